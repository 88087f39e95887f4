"""The page in a real browser: it shows the motion it was given, and nothing else happens."""

from __future__ import annotations

import io
import re
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from PIL import Image
from viewing_browser import Visit
from viewing_scenes import GRAVITY, MASS, about_y, blocks, pendulum, reach, swarm, swing, write_page

from mecanique.viewing.page.page import page
from mecanique.viewing.scene.scene import (
    DerivationStep,
    JointMark,
    Knob,
    LedgerRow,
    Plot,
    Scene,
    SceneBody,
    SceneShape,
    SceneText,
    ShownDerivation,
    VerdictTable,
    WorkLedger,
)

Show = Callable[..., Visit]


def picture(seen: Visit) -> np.ndarray[tuple[int, ...], np.dtype[np.uint8]]:
    shot = seen.page.locator("#stage").screenshot()
    return np.asarray(Image.open(io.BytesIO(shot)).convert("RGB"))


def test_the_pendulum_is_seen_at_two_angles_at_two_times(show: Show) -> None:
    seen = show(pendulum(), drawn=True, device_scale_factor=1)
    pictures = []
    for t in (0.0, 0.45):
        seen.seek(t)
        theta, _, _ = swing(np.array([t]), 2.0)
        found = np.array(seen.body(1))
        assert np.abs(found[:3]).max() < 1e-4
        assert np.abs(np.abs(found[3:] @ about_y(theta)[0]) - 1) < 1e-7
        pictures.append(picture(seen).astype(int))
    changed = np.abs(pictures[1] - pictures[0]).max(axis=2) > 40
    assert changed.sum() > 2000
    seen.clean()


def test_the_bar_is_drawn_where_it_is(show: Show) -> None:
    """The bar's blue fills the pixels around its projected middle, at three instants."""
    scene = replace(pendulum(), arrows=(), traces=(), joints=())
    seen = show(scene, drawn=True, device_scale_factor=1)
    for t in (0.2, 0.7, 1.3):
        seen.seek(t)
        theta = swing(np.array([t]), 2.0)[0][0]
        middle = [0.5 * np.sin(theta), 0.0, -0.5 * np.cos(theta)]
        seen.js(
            "() => document.querySelectorAll('.label').forEach(e => (e.style.display = 'none'))"
        )
        x, y = seen.js("p => mecanique.stage.project(p)", middle)
        sketched = seen.js("p => mecanique.sketch.see(p)", middle)
        assert sketched[:2] == pytest.approx([x, y], abs=1)
        red, green, blue = picture(seen)[round(y), round(x)].astype(int)
        assert blue > green > red
        assert blue - red > 50
    seen.clean()


def test_the_motion_plays_by_itself_and_by_the_keyboard(show: Show) -> None:
    seen = show(pendulum(), reduced_motion="no-preference")
    seen.until("mecanique.clock.time > 0.1")
    marks = seen.js("performance.getEntriesByType('mark').map(mark => mark.name)")
    assert marks == ["moving", "drawn"], "a sketch moves before the viewer has a picture"
    assert seen.page.locator("#sketch").count() == 0
    seen.page.keyboard.press("Space")
    stopped = seen.js("mecanique.clock.time")
    seen.page.wait_for_timeout(150)
    assert seen.js("mecanique.clock.time") == stopped
    seen.page.keyboard.press("ArrowRight")
    assert seen.js("mecanique.clock.time") == pytest.approx(stopped + 1 / 60, rel=1e-6)
    seen.page.keyboard.press("Home")
    assert seen.js("mecanique.clock.time") == 0
    seen.page.keyboard.press("2")
    assert seen.page.get_attribute("[data-camera=side]", "aria-pressed") == "true"
    seen.clean()


def test_the_cursor_is_on_the_clock(show: Show) -> None:
    seen = show(pendulum())
    seen.page.click("#tab-plots")
    for t in (0.3, 2.9):
        seen.seek(t)
        at = seen.js("() => +document.querySelector('.cursor').getAttribute('x1')")
        chart = seen.js("() => { const c = mecanique.plots.charts[0]; return [c.sx(0), c.sx(4)]; }")
        assert at == pytest.approx(chart[0] + (chart[1] - chart[0]) * t / 4, abs=0.01)
        reading = seen.js("() => document.querySelector('figcaption output').textContent")
        assert float(reading.removesuffix(" rad").replace("−", "-")) == pytest.approx(
            swing(np.array([t]), 2.0)[0][0], abs=2e-3
        )
    box = seen.page.locator("figure svg").first.bounding_box()
    assert box is not None
    seen.page.mouse.click(box["x"] + box["width"] / 2, box["y"] + 60)
    middle = seen.js(
        """() => {
            const { clock, plots } = mecanique;
            return [plots.charts[0].sx(clock.time), plots.width];
        }"""
    )
    assert middle[0] == pytest.approx(middle[1] / 2, abs=1.5)
    seen.clean()


def falling(depth: float) -> Scene:
    """A ball of 0.4 m that falls so far in 3 s."""
    scene = swarm(1, 3.0)
    path = np.zeros((len(scene.t), 1, 3))
    path[:, 0, 2] = -depth * (scene.t / 3.0) ** 2
    still = np.tile([0.0, 0, 0, 1], (len(scene.t), 1, 1))
    ball = SceneBody("body 0", (SceneShape("sphere", (0.2,)),))
    return replace(scene, bodies=(ball,), positions=path, quaternions=still, arrows=(), traces=())


def test_the_picture_goes_along_with_what_falls_far(show: Show) -> None:
    seen = show(falling(44.0))
    width, height = seen.js("[mecanique.stage.pane.clientWidth, mecanique.stage.pane.clientHeight]")

    def place(t: float) -> tuple[float, float, float]:
        seen.seek(t)
        seen.settle()
        z = -44.0 * (t / 3.0) ** 2
        x, y = seen.js("p => mecanique.stage.project(p)", [0.0, 0.0, z])
        return x, y, y - seen.js("p => mecanique.stage.project(p)", [0.0, 0.0, z + 0.2])[1]

    for t in (0.0, 3.0, 1.2):
        x, y, radius = place(t)
        assert x == pytest.approx(width / 2, abs=5)
        assert radius < y < height - radius
        assert radius > 0.08 * height
    assert seen.js("document.getElementById('follow').value") == "all"
    seen.page.select_option("#follow", "")
    assert place(3.0)[1] > 2 * height
    seen.clean()


def test_what_goes_no_further_is_shown_whole(show: Show) -> None:
    seen = show(falling(3.0))
    assert seen.js("mecanique.companion") is None
    height = seen.js("mecanique.stage.pane.clientHeight")
    for t in (0.0, 3.0):
        seen.seek(t)
        assert (
            0
            < seen.js("p => mecanique.stage.project(p)", [0.0, 0.0, -3.0 * (t / 3.0) ** 2])[1]
            < height
        )
    seen.clean()


def test_what_is_looked_at_stands_between_the_bars(show: Show) -> None:
    """A tall ball's poles are clear of the bars, however low or narrow the picture."""
    scene = falling(0.0)
    scene = replace(scene, arrows=(replace(pendulum(3.0).arrows[0], body="body 0"),))
    for size in (
        {"width": 920, "height": 560},
        {"width": 390, "height": 844},
        {"width": 1400, "height": 900},
    ):
        seen = show(scene, viewport=size)
        seen.settle()
        top, bottom = (
            seen.js("p => mecanique.stage.project(p)", [0.0, 0.0, z])[1] for z in (0.2, -0.2)
        )
        tools, forces, stage = seen.js(
            """() => ["tools", "forces", "stage"].map(id => {
            const box = document.getElementById(id).getBoundingClientRect();
            return [box.top, box.bottom]; })"""
        )
        assert tools[1] - stage[0] < top < bottom < forces[0] - stage[0]
        assert bottom - top > 0.5 * (forces[0] - tools[1])
        seen.clean()


TIPS = """() => mecanique.arrows.items.map(i => {
    const V = mecanique.stage.three.Vector3;
    i.group.updateMatrixWorld(true);
    const back = mecanique.stage.viewer.scene.matrixWorld.clone().invert();
    const cone = new V(0, i.headLength / 2, 0).applyMatrix4(i.head.matrixWorld).applyMatrix4(back);
    return [i.group.position.toArray(), cone.toArray()];
})"""


def test_arrows_have_the_right_place_length_and_direction(show: Show) -> None:
    """On one scale for all that are shown; a peak is cut, keeps its direction, and says so."""
    scene = pendulum()
    weight, pin, *others = scene.arrows
    largest = scene.t[np.linalg.norm(pin.vector, axis=1).argmax()]
    jolt = np.where(np.abs(scene.t - largest) < 0.1, 3.0, 1.0)[:, None]
    scene = replace(scene, arrows=(weight, replace(pin, vector=jolt * pin.vector), *others))
    seen = show(scene)
    seen.js(
        "() => { for (const kind of ['reaction', 'inertia']) mecanique.arrows.kinds.add(kind); }"
    )
    most, size = reach(arrow.vector for arrow in scene.arrows[:3]), seen.js("mecanique.stage.size")
    reaction = np.linalg.norm(scene.arrows[1].vector, axis=1)
    peak = int(reaction.argmax())
    assert reaction[50] < most < 0.9 * reaction[peak]
    for k in (50, peak):
        seen.seek(float(scene.t[k]))
        found = np.array(seen.js(TIPS))
        for arrow, (origin, tip) in zip(scene.arrows[:3], found[:3], strict=True):
            strength = np.linalg.norm(arrow.vector[k])
            assert origin == pytest.approx(arrow.origin[k], abs=2e-4)
            drawn = arrow.vector[k] / strength * min(strength, most) * 0.28 * size / most
            assert tip - origin == pytest.approx(drawn, abs=2e-3)
        assert seen.js("mecanique.arrows.items.map(i => i.cut.visible)") == [
            False,
            k == peak,
            False,
            False,
        ]
        assert (
            "drawn shorter" in seen.js("mecanique.arrows.describe(mecanique.arrows.items[1])")
        ) == (k == peak)
    told = seen.page.locator("#arrow-told").inner_text()
    assert float(re.findall(r"^1 m ≙ ([\d.]+) N · radius 1 m", told)[0]) == pytest.approx(
        most / (0.28 * size), rel=5e-3
    )
    seen.clean()


def test_the_scale_is_that_of_what_is_shown_or_of_each_kind(show: Show) -> None:
    scene = pendulum()
    seen = show(scene)
    size = seen.js("mecanique.stage.size")
    length = "mecanique.arrows.items[0].length"
    seen.settle()
    assert seen.js(length) == pytest.approx(0.28 * size, rel=1e-6)
    seen.page.get_by_label("Reactions").check()
    seen.settle()
    share = MASS * GRAVITY / reach(arrow.vector for arrow in scene.arrows[:2])
    assert seen.js(length) == pytest.approx(0.28 * size * share, rel=1e-3)
    seen.page.select_option("#arrow-mode", "kinds")
    seen.settle()
    assert seen.js(length) == pytest.approx(0.28 * size, rel=1e-6)
    assert re.fullmatch(
        r"Weight: 1 m ≙ \S+ N · Reactions: 1 m ≙ \S+ N",
        seen.page.locator("#arrow-told").inner_text(),
    )
    seen.clean()


def test_a_body_cut_free_shows_its_forces_and_their_sum(show: Show) -> None:
    scene = pendulum()
    seen = show(scene)
    seen.page.select_option("#free-body", "1")
    seen.page.click("#tab-forces")
    seen.seek(1.0)
    assert seen.js("mecanique.stage.nodes.map(n => n.visible)") == [False, True]
    assert seen.js("mecanique.arrows.items.map(i => i.group.visible)") == [True, True, False, False]
    sums = seen.page.locator("#force-sum dd").all_inner_texts()
    assert len(sums) == 4

    def numbers(text: str) -> list[float]:
        return [float(x) for x in re.findall(r"-?\d+\.?\d*", text.replace("−", "-"))]

    assert numbers(sums[0]) == pytest.approx(numbers(sums[1]), rel=2e-3)
    assert numbers(sums[2]) == pytest.approx(numbers(sums[3]), rel=2e-3)
    seen.clean()


def test_a_moment_that_is_only_rounding_is_called_zero(show: Show) -> None:
    """A pull along the rod at its pin, off by rounding, has no moment about the center."""
    scene = pendulum()
    weight, pin, *others = scene.arrows
    along = scene.traces[0].points
    pull = 40.0 * along + 1e-3 * np.array([1.0, 0, 0])
    scene = replace(scene, arrows=(weight, replace(pin, vector=pull), others[0]))
    seen = show(scene)
    seen.page.select_option("#free-body", "1")
    seen.page.click("#tab-forces")
    seen.seek(1.0)
    assert seen.page.locator("#force-sum dd").all_inner_texts()[2] == "(0, 0, 0) N·m"
    seen.clean()


def test_the_ledger_sums_to_zero(show: Show) -> None:
    seen = show(pendulum())
    seen.page.click("#tab-ledger")
    seen.seek(0.8)
    weight, inertia = seen.page.locator("#ledger tbody td.number").all_inner_texts()
    assert weight.lstrip("−") == inertia.lstrip("−")
    assert weight != inertia
    assert seen.page.locator("#ledger tfoot td").inner_text() == "0"
    seen.clean()


def test_springs_reach_from_end_to_end(show: Show) -> None:
    scene = blocks()
    seen = show(scene)
    for k in (0, 70):
        seen.seek(float(scene.t[k]))
        reach = seen.js(
            """() => { const { group, rest } = mecanique.lines.items[2];
            return [...group.position.toArray(), group.scale.y * rest]; }"""
        )
        ends = scene.lines[2].points[k]
        assert reach[:3] == pytest.approx(ends[0], abs=2e-4)
        assert reach[3] == pytest.approx(np.linalg.norm(ends[1] - ends[0]), abs=3e-4)
    seen.clean()


HOSTILE = (
    "</script><script>alert(1)</script>",
    "<img src=x onerror=alert(1)>",
    "constructor",
    "__proto__",
    "../../etc",
    "x" * 3000,
    "שלום\u202eabc",
    "{{parcel}}",
    "\\u003c\"'`${1}&amp;",
)


def test_hostile_names_are_only_names(show: Show) -> None:
    """Every text a page shows, hostile: names of everything there is, and the document's texts."""
    scene, every = swarm(len(HOSTILE), 0.5), " ".join(HOSTILE)
    bodies = tuple(
        replace(body, name=name) for body, name in zip(scene.bodies, HOSTILE, strict=True)
    )
    texts = SceneText(
        subtitle=every,
        derivations=(ShownDerivation(every, (DerivationStep(every, every, every),)),),
        verdict=VerdictTable(False, every, (every,), ((every,),), (every,)),
        parameters=(Knob(every, every, 1.0, every, every, 0.0, 2.0),),
        freedom=(every,),
        ledger=WorkLedger(
            (every,), (every,), (LedgerRow(every, "weight", every, scene.t[:, None]),)
        ),
        urdf=every,
        file_name=every,
    )
    hostile = replace(
        scene,
        title=every,
        bodies=bodies,
        arrows=tuple(replace(scene.arrows[0], name=name, body=name) for name in HOSTILE),
        joints=tuple(JointMark(name, name, name) for name in HOSTILE),
        traces=tuple(replace(scene.traces[0], name=name) for name in HOSTILE),
        series=tuple(Plot(name, name, name, scene.t, name, True) for name in HOSTILE),
        document=texts,
    )
    seen = show(hostile)
    seen.seek(0.25)
    assert seen.page.locator("h1").text_content() == every
    assert seen.page.locator("#urdf-text").text_content() == every
    shown = seen.page.locator(".label.body").all_text_contents()
    assert shown == [name if len(name) < 41 else name[:39] + "…" for name in HOSTILE]
    for b in range(len(HOSTILE)):
        assert seen.body(b)[:3] == pytest.approx(scene.positions[15, b], abs=1e-4)
    seen.page.click("#tab-urdf")
    with seen.page.expect_download() as download:
        seen.page.click("#save-urdf")
    assert re.fullmatch(r"[\w.-]{1,80}\.urdf", download.value.suggested_filename)
    seen.clean()


def test_the_policy_lets_nothing_else_run(show: Show) -> None:
    text = page(pendulum(duration=0.1))
    policy = re.search(r'http-equiv="Content-Security-Policy" content="([^"]+)"', text)
    assert policy is not None
    assert "unsafe" not in policy[1]
    assert "default-src &#x27;none&#x27;" in policy[1]
    assert "connect-src &#x27;none&#x27;" in policy[1]
    seen = show(pendulum(duration=0.1))
    seen.js(
        """() => { const s = document.createElement('script'); s.textContent = 'window.ran = 1';
        document.head.append(s); }"""
    )
    assert seen.js("window.ran") is None
    assert any("Content Security Policy" in message for message in seen.messages)


def test_the_notices_of_what_is_inside_are_in_the_page() -> None:
    text = page(pendulum(duration=0.1))
    for name in ("meshcat", "three", "dat.gui", "msgpack-lite"):
        assert re.search(rf"(?:^|<pre>){re.escape(name)}\b", text, re.MULTILINE), name
    assert text.count("Permission is hereby granted") >= 4


def test_a_minute_of_ten_bodies_fits_into_a_page_of_a_megabyte_and_a_half(tmp_path: Path) -> None:
    path = write_page(swarm(10, 60.0, 60.0), tmp_path / "page.html")
    assert path.stat().st_size < 1_500_000
    assert [each.name for each in tmp_path.iterdir()] == ["page.html"]


def test_every_control_has_a_name_and_a_narrow_screen_has_no_sideways_scroll(show: Show) -> None:
    seen = show(pendulum(), viewport={"width": 390, "height": 800})
    nameless = seen.js(
        """() => [...document.querySelectorAll('button, input, select, summary')].filter(e =>
            !(e.getAttribute('aria-label') || e.textContent.trim() ||
              e.closest('label')?.textContent.trim()))
            .map(e => e.outerHTML)"""
    )
    assert nameless == []
    assert seen.js("document.documentElement.scrollWidth") <= 390
    seen.clean()


def test_quantities_are_saved_as_csv(show: Show) -> None:
    scene = pendulum(duration=1.0)
    seen = show(scene)
    seen.page.click("#tab-plots")
    with seen.page.expect_download() as download:
        seen.page.click("#csv")
    assert download.value.suggested_filename == "rigid_bar_pendulum.csv"
    lines = Path(download.value.path()).read_text(encoding="utf-8").splitlines()
    assert lines[0] == '"t [s]","theta [rad]","theta rate [rad/s]"'
    table = np.array([[float(x) for x in line.split(",")] for line in lines[1:]])
    assert table[:, 0] == pytest.approx(scene.t, abs=1e-6)
    assert table[:, 1] == pytest.approx(scene.series[0].values, abs=3e-6)


DAE = """<?xml version="1.0"?>
<COLLADA xmlns="http://www.collada.org/2005/11/COLLADASchema" version="1.4.1">
<asset>
<unit name="centimeter" meter="0.01"/>
<up_axis>Z_UP</up_axis>
</asset>
<library_images>
<image id="i">
<init_from>http://example.com/wood.png</init_from>
</image>
</library_images>
<library_effects>
<effect id="e">
<profile_COMMON>
<technique sid="c">
<phong>
<diffuse>
<color>1 0.5 0 1</color>
</diffuse>
</phong>
</technique>
</profile_COMMON>
</effect>
</library_effects>
<library_materials>
<material id="m">
<instance_effect url="#e"/>
</material>
</library_materials>
<library_geometries>
<geometry id="g">
<mesh>
<source id="p">
<float_array id="a" count="9">0 0 0 100 0 0 0 0 100</float_array>
<technique_common>
<accessor source="#a" count="3" stride="3">
<param name="X" type="float"/>
<param name="Y" type="float"/>
<param name="Z" type="float"/>
</accessor>
</technique_common>
</source>
<vertices id="v">
<input semantic="POSITION" source="#p"/>
</vertices>
<triangles count="1" material="m">
<input semantic="VERTEX" source="#v" offset="0"/>
<p>0 1 2</p>
</triangles>
</mesh>
</geometry>
</library_geometries>
<library_visual_scenes>
<visual_scene id="s">
<node>
<instance_geometry url="#g">
<bind_material>
<technique_common>
<instance_material symbol="m" target="#m"/>
</technique_common>
</bind_material>
</instance_geometry>
</node>
</visual_scene>
</library_visual_scenes>
<scene>
<instance_visual_scene url="#s"/>
</scene>
</COLLADA>
"""
STL = """solid a
facet normal 0 0 1
outer loop
vertex 0 0 0
vertex 1 0 0
vertex 0 1 0
endloop
endfacet
endsolid a
"""


def test_meshes_of_every_format_are_drawn(show: Show, tmp_path: Path) -> None:
    files = {"a.stl": STL, "b.obj": "v 0 0 0\nv 1 0 0\nv 0 0 1\nf 1 2 3\n", "c.dae": DAE}
    for name, text in files.items():
        (tmp_path / name).write_text(text, encoding="utf-8")
    scene = replace(
        pendulum(duration=0.1),
        bodies=(
            SceneBody("ground", (SceneShape("mesh", (1, 1, 1), path=tmp_path / "a.stl"),)),
            SceneBody(
                "bar",
                (
                    SceneShape("mesh", (2, 2, 2), path=tmp_path / "b.obj"),
                    SceneShape("mesh", (3, 3, 3), path=tmp_path / "c.dae", rgba=None),
                ),
            ),
        ),
    )
    seen = show(scene)
    assert seen.js("mecanique.sketch") is None
    sizes = seen.js("() => mecanique.stage.boxes.map(b => b.max.clone().sub(b.min).toArray())")
    assert sizes[0] == pytest.approx([1, 1, 0], rel=1e-6)
    assert sizes[1] == pytest.approx([3, 0, 3], rel=1e-6)
    color = seen.js(
        """() => mecanique.stage.nodes[1].children
        .filter(p => p.material && p.geometry.attributes.position.count === 3)
        .map(p => p.material.color.toArray())"""
    )
    assert color[0] == pytest.approx([0.55, 0.58, 0.62], abs=0.01)
    assert color[1] == pytest.approx([1, 0.5, 0], abs=0.01)
    seen.clean()
