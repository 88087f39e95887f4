"""Differentiate the equations of motion at a state, by differences of the reference's answers."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import Any, final

import numpy as np

from mecanique.errors import InputError
from mecanique.model.expression import finite, symbols_in
from mecanique.model.mechanism import Mechanism
from mecanique.model.parameters import Input
from mecanique.motion.dense import State
from mecanique.motion.linearization import Linearization
from mecanique.motion.rates import Rates
from mecanique.motion.settings import Values

__all__ = ["linearize", "undisturbed"]

STEPS = (0.02, 0.004, 0.0008, 0.00016)
"""Steps of the differences, in the unit of each coordinate: the next is tried where one is not accurate."""

ACCURATE = 1e-11
"""Relative error that is good enough."""

WEIGHTS = np.array([4 / 5, -1 / 5, 4 / 105, -1 / 280])
"""Central differences of eighth order: weights of f(x + k h) − f(x − k h), k = 1…4 (Fornberg, 1988)."""

RESTS = 1e-6
"""Largest acceleration of a closed mechanism that counts as rest."""


def linearize(
    mechanism: Mechanism,
    at: Values | State | None = None,
    *,
    near: Values | None = None,
    v: Values | None = None,
    t: float = 0.0,
    reference: Any = None,
) -> Linearization:
    """Linearize the equations of motion about a state.

    M a + bias − forces is differentiated by central differences of eighth order; `error` says how well that worked.
    About a state in motion the accelerations are held at the state's own. A mechanism with loops is linearized in
    independent deviations, about an equilibrium.

    Args:
        mechanism: what moves.
        at: positions, shape (nq,) or by name, or a `State` with time and velocities; by default an equilibrium.
        near: from where the equilibrium is looked for, shape (nq,) or by name; by default from the neutral position.
            Inputs that change with time are then zero.
        v: velocities, shape (nv,) or by name; zero by default.
        t: time [s].
        reference: the mechanism's `Reference`, if it is there already.

    Raises:
        InputError: if the state is not what is expected, or no equilibrium is found.
        UnknownNameError: if a coordinate or velocity does not exist.
    """
    t = finite(t, "the time t")
    described = mechanism
    if at is not None and near is not None:
        raise InputError("expected either at or near, got both")
    if at is None:
        mechanism = undisturbed(mechanism)
        reference = reference if mechanism is described else None
    if reference is None:
        from mecanique.reference import Reference

        reference = Reference(mechanism)
    if isinstance(at, State):
        t, v, at = float(at.t), at.v, at.q
    if at is None:
        from mecanique.motion.equilibrium import equilibrium_near

        at = equilibrium_near(mechanism, mechanism.position(near), t, reference)
        if at is None:
            start = "the neutral position" if near is None else "there"
            raise InputError(
                f"no equilibrium of {mechanism.name!r} was found from {start}; give one: "
                "linearize(mechanism, at={...}), or look for all with equilibria(mechanism)"
            )
    position, velocity = mechanism.position(at), mechanism.velocity(v)
    rates = Rates.of(mechanism)
    acceleration = reference.acceleration(position, velocity, t)
    held = Held(reference, position, t) if mechanism.loops else None
    if held is not None and (velocity.any() or np.abs(acceleration).max(initial=0.0) > RESTS):
        raise InputError(
            f"expected an equilibrium of {mechanism.name!r}, which has loops, got a state in motion; "
            "look for one with equilibria(mechanism)"
        )
    tangent = np.eye(mechanism.nv) if held is None else held.tangent

    def by_position(step: np.ndarray) -> np.ndarray:
        q = rates.moved(np.repeat(position[None], len(step), axis=0), step @ tangent.T)
        many = np.repeat(velocity[None], len(step), axis=0)
        residual: np.ndarray = reference.inverse_dynamics(q, many, np.repeat(acceleration[None], len(step), axis=0), t)
        along: np.ndarray = (residual if held is None else held.without_loops(residual, q)) @ tangent
        return along

    def by_velocity(step: np.ndarray) -> np.ndarray:
        many = np.repeat(position[None], len(step), axis=0)
        a = np.repeat(acceleration[None], len(step), axis=0)
        along: np.ndarray = reference.inverse_dynamics(many, velocity + step @ tangent.T, a, t) @ tangent
        return along

    K, error_k = _slopes(by_position, tangent.shape[1])
    C, error_c = _slopes(by_velocity, tangent.shape[1])
    M = tangent.T @ reference.mass_matrix(position, t) @ tangent
    # what differs from symmetry by no more than the differences' error is symmetric
    if np.abs(K - K.T).max(initial=0.0) <= 1e-11 * np.abs(K).max(initial=0.0):
        K = (K + K.T) / 2
    error = max(error_k, error_c)
    return Linearization(described, position, velocity, t, M, C, K, error, acceleration, tangent)


@final
class Held:
    """The loops of a mechanism at an equilibrium: which deviations they leave free, and their forces.

    Args:
        reference: the mechanism's `Reference`.
        q: shape (nq,), where the loops are closed.
        t: time [s].
    """

    def __init__(self, reference: Any, q: np.ndarray, t: float) -> None:
        from scipy.linalg import qr

        from mecanique.reference.nullspace import split

        self._closures, self._t = reference.closed.closures, t
        still = np.zeros(reference.mechanism.nv)
        jacobian = self._jacobian(q)
        columns = self._closures.columns
        free = columns[:, None] * split(self._closures.rows[:, None] * jacobian * columns).null
        # the velocities that move the others best are the independent ones; in their order
        _, _, order = qr((free / columns[:, None]).T, pivoting=True)
        chosen = np.sort(order[: free.shape[1]])
        self.tangent: np.ndarray = free @ np.linalg.inv(free[chosen])
        """Deviations of all coordinates by the independent ones, shape (nv, n)."""
        residual = reference.inverse_dynamics(q, still, still, t)
        self._multipliers = np.linalg.lstsq(jacobian.T, residual, rcond=1e-10)[0]

    def without_loops(self, residual: np.ndarray, q: np.ndarray) -> np.ndarray:
        """Return generalized forces less those of the loops at the equilibrium.

        Args:
            residual: shape (n, nv).
            q: shape (n, nq).
        """
        loops = np.array([self._jacobian(one).T @ self._multipliers for one in q])
        less: np.ndarray = residual - loops
        return less

    def _jacobian(self, q: np.ndarray) -> np.ndarray:
        still = np.zeros(len(self._closures.columns))
        jacobian: np.ndarray = np.array(self._closures.at(q, still, self._t).jacobian)
        return jacobian


def _changes(signal: Input) -> bool:
    return callable(signal.signal) or "t" in symbols_in(signal.signal)


def undisturbed(mechanism: Mechanism) -> Mechanism:
    """Return a mechanism with all inputs zero that change with time.

    Args:
        mechanism: what moves.
    """
    if not any(_changes(signal) for signal in mechanism.inputs):
        return mechanism
    inputs = tuple(replace(signal, signal=0.0) if _changes(signal) else signal for signal in mechanism.inputs)
    return replace(mechanism, inputs=inputs)


def _slopes(function: Callable[[np.ndarray], np.ndarray], count: int) -> tuple[np.ndarray, float]:
    """Return ∂f/∂x as a matrix, and its error relative to its largest entry."""
    if not count:
        return np.zeros((0, 0)), 0.0
    best, error = np.zeros((count, count)), np.inf
    for h in STEPS:
        fine, coarse = _differences(function, count, h), _differences(function, count, 2 * h)
        scale = float(np.abs(fine).max())
        found = float(np.abs(fine - coarse).max()) / scale if scale > 0 else 0.0
        if found < error:
            best, error = fine, found
        if error < ACCURATE:
            break
    return best, error


def _differences(function: Callable[[np.ndarray], np.ndarray], count: int, h: float) -> np.ndarray:
    k = np.arange(1, 5) * h
    ahead = (np.eye(count)[:, None, :] * k[None, :, None]).reshape(-1, count)
    rise = (function(ahead) - function(-ahead)).reshape(count, 4, -1)
    slopes: np.ndarray = np.einsum("k,jki->ij", WEIGHTS, rise) / h
    return slopes
