"""Call constant inertias that are long sums by a letter in what a derivation comes to."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import replace
from fractions import Fraction
from functools import partial
from math import gcd

from mecanique.derivation.printing.expressions import to_formula, to_power
from mecanique.derivation.printing.formulas import (
    Letter,
    Product,
    Sum,
    draw_number,
    multiply,
    number,
)
from mecanique.derivation.printing.writers import Equation, Expression, Printed, Relation
from mecanique.derivation.scalars.series import GIVEN
from mecanique.derivation.symbolic.derivation import Derivation, Ending, Left, Result
from mecanique.derivation.symbolic.symbols import coordinate_of

_FEWEST = 3
"""Sums of fewer terms, or that stand in fewer places, are written out."""


def abbreviate(derivation: Derivation, endings: Sequence[Ending]) -> tuple[Ending, ...]:
    """Return the last sections with a letter for each long constant on the diagonal of M."""
    algebra, lines = derivation.algebra, [line for ending in endings for line in ending.lines]
    if derivation.ties:
        return tuple(endings)
    sums = [*_find_sums(term for line in lines for term in _list_terms(line))]
    names, definitions, unknowns = dict[Sum, Product](), list[Result](), dict[str, str]()
    for k, row in enumerate(derivation.M):
        formula, name = to_formula(row[k]), coordinate_of(algebra.velocities[k])
        whole = formula.factors[0][0] if formula.factors else None
        if isinstance(whole, Sum) and row[k].kinds <= GIVEN and whole not in names:
            long = all(len(term.factors) > 1 for term in whole.terms)  # no sum of masses
            rare = min(len(whole.terms), sums.count(whole)) < _FEWEST
            if rare or not long or len(formula.factors) > 1:
                continue
            letter = algebra.ring.choose_name((f"J_{name}", f"I_{name}", f"inertia_{name}"))
            size = number(1 / Fraction(formula.number))
            names[whole] = multiply(size, Letter(letter, (0, -1)))
            terms = tuple(multiply(number(formula.number), term) for term in whole.terms)
            definitions.append(Result(Left(letter), row[k], partial(Expression, terms)))
            unknowns[letter] = f"inertia referred to {name}"
    if not names:
        return tuple(endings)
    first, *others = (_rewrite(ending, names) for ending in endings)
    *before, last = first.sections
    said = " ".join(f"{letter} is the {meant}." for letter, meant in unknowns.items())
    last = replace(last, sentence=f"{said} {last.sentence}", lines=(*definitions, *last.lines))
    first = replace(first, sections=(*before, last), unknowns={**first.unknowns, **unknowns})
    return (first, *others)


def _rewrite(ending: Ending, names: Mapping[Sum, Product]) -> Ending:
    """Return a section, and those before it, with sums called by their names."""
    lines = tuple(_call(line, names) for line in ending.lines)
    sections = tuple(_rewrite(section, names) for section in ending.sections)
    return replace(ending, lines=lines, sections=sections)


def _call(line: Printed, names: Mapping[Sum, Product]) -> Printed:
    """Return a line with sums called by their names."""
    match line:
        case Result():
            return replace(line, shown=lambda: _put(line.expression(), names))
        case Equation():
            left, right = _put(line.left, names), _put(line.right, names)
            measure = gcd(*(term.number.numerator for term in (*left.terms, *right.terms)))
            whole = all(term.number.denominator == 1 for term in (*left.terms, *right.terms))
            by = number(Fraction(1, measure if whole else 1))
            return Equation(_scale(left, by), _scale(right, by), line.divisor / by.number)
        case Relation(Expression() as left, sign, Expression() as right):
            return Relation(_put(left, names), sign, _put(right, names))
        case _:
            return line


def _scale(side: Expression, by: Product) -> Expression:
    return replace(side, terms=tuple(multiply(by, term) for term in side.terms))


def _put(side: Expression, names: Mapping[Sum, Product]) -> Expression:
    return replace(side, terms=tuple(_put_in_term(term, names) for term in side.terms))


def _put_in_term(term: Product, names: Mapping[Sum, Product]) -> Product:
    factors = list[Product]()
    for base, power in term.factors:
        whole = multiply((base, 1))
        if isinstance(base, Sum):
            inner = [_put_in_term(part, names) for part in base.terms]
            changed = tuple(inner) != base.terms
            whole = names.get(base) or (draw_number(inner) if changed else whole)
        factors.append(to_power(whole, Fraction(power)))
    return multiply(number(term.number), *factors)


def _list_terms(line: Printed) -> Iterator[Product]:
    """Yield the terms of a line's right side, or of both sides of an equation."""
    match line:
        case Result():
            yield from line.expression().terms
        case Equation(left, right) | Relation(Expression() as left, _, Expression() as right):
            yield from (*left.terms, *right.terms)


def _find_sums(terms: Iterable[Product]) -> Iterator[Sum]:
    """Yield the sums in terms, as often as they stand there."""
    for term in terms:
        for base, _ in term.factors:
            if isinstance(base, Sum):
                yield base
                yield from _find_sums(base.terms)
