"""Solve Lagrange's equations of the first kind: M a + bias − Q = Jᵀ λ together with J a + γ = 0.

Both are solved at once, by least squares where constraints are redundant: a is unique if every
motion that the constraints allow has inertia, and λ is the least solution (Lagrange, Mécanique
analytique, 1788, part II, sect. IV; F. E. Udwadia & R. E. Kalaba, Analytical Dynamics, 1996, ch.
3).

Loops may also lock a mechanism in a singular position, where J alone would allow small motions.
With q' along the free directions, q' = N c and J N = 0, a motion needs some q'' with
J q'' + γ(N c) = 0. So ℓᵀ γ(N c) = 0 for every ℓ with ℓᵀ J = 0: a quadratic form in c for each
redundant row. If a combination of them is definite, only c = 0 satisfies all; a mechanism that is
rigid to second order is rigid (R. Connelly & W. Whiteley, SIAM J. Discrete Math. 9 (1996) 453,
sect. 2, 3).
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from itertools import combinations_with_replacement
from typing import final

import numpy as np

from mecanique.arrays import Array, rank_of
from mecanique.derivation.numeric.constraints.rows import Constraints, Held, RowUnits
from mecanique.derivation.numeric.dynamics import BatchDynamics
from mecanique.derivation.tolerances import DEFINITE, LOOSE, RANK, SHARE
from mecanique.errors import DerivationError, InputError
from mecanique.model.constraints.loops import explain_lock
from mecanique.model.mechanism import Mechanism
from mecanique.model.mechanism_units import velocity_scales
from mecanique.model.states import States


@final
@dataclass(frozen=True)
class HeldMotion:
    """The accelerations and multipliers of a constrained tree in one state, or in n."""

    acceleration: np.ndarray  # shape (nv,)
    multipliers: np.ndarray  # λ of each row, shape (m,); Jᵀ λ is the generalized constraint force
    # shape (m,), False where redundant constraints leave a multiplier undetermined
    determined: np.ndarray
    massless: np.ndarray | None = None  # shape (nv,), an allowed motion without inertia, if any


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
    rank = rank_of(values, RANK)
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

    def motion(self, states: States) -> HeldMotion:
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
                # One check suffices: a locked mechanism cannot reach any other position
                if is_locked(states.at(np.array([k])), self._held.at):
                    raise InputError(explain_lock(self._mechanism.name))
                self._movable = True
            motions.append(motion)
        return HeldMotion(
            np.array([motion.acceleration for motion in motions]).reshape(states.v.shape),
            np.array([motion.multipliers for motion in motions]).reshape(closed.gamma.shape),
            np.array([motion.determined for motion in motions]).reshape(closed.gamma.shape),
        )

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


_LOOKS = 100
"""How often a combination that is not definite is improved."""


def is_locked(state: States, at: Callable[[States], Constraints]) -> bool:
    """Return whether loops prevent every motion in a state; there are no other constraints."""
    units = velocity_scales(state.mechanism)
    J = at(state).jacobian[0] * units
    lengths = np.linalg.norm(J, axis=1)
    lengths = np.where(lengths > 0, lengths, 1.0)[:, None]
    left, values, right = np.linalg.svd(J / lengths)
    rank = rank_of(values, RANK)
    extra, free = left[:, rank:], units[:, None] * right[rank:].T
    if not (extra.size and free.size):
        return False
    bent = _second_order(state, free, at) / lengths[:, None]
    size = np.abs(bent).max()
    return bool(size > 0) and _has_definite(np.einsum("mkl,mr->rkl", bent / size, extra))


def _second_order(state: States, free: Array, at: Callable[[States], Constraints]) -> Array:
    """Return the symmetric forms of γ along the free directions, shape (m, k, k)."""
    k = free.shape[1]
    pairs = list(combinations_with_replacement(range(k), 2))
    c = np.array([np.eye(k)[i] + (np.eye(k)[j] if i != j else 0.0) for i, j in pairs])
    v = np.concatenate([np.zeros((1, len(free))), c @ free.T, -c @ free.T])
    repeated = state.at(np.zeros(len(v), dtype=int))
    gamma = at(replace(repeated, v=v)).gamma
    # the even part in c without its value at rest; the rest is due to prescribed motions
    along = (gamma[1 : 1 + len(c)] + gamma[1 + len(c) :]) / 2 - gamma[0]
    forms = np.zeros((gamma.shape[1], k, k))
    squares = {i: along[n] for n, (i, j) in enumerate(pairs) if i == j}
    for n, (i, j) in enumerate(pairs):
        value = along[n] if i == j else (along[n] - squares[i] - squares[j]) / 2
        forms[:, i, j] = forms[:, j, i] = value
    return forms


def _has_definite(forms: Array) -> bool:
    """Return whether some combination of symmetric forms is positive definite."""
    weights = np.einsum("rkk->r", forms)
    for _ in range(_LOOKS):
        values, vectors = np.linalg.eigh(np.einsum("r,rkl->kl", weights, forms))
        if values[0] > DEFINITE:
            return True
        # add more of the forms that are positive along the worst direction
        along = np.einsum("rkl,k,l->r", forms, vectors[:, 0], vectors[:, 0])
        if np.abs(along).max() < DEFINITE:
            return False
        weights = weights + along / np.linalg.norm(along)
    return False
