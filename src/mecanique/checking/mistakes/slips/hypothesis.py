"""A mistake with the equations it leads to, and the right equations that it changes."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import final

import numpy as np

from mecanique.arrays import Array
from mecanique.checking.judgement.truth import Sample, Truth
from mecanique.derivation import derive
from mecanique.derivation.printing.equations import expression
from mecanique.derivation.scalars.evaluation import Evaluation
from mecanique.derivation.scalars.series import Series
from mecanique.derivation.symbolic.derivation import Derivation
from mecanique.errors import MecaniqueError
from mecanique.model.mechanism import Mechanism


@final
@dataclass(frozen=True, eq=False)
class Hypothesis:
    """A mistake in the whole derivation or in one term, with the equations it leads to.

    Args:
        kind: kind of the mistake.
        text: the mistake in words; "{}" stands for the term.
        weight: the smaller, the likelier.
        M: mass matrix, shape (n, nv, nv).
        rest: bias minus forces, shape (n, nv).
        row: index of the changed equation; −1 for all.
        term: the changed term, if there is only one.
        released: indices of the constraints whose forces are left out.
    """

    kind: str
    text: str
    weight: float
    M: Array
    rest: Array
    row: int = -1
    term: Series | None = None
    released: tuple[int, ...] = ()

    @property
    def sentence(self) -> str:
        """The mistake in words."""
        return self.text.format("" if self.term is None else expression(self.term).text())


@final
class RightEquations:
    """The right equations M a + rest = 0 in the states, and those of changed mechanisms.

    With loops or contacts they are those of the tree, without multipliers.

    Args:
        truth: the right equations in closed form.
        derivation: the closed form.
    """

    def __init__(self, truth: Truth, derivation: Derivation) -> None:
        self.truth = truth
        self.derivation = derivation
        self.sample: Sample = truth.sample
        self.rest = self.sample.bias - self.sample.forces

    @cached_property
    def _evaluated(self) -> Evaluation:
        return Evaluation(self.derivation.algebra.ring, self.sample.values)

    def value(self, series: Series) -> Array:
        """Return the values of a series, shape (n,)."""
        return np.broadcast_to(self._evaluated(series), (self.sample.count,))

    def stack(self, rows: Sequence[Sequence[Series]]) -> Array:
        """Return the values of a matrix of series, shape (n, rows, columns)."""
        return np.stack([self._stack_row(row) for row in rows], axis=1)

    def _stack_row(self, row: Sequence[Series]) -> Array:
        return np.stack([self.value(entry) for entry in row], axis=-1)

    def rebuild(self, mechanism: Mechanism) -> tuple[Array, Array] | None:
        """Return M and bias − forces of a changed mechanism in the same states."""
        try:
            derivation = derive(replace(mechanism, loops=(), contacts=())).derivation
        except MecaniqueError:
            return None
        if derivation.algebra.velocities != self.truth.velocities:
            return None
        return self.evaluate(derivation, Evaluation(derivation.algebra.ring, self.sample.values))

    def evaluate(self, derivation: Derivation, evaluated: Evaluation) -> tuple[Array, Array]:
        """Return M and bias − forces of a derivation for some values of its letters."""
        n, nv = self.sample.count, len(derivation.M)
        M, rest = np.empty((n, nv, nv)), np.empty((n, nv))
        with np.errstate(all="ignore"):
            for i, entries in enumerate(derivation.M):
                for j, entry in enumerate(entries):
                    M[:, i, j] = evaluated(entry)
                rest[:, i] = evaluated(derivation.h[i]) - evaluated(derivation.Q[i])
        return M, rest


def group_by_velocities(series: Series, velocities: Sequence[str]) -> dict[tuple[int, ...], Series]:
    """Return the parts of a series by powers of the velocities."""
    ring = series.ring
    found = {}
    for powers, part in series.coefficients(velocities).items():
        whole = part
        for name, power in zip(velocities, powers, strict=True):
            whole = whole * ring[name] ** power if power else whole
        found[powers] = whole
    return found
