"""The page without mouse and without eyes: axe-core, the keyboard, what is said aloud."""

from __future__ import annotations

import os
from collections.abc import Callable
from pathlib import Path

import pytest
from viewing_browser import Visit

import mecanique as mq
from mecanique.textbook import load
from mecanique.viewing.scene.scene import Scene
from mecanique.viewing.show import scene as scene_with_texts

AXE = Path(__file__).parents[2] / "node_modules" / "axe-core" / "axe.min.js"

TABS = ("equations", "plots", "parameters", "forces", "ledger", "verdict", "urdf")

GRAVE = """async () => (await axe.run()).violations
    .filter(({ impact }) => impact === "serious" || impact === "critical")
    .map(({ id, nodes }) => `${id}: ${nodes[0].html}`)"""


@pytest.fixture(scope="module")
def pendulum() -> Scene:
    motion = mq.simulate(load("double_pendulum"), q=[2.0, 1.5], duration=1.0, fps=30)
    return scene_with_texts(motion)


@pytest.mark.slow
@pytest.mark.parametrize("scheme", ["light", "dark"])
def test_axe_finds_nothing_serious(
    pendulum: Scene, show: Callable[..., Visit], scheme: str
) -> None:
    if not AXE.is_file():
        reason = "no axe-core found; run npm install"
        if "node" in os.environ.get("MECANIQUE_REQUIRE_BROWSERS", "").split():
            pytest.fail(reason)
        pytest.skip(reason)
    seen = show(pendulum, color_scheme=scheme)
    seen.js(AXE.read_text(encoding="utf-8"))
    for tab in TABS:
        seen.page.click(f"#tab-{tab}")
        assert seen.js(GRAVE) == [], tab


def test_the_keyboard_alone_sets_a_parameter(pendulum: Scene, show: Callable[..., Visit]) -> None:
    seen = show(pendulum)
    keys = seen.page.keyboard
    seen.page.focus("#tab-equations")
    for key in ("ArrowRight", "ArrowRight"):
        keys.press(key)
    assert seen.js("document.activeElement.id") == "tab-parameters"
    for _ in range(20):
        keys.press("Tab")
        if seen.js("document.activeElement.type") == "range":
            break
    before = seen.js("mecanique.setup.bench.setting.p[0]")
    keys.press("ArrowRight")
    assert seen.js("mecanique.setup.bench.setting.p[0]") > before
    spoken = seen.js("document.activeElement.getAttribute('aria-valuetext')")
    assert spoken.endswith(" kg")
    assert "steps" in seen.js("document.querySelector('#setup-status').textContent")
    keys.press("Control+z")
    assert seen.js("mecanique.setup.bench.setting.p[0]") == before
    seen.clean()


def test_the_focus_goes_from_the_picture_over_the_clock_to_the_panel(
    pendulum: Scene, show: Callable[..., Visit]
) -> None:
    """As docs/tutorials/pages_for_a_class.md says."""
    seen = show(pendulum, viewport={"width": 1280, "height": 700})
    order = []
    for _ in range(21):
        seen.page.keyboard.press("Tab")
        order.append(seen.js("document.activeElement.id"))
    named = [name for name in order if name]
    picture = ["follow", "free-body", "drag", "arrow-scale", "arrow-mode"]
    clock = ["reset", "play", "slider", "speed", "loop"]
    assert named == [*picture, *clock, "splitter", "tab-equations", "panel-equations"]
    seen.page.keyboard.press("Shift+Tab")
    seen.page.keyboard.press("ArrowRight")
    assert seen.js("document.activeElement.id") == "tab-plots"
    seen.page.keyboard.press("3")
    assert seen.page.get_attribute("[data-camera=top]", "aria-pressed") == "true"
    seen.clean()


def test_studies_are_reached_and_said(pendulum: Scene, show: Callable[..., Visit]) -> None:
    seen = show(pendulum, viewport={"width": 1280, "height": 700})
    seen.page.click("#tab-parameters")
    seen.page.click("#modes-find")
    seen.page.wait_for_selector("[aria-label='Show mode 2']")
    assert "2 natural modes" in seen.page.inner_text("#modes-told")
    seen.page.click("[aria-label='Show mode 2']")
    assert seen.js("mecanique.clock.last") == pytest.approx(4 * 0.874, abs=0.01)
    assert "drawn large and 5 times slower: its period is 0.874 s" in seen.page.inner_text(
        "#modes-told"
    )
    assert seen.page.input_value("#speed") == "0.2"
    seen.page.click("#beside-on")
    assert "apart" in seen.page.inner_text("#beside-told")
    assert seen.js("mecanique.picture.ghost.shown")
    assert seen.page.input_value("#speed") == "1", "another motion has its own speed"
    seen.clean()


def test_rests_found_within_a_slice_of_the_search_are_offered(
    pendulum: Scene, show: Callable[..., Visit]
) -> None:
    seen = show(pendulum, viewport={"width": 1280, "height": 700})
    seen.page.click("#tab-parameters")
    seen.js("performance.now = () => 0")  # so that the search ends in its first slice
    seen.page.click("#modes-find")
    assert "2 natural modes" in seen.page.inner_text("#modes-told")
    assert seen.page.locator("#rests button").count() == 4
    seen.clean()


def test_a_menu_closes_by_escape_and_by_what_is_pressed_outside(
    pendulum: Scene, show: Callable[..., Visit]
) -> None:
    seen = show(pendulum)
    menu = "document.querySelector('#tools details.menu')"
    seen.page.focus("#tools summary")
    seen.page.keyboard.press("Enter")
    seen.page.keyboard.press("Tab")
    assert seen.js(f"{menu}.open && {menu}.contains(document.activeElement)")
    seen.page.keyboard.press("Escape")
    assert seen.js(f"!{menu}.open && document.activeElement.localName === 'summary'")
    seen.page.keyboard.press("Enter")
    seen.page.click("#tools label:has-text('Grid')")
    assert seen.js(f"{menu}.open")
    seen.page.click("h1")
    assert not seen.js(f"{menu}.open")
    seen.clean()


def test_the_panel_widens_by_keyboard(pendulum: Scene, show: Callable[..., Visit]) -> None:
    seen = show(pendulum, viewport={"width": 1280, "height": 700})
    wide = "document.getElementById('panel').clientWidth"
    before = seen.js(wide)
    seen.page.focus("#splitter")
    for _ in range(5):
        seen.page.keyboard.press("ArrowLeft")
    assert seen.js(wide) > before + 100
    seen.clean()


def test_a_body_dragged_starts_from_rest_where_it_is_let_go(
    pendulum: Scene, show: Callable[..., Visit]
) -> None:
    seen = show(pendulum, viewport={"width": 1000, "height": 700})
    seen.seek(0)
    x, y = seen.js(
        """() => {
            const { picture, stage } = mecanique;
            const c = mecanique.traces.items[0].column;
            const [tip, hinge] = [c, 14].map((j) => picture.row.subarray(j, j + 3));
            const box = stage.pane.getBoundingClientRect();
            const [a, b] = stage.project(tip.map((p, i) => 0.7 * p + 0.3 * hinge[i]));
            return [box.left + a, box.top + b];
        }"""
    )
    seen.page.mouse.move(x, y)
    seen.page.mouse.down()
    seen.page.mouse.move(x - 30, y + 60, steps=3)
    seen.page.mouse.up()
    start = seen.js("mecanique.setup.bench.setting.start")
    assert start[2:] == [0, 0]
    assert abs(start[0] - 2.0) + abs(start[1] - 1.5) > 0.05
    assert seen.js("mecanique.clock.playing")
    seen.page.click("#tab-parameters")
    seen.page.click("#setup-undo")
    assert seen.js("mecanique.setup.bench.setting.start") == [2.0, 1.5, 0, 0]
    seen.clean()


def test_what_is_copied_is_latex(pendulum: Scene, show: Callable[..., Visit]) -> None:
    seen = show(pendulum)
    found = seen.js("document.querySelector('[data-copy]').dataset.copy")
    assert found.startswith("\\begin{aligned}")
    seen.page.click("[data-copy]")
    assert seen.js("document.querySelector('[data-copy]').textContent") == "Copied"
    seen.clean()


def test_long_equations_are_broken_where_the_panel_ends_and_copied_whole(
    pendulum: Scene, show: Callable[..., Visit]
) -> None:
    seen = show(pendulum)
    equation = "document.querySelector('.equation.result')"
    broken = f"{equation}.querySelectorAll('mtable.broken mtr').length"
    whole = "math.querySelector('mtable') === null && math.querySelectorAll('mo').length"
    seen.js("document.getElementById('splitter').parentElement.style.setProperty('--panel', '34%')")
    seen.settle()
    assert seen.js(f"{broken} > 1 && {equation}.scrollWidth <= {equation}.clientWidth")
    seen.js("document.addEventListener('copy', () => window.copied = document.activeElement.value)")
    seen.page.click("[data-copy-mathml]")
    assert "mtable" not in seen.js("window.copied")
    assert seen.js("window.copied").count("<math") == 2
    seen.js("document.getElementById('splitter').parentElement.style.setProperty('--panel', '80%')")
    seen.settle()
    assert seen.js(f"{broken} === 0")
    assert seen.js(f"(math => {whole})({equation}.querySelector('math'))") > 4
    seen.clean()


def test_a_factor_wider_than_the_panel_is_broken_between_its_terms(
    pendulum: Scene, show: Callable[..., Visit]
) -> None:
    """And matrices within keep their columns: only lines of the equation are indented."""
    cell = "<mtd><mi>a</mi></mtd>"
    term = f"<mrow><mi>{'m' * 16}</mi></mrow>"
    matrix = f"<mtable><mtr>{cell}{cell}</mtr><mtr>{cell}{cell}</mtr></mtable>"
    factor = f"<mrow><mo>(</mo><mrow>{'<mo>+</mo>'.join([term] * 4)}</mrow><mo>)</mo></mrow>"
    math = f"<math><mrow>{matrix}<mo>+</mo><mrow>{factor}<mi>x</mi></mrow></mrow></math>"
    seen = show(pendulum, viewport={"width": 390, "height": 844})
    seen.js(
        """math => document.getElementById('panel-equations').insertAdjacentHTML(
            'beforeend', `<div class="equation" id="wide">${math}</div>`)""",
        math,
    )
    seen.settle()
    wide = "document.getElementById('wide')"
    lines = seen.js(f"[...{wide}.querySelectorAll('mtable.broken > mtr')].map(e => e.textContent)")
    assert lines == [f"aaaa+({'m' * 16}", *[f"+{'m' * 16}"] * 2, f"+{'m' * 16})x"]
    assert seen.js(f"{wide}.scrollWidth <= {wide}.clientWidth")
    assert seen.js(
        f"[...{wide}.querySelectorAll('mtable:not(.broken) mtr > :first-child')].map(e =>"
        " e.getBoundingClientRect().width).reduce((a, b) => Math.abs(a - b))"
    ) == pytest.approx(0, abs=0.01)
    seen.clean()


def test_a_derivation_unfolds_step_by_step(pendulum: Scene, show: Callable[..., Visit]) -> None:
    seen = show(pendulum)
    seen.page.click(".derivation summary")
    hidden = "document.querySelectorAll('.derivation[open] .step[hidden]').length"
    assert seen.js(hidden) == 0
    seen.page.click(".derivation[open] [data-steps]")
    left = seen.js(hidden)
    assert left > 2
    seen.page.click(".derivation[open] [data-steps]")
    assert seen.js(hidden) == left - 1
    seen.clean()


def test_one_quantity_is_plotted_over_another(pendulum: Scene, show: Callable[..., Visit]) -> None:
    seen = show(pendulum)
    seen.page.click("#tab-plots")
    seen.page.select_option("#plot-x", label="q1 [rad]")
    assert seen.js("document.querySelector('figure svg').getAttribute('aria-label')") == (
        "q1, q2 over q1"
    )
    with seen.page.expect_download() as started:
        seen.page.click("#svg")
    text = started.value.path().read_text(encoding="utf-8")
    assert text.startswith("<svg")
    assert text.count("<polyline") == 2
    seen.clean()


def test_a_slide_shows_picture_and_controls_alone(
    pendulum: Scene, visit: Callable[..., Visit], tmp_path: Path
) -> None:
    from mecanique.viewing.page.page import page

    (tmp_path / "page.html").write_text(page(pendulum), encoding="utf-8")
    (tmp_path / "around.html").write_text(
        "<body class=ready><iframe src='page.html#embed' width=640 height=400></iframe><script>"
        "addEventListener('message', ({ data }) => (window.told = data));</script>",
        encoding="utf-8",
    )
    seen = visit((tmp_path / "around.html").as_uri(), offline=True)
    inner = seen.page.frame_locator("iframe")
    inner.locator("body.ready.embed").wait_for()
    seen.page.wait_for_function("window.told")
    assert seen.js("told") == {"source": "mecanique", "height": round(640 * 0.62)}
    assert not inner.locator("#panel").is_visible()
    assert inner.locator("#play").is_visible()
