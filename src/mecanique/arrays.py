"""The array of floating-point numbers that every room means, and what is asked of it everywhere."""

from __future__ import annotations

from typing import TypeAlias

import numpy as np
import numpy.typing as npt

Array: TypeAlias = npt.NDArray[np.float64]
Flags: TypeAlias = npt.NDArray[np.bool_]


def median(values: npt.ArrayLike) -> float:
    """Return the median of numbers; NumPy's own imports masked arrays, which takes longer."""
    ordered = np.sort(np.asarray(values, dtype=float), axis=None)
    half = len(ordered) // 2
    return float((ordered[half] + ordered[~half]) / 2)


def spread(length: int, most: int) -> npt.NDArray[np.intp]:
    """Return at most so many places along a length, evenly, the first and the last among them."""
    return np.linspace(0, length - 1, min(most, length)).astype(int)


def rank_of(sizes: np.ndarray, part: float) -> int:
    """Return how many singular values, which descend, exceed a part of the largest."""
    return int((sizes > part * sizes[0]).sum()) if sizes.size else 0


def cross(a: Array, b: Array) -> Array:
    """Return a × b, shapes (…, 3); NumPy's own takes several times as long for one vector."""
    ax, ay, az = a[..., 0], a[..., 1], a[..., 2]
    bx, by, bz = b[..., 0], b[..., 1], b[..., 2]
    x = ay * bz - az * by
    product = np.empty((*x.shape, 3), dtype=x.dtype)  # a step of derivatives may be complex
    product[..., 0] = x
    product[..., 1] = az * bx - ax * bz
    product[..., 2] = ax * by - ay * bx
    return product
