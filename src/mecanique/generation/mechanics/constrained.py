"""Accelerations and multipliers of closed mechanisms: M a = f + Jᵀ λ and J a = −γ, on a tape.

With λ from (J M⁻¹ Jᵀ) λ = −γ − J M⁻¹ f. Where M alone is singular, M + Jᵀ W J takes its place and f
− Jᵀ W γ that of f, which changes nothing since J a = −γ (M. Benzi, G. H. Golub & J. Liesen, Acta
Numerica 14 (2005) 1, sect. 5.1).
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, final

import numpy as np

from mecanique.generation.mechanics.letters import Letters
from mecanique.generation.mechanics.loops import Loops
from mecanique.generation.mechanics.sampling import sample
from mecanique.generation.mechanics.vectors import Rows, dot, products, scale, transpose
from mecanique.generation.program.solving import factorize

__all__ = ["Solution", "solve_constrained"]

_RANK = 1e-8
"""Rows whose part across the others is smaller than this are redundant."""


@final
@dataclass(frozen=True)
class Solution:
    """What a closed mechanism does.

    Args:
        acceleration: a.
        multipliers: λ of every row; zero of redundant ones.
    """

    acceleration: tuple[Any, ...]
    multipliers: tuple[Any, ...]


def solve_constrained(letters: Letters, M: Rows, drive: list[Any], loops: Loops) -> Solution:
    """Return accelerations and multipliers.

    Args:
        letters: the inputs.
        M: mass matrix of the tree.
        drive: forces minus bias.
        loops: what the loops demand.
    """
    tape = letters.tape
    masses, jacobians = sample(letters, [M, loops.jacobian])
    kept = _independent(masses, jacobians)
    J = [loops.jacobian[k] for k in kept]
    gamma = [loops.gamma[k] for k in kept]
    if _is_singular(masses):
        weight = float(np.median(np.trace(masses, axis1=1, axis2=2))) / float(
            np.median(np.sum(jacobians**2, axis=(1, 2)))
        )
        columns = transpose(J)
        squares = [scale(weight, row) for row in products(columns, columns)]
        M = [list(map(sum, zip(*rows, strict=True))) for rows in zip(M, squares, strict=True)]
        drive = [f - weight * dot(column, gamma) for f, column in zip(drive, columns, strict=True)]
    factors = factorize(tape, M)
    free = factors.solve(drive)
    pulled = [factors.solve(row) for row in J]
    missing = [-(g + dot(row, free)) for g, row in zip(gamma, J, strict=True)]
    found = factorize(tape, products(J, pulled)).solve(missing)
    moved = transpose(pulled) if pulled else [[] for _ in free]
    a = [x + dot(found, column) for x, column in zip(free, moved, strict=True)]
    multipliers: list[Any] = [0.0] * len(loops.names)
    for k, value in zip(kept, found, strict=True):
        multipliers[k] = value
    return Solution(tuple(a), tuple(multipliers))


def _independent(masses: np.ndarray, jacobians: np.ndarray) -> list[int]:
    """Rows that do not follow from those before them at some state."""
    kept: list[int] = []
    for row in range(jacobians.shape[1]):
        trial = [*kept, row]
        for J in jacobians:
            sizes = np.linalg.norm(J[trial], axis=1)
            if sizes.min() > 0:
                scaled = J[trial] / sizes[:, None]
                if np.linalg.svd(scaled, compute_uv=False)[-1] > _RANK:
                    kept = trial
                    break
    return kept


def _is_singular(masses: np.ndarray) -> bool:
    for M in masses:
        d = np.sqrt(np.diagonal(M))
        if d.min() <= 0 or np.linalg.eigvalsh(M / np.outer(d, d))[0] < _RANK:
            return True
    return False
