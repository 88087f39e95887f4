"""Unit quaternions (x, y, z, w) and how they turn vectors, batched over a first axis."""

from __future__ import annotations

import numpy as np

__all__ = ["conjugate", "multiply", "pure", "turn"]


def multiply(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """Return the product a b of quaternions, shape (…, 4): turns by b, then by a."""
    r, s, v, w = a[..., :3], a[..., 3:], b[..., :3], b[..., 3:]
    return np.concatenate(
        [s * v + w * r + np.cross(r, v), s * w - (r * v).sum(-1, keepdims=True)], axis=-1
    )


def conjugate(q: np.ndarray) -> np.ndarray:
    """Return the quaternions that turn back, shape (…, 4)."""
    return np.asarray(q * np.array([-1.0, -1.0, -1.0, 1.0]))


def pure(vector: np.ndarray) -> np.ndarray:
    """Return vectors, shape (…, 3), as quaternions without a scalar part, shape (…, 4)."""
    return np.concatenate([vector, np.zeros((*vector.shape[:-1], 1))], axis=-1)


def turn(q: np.ndarray, vector: np.ndarray) -> np.ndarray:
    """Return vectors turned from a body's axes, shape (…, 3): v + 2 w (r × v) + 2 r × (r × v)."""
    r, w = q[..., :3], q[..., 3:]
    cross = 2 * np.cross(r, vector)
    return np.asarray(vector + w * cross + np.cross(r, cross))
