"""Watch a motion while it is integrated: limits, contacts, drift, events, interruption.

What rolls presses on its plane, and a cord pulls; equations of motion know neither. Where the
normal force or a tension passes zero, or friction the coefficient that a contact has, the motion
from there on is that of no real mechanism.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from typing import TYPE_CHECKING, NamedTuple, cast, final

import numpy as np

from mecanique.arrays import Array
from mecanique.errors import InputError, IntegrationError, MecaniqueError
from mecanique.model.constraint_base import PressingContact
from mecanique.model.joint_base import Single
from mecanique.model.mechanism import Mechanism
from mecanique.motion.compile.along import StateLaw
from mecanique.motion.record.curve import PLACES, Curve, Steps, find_falls, interpolate
from mecanique.motion.record.events import Event, Occurrence, Quantity, break_names
from mecanique.motion.simulation.integrators.methods import (
    IntegrationTask,
    StallDetector,
    advance_within,
)
from mecanique.motion.simulation.problem import Outcome, Problem
from mecanique.motion.tolerances import AT_LIMIT, SHORTEST_FLIGHT, TINY
from mecanique.motion.trajectory import Trajectory

if TYPE_CHECKING:
    from mecanique.reference import Reference


def contact_events(mechanism: Mechanism, *, stop: bool = False) -> tuple[Event, ...]:
    """Return the events at which contacts and cords cease to hold.

    `simulate` finds them by itself in the motion it returns; given to it, they can stop it.

    Args:
        mechanism: a mechanism with contacts or cords.
        stop: whether a motion ends at the first of them.

    Returns:
        The events, to be given to `simulate`.

    Example:
        >>> machine = mq.textbook.load("atwood_machine")
        >>> [event.name for event in mq.contact_events(machine)]
        ['cord_1 would push', 'cord_2 would push']
    """
    names = break_names(mechanism)
    return tuple(Event(name, LimitMargin(mechanism, k), -1, stop) for k, name in enumerate(names))


def find_breaks(reference: Reference, curve: Curve) -> tuple[Occurrence, ...]:
    """Return where along a motion contacts and cords cease to hold, amiss at its start or later."""
    t, q, v = curve.t[:1], curve.q[:1], curve.v[:1]
    (begin,), (at_start,) = t.tolist(), margins_along(reference, q, v, t)
    falls = find_falls(curve, lambda t, q, v: margins_along(reference, q, v, t))
    breaks = []
    for name, margin, times in zip(break_names(reference.mechanism), at_start, falls, strict=True):
        for moment in [begin, *times] if margin < 0 else times:
            state = curve(moment)
            breaks.append(Occurrence(name, moment, state.q, state.v, state.v))
    return tuple(breaks)


def margins_along(reference: Reference, q: Array, v: Array, t: Array) -> Array:
    """Return what contacts and cords have left in n states, in the order of `break_names` [N].

    Normal forces, reserves of friction and tensions, shape (n, names); NaN if undetermined.
    """
    mechanism, columns = reference.mechanism, list[Array]()
    pressed = pressings(reference, q, v, t)
    contacts = [c for c in mechanism.contacts if isinstance(c, PressingContact)]
    for contact, (normal, friction) in zip(contacts, pressed, strict=True):
        columns.append(normal)
        if contact.friction is not None:
            columns.append(mechanism.evaluate(contact.friction) * normal - friction)
    tensions = [name for element in mechanism.elements for name in element.tensions]
    if tensions:
        forces = StateLaw(mechanism, reference).guide_forces(t, q, v)
        columns += [forces[name] for name in tensions]
    margins: Array = np.array(columns).reshape(-1, len(t)).T
    return margins


def pressings(reference: Reference, q: Array, v: Array, t: Array) -> Array:
    """Return normal force and friction of all that rolls in n states, shape (contacts, 2, n) [N].

    NaN where they are undetermined.
    """
    contacts = [c for c in reference.mechanism.contacts if isinstance(c, PressingContact)]
    if not contacts:
        return np.zeros((0, 2, len(t)))
    by_name = StateLaw(reference.mechanism, reference).multipliers(t, q, v)
    pressed = []
    for contact in contacts:
        N, x, y = (by_name[f"{contact.name}: {row}"] for row in contact.rows)
        pressed.append((N, np.hypot(x, y)))
    return np.array(pressed)


@final
@dataclass(frozen=True)
class LimitMargin:
    """The margin to one of the limits, as the quantity of an event."""

    mechanism: Mechanism
    which: int

    def __call__(self, t: float, q: Array, v: Array) -> float:
        """Return the margin [N]."""
        from mecanique.reference import Reference

        reference = Reference.of(self.mechanism)
        return float(margins_along(reference, q[None], v[None], np.array([t]))[0, self.which])


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
        task: IntegrationTask,
        steps: Steps,
        interruption: Interruption,
        reconsider: Callable[[int, float], bool] | None,
    ) -> None:
        mechanism, rates, corners = problem.mechanism, problem.code.rates, problem.corners
        self.interruption = interruption
        self._reconsider = reconsider
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
        self._switches = {event.name for event in (corners.events if corners else ())}
        self._before = self._measure(steps.t[-1], steps.y[-1])  # each quantity at the last step
        self._lift_margins()
        self._to_record: list[_Crossing] = []
        self._halting: _Crossing | None = None
        self._found: list[Occurrence] = []
        self._last_impact: dict[str, float] = {}
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
            if isinstance(event.when, LimitMargin) and margin < 0
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
        problem, loops = self._problem, self._problem.loops
        if problem.progress is not None and t >= self._next_report:
            if (outcome := problem.report(t)) is not None:
                return outcome
            self._next_report = t + (problem.end - problem.t0) / 100
        halts = (
            (self._events and self._has_crossed())
            or (loops is not None and loops.has_left(t, y))
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
        if event.name in self._switches:
            return self._switch(t, y, event.name)
        q, v = y[: self._nq], y[self._nq :]
        after = v
        if event.name in self._impacts:
            after = self._impacts[event.name](
                t, q, v, partial(self._problem.reference.response, q, t)
            )
        self._found.append(Occurrence(event.name, t, q, v, after))
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

    def _switch(self, t: float, y: np.ndarray, name: str) -> Outcome | None:
        """Change the mode at the last step's end."""
        assert self._problem.corners is not None, "elements switch"
        try:
            y, happened = self._problem.corners.switch(t, y, name)
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
                # cubic interpolation is enough to see a sign change
                y = interpolate(x, h, (y0, y1), (d0, d1)) if x < 1 else y1
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
