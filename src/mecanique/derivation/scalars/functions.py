"""Mathematical functions of numbers, arrays, jets, Poisson series and sympy expressions.

A Lagrangian, a pose or a force written with these and ordinary arithmetic works for all of them.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from mecanique.derivation.scalars import elementary
from mecanique.derivation.scalars.elementary import sqrt
from mecanique.derivation.scalars.jets import Jet
from mecanique.derivation.scalars.polynomials import power
from mecanique.derivation.scalars.series import Series
from mecanique.errors import DerivationError, UnknownNameError
from mecanique.model.expression import FUNCTIONS, numpy_function


def function(name: str) -> Callable[..., Any]:
    """Return a mathematical function that accepts any scalar."""
    if name not in _FUNCTIONS:
        raise UnknownNameError("function", name, FUNCTIONS)
    return _FUNCTIONS[name]


def _generic(name: str) -> Callable[..., Any]:
    on_numbers = numpy_function(name)

    def apply(*arguments: Any) -> Any:
        first = next((x for x in arguments if isinstance(x, (Jet, Series))), arguments[0])
        if isinstance(first, Jet):
            x = arguments[0]
            return getattr(x if isinstance(x, Jet) else first.constant(x), name)(*arguments[1:])
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


_FUNCTIONS = {name: _generic(name) for name in FUNCTIONS}


def function_without_arcs(name: str) -> Callable[..., Any]:
    """Return a function for series; its sine and cosine expand arcs, as in sin(asin u + q)."""
    if name not in ("sin", "cos"):
        return function(name)
    place = ("sin", "cos").index(name)
    return lambda argument: (
        _sine_cosine(argument)[place] if isinstance(argument, Series) else function(name)(argument)
    )


def _sine_cosine(angle: Series) -> tuple[Series, Series]:
    """Return sine and cosine of Σ kᵢ arcᵢ + rest, adding one arc after the other."""
    arcs, rest = [], angle
    for trig, monomial, factor in angle.terms():
        for index, atom in angle.ring.atoms.items():
            if (
                not trig
                and monomial == power(index)
                and factor.denominator == 1
                and atom.function in _OF_ARC
            ):
                arcs.append((atom, int(factor)))
                rest = rest - factor * angle.ring.monomial(monomial)
    sine, cosine = function("sin")(rest), function("cos")(rest)
    for atom, count in arcs:
        s, c = _OF_ARC[atom.function](atom.argument)
        s = s if count > 0 else -s
        for _ in range(abs(count)):
            sine, cosine = sine * c + cosine * s, cosine * c - sine * s
    return sine, cosine


_OF_ARC: dict[str, Callable[[Series], tuple[Series, Series]]] = {
    "asin": lambda u: (u, sqrt(1 - u * u)),
    "acos": lambda u: (sqrt(1 - u * u), u),
    "atan": lambda u: (u / sqrt(1 + u * u), 1 / sqrt(1 + u * u)),
}
"""Functions that give sine and cosine of each arc."""
