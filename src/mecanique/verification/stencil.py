"""Derivatives by central differences of eighth order (Fornberg, Math. Comp. 51, 1988, table 1)."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

WEIGHTS = np.array([4 / 5, -1 / 5, 4 / 105, -1 / 280])
"""Weights of f(x + k h) − f(x − k h), k = 1…4."""

_FINE, _COARSE = [0, 1, 2, 3], [1, 3, 4, 5]
"""Where the multiples of h and of 2 h stand among 1, 2, 3, 4, 6 and 8."""

_Function = Callable[[np.ndarray], np.ndarray]
"""Gives f at many x, shape (m, count), as shape (m, any)."""


def differences(function: _Function, count: int, h: float | np.ndarray) -> np.ndarray:
    """Return ∂f_i/∂x_j at x = 0, to the eighth power of the step; function (m, count)."""
    steps = np.broadcast_to(h, count)
    slopes: np.ndarray = _weigh(_rises(function, steps, (1, 2, 3, 4))) / steps
    return slopes


def differences_twice(function: _Function, count: int, h: float) -> tuple[np.ndarray, np.ndarray]:
    """Return the matrix ∂f_i/∂x_j at x = 0 by steps of h and of 2 h, which share two of four."""
    # of steps h and 2 h, which share two of four
    rises = _rises(function, np.full(count, h), (1, 2, 3, 4, 6, 8))
    return _weigh(rises[:, _FINE]) / h, _weigh(rises[:, _COARSE]) / (2 * h)


def _rises(function: _Function, steps: np.ndarray, multiples: tuple[int, ...]) -> np.ndarray:
    """f(x + k h) − f(x − k h) along each variable, shape (count, k, any)."""
    count = len(steps)
    ahead = (np.diag(steps)[:, None, :] * np.array(multiples)[None, :, None]).reshape(-1, count)
    return (function(ahead) - function(-ahead)).reshape(count, len(multiples), -1)


def _weigh(rises: np.ndarray) -> np.ndarray:
    """The derivatives times the step, shape (any, count)."""
    return np.asarray(np.einsum("k,jki->ij", WEIGHTS, rises))
