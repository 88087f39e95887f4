"""Quaternions and rotation matrices, beside SciPy's."""

from __future__ import annotations

import numpy as np
from scipy.spatial.transform import Rotation

from mecanique.model.quaternions import from_matrices, to_matrices, turn


def some_turns() -> Rotation:
    """Random turns, and turns by π, where three of four ways to a quaternion divide by zero."""
    axes = np.vstack([np.eye(3), -np.eye(3), [[0.6, 0.8, 0.0]]])
    half = Rotation.from_rotvec(np.pi * axes)
    around = Rotation.random(200, rng=np.random.default_rng(0))
    return Rotation.concatenate([around, half, Rotation.identity(1)])


def test_matrices_of_quaternions_are_scipys() -> None:
    turns = some_turns()
    np.testing.assert_allclose(to_matrices(turns.as_quat()), turns.as_matrix(), rtol=0, atol=1e-14)


def test_quaternions_of_matrices_turn_alike_and_have_scipys_signs() -> None:
    matrices = some_turns().as_matrix()
    found = from_matrices(matrices)
    np.testing.assert_allclose(to_matrices(found), matrices, rtol=0, atol=1e-14)
    np.testing.assert_allclose(
        found[:200], Rotation.from_matrix(matrices[:200]).as_quat(), rtol=0, atol=1e-14
    )


def test_axes_of_any_shape_are_kept() -> None:
    matrices = some_turns().as_matrix()[:6].reshape(2, 3, 3, 3)
    found = from_matrices(matrices)
    assert found.shape == (2, 3, 4)
    np.testing.assert_allclose(
        turn(found, np.array([1.0, 2.0, 3.0])), matrices @ [1.0, 2.0, 3.0], rtol=0, atol=2e-14
    )


def test_vectors_may_take_a_complex_step() -> None:
    """The derivative of a turned vector along another is that other, turned."""
    q = some_turns().as_quat()[:5]
    vector, along = np.random.default_rng(1).normal(size=(2, 3))
    stepped = turn(q, vector + 1e-20j * along).imag / 1e-20
    np.testing.assert_allclose(stepped, turn(q, along), rtol=0, atol=1e-14)
