"""Every catalogue entry builds with any sensible values, and its docstring states the problem."""

from __future__ import annotations

import re
from dataclasses import replace
from importlib import import_module
from pathlib import Path

import numpy as np
import pytest

from mecanique.errors import InputError, MechanismError, UnknownNameError
from mecanique.reference import Reference, assemble, degrees_of_freedom
from mecanique.textbook import System, entry, load, names
from mecanique.textbook.facts import Values

UNIT = re.compile(r"1|(kg|m|s|rad|N|J)[²³]?(·(kg|m|s|rad)[²³]?)*(/(kg|m|s|rad)[²³]?)?")
"""Products of SI units, with at most one quotient."""

CHAPTER = {
    "bars_and_springs",
    "bars_and_springs_loop",
    "bars_and_springs_small",
    "dumbbell",
    "free_particle",
    "free_planar_body",
    "free_rigid_body",
    "particle_on_circle",
    "particle_on_circle_x",
    "rigid_bar_pendulum",
    "rotating_plate",
    "two_blocks",
}


ROOT = Path(__file__).parents[2]

EVERYONE = (*names(), *names(corners=True))


def words(text: str) -> set[str]:
    return set(re.findall(r"\w+", text))


def statement(name: str) -> str:
    folder = "corners" if name in names(corners=True) else "systems"
    return import_module(f"mecanique.textbook.{folder}.{name}").__doc__ or ""


def test_every_system_of_the_chapter_is_there() -> None:
    assert {name for name in names() if "chapter" in entry(name).tags} == CHAPTER
    assert all("Fundamentals of Dynamics" in entry(name).source for name in CHAPTER)


@pytest.mark.parametrize("name", EVERYONE)
def test_the_docstring_states_the_problem(name: str) -> None:
    title, *body = statement(name).strip().split("\n")
    assert title.endswith(".")
    assert body[0] == ""
    assert re.search(r"\bgeneralized\s+coordinate|attitude", " ".join(body))
    missing = {p.symbol for p in entry(name).parameters} - words(" ".join(body))
    assert not missing, "parameters that the statement does not name"


@pytest.mark.parametrize("name", EVERYONE)
def test_the_docstring_names_the_generalized_coordinates(name: str) -> None:
    known = words(statement(name))
    coordinates = load(name).coordinates if not entry(name).options else load(name, n=1).coordinates
    assert set(coordinates) <= known | {"theta1"}


@pytest.mark.parametrize("name", EVERYONE)
def test_title_source_parameters_and_tags_are_filled_in(name: str) -> None:
    system = entry(name)
    assert 10 <= len(system.title) <= 70
    assert not system.title.endswith(".")
    assert len(system.source) > 15
    assert system.tags
    assert all(tag == tag.lower() for tag in system.tags)
    assert system.duration > 0
    for parameter in system.parameters:
        assert UNIT.fullmatch(parameter.unit), f"{parameter.symbol} in {parameter.unit}"
        assert parameter.meaning


@pytest.mark.parametrize("name", EVERYONE)
def test_there_are_two_facts_or_more_in_one_line_each(name: str) -> None:
    facts = entry(name).facts
    assert len(facts) >= 2
    assert all(0 < len(fact.statement) <= 220 and "\n" not in fact.statement for fact in facts)
    assert len({fact.statement for fact in facts}) == len(facts)


@pytest.mark.parametrize("name", EVERYONE)
def test_a_urdf_and_a_picture_are_kept(name: str) -> None:
    """That they are up to date is tested where they are written."""
    assert (ROOT / "urdf" / f"{name}.urdf").is_file(), (
        f"run: mecanique urdf {name} -o urdf/{name}.urdf"
    )
    drawn = f"mecanique gallery examples/pictures --pictures --only {name}"
    assert (ROOT / "examples" / "pictures" / f"{name}.svg").is_file(), f"run: {drawn}"


@pytest.mark.parametrize("name", EVERYONE)
def test_the_mechanism_carries_the_name_and_the_parameters_of_its_entry(name: str) -> None:
    mechanism = load(name)
    assert mechanism.name == name
    assert mechanism.parameters == entry(name).parameters


@pytest.mark.parametrize("name", EVERYONE)
def test_every_body_with_mass_is_drawn(name: str) -> None:
    mechanism = load(name)
    heavy = [body for body in mechanism.bodies if mechanism.evaluate(body.mass) > 0]
    assert heavy
    assert all(body.visuals for body in heavy)


@pytest.mark.parametrize("name", names())
def test_the_default_start_sets_it_in_motion(name: str) -> None:
    system, mechanism = entry(name), load(name)
    q, v = assemble(mechanism, system.start), mechanism.velocity(system.start_velocity)
    a = Reference(mechanism).acceleration(q, v, 0.01)
    assert np.isfinite(a).all()
    assert np.linalg.norm(v) > 0.1 or np.linalg.norm(a) * system.duration > 0.1


@pytest.mark.parametrize("name", [name for name in names() if entry(name).options])
@pytest.mark.parametrize("n", [1, 2, 9])
def test_an_option_changes_the_number_of_degrees_of_freedom(name: str, n: int) -> None:
    mechanism = load(name, n=n)
    found = degrees_of_freedom(mechanism, entry(name).start).N
    assert found == (1 if mechanism.loops else n)
    assert mechanism.nq == (2 * n + 1 if mechanism.loops else n)
    # the default start suits every number
    assert len(mechanism.position(entry(name).start)) == mechanism.nq


def test_a_parameter_can_be_changed() -> None:
    assert load("rigid_bar_pendulum", l=2.0).values == {"m": 1.0, "l": 2.0, "g": 9.81}


def test_unknown_names_are_refused_with_the_near_ones() -> None:
    with pytest.raises(
        UnknownNameError, match="unknown system 'duble_pendulum'; did you mean 'double_pendulum'"
    ):
        load("duble_pendulum")
    with pytest.raises(UnknownNameError, match="unknown parameter 'L'; known: m, l, g, n"):
        load("n_link_pendulum", L=2.0)


@pytest.mark.parametrize("n", [0, 2.5, -1])
def test_an_option_must_be_a_whole_number(n: float) -> None:
    with pytest.raises(InputError, match=f"expected a whole number of at least 1 for n, got {n}"):
        load("n_link_pendulum", n=n)


def test_parameters_without_physical_sense_are_refused() -> None:
    with pytest.raises(MechanismError, match="its mass is negative"):
        load("simple_pendulum", m=-1.0)
    with pytest.raises(InputError, match="expected a finite number for parameter l, got nan"):
        load("simple_pendulum", l=float("nan"))


def test_values_are_read_by_attribute_and_by_name() -> None:
    s = Values({"m": 2.0, "q'": 3.0})
    assert (s.m, s["m"], s["q'"]) == (2.0, 2.0, 3.0)
    with pytest.raises(UnknownNameError, match="unknown quantity of a fact 'v'"):
        s["v"]
    with pytest.raises(
        AttributeError, match="a fact asks for 'v', which is no parameter, option, coordinate or t"
    ):
        _ = s.v


def test_a_system_may_be_stated_as_its_mechanism() -> None:
    crane = load("crane")
    stated = System("A crane", "its catalogue entry", replace(crane, about=""), tags=("pendulum",))
    assert stated.parameters == crane.parameters
    assert stated.mechanism(m=2.0).values == {**crane.values, "m": 2.0}
    assert stated.mechanism().about == "A crane\nSource: its catalogue entry."
    told = replace(stated, statement="A crane.\n\nA trolley carries\na load.")
    assert told.mechanism().about == "A trolley carries a load.\nSource: its catalogue entry."
    with pytest.raises(UnknownNameError, match="parameter 'mass'"):
        stated.mechanism(mass=1.0)
