"""Whether loops lock a mechanism in a singular position, where small motions meet no resistance.

With q' along the free directions, q' = N c and J N = 0, a motion needs some q'' with
J q'' + γ(N c) = 0. So ℓᵀ γ(N c) = 0 for every ℓ with ℓᵀ J = 0: a quadratic form in c for each row
too many. If a combination of them is definite, only c = 0 satisfies all, and what is rigid to
second order is rigid (R. Connelly & W. Whiteley, SIAM J. Discrete Math. 9 (1996) 453, sect. 2, 3).
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from itertools import combinations_with_replacement

import numpy as np

from mecanique.arrays import Array
from mecanique.derivation.numeric.loops import Constraints
from mecanique.model.states import States
from mecanique.model.units import velocity_scales

__all__ = ["is_locked"]

_RANK = 1e-9
"""Singular values of J below this part of the largest count as zero."""

_DEFINITE = 1e-6
"""Least eigenvalue of a definite form, as a part of the largest second derivative."""

_LOOKS = 100
"""How often a combination that is not definite is bettered."""


def is_locked(state: States, at: Callable[[States], Constraints]) -> bool:
    """Return whether nothing can move in a state of a mechanism that only loops hold.

    Args:
        state: one state; the loops closed.
        at: returns J and γ of the loops.
    """
    units = velocity_scales(state.mechanism)
    J = at(state).jacobian[0] * units
    lengths = np.linalg.norm(J, axis=1)
    lengths = np.where(lengths > 0, lengths, 1.0)[:, None]
    left, values, right = np.linalg.svd(J / lengths)
    rank = int((values > _RANK * values.max(initial=0.0)).sum())
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
    # what is linear in the velocities, or free of them, is due to prescribed motions
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
        if values[0] > _DEFINITE:
            return True
        # more of the forms that are positive along the worst direction
        along = np.einsum("rkl,k,l->r", forms, vectors[:, 0], vectors[:, 0])
        if np.abs(along).max() < _DEFINITE:
            return False
        weights = weights + along / np.linalg.norm(along)
    return False
