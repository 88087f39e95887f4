"""Coordinates and velocities of the reference against independent geometry; blows on loops."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.linalg import null_space
from scipy.spatial.transform import Rotation

import mecanique as mq
from mecanique import textbook
from mecanique.model import (
    Body,
    Coordinates,
    Floating,
    Mechanism,
    Revolute,
    Shape,
    Spherical,
    box,
    coordinate,
)
from mecanique.reference.engine.tree import EngineTree
from mecanique.reference.loops.assembly import held_columns
from mecanique.reference.reference import Reference

BRICK = Shape(1.7, (0.1, -0.2, 0.3), (0.5, 0.6, 0.4, 0.05, -0.03, 0.02))


def follower(joint: Spherical | Floating) -> Mechanism:
    """A body with a quaternion that turns a wheel by twice its first component."""
    first, *_ = joint.coordinates[-4:]
    return Mechanism(
        "follower",
        bodies=(Body("ground"), Body("brick", BRICK), Body("wheel", BRICK)),
        joints=(joint, Revolute("axle", "ground", "wheel", axis=(0, 1, 0), coordinate="phi")),
        coordinates=Coordinates(joint.coordinates, {"phi": 2 * coordinate(first)}),
        gravity=(0.3, -0.2, -9.81),
    )


def moved(q: np.ndarray, v: np.ndarray, h: float) -> np.ndarray:
    """Coordinates after a time h of constant velocity components in the body's axes, from SciPy."""
    turn = Rotation.from_quat(q[-4:])
    after = (turn * Rotation.from_rotvec(h * v[-3:])).as_quat()
    after = after if after @ q[-4:] > 0 else -after
    shift = turn.apply(h * v[:3]) if len(q) > 4 else np.zeros(0)
    return np.concatenate([q[:-4] + shift, after])


@pytest.mark.parametrize(
    "joint", [Spherical("free", "ground", "brick"), Floating("free", "ground", "brick")]
)
def test_a_coordinate_that_follows_a_quaternion_moves_as_the_body_turns(
    joint: Spherical | Floating,
) -> None:
    """Its velocity and acceleration are those of twice the first component along the motion."""
    mechanism = follower(joint)
    reference = Reference(mechanism)
    random = np.random.default_rng(4)
    for _ in range(3):
        v = random.normal(size=mechanism.nv)
        q = random.normal(size=mechanism.nq)
        q[-4:] /= np.linalg.norm(q[-4:])
        h = 1e-3
        x = [2 * moved(q, v, k * h)[-4] for k in (-2, -1, 0, 1, 2)]
        rate = (8 * (x[3] - x[1]) - (x[4] - x[0])) / (12 * h)
        second = (-x[4] + 16 * x[3] - 30 * x[2] + 16 * x[1] - x[0]) / (12 * h * h)
        arm = reference.point("wheel", (0.0, 0.0, 1.0), q, v, np.zeros(mechanism.nv))
        z = arm.position  # the wheel turns about y: v = rate y × z, a = second y × z − rate² z
        across = np.array([z[2], 0.0, -z[0]])
        np.testing.assert_allclose(arm.velocity, rate * across, rtol=0, atol=1e-10)
        np.testing.assert_allclose(
            arm.acceleration, second * across - rate**2 * z, rtol=0, atol=1e-8
        )


def test_a_blow_changes_velocities_as_the_loops_allow() -> None:
    """M Δv − p is a force of the loops, and Δv keeps them closed (Pars 1965, sect. 14.3)."""
    mechanism = textbook.load("four_bar_linkage")
    reference = Reference(mechanism)
    q = mq.assemble(mechanism, textbook.entry("four_bar_linkage").start)
    push = np.arange(1.0, mechanism.nv + 1)
    change = reference.response(q, 0.0, push)
    assert reference.closed is not None
    J = reference.closed.closures.at(q, np.zeros(mechanism.nv), 0.0).jacobian
    np.testing.assert_allclose(J @ change, 0.0, rtol=0, atol=1e-14)
    left = null_space(J).T @ (reference.mass_matrix(q) @ change - push)
    np.testing.assert_allclose(left, 0.0, rtol=0, atol=1e-14)
    assert push @ change > 0


def test_held_coordinates_hold_the_velocities_of_their_own_joint() -> None:
    hinge = Revolute("hinge", "ground", "arm", axis=(0, 0, 1))
    free, knuckle = Floating("free", "arm", "brick"), Spherical("knuckle", "brick", "tip")
    bodies = tuple(Body(name, box(1, (1, 2, 3))) for name in ("ground", "arm", "brick", "tip"))
    mechanism = Mechanism("hand", bodies, (hinge, free, knuckle))
    for names, velocities in (
        (hinge.coordinates, hinge.velocities),
        (free.coordinates[1:2], free.velocities[:3]),
        (free.coordinates[4:5], free.velocities[3:]),
        (knuckle.coordinates[:1], knuckle.velocities),
    ):
        held = held_columns(mechanism, names)
        assert {mechanism.velocities[k] for k in np.flatnonzero(held)} == set(velocities)


def test_quaternions_of_any_length_are_one_position() -> None:
    """An integration lets their length drift."""
    chart = EngineTree(follower(Spherical("free", "ground", "brick"))).chart
    q = np.array([0.1, -0.5, 0.7, 0.5])
    for length in (1.0, 0.5, 3.0):
        chart.place(length * q, 0.0)
        at = next(to for to, _ in chart._quaternions)
        np.testing.assert_allclose(chart.p[at : at + 4], q, rtol=1e-15, atol=0)
