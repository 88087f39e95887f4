"""Medians, places along a length and ranks, beside numpy's own."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest

from mecanique import arrays
from mecanique.arrays import median, spread
from mecanique.reference import vectors


@pytest.mark.parametrize("values", [[3.0], [4.0, 1.0], [2.0, 9.0, -1.0], [[1.0, 8.0], [2.0, 3.0]]])
def test_the_median_is_that_of_numpy(values: object) -> None:
    assert median(np.array(values)) == np.median(np.array(values))


@pytest.mark.parametrize("most", [2, 5, 24, 40])
def test_places_are_spread_evenly_and_each_is_taken_once(most: int) -> None:
    for length in range(1, 400):
        places = spread(length, most)
        assert len(places) == min(most, length)
        assert places[0] == 0
        assert places[-1] == length - 1 or length == 1
        steps = np.diff(places)
        assert steps.size == 0 or steps.min() >= max(1, steps.max() - 1)


@pytest.mark.parametrize("rank_of", [arrays.rank_of, vectors.rank_of])
def test_the_numerical_rank_counts_what_exceeds_a_part_of_the_largest(
    rank_of: Callable[..., int],
) -> None:
    random = np.random.default_rng(3)
    for rank in range(5):
        A = 40.0 * random.normal(size=(6, rank)) @ random.normal(size=(rank, 4))
        assert rank_of(np.linalg.svd(A, compute_uv=False), 1e-10) == rank
    assert rank_of(np.array([8.0, 4.0, 2.0]), 0.5) == 1
    assert rank_of(np.array([]), 0.5) == 0


def test_the_rank_on_the_engines_side_counts_nothing_below_the_rounding() -> None:
    assert vectors.rank_of(np.array([3.0, 0.2, 0.1]), 1e-9, 0.1) == 2
    assert vectors.rank_of(np.array([1e-16, 1e-17]), 1e-9, 1e-15) == 0
