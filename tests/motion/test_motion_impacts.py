"""Impacts with friction of one contact: Routh's construction by hand, over random rods."""

from __future__ import annotations

import math
from collections import Counter
from dataclasses import replace

import numpy as np
import numpy.typing as npt
import pytest

import mecanique as mq
from mecanique.derivation.mechanics.letters import Letters
from mecanique.derivation.mechanics.switching import ElementRows, Terms, close_contacts
from mecanique.generation.mechanics.constrained import inputs_at
from mecanique.generation.mechanics.switching import SwitchingEquations
from mecanique.model.constraints.friction import LAWS, Restitution
from mecanique.motion.switching.law import Laws
from mecanique.motion.switching.rows import SwitchingRows
from mecanique.program.evaluation import evaluate
from mecanique.program.traced import values_of
from mecanique.verification.states import random_states

Floats = npt.NDArray[np.float64]

ROUNDING = 1e-13

PHASES = "compression", "expansion"


def follow(
    yields: Floats, rates: Floats, mu: float, e: float, law: Restitution
) -> tuple[Floats, str]:
    """Return the tangential and the normal impulse, and the region of Routh's diagram.

    Both grow together: along the line of friction while it slips, along the line of sticking where
    that is within the cone, else back; until the bodies no longer approach, and on to 1 + e times
    the normal impulse of then (Poisson) or to e times the approach (Newton). The yields are
    J M^-1 J^T, tangent first.
    """
    (a, b), (_, c) = yields
    slip, approach = rates.tolist()
    size, phase, ends, region = abs(slip) + abs(approach), "compression", math.inf, "slips through"
    push, target = np.zeros(2), -e * approach
    while True:
        slides = math.copysign(1, slip) if abs(slip) > ROUNDING * size else 0.0
        ways = -mu * slides
        if not slides:
            sticks = abs(b) <= mu * a
            ways = -b / a if sticks else -mu * math.copysign(1, b)
            if region == "slips through":
                region = f"{'sticks' if sticks else 'turns round'} in {phase}"
        rate, parting = b + a * ways, c + b * ways
        to_stick = -slip / rate if rate * slides < 0 else math.inf
        goal = 0.0 if phase == "compression" else target
        to_part = (goal - approach) / parting if parting > 0 else math.inf
        to_end = to_part if phase == "compression" or law == "newton" else ends - push[1]
        step = min(to_stick, to_end)
        push += step * np.array([ways, 1.0])
        slip = 0.0 if step == to_stick else slip + step * rate
        approach += step * parting
        if step == to_end and phase == "expansion":
            return push, region
        if step == to_end:
            phase, ends = "expansion", (1 + e) * push[1]


def make_rod(length: float, mu: float, e: float, law: Restitution) -> mq.Mechanism:
    """Return a uniform rod that meets the floor with its end."""
    return mq.Mechanism(
        "rod",
        (mq.Body("ground"), mq.Body("rod", mq.rod(1.0, length))),
        (mq.Planar("plane", "ground", "rod", axis=(0, -1, 0), names=("x", "z", "th")),),
        switching=(mq.Contact("end", "rod", mu=mu, restitution=e, law=law),),
    )


@pytest.mark.parametrize("law", LAWS)
def test_an_impact_is_routh_s_in_all_regions_of_his_diagram(law: Restitution) -> None:
    """Of 800 random rods; by Poisson's law none gains energy."""
    random, regions = np.random.default_rng(0), Counter[str]()
    for _ in range(800):
        mu, e, length = random.uniform(0.02, 1.5), random.uniform(), random.uniform(0.3, 2)
        contact = mq.Contact("end", "rod", mu=mu, law=law)
        end = ElementRows(contact, 0, (1,), pressing=0, restitution=e)
        x, z = length / 2 * random.normal(size=2)
        v, mass = random.normal(size=3), np.diag([1, 1, length**2 / 12])
        J = np.array([[0, 1, x], [1, 0, -z]])
        if J[0] @ v > 0:
            v = -v
        none, kinetic = np.zeros(2), np.array([mu])
        terms = Terms(mass, np.zeros(3), J, none, none, J @ v, none, kinetic, kinetic)
        change, _ = Laws((end,), ()).impact(terms, [True], 1e-12)
        tangent = J[::-1]
        response = np.linalg.solve(mass, tangent.T)
        push, region = follow(tangent @ response, tangent @ v, mu, e, law)
        np.testing.assert_allclose(change, response @ push, rtol=0, atol=1e-12)
        after = v + change
        if law == "poisson":
            assert after @ mass @ after <= v @ mass @ v * (1 + 1e-12)
        regions[region] += 1
    turns = [f"{way} in {phase}" for way in ("sticks", "turns round") for phase in PHASES]
    assert {*regions} == {"slips through", *turns}
    assert min(regions.values()) >= 5, regions


@pytest.mark.parametrize("law", LAWS)
def test_pages_and_code_have_the_same_impact(law: Restitution) -> None:
    """On their tape, with the terms of the tree, at 60 states; by the engine's terms here."""
    rod = make_rod(1.0, 0.15, 0.8, law)
    letters, rows = Letters(close_contacts(rod)), SwitchingRows(rod)
    states = random_states(replace(rod, switching=()), 60, 0)
    equations = SwitchingEquations(rod, letters, lambda name: name.endswith(": y"))
    inputs = inputs_at(letters, replace(states, mechanism=letters.mechanism))
    values = values_of(equations.bounce("end")[0])
    changes = evaluate(letters.tape, values, inputs, len(states))
    laws, turned = Laws(rows.elements, rows.permanent), 0
    for q, v, change in zip(states.q, states.v, changes, strict=True):
        terms = rows.at(q, v, 0.0)
        slip, approach = terms.rates[[1, 0]]
        after = terms.rates[1] + terms.jacobian[1] @ change
        turned += bool(slip * after < -ROUNDING and approach < 0)
        ours, _ = laws.impact(terms, [True], 1e-12)
        np.testing.assert_allclose(change, ours, rtol=0, atol=1e-12 * np.abs(v).max())
    assert turned >= 3


def test_friction_that_jams_an_impact_is_refused() -> None:
    """A pendulum that leans on its rough tip cannot part: by Poisson's law it stays."""
    bodies = mq.Body("ground"), mq.Body("rod", mq.rod(1.0, 1.0))
    hinge = mq.Revolute("hinge", "ground", "rod", axis=(0, -1, 0), coordinate="th")
    floor = mq.Placement((0, 0, -math.sqrt(3) / 2))
    for law in LAWS:
        tip = mq.Contact("tip", "rod", (1, 0, 0), plane=floor, mu=1.0, restitution=0.5, law=law)
        rod = mq.Mechanism("jammed", bodies, (hinge,), switching=(tip,))
        rows = SwitchingRows(rod)
        terms = rows.at(np.array([-math.pi / 3]), np.array([-1.0]), 0.0)
        laws = Laws(rows.elements, rows.permanent)
        if law == "newton":
            with pytest.raises(mq.InputError, match=r"no velocities follow .* friction jams it"):
                laws.impact(terms, [True], 1e-12)
            assert mq.verify(rod, samples=5).agrees
        else:
            np.testing.assert_allclose(
                laws.impact(terms, [True], 1e-12)[0], 1.0, rtol=1e-12, atol=0
            )


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
    for law in LAWS:
        push, _ = follow(yields, np.array([slip, -1.0]), mu, 0.5, law)
        np.testing.assert_allclose(slip + 3.5 * push[0], after, rtol=0, atol=1e-13)
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
