"""Motion on constraints, against closed forms."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from mecanique.errors import ClosureError
from mecanique.reference.loops.metric import Metric, Units, measure
from mecanique.reference.loops.nullspace import solve, split

M, G, L = 2.0, 9.81, 1.3


def scale(
    mass: np.ndarray, jacobian: np.ndarray, rows: float = 1.0, columns: tuple[float, ...] = ()
) -> Metric:
    """The metric of a state whose rows are measured as one block."""
    m, n = jacobian.shape
    units = Units(np.full(m, rows), np.array(columns or (1.0,) * n), np.zeros(m, dtype=int))
    return measure(mass, jacobian, units)


def pendulum(angle: float, rate: float) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """A particle on a rod in the plane, by x and z: h, J, γ and the acceleration it must have."""
    radial = np.array([math.sin(angle), -math.cos(angle)])
    tangent = np.array([math.cos(angle), math.sin(angle)])
    expected = -G * math.sin(angle) * tangent - rate**2 * L * radial
    return np.array([0.0, M * G]), radial[None, :], np.array([rate**2 * L]), expected


@settings(deadline=None)
@given(st.floats(-3, 3), st.floats(-5, 5))
def test_particle_on_a_rod_accelerates_as_the_pendulum_does(angle: float, rate: float) -> None:
    h, jacobian, gamma, expected = pendulum(angle, rate)
    motion = solve(scale(M * np.eye(2), jacobian), h, jacobian, gamma)
    np.testing.assert_allclose(motion.acceleration, expected, atol=1e-12)
    # the rod pulls inward with m g cos q + m l q'²
    np.testing.assert_allclose(
        motion.multipliers, [-M * (G * math.cos(angle) + L * rate**2)], atol=1e-11
    )
    assert motion.determined.all()


def test_a_doubled_row_changes_no_motion_and_leaves_its_forces_undetermined() -> None:
    h, jacobian, gamma, expected = pendulum(0.7, 0.9)
    twice = np.vstack([jacobian, 2 * jacobian])
    motion = solve(scale(M * np.eye(2), twice), h, twice, np.r_[gamma, 2 * gamma])
    np.testing.assert_allclose(motion.acceleration, expected, atol=1e-12)
    assert motion.rank == 1
    assert not motion.determined.any()


def test_units_of_rows_and_columns_do_not_change_the_answer() -> None:
    h, jacobian, gamma, expected = pendulum(0.7, 0.9)
    metric = scale(M * np.eye(2), jacobian, 1e3, (1e-2, 1e2))
    motion = solve(metric, h, jacobian, gamma)
    np.testing.assert_allclose(motion.acceleration, expected, rtol=1e-10)


def test_a_mass_matrix_that_is_singular_off_the_constraint_is_fine() -> None:
    # the second coordinate is massless and tied to the first
    mass, tie = np.diag([3.0, 0.0]), np.array([[1.0, -1.0]])
    motion = solve(scale(mass, tie), np.array([6.0, 0.0]), tie, np.zeros(1))
    np.testing.assert_allclose(motion.acceleration, [-2.0, -2.0], atol=1e-14)
    np.testing.assert_allclose(motion.multipliers, [0.0], atol=1e-14)


def test_a_massless_free_direction_is_refused_by_its_coordinate() -> None:
    mass, tie = np.diag([3.0, 0.0]), np.array([[1.0, 0.0]])
    with pytest.raises(
        ClosureError, match=r"a free direction carries no mass \([+-]1\.00 at coordinate 1\)"
    ):
        solve(scale(mass, tie), np.zeros(2), tie, np.zeros(1))


def test_a_locked_system_stands_still_and_still_has_forces() -> None:
    tie = np.eye(2)
    motion = solve(scale(np.eye(2), tie), np.array([0.0, 9.81]), tie, np.zeros(2))
    np.testing.assert_allclose(motion.acceleration, 0.0, atol=1e-15)
    np.testing.assert_allclose(motion.multipliers, [0.0, 9.81], atol=1e-14)


@pytest.mark.parametrize(
    ("jacobian", "rank"), [(np.zeros((2, 3)), 0), (np.eye(3)[:2], 2), (np.zeros((0, 3)), 0)]
)
def test_split_counts_what_is_free(jacobian: np.ndarray, rank: int) -> None:
    parts = split(jacobian)
    assert parts.rank == rank
    assert parts.null.shape == (3, 3 - rank)
    np.testing.assert_allclose(jacobian @ parts.null, 0.0, atol=1e-15)
