"""Judge formulas of single quantities: energies, momenta, matrices, frequencies and the like."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from itertools import permutations
from typing import Any, final

import numpy as np
import numpy.typing as npt

from mecanique.arrays import Array
from mecanique.checking.grammar.reader import Statement
from mecanique.checking.grammar.tape import Tape
from mecanique.checking.grammar.tree import Node, add, letter, negate
from mecanique.checking.judgement.motion import TOLERANCE, Residual
from mecanique.checking.judgement.quantities import Quantity
from mecanique.checking.judgement.truth import Sample, Truth
from mecanique.derivation.scalars.evaluation import Evaluation
from mecanique.derivation.scalars.series import Series
from mecanique.errors import FormulaError
from mecanique.model.mechanism_units import characteristic_length
from mecanique.model.random_positions import angles

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


@final
@dataclass(frozen=True, eq=False)
class Judged:
    """A formula with its difference from the truth.

    Args:
        statement: the line.
        residual: left minus right, for the search for mistakes; None if there is no such search.
        worst: the largest relative difference.
        forms: its deviations from the requested form.
        root: the expression that a proof must show to be zero, or constant.
        series: definitions of further letters in it.
    """

    statement: Statement
    residual: Residual | None
    worst: float
    forms: tuple[str, ...] = ()
    root: Node | None = None
    series: Mapping[str, Series] = field(default_factory=dict)

    @property
    def holds(self) -> bool:
        """Whether it is right."""
        return self.worst <= TOLERANCE


def judge_formula(
    statements: Sequence[Statement], truth: Truth, quantity: Quantity, text: str
) -> list[Judged]:
    """Judge each formula.

    Raises:
        FormulaError: if a formula is not of the requested kind.
    """
    judge = {
        "matrix": _judge_matrix,
        "conserved": _judge_constant,
        "several": _judge_several,
        "equilibrium": _judge_equilibrium,
        "letters": _judge_letters,
        "free body": _judge_free_body,
    }.get(quantity.kind, _judge_value)
    return judge(statements, truth, quantity, text)


def _judge_value(
    statements: Sequence[Statement], truth: Truth, quantity: Quantity, text: str
) -> list[Judged]:
    sample = truth.sample
    assert quantity.values is not None
    found = []
    known = dict.fromkeys(quantity.letters, quantity.values)
    for statement in statements:
        one = _residual(statement, truth, sample, known, quantity.letters[0], text)
        worst = one.worst if quantity.again is None else _compare_changes(one, sample, quantity)
        found.append(_judge_residual(one, worst, quantity.series))
    return found


def _compare_changes(one: Residual, sample: Sample, quantity: Quantity) -> float:
    """How far the change between two states is from the truth; a constant is left open."""
    assert quantity.again is not None
    other_values, letters = quantity.again
    other = {**letters, **dict.fromkeys(quantity.letters, other_values)}
    moved = one.tape.evaluate(other, sample.count)
    with np.errstate(all="ignore"):
        difference = np.abs(one.values.whole - moved.whole)
        relative = difference / np.maximum(one.values.size, moved.size)
    return float(np.nanmax(np.where(np.isfinite(relative), relative, 0.0)))


def _judge_residual(
    one: Residual, worst: float, series: Mapping[str, Series], forms: tuple[str, ...] = ()
) -> Judged:
    """Judge a formula by left minus right."""
    return Judged(
        statement=one.statement,
        residual=one,
        worst=worst,
        forms=forms,
        root=one.root,
        series=series,
    )


def _residual(
    statement: Statement,
    truth: Truth,
    sample: Sample,
    known: Mapping[str, Array],
    name: str,
    text: str,
) -> Residual:
    """Return left minus right, with the quantity's true value on the left of a mere formula."""
    sides = statement.sides
    other = sides[1] if len(sides) > 1 else letter(name).at(sides[0].end, sides[0].end)
    root = add(sides[0], negate(other).at(other.start, other.end))
    if any(node.kind == "table" for node in root.walk()):
        raise FormulaError("expected a formula, got a matrix", text, root.start)
    tape = Tape(root)
    # letters of the mechanism keep their own meaning
    values = {**known, **sample.values}
    if len(sides) == 1:
        values[name] = known[name]
    sample = replace(sample, values=values)
    return Residual(
        statement=statement,
        root=root,
        tape=tape,
        values=tape.evaluate(values, sample.count),
        truth=truth,
        sample=sample,
    )


def _judge_matrix(
    statements: Sequence[Statement], truth: Truth, quantity: Quantity, text: str
) -> list[Judged]:
    table = _find_table(statements)
    true, nv = quantity.values, len(truth.velocities)
    assert true is not None
    statement = statements[0]
    if table is None and nv > 1:
        raise FormulaError(
            "expected a matrix, e.g. [[a, b], [b, c]] or \\begin{pmatrix}", text, statement.start
        )
    entries = statement.sides[-1:] if table is None else table.parts
    if len(entries) != nv * nv:
        raise FormulaError(
            f"expected a matrix of {nv} × {nv}, got {len(entries)} entries", text, statement.start
        )
    sample = truth.sample
    given, sizes = [], []
    for entry in entries:
        values = Tape(entry).evaluate(sample.values, sample.count)
        given.append(values.whole)
        sizes.append(values.size)
    M = np.stack(given, axis=-1).reshape(sample.count, nv, nv)
    size = np.stack(sizes, axis=-1).reshape(sample.count, nv, nv)
    size = np.maximum(size, np.sqrt(np.einsum("nii,njj->nij", true, true)))
    if _worst(np.abs(M - true) / size) > TOLERANCE:
        for order in permutations(range(nv)) if nv <= _MOST_ORDERED else ():
            there = true[:, order][:, :, order]
            if _worst(np.abs(M - there) / size) <= TOLERANCE:
                names = ", ".join(truth.velocities[k] for k in order)
                return [Judged(statement, None, 0.0, (f"in the order {names}",))]
    judged = []
    for k, entry in enumerate(entries):
        i, j = divmod(k, nv)
        far = _worst(np.abs(M - true)[:, i, j] / size[:, i, j])
        place = replace(statement, sides=(entry,), text=_quote(entry, text, i, j))
        one = _of_entry(entry, place, truth, true[:, i, j])
        series = {_ENTRY: quantity.series[str(k)]}
        judged.append(_judge_residual(one, far, series))
    return judged


_MOST_ORDERED = 4
_ENTRY = "#entry"
_NOTHING = "#nothing"


def _of_entry(entry: Node, place: Statement, truth: Truth, true: Array) -> Residual:
    return _residual(place, truth, truth.sample, {_ENTRY: true}, _ENTRY, "")


def _quote(entry: Node, text: str, i: int, j: int) -> str:
    return f"entry {i + 1}, {j + 1}: {' '.join(text[entry.start : entry.end].split())}"


def _worst(relative: Array) -> float:
    known = relative[np.isfinite(relative)]
    return float(known.max(initial=0.0)) if len(known) else np.inf


def _find_table(statements: Sequence[Statement]) -> Node | None:
    for statement in statements:
        for side in statement.sides:
            if side.kind == "table":
                return side
    return None


def _judge_constant(
    statements: Sequence[Statement], truth: Truth, quantity: Quantity, text: str
) -> list[Judged]:
    """Judge conserved quantities: their rate in true motions is zero, but they are not constant."""
    sample = truth.sample
    derivation = truth.derivation
    assert derivation is not None
    ring = derivation.algebra.ring
    evaluated = Evaluation(ring, sample.values)
    rates = {"t": np.ones(sample.count)}
    for name in truth.mechanism.coordinates:
        rates[name] = np.broadcast_to(evaluated(ring.rates[ring.index(name)]), (sample.count,))
    for name, row in zip(truth.velocities, sample.a.T, strict=True):
        rates[name] = row
    found = []
    for statement in statements:
        moving = [side for side in statement.sides if side.letters & rates.keys()]
        formula = moving[0] if moving else statement.sides[-1]
        if formula.letters & set(quantity.letters) - sample.values.keys():
            raise FormulaError(
                "expected a formula in the letters of the system", text, formula.start
            )
        tape = Tape(formula)
        values = tape.evaluate(sample.values, sample.count)
        slopes = tape.slopes(values)
        parts = [tape.along(slopes, name) * rate for name, rate in rates.items()]
        total = np.abs(sum(parts[1:], parts[0]))
        size = sum((np.abs(part) for part in parts), np.zeros(sample.count))
        with np.errstate(all="ignore"):
            relative = total / size
        worst = _worst(np.where(size > 0, relative, 0.0))
        constant = not (size > 0).any()
        forms = ("it does not depend on the motion at all",) if constant else ()
        found.append(Judged(statement, None, worst, forms, formula))
    return found


def _judge_several(
    statements: Sequence[Statement], truth: Truth, quantity: Quantity, text: str
) -> list[Judged]:
    """Judge frequencies; periods and frequencies in 1/s are converted."""
    assert quantity.values is not None
    found = []
    for statement in statements:
        tried = []
        for omega in quantity.values:
            with np.errstate(all="ignore"):
                period = 2 * np.pi / omega
            known = dict.fromkeys(quantity.letters, omega)
            for name in quantity.letters:
                if name.startswith(("f", "nu")):
                    known[name] = omega / (2 * np.pi)
                elif name.startswith("T"):
                    known[name] = period
            tried.append(
                _residual(statement, truth, truth.sample, known, quantity.letters[0], text)
            )
        best = min(tried, key=lambda one: one.worst)
        found.append(Judged(statement, best, best.worst))
    return found


def _judge_letters(
    statements: Sequence[Statement], truth: Truth, quantity: Quantity, text: str
) -> list[Judged]:
    """Judge equations that must hold with the true values of the letters in question."""
    assert quantity.values is not None
    known = dict(zip(quantity.letters, quantity.values, strict=True))
    found = []
    for statement in statements:
        if not statement.is_equation:
            names = ", ".join(quantity.letters)
            raise FormulaError(f"expected an equation for one of {names}", text, statement.start)
        one = _residual(statement, truth, truth.sample, known, "", text)
        found.append(_judge_residual(one, one.worst, quantity.series))
    return found


def _judge_free_body(
    statements: Sequence[Statement], truth: Truth, quantity: Quantity, text: str
) -> list[Judged]:
    """Judge equations that must hold with the true forces; some may hold only at rest."""
    assert quantity.values is not None
    assert quantity.again is not None
    count = truth.sample.count
    nothing = np.zeros(count)
    known = {_NOTHING: nothing, **dict(zip(quantity.letters, quantity.values, strict=True))}
    forces, letters = quantity.again
    still = {**letters, _NOTHING: nothing, **dict(zip(quantity.letters, forces, strict=True))}
    body = quantity.name.partition(" of ")[2]
    assert quantity.derivation is not None
    series = {_NOTHING: quantity.derivation.algebra.ring.number(0), **quantity.series}
    foreign = _forces_elsewhere(truth, body, quantity.letters)
    found = []
    for statement in statements:
        one = _residual(statement, truth, truth.sample, known, _NOTHING, text)
        named = sorted(one.root.letters & foreign)
        forms = [f"{name} does not act on {body}" for name in named]
        worst = one.worst
        moving = {*truth.velocities, *truth.accelerations}
        if worst > TOLERANCE and not one.root.letters & moving:
            at_rest = one.tape.evaluate(still, count)
            with np.errstate(all="ignore"):
                relative = _worst(np.abs(at_rest.whole) / at_rest.size)
            if relative <= TOLERANCE:
                worst = relative
                forms.append("it holds at rest only: the inertia forces are missing")
        found.append(_judge_residual(one, worst, series, tuple(forms)))
    return found


def _forces_elsewhere(truth: Truth, body: str, names: Sequence[str]) -> set[str]:
    """Return the named reactions in joints that are not at a body."""
    joints = [j.name for j in truth.mechanism.joints if body not in (j.parent, j.child)]
    prefixes = tuple(f"{letter}_{joint}_" for letter in "RMSC" for joint in joints)
    return {name for name in names if f"{name}_".startswith(prefixes)}


def _judge_equilibrium(
    statements: Sequence[Statement], truth: Truth, quantity: Quantity, text: str
) -> list[Judged]:
    """Judge positions: forces must balance at each of them."""
    positions = Positions(truth, text)
    positions.move(statements)
    worst = positions.measure_forces()
    return [Judged(statement, None, worst) for statement in statements]
