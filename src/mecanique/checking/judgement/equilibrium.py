"""Judge positions of equilibrium: given by formulas, or by a condition on one coordinate."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, final

import numpy as np
import numpy.typing as npt

from mecanique.arrays import Array
from mecanique.checking.grammar.reader import Statement
from mecanique.checking.grammar.tape import Tape
from mecanique.checking.grammar.tree import Node, add, negate
from mecanique.checking.judgement.truth import Truth
from mecanique.derivation.scalars.evaluation import Evaluation
from mecanique.errors import FormulaError
from mecanique.model.random_positions import angles
from mecanique.model.units import characteristic_length

_BALANCED = 1e-9
"""Forces balance if they add up to less than this part of their usual size."""

_GRID = 721
"""Number of values of a coordinate between which sign changes of a condition are sought."""

_HALVINGS = 60
_WIDE = 6.0
"""Lengths are sought up to this many characteristic lengths."""


@final
class Positions:
    """The positions that some statements describe; coordinates that they omit are zero.

    Args:
        truth: the mechanism's own equations.
        text: the text of the statements.
    """

    def __init__(self, truth: Truth, text: str) -> None:
        self._truth = truth
        self._text = text
        sample = truth.sample
        still = dict.fromkeys(
            (*truth.mechanism.coordinates, *truth.velocities, *truth.accelerations),
            np.zeros(sample.count),
        )
        self._values: dict[str, Array] = {
            name: np.broadcast_to(np.asarray(value, dtype=float), (sample.count,))
            for name, value in {**sample.values, **still}.items()
        }

    @property
    def _count(self) -> int:
        return len(self._values["t"])

    def move(self, statements: Sequence[Statement]) -> None:
        """Move to the positions that the statements describe.

        Raises:
            FormulaError: if a statement does not describe positions, or has no solution.
        """
        given: set[str] = set()
        for statement in statements:
            left, right = statement.sides[0], statement.sides[-1]
            if left.kind == "letter" and left.name in self._truth.mechanism.coordinates:
                found = Tape(right).evaluate(self._values, self._count).whole
                self._values[left.name] = found
                given.add(left.name)
                self._keep(np.isfinite(found), statement)
        for statement in statements:
            left, right = statement.sides[0], statement.sides[-1]
            if not (left.kind == "letter" and left.name in given):
                root = left if len(statement.sides) == 1 else add(left, negate(right))
                self._solve(statement, root, given)

    def measure_forces(self) -> float:
        """Return the largest unbalanced force, relative to the usual size of forces."""
        derivation, sample = self._truth.derivation, self._truth.sample
        assert derivation is not None
        evaluated = Evaluation(derivation.algebra.ring, self._values)
        usual = np.abs(sample.bias - sample.forces).mean(0)
        left_over = np.zeros(self._count)
        for k, (h, Q) in enumerate(zip(derivation.h, derivation.Q, strict=True)):
            with np.errstate(all="ignore"):
                force = np.abs(np.broadcast_to(evaluated(h - Q), (self._count,)))
                left_over = np.fmax(left_over, force / max(usual[k], 1e-300))
        worst = float(left_over.max())
        return worst if worst > _BALANCED else 0.0

    def _keep(self, states: Array, statement: Statement) -> None:
        at = np.flatnonzero(states)
        if not len(at):
            raise FormulaError("the formula has a value at no state", self._text, statement.start)
        self._values = {name: value[at] for name, value in self._values.items()}

    def _solve(self, statement: Statement, root: Node, given: set[str]) -> None:
        """Move to all positions at which a condition on one coordinate holds."""
        mechanism = self._truth.mechanism
        free = sorted((root.letters & set(mechanism.coordinates)) - given)
        if len(free) != 1:
            raise FormulaError(
                "expected COORDINATE = FORMULA, e.g. q = 0, or a condition on one coordinate",
                self._text,
                statement.start,
            )
        (name,) = free
        reach = np.pi if name in angles(mechanism) else _WIDE * characteristic_length(mechanism)
        # an odd offset keeps the grid away from simple positions such as 0
        grid = np.linspace(-reach, reach, _GRID) + 0.000271 * reach
        tape = Tape(root)
        states, steps = np.repeat(np.arange(self._count), _GRID), np.tile(grid, self._count)
        table = self._evaluate(tape, name, states, steps).reshape(self._count, _GRID)
        with np.errstate(all="ignore"):
            turned = table[:, :-1] * table[:, 1:] < 0
        at, place = np.nonzero(turned)
        low, high = grid[place], grid[place + 1]
        first = table[at, place]
        for _ in range(_HALVINGS if len(at) else 0):
            middle = (low + high) / 2
            same = self._evaluate(tape, name, at, middle) * first > 0
            low, high = np.where(same, middle, low), np.where(same, high, middle)
        ends = self._evaluate(tape, name, at, low) if len(at) else first
        # a jump from one sign to the other is a pole, not a root
        roots = np.abs(ends) < np.abs(first) + 1e-300
        if not roots.any():
            raise FormulaError(
                f"the condition holds at no {name} of any state", self._text, statement.start
            )
        at, found = at[roots], low[roots]
        self._values = {other: value[at] for other, value in self._values.items()}
        self._values[name] = found

    def _evaluate(self, tape: Tape, name: str, states: npt.NDArray[Any], values: Array) -> Array:
        found = np.empty(len(values))
        for some in tape.blocks(len(values)):
            letters = {other: value[states[some]] for other, value in self._values.items()}
            letters[name] = values[some]
            found[some] = tape.evaluate(letters, len(letters[name])).whole
        return found
