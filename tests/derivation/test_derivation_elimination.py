"""Constraints met in symbols: displacements, forces and multipliers, by what they satisfy."""

from __future__ import annotations

from fractions import Fraction
from typing import Any

import numpy as np
import pytest
from derivation_law import cos, sin

from mecanique.derivation.scalars.evaluation import Evaluation, evaluate
from mecanique.derivation.scalars.series import Kind, Ring, Series
from mecanique.derivation.symbolic.derivation import project
from mecanique.derivation.symbolic.multipliers import (
    Quotient,
    cramer,
    determinant,
    divide_common,
    divide_waves,
    independent_displacements,
    is_constant,
    list_alone,
    make_positive,
    solve_multipliers,
    sweep,
    vanishes_nowhere,
)
from mecanique.errors import DerivationError

RING = Ring()
A, B, X = RING.coordinate("a"), RING.coordinate("b"), RING.coordinate("x")
L, M, R = RING.parameter("l"), RING.parameter("m"), RING.parameter("r")
ZERO, ONE = RING.number(0), RING.number(1)
AT = {"a": 0.4, "b": -1.1, "x": 0.7, "l": 1.3, "m": 0.6, "r": 0.9}

ROWS: dict[str, list[list[Series]]] = {
    "rolling": [[ONE, ZERO, -R, ZERO], [ZERO, ONE, ZERO, ZERO]],
    "blade": [[-sin(A), cos(A), ZERO, L]],
    "two blades": [[-sin(A), cos(A), ZERO, L], [-sin(B), cos(B), X, ZERO]],
    "one twice": [[-sin(A), cos(A), ZERO, L], [-2 * sin(A), 2 * cos(A), ZERO, 2 * L]],
    "loop": [[L * cos(A), R * cos(B), -ONE, ZERO], [L * sin(A), R * sin(B), ZERO, ZERO]],
    "no constant": [[X, cos(A), sin(B) + X, ZERO], [X * sin(A), X, ZERO, cos(B) + 2 * X]],
}


def numbers(rows: Any) -> np.ndarray:
    value = Evaluation(RING, AT)
    return np.array([[float(value(entry)) for entry in row] for row in rows])


@pytest.mark.parametrize("name", ROWS)
def test_independent_displacements_satisfy_all_rows(name: str) -> None:
    rows = ROWS[name]
    basis = independent_displacements(RING, rows, 4)
    for row in rows:
        assert all(entry.vanishes() for entry in project(row, basis))
    rank = np.linalg.matrix_rank(numbers(rows))
    assert len(basis) == np.linalg.matrix_rank(numbers(basis)) == 4 - rank


@pytest.mark.parametrize("name", ROWS)
@pytest.mark.parametrize("ranks", [(0, 1, 2, 3), (3, 2, 1, 0)])
def test_what_is_met_reaches_values_and_weighs_forces(name: str, ranks: tuple[int, ...]) -> None:
    """A p = c for any c, and Aᵀ λ = f for the forces f of any λ."""
    rows = ROWS[name]
    allowed, left = sweep(RING, rows, 4, ranks, divide=True)
    assert not left
    met = [row for row, _ in allowed.pulls]
    for k, (row, u) in enumerate(allowed.pulls):
        slopes = numbers([[*project(rows[i], [u])] for i in met[: k + 1]]).ravel()
        np.testing.assert_allclose(slopes, np.eye(k + 1)[k], rtol=0, atol=1e-13)
        assert row == met[k]
    chosen = [rows[k] for k in met]
    wanted = [X, L * ONE, M * cos(A), ONE][: len(rows)]
    if len(met) == len(rows):
        p = allowed.reach(RING, rows, wanted)
        (reached,) = numbers([[*(project(row, [p])[0] for row in rows)]])
        np.testing.assert_allclose(reached, numbers([wanted])[0], rtol=1e-12, atol=1e-13)
    forces = [
        RING.sum(w * x for w, x in zip(wanted, column, strict=False))
        for column in zip(*chosen, strict=True)
    ]
    weights = allowed.weigh(RING, rows, forces)
    again = numbers(rows).T @ numbers([weights])[0]
    np.testing.assert_allclose(again, numbers([forces])[0], rtol=1e-12, atol=1e-13)


def test_the_velocity_with_the_least_rank_gives_way() -> None:
    rows = [[ONE, -R, ZERO]]
    (first,) = (sweep(RING, rows, 3, ranks)[0] for ranks in [(0, 1, 2)])
    assert list_alone(first.basis) == [[1], [2]]
    (other,) = (sweep(RING, rows, 3, ranks)[0] for ranks in [(1, 0, 2)])
    assert list_alone(other.basis) == [[0], [2]]
    unmet, left = sweep(RING, [[X, cos(A), ZERO]], 3)
    assert left == [0]
    assert len(unmet.basis) == 3
    with pytest.raises(DerivationError, match="too long to be read"):
        independent_displacements(RING, [[(1 + X + A + B + L + M) ** 4, X, A]], 3)


@pytest.mark.parametrize("n", [1, 2, 3, 4])
def test_determinants_and_cramers_rule(n: int) -> None:
    random = np.random.default_rng(n)
    whole = random.integers(-3, 4, (n, n + 1))
    rows = [[RING.number(int(x)) for x in row] for row in whole]
    square, sides = [row[:n] for row in rows], [row[n] for row in rows]
    exact = np.linalg.det(whole[:, :n])
    assert determinant(RING, square) == round(exact)
    numerators = numbers([cramer(RING, square, sides)])[0]
    np.testing.assert_allclose(whole[:, :n] @ numerators, exact * whole[:, n], rtol=0, atol=1e-9)
    assert determinant(RING, []) == 1


def test_multipliers_are_solved_for_one_after_another() -> None:
    """Three of four balances, one of which has a single unknown; the rest by cross products."""
    ring = RING
    unknowns = [ring.unknown(f"lambda_{k}", Kind.REACTION) for k in range(3)]
    slopes = [[L, cos(A), ZERO, ONE], [ZERO, sin(A), X, ONE], [ZERO, L * cos(B), R, X]]
    exact = {"lambda_0": 0.8, "lambda_1": -0.3, "lambda_2": 1.9}
    given = [ring.parameter(f"side_{k}") for k in range(4)]
    sides = numbers(slopes).T @ [*exact.values()]
    at = {**AT, **exact, **{f"side_{k}": side for k, side in enumerate(sides)}}
    solved = solve_multipliers(unknowns, slopes, given)
    assert {*solved} == {*exact}
    value, known = Evaluation(ring, at), list[str]()
    for name, quotient in solved.items():
        assert value(quotient.above) / value(quotient.below) == pytest.approx(
            exact[name], rel=1e-12
        )
        used = {g.name for g in quotient.above.generators() if g.kind is Kind.REACTION}
        assert used <= {*known}
        known.append(name)
    assert not solve_multipliers(unknowns, [[ZERO], [ZERO], [ONE]], given[:1])


def test_quotients_are_bearable_up_to_a_length_and_divided_by_what_may_vanish() -> None:
    def long(count: int) -> Series:
        return RING.sum(X**k for k in range(count))

    assert Quotient(long(40), long(12)).bearable
    assert not Quotient(long(41), ONE).bearable
    assert not Quotient(ONE, long(13)).bearable
    for above in (X / L, X * cos(A), X / (L + M)):
        assert not Quotient(above, ONE).divided
    for quotient in (Quotient(X, X + L), Quotient(L / X, ONE), Quotient(X / (L + cos(A)), ONE)):
        assert quotient.divided


def test_common_factors_and_signs_are_taken_out() -> None:
    shared = [6 * L**2 * X, -4 * L * M * X**2]
    assert divide_common(shared) == [3 * L * X, -2 * M * X**2]
    assert divide_common(shared, Kind.PARAMETER, Kind.COORDINATE) == [3 * L, -2 * M * X]
    assert divide_common([ZERO, ZERO]) == [0, 0]
    assert divide_waves([sin(A) * X, sin(2 * A)]) == [X, 2 * cos(A)]
    assert divide_waves([cos(A) ** 2 * X, cos(A) ** 2 * sin(B)]) == [X, sin(B)]
    assert divide_waves([sin(A), cos(A)]) == [sin(A), cos(A)]
    assert make_positive([ZERO, -X - L + M, X]) == [0, X + L - M, -X]
    assert make_positive([X - L, X]) == [X - L, X]
    assert is_constant(3 * L / M)
    assert not any(map(is_constant, (X, L + M, ZERO, cos(A), L * X)))


def test_products_of_measured_numbers_stay_within_what_floats_hold() -> None:
    """As multiples of their common measure, 3⁻⁷⁰⁰ 7⁻³⁰⁰, they would be 7³⁰⁰ and 3⁷⁰⁰ > 1e308."""
    small, large = Fraction(1, 3**700), Fraction(1, 7**300)
    first, second = divide_common([small * M * X, large * M])
    values = {"x": 2.0, "m": 5.0}
    assert evaluate(second, values) == 1.0
    assert evaluate(first, values) == pytest.approx(float(small / large) * 2.0, rel=1e-12, abs=0)


@pytest.mark.parametrize("sign", [1, -1])
def test_what_outweighs_its_waves_vanishes_nowhere(sign: int) -> None:
    """For positive parameters, each of whose products has a constant of its own."""
    for sums, nowhere in (
        (2 * L + L * cos(A), True),
        (2 * L - L * cos(A) - L * sin(B), False),
        (2 * L + 3 * L * cos(A), False),
        (2 * L + M * cos(A), False),
        (2 * L + M + M * cos(A), True),
        (L - M, False),
        (L + X, False),
        (cos(A) * L, False),
    ):
        assert vanishes_nowhere(sign * sums) is nowhere
