"""A tree's bodies in many states at once: energies, momenta, speeds, and external resultants.

The engine answers one state at a time, each with Python's cost. Here the same tree moves in all
states together, in world axes; the engine is what this is held to.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any, final

import numpy as np

from mecanique.arrays import Array
from mecanique.reference.engine.chart import Chart
from mecanique.reference.engine.forces.sites import Site
from mecanique.reference.engine.tree import EngineTree


@final
@dataclass
class _Frames:
    """How a joint's frame moves, world axes, n states."""

    turn: Array  # shape (n, 3, 3)
    place: Array  # shape (n, 3)
    velocity: Array  # of its origin, shape (n, 3)
    change: Array  # acceleration of its origin, shape (n, 3)
    spin: Array  # angular velocity, shape (n, 3)
    spin_up: Array  # angular acceleration, shape (n, 3)


@final
@dataclass
class _Drive:
    """How the joints move, n states."""

    p: Array  # the engine's positions, shape (n, engine's nq)
    u: Array  # its velocities, shape (n, engine's nv)
    rate: Array  # its accelerations, shape (n, engine's nv)
    values: Array  # q, then the driven joint coordinates, shape (n, k)


def resultants(tree: EngineTree, q: Array, v: Array, t: Array, a: Array) -> Array:
    """Return force and moment about the origin from outside, and the center, shape (n, 3, 3)."""
    # They are what changes the momenta of the bodies: F = Σ m a_c, M = Σ (c × m a_c + I α + ω × I
    # ω) (Newton, Euler)
    force, moment, first = (np.zeros((len(q), 3)) for _ in range(3))
    for inertia, frame in _massive(tree, _frames(tree, _drive(tree.chart, q, v, t, a))):
        arm = frame.turn @ inertia.lever
        center = frame.place + arm
        swing = _cross(frame.spin, arm)
        change = frame.change + _cross(frame.spin_up, arm) + _cross(frame.spin, swing)
        push = inertia.mass * change
        force += push
        first += inertia.mass * center
        back = frame.turn.transpose(0, 2, 1)
        spin, spin_up = _apply(back, frame.spin), _apply(back, frame.spin_up)
        about_center = spin_up @ inertia.inertia + _cross(spin, spin @ inertia.inertia)
        moment += _cross(center, push) + _apply(frame.turn, about_center)
    mass = tree.moving_mass
    return np.stack([force, moment, first / mass if mass else first], axis=1)


def momenta(tree: EngineTree, q: Array, v: Array, t: Array) -> Array:
    """Return linear momentum, angular about the origin and about the center, shape (n, 3, 3)."""
    # p = Σ m v_c, L = Σ (c × m v_c + I ω), and L − c̄ × p about the center of mass c̄ of all
    linear, angular, first = (np.zeros((len(q), 3)) for _ in range(3))
    for inertia, frame in _massive(tree, _frames(tree, _drive(tree.chart, q, v, t, 0 * v))):
        arm = frame.turn @ inertia.lever
        center = frame.place + arm
        push = inertia.mass * (frame.velocity + _cross(frame.spin, arm))
        spin = _apply(frame.turn.transpose(0, 2, 1), frame.spin)
        linear += push
        angular += _cross(center, push) + _apply(frame.turn, spin @ inertia.inertia)
        first += inertia.mass * center
    mass = tree.moving_mass
    orbital = _cross(first / mass if mass else first, linear)
    return np.stack([linear, angular, angular - orbital], axis=1)


def energies(tree: EngineTree, q: Array, v: Array, t: Array) -> Array:
    """Return T, V of gravity and V of the springs, shape (n, 3), as `EngineTree.energy` for one."""
    drive = _drive(tree.chart, q, v, t, np.zeros_like(v))
    frames = _frames(tree, drive)
    kinetic = drive.u**2 @ tree.engine.model.armature / 2
    height = np.full(len(q), tree.resting)
    for inertia, frame in _massive(tree, frames):
        arm = frame.turn @ inertia.lever
        velocity = frame.velocity + _cross(frame.spin, arm)
        spin = _apply(frame.turn.transpose(0, 2, 1), frame.spin)
        kinetic += inertia.mass / 2 * (velocity**2).sum(axis=1)
        kinetic += np.sum(spin @ inertia.inertia * spin, axis=1) / 2
        height -= inertia.mass * (frame.place + arm) @ tree.engine.model.gravity.linear

    def position(site: Site) -> Array:
        frame = frames[site.axes.joint]
        return np.asarray(frame.place + frame.turn @ np.array(site.point))

    return np.stack([kinetic, height, tree.loads.energy(drive.values, t, position)], axis=1)


def _massive(tree: EngineTree, frames: list[_Frames]) -> Iterator[tuple[Any, _Frames]]:
    """The inertias that move, each with its frame."""
    for inertia, frame in zip(list(tree.engine.model.inertias)[1:], frames[1:], strict=True):
        if inertia.mass or inertia.inertia.any():
            yield inertia, frame


def center_speeds(tree: EngineTree, q: Array, v: Array, t: Array) -> Array:
    """Return the speeds of all bodies' centers of mass, in the bodies' order, shape (n, nb)."""
    frames = _frames(tree, _drive(tree.chart, q, v, t, np.zeros_like(v)))
    holders = [tree.engine.holders[body.name] for body in tree.mechanism.bodies]
    speeds = np.empty((len(q), len(holders)))
    for k, holder in enumerate(holders):
        frame = frames[holder.joint]
        swing = _cross(frame.spin, frame.turn @ holder.inertia.lever)
        speeds[:, k] = np.linalg.norm(frame.velocity + swing, axis=1)
    return speeds


def _frames(tree: EngineTree, drive: _Drive) -> list[_Frames]:
    """How the frames of all joints move, the world's first."""
    model = tree.engine.model
    still = np.zeros((len(drive.p), 3))
    frames = [_Frames(np.broadcast_to(np.eye(3), (len(still), 3, 3)), *([still] * 5))]
    for k in range(1, model.njoints):
        frames.append(_move(tree, k, frames[model.parents[k]], drive))
    return frames


def _drive(chart: Chart, q: Array, v: Array, t: Array, a: Array) -> _Drive:
    """How the joints move, one row for each state."""
    p, values = chart.place_many(q, t)
    return _Drive(p, *chart.move_many(q, v, t, a), values)


def _move(tree: EngineTree, k: int, parent: _Frames, drive: _Drive) -> _Frames:
    """How the frame of a joint moves, as its parent's does and as the joint adds to it."""
    model = tree.engine.model
    joint, seat = model.joints[k], model.jointPlacements[k]
    base = parent.turn @ seat.rotation
    at_v = slice(joint.idx_v, joint.idx_v + joint.nv)
    p, speeds, changes = drive.p, drive.u[:, at_v], drive.rate[:, at_v]
    arm = parent.turn @ seat.translation
    if joint.nv == 1:
        motion = np.array(tree.engine.data.joints[k].S).reshape(6)
        along, about = base @ motion[:3], base @ motion[3:]
        if motion[3:].any():
            turn = base @ _turns(motion[3:], p[:, joint.idx_q : joint.idx_q + joint.nq])
        else:
            turn = base
            arm = arm + along * p[:, joint.idx_q, None]
        velocity, spin = along * speeds, about * speeds
        change, spin_up = along * changes, about * changes
    else:
        x, y, z, w = p[:, joint.idx_q + 3 : joint.idx_q + 7].T
        turn = base @ _turn_of(x, y, z, w)
        arm = arm + _apply(base, p[:, joint.idx_q : joint.idx_q + 3])
        velocity, spin = _apply(turn, speeds[:, :3]), _apply(turn, speeds[:, 3:])
        spin_up = _apply(turn, changes[:, 3:])
        change = _apply(turn, changes[:, :3]) + _cross(spin, velocity)
    swing = _cross(parent.spin, arm)
    return _Frames(
        turn,
        parent.place + arm,
        parent.velocity + swing + velocity,
        parent.change
        + _cross(parent.spin_up, arm)
        + _cross(parent.spin, swing)
        + 2 * _cross(parent.spin, velocity)
        + change,
        parent.spin + spin,
        parent.spin_up + _cross(parent.spin, spin) + spin_up,
    )


def _turns(axis: Array, position: Array) -> Array:
    """Rotations about an axis, by angle or by cosine and sine (Rodrigues), shape (n, 3, 3)."""
    if position.shape[1] == 2:
        cos, sin = position.T
    else:
        cos, sin = np.cos(position[:, 0]), np.sin(position[:, 0])
    x, y, z = axis
    K = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
    turns: Array = np.eye(3) + sin[:, None, None] * K + (1 - cos)[:, None, None] * (K @ K)
    return turns


def _turn_of(x: Array, y: Array, z: Array, w: Array) -> Array:
    """Rotations by unit quaternions, shape (n, 3, 3)."""
    rows = [
        [1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
        [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
        [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)],
    ]
    return np.moveaxis(np.array(rows), 2, 0)


def _apply(turn: Array, vector: Array) -> Array:
    return np.asarray((turn @ vector[:, :, None])[:, :, 0])


def _cross(a: Array, b: Array) -> Array:
    """A × b, a third of the time of `np.cross`."""
    product = np.empty(np.broadcast_shapes(a.shape, b.shape))
    product[:, 0] = a[:, 1] * b[:, 2] - a[:, 2] * b[:, 1]
    product[:, 1] = a[:, 2] * b[:, 0] - a[:, 0] * b[:, 2]
    product[:, 2] = a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0]
    return product
