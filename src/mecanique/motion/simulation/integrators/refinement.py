"""Make the curve through the steps of a motion as accurate as the steps."""

from __future__ import annotations

import numpy as np

from mecanique.arrays import median
from mecanique.errors import IntegrationError
from mecanique.motion.record.curve import Curve
from mecanique.motion.record.loops import ClosedLoops
from mecanique.motion.record.steps import Steps
from mecanique.motion.simulation.integrators.methods import (
    EquationsError,
    StalledError,
    Task,
    advance_within,
)
from mecanique.motion.simulation.problem import Problem

MIN_LENGTH = 1e-6
"""Intervals below this fraction of the median are not halved: no step resolves the kink in them."""

EPSILON = 2.2e-16
"""Relative rounding of a number."""


def step_accuracy(problem: Problem) -> tuple[float, float]:
    """Return relative and absolute tolerance of the steps.

    Closing the loops restarts each, and their errors add up.
    """
    part = 1.0 if problem.loops is None else ClosedLoops.share
    return part * problem.rtol, part * problem.atol


def refine(problem: Problem, task: Task, steps: Steps, *, smooth: bool) -> Curve:
    """Halve the intervals on which the polynomial is less accurate than the steps.

    Once only: what is left then is not the polynomial's error but that of the steps, which fit each
    other no better than to the tolerance, and looks the larger the closer they are.
    """
    nq, rates = problem.mechanism.nq, problem.code.rates
    rounding = EPSILON * max(1.0, abs(steps.t[0]), abs(steps.t[-1]))
    rtol, atol = step_accuracy(problem)
    curve = steps.curve(nq, rates, smooth, close=rtol < 1000 * rounding)
    left = curve.intervals
    if not smooth or not len(left):
        return curve
    position, velocity = curve.errors()
    first = rates.first(curve.q, curve.v)

    def allow(x: np.ndarray, rate: np.ndarray) -> np.ndarray:
        # times of steps are rounded, and no step more makes that better
        relative = np.abs(x[left]) * rtol + np.abs(rate[left]) * 100 * rounding
        bound: np.ndarray = atol + relative.max(axis=1)
        return bound

    excess = np.maximum(position / allow(curve.q, first), velocity / allow(curve.v, curve.a))
    length = curve.t[left + 1] - curve.t[left]
    coarse = left[(excess > 1) & (length > MIN_LENGTH * median(length))]
    t = (curve.t[coarse] + curve.t[coarse + 1]) / 2
    states = []
    try:
        for i, middle in zip(coarse, t.tolist(), strict=True):
            y = np.concatenate([curve.q[i], curve.v[i]])
            there = advance_within(task, float(curve.t[i]), y, middle).y
            states.append(problem.correct(middle, there))
    except StalledError:
        raise IntegrationError(
            f"no headway between the steps at t = {curve.t[i]:.6g} s and {curve.t[i + 1]:.6g} s",
            time=float(curve.t[i]),
            state=y,
        ) from None
    except EquationsError:
        return curve
    if not states or not np.isfinite(y := np.array(states)).all():
        return curve
    dy = np.array([task.rhs(s, x) for s, x in zip(t.tolist(), states, strict=True)])
    return curve.with_steps(coarse, t, y[:, :nq], y[:, nq:], dy[:, nq:])
