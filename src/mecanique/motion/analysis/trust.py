"""Estimate how long a motion can be trusted: its error, and how errors grow."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, final

import numpy as np

from mecanique.arrays import spread
from mecanique.errors import InputError
from mecanique.motion.record.loops import ClosedLoops
from mecanique.motion.simulation.choice import COMPILED, Choice, first_choice, method_in
from mecanique.motion.simulation.integrate import failure, integrate
from mecanique.motion.simulation.integrators.methods import (
    METHODS,
    EquationsError,
    IntegrationTask,
    advance,
    step_accuracy,
)
from mecanique.motion.simulation.problem import Problem, longest_step
from mecanique.motion.simulation.watching import limit_events
from mecanique.motion.tolerances import LEAST_RTOL, LYAPUNOV_RTOL, NO_STATE, SEPARATION
from mecanique.motion.trajectory import start_of
from mecanique.wording import Legible

if TYPE_CHECKING:
    from mecanique.motion.trajectory import Trajectory


SMALLER = 100.0
"""How many times smaller the tolerance of the second integration is."""

LARGER = 4.0
"""The same of the quick estimate, how many times larger: less work than the motion was, and errors
so many times larger, as they go with the tolerance, so that the difference bounds the motion's."""

MOST_COMPARED = 2000
"""The quick estimate looks at so many of the samples."""

STRETCHES = 60
"""Number of stretches over which the departure is averaged."""


@final
@dataclass(frozen=True, repr=False)
class Trust(Legible):
    """How far a motion can be trusted.

    Args:
        until: the error stays within the accuracy until then [s].
        end: the motion's end [s].
        accuracy: the error accepted, relative to the largest coordinate.
        error: largest relative difference to the motion with a smaller tolerance.
        lyapunov: largest Lyapunov exponent, an estimate over the motion [1/s].
    """

    until: float
    end: float
    accuracy: float
    error: float
    lyapunov: float

    def __str__(self) -> str:
        reach = "to its end" if self.until >= self.end else f"to t = {self.until:.4g} s"
        text = (
            f"trustworthy {reach} (error within {self.accuracy:g}; largest found {self.error:.1e})"
        )
        text += f"; largest Lyapunov exponent about {self.lyapunov:.2g} 1/s"
        if self.lyapunov * (self.end - 0) > 5:
            text += f": errors grow tenfold every {np.log(10) / self.lyapunov:.2g} s"
        return text


def trust(motion: Trajectory, accuracy: float) -> Trust:
    """Integrate again with a smaller tolerance and follow a neighboring motion.

    The exponent is the mean of the neighbor's departure, brought back to its first distance after
    each stretch (Benettin, Galgani & Strelcyn, Phys. Rev. A 14 (1976) 2338).
    """
    begin, end = float(motion.curve.t[0]), float(motion.curve.t[-1])
    # when exactly it breaks may differ, and with that on which side of the break a state is
    smooth = ~np.isin(motion.t, motion.curve.t[motion.curve.breaks[1:]])
    motion = replace(motion, t=motion.t[smooth], q=motion.q[smooth], v=motion.v[smooth])
    finer = _integrate_again(motion, motion.t, 1 / SMALLER)
    states = np.hstack([motion.q, motion.v])[: len(finer)]
    size = np.maximum(np.abs(states).max(axis=0), NO_STATE + np.abs(states).max() * 1e-3)
    error = np.abs((states - finer[: len(states)]) / size).max(axis=1)
    # an error once made does not count as gone because two motions happen to meet again
    beyond = np.flatnonzero(error > accuracy)
    until = end if not len(beyond) else float(motion.t[max(beyond[0] - 1, 0)])
    return Trust(until, end, accuracy, float(error.max()), _lyapunov(motion, begin, end))


def estimate_errors(motion: Trajectory) -> np.ndarray:
    """Return how far each of (q, v) may be off anywhere, by steps to a larger tolerance."""
    seen = spread(len(motion.t), MOST_COMPARED)
    states = np.hstack([motion.q, motion.v])[seen]
    coarser = _integrate_again(motion, motion.t[seen], LARGER)
    errors: np.ndarray = np.abs(states[: len(coarser)] - coarser[: len(states)]).max(axis=0)
    return errors


def _integrate_again(motion: Trajectory, times: np.ndarray, factor: float) -> np.ndarray:
    """The states (q, v) at times of a motion [s], from its start by another tolerance."""
    mechanism, reference, statistics = motion.mechanism, motion.reference, motion.statistics
    first = start_of(motion)
    begin, end, start = float(first.t), float(times[-1]), np.concatenate([first.q, first.v])
    ends = limit_events(mechanism, start)
    events = (*(motion.watched or ()), *ends)
    problem = Problem(
        mechanism=mechanism,
        reference=reference,
        loops=ClosedLoops(reference, statistics.rtol) if mechanism.constrained else None,
        start=start,
        t0=begin,
        end=end,
        times=times,
        rtol=statistics.rtol,
        atol=statistics.atol,
        max_step=longest_step(mechanism, end - begin, None, events),
        max_steps=1_000_000,
        events=events,
        ends=ends,
        progress=None,
    )
    method = method_in(motion.method)
    if method not in (*METHODS, *COMPILED):
        raise InputError(
            f"expected a motion that was integrated, got one by {motion.method!r}: there is no "
            "other one to compare it with"
        )
    share = max(factor * statistics.share, LEAST_RTOL / step_accuracy(problem)[0])
    # code of Taylor series is not optimized, which would take longer than the motion
    plain = Choice("taylor", None, optimized=False)
    choice = plain if method == "taylor" else first_choice(problem, method)
    integration = integrate(problem, replace(choice, share=share))
    if integration.course is None or not integration.outcome.complete:
        raise failure(problem, integration, None, start[: mechanism.nq])
    samples = integration.course().samples
    return np.hstack([samples.q, samples.v])


def _lyapunov(motion: Trajectory, begin: float, end: float) -> float:
    """The largest exponent, averaged over the second half of the motion and the first alike."""
    rhs = motion.reference.rhs()
    task = IntegrationTask(
        rhs=rhs,
        implicit=not motion.curve.smooth,
        rtol=LYAPUNOV_RTOL,
        atol=LYAPUNOV_RTOL,
        max_step=np.inf,
        max_steps=1_000_000,
    )
    nq = motion.mechanism.nq
    rng = np.random.default_rng(0)
    times = np.linspace(begin, end, STRETCHES + 1)
    start = motion.curve(begin)
    size = 1 + float(np.abs(np.concatenate([start.q, start.v])).max())
    departure = rng.normal(size=nq + motion.mechanism.nv)
    departure *= SEPARATION * size / np.linalg.norm(departure)
    total = 0.0
    for t0, t1 in zip(times[:-1].tolist(), times[1:].tolist(), strict=True):
        state = motion.curve(t0)
        y = np.concatenate([state.q, state.v])
        try:
            away = advance(task, t0, y + departure, t1).y - advance(task, t0, y, t1).y
        except EquationsError:
            return float("nan")
        distance = float(np.linalg.norm(away))
        if not 0 < distance < np.inf:
            return float("nan")
        total += np.log(distance / (SEPARATION * size))
        departure = away * (SEPARATION * size / distance)
    return float(total / (end - begin))
