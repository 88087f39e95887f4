"""Set a mechanism in motion: integrate its equations from a start, step by step, to the tolerance asked for."""

from __future__ import annotations

import signal
import threading
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from functools import partial
from time import perf_counter
from typing import Any

import numpy as np

from mecanique.errors import InputError, IntegrationError, MecaniqueError, UnknownNameError
from mecanique.model.mechanism import Mechanism
from mecanique.motion.record.curve import Curve, State
from mecanique.motion.record.events import Event, Occurrence
from mecanique.motion.record.loops import Closing
from mecanique.motion.record.motion import Motion, Statistics
from mecanique.motion.record.rates import Rates
from mecanique.motion.record.steps import Steps
from mecanique.motion.simulation.arguments import (
    Values,
    kinks,
    longest_step,
    sample_times,
    span_and_tolerances,
)
from mecanique.motion.simulation.choice import COMPILED, Plan, flowed
from mecanique.motion.simulation.limits import chart_ends, refuse_end, tell_end
from mecanique.motion.simulation.methods import METHODS, Outcome, Task, advance
from mecanique.motion.simulation.watcher import Watcher

__all__ = ["simulate"]

SHORTEST = 1e-6
"""Intervals below this fraction of the median are not halved: there is a kink in them that no step resolves."""

EPSILON = 2.2e-16
"""Relative rounding of a number."""


def simulate(
    mechanism: Mechanism,
    *,
    q: Values | None = None,
    v: Values | None = None,
    duration: float = 10.0,
    rtol: float = 1e-10,
    atol: float | None = None,
    method: str = "auto",
    fps: float = 60.0,
    samples: int | Sequence[float] | np.ndarray | None = None,
    t0: float = 0.0,
    max_step: float | None = None,
    max_steps: int = 1_000_000,
    events: Sequence[Event] = (),
    progress: Callable[[float], object] | None = None,
    reference: Any = None,
) -> Motion:
    """Integrate a mechanism's equations of motion.

    The accelerations are the reference's, or those of the closed form derived in-house once both
    have been compared. Loops are closed at the start, what is given by name staying as it is if
    that is possible, and kept closed by projection. The motion is accurate to the tolerance at any
    time, not only at the samples.

    Args:
        mechanism: what moves.
        q: positions at the start: shape (nq,) or by coordinate name, zero where left out.
        v: velocities at the start: shape (nv,) or by name (q or q'), zero where left out.
        duration: how long [s].
        rtol: relative tolerance of each step, in 1e-14…1e-1; where it is 1e-11 or less and dop853
            would take more than 10,000 steps, their tolerance is smaller, because their errors add
            up.
        atol: absolute tolerance of each step, in the units of q and v; as rtol by default.
        method: "auto"; or one of "dop853", "lsoda", "radau", "bdf", on the reference's equations;
            or "closed_form" (dop853 on the closed form) or "taylor" (Taylor series of the closed
            form, extra `fast`), which compile first and then are faster. "auto" takes dop853 and
            changes to radau if the equations turn out to be stiff, or to a faster method if this
            motion, or those of the mechanism before it, take long enough to pay for compiling, or
            if that is done already.
        fps: samples per second of the resulting arrays; the last sample is at the end exactly.
        samples: instead of fps, the number of samples, or their times [s], shape (n,).
        t0: time at the start [s].
        max_step: longest step [s]; by default not bounded, but a fiftieth of the duration where an
            input is a function or events are watched.
        max_steps: most steps.
        events: what to watch for.
        progress: called with the fraction done, in 0…1, about a hundred times.
        reference: the mechanism's `Reference`, if it is there already.

    Raises:
        InputError: if an argument is not what is expected, or the mechanism cannot move.
        UnknownNameError: if a coordinate, velocity, method or name in an event does not exist.
        ClosureError: if the loops cannot be closed at the start.
        DerivationError: if the method asked for needs a closed form and there is none.
        IntegrationError: if the integration stops before its end, also by Ctrl-C; it carries the
            motion until then.
    """
    begin = perf_counter()
    if not mechanism.nv:
        raise InputError(
            f"mechanism {mechanism.name!r} has no coordinate, so nothing in it can be set in motion"
        )
    start = np.concatenate([mechanism.position(q), mechanism.velocity(v)])
    t0, end, rtol, atol = span_and_tolerances(t0, duration, rtol, atol)
    times = sample_times(t0, end, fps, samples)
    if method not in ("auto", *METHODS, *COMPILED):
        raise UnknownNameError("method", method, ("auto", *METHODS, *COMPILED))
    if isinstance(max_steps, bool) or not isinstance(max_steps, (int, np.integer)) or max_steps < 1:
        raise InputError(f"expected a whole number of at least 1 for max_steps, got {max_steps!r}")
    watched = (*events, *chart_ends(mechanism, start))
    longest = longest_step(mechanism, end - t0, max_step, watched)
    if reference is None:
        from mecanique.reference import Reference

        reference = Reference(mechanism)
    closing, remark = None, ""
    if mechanism.loops:
        closing = Closing(mechanism, reference, rtol)
        start, remark = closing.start(q, v, t0)
    plan = Plan(mechanism, reference, method, rtol, end - t0, watched)
    if plan.taylor:
        return flowed(
            plan, start, times, (t0, end), (rtol, atol), longest, int(max_steps), progress, begin
        )
    rhs, chosen, rates = plan.rhs, plan.method, plan.code.rates
    reason = "non-stiff equations"
    path: Callable[[], Curve] | None
    while True:
        steps = Steps()
        share = (
            plan.share if closing is None else Closing.share
        )  # bringing it back restarts each step
        task = Task(
            rhs, not METHODS[chosen].smooth, share * rtol, share * atol, longest, int(max_steps)
        )
        task.quick = plan.quick if chosen == "dop853" else None
        task.doubtful = method == "auto" and chosen == "dop853" and closing is not None
        watcher = Watcher(
            mechanism, reference, rates, task, steps, watched, progress, (t0, end), closing
        )
        if chosen == "dop853":
            watcher.reconsider = plan.watch(t0, end)
        finest = (task.rtol / plan.share, task.atol / plan.share)
        trouble, path = _integrate(
            task, watcher, steps, mechanism, rates, chosen, t0, start, end, finest
        )
        if watcher.reconsidered:
            plan.change()
            if plan.taylor:
                return flowed(
                    plan,
                    start,
                    times,
                    (t0, end),
                    (rtol, atol),
                    longest,
                    int(max_steps),
                    progress,
                    begin,
                )
            rhs = plan.rhs
            continue
        if (
            method == "auto"
            and chosen == "dop853"
            and trouble is not None
            and trouble[0] == "stiff"
        ):
            chosen, reason = "radau", f"stiff equations, found by dop853 at t = {steps.t[-1]:.4g} s"
            continue
        break
    if path is None:
        raise _error(trouble, task, steps, mechanism, None)
    if chosen == "dop853":
        plan.spend(steps.taken)
    choice = f"; chosen for {reason}" if method == "auto" else ""
    if task.rtol < rtol and closing is None:
        remark = f"; steps to {task.rtol:.1e}, because the errors of so many add up"
    text = f"{chosen} ({METHODS[chosen].title}){plan.source}{choice}{remark}"
    statistics = Statistics(steps.taken, task.evaluations, perf_counter() - begin, rtol, atol)
    last = float(steps.t[-1])
    if last < end:  # stopped early: by an event, by trouble or by the user
        times = np.append(times[times < last], last)
    happened: tuple[Occurrence, ...] = ()
    if not watched and closing is None and times.tolist() == [steps.t[0], last]:
        ends = np.array([steps.y[0], steps.y[-1]])
        state = State(times, rates.normalized(ends[:, : mechanism.nq]), ends[:, mechanism.nq :])
    else:
        curve = path()
        state = curve(times)
        if closing is not None:
            state = State(times, *closing.all_back(times, state.q, state.v))
        happened = watcher.occurrences(curve)
        path = partial(_same, curve)
    motion = Motion(
        mechanism,
        times,
        state.q,
        state.v,
        path,
        text,
        statistics,
        happened,
        tuple(events),
        reference,
    )
    if trouble is not None:
        raise _error(trouble, task, steps, mechanism, motion)
    refuse_end(motion)
    tell_end(progress, motion)
    return motion


Trouble = tuple[Outcome, str]


def _same(curve: Curve) -> Curve:
    return curve


def _integrate(
    task: Task,
    watcher: Watcher,
    steps: Steps,
    mechanism: Mechanism,
    rates: Rates,
    chosen: str,
    t0: float,
    start: np.ndarray,
    end: float,
    tolerances: tuple[float, float],
) -> tuple[Trouble | None, Callable[[], Curve] | None]:
    """Integrate stretch by stretch; return what stopped it, if anything did, and what gives the motion so far."""
    method = METHODS[chosen]
    try:
        rate = task.rhs(t0, start)
    except MecaniqueError:
        raise
    except Exception as error:
        task.fault = error
        return ("fault", ""), None
    if not np.isfinite(rate).all():
        steps.add(t0, start, rate)
        return ("fault", "the acceleration at the start is not finite"), None
    steps.add(t0, start, rate)
    watcher.start()
    trouble: Trouble | None = None
    refined = partial(
        _refined, task, tolerances, steps, mechanism.nq, rates, method.smooth, watcher.renormalized
    )
    with _interruptible(watcher):
        for stop in (*kinks(mechanism, t0, end), end):
            while steps.t[-1] < stop:
                outcome = method.run(task, steps, stop, watcher)
                if watcher.reconsidered:
                    return None, refined
                if outcome == "stopped" and not watcher.interrupted and task.fault is None:
                    if watcher.settle():  # ended by an event
                        trouble = ("stopped", "contact") if watcher.contact else None
                        return trouble, refined
                    continue
                if watcher.interrupted:
                    trouble = ("stopped", "interrupted")
                elif outcome != "end":
                    trouble = (outcome, "")
                if trouble is not None:
                    return trouble, partial(steps.curve, mechanism.nq, rates, method.smooth)
                steps.t[-1] = (
                    stop  # by rounding it may fall short, and no step is small enough for the rest
                )
            if stop < end:
                y = steps.y[-1]
                steps.break_here(y, task.rhs(stop, y))
        return None, refined


def _refined(
    task: Task,
    tolerances: tuple[float, float],
    steps: Steps,
    nq: int,
    rates: Rates,
    smooth: bool,
    renormalized: Callable[[float, np.ndarray], np.ndarray],
) -> Curve:
    """Halve the intervals on which the polynomial is less accurate than the steps.

    Once only: what is left then is not the polynomial's error but that of the steps, which fit each
    other no better than to the tolerance, and looks the larger the closer they are.
    """
    rounding = EPSILON * max(1.0, abs(steps.t[0]), abs(steps.t[-1]))
    rtol, atol = tolerances
    curve = steps.curve(nq, rates, smooth, close=rtol < 1000 * rounding)
    at = curve.intervals
    if not smooth or not len(at):
        return curve
    excess = [
        # times of steps are rounded, and no step more makes that better
        error / (atol + (np.abs(x[at]) * rtol + np.abs(rate[at]) * 100 * rounding).max(axis=1))
        for error, x, rate in zip(
            curve.errors(),
            (curve.q, curve.v),
            (rates.first(curve.q, curve.v), curve.a),
            strict=True,
        )
    ]
    length = curve.t[at + 1] - curve.t[at]
    coarse = at[(np.maximum(*excess) > 1) & (length > SHORTEST * float(np.median(length)))]
    t = (curve.t[coarse] + curve.t[coarse + 1]) / 2
    states = [
        renormalized(
            float(s),
            advance(task, float(curve.t[i]), np.concatenate([curve.q[i], curve.v[i]]), float(s)),
        )
        for i, s in zip(coarse, t, strict=True)
    ]
    if not states or not np.isfinite(y := np.array(states)).all():
        return curve
    dy = np.array([task.rhs(float(s), x) for s, x in zip(t, states, strict=True)])
    return curve.with_steps(coarse, t, y[:, :nq], y[:, nq:], dy[:, nq:])


@contextmanager
def _interruptible(watcher: Watcher) -> Iterator[None]:
    """Let Ctrl-C end the integration after a step: SciPy's compiled integrators survive no exception in a callback."""
    in_main = threading.current_thread() is threading.main_thread()
    if not in_main or signal.getsignal(signal.SIGINT) is not signal.default_int_handler:
        yield
        return

    def note(number: int, frame: object) -> None:
        watcher.interrupted = True

    signal.signal(signal.SIGINT, note)
    try:
        yield
    finally:
        signal.signal(signal.SIGINT, signal.default_int_handler)


def _error(
    trouble: Trouble | None, task: Task, steps: Steps, mechanism: Mechanism, motion: Motion | None
) -> IntegrationError:
    outcome, detail = trouble if trouble is not None else ("fault", "")
    t, y = steps.t[-1] if steps.t else 0.0, steps.y[-1] if steps.y else None
    where = "" if y is None else f" at t = {t:.6g} s, {_listed(mechanism, y)}"
    kept = "; the motion until then is in the error's .motion" if motion is not None else ""
    if task.fault is not None and not isinstance(task.fault, (Exception, KeyboardInterrupt)):
        raise task.fault  # e.g. SystemExit, kept back until the compiled integrator had returned
    if detail == "interrupted" or isinstance(task.fault, KeyboardInterrupt):
        interrupted = IntegrationError(f"interrupted{where}{kept}", time=t, state=y, motion=motion)
        interrupted.__cause__ = KeyboardInterrupt()
        return interrupted
    if detail == "contact":
        name = motion.events[-1].name if motion is not None else ""
        message = f"event {name!r} comes to rest{where}: a lasting contact is not modelled; let the event stop{kept}"
        return IntegrationError(message, time=t, state=y, motion=motion)
    if task.fault is not None:
        message = f"the equations failed{where}: {task.fault}{kept}"
    elif detail:
        message = f"{detail}{where}: expected a start where the mass matrix is regular and every force is finite"
    elif outcome == "stiff":
        message = f"the equations are too stiff for dop853{where}; use method='auto', 'lsoda' or 'radau'{kept}"
    elif outcome == "too many steps":
        message = f"more than {task.max_steps} steps{where}; raise max_steps, shorten the duration or loosen rtol{kept}"
    else:
        message = (
            f"the step size collapsed{where}: a force or the mass matrix becomes singular there, or an input jumps; "
            f"check the forces near this state, or loosen rtol{kept}"
        )
    error = IntegrationError(message, time=t, state=y, motion=motion)
    error.__cause__ = task.fault
    return error


def _listed(mechanism: Mechanism, y: np.ndarray) -> str:
    names = (*mechanism.coordinates.names, *mechanism.velocities)
    shown = ", ".join(
        f"{name} = {value:.6g}" for name, value in list(zip(names, y, strict=True))[:8]
    )
    return f"{shown}, …" if len(names) > 8 else shown
