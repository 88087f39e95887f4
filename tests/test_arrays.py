"""Medians and places along a length, beside numpy's own."""

from __future__ import annotations

import numpy as np
import pytest

from mecanique.arrays import median, spread


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
