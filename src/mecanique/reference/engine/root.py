"""A square root of the mass matrix: A with Aᵀ A = M, a row for every way a body can carry energy.

The rows are √m times the velocity of a body's center of mass, and the root of its inertia times its
angular velocity, per unit of each joint velocity. In a long chain the entries of M grow with the
square of its length, and what its loops leave of them cancels; A holds that part with the precision
of lengths, not of their squares.
"""

from __future__ import annotations

from typing import final

import numpy as np

from mecanique.reference.engine.answers import Array
from mecanique.reference.engine.load import Engine

__all__ = ["MassRoot"]


@final
class MassRoot:
    """The root of the mass matrix of a mechanism's tree."""

    def __init__(self, engine: Engine) -> None:
        model = engine.model
        self._data = engine.data
        inertias = [model.inertias[i] for i in range(model.njoints)]
        self._joints = [i for i in range(1, model.njoints) if inertias[i].mass > 0]
        count = len(self._joints)
        self._mass = np.sqrt([inertias[i].mass for i in self._joints]).reshape(count, 1, 1)
        levers = [inertias[i].lever for i in self._joints]
        self._centers = np.array(levers).reshape(count, 3, 1)
        roots = [_root(inertias[i].inertia) for i in self._joints]
        self._inertia = np.array(roots).reshape(count, 3, 3)
        carried = np.zeros((model.njoints, model.nv))
        for i in range(1, model.njoints):
            joint = model.joints[i]
            carried[i] = carried[model.parents[i]]
            carried[i, joint.idx_v : joint.idx_v + joint.nv] = 1.0
        self._carried = carried[self._joints][:, None, :]
        rotors = np.sqrt(np.asarray(model.armature))
        self._rotors = np.diag(rotors)[rotors > 0]

    def now(self) -> Array:
        """Return A, shape (k, nv), in the state whose joint Jacobians the engine last computed."""
        columns = self._data.J.reshape(6, -1)
        nv = columns.shape[1]
        poses = [self._data.oMi[i] for i in self._joints]
        turns = np.array([pose.rotation for pose in poses]).reshape(-1, 3, 3)
        places = np.array([pose.translation for pose in poses]).reshape(-1, 3, 1)
        x, y, z = (places + turns @ self._centers)[:, :, 0].T[:, :, None]
        (vx, vy, vz), (wx, wy, wz) = columns[:3], columns[3:]
        # the velocity of each center, v + ω × c
        parts = [vx + wy * z - wz * y, vy + wz * x - wx * z, vz + wx * y - wy * x]
        linear = self._mass * np.stack(parts, axis=1) * self._carried
        angular = self._inertia @ turns.transpose(0, 2, 1) @ columns[3:] * self._carried
        root: Array = np.concatenate(
            [linear.reshape(-1, nv), angular.reshape(-1, nv), self._rotors]
        )
        return root


def _root(inertia: Array) -> Array:
    """Return R with Rᵀ R = I."""
    principal, axes = np.linalg.eigh(inertia)
    root: Array = np.sqrt(np.maximum(principal, 0.0))[:, None] * axes.T
    return root
