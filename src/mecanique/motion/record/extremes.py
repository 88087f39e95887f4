"""The largest value of a quantity along a motion, between its steps as well."""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from mecanique.motion.record.curve import Curve

CANDIDATES = 3
"""Highest local maxima at the nodes that are refined; another can only lead by chance."""

POINTS, ROUNDS = 9, 7
"""Points across a bracket, which which round narrows fourfold.

The value at a smooth maximum errs by the square of the bracket: 1e-8 of what it changes by between
two nodes.
"""


class Maxima(NamedTuple):
    """The largest values of some quantities."""

    values: np.ndarray  # shape (k,); NaN where a quantity is never known
    times: np.ndarray  # shape (k,), when they are reached [s]


def find_maxima(
    curve: Curve, quantities: Callable[[np.ndarray, np.ndarray, np.ndarray], np.ndarray]
) -> Maxima:
    """Return the largest values of quantities, shape (n, k), that are smooth between breaks."""

    def measure(times: np.ndarray) -> np.ndarray:
        state = curve(times)
        values = quantities(times, state.q, state.v)
        return np.where(np.isnan(values), -np.inf, values)

    # at a break the curve has the state after it; that before it is a rounding earlier
    before = np.nextafter(curve.t[curve.breaks[1:]], -np.inf)
    nodes = np.unique(np.concatenate([curve.t, (curve.t[1:] + curve.t[:-1]) / 2, before]))
    rows = measure(nodes)
    best, times = [], []
    for k, column in enumerate(rows.T):
        around = np.concatenate([[-np.inf], column, [-np.inf]])
        peaks = np.flatnonzero((column >= around[:-2]) & (column >= around[2:]))
        peaks = peaks[np.argsort(-column[peaks], kind="stable")][:CANDIDATES]
        low, high = nodes[(peaks - 1).clip(0)], nodes[(peaks + 1).clip(max=len(nodes) - 1)]
        tops, at = column[peaks], nodes[peaks]
        for _ in range(ROUNDS if len(nodes) > 1 else 0):
            grid = np.linspace(low, high, POINTS)
            values = measure(grid.ravel())[:, k].reshape(grid.shape)
            top = values.argmax(axis=0)
            which = np.arange(len(peaks))
            higher = values[top, which] > tops
            tops, at = (
                np.where(higher, values[top, which], tops),
                np.where(higher, grid[top, which], at),
            )
            width = (high - low) / (POINTS - 1)
            low, high = np.maximum(at - width, low), np.minimum(at + width, high)
        first = int(tops.argmax())
        best.append(float(tops[first]) if np.isfinite(tops[first]) else np.nan)
        times.append(float(at[first]) if np.isfinite(tops[first]) else np.nan)
    return Maxima(np.array(best), np.array(times))
