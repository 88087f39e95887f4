"""A live view keeps what moves in the picture, until a hand moves the picture aside."""

from __future__ import annotations

from collections.abc import Callable, Iterator

import numpy as np
import pytest
from viewing_browser import Visit, until
from viewing_scenes import raised

from mecanique.viewing.live.live import LiveView
from mecanique.viewing.scene.scene import Scene, SceneBody, SceneFrame, SceneShape, Trace

Path = Callable[[float], tuple[float, float, float]]


def brick(path: Path, duration: float = 0.5, planar: bool = False) -> Scene:
    """A brick over a base that stands still, with the first half second of its way."""
    t = np.linspace(0, duration, round(60 * duration) + 1)
    positions = np.zeros((len(t), 2, 3))
    positions[:, 1] = [path(s) for s in t]
    quaternions = np.zeros((len(t), 2, 4))
    quaternions[..., 3] = 1
    return Scene(
        title="Brick",
        t=t,
        bodies=(
            SceneBody("base", (SceneShape("box", (0.5, 0.5, 0.05), raised(z=-0.3)),)),
            SceneBody("brick", (SceneShape("box", (0.4, 0.3, 0.2)),)),
        ),
        positions=positions,
        quaternions=quaternions,
        traces=(Trace("brick", positions[:, 1]),),
        planar=planar,
    )


def at(path: Path, t: float) -> SceneFrame:
    return SceneFrame(t, brick(lambda _: path(t), 0.0).frame(0).row)


def frames(path: Path, start: float, end: float) -> Iterator[SceneFrame]:
    return (at(path, k / 60) for k in range(round(60 * start), round(60 * end) + 1))


def falling(t: float) -> tuple[float, float, float]:
    return 0.1 * t, 0.0, -9.81 * t**2 / 2


def run(
    view: LiveView, seen: Visit, path: Path, start: float, end: float, speed: float = 1.0
) -> None:
    """Let time pass, till the page has shown the end and its camera is at rest."""
    view.stream(frames(path, start, end), speed=speed)
    until(lambda: bool(seen.js("mecanique.clock.time") == pytest.approx(end, rel=1e-6)))
    seen.settle(8)


def seen_at(seen: Visit) -> tuple[float, float]:
    """Where the brick is in the pane, from 0 to 1 to the right and down."""
    x, y = seen.js(
        """() => { const { stage, row } = mecanique; const pane = stage.pane.parentElement;
        const [x, y] = stage.project(row.subarray(7, 10));
        return [x / pane.clientWidth, y / pane.clientHeight]; }"""
    )
    return float(x), float(y)


def in_the_picture(seen: Visit) -> bool:
    return all(0.1 < c < 0.9 for c in seen_at(seen))


def drag(seen: Visit, button: str) -> None:
    box = seen.page.locator("#pane").bounding_box()
    assert box is not None
    x, y = box["x"] + box["width"] / 2, box["y"] + box["height"] / 2
    seen.page.mouse.move(x, y)
    seen.page.mouse.down(button="right" if button == "right" else "left")
    seen.page.mouse.move(x + 60, y + 30, steps=4)
    seen.page.mouse.up(button="right" if button == "right" else "left")
    seen.settle()


def test_what_falls_stays_in_the_picture_and_a_restart_goes_back(
    visit: Callable[..., Visit],
) -> None:
    with LiveView(brick(falling)) as view:
        seen = visit(view.url)
        assert seen.page.input_value("#follow") == "all"
        home = seen.js("mecanique.camera.center().toArray()")
        ground = "mecanique.stage.ground.children[0].visible"
        assert seen.js(ground)
        run(view, seen, falling, 0.0, 3.0)
        assert falling(3.0)[2] < -44
        assert in_the_picture(seen)
        assert seen.js("[mecanique.companion.afloat, mecanique.companion.wall.visible]") == [
            True,
            True,
        ]
        assert not seen.js(ground)
        # from far away it is found at once
        run(view, seen, falling, 30.0, 30.2)
        assert in_the_picture(seen)
        run(view, seen, falling, 0.0, 0.1)
        assert seen.js("mecanique.camera.center().toArray()") == pytest.approx(home, abs=0.3)
        assert seen.js(ground)
        assert in_the_picture(seen)
        assert seen.errors == []


def test_a_page_opened_late_looks_where_the_motion_is(visit: Callable[..., Visit]) -> None:
    with LiveView(brick(falling)) as view:
        view.send(at(falling, 9.0))
        seen = visit(view.url)
        until(lambda: bool(seen.js("mecanique.clock.time") == 9.0))
        seen.settle()
        assert in_the_picture(seen)


def test_turning_goes_along_and_moving_the_picture_aside_stops_it(
    visit: Callable[..., Visit],
) -> None:
    with LiveView(brick(falling)) as view:
        seen = visit(view.url)
        run(view, seen, falling, 0.0, 1.5)
        drag(seen, "left")
        assert seen.js("mecanique.camera.preset") is None
        run(view, seen, falling, 1.5, 2.5)
        assert in_the_picture(seen)
        assert seen.page.input_value("#follow") == "all"
        drag(seen, "right")
        assert seen.page.input_value("#follow") == ""
        where = seen.js("mecanique.camera.center().toArray()")
        run(view, seen, falling, 2.5, 3.5)
        assert seen.js("mecanique.camera.center().toArray()") == pytest.approx(where, abs=1e-6)
        assert not in_the_picture(seen)
        seen.page.select_option("#follow", "all")
        run(view, seen, falling, 3.5, 3.8)
        assert in_the_picture(seen)
        # a single body can be followed as ever
        seen.page.select_option("#follow", "1")
        run(view, seen, falling, 3.8, 4.4)
        assert in_the_picture(seen)
        assert seen.errors == []


@pytest.mark.slow
def test_a_motion_that_grows_a_little_widens_the_view(visit: Callable[..., Visit]) -> None:
    def growing(t: float) -> tuple[float, float, float]:
        return min(0.6 + 0.2 * t, 0.95) * np.sin(4 * t), 0.0, 0.0

    with LiveView(brick(growing, 1.0, planar=True)) as view:
        seen = visit(view.url)
        before = seen.js("mecanique.camera.eye().distanceTo(mecanique.camera.center())")
        for t in np.linspace(0.0, 4.0, 17):  # one by one: a busy page would leave most of them out
            run(view, seen, growing, t, t)
        until(lambda: not seen.js("mecanique.companion.glide(0)"))
        assert seen.js("mecanique.companion.riding") is False
        assert (
            1.05 * before
            < seen.js("mecanique.camera.eye().distanceTo(mecanique.camera.center())")
            < 2 * before
        )
        for t in np.linspace(4.0, 6.0, 7):
            run(view, seen, growing, t, t)
            assert in_the_picture(seen)
        assert seen.js("mecanique.companion.riding") is False


@pytest.mark.slow
def test_what_runs_away_and_stops_is_followed_and_then_left_in_peace(
    visit: Callable[..., Visit],
) -> None:
    def running(t: float) -> tuple[float, float, float]:
        return 4.0 * min(t, 2.0), 0.0, 0.01 * np.sin(9 * t)

    with LiveView(brick(running, planar=True)) as view:
        seen = visit(view.url)
        run(view, seen, running, 0.0, 2.0)
        assert in_the_picture(seen)
        assert seen.js("mecanique.companion.riding") is True
        run(view, seen, running, 2.0, 6.0)
        assert seen.js("mecanique.companion.riding") is False
        assert in_the_picture(seen)
        assert not seen.js("mecanique.companion.afloat")
