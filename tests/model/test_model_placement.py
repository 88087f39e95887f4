"""Turns by roll, pitch and yaw, and inertia tensors by their six entries."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import example, given
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from mecanique.errors import InputError
from mecanique.model import Placement, Sphere, Visual, coordinate
from mecanique.model.bodies.tensor import entries_of, tensor_of
from mecanique.model.expression import evaluate
from mecanique.model.placement import (
    pose_along,
    pose_of,
    rpy_along,
    rpy_of,
    rpy_rotation,
    turn_about,
    unit_vector,
)


@given(st.tuples(*[st.floats(-3.1, 3.1)] * 3))
@example((0.3, math.pi / 2, 0.7))
@example((0.3, -math.pi / 2, 0.7))
@example((0.3, math.pi / 2 - 5e-12, 0.7))
@example((0.3, 5e-10 - math.pi / 2, 0.7))
def test_the_angles_of_a_rotation_give_it_again(rpy: tuple[float, float, float]) -> None:
    turn = np.array(rpy_rotation(rpy), dtype=float)
    again = np.array(rpy_rotation(rpy_of(turn)), dtype=float)
    np.testing.assert_allclose(again, turn, rtol=0, atol=1e-14)


@pytest.mark.parametrize("quarters", range(-6, 7))
def test_quarter_turns_are_exact_and_what_is_beside_them_is_not(quarters: int) -> None:
    cosine, sine = ((1, 0), (0, 1), (-1, 0), (0, -1))[quarters % 4]
    turn = Placement(rpy=(0.0, 0.0, quarters * math.pi / 2)).rotation
    assert turn == ((cosine, -sine, 0), (sine, cosine, 0), (0, 0, 1))
    many = math.nextafter((quarters + 60) * math.pi / 2, math.inf)  # the same up to rounding
    assert Placement(rpy=(0.0, 0.0, many)).rotation == turn
    beside = quarters * math.pi / 2 + 1e-13
    (first, _, _), (second, _, _), _ = Placement(rpy=(0.0, 0.0, beside)).rotation
    assert (first, second) == (math.cos(beside), math.sin(beside))


def test_a_frame_along_an_axis_has_its_z_there() -> None:
    for axis in ((0, 0, 1), (0, 0, -1), (1, 0, 0), (0.6, 0, 0.8), (-0.48, -0.6, 0.64)):
        roll, pitch, yaw = rpy_along(axis)
        turn = np.array(rpy_rotation((roll, pitch, yaw)), dtype=float)
        np.testing.assert_allclose(turn[:, 2], axis, rtol=0, atol=1e-15)
        assert roll == 0


def test_turns_and_places_in_a_row_are_those_of_their_matrices() -> None:
    """A shape's visual moves along with it, in numbers and in letters."""
    random = np.random.default_rng(3)
    for a, b, c, d, e, f in random.uniform(-3, 3, (5, 6)).tolist():
        visual, place = (
            Visual(Sphere(1.0), Placement((c, a, f), (e, b, -d))),
            ((a, b, c), (d, e, f)),
        )
        wanted = pose_of(Placement(*place)) @ pose_of(visual.placement)
        moved = visual.at(Placement(*place)).placement
        np.testing.assert_allclose(pose_of(moved), wanted, rtol=0, atol=1e-13)
        symbols = [[coordinate(name) for name in part] for part in ("abc", "def")]
        (x, y, z), (roll, pitch, yaw) = symbols
        moved = visual.at(Placement((x, y, z), (roll, pitch, yaw))).placement
        values = dict(zip("abcdef", (a, b, c, d, e, f), strict=True))
        x, y, z, roll, pitch, yaw = (evaluate(s, values) for s in (*moved.xyz, *moved.rpy))
        numbers = Placement((x, y, z), (roll, pitch, yaw))
        np.testing.assert_allclose(pose_of(numbers), wanted, rtol=0, atol=1e-13)


@pytest.mark.parametrize("length", [1e-11, 1.0, 1e200])
def test_a_vector_of_any_length_has_a_direction(length: float) -> None:
    given = (2 * length, -1 * length, 2 * length)
    np.testing.assert_allclose(unit_vector(given, "it"), (2 / 3, -1 / 3, 2 / 3), rtol=0, atol=1e-15)


@pytest.mark.parametrize(
    "given", [(0, 0, 0), (1e-13, 0, -1e-13), (math.inf, 0, 0), (math.nan, 0, 1)]
)
def test_a_vector_without_length_has_none(given: tuple[float, float, float]) -> None:
    with pytest.raises(InputError, match="expected a finite vector with a length for it, got"):
        unit_vector(given, "it")


def test_an_inertia_tensor_has_its_entries_in_the_order_of_urdf() -> None:
    tensor = tensor_of((1, 2, 3, 4, 5, 6))
    np.testing.assert_array_equal(tensor, [[1, 4, 5], [4, 2, 6], [5, 6, 3]])
    assert entries_of(tensor) == (1, 2, 3, 4, 5, 6)


@pytest.mark.parametrize("angle", [-2.3, 0.4, 3.0])
def test_a_turn_about_an_axis_of_any_length_is_that_of_rodrigues(angle: float) -> None:
    axis = np.array([0.3, -1.2, 0.7])
    unit = axis / np.linalg.norm(axis)
    expected = Rotation.from_rotvec(angle * unit).as_matrix()
    np.testing.assert_allclose(turn_about(axis, angle), expected, rtol=0, atol=1e-15)
    turned, shifted = (pose_along(unit, angle, turns) for turns in (True, False))
    np.testing.assert_allclose(turned[:3, :3], expected, rtol=0, atol=1e-15)
    np.testing.assert_array_equal(turned[:, 3], [0, 0, 0, 1])
    np.testing.assert_array_equal(shifted[:3], np.column_stack([np.eye(3), angle * unit]))
