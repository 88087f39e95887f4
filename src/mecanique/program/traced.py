"""Scalars that record their arithmetic on a tape, which turns formulas into programs."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any, final

from mecanique.program.tape import Tape, Value


@final
class Traced:
    """The index of an operation on a tape, with arithmetic; numeric results are floats."""

    __slots__ = ("place", "tape")
    __array_ufunc__ = None  # makes numpy's numbers leave arithmetic to this class

    def __init__(self, tape: Tape, place: int) -> None:
        self.tape = tape
        self.place = place

    def __add__(self, other: Any) -> Any:
        return trace(self.tape, self.tape.add(self.place, value_of(other)))

    __radd__ = __add__

    def __sub__(self, other: Any) -> Any:
        return trace(self.tape, self.tape.subtract(self.place, value_of(other)))

    def __rsub__(self, other: Any) -> Any:
        return trace(self.tape, self.tape.subtract(value_of(other), self.place))

    def __mul__(self, other: Any) -> Any:
        return trace(self.tape, self.tape.multiply(self.place, value_of(other)))

    __rmul__ = __mul__

    def __truediv__(self, other: Any) -> Any:
        return trace(self.tape, self.tape.divide(self.place, value_of(other)))

    def __rtruediv__(self, other: Any) -> Any:
        return trace(self.tape, self.tape.divide(value_of(other), self.place))

    def __neg__(self) -> Any:
        return trace(self.tape, self.tape.multiply(-1.0, self.place))

    def __pow__(self, other: Any) -> Any:
        if isinstance(other, int):
            return trace(self.tape, self.tape.power(self.place, other))
        return trace(self.tape, self.tape.call("pow", self.place, value_of(other)))

    def __rpow__(self, other: Any) -> Any:
        return trace(self.tape, self.tape.call("pow", value_of(other), self.place))


def trace(tape: Tape, value: Value) -> Any:
    """Return a value of a tape as a scalar; a number remains a float."""
    return Traced(tape, value) if isinstance(value, int) else value


def value_of(scalar: Any) -> Value:
    """Return a scalar as a value of its tape."""
    return scalar.place if isinstance(scalar, Traced) else float(scalar)


def values_of(scalars: Iterable[Any]) -> list[Value]:
    """Return several scalars as values of their tape."""
    return [value_of(scalar) for scalar in scalars]


def call(tape: Tape, function: str, *arguments: Any) -> Any:
    """Return a function's value on a tape, e.g. "sqrt" of one argument."""
    return trace(tape, tape.call(function, *map(value_of, arguments)))
