"""Loops reduced to one equation: closed forms, the full equations, and the refusals."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from click.testing import CliRunner
from derivation_law import cos, sin
from derivation_reading import residual, value_of_text
from derivation_samples import linkage

import mecanique as mq
from mecanique import textbook
from mecanique.cli import app
from mecanique.derivation.scalars.evaluation import Evaluation, evaluate
from mecanique.derivation.scalars.series import Ring
from mecanique.derivation.symbolic.reduced import _angle_of


@pytest.mark.parametrize(
    ("name", "coordinate"),
    [
        ("slider_crank", "theta"),
        ("slider_crank", "x"),
        ("four_bar_linkage", "phi"),
        ("four_bar_linkage", "psi"),
        ("bars_and_springs_loop", "alpha"),
    ],
)
def test_one_equation_holds_along_motions_with_multipliers(name: str, coordinate: str) -> None:
    assert mq.reduce_loops(textbook.load(name), coordinate).compare() < 1e-9


def test_slider_crank_as_eksergian_writes_it() -> None:
    one = mq.reduce_loops(textbook.load("slider_crank"))
    assert one.coordinate == "theta"
    assert one.coefficients == {
        "K_beta": "-(r cos(theta) + l cos(theta + beta))/(l cos(theta + beta))",
        "K_x": "-(r sin(theta) + l (1 + K_beta) sin(theta + beta))",
        "L_beta": "(r sin(theta) + l (1 + K_beta)^2 sin(theta + beta))/(l cos(theta + beta))",
        "L_x": "-(r cos(theta) + l L_beta sin(theta + beta) + l (1 + K_beta)^2 cos(theta + beta))",
        "J": "m1 r^2/3 + m2 K_x^2",
        "C": "m2 K_x L_x",
    }
    assert str(one.equation) == "J theta'' + C theta'^2 + m1 g r cos(theta)/2 = 0"
    _, speeds, rest, forces = one.found.parts
    assert one.found.derivation.h == (speeds + rest + forces,)


def test_the_steps_to_one_equation_are_those_of_the_loop_and_its_coefficients() -> None:
    """Two bars whose tips a massless rod joins: what loops do without forces is not said."""
    two = linkage("distance", (0.0, 0.0, 0.0))
    steps = {stage.title: stage for stage in mq.reduce_loops(two, "phi").found.derivation.stages}
    assert [*steps] == [
        "Positions and velocities",
        "Kinetic energy",
        "Potential energy",
        "Loops",
        "Kinematic coefficients",
        "Derivatives of the coefficients",
        "Inertia referred to phi",
    ]
    assert steps["Loops"].explanation.endswith("it is zero as long as the loop is closed.")
    phi, psi, (line,) = 0.7, -0.4, steps["Loops"].results
    tips = np.array([[0.5 * np.cos(phi), 0.5 * np.sin(phi)], [1.3, 0.0]])
    tips[1] += 1.2 * np.cos(psi), 1.2 * np.sin(psi)
    stated = evaluate(line.right, {"phi": phi, "psi": psi})
    assert stated == pytest.approx((np.sum((tips[1] - tips[0]) ** 2) - 1.4**2) / 2, rel=1e-13)


def test_what_is_printed_reads_back_and_agrees_with_x_of_theta() -> None:
    mechanism = textbook.load("slider_crank")
    one = mq.reduce_loops(mechanism, "theta")
    p = mechanism.values
    theta = np.linspace(0.1, 6.0, 12)
    rod = np.arcsin(-p["r"] * np.sin(theta) / p["l"])
    values: dict[str, Any] = {**p, "theta": theta, "beta": rod - theta}
    for letter, text in one.coefficients.items():
        values[letter] = value_of_text(text, values)
    run = np.sqrt(p["l"] ** 2 - (p["r"] * np.sin(theta)) ** 2)
    slope = -p["r"] * np.sin(theta) - p["r"] ** 2 * np.sin(theta) * np.cos(theta) / run
    assert np.abs(values["K_x"] - slope).max() < 1e-13
    # the same in theta alone, with x and beta put in as a coordinate map
    values |= {"theta'": 1.3 + 0 * theta}
    tree = _tree(mechanism)
    values["theta''"] = tree.acceleration(theta[:, None], values["theta'"][:, None])[:, 0]
    assert np.abs(residual(str(one.equation), values)).max() < 1e-11
    values["theta''"] = 1.001 * values["theta''"]
    assert np.abs(residual(str(one.equation), values)).max() > 1e-4


def test_a_coupler_turns_by_one_and_its_coefficient() -> None:
    """Of a rod from the crank, at a relative angle, J holds the absolute rate: 1 + K_theta."""
    one = mq.reduce_loops(textbook.load("four_bar_linkage"), "phi")
    assert one.coefficients["J"] == (
        "(m1 + 3 m2) a^2/3 + m2 a b (1 + K_theta) cos(theta) + m3 c^2 K_psi^2/3"
        " + m2 b^2 (1 + K_theta)^2/3"
    )
    names = ("m2", "m3", "a", "b", "c", "theta", "K_theta", "K_psi", "L_theta", "L_psi")
    values = dict(zip(names, np.random.default_rng(3).normal(size=(10, 5)), strict=True))
    m2, m3, a, b, c, theta, K, K_psi, L, L_psi = values.values()
    # half the derivative of J along the motion, where theta' = K phi'
    N = m2 * a * b * (L * cos(theta) - (1 + K) * K * sin(theta)) / 2
    N += m2 * b**2 * (1 + K) * L / 3 + m3 * c**2 * K_psi * L_psi / 3
    assert np.abs(value_of_text(one.coefficients["N"], values) - N).max() < 1e-13


@pytest.mark.parametrize("name", ["four_bar_linkage", "bars_and_springs_loop"])
def test_coefficients_divide_by_nothing_that_vanishes_in_regular_positions(name: str) -> None:
    """Denominators vanish with the determinant of the loop's slopes, by central differences."""
    mechanism = textbook.load(name)
    one = mq.reduce_loops(mechanism)
    kept, *others = mechanism.coordinates.names
    slopes = mq.derive(mechanism).derivation
    ring, found = slopes.algebra.ring, one.found
    rows = [tie.slopes(ring) for tie in slopes.ties]
    random = np.random.default_rng(4)
    values: dict[str, Any] = {**mechanism.values}
    values |= {q: random.uniform(-3, 3, 20) for q in (kept, *others)}
    value = Evaluation(ring, values)
    (a, b), (c, d) = ([value(x) for x in row[1:]] for row in rows)
    for term in (*found.ratios, *found.changes):
        share = Evaluation(term.value.below.ring, values)(term.value.below) / (a * d - b * c)
        np.testing.assert_allclose(share, share[0], rtol=1e-9, atol=0)


def test_a_horizontal_coupler_is_a_regular_position() -> None:
    """Freudenstein: phi and psi of bars a, b, c, d follow the coupler's angle by the sine rule."""
    mechanism = textbook.load("four_bar_linkage")
    p = {**mechanism.values, "a": 0.3, "b": 0.4, "c": 0.5, "d": 0.8}
    found = mq.reduce_loops(mechanism)
    # the coupler of length b at the angle 0: a cos(phi) + b = d + c cos(psi), a sin = c sin
    run = p["d"] - p["b"]
    cosine = (p["a"] ** 2 + run**2 - p["c"] ** 2) / (2 * p["a"] * run)
    phi = np.arccos(cosine)
    psi = np.arctan2(p["a"] * np.sin(phi), p["a"] * np.cos(phi) - run)
    values: dict[str, Any] = {**p, "phi": phi, "theta": -phi, "psi": psi}
    for letter, text in found.coefficients.items():
        values[letter] = value_of_text(text, values)
    # the rates of both ends of the coupler are equal along it
    rates = p["a"] * np.sin(phi), p["c"] * np.sin(psi)
    assert values["K_psi"] == pytest.approx(rates[0] / rates[1], rel=1e-12)
    lift = p["a"] * np.cos(phi) - p["c"] * np.cos(psi) * values["K_psi"]
    assert values["K_theta"] + 1 == pytest.approx(-lift / p["b"], rel=1e-12)
    assert np.isfinite([values[letter] for letter in ("L_theta", "L_psi", "J", "N")]).all()
    said = " ".join(mq.derive(mechanism).text(steps=True).split())
    assert "left for phi wherever no denominator is zero: J phi'' + N phi'² = Q_phi." in said


def _tree(mechanism: mq.Mechanism) -> mq.Equations:
    from sympy import asin, cos, sin, sqrt, symbols

    theta, r, l = symbols("theta r l")
    follow = {
        "beta": -theta - asin(r * sin(theta) / l),
        "x": r * cos(theta) + sqrt(l**2 - r**2 * sin(theta) ** 2),
    }
    coordinates = mq.Coordinates(("theta",), follow)
    return mq.derive(replace(mechanism, name="tree", loops=(), coordinates=coordinates))


def test_refusals_say_what_is_missing() -> None:
    with pytest.raises(mq.DerivationError, match="leave one of its 2 velocities free, got 0"):
        mq.reduce_loops(textbook.load("double_pendulum"))
    with pytest.raises(mq.UnknownNameError, match="phi"):
        mq.reduce_loops(textbook.load("slider_crank"), "phi")


def test_the_command_prints_the_steps() -> None:
    found = CliRunner().invoke(app, ["derive", "slider_crank", "--in", "theta"]).output
    assert "J theta'' + C theta'^2 + m1 g r cos(theta)/2 = 0" in found
    steps = CliRunner().invoke(app, ["derive", "slider_crank", "--in", "theta", "--document"])
    assert "kinematic coefficient" in steps.output
    wrong = CliRunner().invoke(app, ["derive", "slider_crank", "--in", "theta", "--routh"])
    assert wrong.exit_code == 2


@pytest.mark.parametrize(
    ("name", "solved"),
    [
        ("slider_crank", "theta'' = -(C theta'^2 + m1 g r cos(theta)/2)/J"),
        ("bars_and_springs_loop", None),
    ],
)
def test_the_equation_is_solved_for_the_acceleration(name: str, solved: str | None) -> None:
    one = mq.reduce_loops(mq.textbook.load(name))
    assert str(one.acceleration).startswith(f"{one.coordinate}'' = ")
    assert str(one.acceleration) in str(one)
    assert str(one.acceleration) in one.text(steps=True)
    if solved is not None:
        assert str(one.acceleration) == solved


@pytest.mark.parametrize(
    ("kept", "units"),
    [
        ("theta", {"J": "kg·m²", "C": "kg·m²/rad", "K_x": "m/rad", "L_x": "m/rad²"}),
        ("x", {"J": "kg", "C": "kg/m", "K_theta": "rad/m", "L_theta": "rad/m²"}),
    ],
)
def test_letters_have_the_units_of_what_is_kept(kept: str, units: dict[str, str]) -> None:
    meanings = mq.reduce_loops(textbook.load("slider_crank"), kept).found.derivation.unknowns
    for letter, unit in units.items():
        assert meanings[letter].endswith(f"[{unit}]")


def test_a_wrong_equation_is_told_by_the_full_ones() -> None:
    one = mq.reduce_loops(textbook.load("slider_crank"))
    inertia, speeds, rest, forces = one.found.parts
    for parts in (
        (1.001 * inertia, speeds, rest, forces),
        (inertia, -speeds, rest, forces),
        (inertia, speeds, -rest, forces),
    ):
        assert replace(one, found=replace(one.found, parts=parts)).compare(8) > 1e-5
    first, *others = one.found.changes
    wrong = first._replace(value=replace(first.value, above=2 * first.value.above))
    found = replace(one.found, changes=(wrong, *others))
    assert replace(one, found=found).compare(8) > 1e-5
    with pytest.raises(mq.DerivationError, match="no random position allowed its loops to close"):
        one.compare(samples=0)


def test_an_angle_that_a_weld_keeps_is_that_of_its_sine() -> None:
    """3 sin(a − 2 b) = 0 is a − 2 b = 0 in rates; a cosine, a product or a sum is as it is."""
    ring = Ring()
    a, b, x = ring.coordinate("a"), ring.coordinate("b"), ring.parameter("x")
    assert _angle_of(3 * sin(a - 2 * b)) in (a - 2 * b, 2 * b - a)
    for demand in (cos(a), x * sin(a), sin(a) + sin(b), a - b):
        assert _angle_of(demand) == demand


@pytest.mark.parametrize("aside", [0.0, 0.1])
def test_loops_are_not_closed_where_they_are_singular(aside: float) -> None:
    """In a dead center the crank does not follow from the slider, whether it is reached or not."""
    crank = textbook.load("slider_crank")
    one, p = mq.reduce_loops(crank, "x"), crank.values
    center = {"theta": 0.0, "beta": 0.0, "x": p["r"] + p["l"] + aside}
    assert one._close(np.array([center[name] for name in crank.coordinates]), 1.0) is None
    away = {"theta": 0.7, "beta": -0.9, "x": 0.9 * (p["r"] + p["l"])}
    assert one._close(np.array([away[name] for name in crank.coordinates]), 1.0) is not None
