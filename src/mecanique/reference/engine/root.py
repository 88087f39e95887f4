"""Compute a square root A of the mass matrix, Aᵀ A = M, with rows for bodies and rotors.

A body's rows are √m times the velocity of its center of mass, and the root of its inertia times its
angular velocity, per unit of each joint velocity. In a long chain the entries of M grow with the
square of its length and nearly cancel in the motions that loops allow; A keeps the precision of
lengths, not of their squares.
"""

from __future__ import annotations

from typing import final

import numpy as np

from mecanique.arrays import Array
from mecanique.reference.engine.load import Engine


@final
class MassRoot:
    """The root of the mass matrix of a mechanism's tree."""

    def __init__(self, engine: Engine) -> None:
        model = engine.model
        self._data = engine.data
        self._joints = [i for i in range(1, model.njoints) if model.inertias[i].mass > 0]
        inertias = [model.inertias[i] for i in self._joints]
        # reshaped so that empty arrays have three axes, too
        count = len(inertias)
        masses = np.array([one.mass for one in inertias])
        levers = np.array([one.lever for one in inertias])
        roots = np.array([_root(one.inertia) for one in inertias])
        self._mass = np.sqrt(masses).reshape(count, 1, 1)
        self._centers = levers.reshape(count, 3, 1)
        self._inertia = roots.reshape(count, 3, 3)
        carried = np.zeros((model.njoints, model.nv))
        for i in range(1, model.njoints):
            joint = model.joints[i]
            carried[i] = carried[model.parents[i]]
            carried[i, joint.idx_v : joint.idx_v + joint.nv] = 1.0
        self._carried = carried[self._joints][:, None, :]
        rotors = np.sqrt(np.asarray(model.armature))
        self._rotors = np.diag(rotors)[rotors > 0]

    def now(self) -> Array:
        """Return A, shape (k, nv), in the state of the joint Jacobians computed last."""
        columns = self._data.J.reshape(6, -1)
        v, omega = columns[:3], columns[3:]
        poses = [self._data.oMi[i] for i in self._joints]
        turns = np.array([pose.rotation for pose in poses]).reshape(-1, 3, 3)
        places = np.array([pose.translation for pose in poses]).reshape(-1, 3, 1)
        centers = places + turns @ self._centers
        # v + ω × c, written out: NumPy's own product is slow on arrays this small
        x, y, z = centers[:, :, 0].T[:, :, None]
        vx, vy, vz = v
        wx, wy, wz = omega
        parts = [
            vx + wy * z - wz * y,
            vy + wz * x - wx * z,
            vz + wx * y - wy * x,
        ]
        velocities = np.stack(parts, axis=1)
        spins = turns.transpose(0, 2, 1)
        linear = self._mass * velocities * self._carried
        angular = self._inertia @ spins @ omega * self._carried
        nv = columns.shape[1]
        rows = [linear.reshape(-1, nv), angular.reshape(-1, nv), self._rotors]
        root: Array = np.concatenate(rows)
        return root


def _root(inertia: Array) -> Array:
    """Return R with Rᵀ R = I."""
    principal, axes = np.linalg.eigh(inertia)
    root: Array = np.sqrt(np.maximum(principal, 0.0))[:, None] * axes.T
    return root
