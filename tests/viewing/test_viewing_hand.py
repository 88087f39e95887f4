"""The page under the hand: bodies taken, fields that refuse, phase portraits, a phone's screen."""

from __future__ import annotations

import math
from collections.abc import Callable

import pytest
from viewing_browser import Visit

import mecanique as mq
from mecanique.textbook import load
from mecanique.viewing.scene.scene import Scene
from mecanique.viewing.show import scene

PHONE = {"width": 390, "height": 844}

BESIDE = """(across) => {
    const { picture, stage } = mecanique;
    const c = mecanique.traces.items[0].column;
    const [tip, hinge] = [c, 14].map((j) => picture.row.subarray(j, j + 3));
    const box = stage.pane.getBoundingClientRect();
    const [x, y] = stage.project(tip);
    const [a, b] = stage.project(hinge);
    const long = Math.hypot(x - a, y - b);
    const half = [(x + a) / 2, (y + b) / 2];
    const aside = [(across * (y - b)) / long, (-across * (x - a)) / long];
    return [box.left + half[0] + aside[0], box.top + half[1] + aside[1]];
}"""
"""A place so many pixels beside the middle of the last rod."""


@pytest.fixture(scope="module")
def pendulum() -> Scene:
    return scene(mq.simulate(load("double_pendulum"), q={"q1": 2.0, "q2": 1.5}, duration=1.0))


def extent(seen: Visit, what: str, start: str = "x", size: str = "width") -> tuple[float, float]:
    """Where a part of the page begins and ends, to the right or down [px]."""
    box = seen.page.locator(what).bounding_box()
    assert box is not None, what
    first = float(box[start])  # type: ignore[literal-required]
    return first, first + float(box[size])  # type: ignore[literal-required]


def is_across(ends: tuple[float, float]) -> bool:
    """Whether something lies within a phone's width."""
    return ends[0] >= 0 and ends[1] <= PHONE["width"]


@pytest.mark.parametrize("size", [(860, 600), (860, 700), (1280, 800)])
def test_what_moves_keeps_clear_of_the_bars(
    pendulum: Scene, show: Callable[..., Visit], size: tuple[int, int]
) -> None:
    """Their buttons wrap in a notebook's frame, and once the scale of the arrows is told."""
    seen = show(pendulum, viewport=dict(zip(("width", "height"), size, strict=True)))
    seen.settle(5)
    places = seen.js(
        """() => {
            const { camera, stage } = mecanique;
            const { min, max } = camera.box;
            const corners = [min.x, max.x].flatMap((x) =>
                [min.y, max.y].flatMap((y) => [min.z, max.z].map((z) => stage.project([x, y, z]))));
            return corners.map(([, down]) => stage.pane.getBoundingClientRect().top + down);
        }"""
    )
    assert extent(seen, "#tools", "y", "height")[1] <= min(places)
    assert max(places) <= extent(seen, "#forces", "y", "height")[0]
    seen.clean()


@pytest.mark.parametrize("across", [0.0, 12.0, -12.0])
def test_a_body_is_taken_within_twelve_pixels_and_does_not_jump(
    pendulum: Scene, show: Callable[..., Visit], across: float
) -> None:
    seen = show(pendulum, viewport={"width": 1000, "height": 700})
    seen.seek(0)
    x, y = seen.js(BESIDE, across)
    seen.page.mouse.move(x, y)
    assert seen.js("mecanique.stage.pane.classList.contains('over-body')")
    seen.page.mouse.down()
    seen.page.mouse.move(x + 0.01, y)
    seen.page.mouse.up()
    start = seen.js("mecanique.setup.bench.setting.start")
    assert start == pytest.approx([2.0, 1.5, 0, 0], abs=1e-3)
    seen.clean()


def test_a_finger_takes_a_body_that_hangs_at_rest(show: Callable[..., Visit]) -> None:
    hanging = scene(mq.simulate(load("double_pendulum"), duration=1.0))
    seen = show(hanging, viewport=PHONE, has_touch=True, is_mobile=True)
    seen.seek(0.5)
    x, y = seen.js(BESIDE, 0)
    fingers = seen.page.context.new_cdp_session(seen.page)
    for kind, places in (
        ("touchStart", [(x, y)]),
        ("touchMove", [(x + 20, y - 10)]),
        ("touchMove", [(x + 40, y - 20)]),
        ("touchEnd", []),
    ):
        points = [{"x": right, "y": down} for right, down in places]
        fingers.send("Input.dispatchTouchEvent", {"type": kind, "touchPoints": points})
    q1, q2, *rates = seen.js("mecanique.setup.bench.setting.start")
    assert abs(q1) + abs(q2) > 0.2
    assert rates == [0, 0]
    assert seen.js("mecanique.setup.bench.findMoving()") == [False, True, True]  # the ground first
    seen.clean()


def test_the_slider_of_a_linkage_is_taken_and_takes_the_crank_along(
    show: Callable[..., Visit],
) -> None:
    linkage = mq.simulate(load("slider_crank"), q={"theta": 1.0}, duration=1.0)
    seen = show(scene(linkage), viewport={"width": 1000, "height": 700})
    seen.seek(0)
    names = seen.js("mecanique.setup.bench.scene.bodies.map((body) => body.name)")
    assert names[-1] == "slider"
    x, y = seen.js(
        """() => {
        const { stage } = mecanique;
        const [a, b, c] = stage.nodes.at(-1).localToWorld(
            stage.boxes.at(-1).getCenter(new stage.three.Vector3())).toArray();
        const [right, down] = stage.project([a, -c, b]); // the viewer's axes have y up
        const box = stage.pane.getBoundingClientRect();
        return [box.left + right, box.top + down];
    }"""
    )
    before = seen.js("mecanique.setup.bench.setting.start")
    mouse = seen.page.mouse
    mouse.move(x, y)
    mouse.down()
    mouse.move(x - 20, y)
    mouse.move(x - 40, y)
    mouse.up()
    theta, beta, place = seen.js("mecanique.setup.bench.setting.start")[:3]
    assert place < before[2] - 0.02
    r, length = linkage.mechanism.values["r"], linkage.mechanism.values["l"]
    assert r * math.sin(theta) + length * math.sin(theta + beta) == pytest.approx(0, abs=1e-9)
    seen.clean()


def test_the_front_view_of_a_plane_does_not_tip(
    pendulum: Scene, show: Callable[..., Visit]
) -> None:
    seen = show(pendulum, viewport={"width": 1000, "height": 700})
    seen.js("mecanique.clock.pause()")
    eye = "mecanique.camera.eye().toArray()"

    def drag() -> None:
        seen.page.mouse.move(40, 500)
        seen.page.mouse.down()
        seen.page.mouse.move(120, 420, steps=3)
        seen.page.mouse.up()

    before = seen.js(eye)
    drag()
    assert seen.js(eye) == before
    assert seen.js("mecanique.camera.preset") == "front"
    seen.page.click("[data-camera=free]")
    before = seen.js(eye)
    drag()
    assert seen.js(eye) != before
    seen.clean()


def test_a_field_refuses_with_the_reason_beside_it(
    pendulum: Scene, show: Callable[..., Visit]
) -> None:
    seen = show(pendulum, viewport={"width": 1000, "height": 500})
    seen.page.click("#tab-parameters")
    for symbol, value, words in (
        ("l2", "0", "The motion q2' moves no mass, so nothing determines it"),
        ("m1", "-2", "body 'rod1': its mass is negative (-2 kg)"),
        ("g", "", "expected a finite number for parameter g, got ''"),
    ):
        field = f'input[type=number][data-name="{symbol}"]'
        seen.page.fill(field, value)
        reasons = seen.page.locator("td.wrong")
        assert reasons.count() == 1
        assert (reasons.text_content() or "").startswith(words)
        assert seen.page.get_attribute(field, "aria-invalid") == "true"
        top, bottom = extent(seen, "#panel-parameters", "y", "height")
        assert top - 1 <= min(extent(seen, "td.wrong", "y", "height"))
        assert max(extent(seen, "td.wrong", "y", "height")) <= bottom + 1
    seen.page.fill('input[type=number][data-name="g"]', "5")
    assert seen.page.locator("td.wrong, [aria-invalid=true]").count() == 0
    seen.clean()


def test_a_press_shows_a_phase_portrait_of_each_coordinate(
    pendulum: Scene, show: Callable[..., Visit]
) -> None:
    seen = show(pendulum)
    seen.page.click("#tab-plots")
    shown = (
        "() => { const { list, over, chosen } = mecanique.plots;"
        " return [list[over]?.name ?? 'time', ...[...chosen].map((id) => list[id].name)]; }"
    )
    first = seen.js(shown)
    for expected in (["q1", "q1'"], ["q2", "q2'"], first):
        seen.page.click("#portrait")
        assert seen.js(shown) == expected
    seen.clean()


def test_a_phase_portrait_folds_angles_and_shows_both_motions(show: Callable[..., Visit]) -> None:
    """A pendulum that turns over goes on to the right, or through one strip again and again."""
    over = scene(mq.simulate(load("simple_pendulum"), q=[0.0], v=[8.0], duration=5.0))
    seen = show(over)
    seen.js(
        "mecanique.setup.change([['beside', 'q', 0.5], ['beside', \"q'\", -6], ['rtol', '', 1e-9]])"
    )
    seen.page.click("#tab-plots")
    assert not seen.page.is_visible("#fold")  # time is no angle
    seen.page.click("#portrait")
    curves = seen.page.locator("#charts polyline")
    ends = "() => [...document.querySelectorAll('#charts polyline')].map((e) => e.points).map("
    ends += "(p) => [p[0].x, p[p.length - 1].x])"
    assert curves.count() == 2
    turned, swung = seen.js(ends)
    assert turned[1] - turned[0] > 200
    assert abs(swung[1] - swung[0]) < 100
    turns = seen.js("mecanique.clock.table.stateAt(5)[0]") / (2 * math.pi)
    seen.page.check("#fold")
    assert curves.count() == round(turns) + 2  # once more for each turn
    for piece in seen.js(ends)[1:-2]:  # from one side to the other
        assert piece[1] - piece[0] > 0.8 * (seen.js("mecanique.plots.width") - 62)
    label = "q' over q, with the second motion"
    assert seen.page.get_attribute("#charts svg", "aria-label") == label
    seen.page.click("#tab-parameters")
    seen.page.select_option("#beside-name", "q'")
    assert seen.page.input_value("#beside-by") == "-6"
    seen.page.click("#beside-off")
    seen.page.click("#tab-plots")
    assert seen.page.get_attribute("#charts svg", "aria-label") == "q' over q"
    seen.clean()


def test_a_phone_shows_the_picture_and_reaches_every_control(
    pendulum: Scene, show: Callable[..., Visit]
) -> None:
    seen = show(pendulum, viewport=PHONE)
    assert seen.js("document.documentElement.scrollWidth") <= PHONE["width"]
    covered = seen.js(
        "() => ['tools', 'forces'].reduce((sum, id) =>"
        " sum + document.getElementById(id).clientHeight, 0)"
        " / document.getElementById('stage').clientHeight"
    )
    assert covered <= 0.2
    seen.js("() => (document.getElementById('time').textContent = '0.1000 / 0.3000 s')")
    assert extent(seen, "#loop", "y")[0] < max(extent(seen, "#play", "y", "height"))  # one row
    for control in ("#drag", "#free-body", "#arrow-mode", "#loop", "#speed", "#slider"):
        seen.page.locator(control).scroll_into_view_if_needed()
        assert is_across(extent(seen, control)), control
    seen.page.click("#tools summary")
    assert is_across(extent(seen, "#show-menu"))
    seen.page.locator("#show-menu input[type=checkbox]").first.click()
    seen.page.keyboard.press("Escape")
    for tab in ("equations", "plots", "parameters", "forces", "ledger", "verdict"):
        seen.page.click(f"#tab-{tab}")
        wide = f"document.getElementById('panel-{tab}').scrollWidth"
        assert seen.js(wide) <= PHONE["width"], tab
    seen.page.click("#tab-parameters")
    seen.page.wait_for_selector("#panel-parameters .tight")  # in the frame after the panel's
    for k in range(1, 5):
        assert is_across(extent(seen, f"#panel-parameters thead th:nth-child({k}) >> nth=0")), k
    seen.clean()


CUT = """(tab) => [...document.querySelectorAll(`#panel-${tab} :is(th, td)`)].filter((cell) => {
    const { left, right } = cell.getBoundingClientRect();
    const frame = cell.closest("table").parentElement.getBoundingClientRect();
    const over = left < frame.left - 1 || right > frame.right + 1;
    return over || cell.scrollWidth > cell.clientWidth + 1;
}).map((cell) => cell.textContent)"""
"""Cells of a panel's tables that are not shown whole."""


@pytest.mark.parametrize("name", ["shear_building", "four_bar_linkage", "planetary_gear"])
def test_no_column_of_a_wide_table_is_cut(name: str, show: Callable[..., Visit]) -> None:
    """Five coordinates in the ledger, eight forms in the verdict, and two with long names."""
    start = mq.textbook.entry(name).start
    moving = mq.simulate(load(name), q=start, duration=0.5)
    seen = show(scene(moving), viewport=PHONE)
    for width in (1280, 1000, 390):  # the last is that of the next test
        seen.page.set_viewport_size({"width": width, "height": 844})
        for tab in ("parameters", "forces", "ledger", "verdict"):
            seen.page.click(f"#tab-{tab}")
            assert seen.js(f"document.querySelectorAll('#panel-{tab} td').length") > 9
            seen.settle()
            assert seen.js(CUT, tab) == [], (width, tab)
    seen.clean()


@pytest.mark.parametrize("name", ["rocking_block", "acrobot"])
def test_wide_fractions_are_broken_on_a_phone(name: str, show: Callable[..., Visit]) -> None:
    """Of the rocking block also in conditions of modes; of the acrobot 1,400 px wide."""
    entry = mq.textbook.entry(name)
    moving = mq.simulate(load(name), q=entry.start, v=entry.start_velocity, duration=0.1)
    seen = show(scene(moving), viewport=PHONE)
    seen.js("document.querySelectorAll('details').forEach((each) => (each.open = true))")
    seen.until("document.querySelector('mfrac mtable.broken')")
    boxes = "[...document.querySelectorAll('#panel-equations :is(.equation, .note)')]"
    wide = "each.scrollWidth > each.clientWidth"
    seen.settle()
    assert seen.js(f"{boxes}.filter((each) => {wide}).map((each) => each.textContent)") == []
    assert not seen.js("/\\.Source/.test(document.getElementById('panel-equations').textContent)")
    after = "/^[.,;:]/.test(each.nextSibling?.data) && !each.closest('.kept')"
    maths = "[...document.querySelectorAll('#panel-equations math')]"
    assert seen.js(f"{maths}.filter((each) => {after}).length") == 0
    seen.clean()
