"""Compute the momenta and the center of mass of a tree, in one state at a time."""

from __future__ import annotations

from typing import final

import numpy as np

from mecanique.arrays import Array
from mecanique.reference.engine.package import engine_package
from mecanique.reference.engine.tree import Tree


@final
class Whole:
    """All moving bodies of a tree together; arguments must be finite and of correct shape.

    Args:
        tree: the tree inside Pinocchio.
    """

    def __init__(self, tree: Tree) -> None:
        self._pin = engine_package()
        self._tree = tree
        model, data = tree.engine.model, tree.engine.data
        self._joints = range(1, model.njoints)
        self._masses = np.array([model.inertias[joint].mass for joint in self._joints])
        levers = [model.inertias[joint].lever for joint in self._joints]
        self._levers = np.array(levers).reshape(-1, 3)
        # views of the engine's own memory
        self._turns = [data.oMi[joint].rotation for joint in self._joints]
        self._places = [data.oMi[joint].translation for joint in self._joints]
        self._twists = [data.v[joint].vector for joint in self._joints]
        self._rates = [data.a[joint].vector for joint in self._joints]

    def momentum(self, q: Array, v: Array, t: float) -> Array:
        """Return the linear momentum, the angular ones about origin and center, and the center.

        The result has shape (4, 3).
        """
        tree = self._tree
        tree.move(q, v, t)
        model, data = tree.engine.model, tree.engine.data
        total = self._pin.Force.Zero()
        for joint in self._joints:
            total += data.oMi[joint].act(model.inertias[joint] * data.v[joint])
        linear, angular, center = total.linear, total.angular, self._center()
        # np.cross takes three times as long for single vectors
        x, y, z = center.tolist()
        px, py, pz = linear.tolist()
        orbital = np.array((y * pz - z * py, z * px - x * pz, x * py - y * px))
        return np.array([linear, angular, angular - orbital, center])

    def center(self, q: Array, v: Array, t: float, a: Array) -> Array:
        """Return position, velocity, acceleration of the moving bodies' center, shape (3, 3)."""
        self._tree.move(q, v, t, a)
        twists, rates = (np.array(each).reshape(-1, 6) for each in (self._twists, self._rates))
        velocities = twists[:, :3] + np.cross(twists[:, 3:], self._levers)
        # from the spatial to the classical acceleration
        changes = (
            rates[:, :3]
            + np.cross(rates[:, 3:], self._levers)
            + np.cross(twists[:, 3:], velocities)
        )
        own = np.stack([self._levers, velocities, changes], axis=1)
        turned = np.einsum("jik,jrk->jri", np.array(self._turns).reshape(-1, 3, 3), own)
        turned[:, 0] += np.array(self._places).reshape(-1, 3)
        mean = self._masses @ turned.reshape(len(self._masses), 9)
        return np.asarray(mean).reshape(3, 3) / self._tree.moving_mass

    def _center(self) -> Array:
        """Return the center of mass at the engine's position, the origin without mass."""
        if not self._tree.moving_mass:
            return np.zeros(3)
        turned = np.array(self._turns) @ self._levers[:, :, None]
        centers = turned[:, :, 0] + np.array(self._places)
        return np.asarray(self._masses @ centers) / self._tree.moving_mass
