"""Coordinates and velocities of the reference against independent geometry; blows on loops."""

from __future__ import annotations

from collections.abc import Callable
from types import SimpleNamespace

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
    Planar,
    Revolute,
    Shape,
    Spherical,
    box,
    coordinate,
)
from mecanique.reference.engine.chart import turn
from mecanique.reference.engine.tree import EngineTree
from mecanique.reference.loops.assembly import held_columns
from mecanique.reference.originals import drake, exudyn, mujoco
from mecanique.reference.originals.original import Chart
from mecanique.reference.reference import Reference
from mecanique.verification.stencil import differences

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


@pytest.mark.parametrize("length", [1.0, 0.3, 2.7])
def test_a_quaternion_of_any_length_turns_alike(length: float) -> None:
    random = np.random.default_rng(2)
    turned, vector = Rotation.random(rng=random), random.normal(size=3)
    found = turn((length * turned.as_quat()).tolist(), vector.tolist())
    np.testing.assert_allclose(found, turned.apply(vector), rtol=1e-14, atol=0)


def test_quaternions_of_any_length_are_one_position() -> None:
    """An integration lets their length drift."""
    chart = EngineTree(follower(Spherical("free", "ground", "brick"))).chart
    q = np.array([0.1, -0.5, 0.7, 0.5])
    for length in (1.0, 0.5, 3.0):
        chart.place(length * q, 0.0)
        at = next(to for to, _ in chart._quaternions)
        np.testing.assert_allclose(chart.p[at : at + 4], q, rtol=1e-15, atol=0)


def swing(q: np.ndarray, v: np.ndarray, t: float) -> np.ndarray:
    """Where a body with a quaternion is next to a state, with its velocities in its own axes."""
    turned = Rotation.from_quat(q[-4:]) * Rotation.from_rotvec(v[-3:] * t)
    shifted = q[:-4] + (Rotation.from_quat(q[-4:]).apply(v[:3]) * t if len(q) == 7 else 0.0)
    return np.concatenate([shifted, turned.as_quat()])


@pytest.mark.parametrize(
    ("chart", "poses", "twists"),
    [
        (drake._free, lambda p: (p[4:], quaternion_w_first(p[:4])), "world"),
        (mujoco._free, lambda p: (p[:3], quaternion_w_first(p[3:])), "place in the world"),
        (exudyn._free, lambda p: (p[:3], Rotation.from_euler("XYZ", p[3:])), "rates"),
        (drake._ball, lambda p: (np.zeros(0), Rotation.from_euler("xyz", p)), "world"),
    ],
    ids=["drake free", "mujoco free", "exudyn free", "drake ball"],
)
def test_an_engine_counts_the_same_pose_and_the_same_motion(
    chart: Chart, poses: Callable[[np.ndarray], tuple[np.ndarray, Rotation]], twists: str
) -> None:
    """Its positions are the body's, its velocities u = T v of the flow, and Ṫ v the rate of u."""
    random = np.random.default_rng(3)
    for size in [3 if chart is drake._ball else 6] * 4:
        q = np.concatenate([random.normal(size=size - 3), Rotation.random(rng=random).as_quat()])
        v = random.normal(size=size)
        R, omega = Rotation.from_quat(q[-4:]), v[-3:]
        positions, T, drift = chart(q, v)
        place, turn = poses(positions)
        np.testing.assert_allclose(place, q[:-4], rtol=0, atol=1e-14)
        np.testing.assert_allclose((turn * R.inv()).magnitude(), 0, rtol=0, atol=1e-14)
        linear = R.apply(v[:3])[: size - 3]

        def along(number: int, q: np.ndarray = q, v: np.ndarray = v) -> np.ndarray:
            """The rates of positions, or of T v, as the body moves on."""

            def step(steps: np.ndarray) -> np.ndarray:
                answers = (chart(swing(q, v, t), v) for (t,) in steps)
                return np.array([a[0] if number == 0 else a[1] @ v for a in answers])

            return differences(step, 1, 1e-3)[:, 0]

        expected = {
            "world": np.concatenate([R.apply(omega), linear]),
            "place in the world": np.concatenate([linear, omega]),
            "rates": along(0)[: len(v)],
        }[twists]
        np.testing.assert_allclose(T @ v, expected, rtol=0, atol=1e-10)
        np.testing.assert_allclose(drift, along(1), rtol=0, atol=1e-9)


def quaternion_w_first(p: np.ndarray) -> Rotation:
    return Rotation.from_quat(p[[1, 2, 3, 0]])


@pytest.mark.parametrize("seed", range(4))
def test_a_point_of_a_slanted_plane_is_where_the_engine_has_it(seed: int) -> None:
    axes = Rotation.random(rng=np.random.default_rng(seed)).as_matrix()
    rotation = SimpleNamespace(matrix=lambda: axes)
    pose = SimpleNamespace(rotation=lambda: rotation)
    chart = drake._planar(SimpleNamespace(GetFixedPoseInBodyFrame=lambda: pose))
    x, y, z = axes[:, 2].tolist()
    ours = np.array(Planar("plane", "a", "b", axis=(x, y, z)).directions)
    q, v = np.random.default_rng(seed).normal(size=(2, 3))
    positions, T, drift = chart(q, v)
    np.testing.assert_allclose(axes[:, :2] @ positions[:2], q[:2] @ ours, rtol=0, atol=1e-14)
    np.testing.assert_allclose(axes[:, :2] @ (T @ v)[:2], v[:2] @ ours, rtol=0, atol=1e-14)
    assert (positions[2], (T @ v)[2], *drift) == (q[2], v[2], 0, 0, 0)
