"""Differentiate a coordinate map along the motion, as straight-line arithmetic of floats.

Each operation of the map is followed by those of its derivatives (forward mode: Griewank, Walther,
Evaluating Derivatives, 2nd ed., 2008, sect. 3.1 and 13.1). Expressions are not differentiated:
written out, the second derivatives of a long chain grow with the cube of its length.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Mapping, Sequence
from typing import Any, TypeAlias, final

Operand: TypeAlias = "float | str"
"""A number, or the name of an argument or of an earlier operation."""

_RULES: dict[str, tuple[str, str, str]] = {
    "sin": ("sin({x})", "cos({x})", "-{y}"),
    "cos": ("cos({x})", "-sin({x})", "-{y}"),
    "tan": ("tan({x})", "1 + {y} * {y}", "2 * {y} * {d}"),
    "asin": ("asin({x})", "1 / sqrt(1 - {x} * {x})", "{x} * {d} ** 3"),
    "acos": ("acos({x})", "-1 / sqrt(1 - {x} * {x})", "{x} * {d} ** 3"),
    "atan": ("atan({x})", "1 / (1 + {x} * {x})", "-2 * {x} * {d} * {d}"),
    "sqrt": ("sqrt({x})", "0.5 / {y}", "-0.5 * {d} / {x}"),
    "exp": ("exp({x})", "{y}", "{y}"),
    "log": ("log({x})", "1 / {x}", "-{d} * {d}"),
    "tanh": ("tanh({x})", "1 - {y} * {y}", "-2 * {y} * {d}"),
    "Abs": ("abs({x})", "sign({x})", "0"),
    "sign": ("sign({x})", "0", "0"),
}
"""Each function y of x, its derivative d and its second derivative; a sign's impulse left out."""


def _sign(x: float) -> float:
    return math.copysign(1.0, x) if x else 0.0


_SPACE = {name: getattr(math, name) for name in _RULES if hasattr(math, name)}
_SPACE |= {"abs": abs, "sign": _sign, "atan2": math.atan2, "pow": math.pow}
_SPACE |= {"inf": math.inf, "nan": math.nan}  # as floats are written


@final
class Operations:
    """A list of operations on floats, in the order of evaluation."""

    def __init__(self, arguments: Sequence[str]) -> None:
        self._arguments = {name: f"x{k}" for k, name in enumerate(arguments)}
        self._lines: list[tuple[str, str, frozenset[Operand]]] = []

    def __len__(self) -> int:
        return len(self._lines)

    def argument(self, name: str) -> MovingScalar:
        """Return an argument that does not move."""
        return MovingScalar(self, self._arguments[name])

    def add(self, a: Operand, b: Operand) -> Operand:
        """Return a + b."""
        if a == 0 or b == 0:
            return b if a == 0 else a
        if isinstance(a, str) or isinstance(b, str):
            return self.put("{a} + {b}", a=a, b=b)
        return a + b

    def multiply(self, a: Operand, b: Operand) -> Operand:
        """Return a b."""
        if a == 0 or b == 0:
            return 0.0
        if a == 1 or b == 1:
            return b if a == 1 else a
        if isinstance(a, str) or isinstance(b, str):
            return self.put("{a} * {b}", a=a, b=b)
        return a * b

    def put(self, text: str, **operands: Operand) -> Operand:
        """Return the value of an operation, given as text with its operands' letters."""
        name = f"y{len(self._lines)}"
        shown = {letter: x if isinstance(x, str) else f"({x!r})" for letter, x in operands.items()}
        self._lines.append((name, text.format(**shown), frozenset(operands.values())))
        return name

    def reaching(self, start: Iterable[str]) -> frozenset[Operand]:
        """Return the named arguments and what depends on them."""
        reached: set[Operand] = {self._arguments[name] for name in start}
        for name, _, operands in self._lines:
            if not reached.isdisjoint(operands):
                reached.add(name)
        return frozenset(reached)

    def compile(
        self, results: Sequence[Operand], arguments: Sequence[str]
    ) -> Callable[..., tuple[float, ...]]:
        """Return a function of some arguments that returns values, and computes nothing else."""
        needed, lines = set(results), list[str]()
        for name, text, operands in reversed(self._lines):
            if name in needed:
                needed.update(operands)
                lines.append(f"    {name} = {text}")
        head = f"def values({', '.join(self._arguments[name] for name in arguments)}):"
        out = f"    return ({''.join(f'{result}, ' for result in results)})"
        space: dict[str, Any] = dict(_SPACE)
        exec("\n".join([head, *reversed(lines), out]), space)
        function: Callable[..., tuple[float, ...]] = space["values"]
        return function


@final
class MovingScalar:
    """A scalar y along the motion, with y' = Σ s v + s_t and y'' where all v' are zero."""

    __slots__ = ("operations", "rate", "second", "slopes", "value")

    def __init__(
        self,
        operations: Operations,
        value: Operand,
        slopes: Mapping[str, Operand] | None = None,
        rate: Operand = 0.0,
        second: Operand = 0.0,
    ) -> None:
        self.operations, self.value, self.rate, self.second = operations, value, rate, second
        self.slopes: Mapping[str, Operand] = slopes or {}
        """s by the names of generalized velocities, and s_t by "t"; those not zero."""

    def __add__(self, other: Any) -> MovingScalar:
        b = self._of(other)
        value = self.operations.add(self.value, b.value)
        return self._chain(value, [(self, 1.0), (b, 1.0)])

    __radd__ = __add__

    def __mul__(self, other: Any) -> MovingScalar:
        b, times = self._of(other), self.operations.multiply
        curved = times(2.0, times(self.rate, b.rate))
        return self._chain(times(self.value, b.value), [(self, b.value), (b, self.value)], curved)

    __rmul__ = __mul__

    def __neg__(self) -> MovingScalar:
        return self * -1.0

    def __sub__(self, other: Any) -> MovingScalar:
        return self + self._of(other) * -1.0

    def __truediv__(self, other: Any) -> MovingScalar:
        return self * self._of(other) ** -1

    def __rtruediv__(self, other: Any) -> MovingScalar:
        return self.__pow__(-1).__mul__(other)

    def __pow__(self, exponent: Any) -> MovingScalar:
        if isinstance(exponent, MovingScalar):
            return (self.apply("log") * exponent).apply("exp")
        p = exponent
        # a root of a negative number is refused by pow, where ** would make it complex
        power = "{{x}} ** {}" if p == int(p) else "pow({{x}}, {})"
        first, second = (power.format(p - k) for k in (1, 2))
        return self._compose((power.format(p), f"{p} * {first}", f"{p * (p - 1)} * {second}"))

    def __rpow__(self, base: float) -> MovingScalar:
        return (self * math.log(base)).apply("exp")

    def apply(self, function: str, *others: Any) -> MovingScalar:
        """Return a function of it, by its name among those that expressions may contain."""
        return self._atan2(*others) if others else self._compose(_RULES[function])

    def _compose(self, rule: tuple[str, str, str]) -> MovingScalar:
        put, times, x = self.operations.put, self.operations.multiply, self.value
        y = put(rule[0], x=x)
        if not self.slopes:
            return MovingScalar(self.operations, y)
        d = put(rule[1], x=x, y=y)
        curved = put(rule[2], x=x, y=y, d=d) if self.rate != 0 else 0.0
        return self._chain(y, [(self, d)], times(curved, times(self.rate, self.rate)))

    def _atan2(self, x: Any) -> MovingScalar:
        x, put = self._of(x), self.operations.put
        at = {"x": x.value, "y": self.value}
        square = put("{x} * {x} + {y} * {y}", **at)
        of_y, of_x = put("{x} / {s}", s=square, **at), put("-{y} / {s}", s=square, **at)
        rates = {"u": x.rate, "w": self.rate, "s": square}
        curved = put(
            "-2 * ({x} * {u} + {y} * {w}) * ({x} * {w} - {y} * {u}) / {s} ** 2", **at, **rates
        )
        return self._chain(put("atan2({y}, {x})", **at), [(self, of_y), (x, of_x)], curved)

    def _chain(
        self, value: Operand, parts: Iterable[tuple[MovingScalar, Operand]], curved: Operand = 0.0
    ) -> MovingScalar:
        """Return a value with its derivatives by the chain rule."""
        add, times = self.operations.add, self.operations.multiply
        slopes: dict[str, Operand] = {}
        rate: Operand = 0.0
        for path, by in parts:
            for direction, slope in path.slopes.items():
                slopes[direction] = add(slopes.get(direction, 0.0), times(by, slope))
            rate = add(rate, times(by, path.rate))
            curved = add(curved, times(by, path.second))
        return MovingScalar(self.operations, value, slopes, rate, curved)

    def _of(self, other: Any) -> MovingScalar:
        return (
            other
            if isinstance(other, MovingScalar)
            else MovingScalar(self.operations, float(other))
        )


def apply(name: str) -> Callable[..., Any]:
    """Return a function of paths by its name."""
    return lambda x, *others: x.apply(name, *others)
