"""Trees held by constraints, M a − rest = Jᵀ λ and J a + γ = 0: identities and closed forms."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

import mecanique as mq
from mecanique.derivation.numeric.constraints.independent import _choose, _regularity, _turn
from mecanique.derivation.numeric.constraints.multipliers import (
    HeldMotion,
    _energy_units,
    _has_definite,
    is_locked,
    solve_held,
)
from mecanique.derivation.numeric.constraints.rows import Constraints, RowUnits
from mecanique.derivation.scalars.jets import Jet
from mecanique.model.states import States


def rows(units: list[float], blocks: list[int] | None = None) -> RowUnits:
    return RowUnits(np.array(units), np.array(blocks or [0] * len(units)))


def solved(
    M: np.ndarray, rest: np.ndarray, J: np.ndarray, gamma: np.ndarray, units: RowUnits
) -> HeldMotion:
    return solve_held(M, rest, J, gamma, np.ones(len(M)), units)


@pytest.mark.parametrize("size", [1e-6, 1.0, 1e6])
@pytest.mark.parametrize("seed", range(3))
def test_both_equations_hold_for_blocks_of_any_size(size: float, seed: int) -> None:
    random = np.random.default_rng(seed)
    A, J = random.normal(size=(7, 5)), random.normal(size=(3, 5))
    M, rest, gamma = A.T @ A, random.normal(size=5), random.normal(size=3)
    D = np.array([1.0, size, size, 1.0, 1.0])
    M, rest, J = D[:, None] * M * D, D * rest, J * D
    J[2] *= size
    gamma[2] *= size
    motion = solved(M, rest, J, gamma, rows([1.0, 1.0, 1.0], [0, 0, 1]))
    np.testing.assert_allclose(J[:2] @ motion.acceleration, -gamma[:2], rtol=1e-9, atol=0)
    np.testing.assert_allclose(J[2] @ motion.acceleration, -gamma[2], rtol=1e-9, atol=0)
    force = M @ motion.acceleration - rest
    np.testing.assert_allclose(force / D, J.T @ motion.multipliers / D, rtol=1e-8, atol=1e-8)
    assert motion.determined.all()
    assert motion.massless is None


def test_redundant_rows_share_their_force_by_least_squares_in_plain_units() -> None:
    """The least Σ (λ_i u_i)² with r·λ = f is λ_i = f r_i / u_i² / Σ r_k² / u_k²."""
    r, u = np.array([1.0, 2.0, -1.5]), np.array([1.0, 10.0, 0.3])
    J = np.outer(r, [1.0, 0.0])
    motion = solved(np.diag([2.0, 3.0]), np.array([7.0, 6.0]), J, 4 * r, rows([*u]))
    force = 2.0 * -4.0 - 7.0  # M a − rest with a = −4
    np.testing.assert_allclose(motion.acceleration, [-4.0, 2.0], rtol=1e-12, atol=0)
    expected = force * (r / u**2) / np.sum(r**2 / u**2)
    np.testing.assert_allclose(motion.multipliers, expected, rtol=1e-12, atol=0)
    assert not motion.determined.any()


def test_a_row_that_says_the_same_as_another_leaves_a_third_determined() -> None:
    J = np.array([[1.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]])
    motion = solved(np.eye(3), np.array([1.0, 2.0, 3.0]), J, np.zeros(3), rows([1.0] * 3))
    np.testing.assert_allclose(motion.acceleration, [0.0, 0.0, 3.0], rtol=0, atol=1e-14)
    np.testing.assert_allclose(motion.multipliers, [-0.5, -0.5, -2.0], rtol=1e-12, atol=0)
    assert motion.determined.tolist() == [False, False, True]


def test_a_free_motion_without_inertia_is_named() -> None:
    motion = solved(
        np.diag([3.0, 0.0]), np.zeros(2), np.array([[1.0, 0.0]]), np.zeros(1), rows([1])
    )
    assert motion.massless is not None
    np.testing.assert_allclose(np.abs(motion.massless), [0.0, 1.0], rtol=0, atol=1e-14)


def test_a_massless_velocity_tied_to_a_heavy_one_moves_with_it() -> None:
    tie = np.array([[1.0, -2.0]])
    motion = solved(np.diag([3.0, 0.0]), np.array([6.0, 0.0]), tie, np.zeros(1), rows([1.0]))
    np.testing.assert_allclose(motion.acceleration, [2.0, 1.0], rtol=1e-12, atol=0)
    np.testing.assert_allclose(motion.multipliers, [0.0], rtol=0, atol=1e-14)
    assert motion.massless is None


def test_units_carry_half_a_unit_of_energy_each() -> None:
    units = _energy_units(np.diag([4.0, 25.0]), np.zeros((0, 2)), np.array([1.0, 10.0]))
    np.testing.assert_allclose(units, [0.5, 0.2], rtol=1e-15, atol=0)


def test_a_massless_velocity_is_measured_by_the_lightest_one_its_loops_tie_it_to() -> None:
    M = np.diag([0.0, 9.0, 4.0, 1.0, 0.0])
    J = np.array([[1.0, 1.0, 0.0, 0.0, 0.0], [-1.0, 0.0, 1.0, 0.0, 0.0]])
    plain = np.array([6.0, 1.0, 1.0, 1.0, 5.0])
    # the first meets inertias 9 and 4; the last meets none, so that the lightest of all stands in
    units = _energy_units(M, J, plain)
    np.testing.assert_allclose(units, [6 / 2, 1 / 3, 1 / 2, 1.0, 5.0], rtol=1e-15, atol=0)
    np.testing.assert_allclose(
        _energy_units(np.zeros((1, 1)), J[:, :1], np.ones(1)), [1.0], rtol=1e-14, atol=0
    )


@pytest.mark.parametrize(("apart", "independent"), [(1e-3, True), (1e-6, False)])
def test_rows_that_differ_by_rounding_are_one(apart: float, independent: bool) -> None:
    """A direction that differs by δ is met with the part δ² of what inertia and rows have."""
    J = np.array([[1.0, 0.0], [1.0, apart]])
    motion = solved(np.eye(2), np.array([1.0, 2.0]), J, np.zeros(2), rows([1.0, 1.0]))
    assert motion.determined.all() == independent
    assert motion.acceleration[1] == pytest.approx(0.0 if independent else 2.0, abs=1e-6)


@pytest.mark.parametrize(
    ("forms", "definite"),
    [
        ([[[1.0, 0], [0, -1]]], False),
        ([[[1.0, 0], [0, 0]]], False),
        ([[[-2.0, 0], [0, -1]]], True),
        ([[[1.0, 0], [0, -1]], [[-1.0, 0], [0, 2]]], True),
        ([[[1.0, 0], [0, -1]], [[0.0, 1], [1, 0]]], False),
        ([[[1.0, 0], [0, 2e-6]]], True),
        ([[[1.0, 0], [0, 0.5e-6]]], False),
    ],
)
def test_a_combination_of_forms_is_definite_or_none_is(
    forms: list[list[list[float]]], definite: bool
) -> None:
    assert _has_definite(np.array(forms, dtype=float)) == definite


POINT = mq.Mechanism(
    "point",
    (mq.Body("ground"), mq.Body("slider"), mq.Body("point", mq.particle(1.0))),
    (
        mq.Prismatic("along", "ground", "slider", axis=(1, 0, 0), coordinate="x"),
        mq.Prismatic("across", "slider", "point", axis=(0, 1, 0), coordinate="y"),
    ),
)


@pytest.mark.parametrize(
    ("slopes", "curves", "locked"),
    [
        ([[0, 0]], [[1, 1]], True),  # x² + y² = 0
        ([[0, 0]], [[1, -1]], False),  # x² = y² along its diagonals
        ([[0, 0], [0, 0]], [[1, -1], [-1, 2]], True),
        ([[1, 0], [1, 0]], [[0, 0], [0, 1]], True),  # x = 0 and x + y² = 0
        ([[1, 0], [1, 0]], [[0, 1], [0, 1]], False),  # the same parabola twice
        ([[1, 0], [0, 2]], [[0, 1], [0, 1]], False),  # no motion at all, but a regular position
        ([[1, 0]], [[0, 1]], False),
    ],
)
@pytest.mark.parametrize("driven", [0.0, 3.0])
def test_loops_of_second_order_lock_a_point(
    slopes: list[list[float]], curves: list[list[float]], locked: bool, driven: float
) -> None:
    """Φ = J (x, y) + a x² + b y², beside parts of γ that prescribed motions have."""

    def at(states: States) -> Constraints:
        n, m = len(states), len(slopes)
        bent = 2 * states.v**2 @ np.array(curves, dtype=float).T + driven * (1 + states.v[:, :1])
        return Constraints(
            np.zeros((n, m)), np.tile(np.array(slopes, float), (n, 1, 1)), bent, bent, []
        )

    state = States.of(POINT, np.zeros((1, 2)), np.zeros((1, 2)))
    assert is_locked(state, at) == locked


def test_a_gibbs_vector_turns_by_twice_the_angle_of_its_half() -> None:
    """g = 2 tan(θ/2) n turns by θ about n, after the state's own rotation (Shuster, eq. 337)."""
    p, n, angle = Rotation.random(random_state=2), np.array([2, -1, 2]) / 3, 1.1
    place, step = np.array([1.0, -2.0, 0.5]), np.array([0.3, 0.1, -0.7])
    x = [*step, *(2 * np.tan(angle / 2) * n)]
    start = [np.array([entry]) for entry in (*place, *p.as_quat())]
    moved = _turn(start, [Jet(np.full((1, 1, 1), entry)) for entry in x])
    found = np.array([np.asarray(entry.value)[0] for entry in moved])
    expected = [*(place + p.apply(step)), *(p * Rotation.from_rotvec(angle * n)).as_quat()]
    np.testing.assert_allclose(found, expected, rtol=1e-14, atol=0)
    turned = _turn(start[3:], [Jet(np.full((1, 1, 1), entry)) for entry in x[3:]])
    np.testing.assert_allclose([e.value[0] for e in turned], expected[3:], rtol=1e-14, atol=0)


@pytest.mark.parametrize(
    ("J", "chosen", "columns"),
    [
        ([[1.0, 5, 0], [2, 10, 0], [0, 0, 3]], [1, 2], [1, 2]),
        ([[1.0, 1], [1, -1]], [0, 1], [0, 1]),
        ([[-7.0, 1, 2]], [0], [0]),
        ([[1.0, 0, 0], [0, 0, 0.5e-9]], [0], [0]),
        ([[1.0, 0, 0], [0, 0, 2e-9]], [0, 1], [0, 2]),
        ([[0.0, 0]], [], []),
    ],
)
def test_the_largest_entries_choose_rows_and_the_coordinates_that_follow(
    J: list[list[float]], chosen: list[int], columns: list[int]
) -> None:
    found = _choose(np.array(J))
    assert [part.tolist() for part in found] == [chosen, columns]
    assert abs(np.linalg.det(np.array(J)[np.ix_(*found)])) > 0


def test_a_block_is_as_regular_as_its_least_singular_value_beside_that_of_all() -> None:
    J = np.array([[3.0, 4.0]])
    assert _regularity(J[:, :1], J) == pytest.approx(0.6, rel=1e-15)
    assert _regularity(J[:, 1:], J) == pytest.approx(0.8, rel=1e-15)
    two = np.diag([2.0, 0.5])
    assert _regularity(two, two) == 1.0
    assert _regularity(two[:1, :1], two) == 0.0
    assert _regularity(two[:1, :1], np.diag([2.0, 1.9e-9])) == 1.0
    assert _regularity(np.zeros((0, 0)), np.zeros((1, 2))) == 1.0
