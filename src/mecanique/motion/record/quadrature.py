"""Integrals along a motion, by Gauss–Legendre quadrature between the integrator's steps."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.polynomial import legendre

from mecanique.motion.record.curve import Curve

__all__ = ["POINTS", "Integrand", "integral"]

POINTS = 8
"""Gauss points per interval: exact to degree 15 at the interval's end, to degree 7 inside."""

FARTHEST = 0.5
"""Intervals in which a coordinate moves farther [rad or m] are divided.

Steps are long where q(t) is simple, but forces depend on q in other ways.
"""

Integrand = Callable[[np.ndarray, np.ndarray, np.ndarray], np.ndarray]
"""Values, shape (n, k), at times (n,), positions (n, nq) and velocities (n, nv)."""


def integral(curve: Curve, integrand: Integrand, times: np.ndarray) -> np.ndarray:
    """Return the integral from the motion's start to each time, shape (n, k).

    Args:
        curve: the motion.
        integrand: what to integrate.
        times: shape (n,), within the motion [s].
    """
    if len(curve.t) < 2:
        return np.zeros((len(times), integrand(curve.t, curve.q, curve.v).shape[1]))
    begin, half = _parts(curve)
    nodes, weights = legendre.leggauss(POINTS)
    t = (begin + half)[:, None] + half[:, None] * nodes
    state = curve(t.ravel())
    values = integrand(t.ravel(), state.q, state.v)
    values = values.reshape(len(begin), POINTS, -1)
    # Legendre coefficients by the same quadrature, then integrated from −1
    orders = np.arange(POINTS)
    basis = legendre.legvander(nodes, POINTS - 1)
    project = ((2 * orders + 1) / 2)[:, None] * basis.T * weights
    coefficients = np.einsum("op,ipk->iok", project, values)
    total = 2 * coefficients[:, 0] * half[:, None]
    before = np.concatenate([np.zeros((1, total.shape[1])), np.cumsum(total, axis=0)])
    piece = (np.searchsorted(begin, times, side="right") - 1).clip(0, len(begin) - 1)
    x = (times - begin[piece]) / half[piece] - 1
    raised = legendre.legvander(x, POINTS)
    inside = np.empty((len(times), POINTS))
    inside[:, 0] = x + 1
    # ∫ from −1 to x of P_n = (P_{n+1} − P_{n−1}) / (2 n + 1)
    inside[:, 1:] = (raised[:, 2:] - raised[:, : POINTS - 1]) / (2 * orders[1:] + 1)
    part = np.einsum("no,nok->nk", inside, coefficients[piece]) * half[piece, None]
    result: np.ndarray = before[piece] + part
    return result


def _parts(curve: Curve) -> tuple[np.ndarray, np.ndarray]:
    """Return begin and half the length of each part of the motion that is integrated as one."""
    at = curve.intervals
    begin, length = curve.t[at], curve.t[at + 1] - curve.t[at]
    speed = np.abs(curve.rates.first(curve.q, curve.v)).max(axis=1, initial=0.0)
    distance = np.maximum(speed[at], speed[at + 1]) * length
    count = np.ceil(distance / FARTHEST).clip(1, 100).astype(int)
    index = np.repeat(np.arange(len(at)), count)
    within = np.arange(len(index)) - np.repeat(np.cumsum(count) - count, count)
    part = (length / count)[index]
    return begin[index] + within * part, part / 2
