"""Multiply vectors without NumPy's overhead for three numbers."""

from __future__ import annotations

import numpy as np

from mecanique.arrays import Array

_HAT = np.array(
    [[0.0, 0, 0, 0, 0, -1, 0, 1, 0], [0.0, 0, 1, 0, 0, 0, -1, 0, 0], [0.0, -1, 0, 1, 0, 0, 0, 0, 0]]
)
"""Maps a vector x to the nine entries of the matrix of x ×."""


def hat(vectors: Array) -> Array:
    """Return the matrix of x × for each vector x, shape (…, 3, 3)."""
    matrices: Array = (vectors @ _HAT).reshape(*vectors.shape, 3)
    return matrices


def cross(a: Array, b: Array) -> Array:
    """Return a × b, shape (3,) each."""
    ax, ay, az = a
    bx, by, bz = b
    return np.array([ay * bz - az * by, az * bx - ax * bz, ax * by - ay * bx])
