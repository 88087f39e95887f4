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

MOST_PARTS = 100
"""Into which one interval is divided."""

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
        columns = integrand(curve.t, curve.q, curve.v).shape[1]
        return np.zeros((len(times), columns))
    begin, half = _parts(curve)
    coefficients = _coefficients(curve, integrand, begin, half)

    # over a whole part only P_0 = 1 has an integral
    whole = 2 * coefficients[:, 0] * half[:, None]
    before = np.zeros_like(whole)
    np.cumsum(whole[:-1], axis=0, out=before[1:])

    last = np.searchsorted(begin, times, side="right") - 1
    part = last.clip(0, len(begin) - 1)
    x = (times - begin[part]) / half[part] - 1
    inside = np.einsum("no,nok->nk", _legendre_integrals(x), coefficients[part])
    result: np.ndarray = before[part] + inside * half[part, None]
    return result


def _coefficients(
    curve: Curve, integrand: Integrand, begin: np.ndarray, half: np.ndarray
) -> np.ndarray:
    """Legendre coefficients of the integrand on each part, shape (parts, orders, k)."""
    nodes, weights = legendre.leggauss(POINTS)
    middle = begin + half
    t = (middle[:, None] + half[:, None] * nodes).ravel()
    state = curve(t)
    values = integrand(t, state.q, state.v).reshape(len(begin), POINTS, -1)
    # projected on the polynomials by the same quadrature
    norms = (2 * np.arange(POINTS) + 1) / 2
    polynomials = legendre.legvander(nodes, POINTS - 1).T
    project = norms[:, None] * polynomials * weights
    return np.asarray(np.einsum("op,ipk->iok", project, values))


def _legendre_integrals(x: np.ndarray) -> np.ndarray:
    """∫ from −1 to x of P_n: x + 1, then (P_{n+1} − P_{n−1}) / (2 n + 1), shape (n, orders)."""
    P = legendre.legvander(x, POINTS)
    orders = np.arange(1, POINTS)
    integrals = np.empty((len(x), POINTS))
    integrals[:, 0] = x + 1
    integrals[:, 1:] = (P[:, 2:] - P[:, :-2]) / (2 * orders + 1)
    return integrals


def _parts(curve: Curve) -> tuple[np.ndarray, np.ndarray]:
    """Return begin and half the length of each part of the motion that is integrated as one."""
    at = curve.intervals
    begin = curve.t[at]
    length = curve.t[at + 1] - begin
    rates = curve.rates.first(curve.q, curve.v)
    speed = np.abs(rates).max(axis=1, initial=0.0)
    distance = np.maximum(speed[at], speed[at + 1]) * length
    count = np.ceil(distance / FARTHEST).clip(1, MOST_PARTS).astype(int)
    part = np.repeat(length / count, count)
    # 0, 1 … count − 1 within each interval
    first = np.cumsum(count) - count
    number = np.arange(len(part)) - np.repeat(first, count)
    return np.repeat(begin, count) + number * part, part / 2
