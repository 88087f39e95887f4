"""Parameters, inputs and expressions: exact arithmetic, one value in every way of evaluating."""

from __future__ import annotations

import math
import pickle
from collections.abc import Callable
from fractions import Fraction
from typing import Any

import numpy as np
import pytest
import sympy
from hypothesis import given, settings
from hypothesis import strategies as st

from mecanique.errors import InputError, UnknownNameError
from mecanique.model import Input, Parameter, Record, coordinate, time, velocity
from mecanique.model.expression import (
    FUNCTIONS,
    compile_scalars,
    evaluate,
    finite,
    plain,
    symbols_in,
)

m, k = Parameter("m", 2.0, "kg", "mass"), Parameter("k", 3.0, "N/m")
M, K = sympy.symbols("m k")
NUMBERS = st.floats(0.1, 5.0)


@pytest.mark.parametrize(
    "make",
    [
        lambda m, k: m + k,
        lambda m, k: m + 1,
        lambda m, k: 1 + m,
        lambda m, k: m - k,
        lambda m, k: m - 2,
        lambda m, k: 2 - m,
        lambda m, k: m * k,
        lambda m, k: 3 * m,
        lambda m, k: m * 3,
        lambda m, k: m / k,
        lambda m, k: m / 12,
        lambda m, k: 1 / m,
        lambda m, k: m**2,
        lambda m, k: m**k,
        lambda m, k: 2**k,
        lambda m, k: -m,
        lambda m, k: abs(m),
        lambda m, k: m * k**2 / 12,
    ],
)
def test_arithmetic_of_parameters_is_that_of_symbols_and_exact(
    make: Callable[[Any, Any], Any],
) -> None:
    made = make(m, k)
    assert made == make(M, K)
    assert not made.has(sympy.Float)


@pytest.mark.parametrize(
    "expression",
    [
        sympy.Integer(3),
        sympy.Rational(1, 3) + sympy.pi,
        M * K - M / K,
        M**2 + sympy.sqrt(K) + 1 / sympy.sqrt(M),
        M**K + M**-3,
        sympy.sin(M) * sympy.cos(K) - sympy.tan(M / 10),
        sympy.asin(M / 10) + sympy.acos(K / 10) + sympy.atan(M) + sympy.atan2(M, K),
        sympy.exp(-M) + sympy.log(K) + sympy.tanh(M),
        sympy.Abs(M - K) + sympy.sign(K - M),
        -M,
        M - M,
    ],
)
@settings(deadline=None, max_examples=10)
@given(a=NUMBERS, b=NUMBERS)
def test_every_way_of_evaluating_gives_what_sympy_gives(
    expression: Any, a: float, b: float
) -> None:
    exact = float(expression.subs({M: a, K: b}))
    assert evaluate(expression, {"m": a, "k": b}) == pytest.approx(exact, rel=1e-12, abs=1e-12)
    assert compile_scalars([expression], ["m", "k"])(a, b)[0] == pytest.approx(
        exact, rel=1e-12, abs=1e-12
    )
    batch = evaluate(expression, {"m": np.array([a, a]), "k": np.array([b, b])})
    np.testing.assert_allclose(np.broadcast_to(batch, 2), exact, rtol=1e-12, atol=1e-12)


def test_the_cases_above_cover_every_function() -> None:
    arguments = {"atan2": (M, K)}
    for name in FUNCTIONS:
        expression = getattr(sympy, name)(*arguments.get(name, (M,)))
        assert math.isfinite(evaluate(expression, {"m": 0.5, "k": 0.25}))


def test_other_arithmetics_are_used_throughout() -> None:
    third = evaluate(M / 3 + 1, {"m": Fraction(1)}, number=lambda n: Fraction(int(n.p), int(n.q)))
    assert third == Fraction(4, 3)
    seen: list[str] = []

    def function(name: str) -> Callable[..., float]:
        seen.append(name)
        return lambda *_: 7.0

    assert evaluate(sympy.sin(M) + sympy.sqrt(K), {"m": 1.0, "k": 4.0}, function=function) == 14.0
    assert sorted(seen) == ["sin", "sqrt"]


def test_constants_compile_to_constants_and_order_of_names_counts() -> None:
    assert compile_scalars([1, 2.5], [])() == (1.0, 2.5)
    assert compile_scalars([m - k, velocity("q")], ["k", "m", "q'"])(1.0, 3.0, 5.0) == (2.0, 5.0)


def test_symbols_of_a_description() -> None:
    assert symbols_in(m * time() + coordinate("q") - velocity("q")) == {"m", "t", "q", "q'"}
    assert symbols_in(3) == frozenset()
    assert plain(np.float64(2)) == 2.0
    assert isinstance(plain(np.int64(2)), float)


def test_unknown_symbols_are_named() -> None:
    with pytest.raises(UnknownNameError, match="unknown symbol 'm'"):
        evaluate(m * 2, {"k": 1.0})
    with pytest.raises(UnknownNameError, match="unknown symbol 'm'"):
        compile_scalars([m * 2], ["k"])


def test_a_function_outside_the_list_is_refused() -> None:
    with pytest.raises(InputError, match=r"expected functions among sin, .*, got gamma in gamma"):
        evaluate(sympy.gamma(M), {"m": 1.0})


@pytest.mark.parametrize("bad", [True, np.bool_(True), "3", None, [1.0], {}, 10**400])
def test_what_is_no_scalar_is_refused(bad: Any) -> None:
    with pytest.raises(InputError, match=r"expected a number.* got"):
        plain(bad)


@pytest.mark.parametrize("bad", [math.nan, math.inf, "3", True, None, 10**400, 1j])
def test_what_is_no_finite_number_is_refused(bad: Any) -> None:
    with pytest.raises(InputError, match="expected a finite number for weight, got"):
        finite(bad, "weight")
    with pytest.raises(InputError, match="expected a finite number for parameter m, got"):
        Parameter("m", bad)


@pytest.mark.parametrize("kind", [Parameter, Input])
@pytest.mark.parametrize("symbol", ["", "1m", "a b", "t", None, 3])
def test_bad_symbols_are_refused(kind: Any, symbol: Any) -> None:
    with pytest.raises(InputError, match=r"expected .* symbol"):
        kind(symbol, 1.0)


def test_a_parameter_changes_its_value_only_in_a_copy() -> None:
    other = m.with_value(5)
    assert (other.value, other.symbol, other.unit, other.meaning) == (5.0, "m", "kg", "mass")
    assert m.value == 2.0
    with pytest.raises(AttributeError):
        m.value = 3.0  # type: ignore[misc]  # that is the point
    assert pickle.loads(pickle.dumps(m)) == m


def test_inputs_are_numbers_expressions_functions_or_records() -> None:
    values = {"m": 2.0}
    assert Input("F", 3).function({})(1.7) == 3.0
    assert Input("F", m * sympy.cos(time())).function(values)(0.5) == pytest.approx(
        2 * math.cos(0.5), rel=1e-12
    )
    assert Input("F", math.sin).function({})(0.5) == math.sin(0.5)
    record = Record(np.array([0.0, 1.0, 3.0]), np.array([0.0, 2.0, -2.0]))
    assert [Input("F", record).function({})(t) for t in (-1.0, 0.5, 2.0, 9.0)] == [
        0.0,
        1.0,
        0.0,
        -2.0,
    ]
    assert Input("F", m * time()).symbols == {"m", "t"}
    assert Input("F", math.sin).symbols == frozenset()
    assert Input("F", 1.0) * 2 == 2 * sympy.Symbol("F")


@pytest.mark.parametrize(
    ("times", "values", "message"),
    [
        ([0, 1], [1], r"expected times and values of one shape \(n,\), got \(2,\) and \(1,\)"),
        ([], [], "expected times and values of one shape"),
        ([0, 0], [1, 2], "expected increasing times in a record"),
        ([0, 1], [1, math.nan], "expected finite times and values in a record"),
        ([0, math.inf], [1, 2], "expected finite times and values in a record"),
    ],
)
def test_bad_records_are_refused(times: list[float], values: list[float], message: str) -> None:
    with pytest.raises(InputError, match=message):
        Record(np.array(times), np.array(values))


def test_a_record_keeps_its_own_copy() -> None:
    times = np.array([0.0, 1.0])
    record = Record(times, np.array([5.0, 6.0]))
    times[1] = -9.0
    assert record(1.0) == 6.0
    with pytest.raises(ValueError, match="read-only"):
        record.values[0] = 1.0
    assert pickle.loads(pickle.dumps(record))(0.5) == 5.5


def test_an_infinite_input_is_refused() -> None:
    with pytest.raises(InputError, match="expected a finite number for F, got nan"):
        Input("F", math.nan)


def test_what_occurs_many_times_is_evaluated_once() -> None:
    x = sympy.Symbol("x")
    nested = x
    for _ in range(40):  # as a tree, it has 2⁴⁰ leaves
        nested = sympy.sin(nested) + sympy.cos(nested)
    expected = 0.3
    for _ in range(40):
        expected = math.sin(expected) + math.cos(expected)
    assert evaluate(nested, {"x": 0.3}) == pytest.approx(expected, rel=1e-12)
