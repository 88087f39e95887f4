"""Mass, center of mass and inertia of a link as its mass moments, and back."""

from __future__ import annotations

import numpy as np

from mecanique.arrays import Array


def parts_of(J: Array) -> tuple[float, Array, Array]:
    """Return mass, center of mass and inertia about it."""
    m = float(J[3, 3])
    c = J[:3, 3] / m if m else np.zeros(3)
    second = J[:3, :3] - m * np.outer(c, c)
    return m, c, np.trace(second) * np.eye(3) - second


def moments_of(m: float, c: Array, inertia: Array) -> Array:
    """Return the mass moments ∫ (p, 1)(p, 1)ᵀ dm, shape (4, 4)."""
    J = np.empty((4, 4))
    J[:3, :3] = np.trace(inertia) / 2 * np.eye(3) - inertia + m * np.outer(c, c)
    J[:3, 3] = J[3, :3] = m * c
    J[3, 3] = m
    return J
