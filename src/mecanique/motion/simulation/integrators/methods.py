"""The integration methods in one table, used in one way.

Stalled and stiff integrations are told from the steps alone, without a clock, and the curve through
the steps is made as accurate as they are.
"""

from __future__ import annotations

import sys
import warnings
from collections.abc import Callable, Iterator
from contextlib import AbstractContextManager, contextmanager
from dataclasses import dataclass, replace
from functools import cache
from importlib import import_module
from importlib.util import find_spec
from types import ModuleType
from typing import Any, Literal, NamedTuple, TypeAlias, final

import numpy as np

from mecanique.arrays import median
from mecanique.errors import IntegrationError
from mecanique.generation.dop853 import DAMPING, STIFF_AFTER, STIFF_FORGET, UNSTABLE
from mecanique.motion.record.curve import Curve, RightHandSide, Steps
from mecanique.motion.record.loops import ClosedLoops
from mecanique.motion.simulation.problem import Kind, Outcome, Problem
from mecanique.motion.tolerances import EPSILON, NO_STEP, SCIPY_RTOL, UNRESOLVED


class _Pace(NamedTuple):
    """How many points must cover which part of the duration, or the motion makes no headway."""

    points: int
    part: float


_TREES = _Pace(10_000, 1e-6)
"""To the end it would take more than 1e10 points.

A stiff transient, however short, takes some hundreds before the steps grow again.
"""

_LOOPS = _Pace(500, 5e-7)
"""Loops next to singular positions take milliseconds for an evaluation; 1e9 points to the end."""


@final
class StallDetector:
    """Watches the points of a run."""

    def __init__(self, problem: Problem, *, implicit: bool = False) -> None:
        self._pace = _TREES if problem.loops is None or implicit else _LOOPS
        self._least = self._pace.part * (problem.end - problem.t0)
        self._next, self._checked = self._pace.points, problem.t0

    def is_stalled(self, points: int, t: float) -> bool:
        """Return whether the last of so many points cover next to nothing."""
        if points < self._next:
            return False
        covered = t - self._checked
        self._next, self._checked = points + self._pace.points, t
        return covered < self._least


@final
class Stability:
    """Whether steps of dop853 are held short by stability rather than accuracy, across restarts.

    The last two evaluations of a step are at its end and estimate the greatest rate of decay there;
    as in Hairer, Nørsett & Wanner, Solving Ordinary Differential Equations I (1993), DOP853,
    fifteen steps at the limit make the equations stiff, unless six shorter ones in a row lie
    between.
    """

    def __init__(self) -> None:
        self._evaluations = [(np.zeros(0), np.zeros(0))] * 2
        self._at_limit = self._below = 0

    def noting(self, rhs: RightHandSide) -> RightHandSide:
        """Return the same equations, whose last two evaluations are kept."""

        def note(t: float, y: np.ndarray) -> np.ndarray:
            rate = rhs(t, y)
            self._evaluations = [self._evaluations[1], (y.copy(), rate.copy())]
            return rate

        return note

    def is_stiff(self, length: float) -> bool:
        """Return whether the equations are stiff, after a step of a length [s]."""
        (y, rate), (last, last_rate) = self._evaluations
        apart = float(np.linalg.norm(last - y)) if len(y) == len(last) else 0.0
        decay = length * float(np.linalg.norm(last_rate - rate)) if apart else 0.0
        if apart and decay > UNSTABLE * apart:
            self._at_limit, self._below = self._at_limit + 1, 0
        else:
            self._below += 1
            if self._below == STIFF_FORGET:
                self._at_limit = 0
        return self._at_limit >= STIFF_AFTER


@cache
def import_ode() -> Any:
    """Return SciPy's class `ode`.

    `scipy.integrate` imports sparse matrices, optimization and special functions for its other
    half: 0.3 s of processor time, a third of a first motion. The module that `ode` stands in needs
    none of them, and is imported alone unless the whole is there already; where another version of
    SciPy is built otherwise, the whole is imported.
    """
    if "scipy.integrate" not in sys.modules:
        spec = find_spec("scipy.integrate")
        assert spec is not None, "SciPy is required"
        # a package of the same folder, which imports nothing by itself
        package = ModuleType("_scipy_ode_alone")
        package.__path__ = list(spec.submodule_search_locations or ())
        sys.modules[package.__name__] = package
        try:
            return import_module("_scipy_ode_alone._ode").ode
        except (ImportError, AttributeError):
            pass  # the same from where everybody takes it
    from scipy.integrate import ode

    return ode


MIN_STEPS = 200
"""Steps before a restarted integration may count as stiff."""


WITHIN = 500
"""Steps that may lead from one step's begin to a state before its end; a few are usual."""


@final
@dataclass(frozen=True)
class IntegrationTask:
    """Equations to integrate and how accurately."""

    rhs: RightHandSide
    implicit: bool  # whether they need an implicit method
    rtol: float
    atol: float
    max_step: float = np.inf  # longest step, infinite if it need not be bounded [s]
    max_steps: int = 1_000_000
    # the equations for the explicit method, if they may overwrite their last answer; otherwise
    # those above
    quick: RightHandSide | None = None
    # whether the integration restarts so often that stiffness has to be watched for across
    # restarts, which the explicit method's own count forgets
    restarts: bool = False


Run: TypeAlias = Callable[[float], Outcome]
"""Integrates on from the last of the steps to a time, adding steps."""

Look: TypeAlias = Callable[[], Outcome | None]
"""Looks at the last step; returns an outcome if the integration has to halt there."""


@final
@dataclass(frozen=True)
class IntegrationMethod:
    """An integration method."""

    title: str
    # makes it ready for a task, to record steps and to look at each
    open: Callable[[IntegrationTask, Steps, Look], AbstractContextManager[Run]]
    # whether the rates at its steps are as accurate as the states, so that neighboring steps can
    # be interpolated with them; otherwise each step is noted by several points of the method's
    # own interpolation
    smooth: bool


class EquationsError(Exception):
    """The equations failed on the way to a state; the cause is what they raised."""


class StalledError(EquationsError):
    """The way to a state took more steps than are allowed, or steps too small."""


class Reached(NamedTuple):
    """A state reached from an earlier one, and the evaluations of the equations that took."""

    y: np.ndarray
    evaluations: int


def advance(task: IntegrationTask, t: float, y: np.ndarray, end: float) -> Reached:
    """Return the state at a time [s], from the state at an earlier time near it."""
    if end == t:
        return Reached(y.copy(), 0)
    with _lend(task.rhs) as guard:
        step = _radau_step if task.implicit else _dop853_step
        result = step(guard, task, t, y, end)
        if guard.fault is not None:
            raise EquationsError from guard.fault
        return Reached(result, guard.evaluations)


def advance_within(task: IntegrationTask, t: float, y: np.ndarray, end: float) -> Reached:
    """Return the state at a time within a step, from the state at its begin, as `advance` does."""
    return advance(replace(task, max_steps=WITHIN), t, y, end)


def _radau_step(
    guard: _Guard, task: IntegrationTask, t: float, y: np.ndarray, end: float
) -> np.ndarray:
    from scipy.integrate import Radau

    rtol = max(task.rtol, SCIPY_RTOL)
    solver = Radau(guard.rates, t, y, end, rtol=rtol, atol=task.atol, first_step=end - t)
    for _ in range(task.max_steps):
        if solver.status != "running":
            break
        solver.step()
    if guard.fault is None and solver.status != "finished":
        raise StalledError
    return np.array(solver.y)


def _dop853_step(
    guard: _Guard, task: IntegrationTask, t: float, y: np.ndarray, end: float
) -> np.ndarray:
    solver = import_ode()(guard.rates).set_integrator(
        "dop853", rtol=task.rtol, atol=task.atol, nsteps=task.max_steps, first_step=end - t
    )
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # the return code says the same
        result: np.ndarray = solver.set_initial_value(y, t).integrate(end)
    left = end - float(solver.t)
    if guard.fault is None and not solver.successful() and left > NO_STEP * abs(end):
        raise StalledError  # the state is that at which the steps ended
    return result


@final
class _Guard:
    """The equations as SciPy's integrators may call them: counted, and raising nothing.

    No exception may pass through compiled code: what the equations raise is kept, and answered by
    a rate that is not a number, which ends the integration.
    """

    __slots__ = ("_rhs", "evaluations", "fault", "last")

    def __init__(self, rhs: RightHandSide) -> None:
        self._rhs = rhs
        self.evaluations = 0
        self.fault: BaseException | None = None
        self.last: np.ndarray = np.empty(0)

    def rates(self, t: float, y: np.ndarray) -> np.ndarray:
        """Return the rates, and keep them as the last."""
        self.evaluations += 1
        try:
            self.last = rate = self._rhs(t, y)
        except BaseException as error:
            self.fault = self.fault or error  # what comes after it follows from the first
            self.last = rate = np.full(len(y), np.nan)
        return rate

    def let_go(self) -> None:
        """Drop the equations and their last rates."""
        self._rhs, self.fault, self.last = _nothing, None, np.empty(0)


def _pass(t: float, y: np.ndarray) -> Literal[0]:
    return 0


def _nothing(t: float, y: np.ndarray) -> np.ndarray:
    return np.full(len(y), np.nan)


@contextmanager
def _lend(rhs: RightHandSide) -> Iterator[_Guard]:
    """Lend equations to SciPy, whose compiled dop853 (1.17) keeps a reference to them."""
    guard = _Guard(rhs)
    try:
        yield guard
    finally:
        guard.let_go()


@contextmanager
def _dop853(task: IntegrationTask, steps: Steps, look: Look) -> Iterator[Run]:
    """Integrate by SciPy's compiled dop853: one integrator, restarted for each stretch."""
    stability = Stability()
    rhs, reused = task.quick or task.rhs, task.quick is not None
    add, times = steps.add, steps.t
    at_start = True
    halted: Outcome | None = None

    def accept(t: float, y: np.ndarray) -> Literal[-1, 0]:
        nonlocal at_start, halted
        if at_start:  # which is already among the steps
            at_start = False
            return 0
        # the last evaluation was at the step's end
        add(t, y, guard.last.copy() if reused else guard.last)
        if task.restarts and stability.is_stiff(t - times[-2]) and len(times) > MIN_STEPS:
            halted = Outcome("stiff")
        else:
            halted = _look_safely(look)
        return 0 if halted is None else -1

    def run(end: float) -> Outcome:
        nonlocal at_start, halted
        at_start, halted = True, None
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # the return code says the same
            solver.set_initial_value(steps.y[-1], times[-1]).integrate(end)
        if guard.fault is not None:
            return Outcome("fault", guard.fault)
        if halted is not None:
            return halted
        return Outcome(_DOP853_CODES[solver.get_return_code()])

    with _lend(stability.noting(rhs) if task.restarts else rhs) as guard:
        solver = import_ode()(guard.rates).set_integrator(
            "dop853",
            rtol=task.rtol,
            atol=task.atol,
            nsteps=task.max_steps,
            max_step=0.0 if np.isinf(task.max_step) else task.max_step,
            beta=DAMPING,
        )
        solver.set_solout(accept)
        try:
            yield run
        finally:
            solver.set_solout(_pass)
            steps.evaluations += guard.evaluations


_DOP853_CODES: dict[int, Kind] = {
    1: "end",
    2: "halt",
    -1: "step too small",
    -2: "too many steps",
    -3: "step too small",
    -4: "stiff",
}


def _look_safely(look: Look) -> Outcome | None:
    """Look at the last step; what that raises is the outcome, as no caller may let it pass."""
    try:
        return look()
    except BaseException as error:
        return Outcome("fault", error)


def _implicit(
    name: Literal["LSODA", "Radau", "BDF"], degree: int
) -> Callable[[IntegrationTask, Steps, Look], AbstractContextManager[Run]]:
    """Integrate by one of SciPy's classes, whose steps are polynomials of a degree."""
    places = np.arange(1, degree + 1) / degree

    @contextmanager
    def open_run(task: IntegrationTask, steps: Steps, look: Look) -> Iterator[Run]:
        from scipy import integrate

        types = {"LSODA": integrate.LSODA, "Radau": integrate.Radau, "BDF": integrate.BDF}

        def fail() -> Outcome:
            fault = guard.fault
            return Outcome("step too small") if fault is None else Outcome("fault", fault)

        def run(end: float) -> Outcome:
            with warnings.catch_warnings():
                warnings.simplefilter("ignore")  # the solver's status says the same
                solver = types[name](
                    guard.rates,
                    steps.t[-1],
                    steps.y[-1],
                    end,
                    rtol=max(task.rtol, SCIPY_RTOL),
                    atol=task.atol,
                    max_step=task.max_step,
                )
                for _ in range(task.max_steps):
                    try:
                        solver.step()
                    except (ValueError, ArithmeticError, np.linalg.LinAlgError):
                        return fail()  # a state that is not finite
                    if guard.fault is not None or solver.status == "failed":
                        return fail()
                    before, now = float(solver.t_old or 0.0), float(solver.t)
                    times = before + places * (now - before)
                    times[-1] = now
                    states = np.asarray(solver.dense_output()(times)).T
                    states[-1] = solver.y
                    rates = [guard.rates(t, y) for t, y in zip(times, states, strict=True)]
                    steps.add_spread(times, states, np.array(rates))
                    if (halted := _look_safely(look)) is not None:
                        return halted
                    if guard.fault is not None:
                        return fail()
                    if solver.status == "finished":
                        return Outcome("end")
            return Outcome("too many steps")

        with _lend(task.rhs) as guard:
            try:
                yield run
            finally:
                steps.evaluations += guard.evaluations

    return open_run


METHODS: dict[str, IntegrationMethod] = {
    "dop853": IntegrationMethod(
        "explicit Runge-Kutta of order 8(5,3), Dormand & Prince", _dop853, smooth=True
    ),
    "lsoda": IntegrationMethod(
        "LSODA, Adams or BDF by stiffness, Hindmarsh & Petzold", _implicit("LSODA", 9), smooth=False
    ),
    "radau": IntegrationMethod(
        "implicit Runge-Kutta of order 5, Radau IIA, Hairer & Wanner",
        _implicit("Radau", 3),
        smooth=False,
    ),
    "bdf": IntegrationMethod(
        "backward differentiation formulas of order 1 to 5", _implicit("BDF", 5), smooth=False
    ),
}
"""Every method by the name `simulate` knows it under."""


def step_accuracy(problem: Problem) -> tuple[float, float]:
    """Return relative and absolute tolerance of the steps.

    Closing the loops restarts each, and their errors add up.
    """
    part = 1.0 if problem.loops is None else ClosedLoops.share
    return part * problem.rtol, part * problem.atol


def refine(problem: Problem, task: IntegrationTask, steps: Steps, *, smooth: bool) -> Curve:
    """Halve the intervals on which the polynomial is less accurate than the steps.

    Once only: what is left then is not the polynomial's error but that of the steps, which fit each
    other no better than to the tolerance, and looks the larger the closer they are.
    """
    nq, rates = problem.mechanism.nq, problem.code.rates
    rounding = EPSILON * max(1.0, abs(steps.t[0]), abs(steps.t[-1]))
    rtol, atol = step_accuracy(problem)
    lengths = np.diff(steps.t)
    lengths = lengths[lengths > 0]
    # what closes in on an event or a corner takes steps of rounding
    short = len(lengths) > 0 and lengths.min() <= UNRESOLVED * median(lengths)
    curve = steps.curve(nq, rates, smooth, close=rtol < 1000 * rounding or bool(short))
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
    coarse = left[(excess > 1) & (length > UNRESOLVED * median(length))]
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
