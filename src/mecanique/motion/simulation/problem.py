"""An initial value problem of a mechanism: its arguments, and the result of integrating it."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Literal, TypeAlias, final

import numpy as np

from mecanique.errors import InputError
from mecanique.model import Mechanism, Record
from mecanique.model.expression import finite
from mecanique.motion.compile.cache import CompiledMotion, compile_once
from mecanique.motion.record.curve import Curve, LaterCurve, State
from mecanique.motion.record.events import Event, Occurrence
from mecanique.motion.record.loops import ClosedLoops
from mecanique.motion.tolerances import GREATEST_RTOL, KINKS_APART, LEAST_RTOL, LOST, SAMPLES_APART

if TYPE_CHECKING:
    from mecanique.motion.switching.corners import Corners
    from mecanique.reference import Reference

Kind: TypeAlias = Literal[
    "end",
    "event",
    "contact",
    "halt",
    "reconsider",
    "interrupted",
    "stiff",
    "undecided",
    "too many steps",
    "step too small",
    "no headway",
    "not finite",
    "progress",
    "fault",
]


@final
@dataclass(frozen=True)
class Outcome:
    """How an integration ended, or a stretch of it.

    Args:
        kind: "end" if it came to its end, "event" if an event ended it, "contact" if impacts
            followed each other without end; "halt" if a stretch ended because its last step needs
            a correction; "reconsider" if another method may pay; "interrupted" by Ctrl-C; "stiff",
            "too many steps", "step too small" or "no headway" if the method gave up; "undecided" if
            no mode follows, or several; "not finite"
            if the acceleration at the start is not; "progress" or "fault" if `progress`, or the
            equations, raised an exception.
        fault: what was raised.
    """

    kind: Kind
    fault: BaseException | None = None

    @property
    def complete(self) -> bool:
        """Whether the motion ends where it should."""
        return self.kind in ("end", "event")

    @property
    def accurate(self) -> bool:
        """Whether the equations are defined up to the last step, so that it can be refined."""
        return self.kind in ("end", "event", "contact")


@final
@dataclass(frozen=True)
class Problem:
    """An initial value problem of a mechanism."""

    mechanism: Mechanism
    reference: Reference
    loops: ClosedLoops | Corners | None
    start: np.ndarray  # shape (nq + nv,), the state at the start
    t0: float  # time at the start [s]
    end: float  # time at the end [s]
    times: np.ndarray  # shape (n,), of the samples [s]
    rtol: float
    atol: float
    max_step: float  # longest step, infinite if it need not be bounded [s]
    max_steps: int
    events: tuple[Event, ...]
    ends: tuple[Event, ...]  # of these, those at which a coordinate comes to the end of its chart
    progress: Callable[[float], object] | None
    corners: Corners | None = None  # what switches on the way

    @property
    def asked(self) -> tuple[Event, ...]:
        """The events that were asked for."""
        return tuple(event for event in self.events if event not in self.ends)

    @property
    def first(self) -> State:
        """The state at the start."""
        nq = self.mechanism.nq
        return State(self.t0, self.start[:nq], self.start[nq:])

    @property
    def code(self) -> CompiledMotion:
        """What is compiled for the mechanism."""
        return compile_once(self.mechanism)

    def with_way_back(self, close: Callable[[float, np.ndarray], np.ndarray | None]) -> Problem:
        """Return the same with a quicker way onto the loops, which may leave some states alone."""
        return replace(self, loops=ClosedLoops(self.reference, self.rtol, close))

    def correct(self, t: float, y: np.ndarray) -> np.ndarray:
        """Return the state on the loops, and with unit quaternions, next to a state."""
        if self.loops is not None:
            return self.loops.close(t, y)
        nq = self.mechanism.nq
        return np.concatenate([self.code.rates.normalize(y[:nq]), y[nq:]])

    def report(self, t: float) -> Outcome | None:
        """Report the progress; return how it ends the motion if that raises an exception."""
        if self.progress is not None:
            try:
                self.progress((t - self.t0) / (self.end - self.t0))
            except Exception as error:
                return Outcome("progress", error)
        return None


@final
@dataclass(frozen=True)
class Course:
    """A motion's samples, its path between them and the events on it."""

    samples: State
    path: Curve | LaterCurve  # the curve, or what makes it
    events: tuple[Occurrence, ...] = ()
    outcome: Outcome | None = None  # how it ends, if earlier than the integration


@final
@dataclass(frozen=True)
class Integration:
    """The result of an integration, as far as it went."""

    outcome: Outcome
    t: float  # the time it reached [s]
    # shape (nq + nv,), the state there; None if the equations fail at the start
    y: np.ndarray | None
    steps: int
    evaluations: int
    rtol: float  # relative tolerance that the steps were taken to
    course: Callable[[], Course] | None  # gives the course until then; None if there is none


Values: TypeAlias = Sequence[float] | np.ndarray | Mapping[str, float]
"""Numbers in order, or by name."""


def refuse_still(mechanism: Mechanism) -> None:
    """Raise if a mechanism has no coordinate."""
    if not mechanism.nv:
        raise InputError(
            f"mechanism {mechanism.name!r} has no coordinate, so nothing in it can be set in motion"
        )


def span_and_tolerances(
    t0: float, duration: float, rtol: float, atol: float | None
) -> tuple[float, float, float, float]:
    """Return start, end and tolerances, checked."""
    t0, duration = finite(t0, "the start time t0"), finite(duration, "the duration")
    if not duration > 0:
        raise InputError(f"expected a positive duration [s], got {duration:g}")
    if not t0 + duration * LOST > t0:
        raise InputError(
            "expected a duration that is not lost beside the start time, "
            f"got {duration:g} at {t0:g} s"
        )
    rtol = finite(rtol, "the relative tolerance rtol")
    if not LEAST_RTOL <= rtol <= GREATEST_RTOL:
        raise InputError(f"expected a relative tolerance rtol in 1e-14…0.1, got {rtol:g}")
    atol = rtol if atol is None else finite(atol, "the absolute tolerance atol")
    if not atol > 0:
        raise InputError(f"expected a positive absolute tolerance atol, got {atol:g}")
    return t0, t0 + duration, rtol, atol


MOST_SAMPLES = 1e8
"""Of a motion; ten coordinates of as many take 8 GB each of positions and velocities."""


def sample_times(
    t0: float, end: float, fps: float, samples: int | Sequence[float] | np.ndarray | None
) -> np.ndarray:
    """Return the times of the samples, shape (n,) [s]."""
    if samples is None:
        fps = finite(fps, "the samples per second fps")
        if not fps > 0:
            raise InputError(f"expected a positive number of samples per second fps, got {fps:g}")
        count = (end - t0) * fps
        if count > MOST_SAMPLES:
            raise InputError(
                f"expected fewer than {MOST_SAMPLES:,.0f} samples, got {count:.3g}; choose a "
                "smaller fps"
            )
        whole = int(np.ceil(count - SAMPLES_APART))
        times: np.ndarray = t0 + np.arange(whole + 1) / fps
        times[-1] = end
        return times
    if isinstance(samples, (int, np.integer)) and not isinstance(samples, bool):
        if samples < 2:
            raise InputError(f"expected at least 2 samples, got {samples}")
        if samples > MOST_SAMPLES:
            raise InputError(f"expected at most {MOST_SAMPLES:g} samples, got more")
        return np.array([t0, end]) if samples == 2 else np.linspace(t0, end, int(samples))
    try:
        times = np.array(samples, dtype=float)
    except (TypeError, ValueError, OverflowError):
        raise InputError(f"expected a number of samples or their times, got {samples!r}") from None
    if (
        times.ndim != 1
        or not len(times)
        or not np.isfinite(times).all()
        or (np.diff(times) <= 0).any()
    ):
        raise InputError("expected increasing finite sample times, shape (n,)")
    if times[0] < t0 or times[-1] > end:
        raise InputError(
            f"expected sample times in {t0:g}…{end:g} s, got {times[0]:g}…{times[-1]:g} s"
        )
    return times


def longest_step(
    mechanism: Mechanism, span: float, given: float | None, events: Sequence[Event]
) -> float:
    """Return the longest step that the integrator may take [s]."""
    if given is not None:
        given = finite(given, "the longest step max_step")
        if not given > 0:
            raise InputError(f"expected a positive longest step max_step [s], got {given:g}")
        return given
    for event in events:
        if not isinstance(event, Event):
            raise InputError(f"expected events of type Event, got {event!r}")
    blind = any(callable(i.signal) and not isinstance(i.signal, Record) for i in mechanism.inputs)
    return span / 50 if blind or events else float("inf")


def kinks(mechanism: Mechanism, t0: float, end: float) -> list[float]:
    """Return the times at which a sampled input has a kink [s]; no step may reach across."""
    records = [i.signal.times for i in mechanism.inputs if isinstance(i.signal, Record)]
    if not records:
        return []
    times = np.unique(np.concatenate(records))
    least = KINKS_APART * (end - t0)
    inside: list[float] = times[(times > t0 + least) & (times < end - least)].tolist()
    return inside
