"""Differentiate Pinocchio's values by finite differences."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np

from mecanique.generation.program import Program
from mecanique.generation.quantities import Quantity
from mecanique.generation.verdict.answers import answer_of
from mecanique.model.states import States, seated_velocities
from mecanique.reference import Reference
from mecanique.verification.stencil import WEIGHTS

TOLERANCE = 1e-6
"""Largest relative difference that counts as agreement, given the error of this method."""

_STEP = 1e-3
"""Step along a coordinate or a velocity, and relative step of a torque or a parameter."""


def differences(
    quantity: Quantity, program: Program, reference: Reference, states: States, tau: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Return derivatives, shape (n, …, directions), and which directions are compared, 1 or 0.

    Derivatives by signals are not compared, as they are not inputs of Pinocchio, nor those of
    reactions by tau that acts in no joint with one coordinate, which the reference refuses.

    Args:
        quantity: a derivative.
        program: the program with the parameters.
        reference: the mechanism inside Pinocchio.
        states: coordinates, velocities and times.
        tau: torques, shape (n, nv).
    """
    columns: list[np.ndarray] = []
    compared: list[float] = []
    for move, scale in _list_moves(quantity, program, reference, states, tau):
        size = _STEP * scale
        total = 0.0 * answer_of(quantity.base, *move(0.0))
        for k, weight in enumerate(WEIGHTS if scale else (), 1):
            ahead, behind = (answer_of(quantity.base, *move(sign * k * size)) for sign in (1, -1))
            total = total + weight * (ahead - behind) / size
        columns.append(total)
        compared.append(float(scale > 0))
    return np.stack(columns, axis=-1), np.array(compared)


_Move = Callable[[float], tuple[Reference, States, np.ndarray]]


def _list_moves(
    quantity: Quantity, program: Program, reference: Reference, states: States, tau: np.ndarray
) -> list[tuple[_Move, float]]:
    """Return the displacement along each direction, with its scale; zero if it is not compared."""
    nv, mechanism = reference.mechanism.nv, reference.mechanism
    unit = np.eye(nv)

    def along_q(k: int) -> _Move:
        rates = np.asarray(reference.rates(states.q, np.broadcast_to(unit[k], states.v.shape)))

        def move(step: float) -> tuple[Reference, States, np.ndarray]:
            q = states.q + step * rates
            mechanism.normalize(q)
            return reference, replace(states, q=q), tau

        return move

    def along_v(k: int) -> _Move:
        return lambda step: (reference, replace(states, v=states.v + step * unit[k]), tau)

    def along_a(k: int) -> _Move:
        return lambda step: (reference, replace(states, a=states.a + step * unit[k]), tau)

    def along_tau(k: int) -> _Move:
        return lambda step: (reference, states, tau + step * unit[k])

    def along_p(symbol: str) -> _Move:
        def move(step: float) -> tuple[Reference, States, np.ndarray]:
            if not step:
                return reference, states, tau
            other = mechanism.replace(**{symbol: mechanism.values[symbol] + step})
            return Reference(other), replace(states, mechanism=other), tau

        return move

    if quantity.by == "p":
        values = [(p.name, mechanism.values.get(p.name, 0.0)) for p in program.parameters]
        signals = [p.name for p in program.parameters if p.name not in mechanism.values]
        return [
            (along_p(name), 0.0 if name in signals else abs(value) or 1.0) for name, value in values
        ]
    if quantity.by == "tau":
        placed = [
            quantity.base != "reactions" or name in seated_velocities(mechanism)
            for name in mechanism.velocities
        ]
        return [(along_tau(k), float(known)) for k, known in enumerate(placed)]
    kinds = {"y": (along_q, along_v), "q": (along_q,), "v": (along_v,), "a": (along_a,)}
    return [(along(k), 1.0) for along in kinds[quantity.by] for k in range(nv)]
