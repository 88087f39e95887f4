"""Solve for accelerations and multipliers on a tape: M a = f + Jᵀ λ and J a = −γ.

λ follows from (J M⁻¹ Jᵀ) λ = −γ − J M⁻¹ f. If M is singular, it is replaced by M + Jᵀ W J, and f by
f − Jᵀ W γ, which changes nothing since J a = −γ (M. Benzi, G. H. Golub & J. Liesen, Acta Numerica
14 (2005) 1, sect. 5.1). Velocities with a constant factor in a constraint, such as those of a
wheel's center, are first expressed by the others. The same factors project a nearby state on the
loops.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, Protocol, final

import numpy as np

from mecanique.derivation.mechanics.letters import Letters
from mecanique.derivation.mechanics.loops import Loops
from mecanique.derivation.mechanics.vectors import Rows, apply, dot, products, scale, transpose
from mecanique.derivation.numeric.constraints.rows import Held
from mecanique.derivation.tolerances import INDEPENDENT
from mecanique.generation.program import LoopProjection
from mecanique.model.states import States
from mecanique.program.evaluation import evaluate
from mecanique.program.solving import Factors, factorize
from mecanique.program.sweeps import push_forward
from mecanique.program.traced import trace, value_of, values_of
from mecanique.verification.states import random_states


def sample(letters: Letters, tables: list[Any], states: States) -> list[np.ndarray]:
    """Return tables of scalars at a few states, each shape (states, rows, columns)."""
    inputs = inputs_at(letters, states)
    sampled = []
    for table in tables:
        values = [value_of(entry) for row in table for entry in row]
        numbers = evaluate(letters.tape, values, inputs, len(states))
        sampled.append(numbers.reshape(len(states), len(table), -1))
    return sampled


def inputs_at(letters: Letters, states: States) -> dict[str, Any]:
    """Return the value of every input of a program in some states, by name."""
    values = states.values
    return {
        "t": states.t,
        **{name: values[name] for name in letters.mechanism.coordinates},
        **{name: values[name] for name in letters.mechanism.velocities},
        **{symbol: values[symbol] for symbol in letters.open},
        **{f"tau {name}": 0.0 for name in letters.mechanism.velocities},
        **{
            f"a {name}": a for name, a in zip(letters.mechanism.velocities, states.a.T, strict=True)
        },
    }


_STATES = 16
"""Number of states in which redundant equations are found."""


@final
@dataclass(frozen=True)
class ConstrainedSolution:
    """The accelerations and multipliers of a closed mechanism."""

    acceleration: list[Any]  # a
    multipliers: list[Any]  # λ of every row; zero for redundant ones


class Projecting(Protocol):
    """Factors that project a nearby state on the loops."""

    def close(self, gaps: list[Any]) -> list[Any]:
        """Return the displacements of least energy that close the gaps of all rows."""

    def firmness(self) -> Any:
        """Return a measure of regularity of the loops, zero in singular positions."""


@final
class FactorizedConstraints:
    """The mass matrix and the independent equations of the loops, factorized."""

    def __init__(
        self, letters: Letters, M: Rows, loops: Loops, states: States | None = None
    ) -> None:
        if states is None:
            states = random_states(letters.mechanism, _STATES, 0)
        (masses,) = sample(letters, [M], states)
        # not those of the program: rows of nothing but rounding are zero here
        jacobians = Held(letters.mechanism).at(states).jacobian
        self._tape = letters.tape
        self._loops = loops
        self._M = M
        self._kept = independent(jacobians)
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

    def solve(self, drive: list[Any]) -> ConstrainedSolution:
        """Solve for accelerations and multipliers."""
        if self._reduced.pivots and not self._weight:
            return self._solve_reduced(drive)
        if self._weight:
            columns = transpose(self._J)
            pairs = zip(drive, columns, strict=True)
            drive = [f - self._weight * dot(column, self._gamma) for f, column in pairs]
        free = self._free(drive)
        missing = [-(g + dot(row, free)) for g, row in zip(self._gamma, self._J, strict=True)]
        multipliers = self._factors.solve(missing)
        a = [x + dot(multipliers, column) for x, column in zip(free, self._pulled, strict=True)]
        return self._solution(a, multipliers)

    def _solution(self, a: list[Any], values: list[Any]) -> ConstrainedSolution:
        multipliers: list[Any] = [0.0] * len(self._loops.names)
        for k, value in zip(self._kept, values, strict=True):
            multipliers[k] = value
        return ConstrainedSolution(a, multipliers)

    def _solve_reduced(self, drive: list[Any]) -> ConstrainedSolution:
        """Solve with a = S b + c substituted into M a = f + Jᵀ λ, which takes fewer operations."""
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
        multipliers = factorize(tape, products(rows, pulled)).solve(missing)
        if multipliers:
            b = [
                x + dot(multipliers, column) for x, column in zip(b, transpose(pulled), strict=True)
            ]
        a = [c + dot(row, b) for c, row in zip(reduced.rest, reduced.spread, strict=True)]
        known = dict(zip(reduced.others, multipliers, strict=True))
        # the equation of an eliminated velocity contains only the multiplier of its own row
        for k, column in reduced.pivots.items():
            left = dot(self._M[column], a) - drive[column]
            left = left - sum(J[k2][column] * known[k2] for k2 in reduced.others)
            known[k] = left * (1.0 / J[k][column])
        return self._solution(a, [known[k] for k in range(len(J))])

    def close(self, gaps: list[Any]) -> list[Any]:
        """Return the displacements of least energy that close the gaps of all rows."""
        multipliers = self._factors.solve([-gaps[k] for k in self._kept])
        return [dot(multipliers, column) for column in self._pulled]

    def firmness(self) -> Any:
        """Return a measure of regularity of the loops, which is zero where J loses rank.

        It is (Σ 1/σ²)^(−1/2), with the singular values σ of J in directions of unit kinetic energy
        and with the rows of a block scaled to unit length together: the least σ, or a little less.
        """
        if not self._kept:
            return 1.0
        blocks = [self._loops.blocks[k] for k in self._kept]
        total = weakness(self._resistance, self._factors, blocks)
        root = self._tape.call("sqrt", self._tape.divide(1.0, value_of(total)))
        return trace(self._tape, root)


def weakness(resistance: Rows, factors: Factors, blocks: Sequence[int]) -> Any:
    """Return Σ 1/σ² of rows of J by J M⁻¹ Jᵀ, rows of a block scaled to unit length together."""
    total: Any = 0.0
    for k, block in enumerate(blocks):
        unit = [1.0 if k == i else 0.0 for i in range(len(blocks))]
        compliance = factors.solve(unit)[k]
        for i, beside in enumerate(blocks):
            if beside == block:
                total = total + resistance[i][i] * compliance
    return total


@final
@dataclass(frozen=True)
class _Reduced:
    """Velocities with a constant factor in a constraint, expressed by the others."""

    pivots: dict[int, int]  # index of such a velocity, by its row of J
    others: list[int]
    spread: Rows  # S of a = S b + c, with b the other accelerations
    rest: list[Any]


def _reduce(J: Rows, gamma: list[Any]) -> _Reduced:
    """Choose rows of J and a velocity in each, such that these form a diagonal of numbers."""
    pivots: dict[int, int] = {}
    for k, row in enumerate(J):
        for column, entry in enumerate(row):
            alone = all(_is_zero(J[pivot][column]) for pivot in pivots)
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
        spread[column] = [share * J[k][free_column] for free_column in free]
        rest[column] = share * gamma[k]
    return _Reduced(pivots, [k for k in range(len(J)) if k not in pivots], spread, rest)


def _is_zero(entry: Any) -> bool:
    return isinstance(entry, float) and entry == 0.0


def independent(jacobians: np.ndarray) -> list[int]:
    """Return the rows that in some state do not follow from those before them."""
    every = list(range(jacobians.shape[1]))
    if any(_is_independent(J) for J in jacobians):
        return every
    kept: list[int] = []
    for row in every:
        trial = [*kept, row]
        if any(_is_independent(J[trial]) for J in jacobians):
            kept = trial
    return kept


def _is_independent(J: np.ndarray) -> bool:
    """Return whether the rows of a Jacobian in one state are independent."""
    sizes = np.linalg.norm(J, axis=1)
    if not len(J) or len(J) > J.shape[1] or sizes.min() <= 0:
        return not len(J)
    scaled = J / sizes[:, None]
    return bool(np.linalg.svd(scaled, compute_uv=False)[-1] > INDEPENDENT)


def _is_singular(masses: np.ndarray) -> bool:
    for M in masses:
        d = np.sqrt(np.diagonal(M))
        if d.min() <= 0 or np.linalg.eigvalsh(M / np.outer(d, d))[0] < INDEPENDENT:
            return True
    return False


def landing_of(letters: Letters, loops: Loops, constrained: Projecting) -> LoopProjection:
    """Return the changes of q and v that close the loops and their rates."""
    step: list[Any] = constrained.close(loops.residual)
    turn: list[Any] = constrained.close(loops.rate)
    # the rates of q are linear in v, so replacing v by the step gives the change of q
    along = {v.place: value_of(x) for v, x in zip(letters.v, step, strict=True)}
    moved = push_forward(letters.tape, values_of(letters.rates), along)
    changes = (*moved, *values_of(turn))
    gaps = tuple(values_of(loops.residual))
    return LoopProjection(changes, value_of(constrained.firmness()), gaps)
