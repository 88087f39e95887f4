"""Equations of motion and expressions as a textbook prints them: as text, LaTeX and MathML."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from html import escape
from typing import final

from mecanique.derivation.printing.expressions import (
    Expr,
    collect_terms,
    factor_out,
    letters,
)
from mecanique.derivation.printing.layout import FUNCTION_RANK, SUM_RANK, Notation, write
from mecanique.derivation.printing.trigforms import (
    Form,
    content,
    cost,
    has_double_angles,
    scale,
    shortest,
)
from mecanique.derivation.printing.writers import Latex, MathML, Text, Writer
from mecanique.derivation.scalars.monomials import exponents, power
from mecanique.derivation.scalars.polynomials import Parts
from mecanique.derivation.scalars.series import Basis, Kind, Series, canonical
from mecanique.errors import DerivationError

__all__ = ["Equation", "Expression", "Term", "equations", "expression"]

_PLACES = {
    Kind.CONSTANT: -1,
    Kind.ATOM: 5,
    Kind.TIME: SUM_RANK + 5,
    Kind.COORDINATE: SUM_RANK + 5,
    Kind.VELOCITY: FUNCTION_RANK + 2,
    Kind.ACCELERATION: FUNCTION_RANK + 3,
    Kind.INPUT: FUNCTION_RANK + 4,
    Kind.REACTION: FUNCTION_RANK + 4,
    Kind.VARIATION: FUNCTION_RANK + 5,
}
_RANKED = (
    Kind.ACCELERATION,
    Kind.VELOCITY,
    Kind.COORDINATE,
    Kind.INPUT,
    Kind.REACTION,
    Kind.VARIATION,
)
_MOVING = (Kind.ACCELERATION, Kind.VELOCITY, Kind.INPUT, Kind.REACTION, Kind.VARIATION)
_GAIN = 2
"""Products of single angles are preferred to double angles up to this many signs more."""


@final
@dataclass(frozen=True)
class Term:
    """One term of a sum.

    Args:
        coefficient: sympy expression in parameters, coordinates and time.
        motion: monomial of accelerations, velocities, inputs and lengths that it multiplies, 1 for
            none.
    """

    coefficient: Expr
    motion: Expr


@final
@dataclass(frozen=True)
class Expression:
    """A sum of terms in textbook order.

    Args:
        terms: what is added.
        notation: what its letters stand for.
    """

    terms: tuple[Term, ...]
    notation: Notation

    def text(self) -> str:
        """Return it as one line of text."""
        return self.write(Text())

    def latex(self) -> str:
        """Return it in LaTeX, without dollar signs."""
        return self.write(Latex())

    def mathml(self) -> str:
        """Return it as one MathML element."""
        return _math_element(self.write(MathML()), self.text())

    def write(self, writer: Writer) -> str:
        """Return it in the format of a writer."""
        return write(
            [(term.coefficient, term.motion) for term in self.terms], self.notation, writer
        )

    def __str__(self) -> str:
        return self.text()

    def _repr_latex_(self) -> str:
        return f"$\\displaystyle {self.latex()}$"


@final
@dataclass(frozen=True)
class Equation:
    """An equation of motion left = right, with inputs and other functions of time on the right.

    Args:
        left: what holds accelerations, velocities and coordinates.
        right: what depends on time alone.
        divisor: monomial of parameters that the derived equation was divided by: derived = (left −
            right) × divisor.
    """

    left: Expression
    right: Expression
    divisor: Series

    def text(self) -> str:
        """Return it as one line of text, e.g. q'' + 3 g sin(q)/(2 l) = 0."""
        return self._write(Text())

    def latex(self) -> str:
        """Return it in LaTeX, without dollar signs."""
        return self._write(Latex())

    def mathml(self) -> str:
        """Return it as one MathML element."""
        return _math_element(self._write(MathML()), self.text())

    def _write(self, writer: Writer) -> str:
        return writer.equation(self.left.write(writer), self.right.write(writer))

    def __str__(self) -> str:
        return self.text()

    def _repr_latex_(self) -> str:
        return f"$\\displaystyle {self.latex()}$"


def equations(elements: Sequence[Series], *, monic: bool | None = None) -> tuple[Equation, ...]:
    """Return equations of motion element = 0 in textbook form.

    Each is collected by its accelerations, velocities, inputs and lengths and divided by the
    rational number and the monomial of parameters that all terms share. It is never divided by a
    coordinate.

    Args:
        elements: one series for each equation.
        monic: whether to divide by the coefficient before the acceleration where that is a monomial
            of parameters; by default where there is a single equation.

    Raises:
        DerivationError: if an element is zero.
    """
    divide = len(elements) == 1 if monic is None else monic
    return tuple(_equation(element, divide) for element in elements)


def expression(series: Series) -> Expression:
    """Return a series, e.g. a kinetic energy, in textbook order, with the fewest signs."""
    groups = _group(series, by_side=False)
    return _expression(
        series.ring, [(key, shortest(part, products=True)) for (_, key), part in groups]
    )


def _equation(element: Series, divide: bool) -> Equation:
    if not element:
        raise DerivationError(
            "expected an equation of motion, got 0 = 0: a coordinate meets neither inertia nor "
            "force"
        )
    groups = _group(element, by_side=True)
    candidates = []
    for products in (True, False) if has_double_angles(element) else (True,):
        forms = [shortest(part, products=products) for _, part in groups]
        divisor = _divisor(element.ring, groups, forms, divide)
        forms = [scale(form, 1 / divisor) for form in forms]
        candidates.append((sum(map(cost, forms)) - (_GAIN if products else 0), forms, divisor))
    _, forms, divisor = min(candidates, key=lambda candidate: candidate[0])
    left, right = [], []
    for ((is_right, key), _), form in zip(groups, forms, strict=True):
        if is_right:
            right.append((key, scale(form, element.ring.number(-1))))
        else:
            left.append((key, form))
    return Equation(_expression(element.ring, left), _expression(element.ring, right), divisor)


def _divisor(ring: Basis, groups: list[_Group], forms: list[Form], divide: bool) -> Series:
    """What the equation is divided by, so that its first coefficient is positive."""
    first = forms[0]
    if (
        divide
        and first.keys() == {()}
        and first[()].is_unit
        and _accelerates(ring, groups[0][0][1])
    ):
        unit = first[()]
        kinds = {g.kind for g in unit.generators()}
        if kinds <= {Kind.PARAMETER, Kind.CONSTANT, Kind.ATOM}:
            return unit
    divisor = content(forms)
    lead = next(iter(first.values()))
    return -divisor if max(lead.terms(), key=lambda term: term[1])[2] < 0 else divisor


_Group = tuple[tuple[bool, int], Series]


def _group(series: Series, *, by_side: bool) -> list[_Group]:
    """The series by monomials of motion and lengths, in order: ((on the right, monomial), rest)."""
    ring = series.ring
    kinds = [g.kind for g in ring.generators]
    depends = {i: _kinds(atom.argument) for i, atom in ring.atoms.items()}
    turns = [_kinds(angle.argument) for angle in ring.angles]
    parts: dict[tuple[bool, int], Parts] = {}
    for trig, polynomial in series.parts.items():
        turning = set().union(*(turns[j] for j, _ in exponents(trig >> 1)))
        for monomial, c in polynomial.items():
            powers = dict(exponents(monomial))
            moving = {i: e for i, e in powers.items() if kinds[i] in _MOVING}
            involved = turning | {kinds[i] for i in powers}.union(
                *(depends.get(i, set()) for i in powers)
            )
            if not moving and Kind.COORDINATE not in turning:
                moving = {i: e for i, e in powers.items() if kinds[i] is Kind.COORDINATE and e > 0}
            alone = not involved & {Kind.ACCELERATION, Kind.VELOCITY, Kind.COORDINATE}
            forcing = by_side and bool(Kind.INPUT in involved or (alone and Kind.TIME in involved))
            forcing = forcing and not involved & {Kind.ACCELERATION, Kind.VELOCITY}
            key = sum(power(i, e) for i, e in moving.items())
            parts.setdefault((forcing, key), {}).setdefault(trig, {})[monomial - key] = c
    groups = [(k, canonical(ring, p, series.denominator, series.reach)) for k, p in parts.items()]
    return sorted(groups, key=lambda group: (group[0][0], _rank(ring, group[0][1])))


def _kinds(series: Series) -> set[Kind]:
    """What a series depends on."""
    return {generator.kind for generator in series.generators()}


def _rank(ring: Basis, key: int) -> tuple[object, ...]:
    """Accelerations, then velocities, then lengths, then the rest.

    Of motions the higher powers come first, of lengths the lower ones.
    """
    powers = dict(exponents(key))
    degrees: dict[Kind, list[int]] = {kind: [] for kind in _RANKED}
    for generator in ring.generators:
        if generator.kind in degrees:
            degrees[generator.kind].append(-powers.get(generator.index, 0))
    motion = [sum(degrees[kind]) for kind in _RANKED[:2]]
    lengths = -sum(degrees[Kind.COORDINATE])
    return (*motion, lengths or math.inf, *(tuple(degrees[kind]) for kind in _RANKED))


def _accelerates(ring: Basis, key: int) -> bool:
    return any(ring.generators[i].kind is Kind.ACCELERATION for i, _ in exponents(key))


def _expression(ring: Basis, groups: Sequence[tuple[int, Form]]) -> Expression:
    from sympy import Integer

    terms: list[Term] = []
    for key, form in groups:
        if key:
            terms.append(Term(factor_out(form), letters(ring, key)))
            continue
        for coefficient in collect_terms(form):
            parts = coefficient.args if coefficient.is_Add else (coefficient,)
            terms += [Term(part, Integer(1)) for part in parts]
    return Expression(tuple(terms), _notation(ring))


def _notation(ring: Basis) -> Notation:
    ranks = {g.name: _PLACES.get(g.kind, 0) for g in ring.generators}
    return Notation(ranks, frozenset(g.name for g in ring.generators if g.kind is Kind.INPUT))


def _math_element(row: str, text: str) -> str:
    alt = escape(text, quote=True)
    xmlns = "http://www.w3.org/1998/Math/MathML"
    return f'<math xmlns="{xmlns}" display="block" alttext="{alt}">{row}</math>'
