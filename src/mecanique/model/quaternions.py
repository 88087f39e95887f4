"""Unit quaternions (x, y, z, w) and how they turn vectors, batched over a first axis."""

from __future__ import annotations

import numpy as np

from mecanique.arrays import cross


def multiply(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """Return the product a b of quaternions, shape (…, 4): turns by b, then by a."""
    r, s = a[..., :3], a[..., 3:]
    v, w = b[..., :3], b[..., 3:]
    vector = s * v + w * r + cross(r, v)
    scalar = s * w - (r * v).sum(-1, keepdims=True)
    return np.concatenate([vector, scalar], axis=-1)


def conjugate(q: np.ndarray) -> np.ndarray:
    """Return the quaternions that turn back, shape (…, 4)."""
    return np.asarray(q * np.array([-1.0, -1.0, -1.0, 1.0]))


def pure(vector: np.ndarray) -> np.ndarray:
    """Return vectors, shape (…, 3), as quaternions without a scalar part, shape (…, 4)."""
    return np.concatenate([vector, np.zeros((*vector.shape[:-1], 1))], axis=-1)


def turn(q: np.ndarray, vector: np.ndarray) -> np.ndarray:
    """Return vectors turned from a body's axes, shape (…, 3): v + 2 w (r × v) + 2 r × (r × v)."""
    r, w = q[..., :3], q[..., 3:]
    aside = 2 * cross(r, vector)
    return np.asarray(vector + w * aside + cross(r, aside))


def to_matrices(q: np.ndarray) -> np.ndarray:
    """Return the rotation matrices of quaternions, shape (…, 3, 3); columns are turned axes."""
    return np.swapaxes(turn(q[..., None, :], np.eye(3)), -1, -2)


def from_matrices(R: np.ndarray) -> np.ndarray:
    """Return the quaternions of rotation matrices, shape (…, 3, 3), as shape (…, 4).

    The products 4 q qᵀ of a quaternion's entries are sums of those of the matrix; the row that is
    divided by the largest entry is the most accurate (S. W. Shepperd, J. Guidance and Control 1
    (1978) 223).
    """
    (a, b, c), (d, e, f), (g, h, i) = np.moveaxis(R, (-2, -1), (0, 1))
    products = np.array(
        [
            [1 + a - e - i, b + d, c + g, h - f],
            [b + d, 1 - a + e - i, f + h, c - g],
            [c + g, f + h, 1 - a - e + i, d - b],
            [h - f, c - g, d - b, 1 + a + e + i],
        ]
    )
    largest = np.diagonal(products).argmax(axis=-1)
    row = np.take_along_axis(np.moveaxis(products, (0, 1), (-2, -1)), largest[..., None, None], -2)
    q = row[..., 0, :]
    return np.asarray(q / np.linalg.norm(q, axis=-1, keepdims=True))
