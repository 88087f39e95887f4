"""Record straight-line programs: elementary operations in order, each only once.

A value is a float or the index of an operation on the tape. An operation that was written before is
reused (common subexpressions), and operations on numbers alone are evaluated at once.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, field
from typing import TypeAlias, final

from mecanique.errors import DerivationError

Value: TypeAlias = "float | int"
"""A float is a number; an int is the index of an operation on the tape."""

Operation: TypeAlias = "tuple[str, tuple[Value, ...], str]"
"""The operation ("+", "-", "*", "/", a function or "input"), its operands, an input's name."""

_NUMBERS: dict[str, Callable[..., float]] = {
    "sin": math.sin,
    "cos": math.cos,
    "tan": math.tan,
    "sqrt": math.sqrt,
    "exp": math.exp,
    "log": math.log,
    "asin": math.asin,
    "acos": math.acos,
    "atan": math.atan,
    "tanh": math.tanh,
    "Abs": abs,
    "sign": lambda x: math.copysign(1.0, x) if x else 0.0,
    "atan2": math.atan2,
    "pow": math.pow,
}


@final
@dataclass
class Tape:
    """A recorder of operations."""

    # the operations in order; each uses only earlier ones
    operations: list[Operation] = field(default_factory=list)
    most: float = math.inf  # largest number of operations
    _places: dict[object, int] = field(default_factory=dict)

    def input(self, name: str) -> int:
        """Return an input, by name."""
        return self._place("input", (), name)

    def record(self, kind: str, operands: Iterable[Value], name: str = "") -> Value:
        """Return an operation of any kind."""
        match kind:
            case "input":
                return self.input(name)
            case "+":
                return self.add(*operands)
            case "-":
                return self.subtract(*operands)
            case "*":
                return self.multiply(*operands)
            case "/":
                return self.divide(*operands)
        return self.call(kind, *operands)

    def add(self, a: Value, b: Value) -> Value:
        """Return a + b."""
        if isinstance(a, float):
            a, b = b, a
        if isinstance(b, float):
            if isinstance(a, float):
                return a + b
            if b == 0.0:
                return a
        if isinstance(b, int) and (negative := self._negate(b)) is not None:
            return self.subtract(a, negative)
        if isinstance(a, int) and (negative := self._negate(a)) is not None:
            return self.subtract(b, negative)
        return self._place("+", _order(a, b))

    def subtract(self, a: Value, b: Value) -> Value:
        """Return a − b."""
        if isinstance(b, float):
            return self.add(a, -b)
        if isinstance(a, float) and a == 0.0:
            return self.multiply(-1.0, b)
        if (negative := self._negate(b)) is not None:
            return self.add(a, negative)
        return 0.0 if a == b and isinstance(a, int) else self._place("-", (a, b))

    def multiply(self, a: Value, b: Value) -> Value:
        """Return a b, with numeric factors collected in front."""
        if isinstance(b, float):
            a, b = b, a
        if isinstance(b, float):
            return float(a) * b
        if isinstance(a, float):
            if a in (0.0, 1.0):
                return b if a else 0.0
            kind, (first, *rest), _ = self._operation(b)
            if kind == "*" and isinstance(first, float):
                return self.multiply(first * a, rest[0])
            return self._place("*", (a, b))
        for x, y in ((a, b), (b, a)):
            kind, (first, *rest), _ = self._operation(x)
            if kind == "*" and isinstance(first, float):
                return self.multiply(first, self.multiply(rest[0], y))
        return self._place("*", _order(a, b))

    def divide(self, a: Value, b: Value) -> Value:
        """Return a / b."""
        if isinstance(b, float):
            return self.multiply(1.0 / b, a)
        return 0.0 if a == 0.0 and isinstance(a, float) else self._place("/", (a, b))

    def power(self, a: Value, exponent: int) -> Value:
        """Return a power of a with an integer exponent."""
        if exponent < 0:
            return self.divide(1.0, self.power(a, -exponent))
        result: Value = 1.0
        square = a
        while exponent:
            if exponent & 1:
                result = self.multiply(result, square)
            exponent >>= 1
            if exponent:
                square = self.multiply(square, square)
        return result

    def call(self, function: str, a: Value, *more: Value) -> Value:
        """Apply a function, given by its sympy name."""
        if isinstance(a, float) and all(isinstance(b, float) for b in more):
            return _NUMBERS[function](a, *more)
        if (
            function in ("sin", "cos")
            and isinstance(a, int)
            and (negative := self._negate(a)) is not None
        ):
            value = self.call(function, negative)
            return self.multiply(-1.0, value) if function == "sin" else value
        return self._place(function, (a, *more))

    def sum(self, terms: Iterable[Value]) -> Value:
        """Return the sum of several values, added from the first on."""
        total: Value = 0.0
        for term in terms:
            total = self.add(total, term)
        return total

    def find_needed(self, outputs: Sequence[Value]) -> list[int]:
        """Return the indices of the operations that outputs need, in order."""
        needed: set[int] = set()
        todo = [value for value in outputs if isinstance(value, int)]
        while todo:
            place = todo.pop()
            if place not in needed:
                needed.add(place)
                todo += [value for value in self.operations[place][1] if isinstance(value, int)]
        return sorted(needed)

    def _operation(self, place: int) -> tuple[str, tuple[Value, ...], str]:
        kind, values, name = self.operations[place]
        return kind, values or (0.0,), name

    def _negate(self, place: int) -> Value | None:
        """Return the value whose negative an operation is, None if it is not a negation."""
        kind, values, _ = self.operations[place]
        if kind == "*" and isinstance(values[0], float) and values[0] < 0:
            return self.multiply(-values[0], values[1])
        return None

    def _place(self, kind: str, values: tuple[Value, ...], name: str = "") -> int:
        # floats are wrapped, as 1 and 1.0 are equal keys, but an index and a number
        key = kind, name, *(value if isinstance(value, int) else (value,) for value in values)
        index = self._places.get(key)
        if index is None:
            index = self._places[key] = len(self.operations)
            if index >= self.most:
                raise DerivationError(f"the program takes more than {self.most:,} operations")
            self.operations.append((kind, values, name))
        return index


def _order(a: Value, b: Value) -> tuple[Value, Value]:
    """Sort two operands, numbers first, so that a + b and b + a are one operation."""
    if isinstance(b, float) or (isinstance(a, int) and b < a):
        return b, a
    return a, b


@final
@dataclass(frozen=True)
class Counts:
    """Numbers of operations; a result that is used several times counts once."""

    additions: int  # additions and subtractions
    multiplications: int  # products of two factors
    divisions: int  # divisions, except by numbers
    functions: int  # sines, roots and so on

    @property
    def total(self) -> int:
        """The number of all operations."""
        return self.additions + self.multiplications + self.divisions + self.functions

    def __str__(self) -> str:
        return (
            f"{self.total} operations: {self.additions} additions, {self.multiplications} "
            f"multiplications, {self.divisions} divisions, {self.functions} functions"
        )


def count(tape: Tape, outputs: Sequence[Value]) -> Counts:
    """Return the numbers of operations that outputs need."""
    kinds = [tape.operations[place][0] for place in tape.find_needed(outputs)]
    sums = sum(kind in "+-" for kind in kinds)
    products, divisions = kinds.count("*"), kinds.count("/")
    others = len(kinds) - sums - products - divisions - kinds.count("input")
    return Counts(sums, products, divisions, others)
