"""Accelerations by recursion and by elimination, and what no mass moves."""

from __future__ import annotations

import numpy as np
import pytest

import mecanique as mq
from mecanique.reference.engine.tree import EngineTree, backward_error, massless_mode, reach_of
from mecanique.reference.tolerances import SINGULAR_MASS

ROD = mq.rod(1.0, 1.0)


def pair(coordinates: mq.Coordinates, armature: float) -> mq.Mechanism:
    """Two rods, the second hanging from the first."""
    joints = (
        mq.Revolute("a", "ground", "first", axis=(0, -1, 0), coordinate="r1", armature=armature),
        mq.Revolute(
            "b",
            "first",
            "second",
            axis=(0, -1, 0),
            origin=mq.Placement((0, 0, -1)),
            coordinate="r2",
        ),
    )
    bodies = (mq.Body("ground"), mq.Body("first", ROD), mq.Body("second", ROD))
    return mq.Mechanism("pair", bodies, joints, gravity=(0, 0, -9.81), coordinates=coordinates)


q1, q2 = mq.coordinate("q1"), mq.coordinate("q2")
MAPS = {
    "own angles": mq.Coordinates(("r1", "r2")),
    "absolute angles": mq.Coordinates(("q1", "q2"), {"r1": q1, "r2": q2 - q1}),
    "with an offset of many turns": mq.Coordinates(
        ("q1", "q2"), {"r1": q1 + 7.5, "r2": 2 * q2 - q1 - 40.25}
    ),
    "in another order": mq.Coordinates(("q1", "q2"), {"r1": q2, "r2": q1}),
}


@pytest.mark.parametrize("name", sorted(MAPS))
@pytest.mark.parametrize("armature", [0.0, 0.3])
def test_hinges_move_alike_in_all_coordinates(name: str, armature: float) -> None:
    reference = mq.Reference(pair(MAPS[name], armature))
    f, random = reference.rhs(), np.random.default_rng(0)
    for _ in range(5):
        q, v = random.uniform(-30, 30, 2), random.uniform(-3, 3, 2)
        y = f(0.0, np.concatenate([q, v]))
        assert y[:2].tolist() == v.tolist()
        np.testing.assert_allclose(y[2:], reference.acceleration(q, v), rtol=1e-9, atol=1e-9)


def test_a_residual_is_measured_by_all_terms_of_its_equations() -> None:
    """|M a − f| is 3 and 8 here, |M| |a| + |f| is 2·1 + 1·3 + 4 = 9 and 1·1 + 3·3 + 2 = 12."""
    M, a, right = np.array([[2.0, 1.0], [1.0, -3.0]]), np.array([-1.0, 3.0]), np.array([4.0, -2.0])
    left = M @ a
    np.testing.assert_array_equal(left, [1.0, -10.0])
    assert backward_error(M, a, right) == 8 / 12
    assert backward_error(M, a, left) == 0
    assert backward_error(M, 0 * a, 0 * right) == 0
    assert backward_error(M, np.array([np.nan, 1.0]), right) == np.inf
    assert backward_error(np.zeros((0, 0)), np.zeros(0), np.zeros(0)) == 0


def test_a_velocity_reaches_the_masses_it_moves() -> None:
    """A slide all masses; a hinge tr J + m c² of what hangs on it, and its rotor."""
    cart = mq.Body("cart", mq.box(3.0, (0.3, 0.2, 0.1)))
    brick = mq.Shape(2.0, (0.3, 0.0, -0.4), (0.5, 0.6, 0.7, 0.0, 0.0, 0.0))
    joints = (
        mq.Prismatic("slide", "ground", "cart", axis=(1, 0, 0), armature=0.2),
        mq.Revolute("pin", "cart", "brick", axis=(0, 1, 0), armature=0.1),
    )
    tree = EngineTree(
        mq.Mechanism("crane", (mq.Body("ground"), cart, mq.Body("brick", brick)), joints)
    )
    tree.mass(np.array([0.3, 0.7]), np.zeros(2), 0.0)
    reach = reach_of(tree.engine.model, tree.engine.data)
    np.testing.assert_allclose(reach, [5.2, 1.8 + 2.0 * 0.25 + 0.1], rtol=1e-14, atol=0)


def test_a_motion_without_mass_is_a_velocity_or_several() -> None:
    one = np.ones(2)
    for share, found in ((2.0, False), (0.5, True)):
        light = share * SINGULAR_MASS
        mode = massless_mode(np.diag([3.0, light]), one)
        assert (mode is None) != found
        if mode is not None:
            np.testing.assert_array_equal(mode, [0, 1])
        # the same mass is enough where little is moved
        assert massless_mode(np.diag([3.0, light]), np.array([1.0, 0.1])) is None
        # (v, −w)/√2 moves 1 − c if units are those in which each alone moves 1
        near = massless_mode(np.array([[4.0, 2 - 2 * light], [2 - 2 * light, 1.0]]), one)
        assert (near is None) != found
        if near is not None:
            np.testing.assert_allclose(near, [-0.5, 1], rtol=1e-12, atol=0)
    assert massless_mode(np.zeros((0, 0)), np.zeros(0)) is None
    assert massless_mode(-np.eye(2), one) is None  # as no real body has
