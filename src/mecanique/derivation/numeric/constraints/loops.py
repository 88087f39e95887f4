"""Compute the constraints Φ of loops, their Jacobian J and γ = J' v from our poses, in one jet.

Along the path q + ε v the value of Φ is a jet: its partial derivatives at ε = 0 are J, and twice
its coefficient of ε² is γ, the value of Φ'' without accelerations. All is measured in the axes of
frame a, where frame b has the position p and the rotation matrix R; a hinge keeps R z = z, a weld
keeps the skew part of R at zero.

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
from typing import Any, NamedTuple, final

import numpy as np

from mecanique.arrays import Array
from mecanique.derivation.mechanics.loops import closure
from mecanique.derivation.numeric.paths import constant_jet, frame_jet, ground_on_jets
from mecanique.derivation.scalars.jets import Jet
from mecanique.derivation.tolerances import DEFINITE, RANK, ROUNDING
from mecanique.derivation.tree.links import links, place_of
from mecanique.derivation.tree.poses import placement_matrix
from mecanique.model.constraints.loops import CLOSED
from mecanique.model.mechanism import Mechanism
from mecanique.model.mechanism_units import characteristic_length, velocity_scales
from mecanique.model.states import States

_LOOKS = 100
"""How often a combination that is not definite is improved."""


@final
@dataclass(frozen=True)
class Constraints:
    """The constraints at n states: Φ = 0 with Φ'' = J a + γ."""

    residual: np.ndarray  # Φ, shape (n, m)
    jacobian: np.ndarray  # J, shape (n, m, nv)
    gamma: np.ndarray  # γ, shape (n, m)


def drop_rounding(jacobian: np.ndarray, terms: np.ndarray) -> np.ndarray:
    """Return J with zeros where its entries are no more than the rounding of their terms."""
    # Rows that joints satisfy by themselves, such as those across a planar linkage's plane, would
    # otherwise count as constraints once they are scaled to one
    return np.where(np.abs(jacobian) > ROUNDING * terms, jacobian, 0.0)


def shift_sizes(pose: Jet) -> np.ndarray:
    """Return by how much variations displace a pose's origin, shape (n, nv)."""
    return np.asarray(np.linalg.norm(pose.c[0, 1:, :, :3, 3], axis=-1).T)


def turn_sizes(pose: Jet) -> np.ndarray:
    """Return by how much variations turn a pose, shape (n, nv)."""
    return np.asarray(np.linalg.norm(pose.c[0, 1:, :, :3, :3], axis=(-2, -1)).T)


class RowUnits(NamedTuple):
    """Natural units of the rows of constraints."""

    units: np.ndarray  # shape (m,), a typical length or one radian
    # shape (m,), number of each row's block; the rows of a block are scaled together
    blocks: np.ndarray


@final
class Closure:
    """The constraints of a mechanism's loops, as jets."""

    def __init__(self, mechanism: Mechanism) -> None:
        self._mechanism = mechanism
        self._place = place = place_of(links(mechanism), mechanism)
        self._ends: list[list[tuple[int, np.ndarray]]] = []
        """For each end of each loop: index of its link in the tree, and its pose in that link."""
        for loop in mechanism.loops:
            X_a = placement_matrix(loop.frame_a, mechanism.values)
            X_b = placement_matrix(loop.frame_b, mechanism.values)
            self._ends.append([(place[loop.body_a], X_a), (place[loop.body_b], X_b)])
        self.names = tuple(
            f"{loop.name}: {row}" for loop in mechanism.loops for row in CLOSED[loop.kind]
        )
        """Name of each row: the loop's and the motion it closes, in the axes of frame a."""
        self.length = characteristic_length(mechanism)
        """The characteristic length, with which others are compared [m]."""
        self.units = np.array(
            [self.length if name.split(": ")[-1][0] != "r" else 1.0 for name in self.names]
        )
        """Unit of each row, the characteristic length or one radian, shape (m,)."""

        owners = [(k, row) for k, loop in enumerate(mechanism.loops) for row in CLOSED[loop.kind]]
        blocks = np.array([2 * k + (row[0] == "r") for k, row in owners], dtype=int)
        self.row_units = RowUnits(self.units, blocks)
        """Natural units of the rows, and their blocks: a loop's lengths, or its angles."""

    def rows(self, poses: list[Jet]) -> list[Jet]:
        """Return Φ, one jet per row; poses (n, 4, 4)."""
        ground, shape = ground_on_jets(self._mechanism, self._place, poses), poses[0].c.shape[:3]
        rows = [row for loop in self._mechanism.loops for row in closure(loop, ground, _angle)]
        return [row if isinstance(row, Jet) else constant_jet(row, shape) for row in rows]

    def at(self, poses: list[Jet]) -> Constraints:
        """Return Φ, J and γ of the poses along a path without acceleration."""
        c = np.stack([row.c for row in self.rows(poses)], axis=-1)
        jacobian = drop_rounding(np.moveaxis(c[0, 1:], 0, -1), self._terms(poses))
        return Constraints(c[0, 0], jacobian, 2 * c[2, 0])

    def _terms(self, poses: list[Jet]) -> np.ndarray:
        """Return the size of what is summed in each entry of J, shape (n, m, nv)."""
        terms = []
        for loop, ends in zip(self._mechanism.loops, self._ends, strict=True):
            A, B = (frame_jet(poses, place, X) for place, X in ends)
            turn = turn_sizes(A)
            # p = Rᵀ (p_B − p_A) turns with frame a, and p_B − p_A is as certain as its two terms
            far = sum(np.linalg.norm(X.value[:, :3, 3], axis=-1) for X in (A, B))
            shift = shift_sizes(A) + shift_sizes(B) + turn * np.reshape(far, (-1, 1))
            turn = turn + turn_sizes(B)
            terms += [turn if row[0] == "r" else shift for row in CLOSED[loop.kind]]
        return np.stack(terms, axis=1)


def _angle(y: Any, x: Any) -> Any:
    return y.atan2(x) if isinstance(y, Jet) else np.arctan2(y, x)


def is_locked(state: States, at: Callable[[States], Constraints]) -> bool:
    """Return whether loops prevent every motion in a state; there are no other constraints."""
    units = velocity_scales(state.mechanism)
    J = at(state).jacobian[0] * units
    lengths = np.linalg.norm(J, axis=1)
    lengths = np.where(lengths > 0, lengths, 1.0)[:, None]
    left, values, right = np.linalg.svd(J / lengths)
    rank = int((values > RANK * values.max(initial=0.0)).sum())
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
    each = state.at(np.zeros(len(v), dtype=int))
    gamma = at(replace(each, v=v)).gamma
    # the even part in c without its value at rest; the rest is due to prescribed motions
    along = (gamma[1 : 1 + len(c)] + gamma[1 + len(c) :]) / 2 - gamma[0]
    forms = np.zeros((gamma.shape[1], k, k))
    own = {i: along[n] for n, (i, j) in enumerate(pairs) if i == j}
    for n, (i, j) in enumerate(pairs):
        value = along[n] if i == j else (along[n] - own[i] - own[j]) / 2
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
