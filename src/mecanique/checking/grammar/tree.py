"""Represent formulas as trees: numbers, letters, sums, products, powers and functions."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, replace
from fractions import Fraction
from typing import Any, Literal, TypeAlias, final

import numpy as np

from mecanique.arrays import Array
from mecanique.checking.budget import MOST_PARTS, TOO_LONG, spend
from mecanique.errors import FormulaError

Kind: TypeAlias = Literal[
    "number", "letter", "sum", "product", "quotient", "power", "negative", "call", "table"
]

MOST_DEPTH = 120
"""Deepest nesting of a formula; printed formulas stay below 20."""


@final
@dataclass(frozen=True, slots=True)
class Node:
    """A part of a formula."""

    kind: Kind
    # its own parts: numerator and denominator of a quotient, base and exponent of a power, entries
    # of a table row by row
    parts: tuple[Node, ...] = ()
    name: str = ""  # name of a letter or a function
    value: Fraction = Fraction(0)
    start: int = 0  # its first position in the text
    end: int = 0  # the position after it in the text
    depth: int = 1
    size: int = 1  # number of its parts, itself included; shared ones count as often as they occur
    columns: int = 0  # number of columns of a table

    def at(self, start: int, end: int) -> Node:
        """Return the same part at another position in the text."""
        return replace(self, start=start, end=end)

    def put_at(self, place: int) -> Node:
        """Return the same part with all positions set to one, as it is not written in the text."""
        spend(1)
        parts = tuple(part.put_at(place) for part in self.parts)
        return replace(self, parts=parts, start=place, end=place)

    def quote(self, text: str) -> str:
        """Return it as it was written in a text; empty if it is not written there."""
        return " ".join(text[self.start : self.end].split())

    def walk(self) -> Iterator[Node]:
        """Yield this and all parts below it."""
        yield self
        for part in self.parts:
            yield from part.walk()

    @property
    def letters(self) -> set[str]:
        """The names of all letters in it."""
        return {node.name for node in self.walk() if node.kind == "letter"}

    @property
    def is_zero(self) -> bool:
        """Whether it is the number zero."""
        return self.kind == "number" and not self.value


def rename(node: Node, names: Mapping[str, str]) -> Node:
    """Return a part with letters in place of others."""
    if node.kind == "letter":
        return replace(node, name=names.get(node.name, node.name))
    return replace(node, parts=tuple(rename(part, names) for part in node.parts))


def substitute(node: Node, name: str, formula: Node) -> Node:
    """Return a part with a formula in place of a letter, at the same position."""
    if node.kind == "letter" and node.name == name:
        return formula.put_at(node.start)
    if name not in node.letters:
        return node
    parts = [substitute(part, name, formula) for part in node.parts]
    match node.kind:
        case "sum":
            built = add(*parts)
        case "product":
            built = multiply(*parts)
        case "negative":
            built = negate(parts[0])
        case _:
            built = compound(node.kind, *parts, name=node.name, columns=node.columns)
    return built.at(node.start, node.end)


def number(value: Fraction | int) -> Node:
    """Return a number."""
    return Node("number", value=Fraction(value))


def letter(name: str) -> Node:
    """Return a letter."""
    return Node("letter", name=name)


def compound(kind: Kind, *parts: Node, name: str = "", columns: int = 0) -> Node:
    """Return a part made of others, at their position."""
    spend(1)
    depth = 1 + max(part.depth for part in parts)
    if depth > MOST_DEPTH:
        raise FormulaError(f"the formula is nested more than {MOST_DEPTH} deep; write it as a sum")
    size = 1 + sum(part.size for part in parts)
    if size > MOST_PARTS:
        raise FormulaError(TOO_LONG)
    start, end = min(part.start for part in parts), max(part.end for part in parts)
    return Node(kind, parts, name, start=start, end=end, depth=depth, size=size, columns=columns)


def _flatten(kind: Kind, parts: tuple[Node, ...]) -> Iterator[Node]:
    for part in parts:
        if part.kind == kind:
            yield from part.parts
        else:
            yield part


def add(*parts: Node) -> Node:
    """Return the sum of parts, without zeros."""
    terms = [part for part in _flatten("sum", parts) if not part.is_zero]
    if not terms:
        return number(0)
    return terms[0] if len(terms) == 1 else compound("sum", *terms)


def multiply(*parts: Node) -> Node:
    """Return the product of parts."""
    factors = list(_flatten("product", parts))
    if any(part.is_zero for part in factors):
        return number(0)
    factors = [part for part in factors if not (part.kind == "number" and part.value == 1)]
    if not factors:
        return number(1)
    return factors[0] if len(factors) == 1 else compound("product", *factors)


def negate(part: Node) -> Node:
    """Return a part with the opposite sign."""
    if part.kind == "negative":
        return part.parts[0]
    return part if part.is_zero else compound("negative", part)


def divide(above: Node, below: Node) -> Node:
    """Return a quotient."""
    return compound("quotient", above, below)


def raise_to(base: Node, exponent: Node) -> Node:
    """Return a power."""
    return compound("power", base, exponent)


def call(name: str, *arguments: Node) -> Node:
    """Return a function of its arguments."""
    return compound("call", *arguments, name=name)


def _square(part: Node) -> Node:
    return raise_to(part, number(2))


@final
@dataclass(frozen=True)
class Function:
    """A function of formulas."""

    value: Callable[..., Any] | None = None  # of arrays; None where a formula takes its place
    slope: Callable[[Node], Node] | None = None  # the derivative by its only argument
    spellings: tuple[str, ...] = ()  # its other names
    arguments: int = 1  # their number


def _invert_cosine(x: Node) -> Node:
    """Return 1/√(1 − x²), the derivative of the arcsine."""
    return divide(number(1), call("sqrt", add(number(1), negate(_square(x)))))


def _quarter_period(m: Array) -> Array:
    """Return K(m), the complete elliptic integral of the first kind."""
    from scipy.special import ellipk  # wanted by few formulas

    return np.asarray(ellipk(m))


FUNCTIONS: Mapping[str, Function] = {
    "sin": Function(np.sin, lambda x: call("cos", x), ("sen",)),
    "cos": Function(np.cos, lambda x: negate(call("sin", x))),
    "tan": Function(np.tan, lambda x: divide(number(1), _square(call("cos", x))), ("tg",)),
    "cot": Function(spellings=("ctg", "cotg", "cotan")),
    "sec": Function(),
    "csc": Function(spellings=("cosec",)),
    "asin": Function(np.arcsin, _invert_cosine, ("arcsin", "arcsen", "ArcSin")),
    "acos": Function(np.arccos, lambda x: negate(_invert_cosine(x)), ("arccos", "ArcCos")),
    "atan": Function(
        np.arctan,
        lambda x: divide(number(1), add(number(1), _square(x))),
        ("arctan", "arctg", "ArcTan"),
    ),
    "atan2": Function(np.arctan2, spellings=("arctan2",), arguments=2),
    "sinh": Function(np.sinh, lambda x: call("cosh", x), ("senh",)),
    "cosh": Function(np.cosh, lambda x: call("sinh", x)),
    "tanh": Function(np.tanh, lambda x: divide(number(1), _square(call("cosh", x)))),
    "exp": Function(np.exp, lambda x: call("exp", x)),
    "log": Function(np.log, lambda x: divide(number(1), x), ("ln",)),
    "sqrt": Function(np.sqrt, lambda x: divide(number(1), multiply(number(2), call("sqrt", x)))),
    "abs": Function(np.abs, lambda x: call("sign", x), ("Abs",)),
    "sign": Function(np.sign, lambda _: number(0), ("sgn",)),
    "pow": Function(arguments=2),
    "ellipk": Function(_quarter_period, spellings=("EllipticK",)),
    "ellipk_of_modulus": Function(lambda k: _quarter_period(k * k)),
    "integral": Function(arguments=4),
    "det": Function(spellings=("Det",)),
}
"""The functions of formulas, by name."""


def rate(node: Node, rates: Mapping[str, Node | None]) -> Node:
    """Return the time derivative of a formula."""
    return _rate(node, rates).at(node.start, node.end)


def _rate(node: Node, rates: Mapping[str, Node | None]) -> Node:
    if node.kind == "letter":
        letter_rate = rates.get(node.name, number(0))
        if letter_rate is None:
            raise FormulaError(f"the time derivative of {node.name} is not known here")
        return letter_rate
    slopes = [_rate(part, rates) for part in node.parts]
    match node.kind:
        case "sum":
            return add(*slopes)
        case "negative":
            return negate(slopes[0])
        case "table":
            return compound("table", *slopes, columns=node.columns)
        case "product":
            terms = []
            for k, slope in enumerate(slopes):
                terms.append(multiply(*node.parts[:k], slope, *node.parts[k + 1 :]))
            return add(*terms)
        case "quotient":
            above, below = node.parts
            terms = [] if slopes[0].is_zero else [divide(slopes[0], below)]
            if not slopes[1].is_zero:
                terms.append(negate(divide(multiply(above, slopes[1]), _square(below))))
            return add(*terms)
        case "power" if not slopes[1].is_zero:
            what = "the time derivative of a power with a changing exponent is not known"
            raise FormulaError(what)
    if all(slope.is_zero for slope in slopes):
        return number(0)
    if node.kind == "power":
        base, exponent = node.parts
        less = add(exponent, negate(number(1)))
        if exponent.kind == "number":
            less = number(exponent.value - 1)
        return multiply(exponent, raise_to(base, less), slopes[0])
    function = FUNCTIONS.get(node.name)
    if function is not None and function.slope is not None:
        return multiply(function.slope(node.parts[0]), slopes[0])
    raise FormulaError(f"the time derivative of {node.name or 'a table'} is not known here")
