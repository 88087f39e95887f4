"""Derivatives along the motion against sympy's, and how they grow with the length of a chain."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
import sympy

import mecanique as mq
from mecanique.errors import EngineError
from mecanique.model import Coordinates, coordinate
from mecanique.model.expression import evaluate
from mecanique.reference.engine.differentiation import MovingScalar, Operations, apply

X, Y, K = sympy.symbols("x y k", real=True)
U, W = sympy.symbols("u w", real=True)

LAWS = (
    X * Y + 3 * X - K,
    X**3 / Y - 1 / (2 - X),
    sympy.sqrt(X**2 + Y**2 + K) * sympy.sin(X) * sympy.cos(2 * Y),
    sympy.tan(X / 2) + sympy.tanh(X * Y) - sympy.exp(-K * X),
    sympy.asin(X / 3) + sympy.acos(Y / 3) * sympy.atan(K * X * Y),
    sympy.log(X + 2 * Y) * (X + Y) ** K,
    sympy.atan2(X * Y, X - 2) + Y**X + K**X,
    sympy.Abs(X - 2) * Y + sympy.sign(Y - X) * X,
    3**X - Y * 2 ** (X * Y),
)


OPERATORS: dict[str, Callable[[Any, Any], Any]] = {
    "a sum": lambda x, y: x + y * y,
    "a number and": lambda x, y: 3.0 + x * y,
    "a difference": lambda x, y: x * x - y,
    "less a number": lambda x, _: x * x - 3.0,
    "a negative": lambda x, y: -(x * y),
    "a number times": lambda x, y: 3.0 * (x * y),
    "a quotient": lambda x, y: x / (x * y + 2.0),
    "over a number": lambda x, y: x * y / 3.0,
    "a number over": lambda x, y: 3.0 / (x * y + 2.0),
    "a power": lambda x, y: x ** (x * y),
    "a number's power": lambda x, y: 3.0 ** (x * y),
}
"""The operators of Python, which sympy writes as sums, products and powers alone."""


def compile_law(law: sympy.Expr | Callable[[Any, Any], Any]) -> tuple[float, ...]:
    """Return value, slopes by u and w, what remains by time, and y'', for x' = u and y' = w."""
    names = ("x", "y", "u", "w", "t", "k")
    operations = Operations(names)
    given = {name: operations.argument(name) for name in names}
    values = {
        "k": given["k"],
        "x": MovingScalar(operations, given["x"].value, {"u": 1.0}, given["u"].value),
        "y": MovingScalar(operations, given["y"].value, {"w": 1.0}, given["w"].value),
    }
    written = isinstance(law, sympy.Expr)
    path = evaluate(law, values, function=apply) if written else law(values["x"], values["y"])
    results = [path.value, *(path.slopes.get(name, 0.0) for name in ("u", "w")), path.rate]
    return operations.compile([*results, path.second], names)(0.7, 1.1, 0.9, -1.3, 0.2, 1.7)


def derive_law(law: sympy.Expr) -> list[float]:
    """Return the same by sympy."""
    slopes = [law.diff(X), law.diff(Y)]
    rate = slopes[0] * U + slopes[1] * W
    second = rate.diff(X) * U + rate.diff(Y) * W
    at = {X: 0.7, Y: 1.1, U: 0.9, W: -1.3, K: 1.7}
    return [float(part.subs(at)) for part in (law, *slopes, rate, second)]


@pytest.mark.parametrize("law", LAWS, ids=str)
def test_derivatives_are_those_of_sympy(law: sympy.Expr) -> None:
    np.testing.assert_allclose(compile_law(law), derive_law(law), rtol=1e-13, atol=0)


@pytest.mark.parametrize("name", OPERATORS)
def test_derivatives_of_operators_are_those_of_sympy(name: str) -> None:
    law = OPERATORS[name]
    np.testing.assert_allclose(compile_law(law), derive_law(law(X, Y)), rtol=1e-13, atol=0)


def test_a_root_of_a_negative_number_is_refused() -> None:
    """Not made complex: a map of x^(3/2) ended in a TypeError wherever it was evaluated."""
    follower = mq.Prismatic("up", "ground", "b", axis=(0, 0, 1))
    mechanism = mq.Mechanism(
        "cam",
        (mq.Body("ground"), mq.Body("a", mq.particle(1.0)), mq.Body("b", mq.particle(1.0))),
        (mq.Prismatic("s", "ground", "a", axis=(1, 0, 0), coordinate="x"), follower),
        coordinates=Coordinates(("x",), {"up": coordinate("x") ** 1.5}),
    )
    reference = mq.Reference(mechanism)
    # z = x^(3/2): (1 + 9 x/4) x'' = -(9/8) x'^2 - (3/2) g sqrt(x)
    (rate,) = reference.acceleration([4.0], [2.0])
    assert rate == pytest.approx(-(9 / 8 * 4.0 + 1.5 * 9.81 * 2.0) / 10.0, rel=1e-12, abs=0)
    with pytest.raises(EngineError, match="has no finite answer"):
        reference.acceleration([-0.5], [1.0])


def test_operations_grow_with_the_square_of_the_length_of_a_chain() -> None:
    """A slope by each coordinate at each step; second derivatives written out grow far faster."""

    def count(links: int) -> int:
        names = tuple(f"q{k}" for k in range(links))
        operations = Operations((*names, "t"))
        law = sympy.Integer(1)
        for name in names:
            law = sympy.sin(law + sympy.Symbol(name)) * sympy.Symbol(name)
        values = {
            name: MovingScalar(operations, operations.argument(name).value, {name: 1.0}, 1.0)
            for name in names
        }
        assert math.isfinite(
            operations.compile([evaluate(law, values, function=apply).second], names)(
                *np.linspace(0.1, 1.0, links)
            )[0]
        )
        return len(operations)

    assert count(40) < 4.5 * count(20)


@pytest.mark.parametrize("a", [0.0, 1.0, -2.5, "x"])
@pytest.mark.parametrize("b", [0.0, 1.0, 0.3, "y"])
def test_sums_and_products_of_numbers_and_names_are_what_they_say(
    a: float | str, b: float | str
) -> None:
    operations = Operations(("x", "y"))
    given = {name: operations.argument(name).value for name in ("x", "y")}
    left, right = given.get(str(a), a), given.get(str(b), b)
    results = [operations.add(left, right), operations.multiply(left, right)]
    first, second = (1.7 if a == "x" else float(a)), (-0.6 if b == "y" else float(b))
    found = operations.compile(results, ("x", "y"))(1.7, -0.6)
    assert found == (first + second, first * second)
