"""Poses, twists, wrenches and inertias, with the linear part first, as in Pinocchio."""

from __future__ import annotations

import math
from typing import Any, final

import numpy as np

from mecanique.arrays import Array
from mecanique.reference.vectors import cross, hat


class _Pair:
    """Two vectors in one array, shape (6,)."""

    def __init__(self, vector: Array) -> None:
        self.vector = vector

    @property
    def linear(self) -> Array:
        """The first three components, as a view."""
        return self.vector[:3]

    @linear.setter
    def linear(self, value: Array) -> None:
        self.vector[:3] = value

    @property
    def angular(self) -> Array:
        """The last three components, as a view."""
        return self.vector[3:]

    @angular.setter
    def angular(self, value: Array) -> None:
        self.vector[3:] = value


@final
class Force(_Pair):
    """A wrench: force and moment about the origin."""

    def __init__(self, vector: Array, moment: Array | None = None) -> None:
        super().__init__(vector if moment is None else np.concatenate([vector, moment]))

    @staticmethod
    def Zero() -> Force:
        """Return the zero wrench."""
        return Force(np.zeros(6))

    def __add__(self, other: Force) -> Force:
        return Force(self.vector + other.vector)

    def __sub__(self, other: Force) -> Force:
        return Force(self.vector - other.vector)


@final
class Motion(_Pair):
    """A twist: velocity of the point at the origin, and angular velocity."""

    def cross(self, force: Force) -> Force:
        """Return the rate of a wrench that moves with this twist."""
        v, omega = self.linear, self.angular
        return Force(
            cross(omega, force.linear), cross(omega, force.angular) + cross(v, force.linear)
        )


@final
class Inertia:
    """Mass, center of mass, and moments of inertia about the center of mass."""

    # Mass [kg], lever to the center (3,) [m], moments about the center (3, 3) [kg·m²].
    # Shapes: inertia (3, 3)

    def __init__(self, mass: float, lever: Array, inertia: Array) -> None:
        self.mass, self.lever, self.inertia = mass, lever, inertia

    @staticmethod
    def Zero() -> Inertia:
        """Return zero inertia."""
        return Inertia(0.0, np.zeros(3), np.zeros((3, 3)))

    def __add__(self, other: Inertia) -> Inertia:
        mass = self.mass + other.mass
        if not mass:
            return Inertia(0.0, np.zeros(3), self.inertia + other.inertia)
        between = self.lever - other.lever
        steiner = (between @ between) * np.eye(3) - np.outer(between, between)
        return Inertia(
            mass,
            (self.mass * self.lever + other.mass * other.lever) / mass,
            self.inertia + other.inertia + self.mass * other.mass / mass * steiner,
        )

    def __mul__(self, motion: Motion) -> Force:
        """Return the momentum of a twist."""
        return Force(self.matrix() @ motion.vector)

    def matrix(self) -> Array:
        """Return the spatial inertia, shape (6, 6)."""
        m, lever = self.mass, hat(self.lever)
        M = np.zeros((6, 6))
        M[:3, :3] = m * np.eye(3)
        M[:3, 3:] = -m * lever
        M[3:, :3] = m * lever
        M[3:, 3:] = self.inertia - m * lever @ lever
        return M


@final
class SE3:
    """A pose, which maps coordinates of the inner frame to those of the outer one."""

    # Shapes: rotation (3, 3), translation (3,)

    def __init__(self, rotation: Array, translation: Array | None = None) -> None:
        if translation is None:
            rotation, translation = rotation[:3, :3].copy(), rotation[:3, 3].copy()
        self.rotation, self.translation = rotation, translation

    @property
    def homogeneous(self) -> Array:
        """The matrix, shape (4, 4)."""
        H = np.eye(4)
        H[:3, :3], H[:3, 3] = self.rotation, self.translation
        return H

    def copy(self) -> SE3:
        """Return a copy."""
        return SE3(self.rotation.copy(), self.translation.copy())

    def __mul__(self, inner: SE3) -> SE3:
        return SE3(self.rotation @ inner.rotation, self.act(inner.translation))

    def act(self, thing: Any) -> Any:
        """Transform a point, wrench or inertia from the inner frame to the outer one."""
        R, p = self.rotation, self.translation
        if isinstance(thing, Force):
            force = R @ thing.linear
            return Force(force, R @ thing.angular + cross(p, force))
        if isinstance(thing, Inertia):
            return Inertia(thing.mass, self.act(thing.lever), R @ thing.inertia @ R.T)
        return R @ thing + p

    def actInv(self, force: Force) -> Force:
        """Transform a wrench from the outer frame to the inner one."""
        R, p = self.rotation, self.translation
        return Force(R.T @ force.linear, R.T @ (force.angular - cross(p, force.linear)))

    def twist_inside(self) -> Array:
        """Return the matrix that transforms twists from the outer frame to the inner, (6, 6)."""
        R = self.rotation
        X = np.zeros((6, 6))
        X[:3, :3] = X[3:, 3:] = R.T
        X[:3, 3:] = -R.T @ hat(self.translation)
        return X


def log3(turn: Array) -> Array:
    """Return the rotation vector of a rotation, shape (3,)."""
    twice = np.array([turn[2, 1] - turn[1, 2], turn[0, 2] - turn[2, 0], turn[1, 0] - turn[0, 1]])
    sine, cosine = np.linalg.norm(twice) / 2, (np.trace(turn) - 1) / 2
    angle = math.atan2(sine, cosine)
    if sine > 1e-6:
        return np.asarray(twice * (angle / (2 * sine)))
    if cosine > 0:
        return np.asarray(twice / 2)
    # near half a turn the axis is the eigenvector of the symmetric part
    symmetric = (turn + np.eye(3)) / 2
    axis = symmetric[:, int(np.argmax(np.diag(symmetric)))]
    axis = axis / np.linalg.norm(axis)
    return np.asarray(angle * (axis if axis @ twice >= 0 else -axis))
