"""Differentiate the equations of motion about a state, by differences of a reference's answers."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, TypeAlias

import numpy as np

from mecanique.arrays import rank_of
from mecanique.errors import ClosureError, InputError
from mecanique.model.mechanism import Mechanism
from mecanique.model.states import list_left_out
from mecanique.motion.linear.free_motions import FreeMotion, effort, free_near
from mecanique.motion.linear.held import HeldMode
from mecanique.motion.linear.linearization import Linearization
from mecanique.motion.record.loops import begin_on_loops
from mecanique.motion.simulation.problem import Values
from mecanique.motion.tolerances import DIFFERENCES, UNRESISTED
from mecanique.verification.stencil import differences_twice

if TYPE_CHECKING:
    from mecanique.reference import Reference


STEPS = (0.02, 0.004, 0.0008, 0.00016)
"""Steps of the differences, in the unit of each coordinate, tried until one is accurate."""


def linearize_about(
    reference: Reference | HeldMode,
    at: Values,
    v: Values | None = None,
    t: float = 0.0,
    *,
    described: Mechanism | None = None,
    chosen: str = "",
) -> Linearization:
    """Linearize the equations of motion about a state, with loops closed next to it."""
    mechanism = reference.mechanism
    if isinstance(reference, HeldMode):
        position, velocity = mechanism.position(at), mechanism.velocity(v)
    else:
        reference, state, _ = begin_on_loops(reference, at, v, t)
        position, velocity = state[: mechanism.nq], state[mechanism.nq :]
    acceleration = reference.acceleration(position, velocity, t)
    free = free_near(reference, position, t)
    tangent, w, rate = free.tangent, velocity[free.chosen], acceleration[free.chosen]
    by_position = _along(reference, free, free, w, rate, t)

    def by_velocity(step: np.ndarray) -> np.ndarray:
        return np.array([effort(reference, free, position, w + x, rate, t) for x in step])

    K, error_k = slopes(by_position, tangent.shape[1])
    C, error_c = slopes(by_velocity, tangent.shape[1])
    if isinstance(reference, HeldMode):
        K, C = (reference.drop_rounding(slope, tangent, position, t) for slope in (K, C))
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
    reference: Reference | HeldMode,
    at: Values,
    v: Values | None,
    position: np.ndarray,
    velocity: np.ndarray,
) -> str:
    closed = None if isinstance(reference, HeldMode) else reference.closed
    rank = None if closed is None else closed.most
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


def _along(
    reference: Reference | HeldMode,
    places: FreeMotion,
    free: FreeMotion,
    w: np.ndarray,
    rate: np.ndarray,
    t: float,
) -> _Function:
    """Return M a + bias − forces by deviations of the position, along what is free."""
    return lambda step: np.array(
        [effort(reference, free, _near(places, x), w, rate, t) for x in step]
    )


def find_idle(reference: Reference | HeldMode, q: np.ndarray, t: float) -> np.ndarray:
    """Return the displacements that nothing resists at rest, as orthonormal columns (nv, k).

    What rolls may be put where it cannot roll to straight away.
    """
    free, holonomic = free_near(reference, q, t), free_near(reference, q, t, positional=True)
    places, none = holonomic.tangent, np.zeros(len(free.chosen))
    if not places.shape[1]:
        return places
    by_position = _along(reference, holonomic, free, none, none, t)
    K, _ = slopes(by_position, places.shape[1])
    _, sizes, directions = np.linalg.svd(K)
    resisted = rank_of(sizes, UNRESISTED)
    idle: np.ndarray = np.linalg.qr(places @ directions[resisted:].T)[0]
    return idle


def _near(free: FreeMotion, step: np.ndarray) -> np.ndarray:
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
        try:
            fine, coarse = differences_twice(function, count, h)
        except InputError:
            if h == STEPS[-1]:
                raise
            continue  # the loops do not reach so far
        scale = float(np.abs(fine).max())
        gap = float(np.abs(fine - coarse).max()) / scale if scale > 0 else 0.0
        if gap < error:
            best, error = fine, gap
        if error < DIFFERENCES:
            break
    return best, error
