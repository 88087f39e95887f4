"""Differentiate the equations of motion about a state, by differences of a reference's answers."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, TypeAlias

import numpy as np

from mecanique.errors import ClosureError, InputError
from mecanique.model.mechanism import Mechanism
from mecanique.model.states import list_left_out
from mecanique.motion.linear.equilibrium import effort
from mecanique.motion.linear.linearization import Linearization
from mecanique.motion.record.rates import Rates
from mecanique.motion.simulation.problem import Values
from mecanique.motion.tolerances import DIFFERENCES
from mecanique.verification.stencil import differences_twice

if TYPE_CHECKING:
    from mecanique.reference import Reference
    from mecanique.reference.loops.independent import Independent


STEPS = (0.02, 0.004, 0.0008, 0.00016)
"""Steps of the differences, in the unit of each coordinate, tried until one is accurate."""


def linearize_about(
    reference: Reference,
    at: Values,
    v: Values | None = None,
    t: float = 0.0,
    *,
    described: Mechanism | None = None,
    chosen: str = "",
) -> Linearization:
    """Linearize the equations of motion about a state, with loops closed next to it."""
    mechanism = reference.mechanism
    refuse_rolling(mechanism)
    position, velocity = mechanism.position(at), mechanism.velocity(v)
    if mechanism.constrained:
        from mecanique.motion.record.loops import begin_on_loops

        reference, state, _ = begin_on_loops(reference, at, v, t)
        position, velocity = state[: mechanism.nq], state[mechanism.nq :]
    acceleration = reference.acceleration(position, velocity, t)
    tangent = np.eye(mechanism.nv)
    if reference.closed is None:
        by_position, by_velocity = _of_tree(reference, position, velocity, acceleration, t)
    else:
        from mecanique.reference.loops.independent import Independent

        free = Independent(reference.closed, position, t)
        tangent = free.tangent
        by_position, by_velocity = _of_loops(reference, free, position, velocity, acceleration, t)
    K, error_k = slopes(by_position, tangent.shape[1])
    C, error_c = slopes(by_velocity, tangent.shape[1])
    M = tangent.T @ reference.mass_matrix(position, t) @ tangent
    # what differs from symmetry by no more than the differences' error is symmetric
    if np.abs(K - K.T).max(initial=0.0) <= DIFFERENCES * np.abs(K).max(initial=0.0):
        K = (K + K.T) / 2
    return Linearization(
        described or mechanism,
        position,
        velocity,
        t,
        M=M,
        C=C,
        K=K,
        error=max(error_k, error_c),
        acceleration=acceleration,
        tangent=tangent,
        chosen=chosen or _explain_left_out(reference, at, v, position, velocity),
    )


def _explain_left_out(
    reference: Reference, at: Values, v: Values | None, position: np.ndarray, velocity: np.ndarray
) -> str:
    rank = None if reference.closed is None else reference.closed.most
    start = np.concatenate([position, velocity])
    said = list_left_out(reference.mechanism, at, v, start, rank)
    return f"about the state given{said}" if said else ""


def refuse_rolling(mechanism: Mechanism) -> None:
    """Raise if a mechanism rolls or has velocity constraints."""
    if mechanism.rolls:
        raise InputError(
            f"mechanism {mechanism.name!r} rolls or has velocity constraints: its linear "
            "equations are of first order; use linearize_steady(mechanism, at={...}, v={...}), or "
            "`mecanique steady`"
        )


_Function: TypeAlias = Callable[[np.ndarray], np.ndarray]
"""Residuals at many deviations, shape (m, n) both."""


def _of_tree(
    reference: Reference,
    position: np.ndarray,
    velocity: np.ndarray,
    acceleration: np.ndarray,
    t: float,
) -> tuple[_Function, _Function]:
    """Return M a + bias − forces by deviations of the position, and of the velocities."""
    rates = Rates.of(reference.mechanism)

    def by_position(step: np.ndarray) -> np.ndarray:
        q = rates.displace(np.repeat(position[None], len(step), axis=0), step)
        v, a = (np.repeat(x[None], len(step), axis=0) for x in (velocity, acceleration))
        residual: np.ndarray = reference.inverse_dynamics(q, v, a, t)
        return residual

    def by_velocity(step: np.ndarray) -> np.ndarray:
        q, a = (np.repeat(x[None], len(step), axis=0) for x in (position, acceleration))
        residual: np.ndarray = reference.inverse_dynamics(q, velocity + step, a, t)
        return residual

    return by_position, by_velocity


def _of_loops(
    reference: Reference,
    free: Independent,
    position: np.ndarray,
    velocity: np.ndarray,
    acceleration: np.ndarray,
    t: float,
) -> tuple[_Function, _Function]:
    """Return the same on the loops, in the independent coordinates."""
    w, rate = velocity[free.chosen], acceleration[free.chosen]

    def by_position(step: np.ndarray) -> np.ndarray:
        return np.array([effort(reference, free, _near(free, x), w, rate, t) for x in step])

    def by_velocity(step: np.ndarray) -> np.ndarray:
        return np.array([effort(reference, free, position, w + x, rate, t) for x in step])

    return by_position, by_velocity


def _near(free: Independent, step: np.ndarray) -> np.ndarray:
    try:
        return free.position(step)
    except ClosureError as error:
        raise InputError(
            "the loops cannot be closed near this state, which is next to a singular position; "
            f"linearize about another one: {error}"
        ) from error


def slopes(function: _Function, count: int) -> tuple[np.ndarray, float]:
    """Return ∂f/∂x as a matrix, and its error relative to its largest entry."""
    if not count:
        return np.zeros((0, 0)), 0.0
    best, error = np.zeros((count, count)), np.inf
    for h in STEPS:
        fine, coarse = differences_twice(function, count, h)
        scale = float(np.abs(fine).max())
        gap = float(np.abs(fine - coarse).max()) / scale if scale > 0 else 0.0
        if gap < error:
            best, error = fine, gap
        if error < DIFFERENCES:
            break
    return best, error
