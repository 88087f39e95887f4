"""Slips in descriptions: the wrong value is what the words say, and each is listed once."""

from __future__ import annotations

import re

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from mecanique.model.slips import (
    ABOUT_CENTER,
    ABOUT_ORIGIN,
    ANGLE,
    DIGITS,
    INERTIA,
    LENGTH,
    MASS,
    Slip,
    lever_of,
    list_once,
    mistake_axes,
    mistake_point,
    mistake_products,
    mistake_turn,
    mistake_vector,
    say_factor,
)

VECTOR = np.array([1.0, -2.0, 3.5])
TENSOR = np.array([[3.0, 0.1, -0.2], [0.1, 4.0, 0.3], [-0.2, 0.3, 5.0]])
RPY = np.array([0.3, -0.7, 1.1])


def listed(text: str, pattern: str) -> list[str]:
    """Return the names in a part of the words; none if they say something else."""
    found = re.fullmatch(pattern, text)
    return found[1].split(", ") if found else []


def test_a_vector_is_mirrored_or_its_axes_are_exchanged() -> None:
    slips = list(mistake_vector("axis", VECTOR))
    assert len(slips) == 7 + 5
    for slip in slips:
        assert slip.kind == "axis"
        mirrored = listed(slip.text, r"mirrored \((.*) with the other sign\)")
        signs = [-1 if name in mirrored else 1 for name in "xyz"]
        order = listed(slip.text, r"axes exchanged \((.*)\)") or list("xyz")
        wanted = (VECTOR * signs)[["xyz".index(name) for name in order]]
        np.testing.assert_array_equal(slip.value, wanted)
    # along an axis: mirrored, or along one of the others
    alone = [slip.text for slip in mistake_vector("axis", np.array([0.0, 0.0, 2.0]))]
    assert alone == [
        "mirrored (z with the other sign)",
        "axes exchanged (x, z, y)",
        "axes exchanged (z, x, y)",
    ]
    assert list(mistake_vector("axis", np.zeros(3))) == []


def test_an_inertia_is_about_another_point() -> None:
    """Steiner: m (c·c 1 − c cᵀ) more, or less."""
    lever = lever_of(2.0, VECTOR)
    x, y, z = VECTOR
    np.testing.assert_allclose(
        lever,
        2
        * np.array(
            [
                [y * y + z * z, -x * y, -x * z],
                [-x * y, x * x + z * z, -y * z],
                [-x * z, -y * z, x * x + y * y],
            ]
        ),
        rtol=0,
        atol=1e-14,
    )
    missing, twice = mistake_point(2.0, VECTOR, TENSOR)
    assert (missing.text, twice.text) == (ABOUT_CENTER, ABOUT_ORIGIN)
    np.testing.assert_array_equal(missing.value, TENSOR - lever)
    np.testing.assert_array_equal(twice.value, TENSOR + lever)
    assert list(mistake_point(2.0, np.zeros(3), TENSOR)) == []


def test_products_of_inertia_have_the_other_sign_or_are_left_out() -> None:
    every, *single, none = mistake_products(TENSOR)
    diagonal = np.diag(np.diag(TENSOR))
    np.testing.assert_allclose(every.value, 2 * diagonal - TENSOR, rtol=0, atol=1e-15)
    np.testing.assert_array_equal(none.value, diagonal)
    assert none.text == "products of inertia left out"
    for slip, (i, k) in zip(single, ((0, 1), (0, 2), (1, 2)), strict=True):
        assert slip.text == f"product of inertia i{'xyz'[i]}{'xyz'[k]} with the other sign"
        wanted = TENSOR.copy()
        wanted[i, k] = wanted[k, i] = -TENSOR[i, k]
        np.testing.assert_array_equal(slip.value, wanted)
    # of a single product, its sign is that of all
    planar = np.diag([3.0, 4.0, 5.0])
    planar[0, 2] = planar[2, 0] = 0.4
    assert [slip.text for slip in mistake_products(planar)] == [every.text, none.text]
    assert list(mistake_products(np.diag([1.0, 2.0, 3.0]))) == []


def test_a_tensor_is_in_other_axes() -> None:
    slips = list(mistake_axes(TENSOR))
    assert len(slips) == 24 - 1
    for slip in slips:
        mirrored = listed(slip.text, r"mirrored \((.*) with the other sign\)")
        names = listed(slip.text, r"axes exchanged \((.*)\)") or list("xyz")
        order = ["xyz".index(name[-1]) for name in names]
        signs = np.array(
            [-1 if "−" in name or name in mirrored else 1 for name in names], dtype=float
        )
        wanted = TENSOR[np.ix_(order, order)] * np.outer(signs, signs)
        np.testing.assert_allclose(slip.value, wanted, rtol=0, atol=1e-15)
    assert len(list(mistake_axes(np.diag([1.0, 2.0, 3.0])))) == 5
    assert len(list(mistake_axes(np.diag([1.0, 1.0, 3.0])))) == 2
    assert list(mistake_axes(np.eye(3))) == []


def test_an_orientation_is_read_otherwise() -> None:
    slips = list(mistake_turn(RPY))
    right = Rotation.from_euler("xyz", RPY).as_matrix()
    about = {name: Rotation.from_euler(name, angle) for name, angle in zip("xyz", RPY, strict=True)}
    for slip in slips:
        moving = listed(slip.text, r"turned about moving axes (.*) instead of fixed ones")
        order = listed(slip.text, r"rpy in the order (.*)")
        signs = listed(slip.text, r"(.*) with the other sign")
        if moving:
            wanted = about[moving[0]] * about[moving[1]] * about[moving[2]]
        elif order:
            wanted = Rotation.from_euler("xyz", RPY[["rpy".index(name) for name in order]])
        elif signs:
            flipped = [-1 if name in signs else 1 for name in ("roll", "pitch", "yaw")]
            wanted = Rotation.from_euler("xyz", RPY * flipped)
        else:
            wanted = {
                "turned back": Rotation.from_matrix(right).inv(),
                "left out": Rotation.identity(),
                "degrees for radians": Rotation.from_euler("xyz", np.degrees(RPY)),
                "radians for degrees": Rotation.from_euler("xyz", np.radians(RPY)),
            }[slip.text]
        np.testing.assert_allclose(slip.value, wanted.as_matrix(), rtol=0, atol=1e-13)
    texts = [slip.text for slip in slips]
    # z, y, x about moving axes is the right reading itself
    assert sum("moving" in text for text in texts) == 5
    assert sum("order" in text for text in texts) == 5
    assert sum("other sign" in text for text in texts) == 7
    assert len(texts) == len(set(texts)) == 3 + 5 + 5 + 7 + 1


def test_values_that_differ_by_less_than_the_tolerance_are_listed_once() -> None:
    right = np.zeros(2)
    candidates = [
        ("right", np.array([0.0, -1e-3])),
        ("first", np.array([0.0, -2e-3])),
        ("again", np.array([1e-3, -2e-3])),
        ("other", np.array([2e-3, -2e-3])),
    ]
    found = list(list_once("kind", candidates, right, 1e-3))
    assert [(slip.kind, slip.text) for slip in found] == [("kind", "first"), ("kind", "other")]
    assert isinstance(found[0], Slip)


@pytest.mark.parametrize(
    ("factor", "said"),
    [
        *((10.0, "×10"), (0.1, "÷10"), (1000.0, "×1000"), (1e-3, "÷1000")),
        *((1e4, "×10⁴"), (1e-4, "÷10⁴"), (1e6, "×10⁶"), (1e-9, "÷10⁹"), (25.4, "×25.4")),
    ],
)
def test_factors_are_said_by_what_they_do(factor: float, said: str) -> None:
    assert say_factor(factor) == said


SIZES = {
    "kilograms": 1.0,
    "grams": 1e-3,
    "pounds": 0.45359237,
    "meters": 1.0,
    "centimeters": 1e-2,
    "millimeters": 1e-3,
    "inches": 0.0254,
    "kg·m²": 1.0,
    "kg·mm²": 1e-6,
    "g·mm²": 1e-9,
    "radians": 1.0,
    "degrees": np.pi / 180,
}
"""SI units in a unit."""


def test_a_number_in_another_unit_is_as_many_times_larger_as_the_unit_is_smaller() -> None:
    for factor in (*MASS, *LENGTH, *INERTIA, *ANGLE):
        given, wanted = factor.text.split(" for ")
        assert factor.factor == pytest.approx(SIZES[wanted] / SIZES[given], rel=1e-15)


def test_a_decimal_point_is_moved_by_one_or_two_digits() -> None:
    said = {f"a decimal point ({say_factor(each)})": each for each in (10, 0.1, 100, 0.01)}
    assert {each.text: each.factor for each in DIGITS} == said
