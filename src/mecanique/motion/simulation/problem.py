"""An initial value problem of a mechanism, and the result of integrating it."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Literal, TypeAlias, final

import numpy as np

from mecanique.model.mechanism import Mechanism
from mecanique.motion.compile.cache import Compiled, compile_once
from mecanique.motion.record.curve import Curve, State
from mecanique.motion.record.events import Event, Occurrence
from mecanique.motion.record.loops import ClosedLoops

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
    def code(self) -> Compiled:
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
    path: Curve | Callable[[], Curve]  # the curve, or what makes it
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
