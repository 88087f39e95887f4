"""An integrator's steps, and the motion between them: polynomials through nearby steps.

At each step the integrator knows q, v and a, hence q, q̇ and q̈ to its tolerance: the polynomial of
degree 11 through four neighboring steps (Hermite, in Newton's form with confluent nodes) is as
accurate as the eighth-order steps themselves and costs no evaluation of the equations; its
derivative gives v. Where steps are so short that a derivative would enlarge rounding, there is a
second polynomial through v and a at six steps, and the smaller error estimate decides. Polynomials
never reach across a break: an impact, or a kink in a sampled input. Implicit methods do not give q̈
that accurately on stiff systems, and their steps differ too much in length; each of their steps is
a stretch of its own, through points of the method's own interpolation.
"""

from __future__ import annotations

from bisect import bisect_right
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import NamedTuple, TypeAlias, final

import numpy as np

from mecanique.arrays import Array
from mecanique.errors import InputError
from mecanique.generation.dop853 import GRAZES, LOOKS, SHALLOW
from mecanique.motion.record.rates import Rates
from mecanique.motion.tolerances import INSTANT, OUTSIDE

Times: TypeAlias = "float | Sequence[float] | np.ndarray"
"""A time, or shape (n,) [s]."""

CLOSEST = 0.5
"""Least distance between a polynomial's nodes, in intervals; nearer ones would amplify errors."""

DERIVED = 1.5
"""Error of the derivative of q's polynomial, in errors of q per length (measured: 0.3 to 4)."""

DOUBTED = 3.0
"""Factor on the error estimate for v's own polynomial, which on long steps may be too small."""

FEW = 10
"""While so many times more intervals are there than times were asked for, only these are fitted."""

REACH = 5
"""How many intervals away a new step changes the interpolation."""


class State(NamedTuple):
    """Where a mechanism is and how it moves.

    Args:
        t: time, a number or shape (n,) [s].
        q: positions, shape (nq,) or (n, nq).
        v: velocities, shape (nv,) or (n, nv).
    """

    t: float | np.ndarray
    q: np.ndarray
    v: np.ndarray

    @property
    def arrays(self) -> tuple[Array, Array, Array]:
        """Times, positions and velocities of n states."""
        return np.asarray(self.t), self.q, self.v


class _Pieces(NamedTuple):
    """Newton's form on each of n intervals, which are the last axis: numpy's inner loops are long.

    Nodes (m, n), coefficients (m, k, n), error estimate (n,).
    """

    nodes: np.ndarray
    coefficients: np.ndarray
    error: np.ndarray

    def at(self, piece: np.ndarray, t: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Return values and first derivatives, each of shape (n, k), of one polynomial per time."""
        value = self.coefficients[-1][:, piece]
        rate = np.zeros_like(value)
        for order in range(len(self.nodes) - 2, -1, -1):
            away = t - self.nodes[order, piece]
            rate *= away
            rate += value
            value *= away
            value += self.coefficients[order][:, piece]
        return value.T, rate.T

    def merge(self, kept: np.ndarray, changed: np.ndarray, fresh: _Pieces) -> _Pieces:
        """Return these intervals where nothing changed, and fresh ones elsewhere."""
        merged = []
        for old, new in zip(self, fresh, strict=True):
            both = np.empty((*old.shape[:-1], len(changed)))
            both[..., ~changed], both[..., changed] = old[..., kept], new
            merged.append(both)
        return _Pieces(*merged)


@final
@dataclass(frozen=True, eq=False)
class Curve:
    """A motion as a function of time, through the steps of an integrator."""

    t: np.ndarray  # shape (n,), times of the steps [s]; at a break two steps have the same time
    q: np.ndarray  # shape (n, nq), positions
    v: np.ndarray  # shape (n, nv), velocities
    a: np.ndarray  # shape (n, nv), rates of the velocities
    breaks: np.ndarray  # shape (s,), index of the first step of each smooth stretch, 0 first
    rates: Rates  # the maps between v and q̇
    # whether polynomials use q, v and a of neighboring steps; otherwise those of each stretch's
    # points alone
    smooth: bool = True
    close: bool = True  # whether steps are so short that a derivative of q may enlarge rounding
    known: tuple[_Pieces, ...] | None = field(default=None, repr=False)
    # gives states (n, nq + nv) at times [s], where the integrator's own series are kept
    series: Callable[[np.ndarray], np.ndarray] | None = field(default=None, repr=False)

    @cached_property
    def intervals(self) -> np.ndarray:
        """Index of the step at the start of each interval, shape (m,); breaks have no interval."""
        return np.flatnonzero(np.diff(self.t) > 0)

    @cached_property
    def _asked(self) -> list[int]:
        """How many times were asked for, the only entry."""
        return [0]

    @cached_property
    def _pieces(self) -> tuple[_Pieces, ...]:
        return self._fit(self.intervals) if self.known is None else self.known

    def part(self, first: int, last: int) -> Curve:
        """Return the curve through some of its steps, from a first to before a last."""
        inside = self.breaks[(self.breaks > first) & (self.breaks < last)] - first
        t, q, v, a = (x[first:last] for x in (self.t, self.q, self.v, self.a))
        breaks = np.append(0, inside)
        return replace(self, t=t, q=q, v=v, a=a, breaks=breaks, known=None)

    def _fit(self, starts: np.ndarray) -> tuple[_Pieces, ...]:
        """Polynomials for q and for v on intervals; for both at once if the curve is not smooth."""
        if not self.smooth:
            most = int(np.diff(np.append(self.breaks, len(self.t))).max())
            nodes, used = _stencils(self.t, starts, self.breaks, most)
            return (_newton(self.t, [np.hstack([self.q, self.v])], nodes, used, starts),)
        nodes, used = _stencils(self.t, starts, self.breaks, 6 if self.close else 4)
        data = [
            self.q,
            self.rates.first(self.q, self.v),
            self.rates.second(self.q, self.v, self.a) / 2,
        ]
        positions = _newton(self.t, data, nodes[:, :4], used.clip(max=4), starts)
        return (
            (positions, _newton(self.t, [self.v, self.a], nodes, used, starts))
            if self.close
            else (positions,)
        )

    def _errors_of_v(self, starts: np.ndarray, pieces: tuple[_Pieces, ...]) -> np.ndarray:
        """Error estimates of v from q's polynomial, and from its own if there is one, in rows."""
        length = self.t[starts + 1] - self.t[starts]
        estimates = [DERIVED * pieces[0].error / length]
        if self.close:  # the times of steps are rounded, which a derivative between them enlarges
            slope = np.abs(self.v[starts]).max(axis=1, initial=0.0)
            estimates[0] = estimates[0] + slope * np.spacing(np.abs(self.t).max()) / length
        return np.stack(estimates + [DOUBTED * piece.error for piece in pieces[1:]])

    def errors(self) -> tuple[np.ndarray, np.ndarray]:
        """Return estimates of the largest errors in q and in v on each interval, shape (m,)."""
        errors_of_v = self._errors_of_v(self.intervals, self._pieces)
        return self._pieces[0].error, errors_of_v.min(axis=0)

    def __call__(self, t: float | np.ndarray) -> State:
        """Return the state at times [s] within the motion; at a break, the state after it."""
        times = np.atleast_1d(np.asarray(t, dtype=float))
        if not len(self.intervals):
            q, v = (
                np.repeat(self.q[-1:], len(times), axis=0),
                np.repeat(self.v[-1:], len(times), axis=0),
            )
        elif self.series is not None:
            y, nq = self.series(times), self.q.shape[1]
            q, v = self.rates.normalize(y[:, :nq]), y[:, nq:]
        else:
            starts = self.intervals
            piece = np.searchsorted(self.t[starts], times, side="right") - 1
            piece = piece.clip(0, len(starts) - 1)
            self._asked[0] += len(times)
            if self._asked[0] * FEW >= len(starts):
                pieces = self._pieces
            else:
                some, piece = np.unique(piece, return_inverse=True)
                starts = starts[some]
                pieces = self._fit(starts)
            value, rate = pieces[0].at(piece, times)
            nq = self.q.shape[1]
            q = self.rates.normalize(value[:, :nq])
            v = self.rates.velocities(q, rate) if self.smooth else value[:, nq:]
            if self.smooth and self.close:
                better = np.diff(self._errors_of_v(starts, pieces), axis=0)[0, piece] <= 0
                v = np.where(better[:, None], pieces[1].at(piece, times)[0], v)
        return State(times, q, v) if np.ndim(t) else State(float(times[0]), q[0], v[0])

    def admit(self, t: Times) -> float | np.ndarray:
        """Return times as numbers; those beyond an end by rounding are moved to it."""
        try:
            times = np.asarray(t, dtype=float)
        except (TypeError, ValueError, OverflowError):
            raise InputError(f"expected times [s], got {t!r:.60}") from None
        begin, end = float(self.t[0]), float(self.t[-1])
        slack = OUTSIDE * max(abs(begin), abs(end), end - begin)
        if times.ndim > 1 or not ((times >= begin - slack) & (times <= end + slack)).all():
            raise InputError(f"expected times within the motion, {begin:g}…{end:g} s, got {t!r}")
        times = times.clip(begin, end)
        return times if times.ndim else float(times)

    def with_steps(
        self, at: np.ndarray, t: np.ndarray, q: np.ndarray, v: np.ndarray, a: np.ndarray
    ) -> Curve:
        """Return the curve with further steps, each after the step of index `at`, increasing."""
        place = at + 1
        breaks = self.breaks + np.searchsorted(place, self.breaks, side="right")
        curve = Curve(
            t=np.insert(self.t, place, t),
            q=np.insert(self.q, place, q, axis=0),
            v=np.insert(self.v, place, v, axis=0),
            a=np.insert(self.a, place, a, axis=0),
            breaks=breaks,
            rates=self.rates,
            smooth=self.smooth,
            close=self.close,
        )
        starts = curve.intervals
        new = place + np.arange(len(place))
        changed = np.isin(starts, new[:, None] + np.arange(-REACH, REACH + 1))
        # intervals that keep all their neighbors keep their polynomials
        kept = np.searchsorted(
            self.intervals, starts[~changed] - np.searchsorted(new, starts[~changed])
        )
        fresh = curve._fit(starts[changed])
        return replace(
            curve,
            known=tuple(
                old.merge(kept, changed, f) for old, f in zip(self._pieces, fresh, strict=True)
            ),
        )


@final
@dataclass(frozen=True)
class LaterCurve:
    """A motion as a function of time that is made when it is asked for."""

    start: State
    end: float  # [s]
    make: Callable[[], Curve]
    # gives the curve through its steps as they are, which takes no time; None if they are not kept
    through_steps: Callable[[], Curve] | None = None


def _stencils(
    t: np.ndarray, starts: np.ndarray, breaks: np.ndarray, count: int
) -> tuple[np.ndarray, np.ndarray]:
    """Return the nearest steps of each interval, shape (n, count), and how many are usable."""
    stretch = np.searchsorted(breaks, starts, side="right") - 1
    low, high = breaks[stretch], np.append(breaks[1:], len(t))[stretch] - 1
    length = t[starts + 1] - t[starts]
    middle = t[starts] + length / 2
    nodes = np.empty((len(starts), count), dtype=int)
    nodes[:, 0], nodes[:, 1] = starts, starts + 1
    used = np.full(len(starts), 2)
    left, right = starts.copy(), starts + 1  # outermost nodes chosen so far
    below, above = starts - 1, starts + 2  # next candidates
    while (used < count).any():
        if not ((below >= low) | (above <= high))[used < count].any():
            break
        gap_left, gap_right = t[left] - t[below.clip(0)], t[above.clip(max=len(t) - 1)] - t[right]
        can_left, can_right = below >= low, above <= high
        # a step too near to a chosen one is passed over
        below[can_left & (gap_left < CLOSEST * length)] -= 1
        above[can_right & (gap_right < CLOSEST * length)] += 1
        can_left &= gap_left >= CLOSEST * length
        can_right &= gap_right >= CLOSEST * length
        far_left = np.where(can_left, middle - t[below.clip(0)], np.inf)
        far_right = np.where(can_right, t[above.clip(max=len(t) - 1)] - middle, np.inf)
        go_left = can_left & (far_left <= far_right) & (used < count)
        go_right = can_right & (far_right < far_left) & (used < count)
        nodes[go_left, used[go_left]] = left[go_left] = below[go_left]
        nodes[go_right, used[go_right]] = right[go_right] = above[go_right]
        used[go_left | go_right] += 1
        below[go_left] -= 1
        above[go_right] += 1
    return nodes, used


BLOCK = 1000
"""Intervals fitted together: their arrays stay in the processor's cache."""


def _newton(
    t: np.ndarray, data: list[np.ndarray], nodes: np.ndarray, used: np.ndarray, starts: np.ndarray
) -> _Pieces:
    """Return Newton's form through values and Taylor coefficients at the steps."""
    pieces, count = nodes.shape
    repeat = len(data)
    size = count * repeat
    coefficients = np.zeros((size, data[0].shape[1], pieces))
    points = np.zeros((size, pieces))
    error = np.zeros(pieces)
    for number in sorted(set(used.ravel().tolist())):
        same_number = np.flatnonzero(used == number)
        last = number * repeat - 1
        for rows in np.split(same_number, range(BLOCK, len(same_number), BLOCK)):
            index = np.repeat(nodes[rows, :number].T, repeat, axis=0)
            points[: last + 1, rows] = z = t[index]
            table = np.moveaxis(data[0][index], 2, 1).copy()
            coefficients[0][:, rows] = table[0]
            for order in range(1, last + 1):
                gap = z[order:] - z[:-order]
                step = table[1:] - table[:-1]
                if order < repeat:
                    same = index[order:] == index[:-order]
                    gap[same] = 1.0
                step /= gap[:, None]
                if order < repeat:
                    confluent = np.moveaxis(data[order][index[:-order]], 2, 1)
                    step = np.where(same[:, None], confluent, step)
                table = step
                coefficients[order][:, rows] = table[0]
            middle = (t[starts[rows]] + t[starts[rows] + 1]) / 2
            reach = np.abs(np.prod(middle - z[:-1], axis=0))
            error[rows] = np.abs(coefficients[last][:, rows]).max(axis=0, initial=0.0) * reach
    return _Pieces(points, coefficients, error)


PLACES = tuple((k + 1) / LOOKS for k in range(LOOKS))
"""Fractions of a step at which events are looked for."""


def interpolate(
    x: float, h: float | Array, y: tuple[Array, Array], dy: tuple[Array, Array]
) -> Array:
    """Return the states at a fraction of steps of a length, by the cubic through both ends."""
    a, b = (1 + 2 * x) * (1 - x) ** 2, x * x * (3 - 2 * x)
    bend = h * x * (1 - x) * ((1 - x) * dy[0] - x * dy[1])
    return a * y[0] + b * y[1] + bend


class Crossing(NamedTuple):
    """When a quantity passes zero [s], and its sign afterwards."""

    t: float
    sign: int


def turns_low(looks: Sequence[tuple[float, float]]) -> bool:
    """Return whether a quantity that is positive at three times may be below zero between them."""
    (t0, g0), (t1, g1), (t2, g2) = looks
    least = min(g0, g1, g2)
    if not least > 0:
        return False
    # the turn of a parabola through the three
    first, second = (g1 - g0) / (t1 - t0), (g2 - g1) / (t2 - t1)
    bend = (second - first) / (t2 - t0)
    if not bend > 0:
        return False
    turn = (t0 + t1) / 2 - first / (2 * bend)
    lowest = g0 + (first + bend * (turn - t1)) * (turn - t0)
    return t0 < turn < t2 and lowest <= SHALLOW * least


def find_lowest(value: Callable[[float], float], low: float, high: float) -> tuple[float, float]:
    """Return when between two times a quantity is least, and how much it is."""
    from scipy.optimize import minimize_scalar

    lowest = minimize_scalar(
        value, bounds=(low, high), method="bounded", options={"xatol": 1e-8 * (high - low)}
    )
    return float(lowest.x), float(lowest.fun)


def find_crossings(
    curve: Curve,
    quantities: Callable[[Array, Array, Array], Array],
    places: Sequence[float] = PLACES,
) -> list[list[Crossing]]:
    """Return where each of some quantities, shape (n, k), passes zero along a curve.

    It is looked for at fractions of each interval, and where it turns between three of them. What
    jumps at a break does not pass zero there.
    """
    from scipy.optimize import brentq  # takes longer to import than most motions

    begin, end = curve.t[curve.intervals], curve.t[curve.intervals + 1]
    # at a break the curve has the state after it
    end = np.where(np.isin(curve.intervals + 2, curve.breaks), np.nextafter(end, begin), end)
    times = np.array([begin + x * (end - begin) for x in (0.0, *places[:-1])] + [end])
    some, place = np.unique(times, return_inverse=True)  # most ends are the next one's start
    columns = quantities(*curve(some).arrays).T
    crossings: list[list[Crossing]] = []
    for k, column in enumerate(columns):

        def value(t: float, k: int = k) -> float:
            return float(quantities(*curve(np.array([t])).arrays)[0, k])

        values = column[place].reshape(times.shape)
        before, after = values[:-1], values[1:]
        rises, falls = (before < 0) & (after >= 0), (before > 0) & (after <= 0)
        brackets = [
            (*times[j : j + 2, i].tolist(), 1 if rises[j, i] else -1)
            for i, j in zip(*np.nonzero((rises | falls).T), strict=True)
        ]
        brackets += _bracket_dips(times, values, value)
        crossings.append([])
        for low, high, sign in sorted(brackets):
            if value(low) * value(high) > 0:  # one is zero to rounding
                t = min((low, high), key=lambda t: abs(value(t)))
            else:
                t = float(brentq(value, low, high, xtol=INSTANT, rtol=INSTANT))
            crossings[k].append(Crossing(t, sign))
    return crossings


def _bracket_dips(
    times: Array, values: Array, value: Callable[[float], float]
) -> list[tuple[float, float, int]]:
    """Return between which times a quantity passes zero and comes back between two looks."""
    brackets = list[tuple[float, float, int]]()
    for t, g in zip(times.T.tolist(), values.T.tolist(), strict=True):
        for j in range(len(t) - 2):
            sign = 1 if g[j + 1] > 0 else -1

            def distance(x: float, sign: int = sign) -> float:
                return sign * value(x)

            looks = [(x, sign * y) for x, y in zip(t[j : j + 3], g[j : j + 3], strict=True)]
            if turns_low(looks):
                turn, lowest = find_lowest(distance, t[j], t[j + 2])
                # what turns between the middle two of four looks is seen twice
                seen = brackets and turn - brackets[-1][0] < (t[-1] - t[0]) / 1000
                if lowest < -GRAZES * max(y for _, y in looks) and not seen:
                    brackets += [(t[j], turn, -sign), (turn, t[j + 2], sign)]
    return brackets


RightHandSide: TypeAlias = Callable[[float, np.ndarray], np.ndarray]
"""ẏ = f(t, y) for y = (q, v)."""


@final
@dataclass
class Steps:
    """Steps as they come, and where the motion breaks; a recorder, filled while integrating."""

    t: list[float] = field(default_factory=list)  # times [s]
    y: list[np.ndarray] = field(default_factory=list)
    dy: list[np.ndarray] = field(default_factory=list)
    # index of the first step of each smooth stretch
    breaks: list[int] = field(default_factory=lambda: [0])
    spread: bool = False  # whether each step is a stretch of several points
    evaluations: int = 0

    @property
    def first(self) -> int:
        """Index of the point at which the last step starts."""
        return self.breaks[-1] if self.spread else len(self.t) - 2

    @property
    def taken(self) -> int:
        """Number of steps taken."""
        return len(self.breaks) if self.spread else len(self.t) - len(self.breaks)

    def add(self, t: float, y: np.ndarray, dy: np.ndarray) -> None:
        """Note a step."""
        self.t.append(t)
        self.y.append(y.copy())
        self.dy.append(dy)

    def extend(self, t: np.ndarray, y: np.ndarray, dy: np.ndarray) -> None:
        """Note steps: times (n,) [s], states and their rates (n, nq + nv)."""
        self.t += t.tolist()
        self.y += list(y)
        self.dy += list(dy)

    def add_spread(self, t: np.ndarray, y: np.ndarray, dy: np.ndarray) -> None:
        """Note a step by several points (n,), its start left out, as a stretch of its own."""
        if self.breaks[-1] < len(self.t) - 1:
            self.break_here(self.y[-1], self.dy[-1])
        self.extend(t, y, dy)

    def end_at(self, t: float, y: np.ndarray, rhs: RightHandSide) -> None:
        """Let the last step end earlier, at a time within it [s]."""
        if self.spread:
            self._squeeze(t, rhs)
        self.t[-1], self.y[-1], self.dy[-1] = t, y, rhs(t, y)

    def _squeeze(self, end: float, rhs: RightHandSide) -> None:
        """Move the last step's points in proportion to its new end."""
        from scipy.interpolate import BarycentricInterpolator

        first = self.breaks[-1]
        times = np.array(self.t[first:])
        if len(times) < 2:
            return
        moved = times[0] + (times - times[0]) * ((end - times[0]) / (times[-1] - times[0]))
        states = np.asarray(BarycentricInterpolator(times, np.array(self.y[first:]))(moved))
        for k, (t, y) in enumerate(zip(moved.tolist(), states, strict=True)):
            if k:
                self.t[first + k], self.y[first + k], self.dy[first + k] = t, y, rhs(t, y)

    def break_here(self, y: np.ndarray, dy: np.ndarray) -> None:
        """Start a new smooth stretch at the last step's time, from a state of its own."""
        self.breaks.append(len(self.t))
        self.add(self.t[-1], y, dy)

    def cut(self, t: float) -> None:
        """Forget the steps after a time."""
        keep = bisect_right(self.t, t)
        del self.t[keep:], self.y[keep:], self.dy[keep:]
        self.breaks = [first for first in self.breaks if first < keep]

    def curve(self, nq: int, rates: Rates, smooth: bool, close: bool = True) -> Curve:
        """Return the motion through the steps; `smooth` if rates are as accurate as states."""
        y, dy = np.array(self.y), np.array(self.dy)
        q = rates.normalize(y[:, :nq])
        return Curve(
            t=np.array(self.t),
            q=q,
            v=y[:, nq:],
            a=dy[:, nq:],
            breaks=np.array(self.breaks),
            rates=rates,
            smooth=smooth,
            close=close,
        )
