"""Prove equality by algebra, in the ring of Poisson series that the derivation uses.

In this ring trigonometric identities hold by construction: two forms are equal exactly when their
difference has no terms. A submitted formula is read as a fraction of two series. Formulas without a
form in the ring, or with too many terms, are only compared in many states.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from fractions import Fraction
from functools import cached_property
from threading import Lock
from typing import final

from mecanique.checking.grammar.tree import Node, rate
from mecanique.derivation.scalars.functions import function_without_arcs
from mecanique.derivation.scalars.series import Kind, Series
from mecanique.derivation.symbolic.derivation import Derivation
from mecanique.derivation.symbolic.multipliers import cramer, determinant
from mecanique.errors import DerivationError, FormulaError, UnknownNameError

_MOST_PRODUCTS = 30_000
"""Largest number of products of terms for one formula, about 50 ms; longer ones are not proven."""

_LARGEST = 10**1000
"""Largest integer in a proof: powers of powers of a number near 1 would fill the memory."""

_MOST_UNKNOWNS = 3
"""Up to this many accelerations are eliminated by Cramer's rule; else single rows are compared."""


@final
@dataclass(frozen=True)
class _Fraction:
    """A quotient of two series."""

    above: Series
    below: Series


@final
class Proof:
    """Proves formulas about one mechanism."""

    def __init__(self, derivation: Derivation) -> None:
        self._derivation = derivation
        self._ring = derivation.algebra.ring
        self._one = self._ring.number(1)
        self._left = 0
        # reading a formula changes the ring, so formulas are read one at a time
        self._lock = Lock()

    def prove_motion(self, root: Node, letters: Mapping[str, Series] | None = None) -> bool:
        """Return whether a formula is proven to be zero in every true motion."""
        return self._prove(self._follows, root, letters or {})

    def prove_constant(self, root: Node, letters: Mapping[str, Series]) -> bool:
        """Return whether a formula is proven to depend on parameters alone."""
        return self._prove(_is_constant, root, letters)

    def prove_conservation(self, root: Node, rates: Mapping[str, Node | None]) -> bool:
        """Return whether the rate of a formula is proven to be zero in every true motion."""
        try:
            return self.prove_motion(rate(root, rates))
        except FormulaError:
            return False

    def _prove(
        self, holds: Callable[[_Fraction], bool], root: Node, letters: Mapping[str, Series]
    ) -> bool:
        with self._lock:
            try:
                self._left = _MOST_PRODUCTS
                return holds(self._read(root, letters))
            except (DerivationError, UnknownNameError, OverflowError):
                return False

    def _follows(self, fraction: _Fraction) -> bool:
        """Whether a fraction vanishes by the equations of motion and the constraints."""
        above = fraction.above
        if _is_zero(fraction.below):
            return False
        if _is_zero(above):
            return True
        derivation = self._derivation
        if derivation.ties or derivation.quasi:
            # times a number and powers of letters
            return any(self._has_ratio(above, series) for series in self._known)
        names = derivation.algebra.accelerations
        slopes, rest = above.linear(names)
        for row, force in zip(derivation.M, self._forces, strict=True):
            if self._is_row(slopes, rest, row, force):
                return True
        if len(names) > _MOST_UNKNOWNS:
            return False
        below, solution = self._solution
        terms = [self._multiply(rest, below)]
        terms += [self._multiply(a, b) for a, b in zip(slopes, solution, strict=True) if a]
        return _is_zero(self._ring.sum(terms))

    def _is_row(
        self, slopes: Sequence[Series], rest: Series, row: Sequence[Series], force: Series
    ) -> bool:
        """Whether Σ slopes a + rest is a multiple of Σ row a − force."""
        known = [k for k, entry in enumerate(row) if entry]
        if not known or any(bool(a) != bool(b) for a, b in zip(slopes, row, strict=True)):
            return False
        pivot = min(known, key=lambda k: len(row[k]) + len(slopes[k]))
        given_pivot, row_pivot = slopes[pivot], row[pivot]
        pairs = [(slopes[k], row[k]) for k in known if k != pivot] + [(rest, -force)]
        return all(
            _is_zero(self._multiply(a, row_pivot) - self._multiply(b, given_pivot))
            for a, b in pairs
        )

    def _has_ratio(self, above: Series, row: Series) -> bool:
        if above.parts.keys() != row.parts.keys():
            return False
        angle = next(iter(above.parts))
        # packed monomials of a product add up, and keep their order
        first, second = max(above.parts[angle]), max(row.parts[angle])
        given, known = above.parts[angle][first], row.parts[angle][second]
        ratio = Fraction(given * row.denominator, above.denominator * known)
        reach = above.reach + row.reach
        letters = Series(self._ring, {0: {first - second: 1}}, 1, reach)
        return _is_zero(above - row * letters * ratio)

    @cached_property
    def _known(self) -> tuple[Series, ...]:
        """The rows with multipliers, the constraints, and their rates."""
        identities = list(self._derivation.rows)
        for tie in self._derivation.ties:
            identities += [tie.demand, tie.demand.ddt(), tie.second]
        return tuple(series for series in identities if series)

    @cached_property
    def _forces(self) -> tuple[Series, ...]:
        """The right sides of M a = Q − h."""
        pairs = zip(self._derivation.Q, self._derivation.h, strict=True)
        return tuple(Q - h for Q, h in pairs)

    @cached_property
    def _solution(self) -> tuple[Series, list[Series]]:
        """The determinant of M, and the accelerations times this, by Cramer's rule."""
        M, forces = self._derivation.M, self._forces
        below = determinant(self._ring, M, self._multiply)
        return below, cramer(self._ring, M, forces, self._multiply)

    def _multiply(self, a: Series, b: Series) -> Series:
        self._left -= len(a) * len(b)
        if self._left < 0:
            raise DerivationError("the formula has too many terms to prove it")
        product = a * b
        numbers = [c for part in product.parts.values() for c in part.values()]
        if max([product.denominator, *map(abs, numbers)]) > _LARGEST:
            raise DerivationError("the formula has too long numbers to prove it")
        return product

    def _read(self, node: Node, letters: Mapping[str, Series]) -> _Fraction:
        """Read a formula as a fraction."""
        parts = [self._read(part, letters) for part in node.parts] if node.kind != "power" else []
        match node.kind:
            case "number":
                return self._whole(self._ring.number(node.value))
            case "letter" if node.name == "pi":
                return self._whole(self._ring.constant("pi"))
            case "letter":
                is_generator = node.name not in letters
                return self._whole(self._ring[node.name] if is_generator else letters[node.name])
            case "sum":
                return self._add(parts)
            case "negative":
                return _Fraction(-parts[0].above, parts[0].below)
            case "product":
                return self._product(parts)
            case "quotient":
                return self._product([parts[0], _invert(parts[1])])
            case "power":
                return self._power(node, letters)
            case "call":
                return self._call(node.name, parts)
        raise DerivationError("a matrix has no form in the ring")

    def _whole(self, series: Series) -> _Fraction:
        return _Fraction(series, self._one)

    def _add(self, terms: Sequence[_Fraction]) -> _Fraction:
        below_each = dict.fromkeys(term.below for term in terms)
        belows = [divisor for divisor in below_each if divisor != self._one]
        summed = []
        for term in terms:
            above = term.above
            for divisor in belows:
                above = above if divisor == term.below else self._multiply(above, divisor)
            summed.append(above)
        below = self._one
        for divisor in belows:
            below = self._multiply(below, divisor)
        return _Fraction(self._ring.sum(summed), below)

    def _product(self, factors: Sequence[_Fraction]) -> _Fraction:
        above = below = self._one
        for factor in factors:
            if factor.below.is_unit:
                above = self._multiply(above, self._multiply(factor.above, factor.below**-1))
                continue
            above = self._multiply(above, factor.above)
            below = self._multiply(below, factor.below)
        return _Fraction(above, below)

    def _power(self, node: Node, letters: Mapping[str, Series]) -> _Fraction:
        base = self._read(node.parts[0], letters)
        exponent, sign = node.parts[1], 1
        if exponent.kind == "negative":
            exponent, sign = exponent.parts[0], -1
        if exponent.kind != "number" or exponent.value.denominator != 1:
            raise DerivationError("a power has no form in the ring")
        count = int(exponent.value) * sign
        power = self._product([base if count > 0 else _invert(base)] * abs(count))
        return power if count else self._whole(self._one)

    def _call(self, name: str, parts: Sequence[_Fraction]) -> _Fraction:
        if name not in ("sin", "cos", "tan", "sqrt") or not parts[0].below.is_unit:
            raise DerivationError(f"{name} has no form in the ring")
        argument = parts[0].above * parts[0].below ** -1
        if name == "tan":
            sine, cosine = (
                function_without_arcs(circular)(argument) for circular in ("sin", "cos")
            )
            return _Fraction(sine, cosine)
        return self._whole(function_without_arcs(name)(argument))


def _invert(fraction: _Fraction) -> _Fraction:
    if _is_zero(fraction.above):
        raise DerivationError("a division by zero")
    return _Fraction(fraction.below, fraction.above)


def _is_constant(fraction: _Fraction) -> bool:
    kinds = {g.kind for g in (*fraction.above.generators(), *fraction.below.generators())}
    return bool(fraction.below) and kinds <= {Kind.PARAMETER, Kind.CONSTANT}


def _is_zero(series: Series) -> bool:
    return not series or series.vanishes()
