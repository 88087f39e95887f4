"""Build the tree of a formula from its tokens."""

from __future__ import annotations

from collections.abc import Sequence
from fractions import Fraction
from typing import Any, final

from lark import Token as LarkToken
from lark.exceptions import VisitError
from lark.visitors import Transformer_NonRecursive

from mecanique.checking.grammar import tree
from mecanique.checking.grammar.letters import Letters
from mecanique.checking.grammar.tree import FUNCTIONS, Node
from mecanique.errors import FormulaError

_MOST_POWERS = 4
_MOST_EXPONENT = 64
_MOST_DIGITS = 40
_MOST_FACTORS = 64


def build_tree(parsed: Any, letters: Letters, text: str) -> list[list[Node]]:
    """Build the sides of each statement from the parser's tree.

    Args:
        parsed: the parser's tree.
        letters: the letters that a formula may contain.
        text: the original text, for error messages.

    Raises:
        FormulaError: if a number, a power or a call is not understood.
    """
    try:
        return _Builder(letters, text).transform(parsed)  # type: ignore[no-any-return]
    except VisitError as error:
        if isinstance(error.orig_exc, FormulaError):
            raise error.orig_exc from None
        raise


@final
class _Builder(Transformer_NonRecursive[Any, Any]):
    """Builds the tree of a formula from its tokens."""

    def __init__(self, letters: Letters, text: str) -> None:
        super().__init__()
        self._letters = letters
        self._text = text

    def start(self, statements: list[list[Node]]) -> list[list[Node]]:
        return statements

    def statement(self, sides: list[Node]) -> list[Node]:
        return sides

    def number(self, parts: list[LarkToken]) -> Node:
        (token,) = parts
        mantissa, _, exponent = token.lower().partition("e")
        place = token.start_pos or 0
        if len(mantissa) > _MOST_DIGITS:
            what = f"expected a number of at most {_MOST_DIGITS} digits"
            raise FormulaError(what, self._text, place)
        # a long exponent is not read as a number at all: that takes the square of its length
        if len(exponent) > _MOST_DIGITS or abs(int(exponent or 0)) > _MOST_EXPONENT:
            what = (
                f"expected a number of at most 1e{_MOST_EXPONENT}, and at least 1e-{_MOST_EXPONENT}"
            )
            raise FormulaError(what, self._text, place)
        return tree.number(Fraction(token)).at(token.start_pos or 0, token.end_pos or 0)

    def negative_number(self, parts: list[LarkToken]) -> Node:
        return tree.negate(self.number(parts[1:])).at(
            parts[0].start_pos or 0, parts[1].end_pos or 0
        )

    def name(self, parts: list[LarkToken]) -> Node:
        (token,) = parts
        return self._letters.node(str(token)).at(token.start_pos or 0, token.end_pos or 0)

    def positive(self, parts: list[Any]) -> Node:
        return _place(parts[1], parts)

    def negative(self, parts: list[Any]) -> Node:
        return _place(tree.negate(parts[1]), parts)

    def plus(self, parts: list[Any]) -> Node:
        return _place(tree.add(parts[0], parts[2]), parts)

    def minus(self, parts: list[Any]) -> Node:
        term = tree.negate(parts[2])
        term = term if term.is_zero else term.at(parts[1].start_pos, parts[2].end)
        return _place(tree.add(parts[0], term), parts)

    def times(self, parts: list[Any]) -> Node:
        return _place(self._product(parts[0], parts[2]), parts)

    def juxtaposition(self, parts: list[Any]) -> Node:
        return _place(self._product(*parts), parts)

    def _product(self, first: Node, second: Node) -> Node:
        if first.kind == "product" and len(first.parts) >= _MOST_FACTORS:
            raise FormulaError(
                f"expected at most {_MOST_FACTORS} factors in a product", self._text, second.start
            )
        return tree.multiply(first, second)

    def over(self, parts: list[Any]) -> Node:
        return _place(tree.divide(parts[0], parts[2]), parts)

    def fraction(self, parts: list[Any]) -> Node:
        return _place(tree.divide(parts[2], parts[5]), parts)

    def power(self, parts: list[Any]) -> Node:
        return _place(self._power(parts[0], parts[2]), parts)

    def _power(self, base: Node, exponent: Node) -> Node:
        chain, top = 0, exponent
        while top.kind == "power":
            top, chain = top.parts[1], chain + 1
        if chain >= _MOST_POWERS:
            raise FormulaError("expected fewer powers of powers", self._text, exponent.start)
        if exponent.kind == "number" and abs(exponent.value) > _MOST_EXPONENT:
            raise FormulaError(
                f"expected an exponent of at most {_MOST_EXPONENT}", self._text, exponent.start
            )
        return tree.raise_to(base, exponent)

    def time_derivative(self, parts: list[Any]) -> Node:
        return _place(self._rate(parts[1]), parts)

    def prime(self, parts: list[Any]) -> Node:
        return _place(self._rate(parts[0]), parts)

    def _rate(self, node: Node) -> Node:
        try:
            return tree.rate(node, self._letters.rate_nodes).put_at(node.start)
        except FormulaError as error:
            raise FormulaError(str(error), self._text, node.start) from None

    def brackets(self, parts: list[Any]) -> Node:
        return _place(parts[1], parts)

    def cells(self, parts: list[Node]) -> list[Node]:
        return parts

    def rows(self, parts: list[list[Node]]) -> list[list[Node]]:
        return parts

    def square(self, parts: list[Any]) -> Node:
        rows: list[list[Node]] = parts[1]
        if len(rows) == 1 and len(rows[0]) == 1:
            return _place(rows[0][0], parts)
        return _place(self._table(rows), parts)

    def _table(self, rows: list[list[Node]]) -> Node:
        if len(rows) == 1 and any(cell.kind == "table" for cell in rows[0]):
            # the brackets of a row with one entry were read as those of a sum
            rows = [list(cell.parts) if cell.kind == "table" else [cell] for cell in rows[0]]
        width = len(rows[0])
        if any(len(row) != width for row in rows):
            place = rows[0][0].start
            raise FormulaError("expected rows of one length in a matrix", self._text, place)
        entries = [cell for row in rows for cell in row]
        if any(cell.kind == "table" for cell in entries):
            raise FormulaError("a matrix within a matrix", self._text, entries[0].start)
        return tree.compound("table", *entries, columns=width)

    def argument(self, parts: list[Any]) -> Node:
        return _place(tree.compound("table", *parts[1]), parts)

    def argument_fraction(self, parts: list[Any]) -> Node:
        return _place(tree.compound("table", self.fraction(parts)), parts)

    def function(self, parts: list[Any]) -> Node:
        token, arguments = parts
        return _place(self._call(token, arguments.parts), parts)

    def raised_function(self, parts: list[Any]) -> Node:
        token, _, exponent, arguments = parts
        inverse = exponent.kind == "negative" and exponent.parts[0].value == 1
        if inverse and token in ("sin", "cos", "tan"):
            inverted = token.update(value=f"a{token}")
            return _place(self._call(inverted, arguments.parts), parts)
        return _place(self._power(self._call(token, arguments.parts), exponent), parts)

    def _call(self, token: LarkToken, arguments: Sequence[Node]) -> Node:
        wanted = FUNCTIONS[token]
        if len(arguments) != wanted:
            raise FormulaError(
                f"expected {wanted} argument{'s' if wanted > 1 else ''} of {token}, got "
                f"{len(arguments)}",
                self._text,
                token.start_pos or 0,
            )
        if token == "pow":
            return self._power(*arguments)
        return tree.call(str(token), *arguments)

    def sympy(self, parts: list[Any]) -> Node:
        token, _, rows, _ = parts
        arguments: list[Node] = [cell for row in rows for cell in row]
        if token == "Matrix" and len(arguments) == 1 and arguments[0].kind == "table":
            return _place(arguments[0], parts)
        if token == "Matrix" and len(rows) == 1:
            return _place(self._table([[cell] for cell in arguments]), parts)
        if token == "Rational" and len(arguments) == 2:
            return _place(tree.divide(*arguments), parts)
        if token == "Eq" and len(arguments) == 2:
            return _place(tree.compound("call", *arguments, name="Eq"), parts)
        if token == "Derivative" and arguments[1:] and arguments[1].name == "t":
            return _place(self._rate(arguments[0]), parts)
        raise FormulaError(f"expected {token} as SymPy prints it", self._text, token.start_pos or 0)


def _place(node: Node, parts: list[Any]) -> Node:
    first, last = parts[0], parts[-1]
    start = first.start if isinstance(first, Node) else (first.start_pos or 0)
    end = last.end_pos if isinstance(last, LarkToken) else last.end
    return node.at(start, max(start, end or start))
