"""Compute many states of a motion at once, and check some of them against the reference."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np

from mecanique.motion.tolerances import SUMS

ASKED = 24
"""At so many states the reference is asked as well."""


Parts = Sequence[np.ndarray]
"""Arrays whose first axis has a row for each state, and whose numbers have one unit each."""


def spread(count: int) -> np.ndarray:
    """Return the indices of at most `ASKED` of so many states, the first and last among them."""
    return np.unique(np.linspace(0, count - 1, min(ASKED, count)).astype(int))


def agrees(quick: np.ndarray, right: np.ndarray, most: float) -> bool:
    """Return whether all numbers are within `most` of the right ones; one that is NaN is not."""
    return bool(np.abs(quick - right).max(initial=0.0) <= most)


def spot_check(quick: Callable[[], Parts], ask: Callable[[np.ndarray], Parts], count: int) -> Parts:
    """Return the quick values if the reference agrees at some states, or the reference's at all."""
    everywhere = np.arange(count)
    if count <= ASKED:
        return ask(everywhere)
    with np.errstate(all="ignore"):
        quick_parts = quick()
    asked = spread(count)
    for values, right in zip(quick_parts, ask(asked), strict=True):
        most = SUMS * float(np.abs(right).max(initial=0.0))
        if not agrees(values[asked], right, most):
            return ask(everywhere)
    return quick_parts
