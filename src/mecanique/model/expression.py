"""Scalars: numbers, parameters and expressions in parameters, coordinates and time."""

from __future__ import annotations

import inspect
import math
from collections.abc import Callable, Iterable, Mapping, Sequence
from fractions import Fraction
from functools import reduce
from operator import add, mul
from typing import Any, NoReturn, TypeAlias, final

import numpy as np

from mecanique.errors import InputError, UnknownNameError

Scalar: TypeAlias = Any
"""A float, a `Parameter`, an `Input` or a sympy expression in their symbols."""

Vector: TypeAlias = Sequence[Scalar]
"""Three scalars: components along x, y, z."""

FUNCTIONS = (
    "sin",
    "cos",
    "tan",
    "asin",
    "acos",
    "atan",
    "atan2",
    "sqrt",
    "exp",
    "log",
    "Abs",
    "sign",
    "tanh",
)
"""The functions an expression may contain, by their sympy names."""

_NUMPY_NAMES = {
    "asin": "arcsin",
    "acos": "arccos",
    "atan": "arctan",
    "atan2": "arctan2",
    "Abs": "abs",
    "pow": "power",
}


def coordinate(name: str) -> Scalar:
    """Return the symbol of a generalized coordinate, for use in expressions.

    Args:
        name: the coordinate's name, e.g. "q".

    Returns:
        A sympy symbol.

    Example:
        >>> mq.coordinate('q') / 2
        q/2
    """
    from sympy import Symbol

    return Symbol(name)


def velocity(name: str) -> Scalar:
    """Return the symbol of a generalized velocity, for use in expressions.

    Args:
        name: the name of the coordinate whose rate it is, e.g. "q" for q'.

    Returns:
        A sympy symbol.

    Example:
        >>> -3.0 * mq.velocity('q')
        -3.0*q'
    """
    from sympy import Symbol

    return Symbol(f"{name}'")


def distance() -> Scalar:
    """Return the symbol of the distance between the ends of a `CentralForce`.

    Returns:
        A sympy symbol.

    Example:
        >>> -10.0 / mq.distance()
        -10.0/distance
    """
    return coordinate(DISTANCE)


DISTANCE = "distance"
"""Name of the distance between two points in a potential."""


def position() -> tuple[Scalar, Scalar, Scalar]:
    """Return the symbols of a point's coordinates x, y, z in the world, in a `PotentialField`.

    Returns:
        Three sympy symbols.

    Example:
        >>> x, y, z = mq.position()
        >>> 3.0 * (x**2 + y**2) / 2
        1.5*position_x**2 + 1.5*position_y**2
    """
    x, y, z = map(coordinate, POSITION)
    return x, y, z


POSITION = ("position_x", "position_y", "position_z")
"""Names of the coordinates of a point in the world in a potential."""


@final
class _Time:
    """Return the symbol of time, t, for use in expressions; to be called: time().

    Example:
        >>> 0.1 * mq.sin(3 * mq.time())
        0.1*sin(3*t)
    """

    def __call__(self) -> Scalar:
        from sympy import Symbol

        return Symbol("t")

    def __repr__(self) -> str:
        return "<function time>"

    def _refuse(self, *_: object, **options: object) -> NoReturn:
        raise InputError("expected an expression, got the function time; call it: time()")

    _sympy_ = __array_ufunc__ = __float__ = __neg__ = __abs__ = _refuse
    __add__ = __sub__ = __mul__ = __truediv__ = __pow__ = _refuse
    __radd__ = __rsub__ = __rmul__ = __rtruediv__ = __rpow__ = _refuse


time = _Time()
"""Gives the symbol of time; without the call, in an expression, it says so."""


def plain(scalar: Scalar) -> Scalar:
    """Return a scalar as a float or a sympy expression."""
    if scalar.__class__ is float:  # most are: nothing else need be asked
        return scalar
    if isinstance(scalar, (bool, np.bool_, str)):
        raise InputError(f"expected a number, a parameter or an expression, got {scalar!r}")
    if isinstance(scalar, (int, float, np.integer, np.floating)):
        try:
            return float(scalar)
        except OverflowError:
            raise InputError(
                "expected a number within the range of floats, "
                f"got one of {len(str(scalar))} digits"
            ) from None
    convert = getattr(scalar, "_sympy_", None)
    if convert is not None:
        return convert()
    if hasattr(type(scalar), "free_symbols"):  # asked of the scalar, it would list them
        return scalar
    called = f"; call it: {scalar.__name__}(…)" if inspect.isfunction(scalar) else ""
    raise InputError(f"expected a number, a parameter or an expression, got {scalar!r}{called}")


def symbols_in(scalar: Scalar) -> frozenset[str]:
    """Return the names of the symbols a scalar depends on."""
    scalar = plain(scalar)
    return (
        frozenset() if isinstance(scalar, float) else frozenset(s.name for s in scalar.free_symbols)
    )


def evaluate(
    scalar: Scalar | Fraction,
    values: Mapping[str, Any],
    *,
    function: Callable[[str], Callable[..., Any]] | None = None,
    number: Callable[[Any], Any] = float,
) -> Any:
    """Evaluate a scalar in any arithmetic: floats, arrays, jets or series."""
    if isinstance(scalar, Fraction):
        return number(scalar)
    scalar = plain(scalar)
    if isinstance(scalar, float) or scalar.is_number:
        return number(scalar)
    if scalar.is_Symbol:
        if scalar.name not in values:
            raise UnknownNameError("symbol", scalar.name, values)
        return values[scalar.name]
    known: dict[Any, Any] = {}  # what occurs many times is evaluated once

    def value(part: Any) -> Any:
        if part not in known:
            known[part] = of_parts(part)
        return known[part]

    def of_parts(part: Any) -> Any:
        if part.is_number or part.is_Symbol:
            return evaluate(part, values, number=number)
        if part.is_Pow and part.exp.is_number:
            base = value(part.base)
            if part.exp == _half():
                return (function or numpy_function)("sqrt")(base)
            if part.exp == -_half():
                return 1 / (function or numpy_function)("sqrt")(base)
            return base ** (int(part.exp) if part.exp.is_Integer else float(part.exp))
        terms = [value(term) for term in part.args]
        if part.is_Add:
            # sum() rounds floats otherwise from Python 3.12 on, and files are the same everywhere
            return reduce(add, terms)
        if part.is_Mul:
            return reduce(mul, terms)
        if part.is_Pow:
            return terms[0] ** terms[1]
        name = type(part).__name__
        if name not in FUNCTIONS:
            known_names = ", ".join(FUNCTIONS)
            raise InputError(f"expected functions among {known_names}, got {name} in {scalar}")
        return (function or numpy_function)(name)(*terms)

    return value(scalar)


def compile_scalars(
    scalars: Iterable[Scalar], names: Sequence[str]
) -> Callable[..., tuple[float, ...]]:
    """Compile scalars to one plain Python function of floats, with common subexpressions shared."""
    scalars = [plain(scalar) for scalar in scalars]
    for scalar in scalars:
        for name in symbols_in(scalar):
            if name not in names:
                raise UnknownNameError("symbol", name, names)
    if all(isinstance(scalar, float) for scalar in scalars):
        constants = tuple(scalars)
        return lambda *_: constants
    from sympy import Symbol, lambdify, sympify

    arguments = [Symbol(name) for name in names]
    function: Callable[..., tuple[float, ...]] = lambdify(
        arguments, tuple(sympify(s) for s in scalars), modules=["math"], cse=True
    )
    return function


def _half() -> Any:
    from sympy import Rational

    return Rational(1, 2)


def numpy_function(name: str) -> Callable[..., Any]:
    """Return numpy's function of a sympy name, e.g. arcsin for "asin"."""
    function: Callable[..., Any] = getattr(np, _NUMPY_NAMES.get(name, name))
    return function


def finite(value: object, what: str) -> float:
    """Return a value as a float, or raise."""
    try:
        if isinstance(value, (bool, str)):
            raise TypeError
        number = float(value)  # type: ignore[arg-type]  # what has no __float__ raises
    except (TypeError, ValueError, OverflowError):
        raise InputError(f"expected a finite number for {what}, got {value!r}") from None
    if not math.isfinite(number):
        raise InputError(f"expected a finite number for {what}, got {value!r}")
    return number
