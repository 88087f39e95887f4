"""Functions of expressions: those of numpy and math take numbers only.

Of a letter they say so; of an expression in letters `np.sin(l/m)` ends in SymPy with "loop of ufunc
does not support argument 0 of type Mul which has no callable sin method": use `mq.sin(l/m)`.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

from mecanique.errors import InputError
from mecanique.model.expression import Scalar, plain


def sin(x: Scalar) -> Any:
    """Return the sine, for use in expressions.

    Args:
        x: a number, parameter or expression; angle [rad].

    Returns:
        A float of floats, else a sympy expression.

    Example:
        >>> mq.sin(mq.coordinate('q'))
        sin(q)
    """
    return _apply("sin", x)


def cos(x: Scalar) -> Any:
    """Return the cosine, for use in expressions.

    Args:
        x: a number, parameter or expression; angle [rad].

    Returns:
        A float of floats, else a sympy expression.

    Example:
        >>> mq.cos(2 * mq.coordinate('q'))
        cos(2*q)
    """
    return _apply("cos", x)


def tan(x: Scalar) -> Any:
    """Return the tangent, for use in expressions.

    Args:
        x: a number, parameter or expression; angle [rad].

    Returns:
        A float of floats, else a sympy expression.

    Example:
        >>> mq.tan(mq.coordinate('q'))
        tan(q)
    """
    return _apply("tan", x)


def asin(x: Scalar) -> Any:
    """Return the angle in −π/2…π/2 [rad] whose sine is given, for use in expressions.

    Args:
        x: a number, parameter or expression; within −1…1.

    Returns:
        A float of floats, else a sympy expression.

    Example:
        >>> mq.asin(mq.Parameter('r', 0.5) / 2)
        asin(r/2)
    """
    return _apply("asin", x)


def acos(x: Scalar) -> Any:
    """Return the angle in 0…π [rad] whose cosine is given, for use in expressions.

    Args:
        x: a number, parameter or expression; within −1…1.

    Returns:
        A float of floats, else a sympy expression.

    Example:
        >>> mq.acos(1.0)
        0.0
    """
    return _apply("acos", x)


def atan(x: Scalar) -> Any:
    """Return the angle in −π/2…π/2 [rad] whose tangent is given, for use in expressions.

    Args:
        x: a number, parameter or expression; any number.

    Returns:
        A float of floats, else a sympy expression.

    Example:
        >>> mq.atan(mq.coordinate('x'))
        atan(x)
    """
    return _apply("atan", x)


def atan2(y: Scalar, x: Scalar) -> Any:
    """Return the angle in −π…π [rad] of the point (x, y), for use in expressions.

    Args:
        y: a number, parameter or expression.
        x: the same.

    Returns:
        A float of floats, else a sympy expression.

    Example:
        >>> mq.atan2(0.0, 1.0)
        0.0
    """
    return _apply("atan2", y, x)


def sqrt(x: Scalar) -> Any:
    """Return the square root, for use in expressions.

    Args:
        x: a number, parameter or expression; not negative where it is evaluated.

    Returns:
        A float of floats, else a sympy expression.

    Example:
        >>> mq.sqrt(mq.coordinate('x') ** 2 + 1)
        sqrt(x**2 + 1)
    """
    return _apply("sqrt", x)


def exp(x: Scalar) -> Any:
    """Return e to a power, for use in expressions.

    Args:
        x: a number, parameter or expression; a pure number.

    Returns:
        A float of floats, else a sympy expression.

    Example:
        >>> mq.exp(-mq.time())
        exp(-t)
    """
    return _apply("exp", x)


def log(x: Scalar) -> Any:
    """Return the natural logarithm, for use in expressions.

    Args:
        x: a number, parameter or expression; positive where it is evaluated.

    Returns:
        A float of floats, else a sympy expression.

    Example:
        >>> mq.log(1.0)
        0.0
    """
    return _apply("log", x)


def tanh(x: Scalar) -> Any:
    """Return the hyperbolic tangent, for use in expressions.

    Args:
        x: a number, parameter or expression; a pure number.

    Returns:
        A float of floats, else a sympy expression.

    Example:
        >>> mq.tanh(mq.velocity('q'))
        tanh(q')
    """
    return _apply("tanh", x)


def sign(x: Scalar) -> Any:
    """Return −1, 0 or 1, as the argument is negative, zero or positive, for use in expressions.

    Args:
        x: a number, parameter or expression; any number.

    Returns:
        A sympy expression or number.

    Example:
        >>> mq.sign(mq.velocity('q'))
        sign(q')
    """
    return _apply("sign", x)


def _list(numbers: Sequence[float]) -> str:
    return ", ".join(f"{number:g}" for number in numbers)


def _apply(name: str, *arguments: Scalar) -> Any:
    """Apply a function: to floats at once, to whole numbers and letters as an expression."""
    exact = [x if type(x) is int else plain(x) for x in arguments]
    if all(isinstance(x, float) for x in exact) and hasattr(math, name):
        try:
            return getattr(math, name)(*exact)
        except ValueError:
            raise InputError(f"{name} has no real value at {_list(exact)}") from None
        except OverflowError:
            raise InputError(f"{name} exceeds the largest number at {_list(exact)}") from None
    import sympy

    return getattr(sympy, name)(*exact)
