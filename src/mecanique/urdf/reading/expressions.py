"""Expressions in attributes of URDF: read without executing anything, and written in full."""

from __future__ import annotations

import ast
import operator
from collections.abc import Callable, Mapping
from typing import Any

from mecanique.model.expression import FUNCTIONS, Scalar, coordinate, plain, time
from mecanique.urdf.reading.fields import Passage

_LONGEST = 2000
"""Characters of an expression; longer ones are refused."""

_OPERATIONS: dict[type[ast.AST], Callable[..., Any]] = {
    ast.Add: operator.add,
    ast.Sub: operator.sub,
    ast.Mult: operator.mul,
    ast.Div: operator.truediv,
    ast.Pow: operator.pow,
    ast.USub: operator.neg,
    ast.UAdd: operator.pos,
}
_MOST = 100
"""Powers beyond this are refused, and powers of powers whose exponents multiply to more."""


def rename(
    scalar: Scalar, letters: Mapping[str, str], values: Mapping[str, float] | None = None
) -> Scalar:
    """Return a scalar with other letters for some, after some have got their values."""
    scalar = plain(scalar)
    if isinstance(scalar, float) or not (letters or values):
        return scalar
    numbers = {coordinate(name): value for name, value in (values or {}).items()}
    others = {coordinate(old): coordinate(new) for old, new in letters.items()}
    return scalar.subs(numbers).subs(others, simultaneous=True)


def read_expression(place: Passage, attribute: str, letters: str) -> Scalar | None:
    """Return an attribute as an expression in certain letters; nothing in it is executed."""
    text = place.element.attributes.get(attribute, "")
    try:
        if len(text) > _LONGEST:
            raise ValueError("it is too long")
        return plain(_value(ast.parse(text.strip(), mode="eval").body))
    except (SyntaxError, ValueError, ArithmeticError, RecursionError, MemoryError) as error:
        expected = f"expected an expression in {letters}"
        said = f"{expected} for {attribute} of <{place.element.tag}>, got {text[:60]!r} ({error})"
        place.fault("M602", said)
        return None


def _value(node: ast.AST, most: float = _MOST) -> Any:
    """The value of an expression, in which nothing is raised to a power beyond the most."""
    match node:
        case ast.Constant(value=int() | float() as number) if not isinstance(number, bool):
            return float(number) if isinstance(number, float) else number
        case ast.Name(id="t"):
            return time()
        case ast.Name(id=name):
            return coordinate(name)
        case ast.UnaryOp(op=op, operand=operand) if type(op) in _OPERATIONS:
            return _OPERATIONS[type(op)](_value(operand, most))
        case ast.BinOp(left=left, op=ast.Pow(), right=right):
            power = _value(right)
            if not isinstance(power, (int, float)) or abs(power) > most:
                raise ValueError(f"its powers are to be numbers up to {_MOST} in all")
            return _value(left, most / max(abs(power), 1)) ** power
        case ast.BinOp(left=left, op=op, right=right) if type(op) in _OPERATIONS:
            return _OPERATIONS[type(op)](_value(left, most), _value(right, most))
        case ast.Call(func=ast.Name(id=name), args=[argument], keywords=[]) if name in FUNCTIONS:
            import sympy

            return getattr(sympy, name)(_value(argument, most))
    raise ValueError(f"{ast.unparse(node)} is none")


def write_expression(expression: Scalar) -> str:
    """Return an expression as text, its numbers in full."""
    if isinstance(expression, float):
        return repr(expression)
    from sympy.printing.str import StrPrinter

    class Full(StrPrinter):  # type: ignore[misc]
        def _print_Float(self, number: Any) -> str:
            return repr(float(number))

    return str(Full().doprint(expression))
