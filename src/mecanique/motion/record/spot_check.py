"""Compute many states of a motion at once, and check some of them against the reference."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from mecanique.arrays import Array
from mecanique.motion.tolerances import SUMS

ASKED = 24
"""At so many states the reference is asked as well."""


def spread(count: int) -> np.ndarray:
    """Return the indices of at most `ASKED` of so many states, the first and last among them."""
    return np.unique(np.linspace(0, count - 1, min(ASKED, count)).astype(int))


def agrees(quick: np.ndarray, right: np.ndarray, most: float) -> bool:
    """Return whether all numbers are within `most` of the right ones; one that is NaN is not."""
    return bool(np.abs(quick - right).max(initial=0.0) <= most)


def spot_check(quick: Callable[[], Array], ask: Callable[[np.ndarray], Array], count: int) -> Array:
    """Return the quick values, by state, if the reference agrees at some; or its own at all."""
    everywhere = np.arange(count)
    with np.errstate(all="ignore"):
        values = quick()
    asked = spread(count)
    right = ask(asked)
    agreed = agrees(values[asked], right, SUMS * float(np.abs(right).max(initial=0.0)))
    return values if agreed else ask(everywhere)
