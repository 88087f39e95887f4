"""Read the formulas of a listing, and bring them into textbook order for any writer."""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass
from fractions import Fraction
from typing import final

from mecanique.derivation.printing.formulas import (
    MOVING,
    SUMS,
    Base,
    Call,
    Letter,
    Product,
    Sum,
    add,
    multiply,
    names_in,
    number,
)

_TOKEN = re.compile(r"\d[\d.]*(?:e[+-]?\d+)?|δ?[^\W\d]\w*'*|[-+*/()]")
_HALF = Fraction(1, 2)


@final
@dataclass(frozen=True)
class ResultLine:
    """A named result: name = sum."""

    name: str
    right: Sum


def read_formula(text: str, known: Mapping[str, Product]) -> Sum:
    """Read a formula, e.g. "m * (x' + 2.0)", and collect equal terms."""
    return _Reader(_TOKEN.findall(text), known).read_sum()


def tidy(
    lines: Sequence[str], results: Sequence[str], known: Mapping[str, Product], fresh: str
) -> tuple[list[ResultLine], list[Sum]]:
    """Read a listing, and remove results that only repeat others or are not used."""
    once = frozenset[str]()
    for _ in range(2):
        kept, ends = _read(lines, results, known, fresh, once)
        rights = [line.right for line in kept]
        uses = Counter(name for part in (*ends, *rights) for name in _letters(part))
        once = frozenset(
            part.name for part in kept if uses[part.name] == 1 and len(part.right.terms) == 1
        )
    return kept, ends


def _read(
    lines: Sequence[str],
    results: Sequence[str],
    known: Mapping[str, Product],
    fresh: str,
    once: Collection[str],
) -> tuple[list[ResultLine], list[Sum]]:
    """Read the listing, and substitute results that are used once."""
    fresh_name = re.compile(rf"{fresh}\d+")
    letters, lines_read = dict(known), list[ResultLine]()
    for line in lines:
        name, text = line.split(" = ", 1)
        right = read_formula(text, letters)
        if not fresh_name.fullmatch(name):
            lines_read.append(ResultLine(name, right))
        elif len(right.terms) < 2 and (name in once or _is_plain(right)):
            letters[name] = right.terms[0] if right.terms else number(0)
        else:
            lines_read.append(ResultLine(name, right))
    ends = [read_formula(text, letters) for text in results]
    needed = frozenset[str]().union(*(names_in(end) for end in ends))
    kept = list[ResultLine]()
    for one in reversed(lines_read):
        if one.name in needed:
            needed |= names_in(one.right)
            kept.append(one)
    return kept[::-1], ends


def _letters(part: Sum | Product | Base) -> Iterator[str]:
    """Yield every letter in a formula, as often as it occurs."""
    if isinstance(part, Letter):
        yield part.name
    elif isinstance(part, Call):
        yield from _letters(part.argument)
    else:
        inner = part.terms if isinstance(part, Sum) else [base for base, _ in part.factors]
        for inner_part in inner:
            yield from _letters(inner_part)


def _is_plain(whole: Sum) -> bool:
    """Whether a sum is a number, or a number times one letter."""
    factors = [factor for term in whole.terms for factor in term.factors]
    alone = len(factors) <= len(whole.terms) <= 1
    return alone and all(isinstance(base, Letter) and power == 1 for base, power in factors)


@final
class _Reader:
    """Reads tokens from left to right."""

    def __init__(self, tokens: list[str], known: Mapping[str, Product]) -> None:
        self._tokens = [*tokens, ""]
        self._place = 0
        self._known = known

    def read_sum(self) -> Sum:
        """Return the next sum."""
        terms = [self._read_term(negative=self._take("-"))]
        while self._tokens[self._place] in ("+", "-"):
            terms.append(self._read_term(negative=self._next() == "-"))
        return _draw_together(add(terms))

    def _read_term(self, *, negative: bool) -> Product:
        factors = multiply(self._read_factor())
        while self._tokens[self._place] in ("*", "/"):
            below = self._next() == "/"
            factor = multiply(self._read_factor())
            factors = multiply(factors, _invert(factor) if below else factor)
        return multiply(number(-1), factors) if negative else factors

    def _read_factor(self) -> Product | Base | tuple[Base, Fraction]:
        token = self._next()
        if token == "(" or self._take("("):
            inner = self.read_sum()
            self._place += 1
            if token == "(":
                return inner
            if token == "sqrt":
                return inner, _HALF
            return Call("Abs" if token == "abs" else token, inner)
        if token[0].isdigit():
            return number(Fraction(token))
        if token in self._known:
            return self._known[token]
        return Letter(token, (MOVING if token.endswith("'") else SUMS + 1, 0))

    def _next(self) -> str:
        self._place += 1
        return self._tokens[self._place - 1]

    def _take(self, token: str) -> bool:
        matches = self._tokens[self._place] == token
        self._place += matches
        return matches


def _invert(factor: Product) -> Product:
    powers = tuple((base, -power) for base, power in factor.factors)
    return Product(1 / Fraction(factor.number), powers)


def _draw_together(whole: Sum) -> Sum:
    """Collect terms that differ only in their numbers."""
    sizes: dict[tuple[tuple[Base, int | Fraction], ...], int | Fraction] = {}
    for term in whole.terms:
        sizes[term.factors] = sizes.get(term.factors, 0) + term.number
    return add(Product(size, factors) for factors, size in sizes.items())
