"""The inertia tensor as a matrix and by its six entries, in URDF's order."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np

from mecanique.arrays import Array

_ROWS, _COLUMNS = (0, 1, 2, 0, 0, 1), (0, 1, 2, 1, 2, 2)


def tensor_of(entries: Iterable[float]) -> Array:
    """Return the inertia tensor, shape (3, 3) [kg·m²]."""
    ixx, iyy, izz, ixy, ixz, iyz = entries
    return np.array([[ixx, ixy, ixz], [ixy, iyy, iyz], [ixz, iyz, izz]], dtype=float)


def entries_of(tensor: Array) -> tuple[float, ...]:
    """Return ixx, iyy, izz, ixy, ixz, iyz of an inertia tensor; tensor (3, 3)."""
    return tuple(float(entry) for entry in tensor[_ROWS, _COLUMNS])


def moments_of(m: float, c: Array, inertia: Array) -> Array:
    """Return the mass moments ∫ (p, 1)(p, 1)ᵀ dm, shape (4, 4); c (3,), inertia (3, 3)."""
    J = np.empty((4, 4))
    J[:3, :3] = np.trace(inertia) / 2 * np.eye(3) - inertia + m * np.outer(c, c)
    J[:3, 3] = J[3, :3] = m * c
    J[3, 3] = m
    return J
