"""The largest values along a motion, between its steps as well, and the limits it exceeds."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING, NamedTuple, final

import numpy as np

from mecanique.arrays import Array
from mecanique.model.joint_base import Single
from mecanique.motion.record.curve import Curve
from mecanique.motion.record.rates import Rates
from mecanique.motion.tolerances import BEYOND_LIMIT, INSTANT

if TYPE_CHECKING:
    from mecanique.motion.trajectory import Trajectory

CANDIDATES = 3
"""Highest local maxima at the nodes that are refined; another can only lead by chance."""

CLOSER, AROUND = 4, 5
"""So many samples for each step are close; so many on each side of an extreme suffice there."""

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
    # the peaks of all quantities are narrowed down together, as many states cost less at once
    around = np.pad(rows, ((1, 1), (0, 0)), constant_values=-np.inf)
    is_peak = (rows >= around[:-2]) & (rows >= around[2:])
    order = np.argsort(np.where(is_peak, -rows, np.inf), axis=0, kind="stable")[:CANDIDATES]
    place, which = np.nonzero(np.take_along_axis(is_peak, order, axis=0))
    peaks = order[place, which]
    low, high = nodes[(peaks - 1).clip(0)], nodes[(peaks + 1).clip(max=len(nodes) - 1)]
    tops, at, each = rows[peaks, which], nodes[peaks], np.arange(len(peaks))
    for _ in range(ROUNDS if len(nodes) > 1 else 0):
        grid = np.linspace(low, high, POINTS)
        values = measure(grid.ravel()).reshape(*grid.shape, -1)[:, each, which]
        top = values.argmax(axis=0)
        higher = values[top, each] > tops
        tops = np.where(higher, values[top, each], tops)
        at = np.where(higher, grid[top, each], at)
        width = (high - low) / (POINTS - 1)
        low, high = np.maximum(at - width, low), np.minimum(at + width, high)
    best, times = np.full((2, rows.shape[1]), np.nan)
    for k in range(rows.shape[1]):
        mine = np.flatnonzero((which == k) & np.isfinite(tops))
        if len(mine):
            first = mine[tops[mine].argmax()]
            best[k], times[k] = tops[first], at[first]
    return Maxima(best, times)


def find_bounds(motion: Trajectory) -> Array:
    """Return the largest values of q, v, −q and −v along a motion, one after another.

    Where its samples are much closer than its steps, as with long motions by Taylor series, the
    curve through the samples about each extreme is enough, and quicker to have than the whole.
    """

    def list_both(t: Array, q: Array, v: Array) -> Array:
        return np.hstack([q, v, -q, -v])

    whole = isinstance(motion.path, Curve) or "curve" in vars(motion)
    if whole or len(motion.t) < CLOSER * motion.statistics.steps:
        return find_maxima(motion.curve, list_both).values
    values = list_both(motion.t, motion.q, motion.v)
    bounds: Array = values.max(axis=0)
    for k, top in enumerate(values.argmax(axis=0).tolist()):
        near = slice(max(top - AROUND, 0), top + AROUND + 1)
        t, q, v = motion.t[near], motion.q[near], motion.v[near]
        a, rates = motion.reference.acceleration(q, v, t), Rates.of(motion.mechanism)
        curve = Curve(t=t, q=q, v=v, a=a, breaks=np.array([0]), rates=rates)
        (bounds[k],) = find_maxima(curve, lambda *state, k=k: list_both(*state)[:, [k]]).values
    return bounds


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
    exceeded = []
    coordinates = motion.mechanism.coordinates.names
    for joint in motion.mechanism.joints:
        if not isinstance(joint, Single) or joint.limits is None:
            continue
        if joint.coordinate not in coordinates:
            continue
        lower, upper = float(joint.limits.lower), float(joint.limits.upper)
        at = coordinates.index(joint.coordinate)

        def beyond(t: float, k: int = at, lower: float = lower, upper: float = upper) -> float:
            x = float(motion.curve(t).q[k])
            return max(lower - x, x - upper) - BEYOND_LIMIT

        def both(t: Array, q: Array, v: Array, k: int = at) -> Array:
            return np.column_stack([q[:, k], -q[:, k]])

        curve = motion.curve
        most = find_maxima(curve, both)
        highest, lowest = most.values[0], -most.values[1]
        from scipy.optimize import brentq

        worst = 0 if highest - upper >= lower - lowest else 1
        time = float(most.times[worst])
        if beyond(time) > 0:
            earlier = curve.t[curve.t < time]
            outside = [t for t in earlier.tolist() if beyond(t) > 0]
            end = outside[0] if outside else time
            inside = curve.t[curve.t < end]
            since = end
            if len(inside):
                since = float(brentq(beyond, inside[-1], end, xtol=INSTANT))
            exceeded.append(
                Exceeded(
                    joint=joint.name,
                    coordinate=joint.coordinate,
                    lower=lower,
                    upper=upper,
                    value=float((highest, lowest)[worst]),
                    time=time,
                    since=since,
                )
            )
    return tuple(sorted(exceeded, key=lambda passed: passed.since))
