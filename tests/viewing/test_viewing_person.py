"""A person tries everything that a page offers, with mouse and keyboard, in two browsers."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest
from viewing_browser import Visit
from viewing_firefox import Firefox
from viewing_person import InChromium, InFirefox, Person
from viewing_scenes import write_page

from mecanique.motion import simulate
from mecanique.textbook import load
from mecanique.viewing.show import scene

pytestmark = pytest.mark.slow  # every control of a page, one after another

TABS = ("equations", "plots", "parameters", "forces", "ledger", "verdict", "urdf")
STATE = "mecanique.setup.bench.setting.start"
STILL = """await (async () => {
    const eye = () => String(mecanique.camera.eye().toArray());
    const before = eye();
    await new Promise((done) => setTimeout(done, 200));
    return eye() === before;
})()"""
"""Whether the camera has come to rest."""
EYE = "mecanique.camera.eye().toArray()"
LIST = """[...document.querySelectorAll('button, select, input, summary')].filter((control) =>
    control.checkVisibility() && !control.disabled && control.role !== 'tab')"""
"""What a person sees that can be used."""
LEFT = """(() => [...document.querySelectorAll('button, select, input, summary')]
    .filter((control) => !used.has(control) && !control.disabled)
    .map((control) => control.id || control.outerHTML.slice(0, 90)))()"""
MIDDLE = """(() => {
    const { picture, stage } = mecanique;
    const c = mecanique.traces.items[0].column;
    const [tip, hinge] = [c, 14].map((j) => stage.project(picture.row.subarray(j, j + 3)));
    const { left, top } = stage.pane.getBoundingClientRect();
    return [left + (tip[0] + hinge[0]) / 2, top + (tip[1] + hinge[1]) / 2];
})()"""
"""The middle of the last rod in the window [px]."""


def by(identity: str) -> str:
    return f"document.getElementById('{identity}')"


@pytest.fixture(scope="module")
def page(tmp_path_factory: pytest.TempPathFactory) -> Path:
    motion = simulate(load("double_pendulum"), q={"q1": 2.0, "q2": 1.5}, duration=2.0)
    return write_page(scene(motion), tmp_path_factory.mktemp("page") / "page.html")


@pytest.fixture(params=["chromium", "firefox"])
def person(request: pytest.FixtureRequest, page: Path) -> Iterator[Person]:
    if request.param == "chromium":
        visit: Callable[..., Visit] = request.getfixturevalue("visit")
        seen = visit(page.as_uri(), offline=True, viewport={"width": 1280, "height": 800})
        yield Person(InChromium(seen))
        seen.clean()
        return
    fox: Firefox = request.getfixturevalue("fox")
    fox.resize(1280, 800)
    fox.open(page.as_uri())
    yield Person(InFirefox(fox))
    fox.resize(920, 560)
    assert fox.requests() == []
    assert fox.complaints() == []


def test_a_person_finds_their_way(person: Person) -> None:
    """What a student does in the first minutes, and what is seen of it."""
    person.click(by("play"))
    person.wait("mecanique.clock.time > 0.05")
    person.click(by("play"))
    assert person.js("mecanique.clock.playing") is False
    person.click(by("slider"), 0.5)
    assert person.js("mecanique.clock.time") == pytest.approx(1.0, abs=0.05)
    person.click(by("reset"))
    assert person.js("mecanique.clock.time") == 0

    before = person.js(EYE)
    person.click("document.querySelector('[data-camera=free]')")
    person.wait(f"{EYE}.some((x, k) => Math.abs(x - {before}[k]) > 0.1)")
    free = person.js(EYE)
    person.drag([60, 650], [120, 600], [180, 620])
    assert person.js(EYE) != free
    person.click("document.querySelector('[data-camera=front]')")
    person.wait(STILL)

    start = person.js(STATE)
    person.wait(f"{MIDDLE}.every(Number.isFinite)")
    place = person.js(MIDDLE)
    person.drag(place, [place[0] + 20, place[1] - 15], [place[0] + 40, place[1] - 30])
    placed = person.js(STATE)
    assert abs(placed[1] - start[1]) > 0.05
    person.click(by("tab-parameters"))
    person.click(by("setup-undo"))
    assert person.js(STATE) == pytest.approx(start, abs=1e-12)


def test_a_number_that_gives_no_motion_is_refused_where_it_stands(person: Person) -> None:
    person.click(by("tab-parameters"))
    field = "document.querySelector('input[type=number][data-name=l2]')"
    person.write(field, "0")
    told = person.js("[...document.querySelectorAll('td.wrong')].map((e) => e.textContent)")
    assert [text.partition(",")[0] for text in told] == ["The motion q2' moves no mass"]
    box = "document.querySelector('td.wrong').getBoundingClientRect()"
    top, bottom = person.js(f"[{box}.top, {box}.bottom]")
    assert 0 < top < bottom < 800
    person.write(field, "0.5")
    assert person.js("document.querySelector('td.wrong')") is None


def test_two_starts_are_seen_side_by_side_and_in_the_phase_portrait(person: Person) -> None:
    person.click(by("tab-parameters"))
    for name, difference in (("q1", "0.5"), ("q2", "-1")):
        person.choose(by("beside-name"), name)
        person.write(by("beside-by"), difference)
        person.click(by("beside-on"))
    assert person.js("mecanique.setup.bench.neighbor") == {"q1": 0.5, "q2": -1}
    assert "apart" in person.js(f"{by('beside-told')}.textContent")
    person.click(by("tab-plots"))
    person.click(by("portrait"))
    person.click(by("fold"))
    assert person.js("document.querySelectorAll('#charts .ring').length") == 1
    person.click(by("tab-parameters"))
    person.click(by("beside-off"))
    assert person.js("mecanique.setup.bench.neighbor") is None


def test_every_position_of_rest_is_offered_with_its_stability(person: Person) -> None:
    """Two rods hang, stand, or do one of both: only hanging is stable."""
    person.click(by("tab-parameters"))
    person.click(by("modes-find"))
    person.wait(f"{by('modes-find')}.textContent === 'Find rest and modes'")
    rests = person.js("[...document.querySelectorAll('#rests button')].map((e) => e.textContent)")
    assert len(rests) == 4
    assert [re.search(r": (\w+)$", rest)[1] for rest in rests].count("stable") == 1  # type: ignore[index]
    for k in range(4):
        person.click(f"document.querySelectorAll('#rests button')[{k}]")
        at = person.js(f"{by('modes-told')}.textContent")
        assert at.startswith(f"At rest where {rests[k]}.")


def test_everything_that_can_be_used_is_used(person: Person) -> None:
    """Each control does something, complains of nothing, and is within reach of the mouse."""
    person.click(by("tab-parameters"))
    person.click(by("modes-find"))
    for tab in TABS:
        person.click(by(f"tab-{tab}"))
        for _ in range(3):  # what is used may show more
            for control in _unused(person, "document"):
                _use(person, control)
        wide = person.js(
            f"(({{ scrollWidth, clientWidth }}) => scrollWidth - clientWidth)({by('panel-' + tab)})"
        )
        assert wide <= 0, tab
    person.click(by("tab-plots"))
    person.choose(
        by("plot-x"), person.js("String(mecanique.plots.list.find((q) => q.unit === 'rad').id)")
    )
    person.click(by("fold"))  # an angle's turns are folded, those of others are not
    left = person.js(LEFT)
    assert left == []
    person.js("mecanique.clock.seek(0)")
    assert person.js("[...mecanique.picture.row].filter(Number.isNaN).length") == 0


def _unused(person: Person, part: str) -> list[str]:
    """The controls in sight within a part of the page that were not used yet, marked."""
    count = person.js(
        f"""{LIST}.filter((control) => {part}.contains(control) && !used.has(control))
        .map((control) => control.dataset.trial ??= (window.marks = (window.marks ?? 0) + 1))"""
    )
    return [f"document.querySelector('[data-trial=\"{k}\"]')" for k in count]


def _use(person: Person, control: str) -> None:
    ready = f"{control}?.checkVisibility() && !{control}.disabled && !used.has({control})"
    if not person.js(ready):
        return
    kind, tag = person.js(f"[{control}.type ?? '', {control}.localName]")
    if tag == "select":
        for value in person.js(f"[...{control}.options].map((option) => option.value)"):
            person.choose(control, value)
        person.choose(control, person.js(f"{control}.options[0].value"))
    elif kind == "number":
        person.write(control, person.js(f"String(+(1.01 * {control}.value).toPrecision(6))"))
    elif kind == "range":
        person.click(control, 0.3)
    elif kind == "checkbox":
        person.click(control)
        person.click(control)
    else:
        person.click(control)
    if tag == "summary":  # a menu closes once something outside of it is used
        if not person.js(f"{control}.parentElement.open"):
            person.click(control)
        for inner in _unused(person, f"{control}.parentElement"):
            _use(person, inner)
        if person.js(f"{control}.parentElement.matches('.menu')"):
            person.click(control)
