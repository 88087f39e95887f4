"""What is integrated: the equations of a mechanism from a start to an end, and how accurately."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING, final

import numpy as np

from mecanique.model.mechanism import Mechanism
from mecanique.motion.compile.cache import Compiled, compile_once
from mecanique.motion.record.curve import Curve, State
from mecanique.motion.record.events import Event, Occurrence
from mecanique.motion.record.loops import ClosedLoops
from mecanique.motion.simulation.outcome import Outcome

if TYPE_CHECKING:
    from mecanique.reference import Reference

__all__ = ["Course", "Integration", "Problem"]


@final
@dataclass(frozen=True)
class Problem:
    """An initial value problem of a mechanism.

    Args:
        mechanism: what moves.
        reference: the mechanism inside the engine.
        loops: keeps the loops closed, if there are any.
        start: shape (nq + nv,), the state at the start.
        t0: time at the start [s].
        end: time at the end [s].
        times: shape (n,), of the samples [s].
        rtol: relative tolerance of a step.
        atol: absolute tolerance of a step.
        max_step: longest step, infinite if it need not be bounded [s].
        max_steps: most steps.
        events: what to watch for.
        progress: called with the fraction done.
    """

    mechanism: Mechanism
    reference: Reference
    loops: ClosedLoops | None
    start: np.ndarray
    t0: float
    end: float
    times: np.ndarray
    rtol: float
    atol: float
    max_step: float
    max_steps: int
    events: tuple[Event, ...]
    progress: Callable[[float], object] | None

    @property
    def code(self) -> Compiled:
        """What is compiled for the mechanism."""
        return compile_once(self.mechanism)


@final
@dataclass(frozen=True)
class Course:
    """A motion's samples, its path between them and the events on it."""

    samples: State
    path: Curve | Callable[[], Curve]
    events: tuple[Occurrence, ...] = ()


@final
@dataclass(frozen=True)
class Integration:
    """What an integration yields, as far as it went.

    Args:
        outcome: how it ended.
        t: the time it reached [s].
        y: shape (nq + nv,), the state there; None if the equations fail at the start.
        steps: number of steps.
        evaluations: number of evaluations of the equations.
        rtol: relative tolerance that the steps were taken to.
        course: gives the course until then; None if there is none.
    """

    outcome: Outcome
    t: float
    y: np.ndarray | None
    steps: int
    evaluations: int
    rtol: float
    course: Callable[[], Course] | None
