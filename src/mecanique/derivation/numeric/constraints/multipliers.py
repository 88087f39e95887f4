"""Solve Lagrange's equations of the first kind: M a + bias − Q = Jᵀ λ together with J a + γ = 0.

Both are solved at once, by least squares where constraints are redundant: a is unique if every
motion that the constraints allow has inertia, and λ is the least solution (Lagrange, Mécanique
analytique, 1788, part II, sect. IV; F. E. Udwadia & R. E. Kalaba, Analytical Dynamics, 1996, ch.
3).
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple, final

import numpy as np

from mecanique.derivation.numeric.constraints.contacts import VelocityLaws
from mecanique.derivation.numeric.constraints.loops import (
    Closure,
    Constraints,
    RowUnits,
    is_locked,
)
from mecanique.derivation.numeric.dynamics import BatchDynamics
from mecanique.derivation.numeric.lagrange import LagrangeOnJets
from mecanique.derivation.tolerances import LOOSE, RANK, SHARE
from mecanique.errors import DerivationError, InputError
from mecanique.model.constraints.loops import explain_lock
from mecanique.model.mechanism import Mechanism
from mecanique.model.mechanism_units import velocity_scales
from mecanique.model.states import States


@final
@dataclass(frozen=True)
class ConstrainedMotion:
    """The accelerations and multipliers of a constrained tree in n states."""

    acceleration: np.ndarray  # shape (n, nv)
    multipliers: np.ndarray  # λ of each row, shape (n, m); Jᵀ λ is the generalized constraint force
    # shape (n, m), False where redundant constraints leave a multiplier undetermined
    determined: np.ndarray


class Push(NamedTuple):
    """A unit force of a contact."""

    place: np.ndarray  # shape (n, 3), its point of action, in the world [m]
    direction: np.ndarray  # shape (n, 3), world axes
    ends: tuple[str, str]  # the body on which it acts, and the one on which its opposite acts


@final
class Held:
    """All rows that constrain a mechanism's tree: of loops, contacts and velocity constraints."""

    def __init__(self, mechanism: Mechanism) -> None:
        self._mechanism = mechanism
        self._definition = LagrangeOnJets(mechanism)
        self._loops, self._laws = Closure(mechanism), VelocityLaws(mechanism)
        self.names = (*self._loops.names, *self._laws.names)
        """Name of each row."""
        first, rest = self._loops.row_units, self._laws.row_units
        self.row_units = RowUnits(
            np.concatenate([first.units, rest.units]),
            np.concatenate([first.blocks, 2 * len(mechanism.loops) + rest.blocks]),
        )
        """Natural units of the rows, and their blocks."""

    def at(self, states: States) -> Constraints:
        """Return Φ, J and γ."""
        _, poses = self._definition.motion(states, np.zeros_like(states.v))
        parts = [self._loops.at(poses)] if self._mechanism.loops else []
        if self._laws.names:
            parts.append(self._laws.at(states, poses))
        return Constraints(
            np.concatenate([part.residual for part in parts], axis=1),
            np.concatenate([part.jacobian for part in parts], axis=1),
            np.concatenate([part.gamma for part in parts], axis=1),
        )

    def forces(self, states: States) -> dict[int, Push]:
        """Return the unit force of each row that belongs to a contact, by row."""
        _, poses = self._definition.motion(states, np.zeros_like(states.v))
        found, row = {}, len(self._loops.names)
        for contact in self._mechanism.contacts:
            place, directions, _ = self._laws.touch(contact, poses)
            for direction in directions:
                found[row] = Push(
                    place.value[:, :, 0],
                    direction.value[:, :, 0],
                    (contact.body, contact.on),
                )
                row += 1
        return found


def constraints(mechanism: Mechanism, states: States) -> Constraints:
    """Return Φ, J and γ of all constraints on a mechanism's tree."""
    return Held(mechanism).at(states)


class HeldMotion(NamedTuple):
    """The motion of a constrained tree in one state."""

    acceleration: np.ndarray  # shape (nv,)
    multipliers: np.ndarray  # λ of each row, shape (m,)
    # shape (m,), False where redundant constraints leave a multiplier undetermined
    determined: np.ndarray
    massless: np.ndarray | None  # shape (nv,), an allowed motion without inertia, if there is one


def solve_held(
    M: np.ndarray,
    rest: np.ndarray,
    jacobian: np.ndarray,
    gamma: np.ndarray,
    columns: np.ndarray,
    rows: RowUnits,
) -> HeldMotion:
    """Solve M a − rest = Jᵀ λ together with J a + γ = 0, with the least λ."""
    # Velocities are scaled by the kinetic energy they carry and blocks of rows by their size, which
    # gives a small part of a mechanism the same weight as a large one
    # Shapes: M (nv, nv), rest (nv,), jacobian (m, nv), gamma (m,), columns (nv,)
    nv, m = jacobian.shape[1], len(gamma)
    units = _energy_units(M, jacobian, columns)
    size = np.bincount(rows.blocks, ((jacobian * units) ** 2).sum(axis=1))[rows.blocks]
    factors = 1 / np.sqrt(np.where(size > 0, size, 1.0))
    J = factors[:, None] * jacobian * units
    both = np.block([[units[:, None] * M * units, -J.T], [J, np.zeros((m, m))]])
    right = np.concatenate([units * rest, -factors * gamma])
    left, values, turned = np.linalg.svd(both)
    rank = int((values > RANK * values[0]).sum())
    moving, idle = turned[rank:, :nv], turned[rank:, nv:].T
    solution = np.zeros(nv + m)
    for _ in range(2):  # refined once: rounding of a large part disturbs a small one
        missing = left[:, :rank].T @ (right - both @ solution)
        solution = solution + turned[:rank].T @ (missing / values[:rank])
    a, multipliers = units * solution[:nv], solution[nv:]
    if idle.size:
        plain = factors * rows.units
        surplus = np.linalg.lstsq(plain[:, None] * idle, plain * multipliers, rcond=None)[0]
        multipliers = multipliers - idle @ surplus
    determined = np.abs(idle).max(axis=1, initial=0.0) < SHARE
    loose = np.abs(moving).max(axis=1, initial=0.0)
    massless = moving[int(loose.argmax())] if loose.max(initial=0.0) > LOOSE else None
    return HeldMotion(a, factors * multipliers, determined, massless)


def _energy_units(M: np.ndarray, J: np.ndarray, columns: np.ndarray) -> np.ndarray:
    """Return units of the velocities in which each carries the energy ½, shape (nv,)."""
    # A massless velocity takes the unit of the lightest of those that the loops couple it to
    inertia = np.diag(M) * columns**2
    massive = inertia > 0
    tied = np.abs(J) > 0
    for j in np.flatnonzero(~massive):
        beside = massive & tied[tied[:, j]].any(axis=0)
        others = inertia[beside if beside.any() else massive]
        inertia[j] = others.min() if others.size else 1.0
    units: np.ndarray = columns / np.sqrt(inertia)
    return units


@final
class Constrained:
    """Solve for the motion of a tree with loops, contacts or velocity constraints."""

    def __init__(self, mechanism: Mechanism, tree: BatchDynamics) -> None:
        self._mechanism = mechanism
        self._tree = tree
        self._held = Held(mechanism)
        self._units = velocity_scales(mechanism)
        self._movable = bool(mechanism.contacts or mechanism.velocity_constraints)
        """Whether the loops are known not to lock the mechanism in a singular position."""

    @property
    def names(self) -> tuple[str, ...]:
        """Name of each row of the constraints."""
        return self._held.names

    def motion(self, states: States) -> ConstrainedMotion:
        """Solve for accelerations and multipliers."""
        closed = self._held.at(states)
        M, rest = (
            self._tree.mass_matrix(states),
            self._tree.forces(states) - self._tree.bias(states),
        )
        motions = []
        for k in range(len(states)):
            jacobian, gamma = closed.jacobian[k], closed.gamma[k]
            motion = solve_held(M[k], rest[k], jacobian, gamma, self._units, self._held.row_units)
            if motion.massless is not None:
                raise self._massless(motion.massless)
            if not (self._movable or motion.determined.all()):
                self._refuse_locked(states.at(np.array([k])))
            motions.append(motion)
        return ConstrainedMotion(
            np.array([motion.acceleration for motion in motions]).reshape(states.v.shape),
            np.array([motion.multipliers for motion in motions]).reshape(closed.gamma.shape),
            np.array([motion.determined for motion in motions]).reshape(closed.gamma.shape),
        )

    def _refuse_locked(self, state: States) -> None:
        """Refuse a position in which the loops lock the mechanism."""
        # One check suffices: a locked mechanism cannot reach any other position
        if is_locked(state, self._held.at):
            raise InputError(explain_lock(self._mechanism.name))
        self._movable = True

    def _massless(self, mode: np.ndarray) -> DerivationError:
        names = [
            name
            for name, part in zip(self._mechanism.velocities, mode, strict=True)
            if abs(part) > 0.1
        ]
        return DerivationError(
            f"mechanism {self._mechanism.name!r}: its loops allow a motion of "
            f"{', '.join(names) or 'several joints'} without inertia; give a body in it mass"
        )
