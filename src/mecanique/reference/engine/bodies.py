"""How bodies move in one state or many, and sums over them: momenta, energies, resultants.

The engine answers one state at a time, each with Python's cost. `move_frames` moves the same tree
in all states together; the engine is what this is held to. The sums take the frames of either.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import Any, NamedTuple

import numpy as np

from mecanique.arrays import Array
from mecanique.reference.engine.answers import (
    BodyMotions,
    Energy,
    Momentum,
    PointMotion,
    Resultant,
)
from mecanique.reference.engine.forces.sites import Site
from mecanique.reference.engine.tree import EngineTree
from mecanique.reference.vectors import cross, rotate, turn_about, turn_of


class Frame(NamedTuple):
    """How the frame of a joint moves, world axes, in one state or in n."""

    turn: Array  # shape (3, 3) or (n, 3, 3)
    place: Array  # shape (3,) or (n, 3), as the rest
    velocity: Array  # of its origin
    change: Array  # acceleration of its origin
    spin: Array  # angular velocity
    spin_up: Array  # angular acceleration

    def position_of(self, point: Array) -> Array:
        """Return the place of a point of the frame, shape (3,) in it."""
        position: Array = self.place + self.turn @ point
        return position

    def velocity_of(self, point: Array) -> Array:
        """Return the velocity of a point of the frame."""
        return self.velocity + cross(self.spin, self.turn @ point)

    def motion_of(self, point: Array) -> PointMotion:
        """Return position, velocity and acceleration of a point of the frame."""
        arm = self.turn @ point
        swing = cross(self.spin, arm)
        change = self.change + cross(self.spin_up, arm) + cross(self.spin, swing)
        return PointMotion(self.place + arm, self.velocity + swing, change)


def read_frames(rows: Array) -> list[Frame]:
    """Return the frames of all joints by what `EngineTree.carry` answers, shape (…, nj, 24)."""
    turns, place, velocity, omega, change, alpha = np.split(rows, (9, 12, 15, 18, 21), axis=-1)
    turns = turns.reshape(*turns.shape[:-1], 3, 3)
    # from the spatial to the classical acceleration
    vectors = (velocity, change + np.cross(omega, velocity), omega, alpha)
    parts = np.stack([place, *np.moveaxis(turns @ np.stack(vectors, axis=-1), -1, 0)])
    return [Frame(turns[..., k, :, :], *parts[..., k, :]) for k in range(rows.shape[-2])]


def move_frames(tree: EngineTree, q: Array, v: Array, t: Array, a: Array) -> list[Frame]:
    """Return the frames of all joints, the world's first, in all states together."""
    return _move_all(tree, tree.chart.place_many(q, t)[0], *tree.chart.move_many(q, v, t, a))


def motions(tree: EngineTree, frames: list[Frame]) -> BodyMotions:
    """Return the motions of the mechanism's bodies."""
    holders = [tree.engine.holders[body.name] for body in tree.mechanism.bodies]
    shape = (*frames[0].place.shape[:-1], len(holders))
    poses, vectors = np.zeros((*shape, 4, 4)), np.empty((4, *shape, 3))
    poses[..., 3, 3] = 1.0
    for k, holder in enumerate(holders):
        frame = frames[holder.joint]
        place, velocity, change = frame.motion_of(holder.placement.translation)
        poses[..., k, :3, :3], poses[..., k, :3, 3] = frame.turn @ holder.placement.rotation, place
        vectors[..., k, :] = velocity, frame.spin, change, frame.spin_up
    return BodyMotions(poses, *vectors)


def momenta(tree: EngineTree, frames: list[Frame]) -> Momentum:
    """Return p = Σ m v_c and L = Σ (c × m v_c + I ω), about the origin and the common center."""
    linear, angular, first = (np.zeros_like(frames[0].place) for _ in range(3))
    for inertia, frame in massive(tree, frames):
        center = frame.position_of(inertia.lever)
        push = inertia.mass * frame.velocity_of(inertia.lever)
        spin = rotate(frame.turn.swapaxes(-1, -2), frame.spin)
        linear += push
        angular += cross(center, push) + rotate(frame.turn, spin @ inertia.inertia)
        first += inertia.mass * center
    return Momentum(linear, angular, angular - cross(first / (tree.moving_mass or 1.0), linear))


def resultants(tree: EngineTree, frames: list[Frame]) -> Resultant:
    """Return what changes the momenta, F = Σ m a_c and M = Σ (c × m a_c + I α + ω × I ω)."""
    force, moment, first = (np.zeros_like(frames[0].place) for _ in range(3))
    for inertia, frame in massive(tree, frames):
        center, _, change = frame.motion_of(inertia.lever)
        push = inertia.mass * change
        back = frame.turn.swapaxes(-1, -2)
        spin, spin_up = rotate(back, frame.spin), rotate(back, frame.spin_up)
        about_center = spin_up @ inertia.inertia + cross(spin, spin @ inertia.inertia)
        force += push
        moment += cross(center, push) + rotate(frame.turn, about_center)
        first += inertia.mass * center
    return Resultant(force, moment, first / (tree.moving_mass or 1.0))


def energies(tree: EngineTree, q: Array, v: Array, t: Array) -> Energy:
    """Return T, V of gravity and V of the springs in all states together."""
    p, values = tree.chart.place_many(q, t)
    u, rate = tree.chart.move_many(q, v, t, np.zeros_like(v))
    frames = _move_all(tree, p, u, rate)
    kinetic = u**2 @ tree.engine.model.armature / 2
    height = np.full(len(q), tree.resting)
    for inertia, frame in massive(tree, frames):
        velocity = frame.velocity_of(inertia.lever)
        spin = rotate(frame.turn.swapaxes(-1, -2), frame.spin)
        kinetic += inertia.mass / 2 * (velocity**2).sum(axis=1)
        kinetic += np.sum(spin @ inertia.inertia * spin, axis=1) / 2
        height -= inertia.mass * frame.position_of(inertia.lever) @ tree.engine.model.gravity.linear

    def position(site: Site) -> Array:
        return frames[site.axes.joint].position_of(np.array(site.point))

    return Energy(kinetic, height, tree.loads.energy(values, t, position))


def massive(tree: EngineTree, frames: list[Frame]) -> Iterator[tuple[Any, Frame]]:
    """The inertias that move, each with its frame."""
    for inertia, frame in zip(list(tree.engine.model.inertias)[1:], frames[1:], strict=True):
        if inertia.mass or inertia.inertia.any():
            yield inertia, frame


def _move_all(tree: EngineTree, p: Array, u: Array, rate: Array) -> list[Frame]:
    """Return the frames of all joints by the engine's positions, velocities and accelerations."""
    still = np.zeros((len(p), 3))
    frames = [Frame(np.broadcast_to(np.eye(3), (len(p), 3, 3)), *([still] * 5))]
    parents: Sequence[int] = tree.engine.model.parents
    for k in range(1, tree.engine.model.njoints):
        frames.append(_move(tree, k, frames[parents[k]], p, u, rate))
    return frames


def _move(tree: EngineTree, k: int, parent: Frame, p: Array, u: Array, rate: Array) -> Frame:
    """Return how the frame of a joint moves: as its parent's does, and as the joint adds to it."""
    joint, seat = tree.engine.model.joints[k], tree.engine.model.jointPlacements[k]
    at_v, at = slice(joint.idx_v, joint.idx_v + joint.nv), p[:, joint.idx_q :]
    # the directions of its velocities, in the axes of the frame
    S = np.array(tree.engine.data.joints[k].S).reshape(6, joint.nv)
    turn, arm = parent.turn @ seat.rotation, parent.turn @ seat.translation
    if joint.nv == 6:
        arm, turn = arm + rotate(turn, at[:, :3]), turn @ turn_of(at[:, 3:7])
    elif S[:3].any():
        arm = arm + turn @ S[:3, 0] * at[:, :1]
    elif joint.nq == 2:
        turn = turn @ turn_about(S[3:, 0], at[:, 0], at[:, 1])
    else:
        turn = turn @ turn_about(S[3:, 0], np.cos(at[:, 0]), np.sin(at[:, 0]))
    motion, motion_up = (x[:, at_v] @ S.T for x in (u, rate))
    (velocity, spin), (change, spin_up) = (
        (rotate(turn, x[:, :3]), rotate(turn, x[:, 3:])) for x in (motion, motion_up)
    )
    swing = cross(parent.spin, arm)
    return Frame(
        turn,
        parent.place + arm,
        parent.velocity + swing + velocity,
        parent.change
        + cross(parent.spin_up, arm)
        + cross(parent.spin, swing + 2 * velocity)
        + cross(spin, velocity)
        + change,
        parent.spin + spin,
        parent.spin_up + cross(parent.spin, spin) + spin_up,
    )
