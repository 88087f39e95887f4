"""Differentiate the equations of motion at a state, by differences of the reference's answers."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import Any, TypeAlias, final

import numpy as np

from mecanique.errors import InputError
from mecanique.model.expression import finite, symbols_in
from mecanique.model.mechanism import Mechanism
from mecanique.model.parameters import Input
from mecanique.motion.linear.linearization import Linearization
from mecanique.motion.record.curve import State
from mecanique.motion.record.rates import Rates
from mecanique.motion.simulation.arguments import Values
from mecanique.verification.stencil import differences

__all__ = ["linearize", "undisturbed"]

STEPS = (0.02, 0.004, 0.0008, 0.00016)
"""Steps of the differences, in the unit of each coordinate: the next is tried where one is not accurate."""

ACCURATE = 1e-11
"""Relative error that is good enough."""

SWEEPS = 20
CLOSED = 1e-14
"""Loops this near to closed, in characteristic lengths or radians, are closed."""


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

    M a + bias − forces is differentiated by central differences of eighth order; `error` says how
    well that worked. About a state in motion the accelerations are held at the state's own. A
    mechanism with loops is linearized in independent deviations, about the state on the loops next
    to the one given.

    Args:
        mechanism: what moves.
        at: positions, shape (nq,) or by name, or a `State` with time and velocities; by default an
            equilibrium.
        near: from where the equilibrium is looked for, shape (nq,) or by name; by default from the
            neutral position. Inputs that change with time are then zero.
        v: velocities, shape (nv,) or by name; zero by default.
        t: time [s].
        reference: the mechanism's `Reference`, if it is there already.

    Raises:
        InputError: if the state is not what is expected, or no equilibrium is found.
        UnknownNameError: if a coordinate or velocity does not exist.
        ClosureError: if the loops cannot be closed.
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
        from mecanique.motion.linear.equilibrium import equilibrium_near

        at = equilibrium_near(mechanism, mechanism.position(near), t, reference)
        if at is None:
            start = "the neutral position" if near is None else "there"
            raise InputError(
                f"no equilibrium of {mechanism.name!r} was found from {start}; give one: "
                "linearize(mechanism, at={...}), or look for all with equilibria(mechanism)"
            )
    position, velocity = mechanism.position(at), mechanism.velocity(v)
    if mechanism.loops:
        from mecanique.motion.record.loops import Closing

        state, _ = Closing(mechanism, reference, ACCURATE).start(at, v, t)
        position, velocity = state[: mechanism.nq], state[mechanism.nq :]
    acceleration = reference.acceleration(position, velocity, t)
    held = Held(reference, position, t) if mechanism.loops else None
    tangent = np.eye(mechanism.nv) if held is None else held.tangent
    if held is None:
        by_position, by_velocity = _of_tree(reference, position, velocity, acceleration, t)
    else:
        by_position, by_velocity = _of_loops(held, position, velocity, acceleration)
    K, error_k = _slopes(by_position, tangent.shape[1])
    C, error_c = _slopes(by_velocity, tangent.shape[1])
    M = tangent.T @ reference.mass_matrix(position, t) @ tangent
    # what differs from symmetry by no more than the differences' error is symmetric
    if np.abs(K - K.T).max(initial=0.0) <= 1e-11 * np.abs(K).max(initial=0.0):
        K = (K + K.T) / 2
    error = max(error_k, error_c)
    return Linearization(described, position, velocity, t, M, C, K, error, acceleration, tangent)


_Function: TypeAlias = Callable[[np.ndarray], np.ndarray]
"""Residuals at many deviations, shape (m, n) both."""


def _of_tree(
    reference: Any, position: np.ndarray, velocity: np.ndarray, acceleration: np.ndarray, t: float
) -> tuple[_Function, _Function]:
    """M a + bias − forces by deviations of the position, and of the velocities."""
    rates = Rates.of(reference.mechanism)

    def by_position(step: np.ndarray) -> np.ndarray:
        q = rates.moved(np.repeat(position[None], len(step), axis=0), step)
        same = [np.repeat(x[None], len(step), axis=0) for x in (velocity, acceleration)]
        residual: np.ndarray = reference.inverse_dynamics(q, *same, t)
        return residual

    def by_velocity(step: np.ndarray) -> np.ndarray:
        q, a = (np.repeat(x[None], len(step), axis=0) for x in (position, acceleration))
        residual: np.ndarray = reference.inverse_dynamics(q, velocity + step, a, t)
        return residual

    return by_position, by_velocity


def _of_loops(
    held: Held, position: np.ndarray, velocity: np.ndarray, acceleration: np.ndarray
) -> tuple[_Function, _Function]:
    """The same on the loops, in the independent coordinates."""
    w, rate = velocity[held.chosen], acceleration[held.chosen]

    def by_position(step: np.ndarray) -> np.ndarray:
        return np.array([held.residual(held.near(one), w, rate) for one in step])

    def by_velocity(step: np.ndarray) -> np.ndarray:
        return np.array([held.residual(position, w + one, rate) for one in step])

    return by_position, by_velocity


@final
class Held:
    """The motions that loops leave free near a position, by independent velocities w: v = T w + b.

    Args:
        reference: the mechanism's `Reference`.
        q: shape (nq,), where the loops are closed.
        t: time [s].
    """

    def __init__(self, reference: Any, q: np.ndarray, t: float) -> None:
        from scipy.linalg import qr

        from mecanique.reference.loops.nullspace import split

        self._reference, self._q, self._t = reference, q, t
        self._rates = Rates.of(reference.mechanism)
        self._closures = reference.closed.closures
        columns = self._closures.columns
        jacobian = self._at(q, np.zeros(len(columns))).jacobian
        free = columns[:, None] * split(self._closures.rows[:, None] * jacobian * columns).null
        # the velocities that move the others best are the independent ones; in their order
        _, _, order = qr((free / columns[:, None]).T, pivoting=True)
        self.chosen: np.ndarray = np.sort(order[: free.shape[1]])
        """Which velocities are independent, shape (n,)."""
        self.tangent: np.ndarray = free @ np.linalg.inv(free[self.chosen])
        """T, deviations of all coordinates by the independent ones, shape (nv, n)."""

    def near(self, step: np.ndarray) -> np.ndarray:
        """Return the position on the loops that lies a step of the independent coordinates away, shape (nq,).

        Args:
            step: shape (n,).

        Raises:
            InputError: if the loops cannot be closed there.
        """
        still = np.zeros(len(self.tangent))
        q: np.ndarray = self._rates.moved(self._q[None], (self.tangent @ step)[None])[0]
        for _ in range(SWEEPS):
            closure = self._at(q, still)
            off = self._closures.rows * closure.residual
            if float(np.abs(off).max(initial=0.0)) < CLOSED:
                return q
            q = self._rates.moved(q[None], -self._others(closure.jacobian, off)[None])[0]
        raise InputError(
            f"the loops of {self._reference.mechanism.name!r} cannot be closed near this state, which is next to a "
            "singular position; linearize about another one"
        )

    def residual(self, q: np.ndarray, w: np.ndarray, rate: np.ndarray) -> np.ndarray:
        """Return Tᵀ (M a + bias − forces) of the motion on the loops with these independent velocities, shape (n,).

        Args:
            q: shape (nq,), on the loops.
            w: shape (n,).
            rate: shape (n,), of w.
        """
        v = self._whole(q, w, lambda closure: closure.drift)
        a = self._whole(q, rate, lambda closure: closure.gamma, v)
        T = np.stack(
            [self._whole(q, one, lambda closure: 0 * closure.drift) for one in np.eye(len(w))],
            axis=1,
        )
        effort: np.ndarray = T.T @ self._reference.inverse_dynamics(q, v, a, self._t)
        return effort

    def _whole(
        self,
        q: np.ndarray,
        free: np.ndarray,
        rest: Callable[[Any], np.ndarray],
        v: np.ndarray | None = None,
    ) -> np.ndarray:
        """All components x of which some are given, with J x + rest = 0."""
        x = np.zeros(len(self.tangent))
        x[self.chosen] = free
        closure = self._at(q, x if v is None else v)
        x -= self._others(
            closure.jacobian, self._closures.rows * (closure.jacobian @ x + rest(closure))
        )
        return x

    def _others(self, jacobian: np.ndarray, off: np.ndarray) -> np.ndarray:
        """The least deviations of all but the independent coordinates that make up for what loops are off."""
        columns = self._closures.columns.copy()
        columns[self.chosen] = 0.0
        J = self._closures.rows[:, None] * jacobian * columns
        deviations: np.ndarray = columns * np.linalg.lstsq(J, off, rcond=1e-9)[0]
        return deviations

    def _at(self, q: np.ndarray, v: np.ndarray) -> Any:
        return self._closures.at(q, v, self._t)


def _changes(signal: Input) -> bool:
    return callable(signal.signal) or "t" in symbols_in(signal.signal)


def undisturbed(mechanism: Mechanism) -> Mechanism:
    """Return a mechanism with all inputs zero that change with time.

    Args:
        mechanism: what moves.
    """
    if not any(_changes(signal) for signal in mechanism.inputs):
        return mechanism
    inputs = tuple(
        replace(signal, signal=0.0) if _changes(signal) else signal for signal in mechanism.inputs
    )
    return replace(mechanism, inputs=inputs)


def _slopes(function: _Function, count: int) -> tuple[np.ndarray, float]:
    """Return ∂f/∂x as a matrix, and its error relative to its largest entry."""
    if not count:
        return np.zeros((0, 0)), 0.0
    best, error = np.zeros((count, count)), np.inf
    for h in STEPS:
        fine, coarse = differences(function, count, h), differences(function, count, 2 * h)
        scale = float(np.abs(fine).max())
        found = float(np.abs(fine - coarse).max()) / scale if scale > 0 else 0.0
        if found < error:
            best, error = fine, found
        if error < ACCURATE:
            break
    return best, error
