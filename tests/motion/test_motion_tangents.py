from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import mecanique as mq
from mecanique.motion.compile.derive import program_of
from mecanique.motion.compile.program import RatesProgram
from mecanique.motion.compile.python import scalar, vectorize
from mecanique.program.half_angles import by_tangents
from mecanique.program.tape import Tape

NAMES = ("rigid_bar_pendulum", "double_pendulum", "elastic_pendulum", "cart_pole", "heavy_top")


def kinds(tape: Tape, outputs: list[float | int]) -> list[str]:
    return [tape.operations[place][0] for place in tape.find_needed(outputs)]


def chain(n: int) -> RatesProgram:
    rods = [mq.Body(f"rod{k}", mq.rod(1.0, 1.0)) for k in range(n)]
    joints = [
        mq.Revolute(
            f"pin{k}",
            f"rod{k - 1}" if k else "ground",
            f"rod{k}",
            axis=(0, -1, 0),
            coordinate=f"q{k}",
        )
        for k in range(n)
    ]
    return program_of(
        mq.Mechanism("chain", (mq.Body("ground"), *rods), tuple(joints), gravity=(0, 0, -9.81))
    )


@pytest.mark.parametrize("name", NAMES)
def test_arrays_give_what_floats_give(name: str) -> None:
    program = program_of(mq.textbook.load(name))
    random = np.random.default_rng(1)
    Y = random.uniform(0.3, 2.5, (len(program.states), 20))
    out = np.empty_like(Y)
    vectorize(program)(0.0, Y, out)
    expected = np.array([scalar(program)(0.0, y) for y in Y.T]).T
    np.testing.assert_allclose(out, expected, rtol=1e-12, atol=1e-12)


@given(st.floats(-100, 100), st.floats(-100, 100))
@settings(max_examples=200, deadline=None)
def test_sums_and_differences_follow_the_addition_theorems(x: float, y: float) -> None:
    tape = Tape()
    a, b = tape.input("a"), tape.input("b")
    total, gap = tape.add(a, b), tape.subtract(a, b)
    outputs = [tape.call(f, angle) for angle in (a, total, gap) for f in ("sin", "cos")]
    new, moved = by_tangents(tape, outputs)
    assert set(kinds(new, moved)) == {"input", "tan", "+", "-", "*", "/"}
    assert kinds(new, moved).count("tan") == 2
    found = {"a": x, "b": y}
    values: dict[int, float] = {}
    for place in new.find_needed(moved):
        kind, parts, name = new.operations[place]
        numbers = [part if isinstance(part, float) else values[part] for part in parts]
        values[place] = found[name] if kind == "input" else _computed(kind, numbers)
    expected = [np.sin(x), np.cos(x), np.sin(x + y), np.cos(x + y), np.sin(x - y), np.cos(x - y)]
    # the sum of the angles is itself rounded
    np.testing.assert_allclose(
        [values[int(place)] for place in moved], expected, rtol=0, atol=1e-13
    )


def _computed(kind: str, numbers: list[float]) -> float:
    a, b = numbers[0], numbers[-1]
    values = {"+": a + b, "-": a - b, "*": a * b, "tan": float(np.tan(a))}
    return a / b if kind == "/" else values[kind]


def test_at_half_a_turn_the_tangent_has_no_end_and_does_no_harm() -> None:
    program = program_of(mq.textbook.load("cart_pole"))
    Y, out = np.array([[0.0, 0.0], [np.pi, -np.pi], [0.1, 0.1], [0.2, 0.2]]), np.empty((4, 2))
    vectorize(program)(0.0, Y, out)
    for column in (0, 1):
        np.testing.assert_allclose(
            out[:, column], scalar(program)(0.0, Y[:, column]), rtol=1e-14, atol=1e-14
        )


@pytest.mark.parametrize("n", [2, 3, 5])
def test_a_chain_needs_one_tangent_for_each_link(n: int) -> None:
    program = chain(n)
    found = kinds(*by_tangents(program.tape, program.rates))
    assert (found.count("tan"), found.count("sin"), found.count("cos")) == (n, 0, 0)


def test_a_lone_sine_stays_a_sine() -> None:
    program = program_of(mq.textbook.load("rigid_bar_pendulum"))
    found = kinds(*by_tangents(program.tape, program.rates))
    assert (found.count("tan"), found.count("sin")) == (0, 1)
