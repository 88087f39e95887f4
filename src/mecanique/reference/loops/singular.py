"""Compute the right-hand side of closed mechanisms so that integrators can pass singular positions.

Where two branches of a linkage's motion cross, singular values σ of its Jacobian J vanish. The
motion along a branch is smooth, but the acceleration from J a + γ = 0 amplifies errors of position
and velocity by 1/σ, and rounding by 1/σ². Near such a position the integrator's trial state is
therefore first projected on the loops, which also keeps the equations from becoming stiff; very
close to it the acceleration is interpolated along the path, between closed states far enough away
on both sides. These are found in coordinates of the tangent space (Potra & Rheinboldt, Mech.
Struct. Mach. 19 (1991) 1).

Next to a change point branches come near each other but do not cross: the motion turns sharply from
one into the other, and σ passes a small minimum. The position interpolated between the sides then
leaves the loops open, by as much as the mechanism differs from one whose branches cross. Through
such a turn the equations are integrated as they are.
"""

from __future__ import annotations

from functools import partial
from math import factorial
from typing import NamedTuple, final

import numpy as np

from mecanique.arrays import Array
from mecanique.errors import EngineError
from mecanique.model.mechanism_units import coordinate_scales
from mecanique.reference.engine.rhs import Rhs
from mecanique.reference.loops.assembly import NewtonResult, Tangent, displace, newton
from mecanique.reference.loops.closed import Closed
from mecanique.reference.loops.nullspace import Metric, split
from mecanique.reference.tolerances import BRANCH, EVIDENT, LANDED, TURNED, WEAK

_NEAR, _FAR = 0.3, 0.6
"""Distances from a singular position, in characteristic lengths or radians.

States nearer than the first are projected on the loops, those farther than the second are not.
"""

_NEXT = 0.01
"""Distance below which accelerations are interpolated."""

_JUDGED = 0.3
"""Distance ahead below which it is judged whether branches cross there."""

_AROUND, _UNDECIDED = 0.6, 0.05
"""Distances around the place ahead within which that is remembered, and if it cannot be judged."""

_APART, _SIDE = 0.025, 8
"""Distance between the states of the interpolation, and their number on each side."""

_WEIGHTS = tuple(
    (-1) ** (k + 1) * factorial(_SIDE) ** 2 / (factorial(_SIDE - k) * factorial(_SIDE + k))
    for k in range(1, _SIDE + 1)
)
"""Weights of the states on each side, by Lagrange's formula."""

_PROBE = 1e-4
"""Distance ahead at which the Jacobian is evaluated again, for the slope of its singular values."""

_SWEEPS = 12


def plain_rhs(closed: Closed) -> Rhs:
    """Return f(t, y) = y' for constraints without singular positions to pass."""
    nq = closed.mechanism.nq
    return lambda t, y: np.concatenate(_slope(closed, _State(y[:nq], y[nq:], t)))


def is_crossing(closed: Closed, q: Array, v: Array, t: float) -> bool:
    """Return whether branches of the motion cross here, where the constraints lose rank."""
    if closed.most is None or not closed.mechanism.loops:
        return False
    jacobian = closed.closures.at(q, v, t).jacobian
    metric = closed.measure(jacobian)
    return (
        split(metric.scale(jacobian), rounding=partial(metric.rounding, jacobian)).rank
        < closed.most
    )


def branch_acceleration(closed: Closed, q: Array, v: Array, t: float) -> Array:
    """Return the acceleration; in a singular position that of the branch the motion takes."""
    plain = closed.acceleration(q, v, t)
    if not is_crossing(closed, q, v, t):
        return plain
    state = _State(q, v, t)
    closure = closed.closures.at(q, v, t)
    way = _find_way(closed, state)
    along = _interpolate(closed, way, state) if way.along.any() else None
    if along is None or not _fits(closure.jacobian @ along, closure.gamma):
        moving = (
            "no branch continues with" if v.any() else "nothing decides which branch it takes at"
        )
        raise EngineError(
            f"mechanism {closed.mechanism.name!r}: branches of its motion cross in the singular "
            f"position q = {q.tolist()}, and {moving} v = {v.tolist()}; give it a velocity along "
            "a branch, or move it a little"
        )
    return along


def _fits(curved: Array, gamma: Array) -> bool:
    """Return whether J a + γ = 0 holds, which is so only along a branch."""
    return float(np.abs(curved + gamma).max()) <= BRANCH * float(np.abs(gamma).max(initial=1.0))


class _State(NamedTuple):
    q: Array
    v: Array
    t: float


class _Slope(NamedTuple):
    """q' and v'."""

    rates: Array
    acceleration: Array


class _Way(NamedTuple):
    """The direction in which a mechanism moves on, and the directions that its loops prevent."""

    along: Array  # shape (nv,), its largest component one in natural units; zero at rest
    left: Array  # shape (m, rank), singular vectors of J
    # shape (nv, rank), the prevented directions; of the weakly prevented ones, those that the
    # motion does not take
    right: Array
    singular: Array  # shape (rank,), singular values of J
    metric: Metric  # the metric of all of these


class _Neighborhood(NamedTuple):
    """The positions around one."""

    q: Array
    radius: float  # in natural units
    units: Array  # shape (nq,), those of the coordinates

    def holds(self, q: Array) -> bool:
        return bool(np.abs((q - self.q) / self.units).max(initial=0.0) < self.radius)


@final
class ClosedRhs:
    """f(t, y) = y' for a mechanism with loops."""

    # It remembers a neighborhood without singular positions, and one in which branches turn

    def __init__(self, closed: Closed) -> None:
        self._closed = closed
        self._nq = closed.mechanism.nq
        closures = closed.closures
        self._units = coordinate_scales(closed.mechanism, closures.columns, closures.length)
        nowhere = self._around(np.full(self._nq, np.inf), 0.0)
        self._regular = self._judged = self._undecided = nowhere
        self._turns = False

    def __call__(self, t: float, y: Array) -> Array:
        """Return the rates of a state."""
        state = _State(y[: self._nq], y[self._nq :], t)
        if self.turns_at(state.q):
            return self._plain(state)
        slope = _slope(self._closed, state)
        if not self._regular.holds(state.q):
            way = _find_way(self._closed, state)
            ahead = _distance(self._closed, way, state)
            distance = abs(ahead)
            self._regular = self._around(state.q, min(distance - _FAR, _FAR) / 2)
            if distance < _JUDGED and self._judge(state, way, ahead):
                return self._plain(state)
            slope = _pass(self._closed, state, slope, way, distance)
        return np.concatenate(slope)

    def _around(self, q: Array, radius: float) -> _Neighborhood:
        return _Neighborhood(q.copy(), radius, self._units)

    def turns_at(self, q: Array) -> bool:
        """Return whether branches are known to come near each other there, but not to cross."""
        return self._turns and self._judged.holds(q)

    def crosses_at(self, q: Array) -> bool:
        """Return whether branches are known to cross there."""
        return not self._turns and self._judged.holds(q)

    def _judge(self, state: _State, way: _Way, ahead: float) -> bool:
        """Return whether branches are found to turn; it is remembered around where they do."""
        if self._judged.holds(state.q) or self._undecided.holds(state.q):
            return False
        turns = _turns_ahead(self._closed, way, state, ahead)
        if turns is None:  # often a trial state far off; what is known stays so
            self._undecided = self._around(state.q, _UNDECIDED)
            return False
        there = displace(self._closed, state.q, way.metric.columns @ way.along * ahead)
        self._judged, self._turns = self._around(there, _AROUND), turns
        return turns

    def _plain(self, state: _State) -> Array:
        q, v, t = state
        return np.concatenate([self._closed.rates(q, v), self._closed.solve(q, v, t).acceleration])


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
    """Rise from 0 at x = 0 to 1 at x = 1, with two continuous derivatives."""
    # A sudden change would be a kink for the integrator
    x = max(0.0, x)
    return x**3 * (10 - 15 * x + 6 * x**2)


def _find_way(closed: Closed, state: _State) -> _Way:
    """Return how the mechanism moves on."""
    # Weakly prevented directions count as free, except those that the motion does not take
    q, v, t = state
    jacobian = closed.closures.at(q, v, t).jacobian
    metric = closed.measure(jacobian)
    J = metric.scale(jacobian)
    parts = split(J, fixed=closed.most, rounding=partial(metric.rounding, jacobian))
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
    """Estimate, to first order, how far ahead along the path a singular value vanishes."""
    if not way.along.any() or not way.singular.size:
        return np.inf
    if way.singular[-1] <= WEAK:
        return 0.0
    q, v, t = state
    ahead = displace(closed, q, way.metric.columns @ way.along * _PROBE)
    J = way.metric.scale(closed.closures.at(ahead, v, t).jacobian)
    least = float(way.singular[-1])
    change = float(way.left[:, -1] @ J @ way.right[:, -1]) - least
    return -least * _PROBE / change if change else np.inf


def _interpolate(closed: Closed, way: _Way, state: _State) -> Array | None:
    """Interpolate the acceleration between states ahead and behind; None if there are none."""
    # These have the same velocity along the path
    landings = _land_around(closed, way, state, 0.0, _APART)
    if landings is None:
        return None
    acceleration: Array = np.zeros_like(state.v)
    for weight, landing in zip(_WEIGHTS * 2, landings, strict=True):
        v = _velocity_on(state, way, landing)
        acceleration += weight * closed.solve(landing.q, v, state.t).acceleration
    return acceleration


def _turns_ahead(closed: Closed, way: _Way, state: _State, ahead: float) -> bool | None:
    """Return whether the branches that come near each other ahead do not cross; None if unknown."""
    gaps, rounding = [], 0.0
    for apart in (2 * _APART, _APART, _APART / 2):
        landings = _land_around(closed, way, state, ahead, apart)
        if landings is None:
            break  # nearer to the turn than this, loops cannot be closed on every side
        rounding = max(rounding, *(landing.rounding for landing in landings))
        bend = sum(w * landing.bend for w, landing in zip(_WEIGHTS * 2, landings, strict=True))
        there = way.metric.columns @ (ahead * way.along + way.right @ bend)
        middle = displace(closed, state.q, there)
        residual = closed.closures.at(middle, state.v, state.t).residual
        gaps.append(float(np.abs(way.metric.units.rows * residual).max()))
    if not gaps or (len(gaps) == 1 and gaps[0] < EVIDENT):
        return None
    # an error of the interpolation would fall by 2^16
    gap = gaps[-1] if gaps[-1] > 0.1 * gaps[0] else 0.0
    if rounding < gap < TURNED:
        raise EngineError(
            f"mechanism {closed.mechanism.name!r}: near q = {state.q.tolist()} branches of its "
            f"motion come within {gap:.0e} of crossing, so that rounding decides which one it "
            "takes; change a length until they cross, or by more than that"
        )
    return gap >= TURNED


def _land_around(
    closed: Closed, way: _Way, state: _State, ahead: float, apart: float
) -> list[NewtonResult] | None:
    """Return the closed positions on both sides of a place ahead; None if there are none."""
    landings = []
    for side in (1, -1):
        bend: Array = np.zeros(way.right.shape[1])
        last = bend
        for k in range(1, _SIDE + 1):
            along = (ahead + side * k * apart) * way.along
            landing = _land(closed, state, way, Tangent(along, way.right, 2 * bend - last))
            if landing is None:
                return None
            last, bend = bend, landing.bend
            landings.append(landing)
    return landings


def _land(closed: Closed, state: _State, way: _Way, tangent: Tangent) -> NewtonResult | None:
    """Return the closed position for a displacement in the tangent space; None if there is none."""
    q, v, t = state
    landing = newton(
        closed,
        q,
        v,
        t,
        way.metric,
        _least_squares,
        tangent=tangent,
        near=LANDED,
        stagnant=0.3,
        sweeps=_SWEEPS,
    )
    return landing if landing.gap < landing.rounding else None


def _velocity_on(state: _State, way: _Way, landing: NewtonResult) -> Array:
    """Return the velocity that the loops allow, with the same component along the path."""
    turn = _least_squares(landing.jacobian, landing.rates)
    velocity: Array = state.v - way.metric.columns @ (way.right @ turn)
    return velocity


def _least_squares(J: Array, gaps: Array) -> Array:
    return np.asarray(np.linalg.lstsq(J, gaps, rcond=None)[0], dtype=float)
