"""Multiply and rotate vectors, one or many, without the overhead of NumPy's own functions."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from mecanique.arrays import Array

_HAT = np.array(
    [[0.0, 0, 0, 0, 0, -1, 0, 1, 0], [0.0, 0, 1, 0, 0, 0, -1, 0, 0], [0.0, -1, 0, 1, 0, 0, 0, 0, 0]]
)
"""Maps a vector x to the nine entries of the matrix of x ×."""


def hat(vectors: Array) -> Array:
    """Return the matrix of x × for each vector x, shape (…, 3, 3)."""
    matrices: Array = (vectors @ _HAT).reshape(*vectors.shape, 3)
    return matrices


def rotate(turns: Array, vectors: Array) -> Array:
    """Return R x for matrices of shape (…, 3, 3) and vectors of shape (…, 3)."""
    rotated: Array = np.einsum("...ij,...j->...i", turns, vectors)
    return rotated


def rank_of(sizes: Array, part: float, least: float = 0.0) -> int:
    """Return how many singular values or pivots, which descend, exceed a part of the largest."""
    return int((sizes > max(part * sizes[0], least)).sum()) if sizes.size else 0


def turn_about(axis: Array, cos: npt.ArrayLike, sin: npt.ArrayLike) -> Array:
    """Return rotations about a unit vector, shape (…, 3, 3) (Rodrigues)."""
    K = hat(axis)
    c, s = (np.asarray(x)[..., None, None] for x in (cos, sin))
    turns: Array = np.eye(3) + s * K + (1 - c) * (K @ K)
    return turns


def turn_of(quaternion: Array) -> Array:
    """Return the rotation of a unit quaternion x, y, z, w, shape (3, 3)."""
    x, y, z, w = quaternion
    rows = [
        [1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
        [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
        [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)],
    ]
    return np.array(rows)
