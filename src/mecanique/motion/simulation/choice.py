"""Which equations and which method a motion is integrated with, and why."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from time import perf_counter
from typing import Any, final

import numpy as np

from mecanique.errors import DerivationError, InputError, IntegrationError
from mecanique.model.mechanism import Mechanism
from mecanique.motion.compile.cache import compiled
from mecanique.motion.compile.heyoka import installed
from mecanique.motion.compile.python import owning
from mecanique.motion.record.events import Event
from mecanique.motion.record.motion import Motion, Statistics
from mecanique.motion.record.steps import RightHandSide
from mecanique.motion.simulation.limits import tell_end
from mecanique.motion.simulation.taylor import flow

__all__ = ["COMPILED", "Plan", "flowed"]

COMPILED = {
    "closed_form": "dop853 on the closed form, compiled in Python",
    "taylor": "Taylor series of the closed form, compiled by heyoka",
}
"""Methods on the equations derived in-house."""

SMALL = 3
"""With more velocities than this the closed form in Python is no faster than the reference."""

STEPS = 1200
"""Steps after which to see whether compiling would pay; by then dop853 knows whether the equations are stiff."""

PAYS = 3.0
"""Compiling must save this many times what it takes, by an estimate."""

TIGHT = 1e-11
"""Whoever asks for this tolerance or a smaller one wants the whole motion that accurate, and not each step alone."""

MANY = 10_000
"""So many steps of a tight tolerance are taken to a smaller one, because their errors add up."""

FEW = 300
"""So many steps may err by the tolerance each, one way, before their sum is looked at."""

LEAST = 1e-14
"""The least tolerance of a step of dop853: below it, rounding decides."""


@final
class Plan:
    """The choice of equations and method, which may change while integrating.

    Args:
        mechanism: what moves.
        reference: its `Reference`.
        method: what was asked for.
        rtol: relative tolerance.
        span: duration [s].
        events: what is watched for.

    Raises:
        InputError: if the method does not allow what is asked for, or is not installed.
        DerivationError: if the method needs a closed form and there is none.
    """

    def __init__(
        self,
        mechanism: Mechanism,
        reference: Any,
        method: str,
        rtol: float,
        span: float,
        events: Sequence[Event],
    ) -> None:
        self.mechanism = mechanism
        self.reference = reference
        self.code = compiled(mechanism)
        self.taylor = False
        self.reason = ""
        self.share = 1.0
        """Part of the tolerance that a step of dop853 may use."""
        self._rtol = rtol
        self._span = span
        self._auto = method == "auto"
        self._flows = not (
            events or mechanism.loops or any(callable(i.signal) for i in mechanism.inputs)
        )
        self._closed: RightHandSide | None = None
        self._own: RightHandSide | None = None
        self._left = 0.0
        self.method = "dop853" if method in ("auto", *COMPILED) else method
        if method == "taylor":
            if events:
                names = ", ".join(repr(event.name) for event in events)
                raise InputError(
                    f"method 'taylor' watches for no events, got {names}; expected another method: 'closed_form', or "
                    "'auto', which takes one that does"
                )
            self.code.give_back(rtol, self.code.borrow(reference, rtol))
            self.taylor = True
        elif method == "closed_form":
            self._close()
        elif self._auto and self.code.possible and not mechanism.loops:
            if self._flows and self.code.has_integrator(rtol):
                self.taylor, self.reason = True, "equations that are compiled already"
            elif self._can_flow and self.code.spent > PAYS * self.code.seconds_to_build():
                self._try(self._flow, "a mechanism that has moved long enough to pay for compiling")
            elif self._can_close and (
                self.code.has_rhs or self.code.spent > PAYS * self.code.seconds_to_derive()
            ):
                self._try(self._close)

    @property
    def rhs(self) -> RightHandSide:
        """The right-hand side to integrate; each answer is an array of its own."""
        return owning(self.quick)

    @property
    def quick(self) -> RightHandSide:
        """The same but faster, because it may overwrite its last answer."""
        if self._closed is not None:
            return self._closed
        if self._own is None:
            self._own = self.reference.rhs(overwriting=True)
        return self._own

    @property
    def source(self) -> str:
        """Whose equations are integrated, for the method's description."""
        return " on the closed form" if self._closed is not None else ""

    def watch(self, begin: float, end: float) -> Callable[[float], bool] | None:
        """Return what says, at the time of each step, whether to start again in another way; None if never.

        It counts steps and looks at no clock, so that the same calls always give the same motions.

        Args:
            begin: start of the motion [s].
            end: its end [s].
        """
        if self.mechanism.loops:
            return None
        faster = self._auto and self.code.possible and (self._can_flow or self._can_close)
        finer = self.share == 1.0 and LEAST < self._rtol <= TIGHT
        if not (faster or finer):
            return None
        count = 0

        def again(t: float) -> bool:
            nonlocal count
            count += 1
            if count != STEPS:
                return False
            steps = STEPS * (end - begin) / (t - begin)
            self._left = (steps - STEPS) * _seconds_per_step(self.mechanism)
            tighten = finer and steps > MANY
            if tighten:
                self.share = max(FEW / steps, LEAST / self._rtol)
            cost = (
                self.code.seconds_to_derive() if self._can_close else self.code.seconds_to_build()
            )
            return tighten or (faster and self._left > PAYS * cost)

        return again

    def change(self) -> None:
        """Compile, if that is faster from now on."""
        if not (self._auto and self.code.possible):
            return
        if self._can_flow and self._left > PAYS * self.code.seconds_to_build():
            self._try(self._flow, "a motion long enough to pay for compiling")
        elif self._can_close and self._left > PAYS * self.code.seconds_to_derive():
            self._try(self._close)

    @property
    def _can_flow(self) -> bool:
        return self._flows and installed()

    @property
    def _can_close(self) -> bool:
        return self.mechanism.nv <= SMALL and self._closed is None

    def spend(self, steps: int) -> None:
        """Note that a motion is done, so that the next ones may be compiled.

        Args:
            steps: how many steps of dop853 it took.
        """
        self.code.spent += steps * _seconds_per_step(self.mechanism)

    def _try(self, make: Callable[[], None], reason: str = "") -> None:
        try:
            make()
            self.reason = reason
        except DerivationError as error:
            self._auto, self.reason = False, str(error)

    def _close(self) -> None:
        self._closed = self.code.rhs(self.reference)

    def _flow(self) -> None:
        self.code.give_back(self._rtol, self.code.borrow(self.reference, self._rtol))
        self.taylor = True


def flowed(
    plan: Plan,
    start: np.ndarray,
    times: np.ndarray,
    span: tuple[float, float],
    tolerances: tuple[float, float],
    longest: float,
    max_steps: int,
    progress: Callable[[float], object] | None,
    begin: float,
) -> Motion:
    """Return the motion by Taylor series.

    Args:
        plan: what was decided.
        start: shape (nq + nv,).
        times: of the samples, shape (n,) [s].
        span: start and end [s].
        tolerances: relative and absolute.
        longest: longest step [s].
        max_steps: most steps.
        progress: called with the fraction done.
        begin: when the work began, on `perf_counter` [s].

    Raises:
        IntegrationError: if the integration stops before its end; it carries the motion until then.
    """
    mechanism, nq = plan.mechanism, plan.mechanism.nq
    found = flow(
        mechanism,
        plan.reference,
        plan.code,
        start,
        times,
        span,
        tolerances[0],
        longest,
        max_steps,
        progress,
    )
    rates = plan.code.rates
    times, states = times[: len(found.states)], found.states
    text = f"taylor ({COMPILED['taylor']})" + (f"; chosen for {plan.reason}" if plan.reason else "")
    statistics = Statistics(found.steps, found.steps, perf_counter() - begin, *tolerances)
    q, v = rates.normalized(states[:, :nq]), states[:, nq:]
    motion = Motion(mechanism, times, q, v, found.curve, text, statistics, (), (), plan.reference)
    if found.trouble:
        advice = {
            "interrupted": ("interrupted", ""),
            "too many steps": (
                f"more than {max_steps} steps",
                "; raise max_steps, shorten the duration or loosen rtol",
            ),
            "collapsed": (
                "the step size collapsed",
                ": a force or the mass matrix becomes singular there",
            ),
            "told to stop": (f"progress raised {found.fault!r}", ""),
        }[found.trouble]
        error = IntegrationError(
            f"{advice[0]} at t = {found.last:.6g} s{advice[1]}; the motion until then is in the error's .motion",
            time=found.last,
            motion=motion,
        )
        error.__cause__ = KeyboardInterrupt() if found.trouble == "interrupted" else found.fault
        raise error
    tell_end(progress, motion)
    return motion


def _seconds_per_step(mechanism: Mechanism) -> float:
    """What a step of dop853 takes on the reference, about [s]."""
    return 12 * (1.5e-6 + 0.5e-6 * mechanism.nv)
