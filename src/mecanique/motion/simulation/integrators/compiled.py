"""Integrate in compiled C; by the reference past singular positions of loops."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from typing import NamedTuple, TypeAlias, final

import numpy as np

from mecanique.generation.dop853 import LEAP, NEAREST, PASSED
from mecanique.motion.compile.closed import ClosedProgram
from mecanique.motion.compile.python import owning
from mecanique.motion.compile.stepper import March, Stepper, Tolerances
from mecanique.motion.record.curve import PLACES, LaterCurve, State, Steps, interpolate
from mecanique.motion.record.events import Occurrence
from mecanique.motion.simulation.integrators.methods import (
    METHODS,
    EquationsError,
    IntegrationTask,
    StallDetector,
    StalledError,
    advance_within,
    refine,
    step_accuracy,
)
from mecanique.motion.simulation.problem import Course, Integration, Kind, Outcome, Problem

_KINDS: dict[str, Kind] = {
    "end": "end",
    "small": "step too small",
    "many": "too many steps",
    "stiff": "stiff",
    "off": "step too small",
}
"""Outcomes by why compiled steps stop."""


class Watched(NamedTuple):
    """How a stretch that was watched ended."""

    outcome: Outcome
    occurrences: tuple[Occurrence, ...]


_Look: TypeAlias = Callable[[int, float], bool]
"""Returns after a number of steps, at a time, whether other steps pay."""


_Watch: TypeAlias = Callable[[Problem, IntegrationTask, Steps], Watched]
"""Integrates on from the last of the steps, adding steps, to the first event."""


def integrate_in_c(
    problem: Problem, share: float, watch: _Watch, look: _Look | None = None
) -> Integration:
    """Integrate a problem by compiled steps, as far as it goes."""
    code, reference = problem.code, problem.reference
    stepper, equations = code.stepper(reference), code.rhs(reference)
    if isinstance(equations, ClosedProgram):
        problem = problem.with_way_back(equations.close)
    rtol, atol = (share * tolerance for tolerance in step_accuracy(problem))
    tolerances = Tolerances(rtol, atol, problem.max_step, problem.max_steps)
    march = stepper.march(problem.start, problem.t0, problem.times, tolerances)
    task = IntegrationTask(owning(equations), False, rtol, atol, restarts=True)
    run, steps = _Run(problem, stepper, march, task, StallDetector(problem)), Steps()
    steps.add(problem.t0, problem.start, task.rhs(problem.t0, problem.start))
    outcome: Outcome | None = None
    occurrences: tuple[Occurrence, ...] = ()
    leaping = False
    try:
        while outcome is None:
            before = len(steps.t) - 1
            reason, t, y, dy = march.advance(problem.end)
            steps.extend(t, y, dy)
            outcome = problem.report(march.t)
            if outcome is None and run.stalls.is_stalled(len(steps.t), march.t):
                outcome = Outcome("no headway")
            under_way = outcome is None and march.t < problem.end
            if under_way and look is not None and look(steps.taken, march.t):
                outcome = Outcome("reconsider")
            near = outcome is None and reason == "near" and not leaping
            state = march.t, march.y
            if near and isinstance(equations, ClosedProgram) and equations.crosses_at(*state):
                leaping = True
                march.leap(LEAP)
            elif outcome is None and reason in ("near", "past"):
                leaping = False
                march.leap(0.0)
                outcome = run.pass_by(steps) if reason == "near" else None
            elif outcome is None and reason != "room":
                outcome = Outcome(_KINDS[reason])
            if (last := _find_end_of_chart(problem, steps, before, reason)) is not None:
                outcome, occurrences = run.watch_from(last, steps, watch)
    except KeyboardInterrupt:
        outcome = Outcome("interrupted")
    return Integration(
        outcome=outcome,
        t=march.t,
        y=march.y.copy(),
        steps=steps.taken,
        evaluations=march.evaluations + steps.evaluations,
        rtol=rtol,
        course=partial(run.sample, steps, outcome, occurrences),
    )


def _find_end_of_chart(problem: Problem, steps: Steps, first: int, reason: str) -> int | None:
    """The step before the one in which a coordinate leaves its chart, from a step on.

    Beyond it the equations may have no numbers, so that a march which stops there has come to it.
    """
    if not problem.ends:
        return None
    t, y, dy = (np.array(part[first:]) for part in (steps.t, steps.y, steps.dy))
    h, nq = np.diff(t)[:, None], problem.mechanism.nq
    outside = np.zeros(len(h), dtype=bool)
    for x in PLACES:
        there = interpolate(x, h, (y[:-1], y[1:]), (dy[:-1], dy[1:]))
        for end in problem.ends:
            quantity = end.quantity(problem.mechanism)
            outside |= np.asarray(quantity(0.0, there[:, :nq], there[:, nq:])) <= 0
    if outside.any():
        return first + int(outside.argmax())
    return len(steps.t) - 1 if reason in ("off", "small") else None


@final
@dataclass(frozen=True)
class _Run:
    """An integration under way."""

    problem: Problem
    stepper: Stepper
    march: March
    # the equations as Python, with the tolerances of steps past singular positions
    task: IntegrationTask
    stalls: StallDetector  # finds whether it leads nowhere

    def pass_by(self, steps: Steps) -> Outcome | None:
        """Integrate by the reference past a singular position; return why to stop, if so."""
        problem, march, task, loops = self.problem, self.march, self.task, self.problem.loops
        assert loops is not None, "only loops have singular positions"
        passage, end, before = Steps(), problem.end, len(steps.t)
        passage.add(march.t, march.y, task.rhs(march.t, march.y))

        def look() -> Outcome | None:
            t, y = passage.t[-1], passage.y[-1]
            if self.stalls.is_stalled(before + len(passage.t), t):
                return Outcome("no headway")
            away = self.stepper.distance(t, y) > PASSED * NEAREST
            return Outcome("halt") if away or loops.has_left(t, y) else None

        outcome: Outcome | None = None
        with METHODS["dop853"].open(task, passage, look) as run:
            while outcome is None and passage.t[-1] < end:
                stopped = run(end)
                t = end if stopped.kind == "end" else passage.t[-1]
                if stopped.kind in ("end", "halt"):
                    passage.end_at(t, loops.close(t, passage.y[-1]), task.rhs)
                    if self.stepper.distance(t, passage.y[-1]) > PASSED * NEAREST:
                        break
                else:
                    outcome = stopped
                outcome = outcome or problem.report(t)
        steps.evaluations += passage.evaluations
        try:
            self._sample_along(passage)
        except StalledError:
            return Outcome("no headway")
        except EquationsError as error:
            return Outcome("fault", error.__cause__)
        steps.extend(np.array(passage.t[1:]), np.array(passage.y[1:]), np.array(passage.dy[1:]))
        if outcome is None and passage.t[-1] >= end:
            return Outcome("end")
        return outcome

    def watch_from(self, last: int, steps: Steps, watch: _Watch) -> Watched:
        """Integrate on from a step by its number, forgetting those after it."""
        march, times = self.march, self.problem.times
        t, y = steps.t[last], steps.y[last]
        steps.cut(t)
        march.put(t, y, int(np.searchsorted(times, t, side="right")))
        stretch = Steps()
        stretch.add(t, y, steps.dy[last])
        watched = watch(self.problem, self.task, stretch)
        if watched.outcome.complete:
            self._sample_along(stretch)
        else:
            march.put(stretch.t[-1], stretch.y[-1], march.passed)
        steps.evaluations += stretch.evaluations
        steps.extend(np.array(stretch.t[1:]), np.array(stretch.y[1:]), np.array(stretch.dy[1:]))
        return watched

    def _sample_along(self, stretch: Steps) -> None:
        """Note the samples along steps of the reference, and go on from the last."""
        march, times, k = self.march, self.problem.times, 0
        passed = march.passed
        while passed < len(times) and times[passed] <= stretch.t[-1]:
            t = float(times[passed])
            while stretch.t[k + 1] < t:
                k += 1
            y = advance_within(self.task, stretch.t[k], stretch.y[k], t).y
            at_step = t == stretch.t[k + 1]
            march.samples[passed] = stretch.y[k + 1] if at_step else self.problem.correct(t, y)
            passed += 1
        march.put(stretch.t[-1], stretch.y[-1], passed)

    def sample(
        self,
        steps: Steps,
        outcome: Outcome,
        occurrences: tuple[Occurrence, ...],
    ) -> Course:
        """Return the samples, and the curve through the steps, which is made when asked for."""
        problem, rates, nq = self.problem, self.problem.code.rates, self.problem.mechanism.nq
        passed = self.march.passed
        times, y = problem.times[:passed], self.march.samples[:passed]
        if outcome.kind != "end" and (not passed or times[-1] < self.march.t):
            times, y = np.append(times, self.march.t), np.vstack([y, self.march.y])
        samples = State(times, rates.normalize(y[:, :nq]), y[:, nq:])
        make = partial(refine, problem, self.task, steps, smooth=True)
        if outcome.kind != "event":
            through = partial(steps.curve, nq, rates, smooth=True)
            return Course(samples, LaterCurve(problem.first, steps.t[-1], make, through))
        return Course(samples, make(), occurrences)
