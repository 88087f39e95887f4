"""The right-hand side of closed mechanisms for integrators that pass singular positions.

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
from typing import NamedTuple, final

import numpy as np

from mecanique.arrays import Array
from mecanique.errors import EngineError
from mecanique.reference.engine.rhs import Rhs
from mecanique.reference.loops.assembly.newton import Landing, Tangent, displace, newton
from mecanique.reference.loops.closed import Closed
from mecanique.reference.loops.metric import Metric
from mecanique.reference.loops.nullspace import split
from mecanique.reference.loops.tolerances import WEAK

__all__ = ["branch_acceleration", "closed_rhs", "is_crossing", "plain_rhs"]

_BENT = 1e-5
"""What the acceleration of a branch may miss of J a + γ = 0, relative to γ."""

_NEAR, _FAR = 0.3, 0.6
"""Distances from a singular position, in characteristic lengths or radians.

States nearer than the first are brought onto the loops, those farther than the second are not.
"""

_NEXT = 0.01
"""Distance below which accelerations are interpolated."""

_APART, _SIDE = 0.025, 8
"""Distance between the states of the interpolation, and how many lie on each side."""

_WEIGHTS = tuple(
    (-1) ** (k + 1) * factorial(_SIDE) ** 2 / (factorial(_SIDE - k) * factorial(_SIDE + k))
    for k in range(1, _SIDE + 1)
)
"""Weights of the states on each side, by Lagrange's formula."""

_PROBE = 1e-4
"""How far ahead the Jacobian is evaluated again, to see how its least singular value changes."""

_SWEEPS = 12

_LANDING = 1e-11
"""Gap below which the last sweeps of Newton's method only stir the rounding."""


def closed_rhs(closed: Closed) -> Rhs:
    """Return f(t, y) = y' for a mechanism with loops."""
    return _ClosedRhs(closed)


def plain_rhs(closed: Closed) -> Rhs:
    """Return f(t, y) = y' for constraints without singular positions to pass."""
    nq = closed.mechanism.nq
    return lambda t, y: np.concatenate(_slope(closed, _State(y[:nq], y[nq:], t)))


def is_crossing(closed: Closed, q: Array, v: Array, t: float) -> bool:
    """Return whether branches of the motion cross in a position, as its constraints lose rank.

    Args:
        closed: the mechanism, with the rank of its constraints if that is known.
        q: shape (nq,), with closed loops.
        v: shape (nv,).
        t: time [s].
    """
    if closed.most is None or not closed.mechanism.loops:
        return False
    jacobian = closed.closures.at(q, v, t).jacobian
    return split(closed.measure(jacobian).scale(jacobian)).rank < closed.most


def branch_acceleration(closed: Closed, q: Array, v: Array, t: float) -> Array:
    """Return the acceleration, in a singular position that of the branch which the motion takes.

    Args:
        closed: the mechanism, with the rank of its constraints.
        q: shape (nq,), with closed loops.
        v: shape (nv,).
        t: time [s].

    Raises:
        EngineError: in a singular position at rest, or where no motion goes that way.
    """
    plain = closed.acceleration(q, v, t)
    if not is_crossing(closed, q, v, t):
        return plain
    state = _State(q, v, t)
    closure = closed.closures.at(q, v, t)
    way = _find_way(closed, state)
    found = _interpolate(closed, way, state) if way.along.any() else None
    if found is None or not _fits(closure.jacobian @ found, closure.gamma):
        moving = (
            "no motion goes on with" if v.any() else "nothing decides which of them it takes at"
        )
        raise EngineError(
            f"mechanism {closed.mechanism.name!r}: branches of its motion cross in the singular "
            f"position q = {q.tolist()}, and {moving} v = {v.tolist()}; give it a velocity along "
            "one of them, or move it a little"
        )
    return found


def _fits(curved: Array, gamma: Array) -> bool:
    """Return whether J a + γ = 0 holds, as it does along a branch only."""
    return float(np.abs(curved + gamma).max()) <= _BENT * float(np.abs(gamma).max(initial=1.0))


class _State(NamedTuple):
    q: Array
    v: Array
    t: float


class _Slope(NamedTuple):
    """q' and v'."""

    rates: Array
    acceleration: Array


class _Way(NamedTuple):
    """How a mechanism moves on within its loops, and the directions that the loops close.

    Args:
        along: shape (nv,), its largest component one in plain units; zero at rest.
        left: shape (m, rank), singular vectors of J.
        right: shape (nv, rank), the directions that are closed; among the hardly closed ones, those
            that the motion does not take.
        singular: shape (rank,), singular values of J.
        metric: the scale of all of these.
    """

    along: Array
    left: Array
    right: Array
    singular: Array
    metric: Metric


class _Regular(NamedTuple):
    """A neighborhood of a position, without any singular position near it."""

    q: Array
    radius: float

    def holds(self, q: Array) -> bool:
        return bool(np.abs(q - self.q).max(initial=0.0) < self.radius)


@final
class _ClosedRhs:
    """f(t, y) = y'; it remembers where it need not look for singular positions."""

    def __init__(self, closed: Closed) -> None:
        self._closed = closed
        self._nq = closed.mechanism.nq
        self._unit = min(1.0, closed.closures.length)
        self._regular = _Regular(np.full(self._nq, np.inf), 0.0)

    def __call__(self, t: float, y: Array) -> Array:
        state = _State(y[: self._nq], y[self._nq :], t)
        slope = _slope(self._closed, state)
        if not self._regular.holds(state.q):
            way = _find_way(self._closed, state)
            distance = _distance(self._closed, way, state)
            radius = min(distance - _FAR, _FAR) / 2 * self._unit
            self._regular = _Regular(state.q.copy(), radius)
            slope = _pass(self._closed, state, slope, way, distance)
        return np.concatenate(slope)


def _pass(closed: Closed, state: _State, slope: _Slope, way: _Way, distance: float) -> _Slope:
    """Return the slope, corrected for the distance to a singular position."""
    if distance < _NEXT:
        acceleration = _interpolate(closed, way, state)
        if acceleration is not None:
            return _Slope(slope.rates, acceleration)
    if distance >= _FAR:
        return slope
    here, straight = np.zeros_like(state.v), np.zeros(way.right.shape[1])
    landing = _land(closed, state, way, Tangent(here, way.right, straight))
    if landing is None:
        return slope
    closest = _slope(closed, _State(landing.q, _velocity_on(state, way, landing), state.t))
    far = _smooth_step((distance - _NEAR) / (_FAR - _NEAR))
    return _Slope(
        far * slope.rates + (1 - far) * closest.rates,
        far * slope.acceleration + (1 - far) * closest.acceleration,
    )


def _slope(closed: Closed, state: _State) -> _Slope:
    q, v, t = state
    return _Slope(closed.rates(q, v), closed.solve(q, v, t, weak=WEAK).acceleration)


def _smooth_step(x: float) -> float:
    """Rise from 0 at x = 0 to 1 at x = 1, with two continuous derivatives.

    A sudden change would be a kink to the integrator.
    """
    x = max(0.0, x)
    return x**3 * (10 - 15 * x + 6 * x**2)


def _find_way(closed: Closed, state: _State) -> _Way:
    """Return how it moves on.

    Directions that are hardly closed count as free, except those that the motion does not take.
    """
    q, v, t = state
    jacobian = closed.closures.at(q, v, t).jacobian
    metric = closed.measure(jacobian)
    J = metric.scale(jacobian)
    parts = split(J, fixed=closed.most)
    weak = parts.singular < WEAK
    free = np.hstack([parts.range_right[:, weak], parts.null])
    along = free @ (free.T @ (metric.inverse @ v))
    right = parts.range_right
    if weak.any() and along.any():
        across = free - np.outer(along, along @ free) / (along @ along)
        basis = np.linalg.svd(across)[0][:, : free.shape[1] - 1]
        most_closed = basis @ np.linalg.svd(J @ basis)[2].T
        right = np.hstack([right[:, ~weak], most_closed[:, : int(weak.sum())]])
    fastest = float(np.abs(metric.columns @ along / metric.units.columns).max(initial=0.0))
    if fastest:
        along = along / fastest
    return _Way(along, parts.range_left, right, parts.singular, metric)


def _distance(closed: Closed, way: _Way, state: _State) -> float:
    """Return how far along the way the least singular value vanishes, to first order."""
    if not way.along.any() or not way.singular.size:
        return np.inf
    if way.singular[-1] <= WEAK:
        return 0.0
    q, v, t = state
    ahead = displace(closed, q, way.metric.columns @ way.along * _PROBE)
    J = way.metric.scale(closed.closures.at(ahead, v, t).jacobian)
    least = float(way.singular[-1])
    change = float(way.left[:, -1] @ J @ way.right[:, -1]) - least
    return abs(least * _PROBE / change) if change else np.inf


def _interpolate(closed: Closed, way: _Way, state: _State) -> Array | None:
    """Return the acceleration between states before and behind; None if there are none.

    They have the same velocity along the way.
    """
    acceleration: Array = np.zeros_like(state.v)
    for side in (1, -1):
        bend: Array = np.zeros(way.right.shape[1])
        last = bend
        for k, weight in enumerate(_WEIGHTS, 1):
            guess = Tangent(side * k * _APART * way.along, way.right, 2 * bend - last)
            landing = _land(closed, state, way, guess)
            if landing is None:
                return None
            last, bend = bend, landing.bend
            v = _velocity_on(state, way, landing)
            acceleration += weight * closed.solve(landing.q, v, state.t).acceleration
    return acceleration


def _land(closed: Closed, state: _State, way: _Way, tangent: Tangent) -> Landing | None:
    """Return the position on the loops within the tangent space; None if there is none."""
    q, v, t = state
    landing = newton(
        closed,
        q,
        v,
        t,
        way.metric,
        _least_squares,
        tangent=tangent,
        near=_LANDING,
        stagnant=0.3,
        sweeps=_SWEEPS,
    )
    return landing if landing.gap < landing.rounding else None


def _velocity_on(state: _State, way: _Way, landing: Landing) -> Array:
    """Return the velocity on the loops that is the same along the way."""
    turn = _least_squares(landing.jacobian, landing.rates)
    velocity: Array = state.v - way.metric.columns @ (way.right @ turn)
    return velocity


def _least_squares(J: Array, gaps: Array) -> Array:
    return np.asarray(np.linalg.lstsq(J, gaps, rcond=None)[0], dtype=float)
