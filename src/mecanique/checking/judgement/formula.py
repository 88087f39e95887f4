"""Judge formulas of single quantities: energies, momenta, matrices, frequencies and the like."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from itertools import permutations
from typing import final

import numpy as np

from mecanique.arrays import Array
from mecanique.checking.grammar.reader import Statement
from mecanique.checking.grammar.tape import Tape
from mecanique.checking.grammar.tree import Node, add, letter, negate
from mecanique.checking.judgement.equilibria import judge_positions
from mecanique.checking.judgement.motion import TOLERANCE, Residual
from mecanique.checking.judgement.quantities import Quantity
from mecanique.checking.judgement.truth import Sample, Truth
from mecanique.derivation.scalars.evaluation import Evaluation
from mecanique.derivation.scalars.series import Series
from mecanique.errors import FormulaError


@final
@dataclass(frozen=True, eq=False)
class Judged:
    """A formula with its difference from the truth."""

    statement: Statement
    # left minus right, for the search for mistakes; None if there is no such search
    residual: Residual | None
    worst: float  # the largest relative difference
    forms: tuple[str, ...] = ()  # its deviations from the requested form
    root: Node | None = None  # the expression that a proof must show to be zero, or constant
    # definitions of further letters in it
    series: Mapping[str, Series] = field(default_factory=dict)
    fault: str = ""  # why it is no answer although it is true, or empty
    covers: frozenset[int] = frozenset()  # which of several values it holds for
    missing: tuple[str, ...] = ()  # what the whole answer lacks, in words

    @property
    def holds(self) -> bool:
        """Whether it is right."""
        return self.worst <= TOLERANCE and not self.fault


def judge_formula(
    statements: Sequence[Statement], truth: Truth, quantity: Quantity, text: str
) -> list[Judged]:
    """Judge each formula."""
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
        judged = _judge_residual(one, worst, quantity.series)
        fault = _find_emptiness(one, known, alone=quantity.again is None)
        found.append(replace(judged, fault=fault) if judged.holds and fault else judged)
    return found


def _find_emptiness(one: Residual, known: Mapping[str, Array], *, alone: bool = True) -> str:
    """Return why an equation that holds does not determine the letters in question, "" if it does.

    Args:
        one: the equation.
        known: the true values of the letters.
        alone: whether it must hold for these values alone, in each state.
    """
    if not one.statement.is_equation:
        return ""
    count, tables = one.sample.count, []
    for factor in _FACTORS:
        moved = {**one.sample.values, **{name: factor * value for name, value in known.items()}}
        values = one.tape.evaluate(moved, count)
        with np.errstate(all="ignore"):
            changed = np.where(values.size > 0, values.whole / values.size, 0.0)
        tables.append(np.where(np.abs(changed) > TOLERANCE, changed, 0.0))
    signs = np.sign(np.nan_to_num(np.stack(tables)))
    if not signs.any():
        return "it holds for any value of the quantity in question"
    below, above = (signs[:5], signs[5:])
    if alone and (signs[4] * signs[5] > 0).mean() > 0.5:
        return "it only touches zero: a square or a magnitude does not determine a quantity"
    if alone and any((side.min(0) * side.max(0) < 0).any() for side in (below, above)):
        return "it holds for other values, too"
    return ""


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
_CONSTANT = 1e-12
"""What changes less than this part of its terms in a second is constant."""

_FACTORS = np.array([1e-3, 0.03, 0.3, 0.7, 0.9, 1.1, 1.4, 3.0, 30.0, 1e3])
"""What the quantity in question is multiplied by, to see that an equation holds for it alone."""

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
        if len(moving) > 1:
            formula = add(formula, negate(moving[1]).at(moving[1].start, moving[1].end))
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
        fault = ""
        if formula.letters & {*truth.accelerations, *truth.multipliers}:
            fault = "a conserved quantity depends on positions and velocities, not on accelerations"
        elif not (size > _CONSTANT * values.size).any():
            fault = "it does not depend on the motion at all"
        found.append(Judged(statement, None, worst, root=formula, fault=fault))
    return found


def _judge_several(
    statements: Sequence[Statement], truth: Truth, quantity: Quantity, text: str
) -> list[Judged]:
    """Judge frequencies; periods and frequencies in 1/s are converted."""
    assert quantity.values is not None
    found = []
    for statement in statements:
        tried: list[Residual] = []
        used = []
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
            used.append(known)
        covers = frozenset(k for k, one in enumerate(tried) if one.worst <= TOLERANCE)
        k = min(range(len(tried)), key=lambda k: tried[k].worst)
        # an equation of several frequencies holds for each of them
        fault = _find_emptiness(tried[k], used[k], alone=len(tried) == 1) if covers else ""
        found.append(Judged(statement, tried[k], tried[k].worst, fault=fault, covers=covers))
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
        judged = _judge_residual(one, one.worst, quantity.series)
        fault = _find_emptiness(one, known, alone=False) if judged.holds else ""
        found.append(replace(judged, fault=fault))
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
    """Judge positions: forces must balance at each of them, and all must be named."""
    positions, missing = judge_positions(statements, truth, text)
    found = []
    for position in positions:
        for statement in position.statements:
            fault = "" if position.worst else position.fault
            found.append(Judged(statement, None, position.worst, fault=fault))
    if missing:
        found[0] = replace(found[0], missing=tuple(missing))
    return found
