"""Which equations a motion is integrated with, by which method, and why."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import final

from mecanique.errors import DerivationError, InputError
from mecanique.model.mechanism import Mechanism
from mecanique.motion.compile.heyoka import is_installed
from mecanique.motion.record.steps import RightHandSide
from mecanique.motion.simulation.methods import METHODS
from mecanique.motion.simulation.problem import Integration, Problem

__all__ = [
    "COMPILED",
    "Choice",
    "first_choice",
    "may_change",
    "next_choice",
    "worth_reconsidering",
]

COMPILED = {
    "closed_form": "dop853 on the closed form, compiled in Python",
    "taylor": "Taylor series of the closed form, compiled by heyoka",
}
"""Methods on the equations derived in-house."""

SMALL = 3
"""With more velocities than this the closed form in Python is no faster than the reference."""

STEPS = 1200
"""Steps after which to see whether compiling pays; by then dop853 knows if equations are stiff."""

PAYOFF = 3.0
"""Compiling must save this many times what it takes, by an estimate."""

TIGHT_RTOL = 1e-11
"""At this tolerance or a smaller one, the whole motion is to be that accurate, not each step."""

MANY_STEPS = 10_000
"""So many steps of a tight tolerance are taken to a smaller one, because their errors add up."""

VERY_MANY_STEPS = 200_000
"""With more steps of dop853, optimizing the code of Taylor series, which take fewer, pays."""

FREE_STEPS = 300
"""So many steps may err by the tolerance each, one way, before their sum counts."""

MIN_RTOL = 1e-14
"""The least tolerance of a step of dop853: below it, rounding decides."""


@final
@dataclass(frozen=True)
class Choice:
    """A method and the equations it integrates.

    Args:
        method: of `METHODS`, or "taylor", which integrates what is compiled for the mechanism.
        equations: the right-hand side, which may overwrite its last answer; None for "taylor".
        closed_form: whether these are the closed form.
        share: part of the tolerance that a step may use.
        reason: why, where "auto" chose.
        automatic: whether "auto" may change the method.
        compiles: whether it may also compile; not any more once that failed.
        optimized: whether compiled code is optimized; None where that may change on the way.
    """

    method: str
    equations: RightHandSide | None
    closed_form: bool = False
    share: float = 1.0
    reason: str = ""
    automatic: bool = False
    compiles: bool = False
    optimized: bool | None = None

    @property
    def title(self) -> str:
        """What it is and why, for people."""
        if self.method == "taylor":
            text = f"taylor ({COMPILED['taylor']})"
        else:
            source = " on the closed form" if self.closed_form else ""
            text = f"{self.method} ({METHODS[self.method].title}){source}"
        return f"{text}; chosen for {self.reason}" if self.reason else text


def first_choice(problem: Problem, method: str) -> Choice:
    """Return what to start with.

    Raises:
        InputError: if the method does not allow what is asked for, or is not installed.
        DerivationError: if the method needs a closed form and there is none.
    """
    code, reference = problem.code, problem.reference
    if method == "taylor":
        if problem.events:
            names = ", ".join(repr(event.name) for event in problem.events)
            raise InputError(
                f"method 'taylor' watches for no events, got {names}; expected another method: "
                "'closed_form', or 'auto', which takes one that does"
            )
        fast = code.pays_to_optimize(problem.rtol)
        code.build_integrator(reference, problem.rtol, optimized=fast)
        return Choice("taylor", None)
    if method == "closed_form":
        return Choice("dop853", code.rhs(reference), closed_form=True)
    if method != "auto":
        return Choice(method, reference.rhs(overwriting=True))
    return Choice(
        "dop853",
        reference.rhs(overwriting=True),
        reason="non-stiff equations",
        automatic=True,
        compiles=code.possible and problem.loops is None,
    )


def next_choice(problem: Problem, choice: Choice, integration: Integration) -> Choice | None:
    """Return what to integrate with again after an integration; None if that one stands."""
    kind = integration.outcome.kind
    if kind == "stiff" and choice.automatic and choice.method == "dop853":
        reason = f"stiff equations, found by dop853 at t = {integration.t:.4g} s"
        return replace(choice, method="radau", reason=reason)
    if kind == "reconsider":
        return _reconsider(problem, choice, integration.t)
    return None


def may_change(problem: Problem, choice: Choice) -> bool:
    """Return whether another choice may pay after a while."""
    if problem.loops is not None or choice.method != "dop853":
        return False
    return choice.compiles or _can_tighten(problem, choice)


def worth_reconsidering(problem: Problem, choice: Choice, steps: int, t: float) -> bool:
    """Return whether another choice pays, as the first `STEPS` steps of dop853 suggest.

    It looks at no clock, and at nothing that ran before, so that the same call always gives the
    same motion.

    Args:
        problem: what is integrated.
        choice: what it is integrated with.
        steps: how many steps it took so far.
        t: the time they reached [s].
    """
    if steps != STEPS:
        return False
    if _can_tighten(problem, choice) and _steps_in_all(problem, t) > MANY_STEPS:
        return True
    code = problem.code
    if not (choice.compiles and code.possible):
        return False
    left = _seconds_left(problem, t)
    if _can_take_closed_form(problem, choice):
        return left > PAYOFF * code.seconds_to_derive()
    return _can_take_series(problem) and left > PAYOFF * code.seconds_to_build()


def _reconsider(problem: Problem, choice: Choice, t: float) -> Choice:
    """Tighten the steps if there are many, and compile if that pays."""
    steps, left, code = _steps_in_all(problem, t), _seconds_left(problem, t), problem.code
    if _can_tighten(problem, choice) and steps > MANY_STEPS:
        choice = replace(choice, share=max(FREE_STEPS / steps, MIN_RTOL / problem.rtol))
    if not (choice.compiles and code.possible):
        return choice
    if _can_take_series(problem) and left > PAYOFF * code.seconds_to_build():
        reason = "a motion long enough to pay for compiling"
        return _with_series(problem, choice, reason, optimized=steps > VERY_MANY_STEPS)
    if _can_take_closed_form(problem, choice) and left > PAYOFF * code.seconds_to_derive():
        return _with_closed_form(problem, choice)
    return choice


def _with_series(problem: Problem, choice: Choice, reason: str, optimized: bool) -> Choice:
    """Change to Taylor series, if the equations have them."""
    try:
        problem.code.build_integrator(problem.reference, problem.rtol, optimized=optimized)
    except DerivationError:
        return replace(choice, compiles=False)
    return replace(choice, method="taylor", equations=None, reason=reason, optimized=optimized)


def _with_closed_form(problem: Problem, choice: Choice) -> Choice:
    """Change to the closed form, if there is one."""
    try:
        return replace(choice, equations=problem.code.rhs(problem.reference), closed_form=True)
    except DerivationError:
        return replace(choice, compiles=False)


def _has_series(problem: Problem) -> bool:
    blind = any(callable(signal.signal) for signal in problem.mechanism.inputs)
    return not (problem.events or problem.loops or blind)


def _can_take_series(problem: Problem) -> bool:
    return _has_series(problem) and is_installed()


def _can_take_closed_form(problem: Problem, choice: Choice) -> bool:
    return problem.mechanism.nv <= SMALL and not choice.closed_form


def _can_tighten(problem: Problem, choice: Choice) -> bool:
    return choice.share == 1.0 and MIN_RTOL < problem.rtol <= TIGHT_RTOL


def _steps_in_all(problem: Problem, t: float) -> float:
    return STEPS * (problem.end - problem.t0) / (t - problem.t0)


def _seconds_left(problem: Problem, t: float) -> float:
    return (_steps_in_all(problem, t) - STEPS) * _seconds_per_step(problem.mechanism)


def _seconds_per_step(mechanism: Mechanism) -> float:
    """Return about what a step of dop853 takes on the reference [s]."""
    return 12 * (1.5e-6 + 0.5e-6 * mechanism.nv)
