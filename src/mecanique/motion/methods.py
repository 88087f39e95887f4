"""The integration methods: one table, one way to call them."""

from __future__ import annotations

import warnings
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Literal, TypeAlias, final

import numpy as np

from mecanique.motion.steps import RightHandSide, Steps

__all__ = ["METHODS", "Method", "Outcome", "Task", "advance"]

Outcome: TypeAlias = Literal["end", "stopped", "stiff", "too many steps", "step too small", "fault"]
"""How a stretch ended: at its end, by the watcher, or by what stopped the method."""


@final
@dataclass
class Task:
    """Equations to integrate and how accurately.

    No exception may leave a function that SciPy's compiled integrators call: what the equations raise is kept in
    `fault` and answered by a rate that is not a number, which ends the integration.

    Args:
        rhs: the equations.
        rtol: relative tolerance of a step.
        atol: absolute tolerance of a step.
        max_step: longest step, infinite if it need not be bounded [s].
        max_steps: most steps.
        evaluations: number of evaluations of the equations so far.
        fault: what the equations raised, if anything.
    """

    rhs: RightHandSide
    rtol: float
    atol: float
    max_step: float
    max_steps: int
    evaluations: int = 0
    fault: BaseException | None = field(default=None, init=False)


Run: TypeAlias = Callable[[Task, Steps, float, Callable[[], bool]], Outcome]
"""Integrates from the last of the steps to a time, adding steps; after each one the watcher says whether to halt."""


@final
@dataclass(frozen=True)
class Method:
    """An integration method.

    Args:
        title: what it is, in a few words.
        run: how it integrates.
        smooth: whether the rates at its steps are as accurate as the states.
    """

    title: str
    run: Run
    smooth: bool


def advance(task: Task, t: float, y: np.ndarray, end: float) -> np.ndarray:
    """Return the state at a time, from the state at a time near it, by the eighth-order method.

    Args:
        task: the equations and tolerances.
        t: time of the state [s].
        y: the state.
        end: time asked for [s].
    """
    if end == t:
        same: np.ndarray = y.copy()
        return same
    from scipy.integrate import ode

    def rate(s: float, x: np.ndarray) -> np.ndarray:
        task.evaluations += 1
        try:
            slope = task.rhs(s, x)
        except BaseException as error:
            task.fault = error
            slope = np.full(len(x), np.nan)
        return slope

    solver = ode(rate).set_integrator(
        "dop853", rtol=task.rtol, atol=task.atol, nsteps=task.max_steps, first_step=end - t
    )
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # a failure shows as a state that is not finite, or at the next step
        result: np.ndarray = solver.set_initial_value(y, t).integrate(end)
    return result


def _dop853(task: Task, steps: Steps, end: float, watch: Callable[[], bool]) -> Outcome:
    from scipy.integrate import ode

    rhs, add = task.rhs, steps.add
    rate = steps.dy[-1]
    calls = 0

    def follow(t: float, y: np.ndarray) -> np.ndarray:
        nonlocal rate, calls
        calls += 1
        try:
            rate = rhs(t, y)
        except BaseException as error:
            task.fault = error
            rate = np.full(len(y), np.nan)
        return rate

    first = True

    def accepted(t: float, y: np.ndarray) -> Literal[-1, 0]:
        nonlocal first
        if first:  # the start, which is already among the steps
            first = False
            return 0
        add(t, y, rate)  # the last evaluation was at the step's end
        try:
            return -1 if watch() else 0
        except BaseException as error:
            task.fault = error
            return -1

    solver = ode(follow).set_integrator(
        "dop853",
        rtol=task.rtol,
        atol=task.atol,
        nsteps=task.max_steps,
        max_step=0.0 if np.isinf(task.max_step) else task.max_step,
    )
    solver.set_solout(accepted)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # the return code says the same
        solver.set_initial_value(steps.y[-1], steps.t[-1]).integrate(end)
    task.evaluations += calls
    if task.fault is not None:
        return "fault"
    outcomes: dict[int, Outcome] = {
        1: "end",
        2: "stopped",
        -1: "step too small",
        -2: "too many steps",
        -3: "step too small",
        -4: "stiff",
    }
    return outcomes[solver.get_return_code()]


def _implicit(name: Literal["LSODA", "Radau", "BDF"]) -> Run:
    def run(task: Task, steps: Steps, end: float, watch: Callable[[], bool]) -> Outcome:
        from scipy import integrate

        calls = 0

        def follow(t: float, y: np.ndarray) -> np.ndarray:
            nonlocal calls
            calls += 1
            try:
                return task.rhs(t, y)
            except BaseException as error:
                task.fault = error
                return np.full(len(y), np.nan)

        solver_type = {"LSODA": integrate.LSODA, "Radau": integrate.Radau, "BDF": integrate.BDF}[name]
        outcome: Outcome = "end"
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # the solver's status says the same
            rtol = max(task.rtol, 2.3e-14)  # the least SciPy takes
            solver = solver_type(
                follow, steps.t[-1], steps.y[-1], end, rtol=rtol, atol=task.atol, max_step=task.max_step
            )
            for _ in range(task.max_steps):
                try:
                    solver.step()
                except (ValueError, ArithmeticError, np.linalg.LinAlgError):  # a state that is not finite
                    outcome = "step too small"
                    break
                if task.fault is not None or solver.status == "failed":
                    outcome = "step too small"
                    break
                steps.add(float(solver.t), solver.y, follow(solver.t, solver.y))
                if watch():
                    outcome = "stopped"
                    break
                if solver.status == "finished":
                    break
            else:
                outcome = "too many steps"
        task.evaluations += calls
        return "fault" if task.fault is not None else outcome

    return run


METHODS: dict[str, Method] = {
    "dop853": Method("explicit Runge-Kutta of order 8(5,3), Dormand & Prince", _dop853, smooth=True),
    "lsoda": Method("LSODA, Adams or BDF by stiffness, Hindmarsh & Petzold", _implicit("LSODA"), smooth=False),
    "radau": Method("implicit Runge-Kutta of order 5, Radau IIA, Hairer & Wanner", _implicit("Radau"), smooth=False),
    "bdf": Method("backward differentiation formulas of order 1 to 5", _implicit("BDF"), smooth=False),
}
"""Every method by the name `simulate` knows it under."""
