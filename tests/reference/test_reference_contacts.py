"""Rows of velocity constraints and contacts against their derivatives and geometry by hand."""

from __future__ import annotations

from dataclasses import replace
from math import cos, sin

import numpy as np
import pytest
import sympy
from rolling_samples import ALL, coin
from scipy.spatial.transform import Rotation

import mecanique as mq
from mecanique.errors import EngineError
from mecanique.model import (
    Blade,
    Body,
    Floating,
    Mechanism,
    Placement,
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


PLANE = Placement((0.3, -0.2, 0.5), (0.4, -0.3, 1.1))
HUB, AXIS = (0.2, 0.3, -0.1), (0.48, -0.6, 0.64)


@pytest.mark.parametrize(
    "rolling",
    [
        Rolling("sharp", "body", 0.5, HUB, AXIS, on="base", plane=PLANE),
        Rolling("crowned", "body", 0.5, HUB, AXIS, 0.2, on="base", plane=PLANE),
        Rolling("ball", "body", 0.5, HUB, None, on="base", plane=PLANE),
        Rolling("point", "body", 0.0, HUB, None, on="base", plane=PLANE),
        Rolling("egg", "body", 0.5, HUB, None, on="base", plane=PLANE, stretch=(0.7, 1.2, 0.9)),
        Rolling("in a bowl", "body", 0.5, HUB, None, on="base", plane=PLANE, bowl=2.5),
        Rolling("on a dome", "body", 0.5, HUB, None, on="base", plane=PLANE, bowl=-1.5),
    ],
    ids=lambda rolling: rolling.name,
)
def test_gaps_and_slips_are_those_of_geometry(rolling: Rolling) -> None:
    """Φ is the height of the lowest point over the plane, J v its velocity against the plane's."""
    parts = Body("base", box(3.0, (1, 2, 0.1))), Body("body", ball(1.0, 0.5))
    joints = Floating("f", "ground", "base"), Floating("g", "ground", "body")
    mechanism = Mechanism("two", (Body("ground"), *parts), joints, contacts=(rolling,))
    reference, random = Reference(mechanism), np.random.default_rng(5)
    closed = reference.closed
    assert closed is not None
    (o, A), (p, B) = (
        (random.normal(size=3), Rotation.random(rng=random)) for _ in ("base", "body")
    )
    q, v = np.concatenate([o, A.as_quat(), p, B.as_quat()]), random.normal(size=12)
    here = closed.closures.at(q, v, 0.0)
    frame = A.as_matrix() @ np.array(rolling.plane.rotation, dtype=float)
    n, foot, hub = frame[:, 2], o + A.apply(rolling.plane.xyz), p + B.apply(rolling.center)
    radius, crown = float(rolling.radius), float(rolling.crown)
    if rolling.bowl:
        middle, side = foot + float(rolling.bowl) * n, np.sign(float(rolling.bowl))
        length = np.linalg.norm(middle - hub)
        up = side * (middle - hub) / length
        lowest, gap = hub - radius * up, float(rolling.bowl) - side * length - radius
        lean = np.cross(n, up)
        lean *= np.arccos(n @ up) / np.linalg.norm(lean)
        frame = Rotation.from_rotvec(lean).as_matrix() @ frame
    elif rolling.axis is None:
        # the support of an ellipsoid
        D = B.as_matrix() @ np.diag(radius * np.array(rolling.stretch, dtype=float))
        lowest = hub - D @ (D.T @ n) / (np.linalg.norm(D.T @ n) or 1.0)
        gap = n @ (hub - foot) - np.linalg.norm(D.T @ n)
    else:
        axis = B.apply(rolling.axis)
        across = n - (n @ axis) * axis
        sine = np.linalg.norm(across)
        lowest = hub - crown * n - (radius - crown) * across / sine
        gap = n @ (hub - foot) - crown - (radius - crown) * sine
    slip = B.apply(v[6:9] + np.cross(v[9:], B.inv().apply(lowest - p)))
    slip -= A.apply(v[:3] + np.cross(v[3:6], A.inv().apply(lowest - o)))
    np.testing.assert_allclose(here.residual, [gap, 0, 0], rtol=1e-13, atol=1e-15)
    places = reference.contact_points(np.array([q, mechanism.normalize(q + 0.1), q]))
    np.testing.assert_allclose(places[rolling.name][[0, 2]], [lowest] * 2, rtol=1e-13, atol=0)
    if not rolling.bowl:
        closed.closures.at(q, v, 0.0)
        (along,) = closed.closures.contacts.feet
        assert along == pytest.approx(frame[:, 0] @ (lowest - foot), rel=1e-12)
    np.testing.assert_allclose(
        here.jacobian @ v, slip @ frame[:, [2, 0, 1]], rtol=1e-13, atol=1e-14
    )


def test_a_blade_prevents_what_is_sideways_where_it_touches() -> None:
    blade = Blade("edge", "body", (0.2, 0.3, -0.1), (0.48, -0.6, 0.64), on="base")
    bodies = Body("ground"), Body("base", ball(1.0, 0.5)), Body("body", ball(1.0, 0.5))
    joints = Floating("f", "ground", "base"), Floating("g", "ground", "body")
    reference = Reference(Mechanism("skate", bodies, joints, contacts=(blade,)))
    assert reference.closed is not None
    random = np.random.default_rng(6)
    (o, A), (p, B) = (
        (random.normal(size=3), Rotation.random(rng=random)) for _ in ("base", "body")
    )
    q, v = np.concatenate([o, A.as_quat(), p, B.as_quat()]), random.normal(size=12)
    place = p + B.apply(blade.point)
    slip = B.apply(v[6:9] + np.cross(v[9:], B.inv().apply(place - p)))
    slip -= A.apply(v[:3] + np.cross(v[3:6], A.inv().apply(place - o)))
    J = reference.closed.closures.at(q, v, 0.0).jacobian
    np.testing.assert_allclose(J @ v, [slip @ B.apply(blade.side)], rtol=1e-13, atol=0)
    np.testing.assert_allclose(reference.contact_points(q)["edge"], place, rtol=1e-14, atol=0)


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


def test_a_coin_reaches_more_positions_than_its_velocities_can_choose() -> None:
    """Six coordinates less the height it has on the plane; rolling takes two velocities more."""
    freedom = mq.degrees_of_freedom(coin(), {"lean": 0.3})
    assert (freedom.coordinates, freedom.positions, freedom.N) == (6, 5, 3)
