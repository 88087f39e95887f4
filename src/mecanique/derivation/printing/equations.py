"""Bring equations of motion and expressions into the form in which a textbook prints them."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import replace
from fractions import Fraction
from typing import Any, NamedTuple, cast, final

from mecanique.derivation.printing.divisors import draw_divisor
from mecanique.derivation.printing.expressions import (
    collect_terms,
    factor_out,
    letters,
    size,
    to_formula,
    to_power,
)
from mecanique.derivation.printing.formulas import (
    MOVING,
    SUMS,
    Letter,
    Product,
    Sum,
    add,
    multiply,
    number,
    open_sum,
)
from mecanique.derivation.printing.grouping import Group, accelerates, group
from mecanique.derivation.printing.printed import Equation, Expression
from mecanique.derivation.printing.stretches import draw_stretches
from mecanique.derivation.printing.trigforms import (
    Form,
    common_measure,
    content,
    cost,
    has_double_angles,
    scale,
    shortest,
)
from mecanique.derivation.scalars.cancel import tidy
from mecanique.derivation.scalars.generators import Kind
from mecanique.derivation.scalars.monomials import exponents, power
from mecanique.derivation.scalars.series import Basis, Series
from mecanique.errors import DerivationError

_MEASURED = 10_000
"""Numbers with a larger denominator are taken as measured."""

_LONG = 150
"""Equations with more terms are tried in one style only, that of sums of angles."""

_GAIN = 2
"""Single angles are preferred to double angles if they take at most this many symbols more."""


def equations(
    elements: Sequence[Series], *, monic: bool | None = None, own: Sequence[str] = ()
) -> tuple[Equation, ...]:
    """Return equations of motion element = 0 in textbook form.

    The terms of each are collected by accelerations, velocities, inputs and lengths, and divided by
    their common factors: a rational number, a monomial of parameters, and a sum of parameters and
    time. No equation is ever divided by a coordinate.

    Args:
        elements: one series for each equation.
        monic: whether to divide by the coefficient of the acceleration if it is a monomial of
            parameters; by default only for a single equation.
        own: name of the acceleration that each equation belongs to, whose inertia is printed
            positive; by default the first acceleration of each equation.

    Raises:
        DerivationError: if an element is zero.
    """
    divide = len(elements) == 1 if monic is None else monic
    names = [*own, *[""] * (len(elements) - len(own))]
    return tuple(_form_equation(*pair, divide) for pair in zip(elements, names, strict=True))


def root(series: Series) -> Expression:
    """Return the square root of a series as a printed expression."""
    return Expression((to_power(to_formula(series), Fraction(1, 2)),), _in_decimals(series))


def half_square(factor: Series, base: Series) -> Expression:
    """Return half a factor times a square that is not expanded, e.g. ½ k (q2 − q1)²."""
    inner = add(expression(base).terms)
    whole = multiply(number(Fraction(1, 2)), to_formula(factor), (inner, 2))
    return Expression((whole,), _in_decimals(factor))


def join(parts: Iterable[Expression]) -> Expression:
    """Return the sum of expressions, each left as it is."""
    found = list(parts)
    terms = tuple(term for part in found for term in part.terms)
    return Expression(terms, any(part.decimals for part in found))


def distribute(series: Series, factor: Series) -> Expression:
    """Return a series with each of its terms multiplied by a factor."""
    whole, by = expression(series), to_formula(factor)
    return replace(whole, terms=tuple(multiply(term, by) for term in whole.terms))


def shorter(one: Expression, other: Expression) -> Expression:
    """Return the expression that takes fewer symbols."""
    sizes = [sum(map(size, each.terms)) + len(each.terms) for each in (one, other)]
    return one if sizes[0] <= sizes[1] else other


def expression(series: Series) -> Expression:
    """Return a series, e.g. a kinetic energy, in textbook order, with the fewest symbols."""
    parts = []
    bare, stretches = draw_stretches(series)
    for (_, key), part in group(bare, by_side=False):
        parts += _split_group(series.ring, key, shortest(tidy(part), products=True))
    for one in stretches:
        share = factor_out(shortest(tidy(one.share), products=True))
        parts.append(_Part(0, share, one.motion()))
    whole = _expression(series, parts)
    ahead = next((k for k, term in enumerate(whole.terms) if term.number > 0), 0)
    order = (*whole.terms[ahead : ahead + 1], *whole.terms[:ahead], *whole.terms[ahead + 1 :])
    return replace(whole, terms=order)


@final
class _Part(NamedTuple):
    """A term of an equation: a coefficient times a monomial of motions and lengths.

    Args:
        key: the monomial.
        factor: its coefficient.
        motion: the monomial as a formula.
    """

    key: int
    factor: Product
    motion: Product

    def divide(self, by: Sum) -> _Part:
        """Return the term divided by one of its factors, a sum that may have the opposite sign."""
        held = any(base == by for base, _ in self.factor.factors)
        sign = number(1 if held else -1)
        quotient = multiply(sign, self.factor, (by if held else by.negative(), -1))
        return self._replace(factor=quotient)

    def negate(self) -> _Part:
        """Return the term with the opposite sign."""
        return self._replace(factor=multiply(number(-1), self.factor))

    def term(self) -> Product:
        """Return the term as one product."""
        return multiply(self.factor, self.motion)


def _form_equation(element: Series, own: str, divide: bool) -> Equation:
    if not element:
        raise DerivationError(
            "expected an equation of motion, got 0 = 0: a coordinate has neither inertia nor force"
        )
    ring = element.ring
    bare, stretches = draw_stretches(element)
    groups = group(bare, by_side=True)
    ordinary = len(groups)
    groups += [((False, 0), one.share) for one in stretches]
    candidates = []
    # only one style is tried for long equations: with many angles sums are shorter
    styles = (True, False) if has_double_angles(element) else (True,)
    for products in styles if len(element) <= _LONG else (False,):
        forms = [shortest(part, products=products) for _, part in groups]
        divisor = _find_divisor(ring, groups, forms, divide)
        forms = [scale(form, 1 / divisor) for form in forms]
        candidates.append((products, forms, divisor))
    _, forms, divisor = candidates[0] if len(candidates) == 1 else min(candidates, key=_cost)
    sides: dict[bool, list[_Part]] = {False: [], True: []}
    whole = zip(groups[:ordinary], forms[:ordinary], strict=True)
    for ((is_right, key), _), form in whole:
        sides[is_right] += _split_group(ring, key, form)
    for one, form in zip(stretches, forms[ordinary:], strict=True):
        sides[False].append(_Part(0, factor_out(form), one.motion()))
    left, right = sides[False], [part.negate() for part in sides[True]]
    shared = _find_shared_sum([part.factor for part in (*left, *right)])
    if shared is not None:
        left, right = [p.divide(shared) for p in left], [p.divide(shared) for p in right]
        divisor = divisor * _to_series(ring, shared)
    mine = power(ring.index(own)) if own else -1
    inertia = next((part for part in left if part.key == mine), [*left, *right][0])
    if inertia.factor.number < 0:
        left, right = [p.negate() for p in left], [p.negate() for p in right]
        divisor = -divisor
    if left and left[0].factor.number < 0 and inertia in left:
        left.remove(inertia)  # first, as an equation does not begin with a minus
        left.insert(0, inertia)
    whole_left = _expression(element, left)
    whole_left = replace(whole_left, terms=tuple(draw_divisor(whole_left.terms)))
    return Equation(whole_left, _expression(element, right), divisor)


def _cost(candidate: tuple[bool, list[Form], Series]) -> int:
    products, forms, _ = candidate
    return sum(map(cost, forms)) - (_GAIN if products else 0)


def _split_group(ring: Basis, key: int, form: Form) -> list[_Part]:
    """Return a group's terms: one, or each by itself where the group multiplies no motion."""
    if key:
        return [_Part(key, factor_out(form), letters(ring, key))]
    return [_Part(0, part, number(1)) for term in collect_terms(form) for part in open_sum(term)]


def _find_shared_sum(factors: Sequence[Product]) -> Sum | None:
    """Find a sum of parameters and time that divides all factors; None without one."""
    for base, power_of in factors[0].factors:
        if isinstance(base, Sum) and power_of > 0 and _is_given(base):
            either = (base, base.negative())
            if all(_holds(factor, either) for factor in factors):
                return base
    return None


def _holds(factor: Product, sums: Sequence[Sum]) -> bool:
    return any(base in sums and power_of > 0 for base, power_of in factor.factors)


def _is_given(whole: Sum) -> bool:
    """Whether a sum contains only parameters and time."""
    inner = [base for term in whole.terms for base, _ in term.factors]
    return all(isinstance(b, Letter) and (b.place[0] < SUMS or b.name == "t") for b in inner)


def _to_series(ring: Basis, whole: Sum) -> Series:
    """Convert a sum of letters into a series."""
    terms = []
    for term in whole.terms:
        found = ring.number(term.number)
        for base, power_of in term.factors:
            if isinstance(base, Letter):
                found = found * ring[base.name] ** int(power_of)
        terms.append(found)
    return ring.sum(terms)


def _find_divisor(ring: Basis, groups: list[Group], forms: list[Form], divide: bool) -> Series:
    """Return the divisor of an equation: a number times a monomial of parameters."""
    first = forms[0]
    if divide and first.keys() == {()} and first[()].is_unit and accelerates(ring, groups[0][0][1]):
        unit = first[()]
        kinds = {g.kind for g in unit.generators()}
        if kinds <= {Kind.PARAMETER, Kind.CONSTANT, Kind.ATOM}:
            return unit
    shared = content(forms)
    forces = list[Series]()
    for ((_, key), _), form in zip(groups, forms, strict=True):
        if any(ring.generators[i].kind is Kind.REACTION for i, _ in exponents(key)):
            forces += form.values()
    if forces:
        # an unknown force keeps its plain lever arm: its fractions are not cleared
        ((_, _, number_of),) = shared.terms()
        shared = shared * (common_measure(forces) / number_of)
    return shared


def _expression(series: Series, parts: Sequence[_Part]) -> Expression:
    terms = [part.term() for part in parts]
    return Expression(tuple(_pair(terms)), _in_decimals(series))


def _pair(terms: Sequence[Product]) -> list[Product]:
    """Merge terms that differ in one letter: k q2 − k q1 = k (q2 − q1)."""
    paired: list[Product] = []
    seats: dict[Any, int] = {}
    for term in terms:
        rest, letter = _split(term)
        seat = seats.get(rest) if letter is not None else None
        if seat is None or paired[seat].number * term.number > 0:
            seats[rest] = len(paired)
            paired.append(term)
            continue
        other = paired[seat]
        (*before, (first, _)), sign = other.factors, other.number
        own = cast("Letter", letter)
        both = add([Product(1, ((first, 1),)), Product(-1, ((own, 1),))])
        paired[seat] = multiply(number(sign), *before, both)
        del seats[rest]
    return paired


def _split(term: Product) -> tuple[Any, Letter | None]:
    """Split a force law's term into a coefficient and its last letter, a length or velocity."""
    *before, (last, e) = term.factors or [(Letter("", (0, 0)), 0)]
    plain = all(isinstance(base, Letter) for base, _ in term.factors) and e == 1 and before
    moving = any(base.place[0] > MOVING for base, _ in term.factors)
    if not plain or moving or not isinstance(last, Letter):
        return None, None
    kind = last.place[0] == MOVING
    return (abs(term.number), tuple(before), kind), last


def _in_decimals(series: Series) -> bool:
    """Whether a series has measured numbers, as from URDF, rather than fractions of a law."""
    if not any(g.kind is Kind.PARAMETER for g in series.ring.generators):
        return True
    return series.denominator > _MEASURED
