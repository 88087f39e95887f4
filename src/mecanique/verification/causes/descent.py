"""Fit the few numbers of many changes at once, by Levenberg and Marquardt's method.

Source: D. W. Marquardt, SIAM J. Applied Mathematics 11 (1963) 431.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import TypeAlias

import numpy as np

from mecanique.arrays import Array

Residuals: TypeAlias = "Callable[[list[tuple[int, Array]]], Array]"
"""Residuals, shape (trials, N), of trials: a problem's number and its unknowns."""

_STEP = 1e-6
_ROUNDS = 20
_DONE = 1e-14
_SLOW = 1e-3
"""Problems that gain less than this part in a round are at their end."""

_GRACE = 4
"""Rounds after which only the best problems go on, if there are more than are wanted."""


def descend(
    residuals: Residuals, starts: Sequence[Array], most: int | None = None
) -> tuple[list[Array], Array]:
    """Return the unknowns of each problem at its least residual, and the residuals' norms.

    Args:
        residuals: evaluates many trials together.
        starts: unknowns to begin with, of order one, one array for each problem.
        most: how many problems go on after some rounds; all by default.
    """
    unknowns = [np.array(start, dtype=float) for start in starts]
    now = residuals(list(enumerate(unknowns)))
    cost = np.linalg.norm(now, axis=1)
    damping = np.full(len(unknowns), 1e-3)
    active = [k for k in range(len(unknowns)) if np.isfinite(cost[k])]
    for round_ in range(_ROUNDS):
        if round_ == _GRACE:
            active = sorted(active, key=lambda k: float(cost[k]))[:most]
        if not active:
            break
        slopes = _slopes(residuals, unknowns, now, active)
        trials = []
        for k, slope in zip(active, slopes, strict=True):
            normal = slope.T @ slope
            scale = np.diag(normal) + 1e-300
            lhs = normal + damping[k] * np.diag(scale)
            step = np.linalg.lstsq(lhs, -slope.T @ now[k], rcond=None)[0]
            trials.append((k, unknowns[k] + step))
        found = residuals(trials)
        sizes = np.linalg.norm(found, axis=1)
        going = []
        for (k, trial), rest, size in zip(trials, found, sizes, strict=True):
            if size < cost[k]:
                ended = cost[k] - size <= _SLOW * cost[k]
                unknowns[k], now[k], cost[k] = trial, rest, size
                damping[k] *= 0.03
            else:
                ended = damping[k] > 1e3
                damping[k] *= 30
            if not ended and cost[k] > _DONE:
                going.append(k)
        active = going
    return unknowns, cost


def _slopes(
    residuals: Residuals, unknowns: list[Array], now: Array, active: list[int]
) -> list[Array]:
    """Derivatives of the residuals of each active problem, shape (N, unknowns)."""
    trials = []
    for k in active:
        for at in range(len(unknowns[k])):
            moved = unknowns[k].copy()
            moved[at] += _STEP
            trials.append((k, moved))
    rises = iter(residuals(trials))
    slopes = []
    for k in active:
        columns = [(next(rises) - now[k]) / _STEP for _ in unknowns[k]]
        slopes.append(np.stack(columns, axis=1))
    return slopes
