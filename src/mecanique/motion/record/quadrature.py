"""Integrals along a motion, by Gauss–Legendre quadrature between the integrator's steps."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.polynomial import legendre

from mecanique.motion.record.curve import Curve

POINTS = 6
"""Gauss points per part: exact to degree 11 at the part's end, to degree 5 inside."""

RESOLVED = 1e-4
"""A part is halved where its last two Legendre coefficients are larger than this, of the first two.

Coefficients fall geometrically: the error at the part's end is about the cube of their ratio.
"""

_HALVINGS = 7
"""How often a part is halved at most."""

_FLOOR, _SMALL = 1e-3, 1e-6
"""Coefficients are compared with this part of the largest in their column, and of all at least."""

Integrand = Callable[[np.ndarray, np.ndarray, np.ndarray], np.ndarray]
"""Values, shape (n, k), at times (n,), positions (n, nq) and velocities (n, nv)."""


def integral(
    curve: Curve,
    integrand: Integrand,
    times: np.ndarray,
    smooth: int | None = None,
    negligible: np.ndarray | float = 0.0,
) -> np.ndarray:
    """Return the integral from the motion's start to each time [s], shape (n, k)."""
    if len(curve.t) < 2:
        columns = integrand(curve.t, curve.q, curve.v).shape[1]
        return np.zeros((len(times), columns))
    begin, half, coefficients = _resolve(curve, integrand, smooth, negligible)

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


def _resolve(
    curve: Curve, integrand: Integrand, smooth: int | None, negligible: np.ndarray | float
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Begin, half the length and coefficients of parts in which the integrand is resolved.

    The first parts are the integrator's steps: these are long where q(t) is simple, but forces may
    depend on q in other ways.
    """
    at = curve.intervals
    begin, half = curve.t[at], (curve.t[at + 1] - curve.t[at]) / 2
    coefficients = _coefficients(curve, integrand, begin, half)
    largest = np.abs(coefficients[:, :2, :smooth]).max(axis=(0, 1), initial=0.0)
    floor = np.maximum(_FLOOR * largest, _SMALL * largest.max(initial=0.0))
    before = np.full(coefficients[:, 0, :smooth].shape, np.inf)
    done = []
    for _ in range(_HALVINGS):
        last = np.abs(coefficients[:, -2:, :smooth]).max(axis=1)
        first = np.abs(coefficients[:, :2, :smooth]).max(axis=1)
        # what halving does not lessen is rounding, or a jump
        fine = np.maximum(RESOLVED * np.maximum(first, floor), negligible)
        coarse = ((last > fine) & (last < before / 2)).any(axis=1)
        if not coarse.any():
            break
        done.append((begin[~coarse], half[~coarse], coefficients[~coarse]))
        before = np.repeat(last[coarse], 2, axis=0)
        half = np.repeat(half[coarse] / 2, 2)
        begin = np.repeat(begin[coarse], 2)
        begin[1::2] += 2 * half[1::2]
        coefficients = _coefficients(curve, integrand, begin, half)
    done.append((begin, half, coefficients))
    begin, half, coefficients = (np.concatenate(parts) for parts in zip(*done, strict=True))
    order = np.argsort(begin, kind="stable")
    return begin[order], half[order], coefficients[order]
