"""Facts of any kind: true ones hold, wrong ones are detected, those without a value do neither."""

from __future__ import annotations

import math
from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

import mecanique as mq
from mecanique.errors import InputError, UnknownNameError
from mecanique.textbook import entry
from mecanique.textbook.facts import (
    Acceleration,
    Conserved,
    Eigenvalues,
    Fact,
    Frequencies,
    KineticEnergy,
    Lasting,
    MassMatrix,
    ModeAcceleration,
    Occurs,
    Period,
    Reaction,
    Solution,
    StabilityLimit,
    Steady,
    Values,
)
from mecanique.verification.facts import (
    FactRow,
    _frequencies,
    _margin,
    _period,
    _reaction,
    check_facts,
)

TRUE: dict[str, Fact] = {
    "Frequencies": Frequencies("", lambda s: [math.sqrt(1.5 * s.g / s.l)]),
    "Eigenvalues": Eigenvalues("", lambda s: [1j * math.sqrt(1.5 * s.g / s.l)]),
    "MassMatrix": MassMatrix("", lambda s: [[s.m * s.l**2 / 3]]),
    "Steady": Steady("", {"q": math.pi}),
    "Conserved, by time": Conserved("", lambda s: s.q - s["q'"] * s.t, given={"g": 0.0}),
}

WRONG: dict[str, Fact] = {
    "Acceleration": Acceleration("", lambda s: [-1.500001 * s.g / s.l * np.sin(s.q)]),
    "MassMatrix": MassMatrix("", lambda s: [[s.m * s.l**2 / 3.000001]]),
    "KineticEnergy": KineticEnergy("", lambda s: s.m * s.l**2 * s["q'"] ** 2 / 6.000001),
    "Reaction": Reaction("", "pin", lambda s: [0.0, 0.0, s.m * s.g]),
    "Conserved": Conserved("", lambda s: s.l * s["q'"] ** 2 / 6 - s.g * np.cos(s.q) / 2.000001),
    "Conserved, a mere number": Conserved("", lambda s: s.m * s.g),
    "Solution": Solution(
        "", {"q": 0.1}, lambda s: {"q": 0.1 * np.cos(math.sqrt(1.5 * 9.81) * s.t)}, lambda s: 2.0
    ),
    "Period, linearized": Period(
        "", {"q": 0.1}, lambda s: 2 * math.pi * math.sqrt(2 * s.l / (3 * s.g))
    ),
    "Frequencies": Frequencies("", lambda s: [math.sqrt(s.g / s.l)]),
    "Eigenvalues": Eigenvalues("", lambda s: [1j * math.sqrt(s.g / s.l)]),
    "Steady": Steady("", {"q": 3.14159}),
    "StabilityLimit": StabilityLimit("", "g", lambda s: 1.0, stable="above"),
}


@pytest.mark.parametrize("kind", TRUE)
def test_a_true_fact_holds(kind: str) -> None:
    (row,) = check_facts(replace(entry("rigid_bar_pendulum"), facts=(TRUE[kind],)))
    assert row.holds, row.residual


@pytest.mark.parametrize("kind", WRONG)
def test_a_wrong_fact_is_detected(kind: str) -> None:
    (row,) = check_facts(replace(entry("rigid_bar_pendulum"), facts=(WRONG[kind],)))
    assert row.kind == type(WRONG[kind]).__name__
    assert row.residual > 1e-8
    assert not row.holds


def test_a_fact_without_a_value_neither_holds_nor_fails() -> None:
    for fact in (
        MassMatrix("", lambda s: [[np.sqrt(-s.m)]]),
        Steady("", lambda s: {"q": np.arccos(s.m + 1)}),
        Solution("", {}, lambda s: {"q": 1 / (s.m - s.m)}, lambda s: 1.0),
    ):
        (row,) = check_facts(replace(entry("rigid_bar_pendulum"), facts=(fact,)))
        assert math.isnan(row.residual)
        assert row.reason
        assert not row.holds
        assert not row.fails


@pytest.mark.parametrize(("light", "residual"), [(1.0, 1e-4), (1e-12, 0.0)])
def test_a_difference_within_the_rounding_of_a_mass_matrix_is_none(
    light: float, residual: float
) -> None:
    M = np.diag([1.0, light])
    bench: Any = SimpleNamespace(
        stiffness=lambda at: (M, M),
        squares=lambda at: np.ones(2),
        numbers=lambda *state: None,
        state=lambda at: (None, None),
    )
    fact = Frequencies("", lambda s: [1.0, math.sqrt(1 + 1e-4)])
    assert _frequencies(bench, fact) == pytest.approx(residual, rel=1e-3)


def test_a_quantity_that_drifts_is_off_by_the_same_part_in_any_unit() -> None:
    def almost(unit: float) -> Fact:
        return Conserved("", lambda s: unit * (s.l * s["q'"] ** 2 / 6 - s.g * np.cos(s.q) / 2.01))

    facts = tuple(almost(unit) for unit in (1.0, 1e-4, 1e4))
    rows = check_facts(replace(entry("rigid_bar_pendulum"), facts=facts))
    assert 1e-4 < rows[0].residual < 0.1
    for row in rows[1:]:
        assert row.residual == pytest.approx(rows[0].residual, rel=1e-9)


@pytest.mark.parametrize("n", [1, 2, 3])
def test_the_margin_of_a_periodic_motion_is_that_of_its_multipliers(n: int) -> None:
    """Π (μ − 1) over the multipliers μ, the eigenvalues of what becomes of small deviations."""
    turn = np.random.default_rng(n).normal(size=(2 * n, 2 * n))
    bench: Any = SimpleNamespace(
        constants={},
        state=lambda at: (np.zeros(n), np.zeros(n)),
        flow=lambda q, v, times: np.array([turn @ [*q, *v] * time / 0.7 for time in times]),
    )
    fact = StabilityLimit("", "g", lambda s: 1.0, stable="above", period=lambda s: 0.7)
    expected = np.prod(np.linalg.eigvals(turn) - 1)
    assert _margin(bench, fact) == pytest.approx(expected.real, rel=1e-6)


def test_two_periods_are_not_the_period() -> None:
    (period,) = (fact for fact in entry("rigid_bar_pendulum").facts if isinstance(fact, Period))
    twice = replace(period, seconds=lambda s: 2 * period.seconds(s))
    (row,) = check_facts(replace(entry("rigid_bar_pendulum"), facts=(twice,)))
    assert row.residual == math.inf


@pytest.mark.parametrize(("advance", "size"), [((0.0, 0.0), 4.001), ((7.0, -2.0), 4.0)])
def test_what_a_period_misses_is_relative_to_each_coordinates_size(
    advance: tuple[float, float], size: float
) -> None:
    """Of two coordinates, 200 and 4 at most, 0.01 and 0.001 are missed; what rests has no size."""
    way = np.array([[100.0, 4, 0], [150, 2, 0], [200, 1, 0], [150, 0, 0], [120, 1, 0]])
    way = np.vstack([way, [[110, 2, 0], [100.01, 4.001, 0]]])
    way[-1, :2] += advance  # where the motion goes on from
    bench: Any = SimpleNamespace(
        constants={},
        state=lambda at: (np.array([at.get(name, 0.0) for name in "xy"]), np.zeros(1)),
        flow=lambda q, v, times: way,
    )
    fact = Period("", {}, lambda s: 1.0, advance=dict(zip("xy", advance, strict=True)))
    assert _period(bench, fact) == pytest.approx(0.001 / size, rel=1e-9)


@pytest.mark.parametrize("name", ["bead_on_hoop", "kapitza_pendulum", "bar_chain"])
def test_a_limit_of_stability_knows_its_side_and_its_value(name: str) -> None:
    (limit,) = (fact for fact in entry(name).facts if isinstance(fact, StabilityLimit))
    other = replace(limit, stable="above" if limit.stable == "below" else "below")
    off = replace(limit, formula=lambda s: limit.formula(s) * 1.001)
    rows = check_facts(replace(entry(name), facts=(limit, other, off)))
    assert rows[0].holds
    assert rows[1].residual == math.inf
    assert rows[2].residual == pytest.approx(1e-3, rel=0.1)


def test_a_motion_ends_with_the_velocity_it_has_then() -> None:
    ball, t = entry("bouncing_ball"), 0.3
    end = {"z": 1 - 9.81 * t**2 / 2, "z'": -9.81 * t, "after z'": -9.81 * t, "t": t}
    falling = replace(ball, duration=t, facts=(Occurs("", "end", lambda s: end),))
    (row,) = check_facts(falling, simulate=mq.simulate)
    assert row.residual == pytest.approx(0, abs=1e-9)


@pytest.mark.parametrize("described", [True, False])
def test_a_reaction_includes_what_nothing_describes(described: bool) -> None:
    """The force of a guide is known apart from it with an element, and together without one."""
    machine = mq.textbook.load("atwood_machine")
    reference = mq.Reference(machine if described else replace(machine, elements=()))
    q, v = np.array([0.3]), np.array([-0.7])
    bench: Any = SimpleNamespace(
        reference=reference, numbers=lambda *state: None, states=[(q, v, 0.0)]
    )
    assert ("axle" in reference.guided) != described
    ask = reference.reactions if described else reference.totals
    stated = ask(q, v)["axle"].force
    assert np.isfinite(stated).all()
    assert _reaction(bench, Reaction("", "axle", lambda s: stated)) == 0.0


def test_a_fact_may_suppose_parameters() -> None:
    def seen(s: Values) -> list[list[float]]:
        assert (s.m, s.l, s.g) == (3.0, 2.0, 1.0)
        return [[4.0]]

    supposing = MassMatrix("M = 4", seen, given={"m": 3.0})
    system = replace(entry("rigid_bar_pendulum"), facts=(supposing,))
    (row,) = check_facts(system, {"l": 2.0, "g": 1.0, "m": 7.0})
    assert row == FactRow(system.title, "MassMatrix", "M = 4", row.residual)
    assert row.holds


def test_refusals() -> None:
    with pytest.raises(
        InputError, match="expected a source among reference, derive, got 'pinocchio'"
    ):
        check_facts("rigid_bar_pendulum", source="pinocchio")
    with pytest.raises(UnknownNameError, match="unknown system 'pendulum'"):
        check_facts("pendulum")
    with pytest.raises(UnknownNameError, match="unknown parameter 'L'"):
        check_facts("rigid_bar_pendulum", {"L": 1.0})
    body = replace(entry("tennis_racket"), facts=(Eigenvalues("", lambda s: [0.0]),))
    with pytest.raises(
        InputError,
        match="expected a system without quaternions for eigenvalues, got 'tennis_racket'",
    ):
        check_facts(body)


def test_a_wrong_fact_of_a_motion_is_seen() -> None:
    ball = entry("bouncing_ball")
    late = Occurs("it rests too late", "floor: rest", lambda s: {"t": 4.0638})
    early = Occurs("it never slips", "floor: slips", lambda s: {"t": 0.0})
    wrong = ModeAcceleration("z'' = g", ("open",), lambda s: [s.g])
    lost = Lasting("its energy", lambda s: s.g * s.z + s["z'"] ** 2 / 2)
    rows = check_facts(replace(ball, facts=(late, early, wrong, lost)), simulate=mq.simulate)
    assert [row.fails for row in rows] == [True, False, True, True]
    assert "'floor: slips' happens 0 times" in str(rows[1])
    # without motions only what holds at any state is checked
    assert len(check_facts(replace(ball, facts=(late, wrong)))) == 1


def test_what_should_last_is_off_by_part_of_its_first_value() -> None:
    ball = entry("bouncing_ball")
    (row,) = check_facts(
        replace(ball, facts=(Lasting("", lambda s: [1.0 + s.t]),)), simulate=mq.simulate
    )
    assert row.residual == pytest.approx(ball.duration, rel=1e-12)


def test_facts_of_a_motion_are_off_by_the_largest_relative_difference() -> None:
    """Of a ball dropped from 1 m, e = 0.8; what is zero is compared with the others."""
    ball = entry("bouncing_ball")
    fall = math.sqrt(2 / 9.81)
    speed = 9.81 * fall
    still = {"z": 0.0, "z'": 0.0, "after z'": 0.0}

    def stated(off: float) -> list[Fact]:
        part = 1 + off
        return [
            Occurs("", "floor: impact", lambda s: {"t": fall * part, "after z'": 0.8 * speed}),
            Occurs("", "floor: impact", lambda s: {"z": 0.0, "after z'": 0.64 * speed * part}, 1),
            Occurs("", "end", lambda s: {**still, "t": ball.duration * part}),
            ModeAcceleration("", ("open",), lambda s: [-s.g * part]),
            Lasting("", lambda s: [s.g, s.g + off * s.t]),
        ]

    facts = (*stated(0.0), *stated(1e-3))
    rows = check_facts(replace(ball, facts=facts), simulate=mq.simulate)
    sizes = [*[0.0] * 5, *[1e-3] * 4, ball.duration * 1e-3 / 9.81]
    for row, size in zip(rows, sizes, strict=True):
        assert row.holds == (size == 0)
        assert row.residual == pytest.approx(size, rel=2e-3, abs=1e-9), row.kind
