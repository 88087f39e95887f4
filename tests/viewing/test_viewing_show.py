"""Motions of the catalogue, exported and viewed, in a real browser."""

from __future__ import annotations

import io
import signal
import subprocess
import sys
from collections.abc import Callable, Iterator
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from PIL import Image
from scipy.spatial.transform import Rotation
from uncovered import without_coverage
from viewing_browser import Visit, until
from viewing_scenes import reach

import mecanique as mq
from mecanique.derivation.printing.writers import to_lines
from mecanique.motion.analysis.forces import Actions
from mecanique.viewing.show import scene

Motions = Callable[[str], mq.Motion]


@pytest.fixture(scope="module")
def motions() -> Motions:
    made: dict[str, mq.Motion] = {}

    def of(name: str) -> mq.Motion:
        if name not in made:
            start = mq.textbook.entry(name).start
            made[name] = mq.simulate(mq.textbook.load(name), q=dict(start), duration=2.0)
        return made[name]

    return of


@pytest.fixture
def exported(visit: Callable[..., Visit], motions: Motions, tmp_path: Path) -> Callable[..., Visit]:
    """Export a system's motion and open the page without any network."""

    def open_(name: str, **options: Any) -> Visit:
        path = mq.export(motions(name), tmp_path / "page.html")
        assert path == tmp_path / "page.html"
        return visit(path.as_uri(), offline=True, **options)

    return open_


def picture(seen: Visit) -> np.ndarray[tuple[int, ...], np.dtype[np.int64]]:
    shot = seen.page.locator("#stage").screenshot()
    return np.asarray(Image.open(io.BytesIO(shot)).convert("RGB")).astype(int)


def standing(seen: Visit, k: int) -> tuple[Any, Any]:
    """Where a body is in the browser: position and rotation matrix."""
    found = np.array(seen.body(k))
    return found[:3], Rotation.from_quat(found[3:]).as_matrix()


@pytest.mark.parametrize("name", ["rigid_bar_pendulum", "double_pendulum", "heavy_top"])
def test_a_page_shows_the_motion_at_two_times(
    name: str, exported: Callable[..., Visit], motions: Motions
) -> None:
    motion, seen = motions(name), exported(name, drawn=True)
    pictures = []
    for t in (0.0, 0.6):
        seen.seek(t)
        for k, pose in enumerate(motion.poses(t)):
            position, turned = standing(seen, k)
            assert position == pytest.approx(pose[:3, 3], abs=2e-4)
            assert turned == pytest.approx(pose[:3, :3], abs=2e-4)
        pictures.append(picture(seen))
    turn = motion.poses(0.0)[-1][:3, :3].T @ motion.poses(0.6)[-1][:3, :3]
    assert np.linalg.norm(turn - np.eye(3)) > 0.3
    assert (np.abs(pictures[1] - pictures[0]).max(axis=2) > 40).sum() > 500
    seen.clean()


def test_a_page_tells_the_equations_the_verdict_and_the_ledger(
    exported: Callable[..., Visit],
) -> None:
    seen = exported("rigid_bar_pendulum")
    panel = seen.page.locator("#panel-equations")
    assert panel.locator("math").count() > 4
    assert (
        panel.locator(".result math").last.text_content() == "q¨+32lgsin⁡(q)=0"
        or "sin" in panel.inner_text()
    )
    assert panel.locator("h3").first.inner_text() == "Equations of motion"
    heads = panel.locator("h4").all_text_contents()
    assert heads[-3:] == ["Equations of motion", "Result", "Small motions"]
    assert all(panel.locator("h4 + p.note").nth(k).text_content() for k in range(len(heads)))
    assert seen.page.locator(".badge.good").inner_text() == "✓ agrees"
    seen.page.click("#tab-verdict")
    cells = seen.page.locator("#panel-verdict td").all_inner_texts()
    assert "mass matrix" in cells
    seen.page.click("#tab-ledger")
    assert seen.page.locator("#ledger th math").first.text_content() == "q"
    for t in (0.3, 1.7):
        seen.seek(t)
        rows = seen.page.locator("#ledger tbody tr").all_inner_texts()
        assert [row.split("\t")[0] for row in rows] == [
            "weight of rod",
            "reaction at pin",
            "inertia of rod",
        ]
        weight, reaction, inertia = seen.page.locator("#ledger tbody td.number").all_inner_texts()
        assert reaction == "0"
        assert weight not in ("0", inertia)
        assert weight.lstrip("−") == inertia.lstrip("−")
        assert seen.page.locator("#ledger tfoot td").all_inner_texts() == ["0"]
    seen.clean()


@pytest.mark.parametrize(
    "name", ["double_pendulum", "bars_and_springs", "crane", "heavy_top", "furuta_pendulum"]
)
def test_every_column_of_the_ledger_sums_to_zero(name: str, motions: Motions) -> None:
    ledger = scene(
        motions(name), equations=(), verdict=mq.verify(mq.textbook.load(name), samples=2)
    ).document.ledger
    rows = np.array([row.values for row in ledger.rows])
    assert rows.shape[2] == len(ledger.coordinates) == motions(name).mechanism.nv
    assert np.abs(rows.sum(axis=0)).max() < 1e-9 * np.abs(rows).max()


def test_the_cursor_of_a_plot_is_on_the_clock(
    exported: Callable[..., Visit], motions: Motions
) -> None:
    seen = exported("rigid_bar_pendulum")
    seen.page.click("#tab-plots")
    seen.seek(1.2)
    at, first, last = seen.js(
        """() => {
            const { cursor, sx } = mecanique.plots.charts[0];
            return [+cursor.getAttribute('x1'), sx(0), sx(2)];
        }"""
    )
    assert at == pytest.approx(first + (last - first) * 0.6, abs=0.01)
    reading = str(seen.js("() => document.querySelector('figcaption output').textContent"))
    assert float(reading.removesuffix(" rad").replace("−", "-")) == pytest.approx(
        float(motions("rigid_bar_pendulum")(1.2).q[0]), abs=2e-3
    )
    seen.clean()


def test_arrows_are_the_forces(exported: Callable[..., Visit], motions: Motions) -> None:
    """Origin, direction and length of each straight arrow; what is far larger than usual is cut."""
    motion, seen = motions("bars_and_springs"), exported("bars_and_springs")
    kinds = ["weight", "spring", "damper", "load", "reaction", "inertia"]
    seen.js("kinds => kinds.forEach(kind => mecanique.arrows.kinds.add(kind))", kinds)
    k = 40
    seen.seek(float(motion.t[k]))
    shown = seen.js(
        """() => mecanique.arrows.items.filter(i => !i.bent && i.group.visible).map(i => {
            const V = mecanique.stage.three.Vector3;
            const along = new V(0, 1, 0).applyQuaternion(i.group.quaternion);
            const { name } = mecanique.scene.bodies[i.body];
            return [name, i.group.position.toArray(), along.toArray(), i.length];
        })"""
    )
    acting, (t, q, v, a) = (
        Actions(motion.mechanism, motion.reference),
        (motion.t, motion.q, motion.v, motion.a),
    )
    every = [*acting.applied(t, q, v), *acting.reactions(t, q, v), *acting.inertia(t, q, v, a)]
    forces = [f for f in every if f.body != "ground"]
    most = reach(f.force for f in forces)
    per_newton = 0.28 * seen.js("mecanique.stage.size") / most
    expected = [f for f in forces if np.linalg.norm(f.force[k]) > 1e-5 / per_newton]
    assert len(shown) >= len(expected) > 4
    for force in expected:
        size = np.linalg.norm(force.force[k])
        fits = [
            body == force.body
            and np.allclose(origin, force.origin[k], rtol=0, atol=2e-4)
            and np.allclose(along, force.force[k] / size, rtol=0, atol=2e-3)
            and abs(length - min(size, most) * per_newton) < 2e-4
            for body, origin, along, length in shown
        ]
        assert any(fits), force.name
    seen.clean()


def test_a_notebook_shows_the_page_in_a_frame_of_its_own(
    visit: Callable[..., Visit], motions: Motions, tmp_path: Path
) -> None:
    text = motions("rigid_bar_pendulum")._repr_html_()
    assert text is not None
    assert text.startswith('<iframe sandbox="allow-scripts allow-downloads" ')
    fraction = "<mfrac><msup><mi>l</mi><mn>2</mn></msup><mi>g</mi></mfrac>"
    lines = f'<div style="width: 140px">{to_lines("<mo>+</mo>".join(6 * [fraction]))}</div>'
    (tmp_path / "notebook.html").write_text(
        f"<!DOCTYPE html><html><body>{lines}{text}</body></html>", encoding="utf-8"
    )
    seen = visit((tmp_path / "notebook.html").as_uri(), wait=False, offline=True)
    inner = seen.page.frame_locator("iframe")
    inner.locator("body.ready").wait_for()
    assert inner.locator(".badge.good").inner_text() == "✓ agrees"
    assert inner.locator("canvas").count() > 0
    # a denominator keeps clear of the numerator in the line below
    boxes = seen.js("[...document.querySelectorAll('math')].map((e) => e.getBoundingClientRect())")
    gaps = [
        lower["top"] - upper["bottom"]
        for upper, lower in pairwise(boxes)
        if lower["left"] < upper["left"]
    ]
    assert gaps
    assert min(gaps) > 4
    seen.clean()


@pytest.fixture
def live(tmp_path: Path) -> Iterator[tuple[str, subprocess.Popen[str]]]:
    """A pendulum shown by a program of its own, as a user would: its address and the program."""
    script = tmp_path / "show.py"
    script.write_text(
        "import mecanique as mq\n"
        "mechanism = mq.textbook.load('rigid_bar_pendulum')\n"
        "motion = mq.simulate(mechanism, q={'q': 2.0}, duration=20.0)\n"
        "mq.view(motion, open_browser=False)\n"
        "print('ended')\n",
        encoding="utf-8",
    )
    run = subprocess.Popen(
        [sys.executable, str(script)],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        encoding="utf-8",
        cwd=tmp_path,
        env=without_coverage(),
    )
    try:
        assert run.stdout is not None
        yield run.stdout.readline().strip(), run
    finally:
        run.kill()
        run.communicate()


def assert_swings(seen: Visit, **parameters: float) -> None:
    """Stop a live pendulum and compare where it is seen with where it is computed to be by then."""
    seen.page.click("#play")
    until(lambda: seen.js("mecanique.clock.playing") is False)
    seen.settle()
    # at one go: on a busy machine frames that were under way may still arrive
    t, *turn = seen.js(
        "() => [mecanique.clock.time, ...mecanique.stage.nodes[1].quaternion.toArray()]"
    )
    motion = mq.simulate(
        mq.textbook.load("rigid_bar_pendulum", **parameters), q={"q": 2.0}, duration=t
    )
    shown = Rotation.from_quat(turn).as_matrix()
    assert shown == pytest.approx(motion.poses(t)[1, :3, :3], abs=1e-4)


def lengthen(seen: Visit) -> None:
    """Make the bar of a live pendulum twice as long, and see that the page itself moves it."""
    seen.page.click("#play")
    seen.page.click("#tab-parameters")
    seen.page.click("[data-camera=top]")
    seen.js(
        """() => {
            window.same = true;
            const slider = document.querySelector('input[type=range][data-name=l]');
            slider.value = 2;
            slider.oninput();
        }"""
    )
    until(lambda: bool(seen.js("mecanique.clock.time") > 0.2))
    assert_swings(seen, l=2.0)
    assert seen.page.input_value("input[type=number][data-name=l]") == "2"
    assert seen.page.get_attribute("[data-camera=top]", "aria-pressed") == "true"
    assert seen.js("window.same") is True, "the page was loaded anew"
    assert seen.messages == []
    assert seen.errors == []


def test_a_recorded_motion_viewed_live_moves_on_with_a_changed_parameter(
    live: tuple[str, subprocess.Popen[str]], visit: Callable[..., Visit]
) -> None:
    address, run = live
    seen = visit(address)
    seen.page.click("#play")
    until(lambda: bool(seen.js("mecanique.clock.time") > 0.2))
    assert_swings(seen, l=1.0)
    lengthen(seen)
    interrupt(run)
    seen.page.wait_for_selector("#notice:has-text('this page goes on by itself')")


@pytest.fixture
def moving(
    request: pytest.FixtureRequest, tmp_path: Path
) -> Iterator[tuple[str, subprocess.Popen[str]]]:
    """A mechanism shown by a program of its own while its motion is computed."""
    script = tmp_path / "move.py"
    script.write_text(
        f"import mecanique as mq\nmq.view({request.param}, open_browser=False)\nprint('ended')\n",
        encoding="utf-8",
    )
    run = subprocess.Popen(
        [sys.executable, str(script)],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        encoding="utf-8",
        cwd=tmp_path,
        env=without_coverage(),
    )
    try:
        assert run.stdout is not None
        yield run.stdout.readline().strip(), run
    finally:
        run.kill()
        run.communicate()


def interrupt(run: subprocess.Popen[str]) -> None:
    run.send_signal(signal.SIGINT)
    said, complaint = run.communicate(timeout=60)
    assert said.endswith("ended\n")
    assert complaint == ""
    assert run.returncode == 0


@pytest.mark.parametrize(
    "moving", ["mq.textbook.load('rigid_bar_pendulum'), q={'q': 2.0}, speed=4.0"], indirect=True
)
def test_a_mechanism_viewed_live_goes_on_without_end_in_its_page(
    moving: tuple[str, subprocess.Popen[str]], visit: Callable[..., Visit]
) -> None:
    address, run = moving
    seen = visit(address)
    until(lambda: seen.page.input_value("#speed") == "4")
    assert seen.js("mecanique.scene.engine.duration") == 10
    # equations and verdict arrive while it moves, with the comparison of the page's own program
    seen.page.wait_for_selector(".badge.good")
    assert seen.page.locator("#panel-equations math").count() > 3
    seen.page.click("#tab-verdict")
    seen.page.wait_for_selector("h3:has-text('The program of this page')")
    seen.page.click("#play")
    until(lambda: bool(seen.js("mecanique.clock.time") > 10.2))
    assert seen.js("mecanique.clock.last / 10") in (2, 4, 8)
    assert_swings(seen, l=1.0)
    lengthen(seen)
    # no longer than a minute at a time: then comes what follows
    seen.js("() => { while (mecanique.clock.last < 80) mecanique.clock.goesOn(); }")
    assert seen.js("[mecanique.clock.first, mecanique.clock.last]") == [40, 80]
    seen.js("mecanique.clock.seek(41)")
    seen.page.click("#play")
    until(lambda: bool(seen.js("mecanique.clock.time") > 41.2))
    assert_swings(seen, l=2.0)
    interrupt(run)


@pytest.mark.parametrize(
    "moving",
    [
        "mq.textbook.load('four_bar_linkage'), q=mq.textbook.entry('four_bar_linkage').start,"
        " speed=4.0"
    ],
    indirect=True,
)
def test_a_closed_mechanism_moves_on_while_it_is_shown(
    moving: tuple[str, subprocess.Popen[str]], visit: Callable[..., Visit]
) -> None:
    address, run = moving
    seen = visit(address)
    seen.page.click("#play")
    until(lambda: bool(seen.js("mecanique.clock.time") > 2.7))
    assert seen.messages == []
    assert seen.errors == []
    interrupt(run)


def test_what_cannot_be_shown_is_refused(motions: Motions, tmp_path: Path) -> None:
    motion = motions("rigid_bar_pendulum")
    with pytest.raises(
        mq.InputError, match=r"expected a path in a directory that exists, got .*nowhere"
    ):
        mq.export(motion, tmp_path / "nowhere" / "page.html")
    nothing: Any = "rigid_bar_pendulum"
    with pytest.raises(mq.InputError, match="expected a Motion, as simulate returns it, got str"):
        mq.export(nothing, tmp_path / "page.html")
    with pytest.raises(mq.InputError, match="expected a Motion"):
        mq.view(nothing, open_browser=False)
    for speed in (0.0, -1.0, float("inf"), float("nan")):
        with pytest.raises(mq.InputError, match="expected a speed above 0"):
            mq.view(motion, speed=speed, open_browser=False)
    assert list(tmp_path.iterdir()) == []
