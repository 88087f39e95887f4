"""Equations in which the condition of rolling was put into T, as SymPy's documentation had it."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from mecanique import InputError, textbook, verify
from mecanique.model.mechanism.origin import Finding, Origin
from mecanique.verification.foreign import Functions

BY = ("yaw", "lean", "spin")
COIN = textbook.load("rolling_coin")
m, r, g = (COIN.values[name] for name in "mrg")


def mass_matrix(q: np.ndarray) -> np.ndarray:
    """Of yaw, lean and spin, with the velocity of the center by rolling."""
    sine, cosine = np.sin(q[4]), np.cos(q[4])
    both = 3 / 2 * sine
    return (
        m
        * r**2
        * np.array([[1.5 * sine**2 + cosine**2 / 4, 0, both], [0, 5 / 4, 0], [both, 0, 3 / 2]])
    )


def substituted(q: np.ndarray, v: np.ndarray) -> np.ndarray:
    """Lagrange's operator on T with rolling in it: SymPy's tutorial (issue 27631), wrong."""
    sine, cosine = np.sin(q[4]), np.cos(q[4])
    w, k, n = v[3:]
    bend = 5 / 4 * sine * cosine  # ∂M_yaw,yaw/∂lean/2
    return (
        m
        * r**2
        * np.array(
            [
                2 * bend * w * k + 1.5 * cosine * k * n,
                -bend * w * w - 1.5 * cosine * w * n - g / r * sine,
                1.5 * cosine * k * w,
            ]
        )
    )


def right(q: np.ndarray, v: np.ndarray) -> np.ndarray:
    """By Euler's equations (Neimark & Fufaev, 1972, ch. II)."""
    sine, cosine, tangent = np.sin(q[4]), np.cos(q[4]), np.tan(q[4])
    w, k, n = v[3:]
    accelerations = [
        -2 * k * n / cosine,
        4 * g * sine / (5 * r) + sine * cosine * w * w + 6 * cosine * w * n / 5,
        -(5 * cosine * w - 6 * tangent * n) * k / 3,
    ]
    bias: np.ndarray = -mass_matrix(q) @ accelerations
    return bias


def functions(bias: Callable[..., Any]) -> Functions:
    return Functions(mass_matrix=mass_matrix, bias=bias, by=BY)


def test_the_right_equations_agree() -> None:
    assert verify(COIN, 10, against=functions(right)).agrees


def test_a_constraint_put_into_T_is_named_first() -> None:
    verdict = verify(COIN, 10, against=functions(substituted))
    assert not verdict.agrees
    rows = {row.quantity: row for row in verdict.rows}
    assert rows["mass matrix"].agrees
    assert not rows["bias"].agrees
    assert verdict.causes[0].kind == "constraint put into T"
    assert "was put into T before Lagrange's operator" in str(verdict)


def test_another_mistake_is_not_blamed_on_it() -> None:
    verdict = verify(COIN, 10, against=functions(lambda q, v: 1.01 * right(q, v)))
    assert not verdict.agrees
    assert verdict.causes == ()


def test_flaws_of_the_file_are_listed_whatever_its_equations_are_compared_with() -> None:
    flaw = Finding("M204", "error", "coin.urdf", 4, "link 'coin'", "no body has it", "", "Measure.")
    flawed = replace(COIN, origin=Origin("coin.urdf", b"", (flaw,)))
    verdict = verify(flawed, 10, against=functions(right))
    assert verdict.flaws == (flaw,)
    assert "flaw in line 4: link 'coin': no body has it. Measure." in str(verdict)


def test_velocities_that_do_not_suffice_are_refused() -> None:
    few = Functions(bias=lambda q, v: np.zeros(2), by=("yaw", "lean"))
    with pytest.raises(InputError, match="the velocities yaw', lean' do not determine the others"):
        verify(COIN, 5, against=few)
    with pytest.raises(InputError, match="joint 'roll' turns by a quaternion"):
        verify(textbook.load("ball_in_a_bowl"), 5, against=few)
    with pytest.raises(InputError, match="has no contacts or velocity constraints"):
        verify(textbook.load("cart_pole"), 5, against=few)
