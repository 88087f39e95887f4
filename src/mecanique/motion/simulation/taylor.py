"""A motion by Taylor series: the compiled integrator runs by itself, and keeps the series of every step."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any, NamedTuple

import numpy as np

from mecanique.model.mechanism import Mechanism
from mecanique.motion.compile.cache import Compiled
from mecanique.motion.record.curve import Curve
from mecanique.motion.record.rates import Rates

__all__ = ["Flow", "flow"]

AT_ONCE = 20_000
"""Steps between looks at progress and interruption."""

PARTS = (2, 4, 8, 16)
"""Into how many parts a step is cut for the curve through states; the first that is accurate is taken."""


class Flow(NamedTuple):
    """What the integrator yields.

    Args:
        last: time at its end [s].
        states: shape (n, nq + nv), at the times asked for that it reached.
        steps: number of steps.
        curve: gives the motion as a curve through states.
        trouble: what stopped it before its end; empty if nothing did.
        fault: what `progress` raised, if it did.
    """

    last: float
    states: np.ndarray
    steps: int
    curve: Callable[[], Curve]
    trouble: str
    fault: Exception | None = None


def flow(
    mechanism: Mechanism,
    reference: Any,
    code: Compiled,
    start: np.ndarray,
    times: np.ndarray,
    span: tuple[float, float],
    rtol: float,
    max_step: float,
    max_steps: int,
    progress: Callable[[float], object] | None,
) -> Flow:
    """Integrate a motion.

    Args:
        mechanism: what moves.
        reference: its `Reference`.
        code: what is compiled for it.
        start: shape (nq + nv,).
        times: of the samples, shape (n,) [s].
        span: start and end [s].
        rtol: relative error of a step.
        max_step: longest step [s].
        max_steps: most steps.
        progress: called with the fraction done.
    """
    t0, end = span
    machine = code.borrow(reference, rtol)
    options: dict[str, Any] = {} if np.isinf(max_step) else {"max_delta_t": max_step}
    steps, trouble, states = 0, "", [start[None]] if times[0] == t0 else []
    fault: Exception | None = None
    inner = times[times > t0]
    try:
        machine.time = t0
        machine.state[:] = start
        while machine.time < end and not trouble:
            machine = code.exchanged(reference, rtol, machine, steps)
            limits = {"max_steps": min(AT_ONCE, max_steps - steps), **options}
            some = inner[:AT_ONCE]
            if len(some) and some[0] < end:  # samples on the way are read off the series
                grid = np.concatenate([[machine.time], some])
                outcome, _, _, taken, *_, found = machine.propagate_grid(grid, **limits)
                states.append(found[1:])
            else:
                outcome, _, _, taken, *_ = machine.propagate_until(end, **limits)
                asked = len(some) and machine.time == end
                states.append(machine.state[None].copy() if asked else np.empty((0, len(start))))
            inner = inner[len(states[-1]) :]
            steps += taken
            if outcome.name == "step_limit":
                trouble = "too many steps" if steps >= max_steps else ""
            elif outcome.name != "time_limit":
                trouble = "collapsed"
            if progress is not None:
                try:
                    progress((machine.time - t0) / (end - t0))
                except Exception as error:
                    trouble, fault = "told to stop", error
    except KeyboardInterrupt:
        trouble = "interrupted"
    last = float(machine.time)
    code.give_back(rtol, machine, steps)

    def curve() -> Curve:
        return _curve(mechanism, code, reference, start, (t0, last), rtol, options)

    return Flow(
        last,
        np.concatenate(states) if states else np.empty((0, len(start))),
        steps,
        curve,
        trouble,
        fault,
    )


def _values(series: Sequence[Any], times: np.ndarray) -> np.ndarray:
    """States at times, from the series of the steps they lie in."""
    if len(series) == 1:
        found: np.ndarray = series[0](times)
        return found
    ends = np.array([output.bounds[1] for output in series[:-1]])
    piece = np.searchsorted(ends, times)
    return np.concatenate(
        [output(times[piece == k]) for k, output in enumerate(series) if (piece == k).any()]
    )


def _series(
    machine: Any, start: np.ndarray, span: tuple[float, float], options: dict[str, Any]
) -> list[Any]:
    """The series of every step; integrated again, because keeping them takes longer than finding them."""
    machine.time = span[0]
    machine.state[:] = start
    series = []
    while machine.time < span[1]:
        *_, output, _ = machine.propagate_until(
            span[1], max_steps=AT_ONCE, c_output=True, **options
        )
        series.append(output)
    return series


def _curve(
    mechanism: Mechanism,
    code: Compiled,
    reference: Any,
    start: np.ndarray,
    span: tuple[float, float],
    rtol: float,
    options: dict[str, Any],
) -> Curve:
    """The curve through enough states that it is as accurate as the series."""
    nq, rates, rhs = mechanism.nq, Rates.of(mechanism), code.batched(reference)
    machine = code.borrow(reference, rtol)
    series = _series(machine, start, span, options)
    code.give_back(rtol, machine)
    if not series:
        y, rate = start[:, None], np.empty((len(start), 1))
        _fill(rhs, np.array(span[:1]), y, rate)
        return Curve(np.array(span[:1]), y[:nq].T, y[nq:].T, rate[nq:].T, np.array([0]), rates)
    marks = np.concatenate([series[0].times[:1], *(output.times[1:] for output in series)])
    # a step that ends a rounding before the end is followed by one of no length to speak of
    marks = np.append(marks[:-1][np.diff(marks) > 1e-12 * (span[1] - span[0])], marks[-1])
    for parts in PARTS:
        inner = marks[:-1, None] + np.diff(marks)[:, None] * (np.arange(parts) / parts)
        t = np.append(inner.ravel(), marks[-1])
        y = _values(series, t)
        q, v, rate = rates.normalized(y[:, :nq]), y[:, nq:], np.empty(y.T.shape)
        _fill(rhs, t, np.hstack([q, v]).T, rate)
        curve = Curve(t, q, v, rate[nq:].T.copy(), np.array([0]), rates)
        middle = (t[1:] + t[:-1]) / 2
        exact = _values(series, middle)
        found = curve(middle)
        gap = np.abs(np.hstack([found.q, found.v]) - exact) / (
            rtol + max(rtol, 1e-15) * np.abs(exact)
        )
        if gap.max(initial=0.0) <= 10:
            break
    return curve


def _fill(rhs: Any, t: np.ndarray, Y: np.ndarray, out: np.ndarray) -> None:
    """Rates at many times; t may be an array, because every operation on it is elementwise."""
    rhs(t, Y, out)
