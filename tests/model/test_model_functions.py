"""Functions of letters, and what numpy's, math's and functions without a call are answered."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

import mecanique as mq
from mecanique.model.expression import FUNCTIONS, evaluate

Q = mq.coordinate("q")
# as letters in expressions are typed
L: Any = mq.Parameter("l", 2.0, "m")
F: Any = mq.Input("F", 0.0, "N")
VALUES = {"l": 2.0, "q": 0.3}
PUBLIC = [name for name in FUNCTIONS if name != "Abs"]


@pytest.mark.parametrize("name", [name for name in PUBLIC if name != "atan2"])
def test_functions_of_letters_are_those_of_numbers(name: str) -> None:
    function = getattr(mq, name)
    found = evaluate(function(L * Q / 2), VALUES)
    plain = {"sign": np.sign}.get(name) or getattr(math, name)
    assert found == pytest.approx(plain(0.3), rel=1e-15)
    assert float(function(0.3)) == pytest.approx(plain(0.3), rel=1e-15)


def test_angles_of_points_whole_numbers_and_sizes() -> None:
    assert evaluate(mq.atan2(-L, Q), VALUES) == pytest.approx(math.atan2(-2.0, 0.3), rel=1e-12)
    assert mq.atan2(-1.0, -1.0) == pytest.approx(-3 * math.pi / 4, rel=1e-12)
    assert str(mq.sqrt(2) * L) == "sqrt(2)*l"
    assert evaluate(abs(-L), VALUES) == 2.0
    assert evaluate(abs(L), VALUES) == 2.0
    assert evaluate(2**L, VALUES) == 4.0


def test_numbers_of_numpy_still_multiply_letters() -> None:
    for product in (np.float64(2.5) * L, L * np.float64(2.5), np.multiply(2.5, L)):
        assert evaluate(product, VALUES) == 5.0
    assert [evaluate(x, VALUES) for x in np.array([1.0, 2.0]) * L] == [2.0, 4.0]


@pytest.mark.parametrize(
    "ask", [lambda: np.sin(L), lambda: math.sin(L), lambda: np.sqrt(F), lambda: math.exp(F)]
)
def test_functions_of_numbers_say_which_take_letters(ask: Callable[[], Any]) -> None:
    with pytest.raises(TypeError, match=r"got the letter [lF]; .* e\.g\. mecanique\.sin\([lF]\)"):
        ask()


@pytest.mark.parametrize(
    "ask",
    [
        lambda: 2 * mq.time,
        lambda: mq.time * L,
        lambda: L * mq.time,
        lambda: (2 * L) * mq.time,
        lambda: np.cos(mq.time),
        lambda: math.cos(mq.time),
        lambda: mq.cos(mq.time),
        lambda: -mq.time,
        lambda: mq.time**2,
        lambda: mq.Input("F", mq.time, "N"),
        lambda: mq.Coordinates((), {"x": mq.time}),
    ],
)
def test_time_without_its_call_says_so(ask: Callable[[], Any]) -> None:
    with pytest.raises(mq.InputError, match=r"got the function time; call it: time\(\)"):
        ask()


def test_other_functions_without_their_call_say_so_too() -> None:
    with pytest.raises(mq.InputError, match=r"call it: coordinate\(…\)"):
        mq.Coordinates((), {"x": mq.coordinate})


def test_a_law_written_with_them_moves_a_mechanism() -> None:
    t = mq.time()
    slide = mq.Prismatic("slide", "ground", "block", coordinate="x")
    bodies = mq.Body("ground"), mq.Body("block", mq.box(1.0, (1, 1, 1)))
    force = mq.JointForce("push", "slide", mq.sin(2 * t) - mq.velocity("x"))
    mechanism = mq.Mechanism("pushed", bodies, (slide,), (force,), gravity=(0, 0, 0))
    assert mq.verify(mechanism, samples=5).agrees
    a = mq.Reference(mechanism).acceleration([0.0], [0.5], 0.3)
    assert a.item() == pytest.approx(math.sin(0.6) - 0.5, rel=1e-12)
