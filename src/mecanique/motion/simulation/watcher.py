"""What is watched between the integrator's steps: events, impacts, drift, progress, interruption."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import partial
from typing import Any, final

import numpy as np

from mecanique.model.mechanism import Mechanism
from mecanique.motion.record.curve import Curve
from mecanique.motion.record.events import Event, Occurrence
from mecanique.motion.record.loops import Closing
from mecanique.motion.record.rates import Rates
from mecanique.motion.record.steps import Steps
from mecanique.motion.simulation.methods import Task, advance

__all__ = ["Watcher"]

PLACES = (0.25, 0.5, 0.75, 1.0)
"""Fractions of a step at which events are looked for."""

SHORTEST_FLIGHT = 1e-9
"""Impacts that follow each other faster than this fraction of the duration are a lasting contact."""


@final
class Watcher:
    """Looks at each step and says whether the integration must halt there; `settle` then does what is to be done.

    Args:
        mechanism: what moves.
        reference: its `Reference`.
        rates: the maps between v and q̇.
        task: the equations and tolerances.
        steps: the steps so far.
        events: what to watch for.
        progress: called with the fraction done.
        span: start and end of the motion [s].
        closing: keeps the loops closed, if there are any.

    Raises:
        UnknownNameError: if an event depends on a name that does not exist.
        InputError: if an impact depends on velocities.
    """

    def __init__(
        self,
        mechanism: Mechanism,
        reference: Any,
        rates: Rates,
        task: Task,
        steps: Steps,
        events: Sequence[Event],
        progress: Callable[[float], object] | None,
        span: tuple[float, float],
        closing: Closing | None = None,
    ) -> None:
        self.interrupted = False
        self.reconsider: Callable[[float], bool] | None = None
        """Says at a time whether another method would pay; the integration then halts and is `reconsidered`."""
        self.reconsidered = False
        self.contact = ""
        self._reference = reference
        self._rates = rates
        self._task = task
        self._steps = steps
        self._nq = mechanism.nq
        self._events = tuple(events)
        self._quantities = [event.quantity(mechanism) for event in events]
        self._impacts = {
            e.name: e.impact(mechanism, rates) for e in events if e.restitution is not None
        }
        self._before: list[float] = []  # each quantity at the last step
        self._crossings: list[tuple[int, float, float]] = []  # event, and the times it lies between
        self._found: list[Occurrence] = []
        self._pending: tuple[int, float, float, float] | None = None
        self._last_impact: dict[str, float] = {}
        self._progress = progress
        self._span = span
        self._next = span[0]
        self._most_drift = 10 * task.rtol if rates.balls else float("inf")
        self._closing = closing
        self.idle = not (events or progress or rates.balls or closing)
        """Whether nothing but an interruption is watched for."""

    def __call__(self) -> bool:
        """Look at the last step; return whether to halt."""
        if self.interrupted:
            return True
        if self.reconsider is not None and self.reconsider(self._steps.t[-1]):
            self.reconsidered = True
            return True
        if self.idle:
            return False
        t, y = self._steps.t[-1], self._steps.y[-1]
        if self._progress is not None and t >= self._next:
            begin, end = self._span
            self._progress((t - begin) / (end - begin))
            self._next = t + (end - begin) / 100
        if self._events and self._crossed():
            return True
        if self._closing is not None and self._closing.has_left(t, y):
            return True
        return self._rates.drift(y[: self._nq]) > self._most_drift

    def start(self) -> None:
        """Note the quantities at the start, the first of the steps."""
        self._before = self._measured(self._steps.t[-1], self._steps.y[-1])

    def settle(self) -> bool:
        """Do what the last step asks for; return whether the motion ends there."""
        steps = self._steps
        t, y = steps.t[-1], self.renormalized(steps.t[-1], steps.y[-1])
        if self._pending is None:
            steps.end_at(t, y, self._task.rhs)
            return False
        which, low, high, sign = self._pending
        self._pending = None
        event = self._events[which]
        found = self._located(which, low, high, sign)
        if found is None:
            steps.end_at(t, y, self._task.rhs)
            return False
        t, y = found
        self._crossings = [(k, a, min(b, t)) for k, a, b in self._crossings if a < t]
        steps.end_at(t, y, self._task.rhs)
        q, v = y[: self._nq], y[self._nq :]
        after = v
        if event.name in self._impacts:
            after = self._impacts[event.name](t, q, v, partial(self._reference.response, q, t))
        self._found.append(Occurrence(event.name, t, q, v, after))
        if event.stop:
            return True
        flight = t - self._last_impact.get(event.name, -np.inf)
        if flight < SHORTEST_FLIGHT * (self._span[1] - self._span[0]):
            self.contact = event.name
            return True
        self._last_impact[event.name] = t
        y = np.concatenate([q, after])
        steps.break_here(y, self._task.rhs(t, y))
        self._before = self._measured(t, y)
        self._before[which] = sign * 1e-300  # it bounces back to the side it came from
        return False

    def occurrences(self, curve: Curve) -> tuple[Occurrence, ...]:
        """Return the events that took place, in the order of time.

        Args:
            curve: the motion.
        """
        from scipy.optimize import brentq

        for which, low, high in self._crossings:
            quantity = self._quantities[which]

            def value(t: float, quantity: Any = quantity) -> float:
                state = curve(t)
                return float(quantity(t, state.q, state.v))

            high = min(high, float(curve.t[-1]))
            at_low, at_high = value(low), value(high)
            if (
                at_low * at_high > 0
            ):  # the rough look and the motion differ: it only comes near zero
                continue
            t = (
                low
                if at_low == 0
                else high
                if at_high == 0
                else float(brentq(value, low, high, xtol=1e-14, rtol=1e-14))
            )
            state = curve(t)
            self._found.append(Occurrence(self._events[which].name, t, state.q, state.v, state.v))
        self._crossings = []
        return tuple(sorted(self._found, key=lambda occurrence: occurrence.t))

    def _measured(self, t: float, y: np.ndarray) -> list[float]:
        q, v = y[: self._nq], y[self._nq :]
        return [float(quantity(t, q, v)) for quantity in self._quantities]

    def renormalized(self, t: float, y: np.ndarray) -> np.ndarray:
        """Return the state on the loops, and with unit quaternions, next to a state.

        Args:
            t: its time [s].
            y: shape (nq + nv,).
        """
        if self._closing is not None:
            return self._closing.back(t, y)
        return np.concatenate([self._rates.normalized(y[: self._nq]), y[self._nq :]])

    def _crossed(self) -> bool:
        """Look for sign changes along the last step; note those to record, and the first to halt at."""
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
                now = self._measured(high, y)
                self._compare(now, low, high)
                if self._pending is not None:
                    return True
                self._before, low = now, high
        return False

    def _compare(self, now: list[float], low: float, high: float) -> None:
        for k, (event, g0, g1) in enumerate(zip(self._events, self._before, now, strict=True)):
            rising, falling = g0 < 0 <= g1, g0 > 0 >= g1
            if not ((rising and event.direction >= 0) or (falling and event.direction <= 0)):
                continue
            if not event.stop and event.restitution is None:
                self._crossings.append((k, low, high))
            elif self._pending is None:
                self._pending = k, low, high, 1.0 if falling else -1.0

    def _located(
        self, which: int, low: float, high: float, sign: float
    ) -> tuple[float, np.ndarray] | None:
        """Return when and in which state the quantity is zero, by integrating from the step before."""
        from scipy.optimize import brentq

        steps = self._steps
        t0, y0, t1 = steps.t[steps.first], steps.y[steps.first], steps.t[-1]
        quantity, nq = self._quantities[which], self._nq

        def value(t: float) -> float:
            y = advance(self._task, t0, y0, t)
            return float(quantity(t, y[:nq], y[nq:]))

        if (
            not value(low) * sign > 0
        ):  # just after an impact it is zero to rounding: find where it has left
            width = high - low
            for halvings in range(1, 50):
                if value(low + width / 2**halvings) * sign > 0:
                    low += width / 2**halvings
                    break
            else:
                return low, advance(self._task, t0, y0, low)
        if value(high) * sign > 0:
            high = t1
            if value(high) * sign > 0:
                self._before = self._measured(t1, steps.y[-1])
                return None
        t = float(brentq(value, low, high, xtol=1e-15 * max(1.0, abs(high)), rtol=1e-15))
        return t, self.renormalized(t, advance(self._task, t0, y0, t))
