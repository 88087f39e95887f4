"""The array of floating-point numbers that every room means, its median, places along it."""

from __future__ import annotations

from typing import TypeAlias

import numpy as np
import numpy.typing as npt

Array: TypeAlias = npt.NDArray[np.float64]


def median(values: npt.ArrayLike) -> float:
    """Return the median of numbers; NumPy's own imports masked arrays, which takes longer."""
    ordered = np.sort(np.asarray(values, dtype=float), axis=None)
    half = len(ordered) // 2
    return float((ordered[half] + ordered[~half]) / 2)


def spread(length: int, most: int) -> npt.NDArray[np.intp]:
    """Return at most so many places along a length, evenly, the first and the last among them."""
    return np.linspace(0, length - 1, min(most, length)).astype(int)
