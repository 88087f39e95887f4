"""Mathematical functions of numbers, arrays, jets, Poisson series and sympy expressions.

A Lagrangian, a pose or a force written with these and ordinary arithmetic works for all of them.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from mecanique.derivation.scalars import elementary
from mecanique.derivation.scalars.jets import Jet
from mecanique.derivation.scalars.series import Series
from mecanique.errors import DerivationError, UnknownNameError
from mecanique.model.expression import FUNCTIONS, numpy_function


def function(name: str) -> Callable[..., Any]:
    """Return a mathematical function that accepts any scalar.

    Args:
        name: its sympy name, e.g. "sin", "atan", "Abs".

    Raises:
        UnknownNameError: if there is no such function.
    """
    if name not in _FUNCTIONS:
        raise UnknownNameError("function", name, FUNCTIONS)
    return _FUNCTIONS[name]


def _generic(name: str) -> Callable[..., Any]:
    on_numbers = numpy_function(name)

    def apply(*arguments: Any) -> Any:
        first = next((x for x in arguments if isinstance(x, (Jet, Series))), arguments[0])
        if isinstance(first, Jet):
            return getattr(_as_jet(arguments[0], first), name)(*arguments[1:])
        if isinstance(first, Series):
            return elementary.of_series(name, *arguments)
        if isinstance(first, (int, float, np.ndarray, np.generic)):
            return on_numbers(*arguments)
        if hasattr(first, "free_symbols"):
            import sympy

            return getattr(sympy, name)(*arguments)
        raise DerivationError(
            f"expected a number, an array, a jet, a series or an expression in {name}, "
            f"got {first!r}"
        )

    apply.__name__ = name
    apply.__doc__ = f"Return {name} of any scalar."
    return apply


def _as_jet(x: Any, like: Jet) -> Jet:
    if isinstance(x, Jet):
        return x
    c = np.zeros((*like.c.shape[:2], *np.shape(x)))
    c[0, 0] = x
    return Jet(c)


_FUNCTIONS = {name: _generic(name) for name in FUNCTIONS}
