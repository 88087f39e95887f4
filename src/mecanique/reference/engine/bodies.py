"""How bodies move in one state or many, and sums over them: momenta and resultants."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any, NamedTuple

import numpy as np

from mecanique.arrays import Array, cross
from mecanique.reference.engine.answers import (
    BodyMotions,
    Momentum,
    PointMotion,
    Resultant,
)
from mecanique.reference.engine.tree import EngineTree
from mecanique.reference.vectors import rotate


class MovingFrame(NamedTuple):
    """How the frame of a joint moves, world axes, in one state or in n."""

    turn: Array  # shape (3, 3) or (n, 3, 3)
    place: Array  # shape (3,) or (n, 3), as the rest
    velocity: Array  # of its origin
    change: Array  # acceleration of its origin
    spin: Array  # angular velocity
    spin_up: Array  # angular acceleration

    def velocity_of(self, point: Array) -> Array:
        """Return the velocity of a point of the frame."""
        return self.velocity + cross(self.spin, self.turn @ point)

    def motion_of(self, point: Array) -> PointMotion:
        """Return position, velocity and acceleration of a point of the frame."""
        arm = self.turn @ point
        swing = cross(self.spin, arm)
        change = self.change + cross(self.spin_up, arm) + cross(self.spin, swing)
        return PointMotion(self.place + arm, self.velocity + swing, change)


def read_frames(rows: Array) -> list[MovingFrame]:
    """Return the frames of all joints by what `EngineTree.carry` answers, shape (…, nj, 24)."""
    turns, place, velocity, omega, change, alpha = np.split(rows, (9, 12, 15, 18, 21), axis=-1)
    turns = turns.reshape(*turns.shape[:-1], 3, 3)
    # from the spatial to the classical acceleration
    vectors = (velocity, change + np.cross(omega, velocity), omega, alpha)
    parts = np.stack([place, *np.moveaxis(turns @ np.stack(vectors, axis=-1), -1, 0)])
    return [MovingFrame(turns[..., k, :, :], *parts[..., k, :]) for k in range(rows.shape[-2])]


def motions(tree: EngineTree, frames: list[MovingFrame]) -> BodyMotions:
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


def momenta(tree: EngineTree, frames: list[MovingFrame]) -> Momentum:
    """Return p = Σ m v_c and L = Σ (c × m v_c + I ω), about the origin and the common center."""
    linear, angular, first = (np.zeros_like(frames[0].place) for _ in range(3))
    for inertia, frame in massive(tree, frames):
        center = frame.place + frame.turn @ inertia.lever
        push = inertia.mass * frame.velocity_of(inertia.lever)
        spin = rotate(frame.turn.swapaxes(-1, -2), frame.spin)
        linear += push
        angular += cross(center, push) + rotate(frame.turn, spin @ inertia.inertia)
        first += inertia.mass * center
    return Momentum(linear, angular, angular - cross(first / (tree.moving_mass or 1.0), linear))


def resultants(tree: EngineTree, frames: list[MovingFrame]) -> Resultant:
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


def massive(tree: EngineTree, frames: list[MovingFrame]) -> Iterator[tuple[Any, MovingFrame]]:
    """The inertias that move, each with its frame."""
    for inertia, frame in zip(list(tree.engine.model.inertias)[1:], frames[1:], strict=True):
        if inertia.mass or inertia.inertia.any():
            yield inertia, frame
