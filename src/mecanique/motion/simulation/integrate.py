"""Integrate a problem step by step, by a method of the table, or explain why that fails."""

from __future__ import annotations

import signal
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import replace
from functools import partial

import numpy as np

from mecanique.arrays import Array
from mecanique.errors import InputError, IntegrationError, MecaniqueError
from mecanique.model.mechanism import Mechanism
from mecanique.model.states import explain_defaults
from mecanique.model.values import Given
from mecanique.motion.compile.closed import ClosedProgram
from mecanique.motion.compile.python import owning
from mecanique.motion.record.curve import LaterCurve, State, Steps
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
    IntegrationTask,
    StalledError,
    refine,
    step_accuracy,
)
from mecanique.motion.simulation.integrators.taylor import integrate_series
from mecanique.motion.simulation.problem import (
    Course,
    Integration,
    Kind,
    Outcome,
    Problem,
    kinks,
)
from mecanique.motion.simulation.watching import Interruption, Watcher
from mecanique.motion.tolerances import INDEFINITE
from mecanique.motion.trajectory import Trajectory
from mecanique.reference import Reference
from mecanique.wording import say_count


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
        return integrate_series(problem, choice.share, choice.optimized)
    look = partial(worth_reconsidering, problem, choice) if may_change(problem, choice) else None
    if choice.method == "compiled":
        return integrate_in_c(problem, choice.share, partial(_watch, choice), look)
    if problem.loops is not None and isinstance(choice.equations, ClosedProgram):
        problem = problem.with_way_back(choice.equations.close)
    task, steps = _task(problem, choice), Steps(spread=not METHODS[choice.method].smooth)
    stopped = partial(
        Integration,
        t=problem.t0,
        steps=0,
        evaluations=0,
        rtol=task.rtol,
        course=None,
    )
    try:
        rate = task.rhs(problem.t0, problem.start)
    except MecaniqueError:
        raise
    except Exception as error:
        return stopped(Outcome("fault", error), y=None)
    if not np.isfinite(rate).all():
        return stopped(Outcome("not finite"), y=problem.start)
    steps.add(problem.t0, problem.start, rate)
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


def _watch(choice: Choice, problem: Problem, task: IntegrationTask, steps: Steps) -> Watched:
    """Integrate on by dop853 to an event; return how that ends, and what gives the events."""
    watcher = Watcher(problem, task, steps, Interruption(), None)
    choice = replace(choice, method="dop853")
    outcome = _integrate_stretches(problem, choice, task, steps, watcher)
    return Watched(outcome, tuple(watcher.occurrences))


def _task(problem: Problem, choice: Choice) -> IntegrationTask:
    quick = choice.equations
    assert quick is not None, "only compiled integrators need none"
    explicit = choice.method == "dop853"
    rtol, atol = step_accuracy(problem)
    return IntegrationTask(
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
    problem: Problem, choice: Choice, task: IntegrationTask, steps: Steps, watcher: Watcher
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
    problem: Problem,
    choice: Choice,
    task: IntegrationTask,
    steps: Steps,
    watcher: Watcher,
    outcome: Outcome,
) -> Course:
    """Sample the motion through the steps, and find the events on it.

    Where it takes forever to refine the curve between two steps, the motion ends before them.
    """
    rates, nq = problem.code.rates, problem.mechanism.nq
    smooth = METHODS[choice.method].smooth
    make = through = partial(steps.curve, nq, rates, smooth=smooth)
    if outcome.accurate:
        make = partial(refine, problem, task, steps, smooth=smooth)
    last = float(steps.t[-1])
    times = problem.times
    if last < problem.end:
        times = np.append(times[times < last], last)
    if not problem.events and problem.loops is None and times.tolist() == [steps.t[0], last]:
        # the ends are steps: the curve between them can wait until it is asked for
        ends = np.array([steps.y[0], steps.y[-1]])
        samples = State(times, rates.normalize(ends[:, :nq]), ends[:, nq:])
        return Course(samples, LaterCurve(problem.first, last, make, through))
    try:
        curve = make()
    except IntegrationError as error:
        steps.cut(error.time or problem.t0)
        return _course(problem, choice, task, steps, watcher, Outcome("no headway"))
    samples = curve(times)
    if problem.loops is not None:
        samples = State(times, *problem.loops.close_all(times, samples.q, samples.v))
    early = None if outcome.kind != "no headway" else outcome
    return Course(samples, curve, tuple(watcher.occurrences), early)


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


MAX_LISTED = 8
"""At most this many values of a state are listed in a message."""


def failure(
    problem: Problem, integration: Integration, motion: Trajectory | None, asked: Given
) -> IntegrationError:
    """Return the error that explains why an integration is not complete."""
    outcome, t, y = integration.outcome, integration.t, integration.y
    fault = outcome.fault
    if fault is not None and not isinstance(fault, (Exception, KeyboardInterrupt)):
        raise fault  # e.g. SystemExit, kept back until the compiled integrator had returned
    where = "" if y is None else f" at t = {t:.6g} s, {_listing(problem.mechanism, y)}"
    kind, cause = outcome.kind, fault
    if kind == "interrupted" or isinstance(fault, KeyboardInterrupt):
        kind, cause = "interrupted", KeyboardInterrupt()
    rests = motion.events[-1].name if motion is not None and motion.events else ""
    unclosed = "" if problem.loops else explain_defaults(problem.mechanism, asked)
    messages: dict[Kind, str] = {
        "interrupted": f"interrupted{where}",
        "contact": f"event {rests!r} comes to rest{where}: a lasting contact is not modelled; "
        "let the event stop",
        "progress": f"progress raised {fault!r}{where}",
        "fault": f"the equations failed{where}: {fault}",
        "undecided": str(fault),
        "not finite": f"the acceleration at the start is not finite{where}: expected a start where "
        f"the mass matrix is regular and every force is finite{unclosed}",
        "stiff": f"the equations are too stiff for dop853{where}; use method='auto', 'lsoda' or "
        "'radau'",
        "too many steps": f"more than {say_count(problem.max_steps, 'step')}{where}; raise "
        "max_steps, shorten the duration or loosen rtol",
        "no headway": f"no headway{where}: the last steps covered less than a millionth of the "
        "duration; a force chatters there, as dry friction does at rest, or the mechanism is next "
        "to a singular position; smooth the force, or loosen rtol",
        "step too small": f"the step size collapsed{where}: a force or the mass matrix becomes "
        "singular there, or an input jumps; check the forces near this state, or loosen rtol",
    }
    message = messages[kind]
    kept = "; the motion until then is in the error's .motion" if motion is not None else ""
    error = IntegrationError(message + kept, time=t, state=y, motion=motion)
    error.__cause__ = cause
    return error


def refuse_corners(mechanism: Mechanism, method: str, reference: Reference | None) -> None:
    """Raise if a motion with elements that switch is asked for as none can be had."""
    if method not in ("auto", *METHODS):
        raise InputError(
            f"method {method!r} passes no corners, which {mechanism.name!r} has by its elements "
            f"that switch; expected 'auto' or one of {', '.join(METHODS)}"
        )
    if reference is not None:
        raise InputError(
            "expected no reference for a mechanism with elements that switch: each motion has one "
            "of its own, with their forces"
        )


def _listing(mechanism: Mechanism, y: np.ndarray) -> str:
    names = (*mechanism.coordinates.names, *mechanism.velocities)
    values = list(zip(names, y, strict=True))[:MAX_LISTED]
    more = ", …" if len(names) > MAX_LISTED else ""
    return ", ".join(f"{name} = {value:.6g}" for name, value in values) + more


def refuse_indefinite(reference: Reference, t: Array, q: Array) -> None:
    """Raise if the mass matrix has a negative eigenvalue at any of the n states."""
    bodies = [body.name for body in reference.mechanism.bodies if body.as_given]
    if not bodies:
        return
    mass = reference.mass_matrix(q, t)
    size = np.sqrt(np.abs(np.diagonal(mass, axis1=1, axis2=2)))
    size = np.where(size > 0, size, 1.0)
    least = np.linalg.eigvalsh(mass / (size[:, :, None] * size[:, None, :]))[:, 0]
    wrong = np.flatnonzero(least < -INDEFINITE)
    if len(wrong):
        first = wrong[0]
        raise IntegrationError(
            f"the mass matrix is not positive definite at t = {t[first]:.6g} s: there are motions "
            "with negative kinetic energy, so that no integration means anything; no real body "
            f"has the inertia of {', '.join(map(repr, bodies[:6]))}"
            f"{', …' if len(bodies) > 6 else ''}; mend it (mecanique lint --fix --balance)",
            time=float(t[first]),
            state=q[first],
        )
