"""Lay formulas out: sort products, draw out signs and build fractions in one walk."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from fractions import Fraction
from functools import cache, lru_cache
from typing import Any, final

from mecanique.derivation.printing.writers import Writer

__all__ = ["FUNCTION_RANK", "SUM_RANK", "Notation", "write"]

SUM_RANK, FUNCTION_RANK = 10, 30
"""Places within a product: numbers, parameters, sums, lengths; then functions and motions."""

_LARGE = 10**7  # numbers with more digits are written as decimals


@final
@dataclass(frozen=True, eq=False)
class Notation:
    """What letters stand for, as far as it shows in print.

    Args:
        ranks: place of each letter within a product, by name.
        inputs: names of the functions of time.
    """

    ranks: Mapping[str, int]
    inputs: frozenset[str]


def write(terms: Iterable[tuple[Any, Any]], notation: Notation, writer: Writer) -> str:
    """Return the sum of coefficient × motion in a format, in the order given."""
    walk = _Walk(notation, writer)
    return writer.sum([walk.term([coefficient, motion]) for coefficient, motion in terms])


@final
class _Walk:
    """A walk over an expression: sort products, draw out signs, put negative powers below."""

    def __init__(self, notation: Notation, writer: Writer) -> None:
        self._notation = notation
        self._writer = writer
        self._terms: dict[tuple[Any, ...], tuple[bool, str]] = {}

    def term(self, expressions: Sequence[Any]) -> tuple[bool, str]:
        """Whether a product is negative, and the product without its sign."""
        # a sum's sign depends on those of its terms, which are therefore asked for at every depth
        key = tuple(expressions)
        if key not in self._terms:
            self._terms[key] = self._term(expressions)
        return self._terms[key]

    def _term(self, expressions: Sequence[Any]) -> tuple[bool, str]:
        number, factors = Fraction(1), []
        todo = list(expressions)
        while todo:
            factor = todo.pop(0)
            if factor.is_Mul:
                todo = [*factor.args, *todo]
            elif factor.is_Rational:
                number *= Fraction(int(factor.p), int(factor.q))
            else:
                base, exponent = factor.args if factor.is_Pow else (factor, None)
                power = (
                    Fraction(1) if exponent is None else Fraction(int(exponent.p), int(exponent.q))
                )
                if (
                    base.is_Add
                    and power.denominator == 1
                    and power % 2
                    and self._wants_flip(base, number < 0)
                ):
                    base, number = _negate(base), -number
                factors.append((base, power))
        above, tail, below = [], [], []
        for base, power in self._sort(factors):
            if power < 0:
                below.append((base, -power))
            elif self._rank(base) >= FUNCTION_RANK:
                tail.append(self._factor(base, power))
            else:
                above.append(self._factor(base, power))
        size, under = abs(number.numerator), number.denominator
        if max(size, under) >= _LARGE:
            above.insert(0, self._writer.number(_decimal(abs(number))))
        else:
            if size != 1:
                above.insert(0, self._writer.number(str(size)))
            if under != 1:
                below.insert(0, (under, Fraction(1)))
        return number < 0, self._writer.term(
            above, [self._factor(*factor) for factor in below], tail
        )

    def sum(self, expression: Any) -> str:
        """An expression as a sum, positive terms first."""
        parts = expression.args if expression.is_Add else (expression,)
        terms = [self.term([part]) for part in sorted(parts, key=_plain_first)]
        return self._writer.sum(sorted(terms, key=lambda term: term[0]))

    def _factor(self, base: Any, power: Fraction) -> str:
        writer = self._writer
        if isinstance(base, int) or base.is_Rational:
            inner = writer.number(str(base))
            return inner if power == 1 else writer.call("sqrt", inner, "")
        if power == Fraction(1, 2):
            return writer.call("sqrt", self.sum(base), "")
        exponent = "" if power == 1 else str(power)
        if base.is_Function:
            return writer.call(type(base).__name__, self.sum(base.args[0]), exponent)
        if base.is_Symbol or base.is_NumberSymbol:
            name = base.name if base.is_Symbol else str(base)
            return writer.letter(name, name in self._notation.inputs, exponent)
        return writer.brackets(self.sum(base), exponent)

    def _wants_flip(self, base: Any, negative: bool) -> bool:
        """Whether a factor reads better with its signs changed: if most are −."""
        minus = sum(self.term([part])[0] for part in base.args)
        return 2 * minus > len(base.args) or (2 * minus == len(base.args) and negative)

    def _rank(self, base: Any) -> int:
        if base.is_Symbol:
            return self._notation.ranks.get(base.name, 0)
        if base.is_Function:
            return FUNCTION_RANK
        return SUM_RANK if base.is_Add else -1

    def _sort(self, factors: list[tuple[Any, Fraction]]) -> list[tuple[Any, Fraction]]:
        """Factors by rank, then by their text, which is asked for only where it decides."""
        groups: dict[int, list[tuple[Any, Fraction]]] = {}
        for factor in factors:
            groups.setdefault(self._rank(factor[0]), []).append(factor)
        for group in groups.values():
            if len(group) > 1:
                group.sort(key=lambda factor: _name_first(factor[0]))
        return [factor for rank in sorted(groups) for factor in groups[rank]]


def _name_first(base: Any) -> tuple[str, str]:
    """The text of a factor; of a function its name, sin before cos, whatever they are of."""
    if not base.is_Function:
        return _text(base), ""
    name = type(base).__name__
    return {"sin": "a", "cos": "b"}.get(name, name), _text(base.args[0])


@lru_cache(maxsize=1 << 14)
def _text(expression: Any) -> str:
    """Return sympy's text of an expression, which is slow to come by and sorts many products."""
    return str(_printer().doprint(expression))


@cache
def _printer() -> Any:
    """Make sympy's own printer that keeps what it has written; sums are parts of other sums."""
    from sympy.printing.str import StrPrinter

    class Keeping(StrPrinter):  # type: ignore[misc]
        def _print(self, expr: Any, **options: Any) -> str:
            return write_once(expr) if not options else str(super()._print(expr, **options))

    @lru_cache(maxsize=1 << 14)
    def write_once(expression: Any) -> str:
        return str(StrPrinter._print(printer, expression))

    printer = Keeping()
    return printer


def _negate(base: Any) -> Any:
    from sympy import Add

    return Add(*(-part for part in base.args))


def _decimal(number: Fraction) -> str:
    return f"{float(number):.10g}".replace("e+", "e")


def _plain_first(expression: Any) -> tuple[bool, str]:
    """Terms without functions come first, then by their letters."""
    _, rest = expression.as_coeff_Mul()
    return any(part.is_Function for part in rest.args or (rest,)), _text(rest) if rest != 1 else ""
