"""What a blind sample of changed operators showed that no test of this room caught."""

from __future__ import annotations

from math import cos, pi, radians, sin

import numpy as np
import pytest

import mecanique as mq
from mecanique.model import (
    Blade,
    Body,
    Floating,
    Gear,
    JointForce,
    Loop,
    Mechanism,
    Placement,
    Planar,
    Prismatic,
    Revolute,
    box,
    disk,
    rod,
)
from mecanique.model.joints import Joint
from mecanique.reference import Reference
from mecanique.reference.loops.assembly import _PATIENCE, _Search
from mecanique.reference.loops.closed import Closed
from mecanique.reference.standin import log3
from mecanique.reference.tolerances import ROUNDING

BIG, SMALL, DRIVE, ANGLE = 0.2, 0.1, 2.0, radians(20)


def closed_of(mechanism: Mechanism) -> Closed:
    closed = Reference(mechanism).closed
    assert closed is not None
    return closed


def sleigh() -> Mechanism:
    """A sleigh on a blade that is not at its origin, with an arm."""
    return Mechanism(
        "sleigh",
        (Body("ground"), Body("sleigh", box(2.0, (1, 0.4, 0.1))), Body("arm", box(1, (1, 1, 1)))),
        (
            Planar("plane", "ground", "sleigh", names=("x", "y", "theta")),
            Revolute("arm", "sleigh", "arm", axis=(0, 0, 1)),
        ),
        contacts=(Blade("edge", "sleigh", (0.3, -0.2, 0.1), (0.6, 0.8, 0)),),
        gravity=(0, 0, 0),
    )


def test_a_blade_holds_its_point_on_its_line() -> None:
    reference = Reference(sleigh())
    q, v, speed = [0.1, 0.2, 0.7, 0.4], np.array([0.3, -0.5, 1.1, 0.6]), 1e-5
    point = reference.point("sleigh", (0.3, -0.2, 0.1), q, v)
    c, s = cos(0.7), sin(0.7)
    side = np.array([-0.8 * c - 0.6 * s, -0.8 * s + 0.6 * c, 0.0])
    J = reference.constraint_jacobian(q)
    np.testing.assert_allclose(J @ v, side @ point.velocity, rtol=1e-13, atol=0)
    ahead, behind = (
        reference.constraint_jacobian(np.array(q) + sign * speed * v) for sign in (1, -1)
    )
    bias = (ahead - behind) @ v / (2 * speed)
    np.testing.assert_allclose(reference.constraint_bias(q, v), bias, rtol=1e-8, atol=0)


@pytest.mark.parametrize("name", ["rolling_coin", "two_wheeled_cart"])
def test_the_force_of_a_contact_acts_where_it_touches(name: str) -> None:
    """About the point of contact it has no moment; the hub is where the wrench is reported."""
    mechanism = mq.textbook.load(name)
    q = mq.assemble(mechanism, mq.textbook.catalogue.entry(name).start)
    reference = Reference(mechanism)
    wrenches = reference.reactions(q)
    assert np.abs(wrenches[mechanism.contacts[0].name].force).max() > 1
    for contact, point in reference.contact_points(q).items():
        about = wrenches[contact].about(point)
        np.testing.assert_allclose(about.moment, 0.0, rtol=0, atol=1e-13)


def test_a_moment_about_another_point_in_other_axes() -> None:
    """M' = M + r × F, in any axes, in one state and in many."""
    reference = Reference(mq.textbook.load("double_pendulum"))
    second = reference.mechanism.joints[1].name
    q, v = np.array([[0.4, 0.9], [1.1, -0.3]]), np.array([[1.0, 2.0], [-1.0, 0.5]])
    wrench, away = reference.reactions(q, v)[second], np.array([0.3, -0.2, 0.5])
    plain = wrench.about(away)
    turned = wrench.in_axes("child").about(away)
    np.testing.assert_allclose(
        turned.in_axes("world").moment, plain.moment, rtol=0, atol=1e-13 * abs(plain.moment).max()
    )
    at = reference.pose(wrench.child, q)[:, :3, 3]
    expected = wrench.moment + np.cross(at - away, wrench.force)
    np.testing.assert_allclose(plain.moment, expected, rtol=0, atol=1e-12)


def test_the_force_between_bevel_wheels_by_hand() -> None:
    """They touch at (0.2, 0, 0.1), whether the ground turns the apex away from the origin or not.

    The force parts them at right angles to the ray to there, and turns each about its axle.
    """
    apex = np.array([1.0, -2.0, 0.5])
    along = Placement((1.0, -2.0, 0.5 + SMALL))
    aside = Placement((1.0 + BIG, -2.0, 0.5))
    machine = Mechanism(
        "bevel",
        (
            Body("ground"),
            Body("a", disk(3.0, BIG)),
            Body("b", disk(1.0, SMALL).at(rpy=(0, pi / 2, 0))),
        ),
        (
            Revolute("A", "ground", "a", axis=(0, 0, 1), origin=along),
            Revolute("B", "ground", "b", axis=(1, 0, 0), origin=aside),
        ),
        forces=(JointForce("drive", "A", DRIVE),),
        elements=(Gear("mesh", "A", "B", BIG, other_radius=SMALL),),
        gravity=(0, 0, 0),
    )
    reference = Reference(machine)
    small = SMALL**2 / 2
    a = DRIVE / (3.0 * BIG**2 / 2 + 4 * small)
    tangential = small * 2 * a / SMALL
    ray = np.array([BIG, 0, SMALL]) / np.hypot(BIG, SMALL)
    apart = np.array([ray[2], 0, -ray[0]])
    expected = tangential * (np.array([0, 1, 0]) + np.tan(ANGLE) * apart)
    on = {action.body: action for action in reference.guide_actions([0.3])}
    assert len(on) == 2
    assert len(reference.guide_actions([0.3])) == 2
    for body, sign in (("b", 1.0), ("a", -1.0)):
        np.testing.assert_allclose(on[body].force, sign * expected, rtol=0, atol=1e-13)
        np.testing.assert_allclose(
            on[body].point, apex + np.array([BIG, 0, SMALL]), rtol=0, atol=1e-14
        )


@pytest.mark.parametrize("sign", [1.0, -1.0])
@pytest.mark.parametrize("axis", [(1.0, 0.0, 0.0), (0.6, -0.8, 0.0), (-0.36, 0.48, 0.8)])
def test_a_turn_by_almost_half_keeps_its_sense(axis: tuple[float, ...], sign: float) -> None:
    from scipy.spatial.transform import Rotation

    vector = sign * (pi - 1e-8) * np.array(axis)
    found = log3(Rotation.from_rotvec(vector).as_matrix())
    np.testing.assert_allclose(found, vector, rtol=0, atol=1e-7)


def test_what_is_outside_of_loops_has_no_part() -> None:
    """Two rods on hinges with a bar each, and a block beside them; units of length go by part."""
    bodies = [Body("ground"), Body("block", box(1, (1, 1, 1))), Body("free", box(1, (1, 1, 1)))]
    joints: tuple[Joint, ...] = (
        Prismatic("slide", "ground", "block", axis=(1, 0, 0)),
        Floating("free", "ground", "free"),
    )
    loops = []
    for k, size in enumerate((1.0, 0.01)):
        for name, x in ((f"l{k}", 0.0), (f"r{k}", 0.8 * size)):
            bodies.append(Body(name, rod(1.0, size / 2)))
            place = Placement((x, float(k), 0))
            joints += (Revolute(name, "ground", name, axis=(0, -1, 0), origin=place),)
        end = (0, 0, -size / 2)
        loops.append(Loop.distance(f"bar{k}", f"l{k}", end, f"r{k}", end, 0.8 * size))
    mechanism = Mechanism("two", tuple(bodies), joints, loops=tuple(loops))
    closures = closed_of(mechanism).closures
    np.testing.assert_array_equal(closures.parts.columns, [-1] * 7 + [0, 0, 1, 1])
    np.testing.assert_allclose(closures.columns[:4], closures.length, rtol=0, atol=0)


@pytest.mark.parametrize("length", [1e-3, 1.0, 10.0])
def test_the_direction_of_a_rod_is_the_less_certain_the_shorter_it_is(length: float) -> None:
    """A rod at the origin, and one a way off: 1 + way / L, and as much more as L / length."""
    feet = Placement((length, 0, 0))
    mechanism = Mechanism(
        "rods",
        (Body("ground"), Body("left", rod(1.0, 1.0)), Body("right", rod(1.0, 1.0))),
        (
            Revolute("a", "ground", "left", axis=(0, -1, 0)),
            Revolute("b", "ground", "right", axis=(0, -1, 0), origin=feet),
        ),
        loops=(Loop.distance("bar", "left", (0, 0, -1), "right", (0, 0, -1), length),),
    )
    closures = closed_of(mechanism).closures
    here = closures.scale(np.zeros(2), np.zeros(2), 0.0)
    way = float(np.hypot(length, 1.0))
    expected = ROUNDING * (1 + way / closures.length) * (1 + closures.length / length)
    np.testing.assert_allclose(here.rounding, [expected], rtol=1e-12, atol=0)


@pytest.mark.parametrize(("left", "given_up"), [(0.5, False), (0.99, False), (0.9999, True)])
def test_a_search_that_gains_nothing_is_given_up(left: float, given_up: bool) -> None:
    """Steps that leave almost all of a gap count; a single one that gains is enough to go on."""
    first, gap = np.array([0]), np.array([1.0])
    search = _Search(first, first, np.array([True]))
    for _ in range(_PATIENCE + 1):
        taken = search.accept(gap, left * gap)
        gap = left * gap
    assert search.over == given_up
    assert taken != given_up
