"""The page in Firefox: it opens from a file, shows its motion, and asks for nothing."""

from __future__ import annotations

import io
from dataclasses import asdict, replace
from pathlib import Path

import numpy as np
import pytest
from PIL import Image
from scipy.special import ellipj, ellipk
from viewing_engines import engine_of, write_runner
from viewing_firefox import Firefox
from viewing_scenes import about_y, pendulum, swing, write_page

from mecanique.motion import simulate
from mecanique.textbook import entry, load
from mecanique.urdf import read_urdf
from mecanique.urdf.robots import robot
from mecanique.viewing.live.live import LiveView
from mecanique.viewing.scene.from_motion import scene_of
from mecanique.viewing.scene.scene import Scene
from mecanique.viewing.show import scene as scene_with_texts

pytestmark = pytest.mark.slow  # what Chromium shows, once more in another browser


def opened(fox: Firefox, scene: Scene, folder: Path) -> Firefox:
    path = write_page(scene, folder / "page.html")
    fox.open(path.as_uri())
    return fox


def clean(fox: Firefox) -> None:
    assert fox.requests() == []
    assert fox.complaints() == []


def test_requests_and_complaints_would_be_noticed(fox: Firefox, tmp_path: Path) -> None:
    bad = tmp_path / "bad.html"
    image = "http://127.0.0.1:49999/a.png"
    bad.write_text(
        f"<body class=ready><p id=notice hidden></p><img src='{image}'><script>nothing()</script>",
        encoding="utf-8",
    )
    fox.open(bad.as_uri())
    assert set(fox.requests()) == {image}  # a refused one may be tried again
    assert fox.complaints() == ["ReferenceError: nothing is not defined"]


def test_the_page_moves_a_pendulum_by_the_elliptic_function(fox: Firefox, tmp_path: Path) -> None:
    """Sin(θ/2) = k sn(K + ω t, k) from rest, after the start was set in the page."""
    motion = simulate(load("simple_pendulum"), q=[1.0], duration=1.0, samples=9)
    opened(fox, scene_with_texts(motion), tmp_path)
    fox.js(
        """mecanique.setup.change(
            [["initial", "q", 2], ["duration", "", 10], ["rtol", "", 1e-12]].map(
                ([kind, name, x]) => [kind, name && mecanique.setup.bench.machine.names[0], x]))"""
    )
    values = motion.mechanism.values
    omega, k = np.sqrt(values["g"] / values["l"]), np.sin(1.0)
    sn = ellipj(ellipk(k * k) + omega * 10.0, k * k)[0]
    found = fox.js("mecanique.clock.table.stateAt(10)[0]")
    assert found == pytest.approx(2 * np.arcsin(k * sn), abs=1e-10)
    clean(fox)


def test_its_motions_end_where_simulate_says(fox: Firefox, tmp_path: Path) -> None:
    """The engine is plain JavaScript: another browser's functions differ in the last digit."""
    tasks, ends = [], []
    for name in ("double_pendulum", "slider_crank", "tennis_racket", "rolling_coin", "crane"):
        system = entry(name)
        v = {key.removesuffix("'"): value for key, value in system.start_velocity.items()}
        motion = simulate(
            load(name), q=dict(system.start), v=v, duration=2.0, rtol=1e-13, samples=5
        )
        ends.append([*motion.q[-1], *motion.v[-1]])
        tasks.append({"engine": asdict(engine_of(motion)), "rtol": 1e-12, "times": [2.0]})
    fox.open(write_runner(tasks, tmp_path / "run.html").as_uri())
    for found, end in zip(fox.js("globalThis.found"), ends, strict=True):
        assert not found["stopped"]
        assert found["states"][0][:-1] == pytest.approx(end, rel=1e-9, abs=1e-9)
    clean(fox)


def test_the_bar_is_where_it_was_computed_and_drawn_there(fox: Firefox, tmp_path: Path) -> None:
    opened(fox, replace(pendulum(), arrows=(), traces=(), joints=()), tmp_path)
    fox.js("document.getElementById('labels').style.visibility = 'hidden'")
    for t in (0.0, 0.45, 1.3):
        fox.seek(t)
        theta = swing(np.array([t]), 2.0)[0]
        found = np.array(fox.js("mecanique.stage.nodes[1].quaternion.toArray()"))
        assert np.abs(np.abs(found @ about_y(theta)[0]) - 1) < 1e-7
        middle = [0.5 * float(np.sin(theta[0])), 0.0, -0.5 * float(np.cos(theta[0]))]
        x, y = fox.js(
            f"""(() => {{
            const {{ left, top }} = document.getElementById('stage').getBoundingClientRect();
            const [x, y] = mecanique.stage.project({middle}); return [x + left, y + top]; }})()"""
        )
        shot = np.asarray(Image.open(io.BytesIO(fox.screenshot())).convert("RGB")).astype(int)
        red, green, blue = shot[round(y), round(x)]
        assert blue > green > red
        assert blue - red > 50
    clean(fox)


def test_it_plays_and_stops_by_the_keyboard_and_the_cursor_is_on_the_clock(
    fox: Firefox, tmp_path: Path
) -> None:
    opened(fox, pendulum(), tmp_path)
    fox.press(" ")
    fox.js(
        """(async () => {
        while (mecanique.clock.time < 0.05) await new Promise(done => setTimeout(done, 20)); })()"""
    )
    fox.press(" ")
    assert fox.js("mecanique.clock.playing") is False
    fox.js("document.getElementById('tab-plots').click()")
    for t in (0.3, 2.9):
        fox.seek(t)
        at = fox.js("+document.querySelector('.cursor').getAttribute('x1')")
        left, right = fox.js("[0, 4].map(mecanique.plots.charts[0].sx)")
        assert at == pytest.approx(left + (right - left) * t / 4, abs=0.01)
    clean(fox)


def test_every_tab_shows_its_panel_and_equations_are_set(fox: Firefox, tmp_path: Path) -> None:
    opened(fox, pendulum(), tmp_path)
    heights = fox.js(
        """[...document.querySelectorAll('[role=tab]')].map(tab => { tab.click();
        const panel = document.getElementById(tab.getAttribute('aria-controls'));
        return panel.getBoundingClientRect().height; })"""
    )
    assert len(heights) == 7
    assert min(heights) > 100
    fox.js("document.getElementById('tab-equations').click()")
    fractions = fox.js(
        """[...document.querySelectorAll('mfrac')].map(f => {
        const [over, under] = [...f.children].map(e => e.getBoundingClientRect());
        return under.top - over.bottom; })"""
    )
    assert min(fractions) > -1
    clean(fox)


def test_a_robot_s_meshes_are_unpacked(fox: Firefox, tmp_path: Path) -> None:
    scene = scene_of(simulate(read_urdf(robot("panda")), duration=0.2))
    opened(fox, scene, tmp_path)
    triangles = fox.js(
        """(() => {
        let sum = 0;
        for (const node of mecanique.stage.nodes) node.traverse(({ geometry }) => {
            if (geometry && !geometry.index) sum += geometry.attributes.position.count / 3; });
        return sum; })()"""
    )
    assert triangles > 130_000
    clean(fox)


def test_a_live_view_streams(fox: Firefox) -> None:
    scene = pendulum()
    with LiveView(scene) as view:
        fox.open(view.url)
        fox.js("new Promise(done => setTimeout(done, 300))")
        view.send(scene.frame(60))
        time = fox.js(
            """(async () => {
            while (mecanique.clock.time < 0.9) await new Promise(done => setTimeout(done, 20));
            return mecanique.clock.time; })()"""
        )
        assert time == 1.0
        assert [url.rpartition("/")[2] for url in fox.requests()] == ["", "ws"]
        assert fox.complaints() == []


def test_a_narrow_screen_has_no_sideways_scroll(fox: Firefox, tmp_path: Path) -> None:
    fox.resize(390, 800)
    try:
        opened(fox, pendulum(duration=0.5), tmp_path)
        assert fox.js("document.documentElement.scrollWidth") <= 390
        clean(fox)
    finally:
        fox.resize(920, 560)
