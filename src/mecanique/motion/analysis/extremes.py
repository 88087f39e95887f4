"""The largest values along a motion, between its steps as well, and the limits it exceeds."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING, NamedTuple, final

import numpy as np
import numpy.typing as npt

from mecanique.arrays import Array
from mecanique.model.joint_base import Single
from mecanique.motion.record.curve import Curve, interpolate
from mecanique.motion.tolerances import BEYOND_LIMIT, INSTANT
from mecanique.motion.trajectory import steps_of

if TYPE_CHECKING:
    from mecanique.motion.trajectory import Trajectory

CANDIDATES = 3
"""Highest local maxima at the nodes that are refined; another can only lead by chance."""

MANY = 100_000
"""With more steps these alone are looked at: some are next to each maximum."""

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

    def measure(times: np.ndarray, q: np.ndarray, v: np.ndarray) -> np.ndarray:
        values = quantities(times, q, v)
        return np.where(np.isnan(values), -np.inf, values)

    times, q, v, known = _look_between(curve)
    columns = np.ascontiguousarray(measure(times, q, v).T)
    around = np.pad(columns, ((0, 0), (1, 1)), constant_values=-np.inf)
    is_peak = (columns >= around[:, :-2]) & (columns >= around[:, 2:])
    # the peaks of all quantities are narrowed down together, as many states cost less at once
    highest = np.empty((CANDIDATES, len(columns)), dtype=int)
    for k, (column, some) in enumerate(zip(columns, is_peak, strict=True)):
        places = np.flatnonzero(some)
        highest[:, k] = np.resize(places[np.argsort(-column[places])], CANDIDATES)
    peaks, which = highest.ravel(), np.tile(np.arange(len(columns)), CANDIDATES)
    low, high = times[(peaks - 1).clip(0)], times[(peaks + 1).clip(max=len(times) - 1)]
    tops = np.where(known[peaks], columns[which, peaks], -np.inf)
    at, each = times[peaks], np.arange(len(peaks))
    for _ in range(ROUNDS if len(times) > 1 else 0):
        grid = np.linspace(low, high, POINTS)
        values = measure(*curve(grid.ravel()).arrays).reshape(*grid.shape, -1)[:, each, which]
        top = values.argmax(axis=0)
        higher = values[top, each] > tops
        tops = np.where(higher, values[top, each], tops)
        at = np.where(higher, grid[top, each], at)
        width = (high - low) / (POINTS - 1)
        low, high = np.maximum(at - width, low), np.minimum(at + width, high)
    tops, at = tops.reshape(CANDIDATES, -1), at.reshape(CANDIDATES, -1)
    best = tops.argmax(axis=0), np.arange(len(columns))
    return Maxima(*(np.where(np.isfinite(tops[best]), x[best], np.nan) for x in (tops, at)))


def _look_between(curve: Curve) -> tuple[Array, Array, Array, npt.NDArray[np.bool_]]:
    """Return the states at a curve's steps, and about those between, and which are known.

    The cubic through both ends is enough to see where a quantity is largest.
    """
    # at a break the curve has the state after it; that before it is a rounding earlier
    t = curve.t.copy()
    before = curve.breaks[1:] - 1
    t[before] = np.nextafter(t[before], -np.inf)
    if len(t) > MANY:
        return t, curve.q, curve.v, np.ones(len(t), dtype=bool)
    if curve.series is not None or not curve.smooth:
        # cubics do not follow the long steps of series
        middles = curve((curve.t[1:] + curve.t[:-1]) / 2).arrays
    else:
        at, nq = curve.intervals, curve.q.shape[1]
        y, h = np.hstack([curve.q, curve.v]), np.diff(curve.t)[at]
        dy = np.hstack([curve.rates.first(curve.q, curve.v), curve.a])
        between = interpolate(0.5, h[:, None], (y[at], y[at + 1]), (dy[at], dy[at + 1]))
        q = curve.rates.normalize(between[:, :nq])
        middles = curve.t[at] + h / 2, q, between[:, nq:]
    times, q, v = map(np.concatenate, zip((t, curve.q, curve.v), middles, strict=True))
    order = np.argsort(times, kind="stable")
    return times[order], q[order], v[order], order < len(t)


def find_bounds(motion: Trajectory) -> Array:
    """Return the largest values of q, v, −q and −v along a motion, one after another."""
    return find_maxima(steps_of(motion), lambda t, q, v: np.hstack([q, v, -q, -v])).values


@final
@dataclass(frozen=True)
class Exceeded:
    """A joint that goes beyond its limits.

    Args:
        joint: its name.
        coordinate: its coordinate.
        lower: lower limit [rad or m].
        upper: upper limit.
        value: the coordinate where it is farthest beyond.
        time: when that is [s].
        since: when it is beyond for the first time [s].
    """

    joint: str
    coordinate: str
    lower: float
    upper: float
    value: float
    time: float
    since: float

    def __str__(self) -> str:
        return (
            f"joint {self.joint!r} passes its limits {self.lower:.4g} … {self.upper:.4g} from "
            f"t = {self.since:.4g} s, farthest {self.value:.4g} at t = {self.time:.4g} s"
        )


def find_exceeded(motion: Trajectory) -> tuple[Exceeded, ...]:
    """Return the joints that go beyond their limits, in order of time."""
    joints = [
        joint
        for joint in motion.mechanism.joints
        if isinstance(joint, Single)
        and joint.limits is not None
        and joint.coordinate in motion.mechanism.coordinates.names
    ]
    if not joints:
        return ()
    curve, names = steps_of(motion), motion.mechanism.coordinates
    at = [names.index(joint.coordinate) for joint in joints]
    most = find_maxima(curve, lambda t, q, v: np.hstack([q[:, at], -q[:, at]]))
    extremes = most.values.reshape(2, -1).T * (1.0, -1.0)
    each = zip(joints, at, extremes, most.times.reshape(2, -1).T, strict=True)
    passed = [_exceed(curve, *joint) for joint in each]
    return tuple(sorted(filter(None, passed), key=lambda exceeded: exceeded.since))


def _exceed(curve: Curve, joint: Single, at: int, extremes: Array, times: Array) -> Exceeded | None:
    """Return how far a joint goes beyond its limits, by its extremes; None if it stays within."""
    assert joint.limits is not None, "it has limits"
    lower, upper = float(joint.limits.lower), float(joint.limits.upper)

    def beyond(x: Array) -> Array:
        return np.maximum(lower - x, x - upper) - BEYOND_LIMIT

    worst = int(beyond(extremes).argmax())
    time = float(times[worst])
    if not beyond(extremes)[worst] > 0:
        return None
    outside = curve.t[(curve.t < time) & (beyond(curve.q[:, at]) > 0)]
    since = float(outside[0]) if len(outside) else time
    inside = curve.t[curve.t < since]
    if len(inside):
        from scipy.optimize import brentq

        since = brentq(lambda t: float(beyond(curve(t).q[at])), inside[-1], since, xtol=INSTANT)
    return Exceeded(
        joint=joint.name,
        coordinate=joint.coordinate,
        lower=lower,
        upper=upper,
        value=float(extremes[worst]),
        time=time,
        since=float(since),
    )
