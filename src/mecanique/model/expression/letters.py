"""Letters as sympy symbols, whose expressions answer numpy's functions, and math's in words.

Left alone, numpy looks for a method of the function's name and reports that a `Mul` has none, and
math reports that an expression is not a float. Neither names the remedy, and both are reached by an
expression's class, so that the class is taught here, once, when the first letter is made: what it
computes otherwise stays as it is.
"""

from __future__ import annotations

from functools import lru_cache
from typing import Any

import numpy as np

__all__ = ["answer", "letter", "refusal"]

_NAMES = {
    "absolute": "Abs",
    "arccos": "acos",
    "arcsin": "asin",
    "arctan": "atan",
    "arctan2": "atan2",
    "cos": "cos",
    "exp": "exp",
    "log": "log",
    "sign": "sign",
    "sin": "sin",
    "sqrt": "sqrt",
    "tan": "tan",
    "tanh": "tanh",
}
"""What numpy's functions are called in sympy, as far as expressions may hold them."""


def letter(name: str) -> Any:
    """Return a letter as a sympy symbol."""
    return _symbol_class()(name)


def answer(_: Any, function: Any, method: str, *inputs: Any, **options: Any) -> Any:
    """Return what one of numpy's functions makes of letters and expressions: an expression.

    Args:
        function: numpy's; operators work entry by entry, as on other objects.
        method: how it is called, e.g. "__call__".
        inputs: its operands.
        options: its other arguments.

    Raises:
        TypeError: if it is no function that an expression may hold.
    """
    import sympy

    name = _NAMES.get(function.__name__)
    alone = method == "__call__" and not options
    if name and alone and not any(isinstance(each, np.ndarray) for each in inputs):
        return getattr(sympy, name)(*inputs)
    try:
        return getattr(function, method)(*map(_box, inputs), **options)
    except (TypeError, AttributeError):
        if function.nin > 1 and name is None:
            raise
        lettered = next(each for each in inputs if _is_lettered(each))
        raise TypeError(refusal(getattr(lettered, "symbol", lettered))) from None


def refusal(lettered: Any) -> str:
    """Return what a function of numbers is to say of a letter or an expression."""
    kind = "letter" if str(lettered).isidentifier() else "expression"
    return (
        f"expected a number, got the {kind} {lettered}; functions of letters are those of "
        f"mecanique, e.g. mecanique.sin({lettered})"
    )


@lru_cache(maxsize=1)
def _symbol_class() -> Any:
    """Sympy's Symbol, after its expressions have been taught."""
    from sympy import Expr, Symbol

    to_float = Expr.__float__

    def to_number(self: Any) -> float:
        try:
            return float(to_float(self))
        except TypeError:
            if self.free_symbols:
                raise TypeError(refusal(self)) from None
            raise

    Expr.__float__ = to_number
    Expr.__array_ufunc__ = answer
    return Symbol


def _is_lettered(operand: Any) -> bool:
    return getattr(type(operand), "__array_ufunc__", None) is answer


def _box(operand: Any) -> Any:
    """An operand as numpy's operators take it: a letter or expression in an array of objects."""
    if not _is_lettered(operand):
        return operand
    boxed = np.empty((), dtype=object)
    boxed[()] = operand
    return boxed
