"""Read printed formulas back: juxtaposition is the product, ^ the power, ' belongs to the name."""

from __future__ import annotations

import re
from collections.abc import Mapping
from typing import Any

import numpy as np

_FUNCTIONS = {
    "sin": np.sin,
    "cos": np.cos,
    "tan": np.tan,
    "sqrt": np.sqrt,
    "exp": np.exp,
    "log": np.log,
}
_FUNCTIONS |= {
    "asin": np.arcsin,
    "acos": np.arccos,
    "atan": np.arctan,
    "tanh": np.tanh,
    "abs": np.abs,
    "sign": np.sign,
}


def value_of_text(text: str, values: Mapping[str, Any]) -> Any:
    """Return the value of a printed formula.

    Args:
        text: one side of a printed equation.
        values: value of each symbol, by name.
    """
    names: dict[str, Any] = {"pi": np.pi}

    def named(match: re.Match[str]) -> str:
        name = match[0]
        if name[0].isdigit():
            return name
        if match.end() < len(text) and text[match.end()] == "(":
            names[name] = _FUNCTIONS[name]
            return name
        key = f"v{len(names)}_"
        names[key] = values[name]
        return key

    python = re.sub(r"\d[\d.]*(?:e[+-]?\d+)?|[^\W\d]\w*'*", named, text)
    # a blank between two operands is a product
    python = re.sub(r"(?<=[\w)]) (?=[\w(])", "*", python).replace("^", "**")
    return eval(python, {"__builtins__": {}}, names)


def residual(equation: str, values: Mapping[str, Any]) -> Any:
    """Return left minus right of a printed equation.

    Args:
        equation: e.g. "q'' + 3 g sin(q)/(2 l) = 0".
        values: value of each symbol, by name.
    """
    left, right = equation.split(" = ")
    return value_of_text(left, values) - value_of_text(right, values)
