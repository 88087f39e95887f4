"""Represent formulas as trees: sums of products of letters, functions and sums, in book order."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from fractions import Fraction
from functools import cached_property
from typing import Any, TypeAlias, final

SUMS, FUNCTIONS, MOVING = 10, 30, 32
"""Order within a product: parameters, then sums and lengths, then functions, then motions."""

_FIRST = ("sin", "cos")
"""Functions that precede others."""

Place: TypeAlias = "tuple[Any, ...]"
"""A sort key within a product or sum; keys of one length and kind are compared."""


@final
@dataclass(frozen=True, slots=True)
class Letter:
    """A named quantity."""

    name: str  # its name, e.g. "q''"
    # its sort key in a product: the kind of factor, then the author's order
    place: tuple[float, float]
    of_time: bool = False  # whether it is a given function of time, F(t)

    def sympy(self) -> Any:
        """Return the letter as a sympy symbol."""
        from sympy import Symbol, pi

        return pi if self.name == "pi" else Symbol(self.name)


@final
@dataclass(frozen=True)
class Call:
    """A function of a sum."""

    function: str
    argument: Sum

    @cached_property
    def _hash(self) -> int:
        return hash((self.function, self.argument))

    def __hash__(self) -> int:
        return self._hash

    @cached_property
    def place(self) -> Place:
        """Its sort key in a product: sin before cos, then by the letters of the argument."""
        first = _FIRST.index(self.function) if self.function in _FIRST else len(_FIRST)
        order: list[float] = [first]
        for term in self.argument.terms:
            for base, _ in term.factors:
                order.append(base.place[1] if isinstance(base, Letter) else 0)
        return (FUNCTIONS, tuple(order))

    def sympy(self) -> Any:
        """Return the function as a sympy expression; sines are not evaluated."""
        import sympy

        function = getattr(sympy, self.function)
        evaluate = self.function not in _FIRST
        return function(self.argument.sympy(), evaluate=evaluate)


@final
@dataclass(frozen=True)
class Product:
    """A rational number times powers, in order."""

    number: int | Fraction  # the factor before all
    factors: tuple[tuple[Base, int | Fraction], ...] = ()

    @cached_property
    def _hash(self) -> int:
        return hash((self.number, self.factors))

    def __hash__(self) -> int:
        return self._hash

    @cached_property
    def order(self) -> Place:
        """Its sort key in a sum: products without functions first, then by letters."""
        called = any(base.place[0] == FUNCTIONS for base, _ in self.factors)
        places = [(_flat(base.place), -power) for base, power in self.factors]
        return (called, tuple(places))

    def sympy(self) -> Any:
        """Return the product as a sympy expression; a number is not distributed over a sum."""
        from sympy import Integer, Mul, Pow, Rational

        parts = []
        if self.number != 1:
            parts.append(Rational(self.number.numerator, self.number.denominator))
        for base, power in self.factors:
            shown = base.sympy()
            exponent = Rational(power.numerator, power.denominator)
            parts.append(shown if power == 1 else Pow(shown, exponent))
        if len(parts) < 2:
            return parts[0] if parts else Integer(1)
        return Mul(*parts, evaluate=not any(isinstance(base, Sum) for base, _ in self.factors))


@final
@dataclass(frozen=True)
class Sum:
    """A sum of products, in order; made by `add`."""

    terms: tuple[Product, ...]

    @cached_property
    def _hash(self) -> int:
        return hash(self.terms)

    def __hash__(self) -> int:
        return self._hash

    @cached_property
    def place(self) -> Place:
        """Its sort key in a product: that of its letters if these are parameters, else later."""
        firsts = [term.factors[0][0] for term in self.terms if term.factors]
        fixed = all(base.place[0] < SUMS for term in self.terms for base, _ in term.factors)
        if fixed and len(firsts) == len(self.terms):
            dimension = {base.place[0] for base in firsts}
            if len(dimension) == 1:
                return (dimension.pop(), firsts[0].place[1] + 0.5)
        return (SUMS, firsts[0].place[1] if firsts and firsts[0].place[0] < FUNCTIONS else 0)

    def sympy(self) -> Any:
        """Return the sum as a sympy expression."""
        from sympy import Add

        return Add(*(term.sympy() for term in self.terms))

    def negative(self) -> Sum:
        """Return the sum with all signs changed."""
        return add(Product(-term.number, term.factors) for term in self.terms)


Base: TypeAlias = "Letter | Call | Sum"


def number(value: Fraction | int) -> Product:
    """Return a number as a product."""
    return Product(value)


def add(terms: Iterable[Product]) -> Sum:
    """Return a sum of products, positive ones first; sums among them are opened."""
    parts = [part for term in terms for part in open_sum(term)]
    if len(parts) == 1 and parts[0].number:
        return Sum((parts[0],))
    nonzero = [part for part in parts if part.number]
    return Sum(tuple(sorted(nonzero, key=lambda part: (part.number.numerator < 0, part.order))))


def multiply(*parts: Product | Base | tuple[Base, Fraction | int]) -> Product:
    """Multiply: merge powers of one base, and negate a sum with more minus than plus signs."""
    size: int | Fraction = 1
    powers = dict[Base, "int | Fraction"]()
    todo = list(reversed(parts))
    while todo:
        part = todo.pop()
        if isinstance(part, Product):
            size = part.number if size == 1 else size * part.number
            todo += reversed(part.factors)
            continue
        base, power = part if isinstance(part, tuple) else (part, 1)
        if isinstance(base, Sum) and len(base.terms) < 2 and power.denominator == 1:
            inner = base.terms[0] if base.terms else number(0)
            if inner.number != 1:
                size = size * Fraction(inner.number) ** int(power)
            todo += [(b, p * power) for b, p in reversed(inner.factors)]
            continue
        powers[base] = powers.get(base, 0) + power
    if not size:
        return number(0)
    factors: list[tuple[Base, int | Fraction]] = []
    for base, power in powers.items():
        if not power:
            continue
        odd = isinstance(base, Sum) and power.denominator == 1 and power % 2
        if odd and isinstance(base, Sum) and _wants_turn(base, size < 0 < power):
            base, size = base.negative(), -size
        factors.append((base, power))
    if len(factors) > 1:
        factors.sort(key=lambda factor: _flat(factor[0].place))
    return Product(size, tuple(factors))


def draw_number(terms: Sequence[Product]) -> Product:
    """Return a sum as a product, the number that its terms share in front."""
    measure = math.gcd(*(term.number.numerator for term in terms))
    if measure < 2 or any(term.number.denominator > 1 for term in terms):
        return multiply(add(terms))
    return multiply(
        number(measure), add(Product(term.number // measure, term.factors) for term in terms)
    )


def _wants_turn(whole: Sum, negative: bool) -> bool:
    """Whether a sum reads better negated: if most of its signs are −."""
    # A sign before a fraction does not turn its denominator. If one of two terms is negative, the
    # one that changes in time comes last: l − w t
    minus = sum(term.number < 0 for term in whole.terms)
    plus = len(whole.terms) - minus
    if minus != plus:
        return minus > plus
    last = whole.terms[0].factors
    if any(isinstance(base, Letter) and base.name == "t" for base, _ in last):
        return True
    held = [base for term in whole.terms[1:] for base, _ in term.factors]
    return negative and not any(isinstance(base, Letter) and base.name == "t" for base in held)


def open_sum(term: Product) -> tuple[Product, ...]:
    """Return the terms if the product is a sum or its negative, else the product itself."""
    if abs(term.number) == 1 and len(term.factors) == 1:
        base, power = term.factors[0]
        if isinstance(base, Sum) and power == 1:
            return tuple(Product(term.number * part.number, part.factors) for part in base.terms)
    return (term,)


def list_letters(part: Sum | Product | Base) -> Iterator[str]:
    """Yield the name of every letter in a formula, as often as it occurs."""
    if isinstance(part, Letter):
        yield part.name
    elif isinstance(part, Call):
        yield from list_letters(part.argument)
    else:
        inner = part.terms if isinstance(part, Sum) else [base for base, _ in part.factors]
        for inner_part in inner:
            yield from list_letters(inner_part)


def names_in(part: Product | Base) -> frozenset[str]:
    """Return the names of the letters in a formula."""
    return frozenset(list_letters(part))


def _flat(place: Place) -> Place:
    """Flatten a sort key into parts that can be compared with those of any other."""
    major, minor = place
    return (major, minor if isinstance(minor, tuple) else (minor,))
