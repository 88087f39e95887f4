"""Newton's method onto the loops, from states next to them; `assembly` leads there from far away.

In coordinates of the tangent space at a position, the point on the loops is a smooth function of
the displacement (Potra & Rheinboldt, Mech. Struct. Mach. 19 (1991) 1).
"""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple, TypeAlias

import numpy as np

from mecanique.arrays import Array
from mecanique.reference.loops.closed import Closed
from mecanique.reference.loops.metric import Metric
from mecanique.reference.loops.tolerances import EPSILON, EXACT

__all__ = ["Landing", "Tangent", "displace", "newton"]

Least: TypeAlias = Callable[[Array, Array], Array]
"""The least x with J x = gaps, as far as J reaches, from a scaled Jacobian and scaled gaps."""


class Tangent(NamedTuple):
    """Where to look for a point on the loops: displaced by along + directions @ bend.

    All are in directions of the metric.

    Args:
        along: shape (nv,).
        directions: shape (nv, k).
        bend: shape (k,), where to begin.
    """

    along: Array
    directions: Array
    bend: Array


class Landing(NamedTuple):
    """Where Newton's method ended.

    Args:
        q: shape (nq,).
        bend: shape (k,), within the tangent space; empty without one.
        jacobian: scaled, by the directions of the tangent space if there is one.
        rates: shape (m,), scaled rates of the gaps.
        gap: the largest one, in plain units.
        rounding: the gap that rounding leaves there.
    """

    q: Array
    bend: Array
    jacobian: Array
    rates: Array
    gap: float
    rounding: float


def newton(
    closed: Closed,
    q: Array,
    v: Array,
    t: float,
    metric: Metric,
    least: Least,
    *,
    tangent: Tangent | None = None,
    near: float = np.inf,
    stagnant: float,
    sweeps: int,
) -> Landing:
    """Return a position next to q at which the loops are closed, as far as some sweeps get there.

    Args:
        closed: the mechanism.
        q: shape (nq,).
        v: shape (nv,), for the rates of the gaps.
        t: time [s].
        metric: the scale of the state.
        least: solves for a step.
        tangent: the part of the tangent space at q to stay in; without it every step is taken from
            the last position, in any direction.
        near: gap below which a sweep may be the last.
        stagnant: it is, if it leaves more than this part of the gap.
        sweeps: the most steps.
    """
    bend = np.zeros(0) if tangent is None else tangent.bend
    there = q if tangent is None else _within(closed, q, metric, tangent, bend)
    gap = np.inf
    for _ in range(sweeps):
        closure = closed.closures.at(there, v, t)
        J = metric.scale(closure.jacobian)
        if tangent is not None:
            J = J @ tangent.directions
        last, gap = gap, float(np.abs(metric.units.rows * closure.residual).max(initial=0.0))
        if gap < EXACT or (gap < near and gap > stagnant * last):
            break
        held = closed.closures.positional
        step = -least(J[held], (metric.rows * closure.residual)[held])
        if tangent is None:
            there = displace(closed, there, metric.columns @ step)
        else:
            bend = bend + step
            there = _within(closed, q, metric, tangent, bend)
    rates = metric.rows * (closure.jacobian @ v + closure.drift)
    # angles of several turns are rounded too, and all that follows in a chain with each
    moved = metric.units.rows * (np.abs(closure.jacobian) @ closed.sizes(there))
    rounding = closed.closures.rounding() + EPSILON * float(moved.max(initial=0.0))
    return Landing(there, bend, J, rates, gap, rounding)


def displace(closed: Closed, q: Array, step: Array) -> Array:
    """Return positions displaced along velocities, to first order, with unit quaternions.

    Args:
        closed: the mechanism.
        q: shape (nq,).
        step: shape (nv,), a velocity times a short time.
    """
    result: Array = q + closed.rates(q, step)
    for _, at in closed.mechanism.quaternions:
        result[at] /= np.linalg.norm(result[at])
    return result


def _within(closed: Closed, q: Array, metric: Metric, tangent: Tangent, bend: Array) -> Array:
    return displace(closed, q, metric.columns @ (tangent.along + tangent.directions @ bend))
