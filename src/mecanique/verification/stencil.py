"""Derivatives by central differences of eighth order (Fornberg, Math. Comp. 51, 1988, table 1)."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

__all__ = ["differences"]

WEIGHTS = np.array([4 / 5, -1 / 5, 4 / 105, -1 / 280])
"""Weights of f(x + k h) − f(x − k h), k = 1…4."""


def differences(
    function: Callable[[np.ndarray], np.ndarray], count: int, h: float | np.ndarray
) -> np.ndarray:
    """Return the matrix ∂f_i/∂x_j at x = 0; its error goes with the eighth power of the step.

    Args:
        function: gives f at many x, shape (m, count), as shape (m, any).
        count: number of variables.
        h: the step, or one for each variable.
    """
    steps = np.broadcast_to(h, count)
    multiples = np.arange(1, len(WEIGHTS) + 1)
    ahead = (np.diag(steps)[:, None, :] * multiples[None, :, None]).reshape(-1, count)
    rise = (function(ahead) - function(-ahead)).reshape(count, len(WEIGHTS), -1)
    slopes: np.ndarray = np.einsum("k,jki->ij", WEIGHTS, rise) / steps
    return slopes
