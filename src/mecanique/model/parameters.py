"""Parameters and inputs: the named quantities a description is written in."""

from __future__ import annotations

import operator
from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any, TypeAlias, final

import numpy as np

from mecanique.errors import InputError
from mecanique.model.expression import Scalar, evaluate, finite, plain, symbols_in, time
from mecanique.model.units import read_unit
from mecanique.wording import Legible

_Operation: TypeAlias = Callable[[Any, Scalar], Any]


def _both_ways(operation: _Operation) -> tuple[_Operation, _Operation]:
    """Return an operator of a named quantity, with the other operand on its right or left."""
    return (
        lambda named, operand: operation(named._sympy_(), _exact(operand)),
        lambda named, operand: operation(_exact(operand), named._sympy_()),
    )


class _Named:
    """Arithmetic of a named quantity: the result is a sympy expression in its symbol."""

    symbol: str

    def _sympy_(self) -> Any:
        from sympy import Symbol

        return Symbol(self.symbol)

    __add__, __radd__ = _both_ways(operator.add)
    __sub__, __rsub__ = _both_ways(operator.sub)
    __mul__, __rmul__ = _both_ways(operator.mul)
    __truediv__, __rtruediv__ = _both_ways(operator.truediv)
    __pow__, __rpow__ = _both_ways(operator.pow)

    def __neg__(self) -> Any:
        return -self._sympy_()

    def __abs__(self) -> Any:
        return abs(self._sympy_())

    def __float__(self) -> float:
        raise TypeError(
            f"expected a number, got the letter {self.symbol}; functions of letters are those of "
            f"mecanique, e.g. mecanique.sin({self.symbol})"
        )

    def __array_ufunc__(self, function: Any, method: str, *inputs: Any, **options: Any) -> Any:
        if function.nin == 1:
            float(self)  # raises: numpy's sin and the like take numbers
        return getattr(function, method)(*map(_box, inputs), **options)


@final
@dataclass(frozen=True)
class Parameter(_Named):
    """A named constant of a mechanism; arithmetic with it gives sympy expressions.

    Functions of expressions are mecanique's own, e.g. `mecanique.sin`; numpy's and math's take
    numbers only.

    Args:
        symbol: the letter it has in equations, e.g. "m1".
        value: its number, in the unit.
        unit: its SI unit, e.g. "kg", against which expressions are checked; "1" for a pure number;
            where none is given, the unit that its places ask for.
        meaning: what it is, in a few words.

    Raises:
        InputError: if the symbol is empty, the value is not finite or the unit no SI unit.

    Example:
        >>> k, m = mq.Parameter("k", 50.0, "N/m", "stiffness"), mq.Parameter("m", 2.0, "kg")
        >>> mq.sqrt(k / m)
        sqrt(k/m)
    """

    symbol: str
    value: float
    unit: str = ""
    meaning: str = ""

    def __post_init__(self) -> None:
        _check_symbol(self.symbol, "parameter")
        _check_unit(self.unit, f"parameter {self.symbol!r}")
        object.__setattr__(self, "value", finite(self.value, f"parameter {self.symbol}"))

    def with_value(self, value: float) -> Parameter:
        """Return the same parameter with another value [unit of the parameter]."""
        return replace(self, value=value)


@final
@dataclass(frozen=True, eq=False, repr=False)
class Record(Legible):
    """A sampled signal, e.g. an earthquake record; linear between samples, constant outside.

    Args:
        times: shape (n,), increasing [s].
        values: shape (n,), in the unit of the input.

    Raises:
        InputError: if the shapes differ, a number is not finite or the times do not increase.

    Example:
        >>> quake = mq.Record([0.0, 1.0, 2.0], [0.0, 3.0, 0.0])
        >>> ag = mq.Input("ag", quake, "m/s²", "acceleration of the ground")
        >>> float(quake(0.5))
        1.5
    """

    times: np.ndarray
    values: np.ndarray

    def __post_init__(self) -> None:
        times, values = np.array(self.times, dtype=float), np.array(self.values, dtype=float)
        if times.ndim != 1 or times.shape != values.shape or not len(times):
            raise InputError(
                f"expected times and values of one shape (n,), got {times.shape} and {values.shape}"
            )
        if not (np.isfinite(times).all() and np.isfinite(values).all()):
            raise InputError("expected finite times and values in a record")
        if (np.diff(times) <= 0).any():
            raise InputError("expected increasing times in a record")
        times.flags.writeable = values.flags.writeable = False
        object.__setattr__(self, "times", times)
        object.__setattr__(self, "values", values)

    def __call__(self, t: float) -> float:
        """Return the value at time t [s]."""
        return float(np.interp(t, self.times, self.values))


@final
@dataclass(frozen=True)
class Input(_Named):
    """A named signal F(t) that a force or a prescribed motion follows; equations show its symbol.

    Args:
        symbol: the letter it has in equations, e.g. "F".
        signal: a number, an expression in t and parameters, a `Record`, or a function of t [s].
        unit: its SI unit, as of a `Parameter`.
        meaning: what it is, in a few words.

    Example:
        >>> from dataclasses import replace
        >>> F = mq.Input("F", 3 * mq.sin(5 * mq.time()), "N", "shaker")
        >>> shake = mq.Force("shake", "particle", (0, 0, 0), (F, 0, 0))
        >>> particle = replace(mq.textbook.load("free_particle"), forces=(shake,), inputs=(F,))
        >>> print(mq.derive(particle))
        m x'' = F
        y'' = 0
        z'' + g = 0
    """

    symbol: str
    signal: Scalar | Record | Callable[[float], float] = 0.0
    unit: str = ""
    meaning: str = ""

    def __post_init__(self) -> None:
        _check_symbol(self.symbol, "input")
        _check_unit(self.unit, f"input {self.symbol!r}")
        if self.signal is time or not callable(self.signal):
            signal = plain(self.signal)
            object.__setattr__(
                self, "signal", finite(signal, self.symbol) if isinstance(signal, float) else signal
            )

    @property
    def symbols(self) -> frozenset[str]:
        """Names of the symbols its signal depends on."""
        return frozenset() if callable(self.signal) else symbols_in(self.signal)

    def function(self, values: dict[str, float]) -> Callable[[float], float]:
        """Return the signal as a function of t [s].

        Args:
            values: value of each parameter, by symbol.
        """
        signal = self.signal
        if callable(signal):
            return signal
        if isinstance(signal, float):
            return lambda _: signal
        return lambda t: float(evaluate(signal, {**values, "t": t}))


def _box(operand: Any) -> Any:
    """Return an operand as numpy's operators take it: a letter in an array of objects."""
    if not isinstance(operand, _Named):
        return operand
    boxed = np.empty((), dtype=object)
    boxed[()] = operand
    return boxed


def _check_symbol(symbol: object, kind: str) -> None:
    if not (isinstance(symbol, str) and symbol.isidentifier()):
        raise InputError(
            f"expected a letter or word as symbol of a {kind}, e.g. 'm1', got {symbol!r}"
        )
    if symbol == "t":
        raise InputError(f"expected another symbol for a {kind} than 't', which is time")


def _check_unit(unit: object, where: str) -> None:
    if not isinstance(unit, str):
        raise InputError(f"{where}: expected its unit as text, e.g. 'kg', got {unit!r}")
    if unit:
        try:
            read_unit(unit)
        except InputError as error:
            raise InputError(f"{where}: {error}") from None


def _exact(number: Scalar) -> Scalar:
    """Keep whole numbers whole, so that m*l**2/12 stays exact."""
    return (
        int(number)
        if isinstance(number, (int, np.integer)) and not isinstance(number, bool)
        else plain(number)
    )
