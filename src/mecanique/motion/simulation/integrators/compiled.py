"""Integrate in compiled C; by the reference past singular positions of loops."""

from __future__ import annotations

from dataclasses import dataclass
from functools import partial
from typing import final

import numpy as np

from mecanique.motion.compile.closed import ClosedProgram
from mecanique.motion.compile.python import owning
from mecanique.motion.compile.stepper import NEAR, March, Stepper, Tolerances
from mecanique.motion.record.curve import State
from mecanique.motion.record.steps import Steps
from mecanique.motion.simulation.integrators.headway import Headway
from mecanique.motion.simulation.integrators.methods import (
    METHODS,
    EquationsError,
    StalledError,
    Task,
    advance_within,
)
from mecanique.motion.simulation.integrators.refinement import refine, step_accuracy
from mecanique.motion.simulation.outcome import Kind, Outcome
from mecanique.motion.simulation.problem import Course, Integration, Problem

__all__ = ["integrate_in_c"]

_KINDS: dict[str, Kind] = {
    "end": "end",
    "small": "step too small",
    "many": "too many steps",
    "stiff": "stiff",
    "off": "step too small",
}
"""Outcomes by why compiled steps stop."""

_AWAY = 2.0
"""Compiled steps go on this many times as far from a singular position as they stop before it."""


def integrate_in_c(problem: Problem, share: float) -> Integration:
    """Integrate a problem, as far as it goes.

    Args:
        problem: what to integrate; it can be compiled.
        share: part of the tolerance that a step may use.
    """
    code, reference = problem.code, problem.reference
    stepper, equations = code.stepper(reference), code.rhs(reference)
    if isinstance(equations, ClosedProgram):
        problem = problem.with_way_back(equations.close)
    rtol, atol = (share * tolerance for tolerance in step_accuracy(problem))
    tolerances = Tolerances(rtol, atol, problem.max_step, problem.max_steps)
    march = stepper.march(problem.start, problem.t0, problem.times, tolerances)
    task = Task(owning(equations), False, rtol, atol, restarts=True)
    run, steps = _Run(problem, stepper, march, task, Headway(problem)), Steps()
    steps.add(problem.t0, problem.start, task.rhs(problem.t0, problem.start))
    outcome = None
    try:
        while outcome is None:
            reason, t, y, dy = march.advance(problem.end)
            steps.extend(t, y, dy)
            outcome = problem.report(march.t)
            if outcome is None and run.headway.is_lost(len(steps.t), march.t):
                outcome = Outcome("no headway")
            if outcome is None and reason == "near":
                outcome = run.pass_by(steps)
            elif outcome is None and reason != "room":
                outcome = Outcome(_KINDS[reason])
    except KeyboardInterrupt:
        outcome = Outcome("interrupted")
    return Integration(
        outcome,
        march.t,
        march.y.copy(),
        steps.taken,
        march.evaluations + steps.evaluations,
        rtol,
        partial(run.sample, steps, outcome),
    )


@final
@dataclass(frozen=True)
class _Run:
    """An integration under way.

    Args:
        problem: what is integrated.
        stepper: the compiled code.
        march: the motion in it.
        task: the equations as Python, with the tolerances of steps past singular positions.
        headway: whether it leads on.
    """

    problem: Problem
    stepper: Stepper
    march: March
    task: Task
    headway: Headway

    def pass_by(self, steps: Steps) -> Outcome | None:
        """Integrate by the reference until no singular position is near; return why to end.

        Args:
            steps: to which those are added that are taken.
        """
        problem, march, task, loops = self.problem, self.march, self.task, self.problem.loops
        assert loops is not None, "only loops have singular positions"
        own, end, before = Steps(), problem.end, len(steps.t)
        own.add(march.t, march.y, task.rhs(march.t, march.y))

        def look() -> Outcome | None:
            t, y = own.t[-1], own.y[-1]
            if self.headway.is_lost(before + len(own.t), t):
                return Outcome("no headway")
            away = self.stepper.distance(t, y) > _AWAY * NEAR
            return Outcome("halt") if away or loops.has_left(t, y) else None

        outcome: Outcome | None = None
        with METHODS["dop853"].open(task, own, look) as run:
            while outcome is None and own.t[-1] < end:
                stopped = run(end)
                t = end if stopped.kind == "end" else own.t[-1]
                if stopped.kind in ("end", "halt"):
                    own.end_at(t, loops.close(t, own.y[-1]), task.rhs)
                    if self.stepper.distance(t, own.y[-1]) > _AWAY * NEAR:
                        break
                else:
                    outcome = stopped
                outcome = outcome or problem.report(t)
        steps.evaluations += own.evaluations
        try:
            self._sample_along(own)
        except StalledError:
            return Outcome("no headway")
        except EquationsError as error:
            return Outcome("fault", error.__cause__)
        steps.extend(np.array(own.t[1:]), np.array(own.y[1:]), np.array(own.dy[1:]))
        if outcome is None and own.t[-1] >= end:
            return Outcome("end")
        return outcome

    def _sample_along(self, own: Steps) -> None:
        """Note the samples along steps of the reference, and go on from the last."""
        march, times, loops, k = self.march, self.problem.times, self.problem.loops, 0
        passed = march.passed
        assert loops is not None
        while passed < len(times) and times[passed] <= own.t[-1]:
            t = float(times[passed])
            while own.t[k + 1] < t:
                k += 1
            y = advance_within(self.task, own.t[k], own.y[k], t).y
            march.samples[passed] = own.y[k + 1] if t == own.t[k + 1] else loops.close(t, y)
            passed += 1
        march.put(own.t[-1], own.y[-1], passed)

    def sample(self, steps: Steps, outcome: Outcome) -> Course:
        """Return the samples, and the curve through the steps, which is made when asked for."""
        problem, rates, nq = self.problem, self.problem.code.rates, self.problem.mechanism.nq
        passed = self.march.passed
        times, y = problem.times[:passed], self.march.samples[:passed]
        if not outcome.complete and (not passed or times[-1] < self.march.t):
            times, y = np.append(times, self.march.t), np.vstack([y, self.march.y])
        samples = State(times, rates.normalize(y[:, :nq]), y[:, nq:])
        return Course(samples, partial(refine, problem, self.task, steps, smooth=True))
