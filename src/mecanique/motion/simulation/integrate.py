"""Integrate a problem step by step, by a method of the table."""

from __future__ import annotations

import signal
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import replace
from functools import partial

import numpy as np

from mecanique.errors import IntegrationError, MecaniqueError
from mecanique.motion.compile.closed import ClosedProgram
from mecanique.motion.compile.python import owning
from mecanique.motion.record.curve import Curve, State
from mecanique.motion.record.steps import Steps
from mecanique.motion.simulation.arguments import kinks
from mecanique.motion.simulation.choice import (
    Choice,
    first_choice,
    may_change,
    next_choice,
    worth_reconsidering,
)
from mecanique.motion.simulation.integrators.compiled import Watched, integrate_in_c
from mecanique.motion.simulation.integrators.methods import (
    METHODS,
    EquationsError,
    StalledError,
    Task,
)
from mecanique.motion.simulation.integrators.refinement import refine, step_accuracy
from mecanique.motion.simulation.integrators.taylor import integrate_series
from mecanique.motion.simulation.problem import Course, Integration, Outcome, Problem
from mecanique.motion.simulation.watching.watcher import Interruption, Watcher


def integrate_by_choice(problem: Problem, method: str) -> tuple[Choice, Integration]:
    """Integrate by one choice after another until none promises more."""
    choice = first_choice(problem, method)
    integration = integrate(problem, choice)
    while (better := next_choice(problem, choice, integration)) is not None:
        choice = better
        integration = integrate(problem, choice)
    return choice, integration


def integrate(problem: Problem, choice: Choice) -> Integration:
    """Integrate a problem once, as far as it goes."""
    if choice.method == "taylor":
        return integrate_series(
            replace(problem, rtol=choice.share * problem.rtol), choice.optimized
        )
    look = partial(worth_reconsidering, problem, choice) if may_change(problem, choice) else None
    if choice.method == "compiled":
        return integrate_in_c(problem, choice.share, partial(_watch, choice), look)
    if problem.loops is not None and isinstance(choice.equations, ClosedProgram):
        problem = problem.with_way_back(choice.equations.close)
    task, steps = _task(problem, choice), Steps(spread=not METHODS[choice.method].smooth)
    try:
        rate = task.rhs(problem.t0, problem.start)
    except MecaniqueError:
        raise
    except Exception as error:
        return Integration(
            outcome=Outcome("fault", error),
            t=problem.t0,
            y=None,
            steps=0,
            evaluations=0,
            rtol=task.rtol,
            course=None,
        )
    steps.add(problem.t0, problem.start, rate)
    if not np.isfinite(rate).all():
        outcome = Outcome("not finite")
        return Integration(
            outcome=outcome,
            t=problem.t0,
            y=steps.y[0],
            steps=0,
            evaluations=0,
            rtol=task.rtol,
            course=None,
        )
    with _interruptible() as interruption:
        watcher = Watcher(problem, task, steps, interruption, look)
        outcome = watcher.start() or _integrate_stretches(problem, choice, task, steps, watcher)
    return Integration(
        outcome=outcome,
        t=steps.t[-1],
        y=steps.y[-1],
        steps=steps.taken,
        evaluations=steps.evaluations,
        rtol=task.rtol,
        course=partial(_course, problem, choice, task, steps, watcher, outcome),
    )


def _watch(choice: Choice, problem: Problem, task: Task, steps: Steps) -> Watched:
    """Integrate on by dop853 to an event; return how that ends, and what gives the events."""
    watcher = Watcher(problem, task, steps, Interruption(), None)
    choice = replace(choice, method="dop853")
    outcome = _integrate_stretches(problem, choice, task, steps, watcher)
    return Watched(outcome, watcher.occurrences)


def _task(problem: Problem, choice: Choice) -> Task:
    quick = choice.equations
    assert quick is not None, "only compiled integrators need none"
    explicit = choice.method == "dop853"
    rtol, atol = step_accuracy(problem)
    return Task(
        owning(quick),
        implicit=not METHODS[choice.method].smooth,
        rtol=choice.share * rtol,
        atol=choice.share * atol,
        max_step=problem.max_step,
        max_steps=problem.max_steps,
        quick=quick if explicit else None,
        restarts=choice.automatic and explicit and problem.loops is not None,
    )


def _integrate_stretches(
    problem: Problem, choice: Choice, task: Task, steps: Steps, watcher: Watcher
) -> Outcome:
    """Integrate from kink to kink of the inputs, and on from where a step needs a correction."""
    end = problem.end
    with METHODS[choice.method].open(task, steps, watcher.look) as run:
        for stop in (*kinks(problem.mechanism, problem.t0, end), end):
            while steps.t[-1] < stop:
                outcome = run(stop)
                if watcher.interruption.pressed:
                    return Outcome("interrupted")
                if outcome.kind == "halt":
                    try:
                        ended = watcher.settle()
                    except StalledError:
                        return Outcome("no headway")
                    except EquationsError as error:
                        return Outcome("fault", error.__cause__)
                    if ended is not None:
                        return ended
                elif outcome.kind == "end":
                    # by rounding it may fall short, and no step is small enough for the rest
                    steps.t[-1] = stop
                else:
                    return outcome
            if stop < end:
                y = steps.y[-1]
                steps.break_here(y, task.rhs(stop, y))
    return Outcome("end")


def _course(
    problem: Problem, choice: Choice, task: Task, steps: Steps, watcher: Watcher, outcome: Outcome
) -> Course:
    """Sample the motion through the steps, and find the events on it.

    Where it takes forever to refine the curve between two steps, the motion ends before them.
    """
    rates, nq = problem.code.rates, problem.mechanism.nq
    path: Callable[[], Curve] = partial(
        steps.curve, nq, rates, smooth=METHODS[choice.method].smooth
    )
    if outcome.accurate:
        path = partial(refine, problem, task, steps, smooth=METHODS[choice.method].smooth)
    last = float(steps.t[-1])
    times = problem.times
    if last < problem.end:
        times = np.append(times[times < last], last)
    if not problem.events and problem.loops is None and times.tolist() == [steps.t[0], last]:
        # the ends are steps: the curve between them can wait until it is asked for
        ends = np.array([steps.y[0], steps.y[-1]])
        return Course(State(times, rates.normalize(ends[:, :nq]), ends[:, nq:]), path)
    try:
        curve = path()
    except IntegrationError as error:
        steps.cut(error.time or problem.t0)
        return _course(problem, choice, task, steps, watcher, Outcome("no headway"))
    samples = curve(times)
    if problem.loops is not None:
        samples = State(times, *problem.loops.close_all(times, samples.q, samples.v))
    early = None if outcome.kind != "no headway" else outcome
    return Course(samples, curve, watcher.occurrences(curve), early)


@contextmanager
def _interruptible() -> Iterator[Interruption]:
    """Let Ctrl-C end the integration after a step.

    SciPy's compiled integrators survive no exception in a callback.
    """
    interruption = Interruption()
    in_main = threading.current_thread() is threading.main_thread()
    if not in_main or signal.getsignal(signal.SIGINT) is not signal.default_int_handler:
        yield interruption
        return
    signal.signal(signal.SIGINT, interruption.note)
    try:
        yield interruption
    finally:
        signal.signal(signal.SIGINT, signal.default_int_handler)
