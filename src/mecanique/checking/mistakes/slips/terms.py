"""Mistakes in single terms of the equations of motion: missing, doubled, of the wrong sign."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from fractions import Fraction
from itertools import permutations
from typing import Any, NamedTuple

from mecanique.arrays import Array
from mecanique.checking.mistakes.slips.hypothesis import (
    Hypothesis,
    RightEquations,
    group_by_velocities,
)
from mecanique.derivation.scalars.polynomials import exponents
from mecanique.derivation.scalars.series import Kind, Series

_MOST_SINGLE = 60
"""Longer quantities are not searched term by term."""

_MOST_TERMS = 12
"""Longer entries of the equations are changed only as a whole, not term by term."""


class _Mistake(NamedTuple):
    """A kind of mistake, its words about a term, and its weight."""

    kind: str
    text: str
    weight: float


class _Term(NamedTuple):
    """A term of a row of the equations, or a group of terms.

    Args:
        row: index of the equation.
        series: the term, without its acceleration.
        column: column of M; −1 for a term without an acceleration.
        name: its name in words; empty if it has none.
        weight: how likely it is forgotten; smaller is likelier.
    """

    row: int
    series: Series
    column: int
    name: str
    weight: float


def mistake_terms(right: RightEquations) -> Iterator[Hypothesis]:
    """Yield equations with a term left out, of the wrong sign, doubled or halved."""
    for term in _list_terms(right):
        missing = f"{term.name} {{}} is missing" if term.name else "the term {} is missing"
        yield _change(right, term, 0.0, _Mistake("missing", missing, term.weight))
        sign = "the sign of the term {} is wrong"
        yield _change(right, term, -1.0, _Mistake("sign", sign, term.weight))
        twice = "the term {} is counted twice"
        yield _change(right, term, 2.0, _Mistake("factor", twice, term.weight + 0.5))
        half = "the term {} is halved"
        yield _change(right, term, 0.5, _Mistake("factor", half, term.weight + 0.5))


def mistake_letters(right: RightEquations) -> Iterator[Hypothesis]:
    """Yield equations with one letter for another of the same unit in a single term."""
    parameters = right.truth.mechanism.parameters
    values = right.sample.values
    for term in _list_terms(right):
        whole = term.series
        if len(whole) > 1:
            continue
        ((_, monomial, _),) = whole.terms()
        powers = {whole.ring.generators[i].name: e for i, e in exponents(monomial)}
        for one, other in permutations(parameters, 2):
            if one.unit == other.unit and one.symbol in powers:
                ratio = (values[other.symbol] / values[one.symbol]) ** powers[one.symbol]
                text = f"in the term {{}} {other.symbol} should be {one.symbol}"
                yield _change(right, term, ratio, _Mistake("letter", text, 2.1))


def _list_terms(right: RightEquations) -> Iterator[_Term]:
    """Yield the terms that may be wrong: entries of M, groups of h and Q, and their parts."""
    derivation = right.derivation
    velocities = derivation.algebra.velocities
    for row, entries in enumerate(derivation.M):
        for column, entry in enumerate(entries):
            if not entry:
                continue
            own = row == column
            name = "the inertia term" if own else "the coupling term"
            yield _Term(row, entry, column, name, 1.6 if own else 1.0)
            for part in _split(entry):
                yield _Term(row, part, column, "the inertia term", 2.0)
    for row, (h, Q) in enumerate(zip(derivation.h, derivation.Q, strict=True)):
        groups = group_by_velocities(h, velocities)
        for powers, group in groups.items():
            name = _name(powers)
            yield _Term(row, group, -1, name, 1.0)
            for part in _split(group):
                yield _Term(row, part, -1, name, 2.0)
        for group in group_by_velocities(Q, velocities).values():
            yield _Term(row, -group, -1, "the force", 1.2)
            for part in _split(group):
                yield _Term(row, -part, -1, "the force", 1.5)


def _change(
    right: RightEquations, term: _Term, factor: float | Array, mistake: _Mistake
) -> Hypothesis:
    """Return the equations with a term mistakenly multiplied by a factor."""
    M, rest, shown = right.sample.M, right.rest, term.series
    change = (factor - 1) * right.value(term.series)
    if term.column >= 0:
        M = M.copy()
        M[:, term.row, term.column] += change
        ring = right.derivation.algebra.ring
        shown = term.series * ring[right.truth.accelerations[term.column]]
    else:
        rest = rest.copy()
        rest[:, term.row] += change
    return Hypothesis(*mistake, M=M, rest=rest, row=term.row, term=shown)


def list_parts(series: Series, velocities: Sequence[str]) -> list[Series]:
    """Return parts of a series: by powers of velocities, by parameters, and single terms."""
    single = [_term(series, *term) for term in series.terms()]
    if len(single) > _MOST_SINGLE:
        return []
    parts = list(group_by_velocities(series, velocities).values())
    for letter in (g for g in series.generators() if g.kind is Kind.PARAMETER):
        parts.append(series.ring.sum([one for one in single if letter in one.generators()]))
    return [part for part in dict.fromkeys([*parts, *single]) if part != series]


def _split(series: Series) -> list[Series]:
    """Return parts of a series: its terms, and those that share letters, or sine and cosine."""
    terms = list(series.terms())
    if not 1 < len(terms) <= _MOST_TERMS:
        return []
    ring = series.ring
    groups: dict[frozenset[int], Series] = {}
    for first, last in ((1, 2), (0, 1), (0, 2)):
        # terms that share the monomial, the sine or cosine, or both
        together: dict[Any, list[int]] = {}
        for place, term in enumerate(terms):
            together.setdefault(term[first:last], []).append(place)
        for places in together.values():
            if len(places) < len(terms):
                parts = [_term(series, *terms[place]) for place in places]
                groups[frozenset(places)] = ring.sum(parts)
    return list(groups.values())


def _term(series: Series, trig: int, monomial: int, c: Fraction) -> Series:
    return Series(series.ring, {trig: {monomial: c.numerator}}, c.denominator, series.reach)


def _name(powers: Sequence[int]) -> str:
    """Return a textbook's name for terms with these powers of the velocities."""
    if sum(powers) == 2:
        return "the centripetal term" if 2 in powers else "the Coriolis term"
    # dampers are forces; these terms come from prescribed motions
    return "the Coriolis term" if sum(powers) == 1 else "the term"
