"""Lay formulas out: extract signs, build fractions and roots in one walk over the tree."""

from __future__ import annotations

from collections.abc import Iterable
from fractions import Fraction
from typing import final

from mecanique.derivation.printing.formulas import FUNCTIONS, Base, Call, Letter, Product, Sum
from mecanique.derivation.printing.writers import Writer

_LARGE = 10**7  # numbers with more digits are written as decimals
_DECIMAL = 100  # a terminating number with a larger numerator, e.g. 981/100, becomes a decimal
_DIGITS = 13


def write(terms: Iterable[Product], writer: Writer, *, decimals: bool = False) -> str:
    """Write a sum in a format, its terms in the given order.

    Args:
        terms: the terms.
        writer: the format.
        decimals: whether fractions of numbers are written as decimals.
    """
    walk = _Walk(writer, decimals)
    return writer.sum([walk.term(term) for term in terms])


_HALF = Fraction(1, 2)


@final
class _Walk:
    """A walk over a formula that extracts signs and puts negative powers into denominators."""

    def __init__(self, writer: Writer, decimals: bool) -> None:
        self._writer = writer
        self._decimals = decimals
        self._written: dict[Sum, str] = {}

    def term(self, product: Product) -> tuple[bool, str]:
        """Return whether a product is negative, and the product written without its sign."""
        numerator, tail, denominator = list[str](), list[str](), list[str]()
        above = [factor for factor in product.factors if factor[1] > 0]
        below = [(base, -power) for base, power in product.factors if power < 0]
        over, under = self._number(product.number)
        numerator += over
        plain = [factor for factor in above if factor[0].place[0] < FUNCTIONS]
        alone = len(plain) == 1 and not over and bool(below or under)
        numerator += [self._factor(base, power, alone=alone) for base, power in plain]
        moving = above[len(plain) :]
        tail += [self._factor(base, power, alone=False) for base, power in moving]
        denominator += under
        alone = len(below) == 1 and not under
        denominator += [self._factor(base, power, alone=alone) for base, power in below]
        return product.number < 0, self._writer.term(numerator, denominator, tail)

    def _number(self, signed: int | Fraction) -> tuple[list[str], list[str]]:
        """Write a number without its sign, as numerator and denominator."""
        if signed in (1, -1):
            return [], []
        size = abs(Fraction(signed))
        above, below = size.numerator, size.denominator
        if max(above, below) >= _LARGE or (below > 1 and self._wants_decimal(size)):
            return [self._writer.number(_decimal(size))], []
        return (
            [self._writer.number(str(above))] if above != 1 else [],
            [self._writer.number(str(below))] if below != 1 else [],
        )

    def _wants_decimal(self, size: Fraction) -> bool:
        ends = 10**12 % size.denominator == 0
        measured = self._decimals and (ends or size.denominator >= _DECIMAL**2)
        return measured or (ends and size.numerator >= _DECIMAL)

    def sum(self, whole: Sum) -> str:
        """Write a sum, positive terms first; cached, as long equations repeat the same sums."""
        if whole not in self._written:
            self._written[whole] = self._writer.sum([self.term(term) for term in whole.terms])
        return self._written[whole]

    def _factor(self, base: Base, power: int | Fraction, *, alone: bool) -> str:
        """Write a power; a sum that is all of a numerator or denominator needs no brackets."""
        writer = self._writer
        if power != 1 and power == _HALF:
            return writer.call("sqrt", self._inner(base), "")
        exponent = "" if power == 1 else str(power)
        if isinstance(base, Letter):
            return writer.letter(base.name, base.of_time, exponent)
        if isinstance(base, Call):
            inner = self.sum(base.argument)
            return writer.call(base.function, inner, exponent, bare=_is_bare(base.argument))
        if alone and not exponent:
            return writer.alone(self.sum(base))
        return writer.brackets(self.sum(base), exponent)

    def _inner(self, base: Base) -> str:
        if isinstance(base, Sum):
            return self.sum(base)
        return self._factor(base, 1, alone=False)


def _is_bare(argument: Sum) -> bool:
    """Whether a function's argument needs no brackets: a letter or a multiple of one."""
    if len(argument.terms) != 1:
        return False
    (term,) = argument.terms
    letter = len(term.factors) == 1 and isinstance(term.factors[0][0], Letter)
    return letter and term.factors[0][1] == 1 and term.number > 0 and term.number.denominator == 1


def _decimal(value: Fraction) -> str:
    return f"{float(value):.{_DIGITS}g}".replace("e+", "e")
