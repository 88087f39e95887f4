"""The scales of plots: round numbers, each written once, and rounding noise as a flat line."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest
from viewing_browser import Visit
from viewing_scenes import pendulum

from mecanique.viewing.live.live import LiveView
from mecanique.viewing.scene.scene import Plot, Scene


def plotted(*series: Plot) -> Scene:
    scene = pendulum()
    return replace(scene, arrows=(), series=series)


def along(seen: Visit, axis: str, chart: int = 0) -> list[str]:
    """Return what is written at the ticks of a chart, along x or y."""
    anchor = {"x": "middle", "y": "end"}[axis]
    texts = seen.js(
        """([chart, anchor]) => {
            const figure = document.querySelectorAll('#charts figure')[chart];
            const texts = figure.querySelectorAll(`text[text-anchor=${anchor}]:not(.unit)`);
            return [...texts].map(text => text.textContent);
        }""",
        [chart, anchor],
    )
    return [str(text) for text in texts]


def heights(seen: Visit, chart: int = 0) -> list[float]:
    """Return how high the points of a chart's first curve are drawn."""
    points = seen.js(
        """chart => document.querySelectorAll('#charts figure')[chart]
        .querySelector('polyline').getAttribute('points')""",
        chart,
    )
    return [float(point.split(",")[1]) for point in str(points).split()]


def unit(seen: Visit, chart: int) -> str:
    """Return what is written above a chart's upright axis."""
    texts = seen.js(
        """chart => [...document.querySelectorAll('#charts figure')[chart]
        .querySelectorAll('text.unit')].map(text => text.textContent)""",
        chart,
    )
    return "".join(text for text in texts if text != "t [s]")


def number(text: str) -> float:
    return float(text.replace("−", "-"))


T = pendulum().t


CURVES = (
    (3e-6 * np.sin(T), "×10⁻⁶"),
    (2.5e7 * np.sin(T), "×10⁷"),
    (0.7 * np.sin(T), ""),
    (5.0 + 0.001 * np.sin(T), ""),
    (-40 - 3 * T, ""),
    (1e5 + 20 * np.sin(T), "×10⁵"),
    (8e-31 * np.cos(T), "×10⁻³¹"),
)


def test_ticks_are_round_and_written_once(show: Callable[..., Visit]) -> None:
    series = [Plot(f"x{k}", "x", f"K{k}", x, shown=True) for k, (x, _) in enumerate(CURVES)]
    seen = show(plotted(*series))
    seen.page.click("#tab-plots")
    for k, (_, power) in enumerate(CURVES):
        for axis in "xy":
            texts = along(seen, axis, k)
            assert 2 <= len(texts) <= 12
            assert len(set(texts)) == len(texts)
            steps = np.diff([number(text) for text in texts])
            assert steps == pytest.approx(np.full(len(steps), steps[0]), rel=1e-6)
            first = f"{abs(steps[0]):.3e}"
            assert first[:5] in ("1.000", "2.000", "5.000")
        assert all(len(text) <= 8 for text in along(seen, "y", k))
        assert unit(seen, k) == power
        assert np.ptp(heights(seen, k)) > 40
    seen.clean()


def test_noise_is_a_flat_line(show: Callable[..., Visit]) -> None:
    noise = np.random.default_rng(0).normal(size=len(T))
    constant = Plot("E", "E", "J", 12.345678 + 1e-7 * noise, shown=True)
    seen = show(plotted(constant))
    seen.page.click("#tab-plots")
    assert np.ptp(heights(seen)) < 0.5
    assert len(set(along(seen, "y"))) == len(along(seen, "y")) >= 2
    # beside meters, 1e-14 m is nothing
    drift = Plot("x", "x", "m", -6e-15 * T, shown=True)
    seen = show(plotted(drift, Plot("z", "z", "m", np.cos(T))))
    seen.page.click("#tab-plots")
    assert along(seen, "y") == ["−1.0", "−0.5", "0", "0.5", "1.0"]
    assert np.ptp(heights(seen)) < 0.5
    seen.seek(2.0)
    assert seen.page.inner_text("figcaption output") == "0 m"
    # but an angle of a microradian is an angle, and powers are written as such
    seen = show(plotted(Plot("a", "a", "rad", 2e-6 * np.cos(T), shown=True)))
    seen.page.click("#tab-plots")
    assert np.ptp(heights(seen)) > 40
    seen.seek(0.0)
    assert seen.page.inner_text("figcaption output") == "2.00·10⁻⁶ rad"


def test_a_stream_that_begins_has_room_for_what_comes(visit: Callable[..., Visit]) -> None:
    scene = pendulum()
    with LiveView(scene) as view:
        seen = visit(view.url)
        seen.page.click("#tab-plots")
        seen.settle()
        texts = along(seen, "x")
        assert len(set(texts)) == len(texts) >= 3
        assert number(texts[0]) == 0.0
        assert number(texts[-1]) >= 1.0
