"""The integration methods: one table, one way to call them."""

from __future__ import annotations

import warnings
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any, Literal, TypeAlias, final

import numpy as np

from mecanique.motion.record.steps import RightHandSide, Steps

__all__ = ["METHODS", "Method", "Outcome", "Task", "advance"]

_DOUBT = 200
"""Steps after which stiffness is looked for across restarts."""

LEAST_RTOL = 2.3e-14
"""The least relative tolerance that SciPy's classes take."""

_DAMPING = 0.04
"""How much of the last step's error the next step's length heeds; without it a sixth of all steps of a swinging motion
are refused (K. Gustafsson, ACM Trans. Math. Softw. 17 (1991) 533; Hairer, Nørsett & Wanner, sect.
II.4 and IV.2)."""

Outcome: TypeAlias = Literal["end", "stopped", "stiff", "too many steps", "step too small", "fault"]
"""How a stretch ended: at its end, by the watcher, or by what stopped the method."""


@final
class _Doubt:
    """Whether steps of dop853 are held short by stability rather than accuracy, counted across restarts.

    The last two evaluations of a step are at its end and estimate the greatest rate of decay there;
    as in Hairer, Nørsett & Wanner, Solving Ordinary Differential Equations I (1993), DOP853,
    fifteen steps at the limit make the equations stiff, unless six shorter ones in a row lie
    between.
    """

    def __init__(self) -> None:
        self._evaluations = [(np.zeros(0), np.zeros(0))] * 2
        self._at_limit = self._below = 0

    def note(self, y: np.ndarray, rate: np.ndarray) -> None:
        """Keep an evaluation."""
        self._evaluations = [self._evaluations[1], (y.copy(), rate)]

    def step(self, length: float) -> bool:
        """Return whether the equations are stiff, after a step of a length [s]."""
        (y, rate), (last, last_rate) = self._evaluations
        apart = float(np.linalg.norm(last - y)) if len(y) == len(last) else 0.0
        if apart > 0.0 and length * float(np.linalg.norm(last_rate - rate)) > 6.1 * apart:
            self._at_limit, self._below = self._at_limit + 1, 0
        else:
            self._below += 1
            if self._below == 6:
                self._at_limit = 0
        return self._at_limit >= 15


@final
@dataclass
class Task:
    """Equations to integrate and how accurately.

    No exception may leave a function that SciPy's compiled integrators call: what the equations
    raise is kept in `fault` and answered by a rate that is not a number, which ends the
    integration.

    Args:
        rhs: the equations.
        implicit: whether they need an implicit method.
        rtol: relative tolerance of a step.
        atol: absolute tolerance of a step.
        max_step: longest step, infinite if it need not be bounded [s].
        max_steps: most steps.
        quick: the equations for the explicit method, if they may overwrite their last answer;
            otherwise those above.
        doubtful: whether to watch for stiffness across restarts, which the explicit method's own
            count forgets.
        evaluations: number of evaluations of the equations so far.
        fault: what the equations raised, if anything.
    """

    rhs: RightHandSide
    implicit: bool
    rtol: float
    atol: float
    max_step: float
    max_steps: int
    quick: RightHandSide | None = None
    doubtful: bool = False
    evaluations: int = 0
    fault: BaseException | None = field(default=None, init=False)
    doubt: _Doubt = field(default_factory=_Doubt, init=False)


Run: TypeAlias = Callable[[Task, Steps, float, Callable[[], bool]], Outcome]
"""Integrates from the last of the steps to a time, adding steps; after each one the watcher says whether to halt."""


@final
@dataclass(frozen=True)
class Method:
    """An integration method.

    Args:
        title: what it is, in a few words.
        run: how it integrates.
        smooth: whether the rates at its steps are as accurate as the states, so that neighboring
            steps can be interpolated with them; otherwise each step is noted by several points of
            the method's own interpolation.
    """

    title: str
    run: Run
    smooth: bool


def advance(task: Task, t: float, y: np.ndarray, end: float) -> np.ndarray:
    """Return the state at a time, from the state at an earlier time near it.

    Args:
        task: the equations and tolerances.
        t: time of the state [s].
        y: the state.
        end: time asked for [s].
    """
    if end == t:
        same: np.ndarray = y.copy()
        return same
    follow = _Follower(task)
    if task.implicit:
        from scipy.integrate import Radau

        solver = Radau(
            follow, t, y, end, rtol=max(task.rtol, LEAST_RTOL), atol=task.atol, first_step=end - t
        )
        while solver.status == "running":
            solver.step()
        return np.array(solver.y) if solver.status == "finished" else np.full(len(y), np.nan)
    from scipy.integrate import ode

    def called(t: float, y: np.ndarray) -> np.ndarray:
        return follow(t, y)

    explicit = ode(called).set_integrator(
        "dop853", rtol=task.rtol, atol=task.atol, nsteps=task.max_steps, first_step=end - t
    )
    with warnings.catch_warnings():
        warnings.simplefilter(
            "ignore"
        )  # a failure shows as a state that is not finite, or at the next step
        result: np.ndarray = explicit.set_initial_value(y, t).integrate(end)
    _let_go(explicit, called)
    return result


@final
class _Follower:
    """The equations as SciPy's integrators may call them: counted, and raising nothing."""

    def __init__(self, task: Task) -> None:
        self._task = task

    def __call__(self, t: float, y: np.ndarray) -> np.ndarray:
        task = self._task
        task.evaluations += 1
        try:
            return task.rhs(t, y)
        except BaseException as error:
            task.fault = error
            return np.full(len(y), np.nan)


def _dop853(task: Task, steps: Steps, end: float, watch: Callable[[], bool]) -> Outcome:
    from scipy.integrate import ode

    rhs, add = task.quick or task.rhs, steps.add
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

    def doubted(t: float, y: np.ndarray) -> np.ndarray:
        task.doubt.note(y, follow(t, y).copy())
        return rate

    stiff = False
    first = True

    def accepted(t: float, y: np.ndarray) -> Literal[-1, 0]:
        nonlocal first, stiff
        if first:  # the start, which is already among the steps
            first = False
            return 0
        add(
            t, y, rate if task.quick is None else rate.copy()
        )  # the last evaluation was at the step's end
        if task.doubtful and task.doubt.step(t - steps.t[-2]) and len(steps.t) > _DOUBT:
            stiff = True
            return -1
        try:
            return -1 if watch() else 0
        except BaseException as error:
            task.fault = error
            return -1

    solver = ode(doubted if task.doubtful else follow).set_integrator(
        "dop853",
        rtol=task.rtol,
        atol=task.atol,
        nsteps=task.max_steps,
        max_step=0.0 if np.isinf(task.max_step) else task.max_step,
        beta=_DAMPING,
    )
    solver.set_solout(accepted)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # the return code says the same
        solver.set_initial_value(steps.y[-1], steps.t[-1]).integrate(end)
    task.evaluations += calls
    outcomes: dict[int, Outcome] = {
        1: "end",
        2: "stopped",
        -1: "step too small",
        -2: "too many steps",
        -3: "step too small",
        -4: "stiff",
    }
    faulty = task.fault is not None
    outcome: Outcome = (
        "fault" if faulty else "stiff" if stiff else outcomes[solver.get_return_code()]
    )
    _let_go(solver, follow, accepted)
    return outcome


def _let_go(solver: Any, *functions: Callable[..., Any]) -> None:
    """Empty what would be kept for ever: SciPy 1.17 gives back no function that its compiled dop853 has called."""
    vars(solver._integrator).clear()
    for function in functions:
        for cell in function.__closure__ or ():
            cell.cell_contents = None


def _implicit(name: Literal["LSODA", "Radau", "BDF"], degree: int) -> Run:
    """The run of one of SciPy's classes, whose steps are polynomials of a degree."""
    places = np.arange(1, degree + 1) / degree

    def run(task: Task, steps: Steps, end: float, watch: Callable[[], bool]) -> Outcome:
        from scipy import integrate

        steps.spread = True
        follow = _Follower(task)
        solver_type = {"LSODA": integrate.LSODA, "Radau": integrate.Radau, "BDF": integrate.BDF}[
            name
        ]
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # the solver's status says the same
            rtol = max(task.rtol, LEAST_RTOL)
            solver = solver_type(
                follow,
                steps.t[-1],
                steps.y[-1],
                end,
                rtol=rtol,
                atol=task.atol,
                max_step=task.max_step,
            )
            for _ in range(task.max_steps):
                try:
                    solver.step()
                except (
                    ValueError,
                    ArithmeticError,
                    np.linalg.LinAlgError,
                ):  # a state that is not finite
                    return "fault" if task.fault is not None else "step too small"
                if task.fault is not None:
                    return "fault"
                if solver.status == "failed":
                    return "step too small"
                before, now = float(solver.t_old or 0.0), float(solver.t)
                times = before + places * (now - before)
                times[-1] = now
                states = np.asarray(solver.dense_output()(times)).T
                states[-1] = solver.y
                steps.add_spread(
                    times,
                    states,
                    np.array([follow(t, y) for t, y in zip(times, states, strict=True)]),
                )
                if watch():
                    return "stopped"
                if solver.status == "finished":
                    return "fault" if task.fault is not None else "end"
        return "too many steps"

    return run


METHODS: dict[str, Method] = {
    "dop853": Method(
        "explicit Runge-Kutta of order 8(5,3), Dormand & Prince", _dop853, smooth=True
    ),
    "lsoda": Method(
        "LSODA, Adams or BDF by stiffness, Hindmarsh & Petzold", _implicit("LSODA", 9), smooth=False
    ),
    "radau": Method(
        "implicit Runge-Kutta of order 5, Radau IIA, Hairer & Wanner",
        _implicit("Radau", 3),
        smooth=False,
    ),
    "bdf": Method(
        "backward differentiation formulas of order 1 to 5", _implicit("BDF", 5), smooth=False
    ),
}
"""Every method by the name `simulate` knows it under."""
