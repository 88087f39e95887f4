"""Choose the equations and the method of an integration, and say why."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import partial
from typing import final

from mecanique.errors import DerivationError, InputError
from mecanique.motion.compile import costs
from mecanique.motion.compile.closed import ClosedProgram
from mecanique.motion.compile.heyoka import is_installed
from mecanique.motion.compile.stepper import has_compiler
from mecanique.motion.record.curve import RightHandSide
from mecanique.motion.simulation.integrators.methods import METHODS, step_accuracy
from mecanique.motion.simulation.problem import Integration, Problem
from mecanique.motion.tolerances import LEAST_RTOL, TIGHT_RTOL

COMPILED = {
    "closed_form": "dop853 on the closed form, compiled in Python",
    "taylor": "Taylor series of the closed form, compiled by heyoka",
    "compiled": "dop853 on the equations derived in-house, both compiled in C",
}
"""Methods on the equations derived in-house."""

SMALL = 3
"""With more velocities than this the closed form in Python is no faster than the reference."""

STEPS = 1200
"""Steps after which to see whether compiling pays; by then dop853 knows if equations are stiff."""

PAYOFF = 3.0
"""Compiling must save this many times what it costs, by an estimate."""

LOOP_STEPS = 5
"""Steps of a closed mechanism after which to see whether its equations are to be derived."""

CHAIN_STEPS = 8
"""So many times more steps does a chain take than its first ones suggest, past flat positions: 94
instead of 11 in a second of 40 falling parallelograms."""

PAYOFF_OF_LOOPS = 1.5
"""Deriving the equations must save this many times what it costs, by an estimate."""


MANY_STEPS = 10_000
"""So many steps of a tight tolerance are taken to a smaller one, because their errors add up."""

LONG_ENOUGH = "a motion long enough to pay for compiling"
"""Why equations are compiled."""

VERY_MANY_STEPS = 200_000
"""With more steps of dop853, optimizing the code of Taylor series, which take fewer, pays."""

FREE_STEPS, FREE_STEPS_ON_LOOPS = 300, 10_000
"""So many steps may err by their tolerance each, one way, before their sum counts."""


@final
@dataclass(frozen=True)
class Choice:
    """A method and the equations it integrates."""

    # of `METHODS`, or "taylor" or "compiled", which integrate what is compiled for the mechanism
    method: str
    # the right-hand side, which may overwrite its last answer; None for "taylor" and "compiled"
    equations: RightHandSide | None
    closed_form: bool = False
    share: float = 1.0  # part of the tolerance that a step may use
    reason: str = ""
    automatic: bool = False  # whether "auto" may change the method
    compiles: bool = False  # whether it may also compile; not any more once that failed
    # whether compiled code is optimized; None where that may change on the way
    optimized: bool | None = None

    @property
    def title(self) -> str:
        """The method and the reason for it, in words."""
        if self.equations is None:
            text = f"{self.method} ({COMPILED[self.method]})"
        elif isinstance(self.equations, ClosedProgram):
            text = f"{self.method} ({METHODS[self.method].title}) on the equations derived in-house"
        else:
            source = " on the closed form" if self.closed_form else ""
            text = f"{self.method} ({METHODS[self.method].title}){source}"
        return f"{text}; chosen for {self.reason}" if self.reason else text


def method_in(title: str) -> str:
    """Return the method that a choice's title names."""
    method = title.split()[0]
    derived = " on the closed form", " on the equations derived in-house"
    return "closed_form" if method == "dop853" and any(map(title.__contains__, derived)) else method


def first_choice(problem: Problem, method: str) -> Choice:
    """Return the choice to start with."""
    code, reference = problem.code, problem.reference
    if problem.corners is not None:
        chosen = "dop853" if method == "auto" else method
        reason = "motions with corners" if method == "auto" else ""
        return Choice(chosen, problem.corners.rhs, reason=reason)
    blind = {"taylor": problem.events, "compiled": problem.asked}.get(method, ())
    if blind:
        names = ", ".join(repr(event.name) for event in blind)
        raise InputError(
            f"method {method!r} watches for no events, got {names}; expected another method: "
            "'closed_form', or 'auto', which takes one that does"
        )
    if method == "compiled":
        code.stepper(reference)
        return Choice("compiled", None)
    if method == "taylor":
        if problem.loops is not None:
            raise DerivationError(
                f"mechanism {problem.mechanism.name!r} has constraints, which Taylor series do not "
                "keep; expected another method: 'compiled', 'closed_form' or 'auto'"
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
        compiles=code.possible,
    )


def next_choice(problem: Problem, choice: Choice, integration: Integration) -> Choice | None:
    """Return the choice for another integration; None if this one stands."""
    kind = integration.outcome.kind
    if kind == "stiff" and choice.automatic and choice.method in ("dop853", "compiled"):
        reason = f"stiff equations, found by dop853 at t = {integration.t:.4g} s"
        equations = choice.equations or problem.reference.rhs(overwriting=True)
        return replace(choice, method="radau", equations=equations, reason=reason)
    if kind == "reconsider":
        for change in _list_changes(problem, choice, integration.steps, integration.t):
            try:
                choice = change(choice)
            except (DerivationError, InputError):
                choice = replace(choice, compiles=False)
        return choice
    return None


def may_change(problem: Problem, choice: Choice) -> bool:
    """Return whether another choice may pay after a while."""
    return _can_tighten(problem, choice) or _can_compile(problem, choice)


def worth_reconsidering(problem: Problem, choice: Choice, steps: int, t: float) -> bool:
    """Return whether another choice pays, as the first `STEPS` steps suggest.

    It looks at no clock, and at nothing that ran before, so that the same call always gives the
    same motion.
    """
    at_loops = problem.loops is not None and steps == LOOP_STEPS
    if not at_loops and (steps < STEPS or (steps > STEPS and choice.method == "dop853")):
        return False
    return bool(_list_changes(problem, choice, steps, t))


_Change = Callable[[Choice], Choice]
"""Returns a better choice; raises if the equations do not allow it."""


def _list_changes(problem: Problem, choice: Choice, taken: int, t: float) -> list[_Change]:
    """Return what makes a choice better after some steps: tighter steps, compiled equations."""
    compiles = _can_compile(problem, choice) and problem.code.possible
    if problem.loops is not None and taken == LOOP_STEPS:
        pays = compiles and _best_for_loops(problem, t) != "dop853"
        return [partial(_with_program, problem, t)] if pays else []
    changes: list[_Change] = []
    steps = taken * (problem.end - problem.t0) / (t - problem.t0)
    if _can_tighten(problem, choice) and steps > MANY_STEPS:
        free = FREE_STEPS if problem.loops is None else FREE_STEPS_ON_LOOPS
        share = max(free / steps, LEAST_RTOL / step_accuracy(problem)[0])
        changes.append(lambda choice: replace(choice, share=share))
    if problem.loops is not None or not compiles:
        return changes
    m = problem.mechanism
    left = (STEPS * steps / taken - STEPS) * costs.estimate_step(m)
    series = not (problem.events or _is_blind(problem)) and is_installed()
    if series and left > PAYOFF * costs.estimate_deriving_series(m):
        changes.append(partial(_with_series, problem, steps > VERY_MANY_STEPS))
    elif m.nv <= SMALL and not choice.closed_form and left > PAYOFF * costs.estimate_deriving(m):
        rhs = problem.code.rhs
        changes.append(lambda was: replace(was, equations=rhs(problem.reference), closed_form=True))
    return changes


def _best_for_loops(problem: Problem, t: float, operations: int | None = None) -> str:
    """Return the method expected to finish first, by what compiling and steps cost."""
    code = problem.code
    if not code.possible:
        return "dop853"
    steps, nv = LOOP_STEPS * (problem.end - problem.t0) / (t - problem.t0), problem.mechanism.nv
    by_reference = costs.LOOP_STEP["dop853"] * nv
    by_program = costs.LOOP_STEP["closed_form"] * nv**2
    if code.chain:
        by_program = costs.CHAIN_STEP * nv
        by_reference *= CHAIN_STEPS
    deriving = costs.estimate_deriving(problem.mechanism) if operations is None else 0.0
    work = {
        "dop853": (steps - LOOP_STEPS) * by_reference / PAYOFF_OF_LOOPS,
        "closed_form": deriving + steps * by_program,
    }
    if has_compiler() and not problem.asked and not _is_blind(problem):
        if code.chain:
            del work["closed_form"]  # only compiled steps leap across singular positions
        compiling = deriving + costs.estimate_compiling(problem.mechanism, operations)
        work["compiled"] = compiling + steps * costs.LOOP_STEP["compiled"]
    return min(work, key=lambda method: work[method])


def _with_program(problem: Problem, t: float, choice: Choice) -> Choice:
    """Change to the equations derived in-house, in Python or C, if there are any and they pay."""
    code, reference = problem.code, problem.reference
    choice = replace(choice, compiles=False)
    method = _best_for_loops(problem, t, code.program(reference).length)
    if method == "dop853":
        return choice
    if method == "closed_form":
        return replace(choice, equations=code.rhs(reference), closed_form=True)
    code.stepper(reference)
    return replace(choice, method="compiled", equations=None, reason=LONG_ENOUGH)


def _with_series(problem: Problem, optimized: bool, choice: Choice) -> Choice:
    """Change to Taylor series, if the equations have them.

    Where steps are tightened they are to the least tolerance: it takes next to no more of them.
    """
    if choice.share < 1.0:
        choice = replace(choice, share=LEAST_RTOL / problem.rtol)
    tolerance = choice.share * problem.rtol
    problem.code.build_integrator(problem.reference, tolerance, optimized=optimized)
    return replace(choice, method="taylor", equations=None, reason=LONG_ENOUGH, optimized=optimized)


def _is_blind(problem: Problem) -> bool:
    return any(callable(signal.signal) for signal in problem.mechanism.inputs)


def _can_tighten(problem: Problem, choice: Choice) -> bool:
    explicit = choice.method in ("dop853", "compiled")
    return explicit and choice.share == 1.0 and LEAST_RTOL < problem.rtol <= TIGHT_RTOL


def _can_compile(problem: Problem, choice: Choice) -> bool:
    fresh = problem.loops is None or not choice.closed_form
    return choice.method == "dop853" and choice.compiles and fresh
