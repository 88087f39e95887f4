"""Straight-line programs: values, derivatives both ways, what costs nothing, listings."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from mecanique.derivation.scalars.functions import function
from mecanique.errors import DerivationError
from mecanique.model.expression import numpy_function
from mecanique.program.evaluation import evaluate
from mecanique.program.half_angles import by_tangents
from mecanique.program.listing import Notation, list_program
from mecanique.program.solving import eliminate, factorize
from mecanique.program.sweeps import pull_back, push_forward, substitute
from mecanique.program.tape import Tape, Value, count
from mecanique.program.traced import Traced, call, trace, value_of, values_of

PROPERTY = settings(deadline=None, max_examples=40, derandomize=True)
NAMES = ("x", "y", "z")
AT = {"x": 0.7, "y": -1.3, "z": 0.45}
SMOOTH = ("sin", "cos", "tanh", "atan", "exp")

Formula = Callable[[dict[str, Any], Callable[[str], Callable[..., Any]]], Any]
"""A formula of letters and functions, of numbers or on a tape."""


@st.composite
def formulas(draw: Any, depth: int = 4) -> Formula:
    """Return a formula that is analytic near the place at which it is taken."""
    if depth == 0 or draw(st.integers(0, 5)) == 0:
        letter = draw(st.sampled_from([*NAMES, -2.0, -1.0, 0.0, 0.5, 1.0, 3.0]))
        return lambda x, f: x[letter] if isinstance(letter, str) else letter
    kind = draw(st.sampled_from(["+", "-", "*", "/", "-u", "power", "function"]))
    a, b = draw(formulas(depth=depth - 1)), draw(formulas(depth=depth - 1))
    exponent, name = draw(st.integers(-2, 3)), draw(st.sampled_from(SMOOTH))
    of_kind: dict[str, Formula] = {
        "+": lambda x, f: a(x, f) + b(x, f),
        "-": lambda x, f: a(x, f) - b(x, f),
        "*": lambda x, f: a(x, f) * b(x, f),
        "/": lambda x, f: a(x, f) / (2.0 + b(x, f) * b(x, f)),
        "-u": lambda x, f: -a(x, f),
        "power": lambda x, f: (1.5 + a(x, f) * a(x, f)) ** exponent,
        "function": lambda x, f: f(name)(f("tanh")(a(x, f))),
    }
    return of_kind[kind]


def record(formula: Formula) -> tuple[Tape, Value]:
    """Return a formula as a program."""
    tape = Tape()
    letters = {name: trace(tape, tape.input(name)) for name in NAMES}
    return tape, value_of(formula(letters, lambda f: lambda *x: call(tape, f, *x)))


def compute(tape: Tape, *outputs: Value) -> list[float]:
    given = {name: np.array([value]) for name, value in AT.items()}
    return [float(x) for x in evaluate(tape, outputs, given, 1)[0]]


def close(x: Any, y: Any) -> None:
    np.testing.assert_allclose(x, y, rtol=1e-11, atol=1e-11)


@PROPERTY
@given(formulas())
def test_a_program_has_the_value_of_its_formula(formula: Formula) -> None:
    close(compute(*record(formula)), formula(AT, numpy_function))


@PROPERTY
@given(formulas())
def test_derivatives_are_those_of_a_complex_step(formula: Formula) -> None:
    """Forward along a direction, and in reverse by each input (Squire & Trapp, 1998)."""
    tape, y = record(formula)
    inputs = [tape.input(name) for name in NAMES]
    direction = (0.3, -0.8, 1.1)
    slopes = []
    for name in NAMES:
        at = {**AT, name: AT[name] + 1e-30j}
        slopes.append(
            np.imag(formula(at, lambda f: getattr(np, {"atan": "arctan"}.get(f, f)))) / 1e-30
        )
    along = dict(zip(inputs, direction, strict=True))
    close(compute(tape, *push_forward(tape, [y], along)), [np.dot(slopes, direction)])
    close(compute(tape, *pull_back(tape, [y, y], [2.0, -0.5], inputs)), 1.5 * np.array(slopes))
    (second,) = push_forward(tape, push_forward(tape, [y], {inputs[0]: 1.0}), {inputs[1]: 1.0})
    (turned,) = push_forward(tape, push_forward(tape, [y], {inputs[1]: 1.0}), {inputs[0]: 1.0})
    close(compute(tape, second), compute(tape, turned))


@pytest.mark.parametrize(
    ("name", "arguments", "slopes"),
    [
        ("tan", (0.4,), (1 / math.cos(0.4) ** 2,)),
        ("sqrt", (0.4,), (0.5 / math.sqrt(0.4),)),
        ("log", (0.4,), (2.5,)),
        ("asin", (0.6,), (1.25,)),
        ("acos", (0.6,), (-1.25,)),
        ("Abs", (-0.4,), (-1.0,)),
        ("sign", (-0.4,), (0.0,)),
        ("sign", (0.0,), (0.0,)),
        ("atan2", (3.0, -4.0), (-4 / 25, -3 / 25)),
        ("pow", (2.0, 3.0), (12.0, 8 * math.log(2.0))),
    ],
)
def test_functions_have_their_values_and_derivatives(
    name: str, arguments: tuple[float, ...], slopes: tuple[float, ...]
) -> None:
    tape = Tape()
    inputs = [tape.input(name) for name in "ab"[: len(arguments)]]
    y = tape.call(name, *inputs)
    given = dict(zip("ab", arguments, strict=False))
    gradient = pull_back(tape, [y], [1.0], inputs)
    rates = [push_forward(tape, [y], {x: 1.0})[0] for x in inputs]
    exact = math.pow(*arguments) if name == "pow" else numpy_function(name)(*arguments)
    for outputs in ([y, *gradient], [y, *rates]):
        close(evaluate(tape, outputs, given, 1)[0], [exact, *slopes])
    assert tape.call(name, *arguments) == pytest.approx(float(exact), rel=1e-15)


def test_what_has_no_derivative_is_refused() -> None:
    tape = Tape()
    with pytest.raises(DerivationError, match="no derivative is known for 'floor'"):
        push_forward(tape, [tape.call("floor", tape.input("x"))], {tape.input("x"): 1.0})


def test_what_is_known_beforehand_costs_nothing() -> None:
    tape = Tape()
    x, y = (trace(tape, tape.input(name)) for name in "xy")
    n = len(tape.operations)
    free = [x + 0, 0 + x, x - 0.0, x * 1, 1.0 * x, x / 1]
    assert {value_of(same) for same in free} == {x.place}
    assert [x - x, x * 0, 0 * x, 0 / x, x**0, x**1 - x] == [0.0, 0.0, 0.0, 0.0, 1.0, 0.0]
    assert len(tape.operations) == n
    assert value_of(x + y) == value_of(y + x)
    assert value_of(x * y) == value_of(y * x)
    assert value_of(x - y) != value_of(y - x)
    # signs and numbers are moved to where they cost least
    assert value_of(x + -y) == value_of(-y + x) == value_of(x - y)
    assert value_of(x - -y) == value_of(x + y)
    assert value_of(x + -2 * y) == value_of(x - 2 * y)
    assert value_of(0 - x) == value_of(-x)
    negative = -x
    assert value_of(-negative) == x.place
    assert value_of((2 * x) * (3 * y)) == value_of(6 * (x * y)) == value_of(x * 6 * y)
    assert value_of(0.5 * (2 * x)) == x.place
    sine, cosine = call(tape, "sin", -x), call(tape, "cos", -3 * x)
    assert value_of(sine) == value_of(-call(tape, "sin", x))
    assert value_of(cosine) == value_of(call(tape, "cos", 3 * x))


@pytest.mark.parametrize("exponent", range(-9, 17))
def test_powers_are_squared_and_multiplied(exponent: int) -> None:
    """By the binary digits of the exponent, each of which costs two products at most."""
    tape = Tape()
    power = tape.power(tape.input("x"), exponent)
    assert evaluate(tape, [power], {"x": -1.3}, 1)[0, 0] == pytest.approx(
        (-1.3) ** exponent, rel=1e-13
    )
    size = abs(exponent)
    products = max(size.bit_length() + size.bit_count() - 2, 0)
    assert count(tape, [power]).multiplications == products
    assert count(tape, [power]).divisions == (exponent < 0)


def test_operations_are_counted_once_and_bounded() -> None:
    tape = Tape(most=8)
    x, y = (trace(tape, tape.input(name)) for name in "xy")
    root = call(tape, "sqrt", x * y)
    whole = value_of((root + x) / y - root)
    assert str(count(tape, [whole, whole])) == (
        "5 operations: 2 additions, 1 multiplications, 1 divisions, 1 functions"
    )
    assert count(tape, [value_of(root)]).total == 2
    call(tape, "sin", x)
    with pytest.raises(DerivationError, match="takes more than 8 operations"):
        call(tape, "cos", x)


@PROPERTY
@given(formulas(), formulas())
def test_what_replaces_an_input_is_composed(outer: Formula, inner: Formula) -> None:
    tape, y = record(outer)
    letters = {name: trace(tape, tape.input(name)) for name in NAMES}
    put = value_of(inner(letters, lambda f: lambda *x: call(tape, f, *x)))
    (composed,) = substitute(tape, [y], {tape.input("x"): put})
    at = {**AT, "x": float(inner(AT, numpy_function))}
    close(compute(tape, composed), outer(at, numpy_function))


@PROPERTY
@given(formulas())
def test_a_listing_computes_the_same_to_the_last_bit(formula: Formula) -> None:
    """Written in Python and run: parentheses keep the order in which is rounded."""
    tape, y = record(formula)
    names = {f: f"numpy_function('{f}')({{}})" for f in (*SMOOTH, "pow")}
    listing = list_program(tape, [y, 2.0], {n: n for n in NAMES}, Notation(names, "{} = {}"))
    scope: dict[str, Any] = {"numpy_function": numpy_function, **AT}
    exec("\n".join(listing.lines), scope)
    assert [eval(text, scope) for text in listing.outputs] == compute(tape, y, 2.0)


def test_a_listing_names_what_is_used_twice_or_is_long() -> None:
    tape = Tape()
    x, y = (trace(tape, tape.input(name)) for name in ("x", "y"))
    notation = Notation({"sin": "sin({})"}, "let {} = {};")
    written = {
        "(x0 - x1) / (x0 / (a / b))": (x * y - (x - y)) / (x * y / (x / y)),
        "x0 + 3.0 * a": x * y - -3.0 * x,
        "-(a * a)": -(x * x),
        "a - (2.0 + b)": x - (y + 2.0),
        "x1 * (a + b)": (x - y) * (x + y),
        "a / (b / a)": x / (y / x),
        "3.0 * sin(x1)": 3.0 * call(tape, "sin", x - y),
    }
    letters = {"x": "a", "y": "b", "z": "c"}
    listing = list_program(tape, values_of(written.values()), letters, notation)
    assert listing.outputs == (*written,)
    assert listing.inputs == ("x", "y")
    assert listing.lines == ("let x0 = a * b;", "let x1 = a - b;")
    assert [*listing.names.values()] == ["x0", "x1"]
    area = (x * y).place
    chosen = list_program(tape, [area], letters, notation, {area: "area"})
    assert (chosen.lines, chosen.outputs) == (("let area = a * b;",), ("area",))
    terms = [trace(tape, tape.input(f"p{k:02}")) for k in range(40)]
    names = {f"p{k:02}": f"p{k:02}" for k in range(40)}
    lines = list_program(tape, [value_of(sum(terms, 0.0 * x))], names, notation).lines
    sizes = [len(line) - len("let x0 = ;") for line in lines]
    assert all(72 < size <= 72 + len("p00 + ()") for size in sizes)
    with pytest.raises(DerivationError, match="there is no 'cos' in this language"):
        list_program(tape, [tape.call("cos", x.place)], {"x": "a"}, notation)


def count_functions(tape: Tape, outputs: list[Value]) -> dict[str, int]:
    kinds = [tape.operations[place][0] for place in tape.find_needed(outputs)]
    return {name: kinds.count(name) for name in ("sin", "cos", "tan") if name in kinds}


def test_sine_and_cosine_of_an_angle_share_a_tangent() -> None:
    tape = Tape()
    a, b, c = (trace(tape, tape.input(name)) for name in "abc")

    def waves(angle: Any, *names: str) -> list[Value]:
        return [value_of(call(tape, name, angle)) for name in names or ("sin", "cos")]

    cases: list[tuple[list[Value], dict[str, int]]] = [
        (waves(a), {"tan": 1}),
        (waves(a, "sin") + waves(b, "cos"), {"sin": 1, "cos": 1}),
        (waves(a) + waves(a + b), {"tan": 2}),
        (waves(a) + waves(a - b, "sin"), {"tan": 2}),
        (waves(a, "sin") + waves(a + b) + waves(a + b - c, "cos"), {"tan": 3}),
        (waves(a + b), {"tan": 1}),
        (waves(a) + waves(a + 0.5), {"tan": 2}),
    ]
    random = np.random.default_rng(0)
    at = {name: random.uniform(-4, 4, 20) for name in "abc"}
    for outputs, functions in cases:
        short, moved = by_tangents(tape, [*outputs, 2.5])
        assert count_functions(short, moved) == functions
        close(evaluate(short, moved, at, 20), evaluate(tape, [*outputs, 2.5], at, 20))


@pytest.mark.parametrize("n", [1, 2, 5])
def test_symmetric_and_other_systems_are_solved(n: int) -> None:
    random = np.random.default_rng(n)
    A, rest = random.normal(size=(n, n)) + 3 * np.eye(n), random.normal(size=n)
    M = A @ A.T
    tape = Tape()
    rows = [[trace(tape, tape.input(f"m{i}{k}")) for k in range(n)] for i in range(n)]
    right = [trace(tape, tape.input(f"r{i}")) for i in range(n)]
    factors = factorize(tape, rows)
    at = {f"m{i}{k}": M[i, k] for i in range(n) for k in range(i + 1)}
    at |= {f"r{i}": x for i, x in enumerate(rest)}
    solved = values_of(factors.solve(right))
    close(evaluate(tape, solved, at, 1)[0], np.linalg.solve(M, rest))
    U = np.eye(n)
    for k, row in enumerate(factors.rows):
        U[k, :k] = evaluate(tape, row, at, 1)[0]
    D = np.diag(evaluate(tape, factors.pivots, at, 1)[0])
    close(U.T @ D @ U, M)
    close(eliminate(A.tolist(), rest.tolist()), np.linalg.solve(A, rest))


def test_a_chain_of_parents_fills_in_no_zero() -> None:
    """Where the last is coupled with its parent alone, n rows take one step each."""
    products = []
    for n in (10, 20):
        tape = Tape()
        rows: list[list[Any]] = [[0.0] * n for _ in range(n)]
        for k in range(n):
            rows[k][k] = trace(tape, tape.input(f"d{k}"))
            parent = (k - 1) // 2
            if parent >= 0:
                rows[k][parent] = trace(tape, tape.input(f"o{k}"))
        factors = factorize(tape, rows)
        assert [sum(value != 0.0 for value in row) for row in factors.rows] == [0] + [1] * (n - 1)
        products.append(count(tape, factors.pivots).multiplications)
    assert products == [9, 19]


def test_traced_scalars_keep_numbers_as_numbers() -> None:
    tape = Tape()
    x = trace(tape, tape.input("x"))
    assert isinstance(x, Traced)
    results = [3 - x, x - 3, 2 / x, x / 2, x**-2, x**0.5, 2.0**x, x**x, np.float64(2.0) * x]
    at = {"x": np.array(1.7)}
    exact = [1.3, -1.3, 2 / 1.7, 0.85, 1.7**-2, 1.7**0.5, 2**1.7, 1.7**1.7, 3.4]
    close(evaluate(tape, values_of(results), at, 1)[0], exact)
    assert evaluate(tape, [], at, 3).shape == (3, 0)
    assert function("sin")(0.0) == 0.0
