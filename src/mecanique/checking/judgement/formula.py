"""Judge formulas of single quantities: energies, momenta, matrices, frequencies and the like."""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import partial
from itertools import chain, pairwise, permutations
from types import MappingProxyType
from typing import final

import numpy as np

from mecanique.arrays import Array
from mecanique.checking.grammar.letters import KnownLetters
from mecanique.checking.grammar.mathml import is_mathml, text_of
from mecanique.checking.grammar.reader import Statement, name_values, part_chains
from mecanique.checking.grammar.scanner import BOTH_SIGNS
from mecanique.checking.grammar.tape import FormulaTape, find_rounding
from mecanique.checking.grammar.tree import (
    Node,
    add,
    call,
    letter,
    negate,
    number,
    rate,
    substitute,
)
from mecanique.checking.judgement.equilibria import judge_positions
from mecanique.checking.judgement.motion import EQUATION_HOLDS, Residual, count_rank, residuals
from mecanique.checking.judgement.quantities import (
    ACROSS,
    ENERGIES,
    AskedQuantity,
    by_momentum,
    measure,
)
from mecanique.checking.judgement.steady import SteadyMotions
from mecanique.checking.judgement.truth import Sample, Truth
from mecanique.derivation.scalars.series import Series
from mecanique.derivation.symbolic.lagrange import Lagrange
from mecanique.errors import FormulaError, InputError


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
    missing: tuple[str, ...] = ()  # what the whole answer lacks, in words
    rounding: str = ""  # the rounded number that explains a small difference
    proven: bool = False  # whether algebra proves it
    # what it says about each unknown that is asked for, shape (k, unknowns)
    says: Array = field(default_factory=lambda: np.ones((1, 1)))

    @property
    def agrees(self) -> bool:
        """Whether it is true, up to rounding."""
        return self.worst <= EQUATION_HOLDS or bool(self.rounding)

    @property
    def holds(self) -> bool:
        """Whether it is right."""
        return self.agrees and not self.fault


def judge_formula(
    statements: Sequence[Statement], truth: Truth, quantity: AskedQuantity, text: str
) -> list[Judged]:
    """Judge each formula."""
    quantity = quantity.meant_by(statements)
    judge = {
        "motion": _judge_motion,
        "matrix": _judge_matrix,
        "conserved": _judge_constant,
        "equilibrium": _judge_equilibrium,
        "free body": _judge_free_body,
        "rates of momenta": _judge_canonical,
        "steady": _judge_steady,
    }.get(quantity.kind, _judge_value)
    if quantity.kind in ("motion", "matrix", "conserved", "equilibrium"):
        return judge(statements, truth, quantity, text)
    judged = judge(part_chains(statements, text), truth, quantity, text)
    if quantity.kind not in ("several", "steady"):
        return _refuse_either(judged, text, count_independent)
    # with ±, several begin at one place, and are to be different
    begun = Counter(statement.start for statement in statements)
    chains = {s.start for s in statements if len(s.sides) > 2 and begun[s.start] == 1}
    return _compare_sides(judged, chains)


_EITHER = re.compile(r"\b(?:or|oder|ou|o|either)\b")


def _refuse_either(
    judged: list[Judged], text: str, count: Callable[[Sequence[Judged]], int]
) -> list[Judged]:
    """Return formulas, with a fault where "or" leaves open which of two different ones holds."""
    text = text_of(text) if is_mathml(text) else text
    for k, (first, second) in enumerate(pairwise(judged), 1):
        end = first.statement.start + len(first.statement.text)
        either = _EITHER.search(text[end : second.statement.start])
        if either and first.holds and second.holds and count((first, second)) > 1:
            fault = f"{either[0]!r} leaves open which of two equations holds: write both"
            judged[k] = replace(second, fault=fault)
    return judged


def _compare_sides(judged: list[Judged], chains: Collection[int]) -> list[Judged]:
    """Return formulas, with a fault where two sides of a chain are two of the true values."""
    for k, (first, second) in enumerate(pairwise(judged), 1):
        chained = first.statement.start == second.statement.start in chains
        if chained and first.holds and second.holds and not (first.says @ second.says.T).any():
            judged[k] = replace(second, fault="it is another value than the side before it")
    return judged


def _judge_motion(
    statements: Sequence[Statement], truth: Truth, _: AskedQuantity, text: str
) -> list[Judged]:
    """Judge equations of motion at the true accelerations."""
    equations = residuals(statements, truth, truth.sample, text)
    judged = [replace(_judge_residual(e), fault=e.emptiness if e.holds else "") for e in equations]
    return _refuse_either(judged, text, _count_of_motion)


def _count_of_motion(judged: Sequence[Judged]) -> int:
    return count_rank([formula.residual for formula in judged if formula.residual])


def _judge_value(
    statements: Sequence[Statement], truth: Truth, quantity: AskedQuantity, text: str
) -> list[Judged]:
    """Judge formulas with the true values of the letters in question.

    Of several values, such as frequencies, each must be among the answers.
    """
    cases = _list_cases(quantity)
    letters = quantity.letters
    several = len(cases) > 1
    needed = list_oscillating(quantity) if several else []
    by_letter = quantity.kind == "letters"
    fixed = {**quantity.more} if by_letter or quantity.kind == "several" else {}
    fixed |= cases[0] if by_letter else {}
    all_judged: list[Judged] = []
    statements, helpers = _insert_values(statements, letters if quantity.kind == "several" else ())
    for statement in statements:
        if several and statement.sides[0].name in truth.mechanism.coordinates.names:
            raise FormulaError(
                f"{statement.text!r} is a position; it belongs to the question, as in "
                f"--ask 'frequency at {statement.text}'",
                text,
                statement.start,
            )
        if by_letter:
            _refuse_formula(statement, f"one of {', '.join(letters)}", text)
        # a number alone says by its unit what it is
        measured = [name for unit, name in _MEASURES if unit.search(statement.text)]
        name = ([name for name in measured if name in letters] or [*letters, ""])[0]
        tried: list[Judged] = []
        for values in cases:
            residual = _residual(statement, truth, values, name, text, fixed)
            judged = _judge_residual(residual, quantity.series)
            if quantity.again is not None:
                judged = replace(judged, worst=_compare_changes(residual, truth.sample, quantity))
            elif not judged.holds:
                rounding = find_rounding(residual.tape, residual.values, text)
                judged = replace(judged, rounding=rounding)
            tried.append(judged)
        covers = [k for k, judged in enumerate(tried) if judged.agrees]
        signed = any(signs in statement.text for signs in BOTH_SIGNS)
        if quantity.kind == "several" and not covers and signed:
            again = (
                _residual(statement, truth, _mirror(values), name, text, fixed) for values in cases
            )
            if any(_judge_residual(residual).agrees for residual in again):
                continue  # of ± the other root, whose frequency is the same
        judged, values = min(zip(tried, cases, strict=True), key=lambda pair: pair[0].worst)
        best = judged.residual
        assert best is not None, "it is judged by one"
        if covers:
            others = [cases[k] for k in covers if cases[k] is not values]
            places = {name: k for k, name in enumerate(letters) if by_letter}
            roots, free = [values, *others], quantity.again is not None
            signed = quantity.name in ENERGIES
            fault = _find_emptiness(best, letters, roots, places, open_constant=free, signed=signed)
            judged = replace(judged, fault=fault or _find_limit(best))
        if several:
            judged = replace(judged, says=np.eye(len(cases))[covers][:, needed])
        elif by_letter:
            judged = replace(judged, says=_slopes_of(best, quantity.needed or letters))
        all_judged.append(_judge_form(judged, best, truth, quantity))
    # ω0 = √(k/m) may only be what the damped frequency is written with
    aside = {*map(id, helpers)}
    kept = [judged for judged in all_judged if judged.agrees or id(judged.statement) not in aside]
    all_judged = kept or all_judged
    kind = "frequencies" if several else "equations"
    return _tell_missing(all_judged, kind) if several or quantity.needed else all_judged


def list_oscillating(quantity: AskedQuantity) -> list[int]:
    """Return the frequencies that an answer must name: not zero, that of a motion as a whole."""
    assert quantity.values is not None
    size = np.abs(quantity.values).max(axis=1)
    moving = np.flatnonzero(size > _STILL * size.max())
    return [*map(int, moving)] or [*range(len(size))]


_STILL = 1e-6
"""A frequency below this part of the largest is zero."""

_HELPER = re.compile(r"(?:omega|w|f|nu|T)[0n]")
"""Letters of frequencies that others are written with."""


def _insert_values(
    statements: Sequence[Statement], letters: Sequence[str]
) -> tuple[list[Statement], list[Statement]]:
    """Return answers with what they give for letters in place of these in others.

    With them come those that may be no answers themselves.
    """
    inserted, helpers = [*statements], list[Statement]()
    for k, statement in enumerate(statements):
        first, formula = statement.sides[0], inserted[k].sides[-1]
        if first.kind == "power" and first.parts[1].value == 2:
            first, formula = first.parts[0], call("sqrt", formula)
        name = first.name if first.kind == "letter" else ""
        if name not in letters or not statement.is_equation or name in formula.letters:
            continue
        for other, (left, *rest) in ((i, line.sides) for i, line in enumerate(inserted)):
            if other != k and any(name in side.letters for side in rest):
                rest = [substitute(side, name, formula) for side in rest]
                inserted[other] = replace(inserted[other], sides=(left, *rest))
                helpers += [inserted[k]] if _HELPER.fullmatch(name) else []
    # a later line may have changed the one that is kept
    texts = {helper.text for helper in helpers}
    return inserted, [line for line in inserted if line.text in texts]


def _mirror(values: Mapping[str, Array]) -> dict[str, Array]:
    """Return the values of the other sign."""
    return {name: -value for name, value in values.items()}


def count_independent(judged: Sequence[Judged]) -> int:
    """Return how many unknowns those of some formulas that hold determine."""
    rows = [formula.says for formula in judged if formula.holds]
    if not rows or not (table := np.concatenate(rows)).size:
        return 0
    size = np.abs(table).max(axis=1, initial=1e-300, keepdims=True)
    return int(np.linalg.matrix_rank(table / size))


def _tell_missing(judged: list[Judged], what: str) -> list[Judged]:
    """Return formulas, of which the first tells how many that are asked for are missing."""
    needed = judged[0].says.shape[1]
    if lacking := needed - count_independent(judged):
        judged[0] = replace(judged[0], missing=(f"{lacking} of {needed} {what} missing",))
    return judged


def _list_cases(quantity: AskedQuantity) -> list[Mapping[str, Array]]:
    """Return the true values of the letters in question, several of frequencies."""
    assert quantity.values is not None
    match quantity.kind:
        case "several":
            return [measure(omega, quantity.letters) for omega in quantity.values]
        case "letters":
            return [dict(zip(quantity.letters, quantity.values, strict=True))]
    return [{**dict.fromkeys(quantity.letters, quantity.values), **quantity.more}]


def _refuse_formula(statement: Statement, what: str, text: str) -> None:
    if not statement.is_equation:
        raise FormulaError(f"expected an equation for {what}", text, statement.start)


def _refuse_letters(formula: Node, names: set[str], text: str) -> None:
    if formula.letters & names:
        raise FormulaError("expected a formula in the letters of the system", text, formula.start)


def _judge_form(
    judged: Judged, residual: Residual, truth: Truth, quantity: AskedQuantity
) -> Judged:
    """Return a Hamiltonian in rates with that form, and another Lagrangian of the same motion."""
    rates = sorted(residual.root.letters & set(truth.velocities))
    if quantity.name == "Hamiltonian" and judged.agrees and rates:
        return replace(judged, forms=(f"in {', '.join(rates)}, not in momenta alone",))
    lagrangian = quantity.name == "Lagrangian" and not judged.agrees
    if lagrangian and is_equivalent(residual, truth, quantity.letters):
        return replace(judged, worst=0.0, root=None)
    return judged


def _find_emptiness(
    residual: Residual,
    names: Sequence[str],
    roots: Sequence[Mapping[str, Array]],
    places: Mapping[str, int] = MappingProxyType({}),
    *,
    open_constant: bool = False,
    signed: bool = False,
) -> str:
    """Return why an equation that holds does not determine its letters, "" if it does.

    Where they are multiplied by the same factor, it must change its sign at each of the true
    values, the roots, and nowhere else; up to a constant, so must its difference from the true one.
    """
    statement, known = residual.statement, {name: roots[0][name] for name in names}
    # a mere formula is said to be equal to the quantity, and may contain its letter as well
    if not statement.is_equation and not statement.sides[0].letters & known.keys():
        return ""
    first = next((name for name in names if name in residual.root.letters), names[0])
    others = [root[first] for root in roots[1:] if not np.array_equal(root[first], known[first])]
    rows = []
    for factor in _FACTORS:
        moved = {}
        for name, value in known.items():
            # of several quantities each is changed otherwise, or R1 = R2 would say nothing
            step = (factor - 1) * (1 - 0.5 * places.get(name, 0) / len(known))
            moved[name] = value + step * np.where(value == 0, 1.0, value)
        values = residual.evaluate(moved)
        changed = values.whole - (residual.values.whole if open_constant else 0.0)
        seen = np.abs(changed) > EQUATION_HOLDS * np.maximum(values.size, residual.values.size)
        side = np.sign(factor - 1) * np.prod([np.sign(moved[first] - x) for x in others], axis=0)
        rows.append(np.where(seen, side * changed, 0.0))
    table = np.nan_to_num(np.array(rows))
    if not table.any():
        return "it holds for any value of the quantity in question"
    above, start = np.searchsorted(_FACTORS, (1.0, 0.0))
    if (table[above - 1] * table[above] < 0).mean() > 0.5:
        return "it only touches zero: a square or a magnitude does not determine a quantity"
    # of several letters, as in R = m g − abs(F), each may stand within a magnitude
    alone = not places or len(residual.root.letters & known.keys()) == 1
    if signed or (alone and (np.stack([*known.values()]) < 0).any()):
        # at a pole at zero it grows before it changes its sign
        pole = np.abs(table[start - 1]) > np.abs(table[start - 2])
        table[:start] *= np.where(pole & (table[start - 1] * table[start] < 0), -1.0, 1.0)
        start = 0
    if (table[start:].min(axis=0) * table[start:].max(axis=0) < 0).any():
        return "it holds for other values, too"
    return ""


def _find_limit(residual: Residual) -> str:
    """Return why the conditions under which a formula is said to hold are wrong, "" if none is."""
    sample, known = residual.sample, np.isfinite(residual.values.whole)
    for condition in residual.statement.conditions:
        holds = condition.holds(sample.values, sample.count)
        if not (holds & known).any():
            return f"there is none where {condition.said}"
        if (known & ~holds).any():
            return f"it holds not only where {condition.said}"
    return ""


def _compare_changes(residual: Residual, sample: Sample, quantity: AskedQuantity) -> float:
    """How far the change between two states is from the truth; a constant is left open."""
    assert quantity.again is not None
    other_values, letters = quantity.again
    moved_letters = {**dict.fromkeys(quantity.letters, other_values), **letters}
    moved = residual.tape.evaluate(moved_letters, sample.count)
    difference = np.abs(residual.values.whole - moved.whole)
    relative = difference / np.maximum(residual.values.size, moved.size)
    return float(np.nanmax(np.where(np.isfinite(relative), relative, 0.0)))


def _judge_residual(
    residual: Residual, series: Mapping[str, Series] = MappingProxyType({})
) -> Judged:
    """Judge a formula by left minus right."""
    return Judged(residual.statement, residual, residual.worst, root=residual.root, series=series)


def _residual(
    statement: Statement,
    truth: Truth,
    known: Mapping[str, Array],
    name: str,
    text: str,
    fixed: Mapping[str, Array] | None = None,
) -> Residual:
    """Return left minus right, with the quantity's true value on the left of a mere formula."""
    sides = statement.sides
    right = sides[1] if len(sides) > 1 else letter(name).at(sides[0].end, sides[0].end)
    root = add(sides[0], negate(right).at(right.start, right.end))
    if any(node.kind == "table" for node in root.walk()):
        raise FormulaError("expected a formula, got a matrix", text, root.start)
    # letters of the mechanism keep their own meaning
    values = {**known, **truth.sample.values, **(fixed or {})}
    if len(sides) == 1:
        values[name] = known[name]
    return Residual(statement, root, truth, replace(truth.sample, values=values))


def _judge_matrix(
    statements: Sequence[Statement], truth: Truth, quantity: AskedQuantity, text: str
) -> list[Judged]:
    """Judge every matrix, of one coordinate also every formula, entry by entry."""
    sides = [(line, side) for line in statements for side in line.sides]
    tables = [(line, side.parts) for line, side in sides if side.kind == "table"]
    if not tables and len(truth.velocities) > 1:
        raise FormulaError(
            "expected a matrix, e.g. [[a, b], [b, c]] or \\begin{pmatrix}",
            text,
            statements[0].start,
        )
    alone = [(line, (side,)) for line, side in sides if side.name not in quantity.letters]
    judged = (_judge_entries(*table, truth, quantity, text) for table in tables or alone)
    return list(chain.from_iterable(judged))


def _judge_entries(
    statement: Statement,
    entries: tuple[Node, ...],
    truth: Truth,
    quantity: AskedQuantity,
    text: str,
) -> list[Judged]:
    true, nv = quantity.values, len(truth.velocities)
    assert true is not None
    if len(entries) != nv * nv:
        raise FormulaError(
            f"expected a matrix of {nv} × {nv}, got {len(entries)} entries", text, statement.start
        )
    across = np.arange(nv * nv).reshape(nv, nv).T.ravel()
    mirrored = zip(across, entries, strict=True)
    entries = tuple(entries[k] if entry.name == ACROSS else entry for k, entry in mirrored)
    sample = truth.sample
    given, sizes = [], []
    for entry in entries:
        _refuse_letters(entry, {*quantity.letters} - sample.values.keys(), text)
        values = FormulaTape(entry).evaluate(sample.values, sample.count)
        given.append(values.whole)
        sizes.append(values.size)
    M = np.stack(given, axis=-1).reshape(sample.count, nv, nv)
    size = np.stack(sizes, axis=-1).reshape(sample.count, nv, nv)
    size = np.maximum(size, np.sqrt(np.einsum("nii,njj->nij", true, true)))
    if _worst(np.abs(M - true) / size) > EQUATION_HOLDS:
        for order in permutations(range(nv)) if nv <= _MOST_ORDERED else ():
            there = true[:, order][:, :, order]
            if _worst(np.abs(M - there) / size) <= EQUATION_HOLDS:
                names = ", ".join(truth.velocities[k] for k in order)
                says = np.eye(nv * nv)
                return [Judged(statement, None, 0.0, (f"in the order {names}",), says=says)]
    judged = []
    for k, entry in enumerate(entries):
        i, j = divmod(k, nv)
        far = _worst(np.abs(M - true)[:, i, j] / size[:, i, j])
        written = f"entry {i + 1}, {j + 1}: {entry.quote(text)}"
        place = replace(statement, sides=(entry,), text=written)
        residual = _residual(place, truth, {_ENTRY: true[:, i, j]}, _ENTRY, "")
        series = {_ENTRY: quantity.series[str(k)]}
        says = np.eye(nv * nv)[[k]]
        judged.append(replace(_judge_residual(residual, series), worst=far, says=says))
    return judged


_MOST_ORDERED = 4
_MEASURES = ((re.compile(r"(?<!/)\bHz$"), "f"), (re.compile(r"\d\s*(?:s|sec|ms)$"), "T"))
"""Units of frequencies and periods at the end of a number, and the letter that it stands for."""

_CONSTANT = 1e-12
"""What changes less than this part of its terms in a second is constant."""

_FACTORS = np.array([1e-3, 0.03, 0.1, 0.3, 0.6, 0.9, 1.1, 1.5, 3.0, 10.0, 30.0, 1e3])
_FACTORS = np.concatenate([-_FACTORS[::-1], _FACTORS])
"""What the quantity in question is multiplied by, to see that an equation holds for it alone."""

_ENTRY = "#entry"
_NOTHING = "#nothing"


def _worst(relative: Array) -> float:
    known = relative[np.isfinite(relative)]
    return float(known.max(initial=0.0)) if len(known) else np.inf


def _judge_constant(
    statements: Sequence[Statement], truth: Truth, quantity: AskedQuantity, text: str
) -> list[Judged]:
    """Judge conserved quantities: their rate in true motions is zero, but they are not constant."""
    sample = truth.sample
    ring = truth.closed_form.algebra.ring
    rates = {"t": np.ones(sample.count)}
    for name in truth.mechanism.coordinates:
        rates[name] = truth.at({})(ring[name].ddt())
    rates |= dict(zip(truth.velocities, sample.a.T, strict=True))
    all_judged = []
    listed = ((line, side) for line in statements for side in _list_constant(line, rates.keys()))
    for statement, formula in listed:
        named = {name for name in formula.letters if not name.startswith("[")}
        _refuse_letters(formula, named - sample.values.keys(), text)
        tape = FormulaTape(formula)
        values = tape.evaluate(sample.values, sample.count)
        slopes = tape.slopes(values)
        parts = [tape.along(slopes, name) * rate for name, rate in rates.items()]
        total = np.abs(sum(parts[1:], parts[0]))
        size = sum((np.abs(part) for part in parts), np.zeros(sample.count))
        relative = total / size
        worst = _worst(np.where(size > 0, relative, 0.0))
        # what depends on a velocity that is constant has no rate at all
        felt = [
            np.abs(tape.along(slopes, name) * sample.values[name])
            for name in (*truth.mechanism.coordinates, *truth.velocities)
        ]
        fault = ""
        if formula.letters & {*truth.accelerations, *truth.multipliers}:
            fault = "a conserved quantity depends on positions and velocities, not on accelerations"
        elif not (sum(felt, size) > _CONSTANT * values.size).any():
            fault = "it does not depend on the motion at all"
        all_judged.append(Judged(statement, None, worst, root=formula, fault=fault))
    return all_judged


def _list_constant(statement: Statement, moving: Collection[str]) -> list[Node]:
    """Return what is said to be constant: each side, of sides that all move their differences."""
    changing = [side for side in statement.sides if side.letters & {*moving}]
    if len(changing) < len(statement.sides) or not changing[1:]:
        return changing or [statement.sides[-1]]
    first, *others = changing
    return [add(first, negate(side).at(side.start, side.end)) for side in others]


def _judge_free_body(
    statements: Sequence[Statement], truth: Truth, quantity: AskedQuantity, text: str
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
    all_judged = []
    for statement in statements:
        residual = _residual(statement, truth, known, _NOTHING, text)
        named = sorted(residual.root.letters & foreign)
        forms = [f"{name} does not act on {body}" for name in named]
        worst = residual.worst
        moving = {*truth.velocities, *truth.accelerations}
        if not residual.holds and not residual.root.letters & moving:
            at_rest = residual.tape.evaluate(still, count)
            relative = _worst(at_rest.relative)
            if relative <= EQUATION_HOLDS:
                worst = relative
                forms.append("it holds at rest only: the inertia forces are missing")
        judged = _judge_residual(residual, series)
        says = _slopes_of(residual, quantity.letters)
        all_judged.append(replace(judged, worst=worst, forms=tuple(forms), says=says))
    return all_judged


def _forces_elsewhere(truth: Truth, body: str, names: Sequence[str]) -> set[str]:
    """Return the named reactions in joints that are not at a body."""
    joints = [j.name for j in truth.mechanism.joints if body not in (j.parent, j.child)]
    prefixes = tuple(f"{letter}_{joint}_" for letter in "RMSC" for joint in joints)
    return {name for name in names if f"{name}_".startswith(prefixes)}


def _judge_equilibrium(
    statements: Sequence[Statement], truth: Truth, quantity: AskedQuantity, text: str
) -> list[Judged]:
    """Judge positions: forces must balance at each of them, and all must be named."""
    positions, missing = judge_positions(statements, truth, text)
    by_statement: dict[Statement, Judged] = {}
    for position in positions:
        for statement in position.statements:
            fault = "" if position.worst else position.fault
            judged = Judged(
                statement,
                None,
                position.worst,
                fault=fault,
                says=position.says,
                rounding=position.rounding,
            )
            known = by_statement.get(statement, judged)
            # of a family, q = n π, the worst position counts
            worse = judged if known.holds else known
            says = np.concatenate([known.says, position.says])
            by_statement[statement] = replace(worse, says=says)
    all_judged = list(by_statement.values())
    if missing:
        lacking = tuple(f"{position} is missing" for position in missing)
        all_judged[0] = replace(all_judged[0], missing=lacking)
    return all_judged


def _judge_canonical(
    statements: Sequence[Statement], truth: Truth, quantity: AskedQuantity, text: str
) -> list[Judged]:
    """Judge Hamilton's equations; all rates of coordinates and momenta must follow from them."""
    nv = len(truth.velocities)
    # the letters of one momentum are one unknown
    places = dict(zip(truth.velocities, range(nv), strict=True))
    places |= by_momentum(truth, range(nv, 2 * nv), "'")
    unknowns: dict[int, list[str]] = {}
    for name, place in places.items():
        unknowns.setdefault(place, []).append(name)
    true = {**truth.sample.values, **quantity.more}
    accelerations = set(truth.accelerations)
    all_judged = []
    for statement in statements:
        _refuse_formula(statement, "a rate", text)
        residual = _residual(statement, truth, quantity.more, "", text)
        says, fault = _slopes_by_place(residual, places)[:1], ""
        if residual.holds and residual.root.letters & accelerations:
            fault = "Hamilton's equations contain no accelerations"
        elif residual.holds:
            faults = [
                _find_emptiness(residual, names, [true])
                for names in unknowns.values()
                if residual.root.letters & set(names)
            ]
            # a rate of a momentum may stand beside squares of other rates
            fault = min(faults, key=bool, default="it contains no rate")
        judged = _judge_residual(residual, quantity.series)
        all_judged.append(replace(judged, fault=fault, says=says))
    return _tell_missing(all_judged, "equations")


def _slopes_of(residual: Residual, names: Sequence[str]) -> Array:
    """Return the derivatives by unknowns in the first state, shape (1, unknowns)."""
    return _slopes_by_place(residual, {name: k for k, name in enumerate(names)})[:1]


def _slopes_by_place(residual: Residual, places: Mapping[str, int]) -> Array:
    """Return the derivatives by unknowns, each of which may have several letters, shape (n, k)."""
    slopes = np.zeros((residual.sample.count, 1 + max(places.values())))
    for name, place in places.items():
        slopes[:, place] += residual.tape.along(residual.slopes, name)
    return slopes


def _judge_steady(
    statements: Sequence[Statement], truth: Truth, quantity: AskedQuantity, text: str
) -> list[Judged]:
    """Judge the rates of steady motions at given positions: each of them, and no others."""
    all_judged, motions = list[Judged](), SteadyMotions(truth)
    for statement in name_values(statements):
        written = set().union(*(side.letters for side in statement.sides))
        rates = [name for name in quantity.letters if name in written]
        if not rates or not statement.is_equation:
            raise FormulaError(
                f"expected an equation for {' or '.join(quantity.letters)}", text, statement.start
            )
        sides = [side.name for side in statement.sides]
        alone = [name for name in rates if name in sides]
        # more states have a value of some rates than of others
        name = max(alone or rates, key=partial(_count_rates, motions))
        roots = motions.find_rates(name)
        apart = np.abs(roots[0] - roots[1])
        # the same motion backwards is no other
        turned = np.abs(roots[0] + roots[1])
        small = 1e-6 * np.nanmax(np.abs(roots))
        several = bool((apart > small).any() and (turned > small).any())
        cases = [motions.at({name: root}) for root in roots]
        tried = [_residual(statement, truth, {}, "", text, case) for case in cases]
        holds = [residual.holds and bool(residual.finite.any()) for residual in tried]
        covers = np.flatnonzero(holds)
        # where there is but one rate, there is nothing to compare with the other
        best = min(tried, key=lambda residual: (not residual.finite.any(), residual.worst))
        covered = [cases[k] for k in covers]
        if not covered:
            # of a formula with a root the same sign may give now the smaller, now the larger rate
            nearest = np.argmin([residual.relative for residual in tried], axis=0)
            case = motions.at({name: np.where(nearest, roots[1], roots[0])})
            mixed = _residual(statement, truth, {}, "", text, case)
            if mixed.holds and mixed.finite.any():
                best, covered, covers = mixed, [case], nearest[mixed.finite][:1]
        fault = (_find_emptiness(best, [name], covered) or _find_limit(best)) if covered else ""
        says = np.eye(2)[covers] if several else np.ones((len(covers), 1))
        all_judged.append(replace(_judge_residual(best), fault=fault, says=says))
    if all_judged[0].says.shape[1] - count_independent(all_judged) == 1 and any(
        judged.holds for judged in all_judged
    ):
        all_judged[0] = replace(
            all_judged[0], missing=("the other rate at the same position is missing",)
        )
    return all_judged


def _count_rates(motions: SteadyMotions, name: str) -> int:
    """Return how many values a rate has in all states."""
    try:
        return int(np.isfinite(motions.find_rates(name)).sum())
    except InputError:
        return 0


def is_equivalent(residual: Residual, truth: Truth, letters: Sequence[str]) -> bool:
    """Return whether two Lagrangians give the same equations, for any motion."""
    # they may differ by the total time derivative of a function of coordinates and time; the
    # letters are those that stand for the Lagrangian itself
    sample = truth.sample
    formulas = [side for side in residual.statement.sides if side.name not in letters]
    if len(formulas) != 1 or formulas[0].letters & set(letters):
        return False
    if any(not velocity.endswith("'") for velocity in truth.velocities):
        return False
    answer = formulas[0]
    # T − V without the forces that have no potential
    true = Lagrange(truth.mechanism, truth.closed_form.algebra)
    moving = KnownLetters.of(truth.mechanism).rate_nodes
    moving |= {name: letter("#zero") for name in truth.accelerations}
    L = true.T - true.V
    random = np.random.default_rng(1)
    accelerations = {
        name: sample.values[name]
        + random.normal(size=sample.count) * (1 + np.abs(sample.values[name]))
        for name in truth.accelerations
    }
    values = {**sample.values, **accelerations, "#zero": np.zeros(sample.count)}
    for velocity in truth.velocities:
        name = velocity.removesuffix("'")
        try:
            momentum = rate(answer, {velocity: number(1)})
            euler = add(rate(momentum, moving), negate(rate(answer, {name: number(1)})))
        except FormulaError:
            return False
        given = FormulaTape(euler).evaluate(values, sample.count)
        left_side = truth.at(values)(L.diff(velocity).ddt() - L.diff(name))
        relative = np.abs(given.whole - left_side) / (given.size + np.abs(left_side))
        if not (relative[np.isfinite(relative)] <= EQUATION_HOLDS).all():
            return False
    return True
