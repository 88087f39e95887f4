"""Two sources compared: sizes, floors, what rounding excuses, and the entry that is named."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
import pytest

import mecanique as mq
from mecanique.model.states import States
from mecanique.verification.rows import (
    IMPACT_MOMENTUM,
    OF_ELEMENTS,
    QUANTITIES,
    differ_by,
    evaluate,
    least_size,
    relative_difference,
    relative_differences,
    relative_rounding,
    rows_of,
    scale,
    scales,
)
from mecanique.verification.states import random_states
from mecanique.verification.stencil import differences, differences_twice
from mecanique.verification.verdict import Row

Array = Any


def test_units_are_the_roots_of_the_masses() -> None:
    """d_i = √M_ii: M_ij / (d_i d_j), f_i / d_i and a_i d_i have one unit; all else has its own."""
    mass, vector = np.array([[[4.0, 2.0], [2.0, 25.0]]]), np.array([[10.0, 20.0]])
    np.testing.assert_array_equal(scales(mass), [[2.0, 5.0]])
    np.testing.assert_allclose(
        scale("mass matrix", mass, mass), [[1, 0.2, 0.2, 1]], rtol=1e-15, atol=0
    )
    for quantity in ("bias", "gravity", "forces", "inverse dynamics"):
        np.testing.assert_array_equal(scale(quantity, vector, mass), [[5.0, 4.0]])
    np.testing.assert_array_equal(scale("acceleration", vector, mass), [[20.0, 100.0]])
    for quantity in (*QUANTITIES[6:], OF_ELEMENTS, IMPACT_MOMENTUM):
        np.testing.assert_array_equal(scale(quantity, vector, mass), vector)


def test_what_a_difference_is_judged_against_at_least() -> None:
    """Scaled forces and accelerations have the root of a mass; energies and momenta a mass."""
    for quantity in QUANTITIES[1:6]:
        assert least_size(quantity, 9.0) == 3.0
    for quantity in (*QUANTITIES[6:], OF_ELEMENTS, IMPACT_MOMENTUM):
        assert least_size(quantity, 9.0) == 9.0
    assert least_size("mass matrix", 9.0) == 1.0
    assert QUANTITIES[5:7] == ("acceleration", "kinetic energy")


def test_a_difference_of_vectors_is_judged_by_their_scaled_size() -> None:
    mass = np.array([[[4.0, 0.0], [0.0, 25.0]]] * 2)
    x, y = np.array([[10.0, 20.0], [2.0, 0.0]]), np.array([[10.0, 25.0], [2.0, 0.0]])
    expected = [1 / np.sqrt(50), 0]
    np.testing.assert_allclose(differ_by("bias", x, y, mass), expected, rtol=1e-14, atol=0)


@pytest.mark.parametrize(
    ("y", "least", "size"),
    [
        ([[3.0, 4.0], [3.0, 4.0]], 1.0, 5.0),  # its own
        # a thousandth of the typical one
        ([[0.0, 0.0], [3.0, 4.0], [6.0, 8.0]], 1.0, 1e-3 * np.sqrt(125 / 3)),
        ([[0.0, 0.0], [3.0, 4.0]], 10.0, 1e-2),  # a thousandth of the least
        ([[0.0, 0.0], [np.inf, 4.0]], 1.0, 1e-3),  # of the finite ones
        ([[0.0, 0.0], [np.nan, 4.0]], 2.0, 2e-3),
    ],
)
def test_sizes_come_from_the_values_or_a_thousandth_of_what_is_usual(
    y: list[list[float]], least: float, size: float
) -> None:
    there = np.array(y)
    x = there.copy()
    x[0, 0] += 1e-6 * size
    expected = x[0, 0] - there[0, 0]
    found = relative_difference(x, there, least)[0]
    assert found == pytest.approx(expected / size, rel=1e-5, abs=0)
    entries = relative_differences(x, there, least)[0]
    assert entries[0] == pytest.approx(expected / size, rel=1e-5, abs=0)
    assert entries[1] == 0
    assert relative_differences(x, there, None)[0, 0] == pytest.approx(expected, rel=1e-9, abs=0)


def test_the_larger_of_two_values_is_the_size() -> None:
    small, large = np.array([[1.0]]), np.array([[4.0]])
    for x, y in ((small, large), (large, small)):
        np.testing.assert_array_equal(relative_difference(x, y, 1.0), [0.75])
        np.testing.assert_array_equal(relative_differences(x, y, 1.0), [[0.75]])
        np.testing.assert_array_equal(relative_differences(x, y, None), [[3.0]])


def test_rounding_excuses_its_part_of_the_size_and_a_thousandth_at_most() -> None:
    x, y = np.array([[3.0, 4.0]] * 4), np.array([[0.0, 2.0]] * 4)
    bound = np.array([1e-6, 5e-3, 6e-3, np.nan])
    expected = [2e-7, 1e-3, 1e-3, 0.0]
    np.testing.assert_allclose(relative_rounding(bound, x, y, 1.0), expected, rtol=1e-12, atol=0)
    entries = np.stack([bound, 2 * bound], axis=1)
    found = relative_rounding(entries, x, y, 1.0)
    np.testing.assert_allclose(found[0], [2e-7, 4e-7], rtol=1e-12, atol=0)
    np.testing.assert_array_equal(found[3], [0, 0])
    # entries of the mass matrix are scaled to one already
    np.testing.assert_array_equal(relative_rounding(entries, x, y, None)[0], [1e-6, 2e-6])


def pendulum() -> tuple[mq.Mechanism, States, dict[str, Array]]:
    mechanism = mq.textbook.load("double_pendulum")
    states = random_states(mechanism, 6, 0)
    return mechanism, states, evaluate(mq.derive(mechanism), states)


def row_of(quantity: str, factor: Array, **how: Any) -> Row:
    """The row of a quantity whose values are off by a factor at each state, shape (6,)."""
    mechanism, states, values = pendulum()
    shape = (-1, *[1] * (values[quantity].ndim - 1))
    wrong = values | {quantity: values[quantity] * np.reshape(factor, shape)}
    rows = rows_of(("ours", "theirs"), wrong, values, states, mechanism, **how)
    (row,) = (row for row in rows if row.quantity == quantity)
    return row


def test_the_state_is_told_where_most_of_what_is_allowed_is_used_up() -> None:
    """A millionth where rounding may make as much is better than 1e-8 where it may not."""
    _, states, values = pendulum()
    off = np.array([0, 1e-6, 0, 0, 1e-8, 0])
    assert row_of("acceleration", 1 + off).q == tuple(states.q[1])
    M = values["mass matrix"]
    sizes = np.linalg.norm(scale("acceleration", values["acceleration"], M), axis=1)
    bound = np.where(np.arange(6) == 1, 2e-6 * sizes, 0.0)
    row = row_of("acceleration", 1 + off, rounding={"acceleration": bound})
    assert row.q == tuple(states.q[4])
    assert row.worst == pytest.approx(1e-8, rel=1e-6, abs=0)
    assert not row.agrees
    row = row_of("acceleration", 1 + off * [1, 1, 1, 1, 0, 1], rounding={"acceleration": bound})
    assert row.agrees
    assert row.rounding == pytest.approx(2e-6, rel=1e-5, abs=0)
    assert (row.by_entry, row.entry, row.tolerance) == (False, (), 1e-9)


@pytest.mark.parametrize(("off", "agrees"), [(0.9, True), (1.1, False)])
@pytest.mark.parametrize("tolerance", [1e-9, 1e-6])
def test_a_tolerance_is_what_a_row_may_differ_by(
    tolerance: float, off: float, agrees: bool
) -> None:
    for quantity in ("mass matrix", "bias", "acceleration", "momentum"):
        factor = 1 + off * tolerance * np.array([0, 0, 1, 0, 0, 0])
        row = row_of(quantity, factor, tolerance=tolerance)
        assert row.worst <= 1.01 * off * tolerance
        if quantity in ("bias", "acceleration"):
            assert row.agrees == agrees


@pytest.mark.parametrize(("off", "agrees"), [(0.9, True), (1.1, False)])
def test_entries_of_a_mass_matrix_are_judged_by_their_own_scale_and_named(
    off: float, agrees: bool
) -> None:
    """Rounding alone decides by default: an entry off by more than its bound is named."""
    mechanism, states, values = pendulum()
    M = values["mass matrix"]
    d = np.sqrt(np.diagonal(M, axis1=1, axis2=2))
    bound = 1e-13 * d[:, :, None] * d[:, None, :]
    wrong = M.copy()
    wrong[3, 1, 0] += off * bound[3, 1, 0]
    sides = values | {"mass matrix": wrong}, values
    rows = rows_of(
        ("ours", "theirs"),
        *sides,
        states,
        mechanism,
        entries={"mass matrix": bound},
        tolerance=None,
    )
    (row,) = (row for row in rows if row.quantity == "mass matrix")
    assert row.agrees == agrees
    assert row.entry == (mechanism.velocities[1], mechanism.velocities[0])
    assert row.q == tuple(states.q[3])
    assert row.worst == pytest.approx(off * 1e-13, rel=1e-2, abs=0)
    assert row.rounding == pytest.approx(1e-13, rel=1e-9, abs=0)
    assert (row.by_entry, row.tolerance) == (True, 0.0)


@pytest.mark.parametrize(
    ("quantity", "place", "entry"),
    [
        ("bias", (2, 1), ("q2'",)),
        ("momentum", (2, 2), ("z",)),
        ("angular momentum", (2, 1), ("y",)),
        ("kinetic energy", (2,), ()),
    ],
)
def test_an_entry_is_named_by_its_velocity_or_axis(
    quantity: str, place: tuple[int, ...], entry: tuple[str, ...]
) -> None:
    mechanism, states, values = pendulum()
    wrong = values | {quantity: values[quantity].copy()}
    wrong[quantity][place] += 1.0
    bounds = {quantity: np.full_like(values[quantity], 1e-12)}
    rows = rows_of(
        ("ours", "theirs"), wrong, values, states, mechanism, entries=bounds, tolerance=None
    )
    (row,) = (row for row in rows if row.quantity == quantity)
    assert row.entry == entry
    assert row.q == tuple(states.q[2])
    assert not row.agrees


def test_a_constant_of_the_potential_is_judged_with_the_tolerance_that_is_asked() -> None:
    mechanism, states, values = pendulum()
    V = values["potential energy"]
    for tilt, tolerance, constant in ((1e-5, 1e-9, False), (1e-5, 1e-3, True), (0.0, 1e-9, True)):
        other = values | {"potential energy": V * (1 + tilt) + 40.0}
        rows = rows_of(("ours", "theirs"), other, values, states, mechanism, tolerance=tolerance)
        (row,) = (row for row in rows if row.quantity == "potential energy")
        assert row.agrees == constant
        assert row.remark.startswith("up to a constant of 40") == constant


def test_which_source_is_not_finite_is_said() -> None:
    mechanism, states, values = pendulum()
    bad = values | {"momentum": values["momentum"].copy()}
    bad["momentum"][[1, 4], 2] = np.nan
    for first, second, name in (
        (bad, values, "ours"),
        (values, bad, "theirs"),
        (bad, bad, "theirs"),
    ):
        rows = rows_of(("ours", "theirs"), first, second, states, mechanism)
        remarks = {row.quantity: row.remark for row in rows if row.remark}
        assert remarks == {"momentum": f"{name} is not finite at 2 of 6 states"}


def test_parts_of_a_potential_energy_are_summed() -> None:
    _, states, values = pendulum()
    equations = mq.derive(mq.textbook.load("double_pendulum"))

    class Parted:
        def __getattr__(self, name: str) -> Any:
            return getattr(equations, name)

        def energy(self, q: Array, v: Array, t: Array) -> tuple[Array, ...]:
            kinetic, potential = equations.energy(q, v, t)
            return kinetic, potential / 2, potential / 3, potential / 6

    found: Mapping[str, Array] = evaluate(Parted(), states)  # type: ignore[arg-type]
    np.testing.assert_allclose(
        found["potential energy"], values["potential energy"], rtol=1e-14, atol=0
    )
    np.testing.assert_array_equal(found["kinetic energy"], values["kinetic energy"])


def test_differences_of_both_steps_are_exact_up_to_the_eighth_power_and_not_beyond() -> None:
    """Of (1 + x)⁹ the term x⁹ alone is off: by −4!² h⁸."""
    powers, h = np.arange(10), 0.05

    def function(x: Array) -> Array:
        return (1 + x) ** powers

    fine, coarse = differences_twice(function, 1, h)
    for slopes, step in ((fine, h), (coarse, 2 * h), (differences(function, 1, h), h)):
        np.testing.assert_allclose(slopes[:9, 0], powers[:9], rtol=0, atol=1e-11)
        assert slopes[9, 0] - 9 == pytest.approx(-576 * step**8, rel=1e-3, abs=0)


def test_differences_have_a_step_for_each_variable() -> None:
    def function(x: Array) -> Array:
        return np.stack([x[:, 0] * 2 + x[:, 1] ** 3, np.sin(x[:, 1])], axis=1)

    expected = [[2.0, 0.0], [0.0, 1.0]]
    found = differences(function, 2, np.array([1e-1, 1e-2]))
    np.testing.assert_allclose(found, expected, rtol=0, atol=1e-12)
    for slopes in differences_twice(function, 2, 1e-2):
        np.testing.assert_allclose(slopes, expected, rtol=0, atol=1e-12)
