"""Watch a motion: while it is integrated where it halts, and afterwards what it passes."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import partial
from itertools import starmap
from typing import NamedTuple, cast, final

import numpy as np

from mecanique.arrays import Array
from mecanique.errors import InputError, IntegrationError, MecaniqueError
from mecanique.model.joint_base import Single
from mecanique.model.mechanism import Mechanism
from mecanique.motion.record.curve import (
    PLACES,
    Crossing,
    Curve,
    Steps,
    find_crossings,
    find_lowest,
    interpolate,
    turns_low,
)
from mecanique.motion.record.events import (
    Event,
    Margin,
    Occurrence,
    break_names,
    is_halt,
    is_switch,
)
from mecanique.motion.simulation.integrators.methods import (
    IntegrationTask,
    StallDetector,
    advance_within,
)
from mecanique.motion.simulation.problem import Outcome, Problem
from mecanique.motion.switching.holding import Holding
from mecanique.motion.tolerances import AT_LIMIT, NOT_LEFT, SHORTEST_FLIGHT, TINY
from mecanique.motion.trajectory import Trajectory


def record_events(
    events: Sequence[Event], holding: Holding, curve: Curve
) -> tuple[Occurrence, ...]:
    """Return where along a motion it did not halt: at events, and where something ceases to hold.

    Contacts and cords may be amiss at its start, too.
    """
    mechanism, names = holding.mechanism, {event.name for event in events if is_halt(event)}
    asked = [event for event in events if not (is_halt(event) or isinstance(event.when, Margin))]
    passed: list[tuple[str, int, list[Crossing]]] = []
    if asked:
        quantities = [event.quantity(mechanism) for event in asked]

        def measure(t: Array, q: Array, v: Array) -> Array:
            states = list(zip(t.tolist(), q, v, strict=True))
            return np.column_stack([list(starmap(quantity, states)) for quantity in quantities])

        crossings = find_crossings(curve, measure)
        passed += [(e.name, e.direction, some) for e, some in zip(asked, crossings, strict=True)]
    if breaks := break_names(mechanism):
        begin = float(curve.t[0])
        at_start = holding.margins(begin, curve.q[0], curve.v[0])
        # the engine takes long for a state: one look between steps
        crossings = find_crossings(curve, holding.margins, (0.5, 1.0))
        for name, margin, some in zip(breaks, at_start, crossings, strict=True):
            if name not in names:
                passed.append((name, -1, [Crossing(begin, -1)] * bool(margin < 0) + some))
    occurrences = []
    for name, direction, some in passed:
        for crossing in some:
            if direction in (0, crossing.sign):
                state = curve(crossing.t)
                occurrences.append(Occurrence(name, crossing.t, state.q, state.v, state.v))
    return tuple(occurrences)


@final
@dataclass(frozen=True)
class _Distance:
    """Distance of a coordinate from where it is too near a limit, positive inside."""

    index: int
    bound: float
    side: float  # +1 for a lower limit, −1 for an upper one
    margin: float  # how near is too near

    def __call__(self, t: float, q: np.ndarray, v: np.ndarray) -> float:
        """Return the distance, of many positions at once as well, shape (n, nq)."""
        return cast("float", self.side * (q[..., self.index] - self.bound) - self.margin)


def limit_events(mechanism: Mechanism, start: np.ndarray) -> tuple[Event, ...]:
    """Return the events at which coordinates reach their limits."""
    ends = []
    for name, (lower, upper) in mechanism.limits.items():
        at = mechanism.coordinates.index(name)
        margin = AT_LIMIT * (upper - lower if np.isfinite([lower, upper]).all() else 1.0)
        for bound, side in ((lower, 1.0), (upper, -1.0)):
            if np.isfinite(bound):
                # a motion that starts nearer to a limit may come half as near
                near = min(margin, abs(float(start[at]) - bound) / 2)
                inside = _Distance(at, bound, side, near)
                ends.append(Event(f"end of chart {name}", inside, -1, stop=True))
    return tuple(ends)


def joint_events(
    mechanism: Mechanism, start: np.ndarray, limits: str | float | None
) -> tuple[Event, ...]:
    """Return the events at which joints reach their limits: stops, or impacts."""
    if limits is None:
        return ()
    from sympy import Symbol

    wrong = isinstance(limits, bool) or (isinstance(limits, str) and limits != "stop")
    if wrong or (not isinstance(limits, str) and not 0 <= limits <= 1):
        raise InputError(
            f'expected "stop" or a coefficient of restitution in 0…1 for limits, got {limits!r}'
        )
    restitution = None if isinstance(limits, str) else float(limits)
    values = start[: mechanism.nq].tolist()
    places, events = dict(zip(mechanism.coordinates, values, strict=True)), list[Event]()
    for joint in mechanism.joints:
        if not isinstance(joint, Single) or joint.limits is None:
            continue
        value = places.get(joint.coordinate)
        for words, side in (("lower", 1), ("upper", -1)):
            bound = float(getattr(joint.limits, words))
            if value is None or not np.isfinite(bound):
                continue
            if side * (value - bound) < 0:
                raise InputError(
                    f"joint {joint.name!r} starts at {value:.6g}, beyond its {words} limit "
                    f"{bound:.6g}; start within the limits, or leave them out"
                )
            when, stop = side * (Symbol(joint.coordinate) - bound), restitution is None
            name = f"{words} limit of {joint.name}"
            events.append(Event(name, when, -1, stop=stop, restitution=restitution))
    return tuple(events)


def refuse_limit(motion: Trajectory) -> None:
    """Raise if a motion stopped because a coordinate reached its limit."""
    mechanism = motion.mechanism
    last = motion.events[-1] if motion.events else None
    for name in mechanism.limits:
        if last is not None and last.name == f"end of chart {name}":
            value = float(last.q[mechanism.coordinates.index(name)])
            message = mechanism.explain_limit(
                name, f", but comes to {value:.6g} at t = {last.t:.6g} s"
            )
            raise IntegrationError(
                f"{message}; the motion until then is in the error's .motion",
                time=last.t,
                state=np.concatenate([last.q, last.v]),
                motion=motion,
            )


def report_end(progress: Callable[[float], object] | None, motion: Trajectory) -> None:
    """Report that a motion is complete; what `progress` raises then does not lose it."""
    if progress is None:
        return
    try:
        progress(1.0)
    except Exception as error:
        t = float(motion.t[-1])
        message = (
            f"progress raised {error!r} at the end, t = {t:.6g} s; "
            "the whole motion is in the error's .motion"
        )
        raise IntegrationError(message, time=t, motion=motion) from error


NEARLY = 0.01
"""What a cubic through a long step may be off, of the largest of the three."""

MAX_HALVINGS = 50
"""How often a step is halved to find where a quantity has left zero."""


@final
class Interruption:
    """Whether Ctrl-C was pressed."""

    def __init__(self) -> None:
        self.pressed = False

    def note(self, number: int, frame: object) -> None:
        """Handle the signal."""
        self.pressed = True


class _Crossing(NamedTuple):
    """Between which times an event's quantity changes its sign, and its sign before."""

    which: int
    low: float
    high: float
    sign: float
    size: float = 0.0  # largest value around a dip, after which it is back; zero of what passes


def _interpolate_step(steps: Steps, at: int, t: float) -> np.ndarray:
    """Return the state within a step by a cubic."""
    begin, end = steps.t[at : at + 2]
    (y0, y1), (d0, d1) = steps.y[at : at + 2], steps.dy[at : at + 2]
    return interpolate((t - begin) / (end - begin), end - begin, (y0, y1), (d0, d1))


@final
class Watcher:
    """Looks at each step, the start first, and says whether the integration must halt."""

    def __init__(
        self,
        problem: Problem,
        task: IntegrationTask,
        steps: Steps,
        interruption: Interruption,
        reconsider: Callable[[int, float], bool] | None,
    ) -> None:
        mechanism, rates = problem.mechanism, problem.code.rates
        self.interruption = interruption
        self._reconsider = reconsider
        self._problem = problem
        self._rates = rates
        self._task = task
        self._steps = steps
        self._nq = mechanism.nq
        self._events = tuple(filter(is_halt, problem.events))
        self._quantities = [event.quantity(mechanism) for event in self._events]
        self._sources = {g.source for g in self._quantities if isinstance(g, Margin)}
        self._impacts = {
            event.name: event.impact(mechanism, rates)
            for event in self._events
            if event.restitution is not None
        }
        self._before = self._measure(steps.t[-1], steps.y[-1])  # each quantity at the last step
        self._lift_margins()
        self._halting: list[_Crossing] = []  # those within the last look
        self.occurrences: list[Occurrence] = []  # at which it halted
        self._last_impact: dict[str, float] = {}
        self._next_report = problem.t0
        self._stalls = StallDetector(problem, implicit=task.implicit)
        self._most_drift = 10 * task.rtol if rates.balls else float("inf")
        self._idle = not (self._events or problem.progress or rates.balls or problem.loops)

    def start(self) -> Outcome | None:
        """Note what is amiss with contacts and cords from the start; return how that ends all."""
        t, y = self._steps.t[0], self._steps.y[0]
        q, v = y[: self._nq], y[self._nq :]
        amiss = [
            event
            for event, margin in zip(self._events, self._before, strict=True)
            if isinstance(event.when, Margin) and margin < 0 and event.stop
        ]
        self.occurrences += [Occurrence(event.name, t, q, v, v) for event in amiss]
        return Outcome("event") if amiss else None

    def look(self) -> Outcome | None:
        """Look at the last step; return why to halt, or None to continue."""
        if self.interruption.pressed:
            return Outcome("interrupted")
        steps = self._steps
        if self._reconsider is not None and self._reconsider(steps.taken, steps.t[-1]):
            return Outcome("reconsider")
        if self._stalls.is_stalled(len(steps.t), steps.t[-1]):
            return Outcome("no headway")
        if self._idle:
            return None
        t, y = steps.t[-1], steps.y[-1]
        problem, loops = self._problem, self._problem.loops
        if problem.progress is not None and t >= self._next_report:
            if (outcome := problem.report(t)) is not None:
                return outcome
            self._next_report = t + (problem.end - problem.t0) / 100
        try:
            halts = (
                (self._events and self._has_crossed())
                or (loops is not None and loops.has_left(t, y))
                or self._rates.drift(y[: self._nq]) > self._most_drift
            )
        except MecaniqueError as error:
            return Outcome("undecided", error)
        return Outcome("halt") if halts else None

    def settle(self) -> Outcome | None:
        """Correct the last step: end it at an event or on the loops; return how all ends there."""
        steps, first = self._steps, self._locate_first()
        self._halting = []
        if first is None:
            t = steps.t[-1]
            steps.end_at(t, self._problem.correct(t, steps.y[-1]), self._task.rhs)
            return None
        crossing, (t, y) = first
        steps.end_at(t, y, self._task.rhs)
        event = self._events[crossing.which]
        if is_switch(event):
            return self._switch(t, y, event)
        q, v = y[: self._nq], y[self._nq :]
        after = v
        if event.name in self._impacts:
            after = self._impacts[event.name](
                t, q, v, partial(self._problem.reference.response, q, t)
            )
        self.occurrences.append(Occurrence(event.name, t, q, v, after))
        if event.stop:
            return Outcome("event")
        duration = self._problem.end - self._problem.t0
        if t - self._last_impact.get(event.name, -np.inf) < SHORTEST_FLIGHT * duration:
            return Outcome("contact")
        self._last_impact[event.name] = t
        y = np.concatenate([q, after])
        steps.break_here(y, self._task.rhs(t, y))
        self._before = self._measure(t, y)
        # zero to rounding, but it bounces back to the side it came from
        self._before[crossing.which] = crossing.sign * TINY
        return None

    def _switch(self, t: float, y: np.ndarray, event: Event) -> Outcome | None:
        """Change the mode at the last step's end."""
        assert self._problem.corners is not None, "elements switch"
        try:
            y, happened = self._problem.corners.switch(t, y, event)
        except MecaniqueError as error:
            return Outcome("undecided", error)
        self.occurrences += happened
        self._steps.break_here(y, self._task.rhs(t, y))
        self._before = self._measure(t, y)
        self._lift_margins()
        return None

    def _lift_margins(self) -> None:
        """Take margins that begin at zero, to rounding, for positive: a mode begins sound."""
        for k, event in enumerate(self._events):
            if is_switch(event):
                self._before[k] = max(self._before[k], TINY)

    def _measure(self, t: float, y: np.ndarray) -> list[float]:
        q, v = y[: self._nq], y[self._nq :]
        margins = {source: source.margins(t, q, v) for source in self._sources}
        return [
            float(margins[g.source][g.index] if isinstance(g, Margin) else g(t, q, v))
            for g in self._quantities
        ]

    def _has_crossed(self) -> bool:
        """Look for a sign change along the last step to halt at, and note it."""
        steps, dips = self._steps, list[_Crossing]()
        for at in range(steps.first, len(steps.t) - 1):
            t0, t1 = steps.t[at : at + 2]
            (y0, y1), (d0, d1) = steps.y[at : at + 2], steps.dy[at : at + 2]
            low, h = t0, t1 - t0
            looks = [(t0, self._before)]
            for x in PLACES:
                # cubic interpolation is enough to see a sign change
                y = interpolate(x, h, (y0, y1), (d0, d1)) if x < 1 else y1
                high = t0 + x * h if x < 1 else t1
                now = self._measure(high, y)
                self._compare(now, low, high)
                looks.append((high, now))
                passed = list(self._halting)
                self._halting = [c for c in passed if not self._passes_over(c.which, high, y)]
                if self._halting:
                    break
                self._before, low = self._measure(high, y) if passed else now, high
                if passed:
                    self._lift_margins()
                    looks = [(high, self._before)]
            dips += self._list_dips(looks, partial(_interpolate_step, steps, at))
            if self._halting:
                break
        self._halting = dips + self._halting
        return bool(self._halting)

    def _list_dips(
        self, looks: Sequence[tuple[float, list[float]]], state: Callable[[float], np.ndarray]
    ) -> list[_Crossing]:
        """Return where quantities may be beyond zero between places of a step, and back."""
        dips = []
        for three in zip(looks, looks[1:], looks[2:], strict=False):
            for k, event in enumerate(self._events):
                sign = 1.0 if three[1][1][k] > 0 else -1.0
                signed = [(t, sign * g[k]) for t, g in three]
                if event.direction * sign > 0 or not turns_low(signed):
                    continue
                size = max(g for _, g in signed)
                dip = _Crossing(k, three[0][0], three[2][0], sign, size)
                if self._find_lowest(dip, state)[1] < NEARLY * size:
                    dips.append(dip)
        return dips

    def _find_lowest(
        self, dip: _Crossing, state: Callable[[float], np.ndarray]
    ) -> tuple[float, float]:
        """Return when a quantity is nearest to zero or farthest beyond it, and its distance."""
        quantity, nq = self._quantities[dip.which], self._nq

        def distance(t: float) -> float:
            y = state(t)
            return dip.sign * float(quantity(t, y[:nq], y[nq:]))

        return find_lowest(distance, dip.low, dip.high)

    def _reach(self, t: float) -> np.ndarray:
        """Return the state at a time within the last look, by integrating from its beginning."""
        steps = self._steps
        reached = advance_within(self._task, steps.t[steps.first], steps.y[steps.first], t)
        steps.evaluations += reached.evaluations
        return reached.y

    def _compare(self, now: list[float], low: float, high: float) -> None:
        for k, (event, g0, g1) in enumerate(zip(self._events, self._before, now, strict=True)):
            rising, falling = g0 < 0 <= g1, g0 > 0 >= g1
            if not ((rising and event.direction >= 0) or (falling and event.direction <= 0)):
                continue
            self._halting.append(_Crossing(k, low, high, 1.0 if falling else -1.0))

    def _passes_over(self, which: int, t: float, y: np.ndarray) -> bool:
        event, corners = self._events[which], self._problem.corners
        return corners is not None and is_switch(event) and corners.passes_over(t, y, event)

    def _locate_first(self) -> tuple[_Crossing, tuple[float, np.ndarray]] | None:
        """Return the first crossing of the last look, with its time and state."""
        first: tuple[_Crossing, tuple[float, np.ndarray]] | None = None
        for crossing in self._halting:
            if crossing.size:
                t, distance = self._find_lowest(crossing, self._reach)
                # what is shallower than the tolerance of the motion only touches
                if distance > -self._task.rtol * crossing.size:
                    continue
                if self._passes_over(crossing.which, t, self._reach(t)):
                    continue
                crossing = crossing._replace(high=t)
            elif first is not None:
                t, y = first[1]
                quantity = self._quantities[crossing.which]
                if quantity(t, y[: self._nq], y[self._nq :]) * crossing.sign > 0:
                    continue  # it passes later
                crossing = crossing._replace(high=t)
            root = self._locate(crossing)
            if root is not None and (first is None or root[0] < first[1][0]):
                first = crossing, root
        return first

    def _locate(self, crossing: _Crossing) -> tuple[float, np.ndarray] | None:
        """Return when and where the quantity is zero, by integrating from the step before."""
        from scipy.optimize import brentq

        steps, quantity, nq = self._steps, self._quantities[crossing.which], self._nq
        low, high, sign, t1 = crossing.low, crossing.high, crossing.sign, steps.t[-1]

        def value(t: float) -> float:
            y = self._reach(t)
            return float(quantity(t, y[:nq], y[nq:]))

        begun = value(low) * sign
        if not begun > NOT_LEFT * abs(value(high)):
            # just after an impact it is zero to rounding, of either sign: find where it has left
            width = high - low
            for halvings in range(1, MAX_HALVINGS):
                if value(low + width / 2**halvings) * sign > 0:
                    low += width / 2**halvings
                    break
            else:
                if not begun > 0:
                    return low, self._reach(low)
        if value(high) * sign > 0:
            high = t1
            if value(high) * sign > 0:
                # the cubic only seemed to cross: what else does by the end of the step is looked at
                now = self._measure(t1, steps.y[-1])
                self._compare(now, crossing.low, t1)
                self._before = now
                return None
        t = float(brentq(value, low, high, xtol=1e-15 * max(1.0, abs(high)), rtol=1e-15))
        return t, self._problem.correct(t, self._reach(t))
