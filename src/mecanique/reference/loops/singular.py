"""The right-hand side of a closed mechanism's equations, for integrators that pass singular positions.

Where two branches of a linkage's motion cross, singular values σ of its Jacobian J vanish. The
motion along a branch is smooth, but what J a + γ = 0 says of the acceleration carries errors of
position and velocity in proportion to 1/σ, and rounding in proportion to 1/σ². So near such a
position the state that an integrator tries is brought onto the loops first, which also keeps the
equations from being stiff; and next to it the acceleration is interpolated along the way, between
states on the loops that lie far enough on both sides. These are found in coordinates of the tangent
space (Potra & Rheinboldt, Mech. Struct. Mach. 19 (1991) 1).
"""

from __future__ import annotations

from math import factorial
from typing import NamedTuple

import numpy as np

from mecanique.reference.engine.answers import Array
from mecanique.reference.engine.rhs import Rhs
from mecanique.reference.loops.assembly import moved
from mecanique.reference.loops.closed import WEAK, Closed
from mecanique.reference.loops.nullspace import split

__all__ = ["closed_rhs"]

_NEAR, _FAR = 0.3, 0.6
"""Distances, in characteristic lengths or radians, between which bringing states onto the loops sets in."""

_NEXT = 0.01
"""Distance at which accelerations are interpolated."""

_APART, _SIDE = 0.025, 8
"""How far apart the states are between which they are interpolated, and how many lie on each side."""

_WEIGHTS = tuple(
    (-1) ** (k + 1) * factorial(_SIDE) ** 2 / (factorial(_SIDE - k) * factorial(_SIDE + k))
    for k in range(1, _SIDE + 1)
)
"""Weights of the states on each side, by Lagrange's formula."""

_PROBE = 1e-4
"""How far along the way the Jacobian is looked at again, to see how its singular value changes."""

_SWEEPS = 12
_CLOSED = 1e-14
"""Loops this near to closed, in characteristic lengths or radians, are closed there."""


def closed_rhs(closed: Closed) -> Rhs:
    """Return f(t, y) = y' for a mechanism with loops.

    Args:
        closed: the mechanism.
    """
    nq, size = closed.mechanism.nq, closed.mechanism.nq + closed.mechanism.nv
    unit = min(1.0, closed.closures.length)
    regular, reach = (
        np.full(nq, np.inf),
        0.0,
    )  # a position, and how far around it there are no singular ones

    def rhs(t: float, y: Array) -> Array:
        nonlocal regular, reach
        q, v = y[:nq], y[nq:]
        rates, a = closed.rates(q, v), closed.solve(q, v, t, weak=WEAK).acceleration
        if not np.abs(q - regular).max(initial=0.0) < reach:
            way = _way(closed, q, v, t)
            distance = _distance(closed, way, q, v, t)
            regular, reach = q.copy(), min(distance - _FAR, _FAR) / 2 * unit
            between = _interpolated(closed, way, q, v, t) if distance < _NEXT else None
            if between is not None:
                a = between
            elif distance < _FAR:
                x = max(0.0, (distance - _NEAR) / (_FAR - _NEAR))
                share = x**3 * (
                    10 - 15 * x + 6 * x**2
                )  # a sudden change would be a kink to the integrator
                found = _on_loops(
                    closed, q, v, t, np.zeros_like(v), way.right, np.zeros(way.right.shape[1])
                )
                if found is not None:
                    q, v, _ = found
                    near = closed.solve(q, v, t, weak=WEAK).acceleration
                    rates, a = (
                        share * rates + (1 - share) * closed.rates(q, v),
                        share * a + (1 - share) * near,
                    )
        out = np.empty(size)
        out[:nq] = rates
        out[nq:] = a
        return out

    return rhs


class _Way(NamedTuple):
    """How a mechanism moves on: the direction within the loops, zero at rest, and what J closes.

    Args:
        along: shape (nv,), scaled, its largest component one.
        left: shape (m, rank), singular vectors.
        right: shape (nv, rank), singular vectors; among the hardly held ones, those the motion does
            not take.
        singular: shape (rank,), singular values.
    """

    along: Array
    left: Array
    right: Array
    singular: Array


def _way(closed: Closed, q: Array, v: Array, t: float) -> _Way:
    """How it moves on; directions that are hardly held count as free, but for those the motion does not take."""
    J = _scaled(closed, q, v, t)
    parts = split(J, fixed=closed.most)
    weak = parts.singular < WEAK * parts.singular.max(initial=0.0)
    free = np.hstack([parts.range_right[:, weak], parts.null])
    along = free @ (free.T @ (v / closed.closures.columns))
    fastest = float(np.abs(along).max(initial=0.0))
    right = parts.range_right
    if weak.any() and fastest:
        rest = free - np.outer(along, along @ free) / (along @ along)
        basis = np.linalg.svd(rest)[0][:, : free.shape[1] - 1]
        most_held = basis @ np.linalg.svd(J @ basis)[2].T
        right = np.hstack([right[:, ~weak], most_held[:, : int(weak.sum())]])
    return _Way(along / fastest if fastest else along, parts.range_left, right, parts.singular)


def _scaled(closed: Closed, q: Array, v: Array, t: float) -> Array:
    closures = closed.closures
    scaled: Array = closures.rows[:, None] * closures.at(q, v, t).jacobian * closures.columns
    return scaled


def _distance(closed: Closed, way: _Way, q: Array, v: Array, t: float) -> float:
    """How far it is along the way to where the least singular value vanishes, to first order."""
    if not way.along.any() or not way.singular.size:
        return np.inf
    if way.singular[-1] <= WEAK * way.singular[0]:
        return 0.0
    least, ahead = (
        float(way.singular[-1]),
        moved(closed, q, closed.closures.columns * way.along * _PROBE),
    )
    change = float(way.left[:, -1] @ _scaled(closed, ahead, v, t) @ way.right[:, -1]) - least
    return abs(least * _PROBE / change) if change else np.inf


def _interpolated(closed: Closed, way: _Way, q: Array, v: Array, t: float) -> Array | None:
    """The acceleration from states before and behind, with the same velocity along the way; None if there are none."""
    right, a = way.right, np.zeros_like(v)
    for side in (1, -1):
        bend = np.zeros(right.shape[1])
        last = bend
        for k, weight in enumerate(_WEIGHTS, 1):
            found = _on_loops(
                closed, q, v, t, side * k * _APART * way.along, right, 2 * bend - last
            )
            if found is None:
                return None
            there, velocity, (last, bend) = found[0], found[1], (bend, found[2])
            a += weight * closed.solve(there, velocity, t).acceleration
    return a


def _on_loops(
    closed: Closed, q: Array, v: Array, t: float, step: Array, right: Array, bend: Array
) -> tuple[Array, Array, Array] | None:
    """The state on the loops that lies a step away within the tangent space, and how far off it."""
    closures = closed.closures
    rows, columns = closures.rows, closures.columns
    for _ in range(_SWEEPS):
        there = moved(closed, q, columns * (step + right @ bend))
        closure = closures.at(there, v, t)
        J = rows[:, None] * closure.jacobian * columns @ right
        off = rows * closure.residual
        if float(np.abs(off).max()) < _CLOSED:
            turn = np.linalg.lstsq(J, rows * (closure.jacobian @ v + closure.drift), rcond=None)[0]
            return there, v - columns * (right @ turn), bend
        bend = bend - np.linalg.lstsq(J, off, rcond=None)[0]
    return None
