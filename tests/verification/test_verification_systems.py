"""The derivation agrees with the engine on every system, and every difference is seen."""

from __future__ import annotations

import json
from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from systems import TREES

from mecanique import textbook
from mecanique.derivation.equations import Equations
from mecanique.errors import EngineError, InputError
from mecanique.model import Loop, Mechanism
from mecanique.reference import Reference
from mecanique.reference.engine.package import engine_name
from mecanique.verification import Verdict, verify
from mecanique.verification import compare as sources
from mecanique.verification.compare import derive_all, joint_reactions
from mecanique.verification.facts import Bench
from mecanique.verification.rows import QUANTITIES, Values, evaluate, rows_of
from mecanique.verification.states import random_states, usual_samples
from mecanique.verification.verdict import versions

UNREADABLE = ("whipple_bicycle",)
"""Systems whose equations are too long to be written out, or not in closed form."""
WITHOUT_CONTACTS = tuple(quantity for quantity in QUANTITIES if quantity != "contact forces")


@pytest.mark.parametrize("name", TREES)
def test_every_textbook_system_agrees(name: str) -> None:
    mechanism = textbook.load(name)
    verdict = verify(mechanism, samples=10, seed=1)
    assert verdict.agrees, str(verdict)
    assert verdict.worst < 1e-10, str(verdict)
    expected = QUANTITIES if mechanism.contacts else WITHOUT_CONTACTS
    assert {row.quantity for row in verdict.rows} == set(expected)
    forms = {"Newton-Euler", "jets", "recursion", "virtual work"}
    if name not in UNREADABLE:
        forms.add("closed form")
    assert {row.sources for row in verdict.rows} == {(form, engine_name()) for form in forms}
    assert all(row.remark == "" for row in verdict.rows), str(verdict)


@pytest.fixture(scope="module")
def pendulum() -> Mechanism:
    return textbook.load("cart_pole")


@pytest.fixture(scope="module")
def ours(pendulum: Mechanism) -> Values:
    states = random_states(pendulum, 20, 0)
    forms = derive_all(pendulum).forms
    newton_euler = forms["Newton-Euler"]
    assert isinstance(newton_euler, Equations)
    return {
        **evaluate(forms["recursion"], states),
        "reactions": joint_reactions(newton_euler, pendulum, states),
    }


def compare(pendulum: Mechanism, ours: Values, **changed: Any) -> dict[str, Any]:
    """Rows of a comparison in which some values of one source are changed, by quantity."""
    states = random_states(pendulum, 20, 0)
    rows = rows_of(("ours", "theirs"), {**ours, **changed}, ours, states, pendulum)
    assert [row.quantity for row in rows] == list(WITHOUT_CONTACTS)
    return {row.quantity: row for row in rows}


@pytest.mark.parametrize("quantity", WITHOUT_CONTACTS)
@pytest.mark.parametrize("size", [1e-8, 1e-3, 1.0])
def test_a_change_of_one_number_is_seen_and_placed(
    pendulum: Mechanism, ours: Values, quantity: str, size: float
) -> None:
    changed = ours[quantity].copy()
    changed[7] += size * max(1.0, float(abs(changed[7]).max()))
    rows = compare(pendulum, ours, **{quantity: changed})
    assert [name for name, row in rows.items() if row.worst > 1e-9] == [quantity]
    states = random_states(pendulum, 20, 0)
    assert rows[quantity].q == tuple(states.q[7])
    assert rows[quantity].v == tuple(states.v[7])
    assert rows[quantity].worst > 1e-3 * size


@pytest.mark.parametrize("quantity", WITHOUT_CONTACTS)
@pytest.mark.parametrize("bad", [np.nan, np.inf])
def test_what_is_not_finite_is_named(
    pendulum: Mechanism, ours: Values, quantity: str, bad: float
) -> None:
    changed = ours[quantity].copy()
    changed[[3, 5]] = bad
    row = compare(pendulum, ours, **{quantity: changed})[quantity]
    assert row.worst == np.inf
    assert row.remark == "ours is not finite at 2 of 20 states"


def test_potential_energies_may_differ_by_a_constant_which_is_reported(
    pendulum: Mechanism, ours: Values
) -> None:
    row = compare(pendulum, ours, **{"potential energy": ours["potential energy"] + 12.5})[
        "potential energy"
    ]
    assert row.worst < 1e-12
    assert row.remark == "up to a constant of 12.5 J, which no equation of motion sees"
    row = compare(pendulum, ours, **{"potential energy": ours["potential energy"] * 1.01 + 12.5})[
        "potential energy"
    ]
    assert row.worst > 1e-3
    row = compare(pendulum, ours, **{"kinetic energy": ours["kinetic energy"] + 12.5})[
        "kinetic energy"
    ]
    assert row.worst > 1e-3


@pytest.mark.parametrize(
    ("change", "seen"),
    [
        (
            lambda m: m.replace(g=9.80),
            {"bias", "gravity", "inverse dynamics", "acceleration", "potential energy"},
        ),
        (lambda m: m.replace(c=0.2), {"forces", "inverse dynamics", "acceleration"}),
        (
            lambda m: m.replace(M=2.0001),
            {
                "mass matrix",
                "inverse dynamics",
                "acceleration",
                "kinetic energy",
                "momentum",
                "angular momentum",
            },
        ),
        (lambda m: m.replace(l=-1.0), set(QUANTITIES) - {"forces", "angular momentum"}),
    ],
)
def test_another_mechanism_is_told_apart_by_what_it_changes(
    pendulum: Mechanism, change: Callable[[Mechanism], Mechanism], seen: set[str]
) -> None:
    states = random_states(pendulum, 20, 0)
    theirs = evaluate(Reference(change(pendulum)), states)
    for name, form in derive_all(pendulum).forms.items():
        values = evaluate(form, states)
        rows = rows_of((name, "Pinocchio"), values, theirs, states, pendulum)
        assert {row.quantity for row in rows if row.worst > 1e-9} == seen & set(values)


def test_a_wrong_derivation_gives_a_verdict_that_disagrees(
    pendulum: Mechanism, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(
        sources, "derive_all", lambda mechanism: derive_all(mechanism.replace(l=1.1))
    )
    verdict = verify(pendulum, samples=5)
    assert not verdict.agrees
    assert "DISAGREES" in str(verdict)
    assert json.loads(verdict.to_json())["agrees"] is False


def test_one_seed_gives_one_verdict(pendulum: Mechanism) -> None:
    first, again, other = (verify(pendulum, samples=5, seed=seed) for seed in (3, 3, 4))
    assert isinstance(first, Verdict)
    assert first == again
    assert first.rows != other.rows
    assert (first.samples, first.seed, first.tolerance) == (5, 3, 1e-9)
    assert (first.coordinates, first.velocities) == (("x", "q"), ("x'", "q'"))


def test_the_versions_are_stated(pendulum: Mechanism) -> None:
    found = verify(pendulum, samples=1).versions
    assert found == versions()
    assert set(found) == {"mecanique", "numpy", "pin", "python"}
    assert "unknown" not in found.values()


def test_loops_are_verified_with_multipliers_and_in_independent_coordinates(
    pendulum: Mechanism,
) -> None:
    tied = replace(
        pendulum, loops=(Loop.distance("rope", "ground", (0, 0, -3), "pole", (0, 0, -1), 2.5),)
    )
    verdict = verify(tied, samples=10)
    assert verdict.agrees
    assert verdict.worst < 1e-10, str(verdict)
    bounds = {r.sources[0]: r.rounding for r in verdict.rows if r.quantity == "acceleration"}
    # the block that is inverted enters twice in each of eight steps
    assert bounds["independent coordinates"] >= 8 * min(bounds.values())
    assert {*bounds} == {
        "jets",
        "recursion",
        "Newton-Euler",
        "virtual work",
        "closed form",
        "Newton-Euler, closed form",
        "virtual work, closed form",
        "independent coordinates",
    }
    assert not verify(pendulum, samples=5).notes


@pytest.mark.parametrize(
    ("name", "sizes"),
    [
        ("double_pendulum", {"l1": 3e-6, "l2": 8e-6, "m1": 1e-12, "m2": 2e-12}),
        (
            "four_bar_linkage",
            {"a": 3e-6, "b": 8e-6, "c": 6e-6, "d": 9e-6, "m1": 1e-12, "m2": 2e-12, "m3": 1e-12},
        ),
        ("double_pendulum", {"l1": 3e6, "l2": 8e6, "m1": 1e12, "m2": 2e12}),
    ],
)
def test_micrometers_and_megameters_are_verified_as_exactly(
    name: str, sizes: dict[str, float]
) -> None:
    """Weights of tiny bodies are a million times their inertia: neither may drown in the other."""
    verdict = verify(textbook.load(name, **sizes), samples=20)
    assert verdict.worst < 1e-12, str(verdict)


def test_bad_numbers_are_refused(pendulum: Mechanism) -> None:
    with pytest.raises(
        InputError, match="expected a whole number of at least 1 for samples, got 0"
    ):
        verify(pendulum, samples=0)
    with pytest.raises(InputError, match="expected a whole number of at least 0 for seed, got -3"):
        verify(pendulum, seed=-3)


def test_the_jets_are_asked_for_fewer_states_of_a_large_mechanism_which_is_reported() -> None:
    chain = textbook.load("n_link_pendulum", n=12)
    verdict = verify(chain, samples=30)
    assert verdict.agrees
    assert verdict.notes == (
        "jets: at the first 25 states only, their cost grows with the cube of the size",
    )
    verdict = verify(chain, samples=25)
    assert not verdict.notes
    assert "jets" in sources_of("mass matrix", verdict)


def test_a_closed_form_that_nobody_would_read_is_left_out_which_is_reported() -> None:
    verdict = verify(textbook.load("n_link_pendulum", n=13), samples=3)
    assert verdict.agrees
    assert verdict.notes == ("left out: the closed form, made for at most 12 velocities",)
    assert {row.sources[0] for row in verdict.rows} == {
        "jets",
        "recursion",
        "Newton-Euler",
        "virtual work",
    }
    by_others = {"recursion", "Newton-Euler", "virtual work"}
    assert sources_of("mass matrix", verdict) == by_others
    assert sources_of("bias", verdict) == by_others | {"jets"}


def sources_of(quantity: str, verdict: Verdict) -> set[str]:
    """The forms whose answer for a quantity was compared."""
    return {row.sources[0] for row in verdict.rows if row.quantity == quantity}


@pytest.mark.parametrize(
    "name", ["rigid_bar_pendulum", "two_blocks", "bars_and_springs", "gyroscope", "crane"]
)
def test_every_reaction_is_the_engines(name: str) -> None:
    verdict = verify(textbook.load(name), samples=30, seed=2)
    (row,) = [row for row in verdict.rows if row.quantity == "reactions"]
    assert row.sources == ("Newton-Euler", engine_name())
    assert row.worst < 1e-12


def test_a_long_chain_is_compared_at_fewer_states(monkeypatch: pytest.MonkeyPatch) -> None:
    """By the square of its size."""
    monkeypatch.setattr("mecanique.verification.states._LONG", 3)
    chains = {n: textbook.load("n_link_pendulum", n=n) for n in (2, 3, 6, 15)}
    counts = {n: usual_samples(chain) for n, chain in chains.items()}
    assert counts == {2: 100, 3: 100, 6: 25, 15: 5}


def test_verify_reports_its_progress() -> None:
    told: list[tuple[str, float]] = []
    verdict = verify(
        textbook.load("double_pendulum"), progress=lambda name, done: told.append((name, done))
    )
    assert verdict.samples == 100
    assert [name for name, _ in told][:2] == [engine_name(), "jets"]
    assert [done for _, done in told] == sorted({done for _, done in told})


def test_what_is_too_long_for_the_engine_is_declined_before_anything_is_derived(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    def derive(mechanism: Mechanism) -> None:
        raise AssertionError("derived before the engine was asked")

    monkeypatch.setattr("mecanique.verification.compare.derive_all", derive)
    with pytest.raises(EngineError, match="has 251 joint velocities; Pinocchio is given at most"):
        verify(textbook.load("n_link_pendulum", n=251))


def test_facts_are_held_against_the_equations_that_are_asked_for() -> None:
    """By the engine or derived here, without what switches; both have the same accelerations."""
    system = textbook.entry("stick_slip")
    engine, derived = (Bench(system, {}, source, 2, 0) for source in ("reference", "derive"))
    assert isinstance(engine.dynamics, Reference)
    assert isinstance(derived.dynamics, Equations)
    assert engine.dynamics is engine.reference
    for bench in (engine, derived):
        assert bench.smooth == replace(bench.mechanism, switching=())
        assert bench.dynamics.mechanism == bench.smooth
