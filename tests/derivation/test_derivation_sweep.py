"""Displacements that constraints allow, in letters: identities at any values of the letters."""

from __future__ import annotations

import numpy as np
import pytest

from mecanique.derivation.scalars.elementary import cos, sin
from mecanique.derivation.scalars.evaluation import Evaluation
from mecanique.derivation.scalars.series import Ring, Series
from mecanique.derivation.symbolic.multipliers import sweep


def draw_rows(ring: Ring, seed: int, rows: int, count: int) -> list[list[Series]]:
    """Rows of few entries; of one in two the first two are a length times cosine and sine."""
    random = np.random.default_rng(seed)
    l, q, p = ring.parameter("l"), ring.coordinate("q"), ring.coordinate("p")
    entries = [ring.number(1), ring.number(-2), l, cos(q), 3 * sin(p), l * sin(q + p)]
    drawn = []
    for _ in range(rows):
        row = [ring.number(0)] * count
        first, second, *places = random.permutation(count)[:4]
        if random.random() < 0.5:
            row[first], row[second] = l * cos(q), l * sin(q)
            entries_of_rest = entries[3:]
        else:
            entries_of_rest = entries
        for place in places:
            row[place] = entries_of_rest[random.integers(len(entries_of_rest))]
        drawn.append(row)
    return drawn


@pytest.mark.parametrize("divide", [False, True])
@pytest.mark.parametrize("seed", range(12))
def test_what_constraints_allow_is_all_that_they_allow(seed: int, divide: bool) -> None:
    """A S = 0; each row that was met is 1 along its u, and 0 along those of later rows."""
    ring, count = Ring(), 6
    rows = draw_rows(ring, seed, 3, count)
    rows.append([a + b for a, b in zip(rows[0], rows[1], strict=True)])  # which says nothing new
    allowed, left = sweep(ring, rows, count, divide=divide)
    random = np.random.default_rng(seed)
    letters = dict(zip(("l", "q", "p"), random.uniform(0.5, 1.5, size=3), strict=True))
    value = Evaluation(ring, letters)

    def numbers(columns: list[list[Series]]) -> np.ndarray:
        return np.array([[value(entry) for entry in column] for column in columns])

    A = numbers(rows)
    met = [row for row, _ in allowed.pulls]
    assert left == [] or not divide
    assert len(met) == np.linalg.matrix_rank(np.delete(A, left, axis=0))
    S = numbers(allowed.basis)
    assert len(S) == count - len(met) == np.linalg.matrix_rank(S)
    np.testing.assert_allclose(np.delete(A, left, axis=0) @ S.T, 0, rtol=0, atol=1e-12)
    U = numbers([u for _, u in allowed.pulls])
    np.testing.assert_allclose(np.tril(U @ A[met].T), np.eye(len(met)), rtol=0, atol=1e-12)
    # any values of the rows are reached, and any forces of theirs have the multipliers
    wanted = [ring.number(int(k)) for k in random.integers(-5, 6, size=len(rows))]
    wanted[-1] = wanted[0] + wanted[1]
    (reached,) = numbers([allowed.reach(ring, rows, wanted)])
    np.testing.assert_allclose(A[met] @ reached, numbers([wanted])[0][met], rtol=0, atol=1e-11)
    pushes = random.normal(size=len(met))
    forces = [
        ring.sum([entry * round(100 * push) for entry, push in zip(column, pushes, strict=True)])
        for column in zip(*(rows[k] for k in met), strict=True)
    ]
    (multipliers,) = numbers([allowed.weigh(ring, rows, forces)])
    np.testing.assert_allclose(multipliers @ A, numbers([forces])[0], rtol=0, atol=1e-9)
