"""Close loops by Newton's method from nearby states; `closing` does so from far away.

In coordinates of the tangent space at a position, the position with closed loops is a smooth
function of the displacement (Potra & Rheinboldt, Mech. Struct. Mach. 19 (1991) 1).
"""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple, TypeAlias

import numpy as np

from mecanique.arrays import Array
from mecanique.reference.loops.closed import Closed
from mecanique.reference.loops.metric import Metric
from mecanique.reference.loops.tolerances import EPSILON, EXACT

Least: TypeAlias = Callable[[Array, Array], Array]
"""Returns the least-squares solution of J x = gaps, for a scaled Jacobian and scaled gaps."""


class Tangent(NamedTuple):
    """The displacements among which to search: along + directions @ bend, in metric directions.

    Args:
        along: shape (nv,), a given displacement.
        directions: shape (nv, k), directions of the correction.
        bend: shape (k,), initial correction.
    """

    along: Array
    directions: Array
    bend: Array


class Landing(NamedTuple):
    """The result of Newton's method.

    Args:
        q: shape (nq,).
        bend: shape (k,), the correction in the tangent space; empty without one.
        jacobian: scaled Jacobian, in the directions of the tangent space if there is one.
        rates: shape (m,), scaled rates of the gaps.
        gap: the largest gap, in natural units.
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
    """Close the loops near q by a limited number of Newton's steps.

    Args:
        closed: the mechanism.
        q: shape (nq,).
        v: shape (nv,), for the rates of the gaps.
        t: time [s].
        metric: the metric of the state.
        least: solves for a step.
        tangent: displacements to search among; by default every step starts at the last position
            and may have any direction.
        near: gap below which stagnation ends the iteration.
        stagnant: a step stagnates if it leaves more than this part of the gap.
        sweeps: largest number of steps.
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
    # the rounding of large angles propagates along a chain
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
