"""Turns by roll, pitch and yaw, and inertia tensors by their six entries."""

from __future__ import annotations

import math

import numpy as np
from hypothesis import example, given
from hypothesis import strategies as st

from mecanique.model.bodies.tensor import entries_of, tensor_of
from mecanique.model.placement import rpy_of, rpy_rotation


@given(st.tuples(*[st.floats(-3.1, 3.1)] * 3))
@example((0.3, math.pi / 2, 0.7))
@example((0.3, -math.pi / 2, 0.7))
@example((0.3, math.pi / 2 - 5e-12, 0.7))
@example((0.3, 5e-10 - math.pi / 2, 0.7))
def test_the_angles_of_a_rotation_give_it_again(rpy: tuple[float, float, float]) -> None:
    turn = np.array(rpy_rotation(rpy), dtype=float)
    again = np.array(rpy_rotation(rpy_of(turn)), dtype=float)
    np.testing.assert_allclose(again, turn, rtol=0, atol=1e-14)


def test_an_inertia_tensor_has_its_entries_in_the_order_of_urdf() -> None:
    tensor = tensor_of((1, 2, 3, 4, 5, 6))
    np.testing.assert_array_equal(tensor, [[1, 4, 5], [4, 2, 6], [5, 6, 3]])
    assert entries_of(tensor) == (1, 2, 3, 4, 5, 6)
