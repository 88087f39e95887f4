"""Watch the integrator's steps: events, impacts, drift, progress, interruption."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from typing import NamedTuple, final

import numpy as np

from mecanique.errors import MecaniqueError
from mecanique.motion.record.curve import Curve
from mecanique.motion.record.events import Occurrence, Quantity
from mecanique.motion.record.steps import Steps
from mecanique.motion.simulation.integrators.methods import Task, advance_within
from mecanique.motion.simulation.integrators.stalling import StallDetector
from mecanique.motion.simulation.problem import Outcome, Problem
from mecanique.motion.simulation.watching.validity import Margin

PLACES = (0.25, 0.5, 0.75, 1.0)
"""Fractions of a step at which events are checked."""

SHORTEST_FLIGHT = 1e-9
"""Impacts closer together than this fraction of the duration are a lasting contact."""

TINY = 1e-300
"""Stands for zero with a sign."""

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


@final
class Watcher:
    """Looks at each step, the start first, and says whether the integration must halt."""

    def __init__(
        self,
        problem: Problem,
        task: Task,
        steps: Steps,
        interruption: Interruption,
        reconsider: Callable[[int, float], bool] | None,
    ) -> None:
        mechanism, rates = problem.mechanism, problem.code.rates
        self.interruption = interruption
        self._reconsider = reconsider
        self._reference = problem.reference
        self._loops = problem.loops
        self._problem = problem
        self._rates = rates
        self._task = task
        self._steps = steps
        self._nq = mechanism.nq
        self._events = problem.events
        self._quantities = [event.quantity(mechanism) for event in problem.events]
        self._impacts = {
            event.name: event.impact(mechanism, rates)
            for event in problem.events
            if event.restitution is not None
        }
        self._corners = problem.corners
        self._switches = {
            event.name for event in (problem.corners.events if problem.corners else ())
        }
        self._before = self._measure(steps.t[-1], steps.y[-1])  # each quantity at the last step
        self._lift_margins()
        self._to_record: list[_Crossing] = []
        self._halting: _Crossing | None = None
        self._found: list[Occurrence] = []
        self._last_impact: dict[str, float] = {}
        self._progress = problem.progress
        self._begin, self._duration = problem.t0, problem.end - problem.t0
        self._next_report = problem.t0
        self._stalls = StallDetector(problem, implicit=task.implicit)
        self._most_drift = 10 * task.rtol if rates.balls else float("inf")
        self._idle = not (problem.events or problem.progress or rates.balls or problem.loops)

    def start(self) -> Outcome | None:
        """Note what is amiss with contacts and cords from the start; return how that ends all."""
        t, y = self._steps.t[0], self._steps.y[0]
        q, v = y[: self._nq], y[self._nq :]
        amiss = [
            event
            for event, margin in zip(self._events, self._before, strict=True)
            if isinstance(event.when, Margin) and margin < 0
        ]
        self._found += [Occurrence(event.name, t, q, v, v) for event in amiss]
        return Outcome("event") if any(event.stop for event in amiss) else None

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
        if self._progress is not None and t >= self._next_report:
            try:
                self._progress((t - self._begin) / self._duration)
            except Exception as error:
                return Outcome("progress", error)
            self._next_report = t + self._duration / 100
        halts = (
            (self._events and self._has_crossed())
            or (self._loops is not None and self._loops.has_left(t, y))
            or self._rates.drift(y[: self._nq]) > self._most_drift
        )
        return Outcome("halt") if halts else None

    def settle(self) -> Outcome | None:
        """Correct the last step: end it at an event or on the loops; return how all ends there."""
        steps, crossing = self._steps, self._halting
        self._halting = None
        root = None if crossing is None else self._locate(crossing)
        if crossing is None or root is None:
            t = steps.t[-1]
            steps.end_at(t, self._problem.correct(t, steps.y[-1]), self._task.rhs)
            return None
        t, y = root
        self._to_record = [
            late._replace(high=min(late.high, t)) for late in self._to_record if late.low < t
        ]
        steps.end_at(t, y, self._task.rhs)
        event = self._events[crossing.which]
        if self._corners is not None and event.name in self._switches:
            return self._switch(t, y, event.name)
        q, v = y[: self._nq], y[self._nq :]
        after = v
        if event.name in self._impacts:
            after = self._impacts[event.name](t, q, v, partial(self._reference.response, q, t))
        self._found.append(Occurrence(event.name, t, q, v, after))
        if event.stop:
            return Outcome("event")
        if t - self._last_impact.get(event.name, -np.inf) < SHORTEST_FLIGHT * self._duration:
            return Outcome("contact")
        self._last_impact[event.name] = t
        y = np.concatenate([q, after])
        steps.break_here(y, self._task.rhs(t, y))
        self._before = self._measure(t, y)
        # zero to rounding, but it bounces back to the side it came from
        self._before[crossing.which] = crossing.sign * TINY
        return None

    def _switch(self, t: float, y: np.ndarray, name: str) -> Outcome | None:
        """Change the mode at the last step's end."""
        assert self._corners is not None, "elements switch"
        try:
            y, happened = self._corners.switch(t, y, name)
        except MecaniqueError as error:
            return Outcome("undecided", error)
        self._found += happened
        self._steps.break_here(y, self._task.rhs(t, y))
        self._before = self._measure(t, y)
        self._lift_margins()
        return None

    def _lift_margins(self) -> None:
        """Take margins that begin at zero, to rounding, for positive: a mode begins sound."""
        for k, event in enumerate(self._events):
            if event.name in self._switches:
                self._before[k] = max(self._before[k], TINY)

    def occurrences(self, curve: Curve) -> tuple[Occurrence, ...]:
        """Return the events that took place, in the order of time."""
        last = float(curve.t[-1])
        for crossing in self._to_record:
            from scipy.optimize import brentq  # takes longer to import than most motions

            if crossing.low >= last:
                continue  # the curve was cut before
            quantity = self._quantities[crossing.which]

            def value(t: float, quantity: Quantity = quantity) -> float:
                state = curve(t)
                return float(quantity(t, state.q, state.v))

            low, high = crossing.low, min(crossing.high, last)
            at_low, at_high = value(low), value(high)
            if at_low * at_high > 0:
                continue  # on the curve it only comes near zero
            if at_low == 0:
                t = low
            elif at_high == 0:
                t = high
            else:
                t = float(brentq(value, low, high, xtol=1e-14, rtol=1e-14))
            state = curve(t)
            name = self._events[crossing.which].name
            self._found.append(Occurrence(name, t, state.q, state.v, state.v))
        self._to_record = []
        return tuple(sorted(self._found, key=lambda occurrence: occurrence.t))

    def _measure(self, t: float, y: np.ndarray) -> list[float]:
        q, v = y[: self._nq], y[self._nq :]
        return [float(quantity(t, q, v)) for quantity in self._quantities]

    def _has_crossed(self) -> bool:
        """Look for sign changes along the last step, and note those to record or to halt at."""
        steps = self._steps
        for at in range(steps.first, len(steps.t) - 1):
            t0, t1 = steps.t[at : at + 2]
            (y0, y1), (d0, d1) = steps.y[at : at + 2], steps.dy[at : at + 2]
            low, h = t0, t1 - t0
            for x in PLACES:
                # cubic Hermite interpolation is enough to see a sign change
                a, b = (1 + 2 * x) * (1 - x) ** 2, x * x * (3 - 2 * x)
                y = a * y0 + b * y1 + h * x * (1 - x) * ((1 - x) * d0 - x * d1) if x < 1 else y1
                high = t0 + x * h if x < 1 else t1
                now = self._measure(high, y)
                self._compare(now, low, high)
                if self._halting is not None:
                    return True
                self._before, low = now, high
        return False

    def _compare(self, now: list[float], low: float, high: float) -> None:
        for k, (event, g0, g1) in enumerate(zip(self._events, self._before, now, strict=True)):
            rising, falling = g0 < 0 <= g1, g0 > 0 >= g1
            if not ((rising and event.direction >= 0) or (falling and event.direction <= 0)):
                continue
            crossing = _Crossing(k, low, high, 1.0 if falling else -1.0)
            switches = event.name in self._switches
            if not event.stop and event.restitution is None and not switches:
                self._to_record.append(crossing)
            elif self._halting is None:
                self._halting = crossing

    def _locate(self, crossing: _Crossing) -> tuple[float, np.ndarray] | None:
        """Return when and where the quantity is zero, by integrating from the step before."""
        from scipy.optimize import brentq

        steps = self._steps
        t0, y0, t1 = steps.t[steps.first], steps.y[steps.first], steps.t[-1]
        quantity, nq = self._quantities[crossing.which], self._nq
        low, high, sign = crossing.low, crossing.high, crossing.sign

        def state(t: float) -> np.ndarray:
            reached = advance_within(self._task, t0, y0, t)
            steps.evaluations += reached.evaluations
            return reached.y

        def value(t: float) -> float:
            y = state(t)
            return float(quantity(t, y[:nq], y[nq:]))

        if not value(low) * sign > 0:
            # just after an impact it is zero to rounding: find where it has left
            width = high - low
            for halvings in range(1, MAX_HALVINGS):
                if value(low + width / 2**halvings) * sign > 0:
                    low += width / 2**halvings
                    break
            else:
                return low, state(low)
        if value(high) * sign > 0:
            high = t1
            if value(high) * sign > 0:
                self._before = self._measure(t1, steps.y[-1])
                return None
        t = float(brentq(value, low, high, xtol=1e-15 * max(1.0, abs(high)), rtol=1e-15))
        return t, self._problem.correct(t, state(t))
