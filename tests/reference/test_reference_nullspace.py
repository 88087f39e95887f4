"""Motion on constraints, against closed forms."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from mecanique.errors import ClosureError
from mecanique.reference.loops.nullspace import (
    Metric,
    NaturalUnits,
    are_certain,
    measure,
    solve,
    split,
)

M, G, L = 2.0, 9.81, 1.3


def scale(
    mass: np.ndarray, jacobian: np.ndarray, rows: float = 1.0, columns: tuple[float, ...] = ()
) -> Metric:
    """The metric of a state whose rows are measured as one block."""
    m, n = jacobian.shape
    units = NaturalUnits(np.full(m, rows), np.array(columns or (1.0,) * n), np.zeros(m, dtype=int))
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
    np.testing.assert_allclose(motion.acceleration, expected, rtol=0, atol=1e-12)
    # the rod pulls inward with m g cos q + m l q'²
    np.testing.assert_allclose(
        motion.multipliers, [-M * (G * math.cos(angle) + L * rate**2)], rtol=0, atol=1e-11
    )
    assert motion.determined.all()


def test_a_doubled_row_changes_no_motion_and_leaves_its_forces_undetermined() -> None:
    h, jacobian, gamma, expected = pendulum(0.7, 0.9)
    twice = np.vstack([jacobian, 2 * jacobian])
    motion = solve(scale(M * np.eye(2), twice), h, twice, np.r_[gamma, 2 * gamma])
    np.testing.assert_allclose(motion.acceleration, expected, rtol=0, atol=1e-13)
    assert motion.rank == 1
    assert not motion.determined.any()


def test_units_of_rows_and_columns_do_not_change_the_answer() -> None:
    h, jacobian, gamma, expected = pendulum(0.7, 0.9)
    metric = scale(M * np.eye(2), jacobian, 1e3, (1e-2, 1e2))
    motion = solve(metric, h, jacobian, gamma)
    np.testing.assert_allclose(motion.acceleration, expected, rtol=1e-10, atol=0)


def test_a_mass_matrix_that_is_singular_off_the_constraint_is_fine() -> None:
    # the second coordinate is massless and tied to the first
    mass, tie = np.diag([3.0, 0.0]), np.array([[1.0, -1.0]])
    motion = solve(scale(mass, tie), np.array([6.0, 0.0]), tie, np.zeros(1))
    np.testing.assert_allclose(motion.acceleration, [-2.0, -2.0], rtol=0, atol=1e-14)
    np.testing.assert_allclose(motion.multipliers, [0.0], rtol=0, atol=1e-14)


def test_a_massless_free_direction_is_refused_by_its_coordinate() -> None:
    mass, tie = np.diag([3.0, 0.0]), np.array([[1.0, 0.0]])
    with pytest.raises(
        ClosureError, match=r"a free direction carries no mass \([+-]1\.00 at coordinate 1\)"
    ):
        solve(scale(mass, tie), np.zeros(2), tie, np.zeros(1))


def test_a_locked_system_stands_still_and_still_has_forces() -> None:
    tie = np.eye(2)
    motion = solve(scale(np.eye(2), tie), np.array([0.0, 9.81]), tie, np.zeros(2))
    np.testing.assert_allclose(motion.acceleration, 0.0, rtol=0, atol=1e-15)
    np.testing.assert_allclose(motion.multipliers, [0.0, 9.81], rtol=0, atol=1e-14)


@pytest.mark.parametrize(
    ("jacobian", "rank"), [(np.zeros((2, 3)), 0), (np.eye(3)[:2], 2), (np.zeros((0, 3)), 0)]
)
def test_split_counts_what_is_free(jacobian: np.ndarray, rank: int) -> None:
    parts = split(jacobian)
    assert parts.rank == rank
    assert parts.null.shape == (3, 3 - rank)
    np.testing.assert_allclose(jacobian @ parts.null, 0.0, rtol=0, atol=1e-15)


def test_redundant_rows_share_their_force_by_least_squares_in_plain_units() -> None:
    """The least Σ (λ_i / u_i)² with r·λ = f is λ_i = f r_i u_i² / Σ r_k² u_k²."""
    r, u = np.array([1.0, 2.0, -1.5]), np.array([1.0, 10.0, 0.3])
    mass, J = np.diag([2.0, 3.0]), np.outer(r, [1.0, 0.0])
    metric = measure(mass, J, NaturalUnits(u, np.ones(2), np.zeros(3, dtype=int)))
    motion = solve(metric, np.array([-7.0, -6.0]), J, 4 * r)
    np.testing.assert_allclose(motion.acceleration, [-4.0, 2.0], rtol=1e-12, atol=0)
    force = 2.0 * -4.0 - 7.0  # M a + h with a = −4
    expected = force * r * u**2 / np.sum(r**2 * u**2)
    np.testing.assert_allclose(motion.multipliers, expected, rtol=1e-12, atol=0)
    assert not motion.determined.any()


def test_a_hardly_closed_direction_keeps_its_velocity_if_asked_to() -> None:
    """Its row demands a = −γ / σ, which next to a singular position is mostly error."""
    J, gamma, h = np.diag([1.0, 1e-6]), np.array([3.0, 2e-3]), np.array([5.0, 7.0])
    metric = scale(np.eye(2), J)
    strict = solve(metric, h, J, gamma, most=2)
    np.testing.assert_allclose(strict.acceleration, [-3.0, -2e3], rtol=1e-9, atol=0)
    np.testing.assert_allclose(J.T @ strict.multipliers, strict.acceleration + h, rtol=1e-9, atol=0)
    kept = solve(metric, h, J, gamma, most=2, weak=1e-4)
    np.testing.assert_allclose(kept.acceleration, [-3.0, 0.0], rtol=0, atol=1e-14)
    np.testing.assert_allclose(kept.multipliers, [2.0, 0.0], rtol=0, atol=1e-14)
    assert kept.rank == 2
    # one rank less, and it is free instead
    free = solve(metric, h, J, gamma, most=1)
    np.testing.assert_allclose(free.acceleration, [-3.0, -7.0], rtol=1e-12, atol=0)
    # so it is if it is rounding, unless it is to keep its velocity
    rough = NaturalUnits(np.ones(2), np.ones(2), np.zeros(2, dtype=int), lambda: 1e-5)
    metric = measure(np.eye(2), J, rough)
    free = solve(metric, h, J, gamma)
    np.testing.assert_allclose(free.acceleration, [-3.0, -7.0], rtol=1e-12, atol=0)
    assert free.rank == 1
    kept = solve(metric, h, J, gamma, most=2, weak=1e-4)
    np.testing.assert_allclose(kept.acceleration, [-3.0, 0.0], rtol=0, atol=1e-14)
    assert kept.rank == 2


@pytest.mark.parametrize("by_root", [False, True])
@pytest.mark.parametrize(("least", "count"), [(2e-13, 2), (5e-14, 1), (0.0, 1)])
def test_principal_inertias_of_mere_rounding_are_none(
    least: float, count: int, by_root: bool
) -> None:
    """Two velocities, of inertias 9 and 400, that move one body against a mass of that part."""
    axes, weight = np.array([[1.0, 1.0], [1.0, -1.0]]) / np.sqrt(2), np.array([3.0, 20.0])
    root = np.sqrt([2 - least, least])[:, None] * axes * weight
    units = NaturalUnits(np.ones(0), np.ones(2), np.zeros(0, dtype=int))
    metric = measure(root.T @ root, np.zeros((0, 2)), units, (lambda: root) if by_root else None)
    assert sorted(metric.mass) == [0.0] * (2 - count) + [1.0] * count
    C = metric.columns
    np.testing.assert_allclose(C.T @ root.T @ root @ C, np.diag(metric.mass), rtol=0, atol=2e-2)
    np.testing.assert_allclose(metric.inverse @ C, np.eye(2), rtol=0, atol=1e-8)


def test_the_largest_components_of_a_massless_motion_are_named_in_plain_units() -> None:
    """Massless along (3, 4): the tie of the two is the only row."""
    tie = np.array([[4.0, -3.0]])
    units = NaturalUnits(np.ones(1), np.array([1.0, 2.0]), np.zeros(1, dtype=int))
    metric = measure(np.zeros((2, 2)), tie, units)
    with pytest.raises(ClosureError) as refusal:
        solve(metric, np.zeros(2), tie, np.zeros(1), names=["x", "y"])
    # in plain units (3, 4 / 2), of norm sqrt(13)
    assert "0.83 at x" in str(refusal.value)
    assert "0.55 at y" in str(refusal.value)


@pytest.mark.parametrize(
    ("bounds", "rank"),
    [
        ({}, 3),
        ({"tolerance": 4.9e-4}, 3),
        ({"tolerance": 5.1e-4}, 2),
        ({"least": 0.9e-3}, 3),
        ({"least": 1.1e-3}, 2),
        ({"most": 4}, 3),
        ({"most": 1}, 1),
        ({"fixed": 1}, 1),
        ({"tolerance": 0.9, "fixed": 3}, 3),
        ({"fixed": 9}, 3),
    ],
)
def test_singular_values_count_above_bounds_of_the_largest_and_of_their_number(
    bounds: dict[str, Any], rank: int
) -> None:
    parts = split(np.diag([0.5, 2.0, 1e-3]), **bounds)
    assert parts.rank == rank
    assert parts.singular.tolist() == [2.0, 0.5, 1e-3][:rank]
    assert parts.range_right.shape == parts.range_left.shape == (3, rank)
    np.testing.assert_array_equal(np.abs(parts.null), np.eye(3)[:, [1, 0, 2][rank:]])
    assert parts.determined.tolist() == [rank > 1, rank > 0, rank > 2]


def test_a_short_row_that_is_certain_counts_before_a_longer_one_of_rounding() -> None:
    """Axes 0, 1 and 2 by 1, 1e-5 and 1e-6, the second with an error of 2e-5."""
    rounding = np.array([1e-15, 2e-5, 1e-15])
    parts = split(np.diag([1.0, 1e-5, 1e-6]), rounding=lambda: rounding)
    assert parts.rank == 2
    np.testing.assert_allclose(parts.singular, [1.0, 1e-6], rtol=1e-12, atol=0)
    np.testing.assert_allclose(np.abs(parts.range_left), np.eye(3)[:, [0, 2]], rtol=0, atol=1e-15)
    np.testing.assert_allclose(np.abs(parts.range_right), np.eye(3)[:, [0, 2]], rtol=0, atol=1e-15)
    np.testing.assert_allclose(np.abs(parts.null), np.eye(3)[:, [1]], rtol=0, atol=1e-15)
    np.testing.assert_allclose(np.abs(parts.loose), np.eye(3)[:, [1]], rtol=0, atol=1e-15)
    assert parts.determined.tolist() == [True, False, True]
    assert split(np.diag([1.0, 1e-5, 1e-6]), rounding=lambda: rounding / 4).rank == 3


def test_the_rounding_of_a_combination_of_rows_is_that_of_its_parts() -> None:
    """0.6 and 0.8 of rows with errors of 1 and 2 have one of √(0.36 + 2.56) = 1.709."""
    left = np.array([[0.6, -0.8], [0.8, 0.6]])
    rounding = np.array([1.0, 2.0])
    assert are_certain(left, np.array([1.71, 1.45]), 0.0, rounding).tolist() == [True, True]
    assert are_certain(left, np.array([1.70, 1.43]), 0.0, rounding).tolist() == [False, False]
    assert are_certain(left, np.array([1.71, 1.45]), 1.5, rounding).tolist() == [True, False]
    assert are_certain(left, np.array([0.6, 0.4]), 0.0, 0.5).tolist() == [True, False]


def test_rounding_of_scaled_rows_is_that_of_the_entries_they_are_made_of() -> None:
    """Of velocities in their units; entries that are zero have none."""
    units = NaturalUnits(
        np.array([0.5, 4.0]), np.array([2.0, 10.0]), np.array([0, 1]), lambda: 1e-14
    )
    columns = np.array([[3.0, 0.0], [-4.0, 5.0]])
    metric = Metric(np.array([7.0, 2.0]), columns, np.linalg.inv(columns), np.ones(2), units)
    found = metric.rounding(np.array([[1e-3, 0.0], [1.0, -2.0]]))
    first = 7.0 / 0.5 * 3.0 / 2.0
    second = 2.0 / 4.0 * np.hypot(3.0 / 2.0 + 4.0 / 10.0, 5.0 / 10.0)
    np.testing.assert_allclose(found, [1e-14 * first, 1e-14 * second], rtol=1e-14, atol=0)
