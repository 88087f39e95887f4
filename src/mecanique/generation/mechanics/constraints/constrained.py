"""Accelerations and multipliers of closed mechanisms: M a = f + Jᵀ λ and J a = −γ, on a tape.

With λ from (J M⁻¹ Jᵀ) λ = −γ − J M⁻¹ f. Where M alone is singular, M + Jᵀ W J takes its place and f
− Jᵀ W γ that of f, which changes nothing since J a = −γ (M. Benzi, G. H. Golub & J. Liesen, Acta
Numerica 14 (2005) 1, sect. 5.1). Velocities that stand in an equation with a constant factor, as
those of a wheel's center do, are first put in terms of the others.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, final

import numpy as np

from mecanique.generation.mechanics.constraints.loops import Loops
from mecanique.generation.mechanics.letters import Letters
from mecanique.generation.mechanics.sampling import sample
from mecanique.generation.mechanics.vectors import Rows, apply, dot, products, scale, transpose
from mecanique.generation.program.solving import factorize
from mecanique.generation.program.traced import trace, value_of
from mecanique.model.states import States

__all__ = ["Constrained", "Solution"]

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


@final
class Constrained:
    """The mass matrix and the independent equations of the loops, factorized.

    Args:
        letters: the inputs.
        M: mass matrix of the tree.
        loops: what the loops demand.
        states: where to see which equations are redundant; random ones by default.
    """

    def __init__(
        self, letters: Letters, M: Rows, loops: Loops, states: States | None = None
    ) -> None:
        masses, jacobians = sample(letters, [M, loops.jacobian], states)
        self._tape = letters.tape
        self._loops = loops
        self._M = M
        self._kept = _independent(masses, jacobians)
        self._J = [loops.jacobian[k] for k in self._kept]
        self._gamma = [loops.gamma[k] for k in self._kept]
        self._reduced = _reduce(self._J, self._gamma)
        self._weight = 0.0
        if _is_singular(masses):
            self._weight = float(np.median(np.trace(masses, axis1=1, axis2=2))) / float(
                np.median(np.sum(jacobians**2, axis=(1, 2)))
            )
            columns = transpose(self._J)
            squares = [scale(self._weight, row) for row in products(columns, columns)]
            M = [list(map(sum, zip(*rows, strict=True))) for rows in zip(M, squares, strict=True)]
        factors = factorize(self._tape, M)
        self._free = factors.solve
        pulled = [factors.solve(row) for row in self._J]
        self._pulled = transpose(pulled) if pulled else [[] for _ in letters.v]
        self._resistance = products(self._J, pulled)
        self._factors = factorize(self._tape, self._resistance)

    def solve(self, drive: list[Any]) -> Solution:
        """Return accelerations and multipliers.

        Args:
            drive: forces minus bias.
        """
        if self._reduced.pivots and not self._weight:
            return self._solve_reduced(drive)
        if self._weight:
            columns = transpose(self._J)
            pairs = zip(drive, columns, strict=True)
            drive = [f - self._weight * dot(column, self._gamma) for f, column in pairs]
        free = self._free(drive)
        missing = [-(g + dot(row, free)) for g, row in zip(self._gamma, self._J, strict=True)]
        found = self._factors.solve(missing)
        a = [x + dot(found, column) for x, column in zip(free, self._pulled, strict=True)]
        return self._solution(a, found)

    def _solution(self, a: list[Any], found: list[Any]) -> Solution:
        multipliers: list[Any] = [0.0] * len(self._loops.names)
        for k, value in zip(self._kept, found, strict=True):
            multipliers[k] = value
        return Solution(tuple(a), tuple(multipliers))

    def _solve_reduced(self, drive: list[Any]) -> Solution:
        """The same with a = S b + c put into M a = f + Jᵀ λ, which takes fewer operations."""
        reduced, tape, J = self._reduced, self._tape, self._J
        S = transpose(reduced.spread)
        factors = factorize(tape, products(S, products(S, self._M)))
        pushed = apply(self._M, reduced.rest)
        b = factors.solve(apply(S, [f - x for f, x in zip(drive, pushed, strict=True)]))
        rows = products([J[k] for k in reduced.others], S)
        pulled = [factors.solve(row) for row in rows]
        missing = [
            -(self._gamma[k] + dot(J[k], reduced.rest) + dot(row, b))
            for k, row in zip(reduced.others, rows, strict=True)
        ]
        found = factorize(tape, products(rows, pulled)).solve(missing)
        if found:
            b = [x + dot(found, column) for x, column in zip(b, transpose(pulled), strict=True)]
        a = [c + dot(row, b) for c, row in zip(reduced.rest, reduced.spread, strict=True)]
        known = dict(zip(reduced.others, found, strict=True))
        # in the equation of a velocity that was put in terms of others its own row stands alone
        for k, column in reduced.pivots.items():
            left = dot(self._M[column], a) - drive[column]
            left = left - sum(J[other][column] * known[other] for other in reduced.others)
            known[k] = left * (1.0 / J[k][column])
        return self._solution(a, [known[k] for k in range(len(J))])

    def close(self, gaps: list[Any]) -> list[Any]:
        """Return the velocities times a time that undo gaps of all rows, with least energy.

        Args:
            gaps: of every row; those of redundant ones follow from the others.
        """
        found = self._factors.solve([-gaps[k] for k in self._kept])
        return [dot(found, column) for column in self._pulled]

    def firmness(self) -> Any:
        """Return how firmly the loops hold what they close: zero where J loses rank.

        It is (Σ 1/σ²)^(−1/2), with σ the singular values of the rows of J by directions of unit
        kinetic energy, those of a block together of length one: the least σ, or somewhat less.
        """
        if not self._kept:
            return 1.0
        blocks = [self._loops.blocks[k] for k in self._kept]
        total: Any = 0.0
        for k, block in enumerate(blocks):
            unit = [1.0 if k == i else 0.0 for i in range(len(blocks))]
            compliance = self._factors.solve(unit)[k]
            for i, other in enumerate(blocks):
                if other == block:
                    total = total + self._resistance[i][i] * compliance
        root = self._tape.call("sqrt", self._tape.divide(1.0, value_of(total)))
        return trace(self._tape, root)


@final
@dataclass(frozen=True)
class _Reduced:
    """Velocities that stand in an equation with a constant factor, in terms of the others.

    Args:
        pivots: number of such a velocity, by the row of J in which it stands.
        others: the other rows.
        spread: S of a = S b + c, with b the other accelerations.
        rest: c.
    """

    pivots: dict[int, int]
    others: list[int]
    spread: Rows
    rest: list[Any]


def _reduce(J: Rows, gamma: list[Any]) -> _Reduced:
    """Choose rows of J and a velocity of each, such that these rows have a diagonal of numbers."""
    pivots: dict[int, int] = {}
    for k, row in enumerate(J):
        for column, entry in enumerate(row):
            alone = all(_is_zero(J[one][column]) for one in pivots)
            alone = alone and all(_is_zero(row[taken]) for taken in pivots.values())
            if isinstance(entry, float) and entry and alone:
                pivots[k] = column
                break
    count = len(J[0]) if J else 0
    free = [column for column in range(count) if column not in pivots.values()]
    spread: Rows = [[0.0] * len(free) for _ in range(count)]
    for at, column in enumerate(free):
        spread[column][at] = 1.0
    rest: list[Any] = [0.0] * count
    for k, column in pivots.items():
        share = -1.0 / J[k][column]
        spread[column] = [share * J[k][other] for other in free]
        rest[column] = share * gamma[k]
    return _Reduced(pivots, [k for k in range(len(J)) if k not in pivots], spread, rest)


def _is_zero(entry: Any) -> bool:
    return isinstance(entry, float) and entry == 0.0


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
