"""Integrate by Taylor series, in heyoka's compiled integrator."""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial
from typing import Any

import numpy as np

from mecanique.motion.record.curve import Curve, LaterCurve, State
from mecanique.motion.simulation.problem import Course, Integration, Outcome, Problem
from mecanique.motion.tolerances import NO_SERIES_STEP

AT_ONCE = 20_000
"""Steps between reports of progress and looks for an interruption."""


def integrate_series(problem: Problem, share: float, optimized: bool | None) -> Integration:
    """Integrate a problem by Taylor series to a share of its tolerance, as far as it goes."""
    code, reference, rtol, end = problem.code, problem.reference, share * problem.rtol, problem.end
    fast = code.pays_to_optimize(rtol) if optimized is None else optimized
    machine = code.borrow(reference, rtol, optimized=fast)
    options = _options(problem)
    left = problem.times[problem.times > problem.t0]
    states = [problem.start[None]] if problem.times[0] == problem.t0 else []
    steps, outcome = 0, None
    try:
        machine.time = problem.t0
        machine.state[:] = problem.start
        while outcome is None and machine.time < end:
            if optimized is None and not fast and code.pays_to_optimize(rtol, steps):
                before, machine = machine, code.borrow(reference, rtol, optimized=True)
                machine.time, machine.state[:] = before.time, before.state
                code.give_back(rtol, before, optimized=False)
                fast = True
            limits = {"max_steps": min(AT_ONCE, problem.max_steps - steps), **options}
            some = left[:AT_ONCE]
            if len(some) and some[0] < end:  # samples on the way are read off the series
                grid = np.concatenate([[machine.time], some])
                stop, _, _, taken, *_, grid_states = machine.propagate_grid(grid, **limits)
                states.append(grid_states[1:])
            else:
                stop, _, _, taken, *_ = machine.propagate_until(end, **limits)
                sampled = len(some) and machine.time == end
                states.append(machine.state[None].copy() if sampled else machine.state[None][:0])
            left = left[len(states[-1]) :]
            steps += taken
            if stop.name == "step_limit":
                outcome = Outcome("too many steps") if steps >= problem.max_steps else None
            elif stop.name != "time_limit":
                outcome = Outcome("step too small")
            outcome = problem.report(float(machine.time)) or outcome
    except KeyboardInterrupt:
        outcome = Outcome("interrupted")
    last, y = float(machine.time), np.array(machine.state)
    code.give_back(rtol, machine, steps, optimized=fast)
    return Integration(
        outcome=outcome or Outcome("end"),
        t=last,
        y=y,
        steps=steps,
        evaluations=steps,
        rtol=rtol,
        course=partial(_course, problem, rtol, states, last, fast),
    )


def _options(problem: Problem) -> dict[str, Any]:
    return {} if np.isinf(problem.max_step) else {"max_delta_t": problem.max_step}


def _course(
    problem: Problem, rtol: float, states: list[np.ndarray], last: float, optimized: bool
) -> Course:
    """The samples that were read off, and the curve that is made when it is asked for."""
    y = np.concatenate(states) if states else np.empty((0, len(problem.start)))
    nq = problem.mechanism.nq
    samples = State(problem.times[: len(y)], problem.code.rates.normalize(y[:, :nq]), y[:, nq:])
    make = partial(_curve, problem, rtol, last, optimized)
    return Course(samples, LaterCurve(problem.first, last, make))


def _values(series: Sequence[Any], times: np.ndarray) -> np.ndarray:
    """States at times, from the series of the steps they lie in."""
    if len(series) == 1:
        values: np.ndarray = series[0](times)
        return values
    ends = np.array([output.bounds[1] for output in series[:-1]])
    piece = np.searchsorted(ends, times)
    return np.concatenate(
        [output(times[piece == k]) for k, output in enumerate(series) if (piece == k).any()]
    )


def _series(problem: Problem, machine: Any, last: float) -> list[Any]:
    """The series of every step; integrated again, because keeping them takes longer."""
    machine.time = problem.t0
    machine.state[:] = problem.start
    series = []
    while machine.time < last:
        *_, output, _ = machine.propagate_until(
            last, max_steps=AT_ONCE, c_output=True, **_options(problem)
        )
        series.append(output)
    return series


def _curve(problem: Problem, rtol: float, last: float, optimized: bool) -> Curve:
    """The curve through the steps, and between them by their series."""
    nq, code = problem.mechanism.nq, problem.code
    machine = code.borrow(problem.reference, rtol, optimized=optimized)
    series = _series(problem, machine, last)
    code.give_back(rtol, machine, optimized=optimized)
    t, y, along = np.array([problem.t0]), problem.start[None], None
    if series:
        marks = np.concatenate([series[0].times[:1], *(output.times[1:] for output in series)])
        # a step that ends a rounding before the end is followed by one of next to no length
        inner = marks[:-1][np.diff(marks) > NO_SERIES_STEP * (last - problem.t0)]
        t, along = np.append(inner, marks[-1]), partial(_values, series)
        y = along(t)
    q, v = code.rates.normalize(y[:, :nq]), y[:, nq:]
    rate = np.empty(y.T.shape)
    # t may be an array, because every operation on it is elementwise
    code.vectorize(problem.reference)(t, np.hstack([q, v]).T, rate)
    a, breaks = rate[nq:].T.copy(), np.array([0])
    return Curve(t=t, q=q, v=v, a=a, breaks=breaks, rates=code.rates, series=along)
