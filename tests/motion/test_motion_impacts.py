"""Impacts with friction of one contact: Routh's construction by hand, over random rods."""

from __future__ import annotations

import math

import numpy as np
import numpy.typing as npt
import pytest

import mecanique as mq
from mecanique.model.constraints.friction import LAWS, Restitution
from mecanique.motion.switching.law import Laws
from mecanique.motion.switching.rows import SwitchingRows

Floats = npt.NDArray[np.float64]

ROUNDING = 1e-13


def follow(yields: Floats, rates: Floats, mu: float, e: float) -> tuple[Floats, bool]:
    """Return the tangential and the normal impulse, and whether slip turns round within a phase.

    Both grow together, as in Routh's diagram: along the line of friction while it slips, along the
    line of sticking where that is within the cone, else back; until the bodies no longer approach,
    and on to 1 + e times the normal impulse of then. The yields are J M^-1 J^T, tangent first.
    """
    (a, b), (_, c) = yields
    slip, approach = rates.tolist()
    size, end, turns = abs(slip) + abs(approach), math.inf, False
    push = np.zeros(2)
    while push[1] < end * (1 - ROUNDING):
        slides = math.copysign(1, slip) if abs(slip) > ROUNDING * size else 0.0
        ways = -mu * slides
        if not slides:
            sticks = abs(b) <= mu * a
            ways = -b / a if sticks else -mu * math.copysign(1, b)
            turns |= not sticks
        rate, parting = b + a * ways, c + b * ways
        to_stick = -slip / rate if rate * slides < 0 else math.inf
        to_part = -approach / parting if parting > 0 else math.inf
        step = min(to_stick, to_part if end == math.inf else end - push[1])
        push += step * np.array([ways, 1.0])
        slip = 0.0 if step == to_stick else slip + step * rate
        approach += step * parting
        if end == math.inf and step == to_part:
            end = (1 + e) * push[1]
    return push, turns


def make_rod(length: float, mu: float, e: float, law: Restitution) -> mq.Mechanism:
    """Return a uniform rod that meets the floor with its end."""
    return mq.Mechanism(
        "rod",
        (mq.Body("ground"), mq.Body("rod", mq.rod(1.0, length))),
        (mq.Planar("plane", "ground", "rod", axis=(0, -1, 0), names=("x", "z", "th")),),
        switching=(mq.Contact("end", "rod", mu=mu, restitution=e, law=law),),
    )


@pytest.mark.parametrize("seed", range(10))
def test_an_impact_by_poisson_is_routh_s_and_adds_no_energy(seed: int) -> None:
    random = np.random.default_rng(seed)
    mu, e = random.uniform(0.02, 1.5), random.uniform()
    rows = SwitchingRows(make_rod(random.uniform(0.3, 2), mu, e, "poisson"))
    laws, (end,) = Laws(rows.elements, rows.permanent), rows.elements
    compared = 0
    for _ in range(20):
        q, v = np.array([0, 0, random.uniform(-math.pi, math.pi)]), random.normal(size=3)
        terms = rows.at(q, v, 0.0)
        if terms.rates[end.rows[0]] > 0:
            v, terms = -v, rows.at(q, -v, 0.0)
        J = terms.jacobian[[*end.tangents, *end.rows[:1]]]
        response = np.linalg.solve(terms.mass, J.T)
        change, _ = laws.impact(terms, [True], 1e-12)
        push, turns = follow(J @ response, J @ v, mu, e)
        if not turns:  # what turns round within a phase, the law takes as a whole
            np.testing.assert_allclose(change, response @ push, rtol=0, atol=1e-12)
            compared += 1
        after = v + change
        assert after @ terms.mass @ after <= v @ terms.mass @ v * (1 + 1e-12)
    assert compared >= 15


@pytest.mark.parametrize(
    ("mu", "slip", "after"),
    [
        (0.1, 4.0, 4.0 - 0.1 * 1.5 * 7 / 2),  # slips through: μ (1 + e) v_n of a ball, 7/2 of it
        (0.1, 0.1, 0.0),  # sticks in compression
        (0.1, 0.4, 0.0),  # sticks in expansion
    ],
)
def test_a_ball_slips_through_an_impact_or_sticks(mu: float, slip: float, after: float) -> None:
    """By both laws of restitution, as the normal impulse of a ball leaves its slip alone."""
    yields = np.array([[3.5, 0.0], [0.0, 1.0]])
    push, turns = follow(yields, np.array([slip, -1.0]), mu, 0.5)
    np.testing.assert_allclose(slip + 3.5 * push[0], after, rtol=0, atol=1e-13)
    assert not turns
    for law in LAWS:
        bodies = mq.Body("ground"), mq.Body("ball", mq.ball(1.0, 0.1))
        plane = mq.Planar("plane", "ground", "ball", axis=(0, -1, 0), names=("x", "z", "th"))
        floor = mq.Contact("floor", "ball", radius=0.1, mu=mu, restitution=0.5, law=law)
        ball = mq.Mechanism("ball", bodies, (plane,), switching=(floor,))
        rows = SwitchingRows(ball)
        terms = rows.at(np.array([0, 0.1, 0]), np.array([slip, -1.0, 0]), 0.0)
        change, _ = Laws(rows.elements, rows.permanent).impact(terms, [True], 1e-12)
        np.testing.assert_allclose(change[1:], [1.5, 10 * 2.5 * push[0]], rtol=0, atol=1e-12)


def test_newton_s_restitution_with_friction_may_add_energy() -> None:
    """Kane & Levinson, Dynamics, 1985; by Poisson's law none of these rods gains any."""
    gains = []
    for law in LAWS:
        rows = SwitchingRows(make_rod(1.0, 0.8, 0.9, law))
        laws, gained = Laws(rows.elements, rows.permanent), 0.0
        for lean in np.linspace(-1.4, 1.4, 29):
            q = np.array([0, 0, math.pi + lean])
            for v in ([1.0, -1.0, 0.0], [-1.0, -1.0, 0.0], [0.2, -1.0, 0.0]):
                terms = rows.at(q, np.array(v), 0.0)
                change, _ = laws.impact(terms, [True], 1e-12)
                after = v + change
                gained = max(gained, float(after @ terms.mass @ after / (v @ terms.mass @ v)) - 1)
        gains.append(gained)
    assert gains[0] > 0.01
    assert gains[1] < 1e-12
