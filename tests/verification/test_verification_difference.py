"""The relative difference: units do not matter, and nothing that is not finite passes."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from mecanique.verification.rows import relative_difference, scale

NUMBERS = st.floats(-1e3, 1e3)


def test_it_is_the_norm_of_the_difference_over_the_larger_norm() -> None:
    x, y = np.array([[3.0, 4.0], [0.0, 10.0]]), np.array([[3.0, 4.5], [0.0, 8.0]])
    expected = [0.5 / np.hypot(3, 4.5), 2 / 10]
    np.testing.assert_allclose(relative_difference(x, y, 1.0), expected, rtol=1e-14, atol=0)


@settings(deadline=None)
@given(st.lists(st.tuples(NUMBERS, NUMBERS), min_size=1, max_size=5), NUMBERS)
def test_it_is_zero_for_equal_values_and_at_most_two(
    pairs: list[tuple[float, float]], other: float
) -> None:
    x = np.array(pairs)
    assert (relative_difference(x, x.copy(), 1.0) == 0).all()
    assert (relative_difference(x, -x + other, 1.0) <= 2.0000001).all()


@pytest.mark.parametrize("bad", [np.nan, np.inf, -np.inf])
def test_what_is_not_finite_is_infinitely_wrong_even_where_both_sources_share_it(
    bad: float,
) -> None:
    x = np.array([[1.0, bad], [1.0, 2.0]])
    for first, second in ((x, np.ones((2, 2))), (np.ones((2, 2)), x), (x, x.copy())):
        difference = relative_difference(first, second, 1.0)
        assert difference[0] == np.inf
        assert np.isfinite(difference[1])


def test_a_value_that_passes_through_zero_is_judged_against_the_typical_one() -> None:
    x, y = np.array([[1e-12], [1.0], [1.0]]), np.array([[0.0], [1.0], [1.0]])
    assert relative_difference(x, y, 0.0)[0] == pytest.approx(
        1e-12 / (1e-3 * np.sqrt(2 / 3)), rel=1e-12, abs=0
    )


def test_zero_against_rounding_errors_is_judged_against_the_least_size() -> None:
    difference = relative_difference(np.array([[1e-15]]), np.array([[0.0]]), 2.0)
    assert difference[0] == pytest.approx(1e-15 / 2e-3, rel=1e-12, abs=0)


def test_a_huge_value_does_not_excuse_the_others() -> None:
    x, y = np.array([[1e200], [1.0]]), np.array([[1e200], [2.0]])
    assert not np.isnan(relative_difference(x, y, 1.0)).any()
    x, y = np.array([[3e200], [1e200]]), np.array([[1e200], [1e200]])
    assert relative_difference(x, y, 1.0)[0] > 1e-9


@pytest.mark.parametrize("quantity", ["mass matrix", "bias", "forces", "acceleration"])
def test_units_of_the_coordinates_do_not_matter(quantity: str) -> None:
    """In units u_i, M_ij becomes M_ij u_i u_j, f_i becomes f_i u_i and a_i becomes a_i / u_i."""
    random = np.random.default_rng(3)
    units = np.array([1.0, 1e3, 1e-3])
    root = random.normal(size=(4, 3, 3))
    mass = root @ root.transpose(0, 2, 1)
    other_mass = mass * units[:, None] * units
    if quantity == "mass matrix":
        values, others = mass * 1.1, other_mass * 1.1
    else:
        values = random.normal(size=(4, 3))
        others = values / units if quantity == "acceleration" else values * units
    np.testing.assert_allclose(
        scale(quantity, values, mass), scale(quantity, others, other_mass), rtol=1e-12, atol=0
    )


def test_scaling_by_a_broken_mass_matrix_keeps_the_values() -> None:
    mass = np.array([[[0.0, 0.0], [0.0, np.nan]], [[-1.0, 0.0], [0.0, 4.0]]])
    expected = [[1.0, 2.0], [1.0, 1.0]]
    np.testing.assert_allclose(
        scale("bias", np.array([[1.0, 2.0], [1.0, 2.0]]), mass), expected, rtol=1e-14, atol=0
    )
