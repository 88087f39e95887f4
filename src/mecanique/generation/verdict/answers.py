"""Compute each quantity by Pinocchio, and the units that make its entries comparable."""

from __future__ import annotations

from typing import Any

import numpy as np

from mecanique.errors import DerivationError, InputError
from mecanique.model.states import States
from mecanique.reference import Reference

ROUNDED = {
    "rhs": "acceleration",
    "mass_matrix": "mass matrix",
    "inverse_dynamics": "inverse dynamics",
    "multipliers": "acceleration",
}
"""The name under which the rounding of a quantity is known, if it is not its own."""


def answer_of(name: str, reference: Reference, states: States, tau: np.ndarray) -> np.ndarray:
    """Compute a quantity by Pinocchio, shape (n, …).

    Args:
        name: name of the quantity.
        reference: the mechanism inside Pinocchio.
        states: coordinates, velocities and times.
        tau: torques, shape (n, nv).

    Raises:
        InputError: if Pinocchio does not provide the quantity.
        DerivationError: if redundant loops leave multipliers undetermined.
    """
    q, v, t = states.q, states.v, states.t
    match name:
        case "rhs":
            rates = np.asarray(reference.rates(q, v))
            return np.hstack([rates, answer_of("acceleration", reference, states, tau)])
        case "acceleration":
            return np.asarray(reference.acceleration(q, v, t, tau=tau))
        case "mass_matrix":
            return np.asarray(reference.mass_matrix(q, t))
        case "bias":
            return np.asarray(reference.bias(q, v, t))
        case "forces":
            return np.asarray(reference.forces(q, v, t))
        case "gravity":
            return np.asarray(reference.gravity(q, t))
        case "inverse_dynamics":
            return np.asarray(reference.inverse_dynamics(q, v, states.a, t))
        case "energy":
            energy = reference.energy(q, v, t)
            V = np.asarray(energy.gravity) + np.asarray(energy.springs)
            return np.stack([np.asarray(energy.kinetic), V], axis=-1)
        case "poses":
            mechanism = reference.mechanism
            moved = [body.name for body in mechanism.bodies if body.name != mechanism.ground]
            found = [np.asarray(reference.pose(body, q, t))[:, :3] for body in moved]
            return np.stack(found, axis=1)
        case "jacobians":
            mechanism = reference.mechanism
            moved = [body.name for body in mechanism.bodies if body.name != mechanism.ground]
            return np.stack([np.asarray(reference.jacobian(body, q, t)) for body in moved], axis=1)
        case "reactions":
            return _compute_reactions(reference, states, tau)
        case "closure":
            residual = np.asarray(reference.constraint_residual(q, t))
            return np.hstack([residual, _compute_gap_rates(reference, states)])
        case "multipliers":
            return _compute_multipliers(reference, states, tau)
    raise InputError(f"{name!r} cannot be compared with Pinocchio")


def _compute_reactions(reference: Reference, states: States, tau: np.ndarray) -> np.ndarray:
    """Return the wrenches of joints on their children, then of loops, (n, joints and loops, 6).

    Raises:
        DerivationError: if some are undetermined.
    """
    wrenches = reference.reactions(states.q, states.v, states.t, tau)
    loose = [name for name, wrench in wrenches.items() if wrench.undetermined]
    if loose:
        raise DerivationError(
            f"the reactions of mechanism {reference.mechanism.name!r} are undetermined in "
            f"{', '.join(loose)}"
        )
    rows = [np.concatenate([w.force, w.moment], axis=-1) for w in wrenches.values()]
    return np.stack(rows, axis=1)


def _compute_gap_rates(reference: Reference, states: States) -> np.ndarray:
    """Return Φ', or ψ for rows that restrict velocities only, shape (n, m)."""
    assert reference.closed is not None, "the mechanism has loops"
    found = []
    for q, v, t in zip(states.q, states.v, states.t.tolist(), strict=True):
        here = reference.closed.closures.at(q, v, t)
        found.append(here.jacobian @ v + here.drift)
    return np.array(found)


def unit_of(name: str, answer: np.ndarray, d: np.ndarray, mass: float) -> Any:
    """Return the factors that make the entries of an answer comparable, for its shape (n, size).

    Args:
        name: name of a quantity.
        answer: its values, shape (n, …).
        d: square roots of the mass matrix's diagonal, shape (n, nv).
        mass: the moving mass [kg].
    """
    match name:
        case "rhs":
            rates = answer.shape[1] - d.shape[1]
            return np.hstack([np.full((len(d), rates), np.sqrt(mass)), d])
        case "acceleration":
            return d
        case "mass_matrix":
            return (1 / (d[:, :, None] * d[:, None, :])).reshape(len(d), -1)
        case "bias" | "forces" | "gravity" | "inverse_dynamics":
            return 1 / d
    return np.ones((len(d), int(np.prod(answer.shape[1:]))))


def _compute_multipliers(reference: Reference, states: States, tau: np.ndarray) -> np.ndarray:
    """Return λ from M a + bias − forces − τ = Jᵀ λ."""
    J = np.asarray(reference.constraint_jacobian(states.q, states.t))
    a = answer_of("acceleration", reference, states, tau)
    M = answer_of("mass_matrix", reference, states, tau)
    rest = answer_of("bias", reference, states, tau) - tau
    rest = rest - answer_of("forces", reference, states, tau)
    found = []
    for k in range(len(states)):
        solved = np.linalg.lstsq(J[k].T, M[k] @ a[k] + rest[k], rcond=None)
        if solved[2] < len(J[k]):
            raise DerivationError(
                f"constraints of mechanism {reference.mechanism.name!r} are redundant, which "
                "leaves their multipliers undetermined"
            )
        found.append(solved[0])
    return np.array(found)
