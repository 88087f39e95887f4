"""Rows of contacts: their rates are derivatives of gap and slip, and none is made of rounding."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
from rolling_samples import ALL, sleigh
from sympy import cos

from mecanique.derivation.mechanics.letters import Letters
from mecanique.derivation.mechanics.loops import loops_of
from mecanique.derivation.mechanics.recursion import recursion_on_tape
from mecanique.derivation.numeric.constraints.rows import Held
from mecanique.derivation.symbolic.lagrange import Lagrange
from mecanique.model import (
    Body,
    Coordinates,
    Mechanism,
    Placement,
    Prismatic,
    Revolute,
    Rolling,
    ball,
    coordinate,
    time,
)
from mecanique.model.states import States
from mecanique.program.evaluation import evaluate
from mecanique.program.traced import values_of

STATES = 4

SLEIGH = sleigh(by_element=False)
DRIFT = 0.4 * cos(3 * time()) * coordinate("x") ** 2
SAMPLES = {
    **ALL,
    "drifting_sleigh": replace(
        SLEIGH, velocity_constraints=(replace(SLEIGH.velocity_constraints[0], rate=DRIFT),)
    ),
}
"""With one whose ψ = A v − b has a b of its own."""


@pytest.mark.parametrize("mechanism", SAMPLES.values(), ids=SAMPLES)
def test_rates_of_gaps_and_slips_are_their_derivatives_off_the_contact(
    mechanism: Mechanism,
) -> None:
    """Φ' = ψ = A v − b and ψ' = A a + γ, wherever the bodies are and however they slip."""
    letters = Letters(mechanism)
    rows = loops_of(letters, recursion_on_tape(letters)).velocity_rows
    gaps = [row for row in rows if row.name.endswith(": normal")]
    drifts = values_of(row.slip for row in rows)
    pairs = [
        ([row.slip for row in gaps], letters.along([row.gap for row in gaps])),
        ([row.rate for row in rows], letters.along([row.slip for row in rows])),
    ]
    random = np.random.default_rng(3)
    q = mechanism.normalize(random.uniform(-0.7, 0.7, (STATES, mechanism.nq)))
    v = random.normal(size=(STATES, mechanism.nv))
    names = (*mechanism.coordinates, *mechanism.velocities)
    given = {
        "t": random.uniform(0, 1, STATES),
        **dict(zip(names, np.hstack([q, v]).T, strict=True)),
    }
    for found, expected in pairs:
        answers = evaluate(letters.tape, values_of([*found, *expected]), given, STATES)
        ours, exact = np.split(answers, 2, axis=1)
        np.testing.assert_allclose(ours, exact, rtol=1e-11, atol=1e-12)
    # ψ is linear in v, with the slopes A
    slips = evaluate(letters.tape, drifts, given, STATES)
    still = {**given, **dict.fromkeys(mechanism.velocities, np.zeros(STATES))}
    slopes = [value for row in rows for value in values_of(row.slopes)]
    A = evaluate(letters.tape, slopes, given, STATES).reshape(STATES, len(rows), -1)
    rest = evaluate(letters.tape, drifts, still, STATES)
    np.testing.assert_allclose(slips - rest, (A @ v[..., None])[..., 0], rtol=1e-11, atol=1e-12)
    # on jets, from the motions of both bodies, the rows are the same
    held = Held(mechanism).at(States.of(mechanism, q, v, given["t"]))
    laws = values_of(value for row in rows for value in (row.gap, row.rate))
    laid = evaluate(letters.tape, laws, given, STATES).reshape(STATES, len(rows), 2)
    for ours, exact in zip(
        (held.rates, held.jacobian, held.residual, held.gamma),
        (slips, A, *np.moveaxis(laid, -1, 0)),
        strict=True,
    ):
        np.testing.assert_allclose(ours, exact, rtol=1e-11, atol=1e-12)


@pytest.mark.parametrize(
    ("moves", "left"), [("axle", []), ("belt", []), ("nothing", ["c_x"])], ids=str
)
def test_what_cancels_but_for_rounding_is_no_constraint(moves: str, left: list[str]) -> None:
    """An axle or a belt moves by 0.7 s + 0.2 s where a wheel of the radius 0.9 s turns by one.

    So slip is 0, as is the gap; in floats they are -1.1e-16, which held the wheel still.
    """
    a, b, radius = (part * math.sin(1.0) for part in (0.7, 0.2, 0.9))
    assert 0 < abs(a + b - radius) < 1e-15
    theta, sign = coordinate("theta"), {"axle": 1, "belt": -1, "nothing": 0}[moves]
    slides = (
        Prismatic("slide", "ground", "first", axis=(1, 0, 0), coordinate="x"),
        Prismatic("slide_on", "first", "second", axis=(1, 0, 0), coordinate="y"),
    )
    axle, under = ("second", "ground") if moves == "axle" else ("ground", "second")
    legs = Placement((0, 0, a)), Placement((0, 0, b))
    joints = (
        *slides,
        Prismatic("rise", axle, "leg", axis=(0, 0, 1), origin=legs[0], coordinate="z"),
        Revolute("turn", "leg", "wheel", axis=(0, 1, 0), origin=legs[1], coordinate="theta"),
    )
    bodies = (Body("ground"), *map(Body, ("first", "second", "leg")), Body("wheel", ball(0.7, 0.9)))
    mechanism = Mechanism(
        "roller",
        bodies,
        joints,
        coordinates=Coordinates(("theta",), {"x": sign * a * theta, "y": sign * b * theta, "z": 0}),
        contacts=(Rolling("c", "wheel", radius, axis=None, on=under),),
    )
    assert [tie.name for tie in Lagrange(mechanism).derivation().ties] == left
