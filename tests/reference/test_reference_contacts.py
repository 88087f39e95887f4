"""Rows of velocity constraints and contacts against their derivatives and geometry by hand."""

from __future__ import annotations

from dataclasses import replace
from math import cos, sin

import numpy as np
import pytest
import sympy
from rolling_samples import ALL, coin

import mecanique as mq
from mecanique.errors import EngineError
from mecanique.model import (
    Body,
    Floating,
    Mechanism,
    Planar,
    Prismatic,
    Revolute,
    Rolling,
    VelocityConstraint,
    ball,
    box,
    coordinate,
    time,
)
from mecanique.reference import Reference, assemble
from mecanique.verification.states import random_states

SIDE, RATE = 0.3, 2.0


def steered() -> Mechanism:
    """A sleigh whose edge is driven sideways: y' cos θ − x' sin θ = 0.3 sin 2t."""
    theta, t = coordinate("theta"), time()
    edge = VelocityConstraint(
        "edge",
        {"x": -sympy.sin(theta), "y": sympy.cos(theta)},
        SIDE * sympy.sin(RATE * t),
    )
    return Mechanism(
        "steered",
        (Body("ground"), Body("sleigh", box(2.0, (1, 0.4, 0.1)).at((0.3, 0, 0)))),
        (Planar("plane", "ground", "sleigh", names=("x", "y", "theta")),),
        velocity_constraints=(edge,),
        gravity=(0, 0, 0),
    )


@pytest.mark.parametrize("t", [0.2, 1.1, 5.0])
def test_a_rate_that_depends_on_time_enters_with_its_sign(t: float) -> None:
    reference, theta, turning = Reference(steered()), 0.4, 1.7
    q = np.array([0.2, -0.3, theta])
    sideways = SIDE * sin(RATE * t)
    ahead = 0.8
    v = np.array(
        [
            ahead * cos(theta) - sideways * sin(theta),
            ahead * sin(theta) + sideways * cos(theta),
            turning,
        ]
    )
    assert reference.drift(q, v, t)[1] == pytest.approx(0.0, abs=1e-15)
    assert reference.drift(q, np.zeros(3), t)[1] == pytest.approx(abs(sideways), rel=1e-14)
    closed = reference.closed
    assert closed is not None
    here = closed.closures.at(q, v, t)
    np.testing.assert_allclose(here.jacobian, [[-sin(theta), cos(theta), 0]], rtol=0, atol=1e-15)
    np.testing.assert_allclose(here.drift, [-sideways], rtol=1e-14, atol=0)
    # d/dt of the law: A' v + A a = b'
    bent = -turning * ahead - SIDE * RATE * cos(RATE * t)
    np.testing.assert_allclose(reference.constraint_bias(q, v, t), [bent], rtol=1e-13, atol=0)
    x, y, _ = reference.acceleration(q, v, t)
    assert y * cos(theta) - x * sin(theta) == pytest.approx(-bent, rel=1e-13)


@pytest.mark.parametrize("name", ["rolling_coin", "chaplygin_sleigh", "ball_in_a_bowl"])
def test_slopes_of_contacts_are_those_of_the_whole_closure(name: str) -> None:
    """A search for closed positions asks for J alone, without rates of the engine's Jacobians."""
    reference = Reference(mq.textbook.load(name))
    mechanism, closed = reference.mechanism, reference.closed
    assert closed is not None
    q = mechanism.normalize(mechanism.neutral() + 0.1)
    reference.constraint_bias(q, np.ones(mechanism.nv))  # what moved before does not matter
    J, rounding = closed.closures.slopes(q, 0.0)
    whole = closed.closures.scale(q, np.zeros(mechanism.nv), 0.0)
    np.testing.assert_allclose(J, whole.jacobian, rtol=1e-14, atol=1e-14)
    np.testing.assert_allclose(rounding, whole.rounding, rtol=1e-14, atol=0)
    np.testing.assert_allclose(
        closed.closures.rows[:, None] * reference.constraint_jacobian(q) * closed.closures.columns,
        J,
        rtol=1e-14,
        atol=1e-14,
    )


def margin(contact: Rolling, q: list[float]) -> float:
    """How well the place of a free body's contact is determined."""
    bodies = Body("ground"), Body("body", ball(1.0, 0.5))
    free = Mechanism("free", bodies, (Floating("f", "ground", "body"),), contacts=(contact,))
    closed = Reference(free).closed
    assert closed is not None
    closed.closures.at(np.array(q), np.zeros(6), 0.0)
    (found,) = closed.closures.contacts.margins
    return float(found)


@pytest.mark.parametrize("lying", [1e-6, 0.01, 0.4, 1.5])
@pytest.mark.parametrize("crown", [0.0, 0.2])
def test_a_wheel_that_lies_touches_nowhere_in_particular(lying: float, crown: float) -> None:
    half = (np.pi / 2 - lying) / 2
    rolling = Rolling("rim", "body", 0.5, crown=crown)
    found = margin(rolling, [0, 0, 0, sin(half), 0, 0, cos(half)])
    assert found == pytest.approx(sin(lying), rel=1e-9)


@pytest.mark.parametrize("radius", [2.0, -2.0])
@pytest.mark.parametrize("angle", [0.0, 1.0, 3.0])
def test_directions_turn_the_less_surely_the_nearer_a_ball_is_to_the_top_of_a_bowl(
    radius: float, angle: float
) -> None:
    away = radius - 0.5
    place = [away * sin(angle), 0.0, radius - away * cos(angle)]
    rolling = Rolling("inside", "body", 0.5, axis=None, bowl=radius)
    found = margin(rolling, [*place, 0, 0, 0, 1])
    assert found == pytest.approx((1 + cos(angle)) / 2, rel=1e-12)
    assert margin(Rolling("flat", "body", 0.5, axis=None), [0, 0, 0.5, 0, 0, 0, 1]) == 1


def test_a_wheel_rolls_on_a_plate_in_gimbals() -> None:
    """γ is J' v: its lean changes as the plate's normal turns, and as its own axis does."""
    bodies = (
        Body("ground"),
        Body("gimbal", box(0.1, (0.1, 0.1, 0.1))),
        Body("plate", box(2.0, (1, 1, 0.1))),
        Body("fork", box(0.1, (0.1, 0.1, 0.1))),
        Body("wheel", box(1.4, (0.3, 0.1, 0.3))),
    )
    joints = (
        Revolute("swing", "ground", "gimbal", axis=(0.6, 0.8, 0), coordinate="a"),
        Revolute("tip", "gimbal", "plate", axis=(0.8, -0.6, 0), coordinate="b"),
        Planar("plane", "ground", "fork", names=("x", "y", "yaw")),
        Prismatic("lift", "fork", "post", axis=(0, 0, 1), coordinate="z"),
        Revolute("lean", "post", "hub", axis=(1, 0, 0), coordinate="lean"),
        Revolute("spin", "hub", "wheel", axis=(0, 1, 0), coordinate="spin"),
    )
    extra = (Body("post", box(0.1, (0.1, 0.1, 0.1))), Body("hub", box(0.1, (0.1, 0.1, 0.1))))
    rolling = Rolling("c", "wheel", 0.5, crown=0.1, on="plate")
    mechanism = Mechanism("gimbals", (*bodies, *extra), joints, contacts=(rolling,))
    reference = Reference(mechanism)
    q0 = np.array([0.3, -0.2, 0.2, -0.1, 0.7, 0.6, 0.5, 0.4])
    q = assemble(mechanism, dict(zip(mechanism.coordinates, q0, strict=True)))
    allowed = np.linalg.svd(reference.constraint_jacobian(q))[2][3:]
    v = allowed.T @ np.array([0.9, -0.7, 0.8, 0.6, -0.5])
    h = 1e-5

    def rate(step: float) -> np.ndarray:
        jacobian: np.ndarray = reference.constraint_jacobian(q + step * v)
        rates: np.ndarray = jacobian @ v
        return rates

    slopes = (8 * (rate(h) - rate(-h)) - (rate(2 * h) - rate(-2 * h))) / (12 * h)
    np.testing.assert_allclose(reference.constraint_bias(q, v), slopes, rtol=1e-7, atol=1e-8)


@pytest.mark.parametrize("mechanism", ALL.values(), ids=ALL)
def test_rates_of_gaps_and_rows_are_those_of_differences_while_bodies_slip(
    mechanism: Mechanism,
) -> None:
    """Φ' = J v + b off the contact, and (J v + b)' = γ, as the directions of a contact turn."""
    states = random_states(mechanism, 5, 1)
    slips = np.random.default_rng(2).normal(size=states.v.shape)
    closed = Reference(mechanism).closed
    assert closed is not None
    for q, v, t in zip(states.q, states.v + slips, states.t, strict=True):
        h = 1e-5
        here, after, before = (
            closed.closures.at(q + s * closed.rates(q, v), v, t + s) for s in (0, h, -h)
        )
        change = after.jacobian @ v + after.drift - before.jacobian @ v - before.drift
        held = closed.closures.positional
        pairs = [
            (here.gamma, change),
            ((here.jacobian @ v + here.drift)[held], (after.residual - before.residual)[held]),
        ]
        for rate, difference in pairs:
            size = 1 + np.abs(rate).max(initial=0.0)
            np.testing.assert_allclose(rate, difference / (2 * h), rtol=1e-6, atol=1e-6 * size)


def test_each_contact_and_each_constraint_owns_its_rows() -> None:
    extra = [
        VelocityConstraint("guided", {"spin": 1.0, "yaw": -coordinate("lean")}),
        VelocityConstraint("led", {"x": 1.0, "yaw": coordinate("y")}),
    ]
    closed = Reference(replace(coin(), velocity_constraints=tuple(extra))).closed
    assert closed is not None
    assert closed.closures.owner.tolist() == [0, 0, 0, 1, 2]


def test_a_wheel_off_its_plane_is_refused() -> None:
    with pytest.raises(EngineError, match="a wheel is off its plane"):
        Reference(coin()).acceleration({"z": 0.7})


def test_each_of_several_contacts_has_a_gap_of_its_own() -> None:
    """Two balls of half a meter, 0.1 m and 0.3 m above the plane, and a blade before them."""
    bodies = Body("ground"), *(Body(name, ball(1.0, 0.5)) for name in ("one", "two", "sled"))
    joints = tuple(Floating(f"f {body.name}", "ground", body.name) for body in bodies[1:])
    contacts = (
        Rolling("first", "one", 0.5, axis=None),
        mq.Blade("edge", "sled", (0, 0, 0), (0, 1, 0)),
        Rolling("second", "two", 0.5, axis=None),
    )
    closed = Reference(Mechanism("balls", bodies, joints, contacts=contacts)).closed
    assert closed is not None
    still = [0, 0, 0, 1]
    q = np.array([0, 0, 0.6, *still, 2, 0, 0.8, *still, 4, 0, 0, *still], dtype=float)
    gaps = dict(zip(closed.closures.names, closed.closures.residual(q, 0.0), strict=True))
    expected = {"first: normal": 0.1, "second: normal": 0.3}
    for name, gap in gaps.items():
        assert gap == pytest.approx(expected.get(name, 0.0), abs=1e-15)
