"""Printed equations stay short: counted for every system, and compared with those of experts."""

from __future__ import annotations

import re
from typing import Any

import numpy as np
import pytest
from derivation_reading import residual
from systems import derive_system

from mecanique import derive, textbook
from mecanique.derivation.equations import Equations
from mecanique.derivation.printing.equations import expression
from mecanique.derivation.printing.writers import Text
from mecanique.derivation.scalars.series import Generator
from mecanique.derivation.symbolic.balances import needs
from mecanique.derivation.symbolic.newton_euler import NewtonEuler
from mecanique.derivation.symbolic.vectors import component

SIGNS = {
    "acrobot": 109,
    "atwood_machine": 15,
    "bar_chain": 381,
    "bars_and_springs": 75,
    "bars_and_springs_loop": 110,
    "bars_and_springs_small": 9,
    "base_excited_mass": 18,
    "bead_on_hoop": 14,
    "cart_pole": 33,
    "chained_four_bars": 321,  # the forces λ stand with their bare levers
    "chaplygin_sleigh": 70,
    "compound_pendulum": 26,
    "coupled_pendulums": 58,
    "crane": 50,
    "double_atwood_machine": 34,
    "double_pendulum": 64,
    "dumbbell": 32,
    "elastic_pendulum": 34,
    "foucault_pendulum": 80,
    "four_bar_linkage": 198,  # the forces λ stand with their bare levers
    "free_particle": 8,
    "free_planar_body": 8,
    "free_rigid_body": 102,
    "furuta_pendulum": 71,
    "governor": 138,
    "gyroscope": 151,
    "heavy_top": 108,
    "kapitza_pendulum": 16,
    "kepler_orbit": 23,
    "n_link_pendulum": 238,
    "particle_on_circle": 2,
    "particle_on_circle_x": 15,
    "planetary_gear": 146,
    "rack_and_pinion": 15,
    "rigid_bar_pendulum": 10,
    "ball_in_a_bowl": 958,
    "ball_on_a_turntable": 391,  # friction turns with the table, the ball by its quaternion
    "snakeboard": 89,
    "rattleback": 1361,
    "rolling_coin": 192,  # the forces λ stand with their bare levers
    "rolling_disk": 37,  # the forces λ stand with their bare levers
    "rotating_plate": 14,
    "screw_press": 25,
    "shear_building": 109,
    "simple_pendulum": 8,
    "slider_crank": 77,
    "spherical_pendulum": 30,
    "squeezer": 458,
    "swinging_atwood_machine": 34,
    "tennis_racket": 57,
    "two_blocks": 19,
    "two_link_arm": 118,
    "two_wheeled_cart": 1205,
}
"""Letters, numbers, functions and signs of each system's equations; fewer may be entered."""

EXPERTS = {
    "rigid_bar_pendulum": ["q'' + 3 g sin(q)/(2 l) = 0"],
    "simple_pendulum": ["q'' + g sin(q)/l = 0"],
    "two_blocks": ["m1 q1'' + (k1 + k2) q1 - k2 q2 = 0", "m2 q2'' + k2 (q2 - q1) = F"],
    "cart_pole": [
        "(M + m) x'' + m l cos(q) q'' - m l sin(q) q'^2 + c x' = F",
        "cos(q) x'' + l q'' + g sin(q) = 0",
    ],
    "double_pendulum": [
        "2 (m1 + 3 m2) l1 q1'' + 3 m2 l2 cos(q1 - q2) q2'' + 3 m2 l2 sin(q1 - q2) q2'^2"
        " + 3 (m1 + 2 m2) g sin(q1) = 0",
        "3 l1 cos(q1 - q2) q1'' + 2 l2 q2'' - 3 l1 sin(q1 - q2) q1'^2 + 3 g sin(q2) = 0",
    ],
    "crane": [
        "(M + m) x'' + m (l0 - w t) cos(theta) theta'' - m (l0 - w t) sin(theta) theta'^2"
        " - 2 m w cos(theta) theta' = F",
        "cos(theta) x'' + (l0 - w t) theta'' - 2 w theta' + g sin(theta) = 0",
    ],
    "elastic_pendulum": [
        "m r'' - m r theta'^2 + k (r - l0) - m g cos(theta) = 0",
        "m r^2 theta'' + 2 m r r' theta' + m g r sin(theta) = 0",
    ],
    "spherical_pendulum": [
        "theta'' - sin(theta) cos(theta) phi'^2 + g sin(theta)/l = 0",
        "sin(theta)^2 phi'' + 2 sin(theta) cos(theta) theta' phi' = 0",
    ],
    "kepler_orbit": ["r^2 phi'' + 2 r r' phi' = 0", "r'' - r phi'^2 + mu/r^2 = 0"],
    "bead_on_hoop": ["theta'' + (g/R - W^2 cos(theta)) sin(theta) = 0"],
    "kapitza_pendulum": ["q'' + (g - A W^2 cos(W t)) sin(q)/l = 0"],
    "double_atwood_machine": [
        "(m1 + m2 + m3) x'' + (m3 - m2) y'' + (m2 + m3 - m1) g = 0",
        "(m3 - m2) x'' + (m2 + m3) y'' + (m3 - m2) g = 0",
    ],
    "furuta_pendulum": [
        "((M + 3 m) r^2 + 3 m l^2 sin(theta)^2) alpha'' + 3 m r l cos(theta) theta''"
        " + 6 m l^2 sin(theta) cos(theta) alpha' theta' - 3 m r l sin(theta) theta'^2 = 3 tau",
        "r cos(theta) alpha'' + l theta'' - l sin(theta) cos(theta) alpha'^2 + g sin(theta) = 0",
    ],
    "rotating_plate": ["m (a^2 + b^2) theta'' + 3 k theta = 0"],
    "swinging_atwood_machine": [
        "(M + m) r'' - m r theta'^2 + M g - m g cos(theta) = 0",
        "r^2 theta'' + 2 r r' theta' + g r sin(theta) = 0",
    ],
    "bars_and_springs_small": ["q'' + 36 k q/(17 m) = 0"],
    "particle_on_circle_x": ["x'' + x x'^2/(R^2 - x^2) = 0"],
    "slider_crank": [
        "m1 r^2 theta''/3 - (r sin(theta) + l sin(theta + beta)) lambda_B_x"
        " + (r cos(theta) + l cos(theta + beta)) lambda_B_z + m1 g r cos(theta)/2 = 0",
        "sin(theta + beta) lambda_B_x - cos(theta + beta) lambda_B_z = 0",
        "m2 x'' - lambda_B_x = 0",
        "x - r cos(theta) - l cos(theta + beta) = 0",
        "r sin(theta) + l sin(theta + beta) = 0",
    ],
    "base_excited_mass": ["u'' + c u'/m + k u/m = X W^2 sin(W t)"],
}
"""Equations as the catalogue's sources or their like write them."""


def count_signs(text: str) -> int:
    """Count what an equation is written with, brackets apart."""
    return len(re.findall(r"\d[\d.]*(?:e[-+]?\d+)?|[^\W\d]\w*'*|[-+/^]", text))


@pytest.mark.parametrize("name", textbook.names())
def test_the_equations_of_no_system_grow(name: str) -> None:
    equations = derive(textbook.load(name))
    if equations.symbolic:
        counted = sum(count_signs(equation.text()) for equation in equations.equations)
        assert name in SIGNS, f"enter {counted} signs for {name}"
        assert counted <= SIGNS[name]
    else:
        assert name not in SIGNS


@pytest.mark.parametrize("name", EXPERTS)
def test_ours_are_at_most_as_long_as_the_experts(name: str) -> None:
    mechanism = textbook.load(name)
    equations = derive(mechanism)
    rng = np.random.default_rng(5)
    values: dict[str, Any] = {name: rng.uniform(0.5, 2.0) for name in mechanism.values}
    values |= {generator.name: rng.uniform(0.3, 1.2, 9) for generator in _moving(equations)}
    for ours, expert in zip(equations.equations, EXPERTS[name], strict=True):
        printed = ours.text()
        assert count_signs(printed) <= count_signs(expert), printed
        ratio = residual(printed, values) / residual(expert, values)
        np.testing.assert_allclose(ratio, ratio[0], rtol=1e-9, atol=0, err_msg=printed)


def _moving(equations: Equations) -> list[Generator]:
    algebra = equations.derivation.algebra
    return [g for g in algebra.ring.generators if g.name not in algebra.mechanism.values]


def test_foucaults_rows_are_half_as_long_as_they_were() -> None:
    rows = [equation.text() for equation in derive(textbook.load("foucault_pendulum")).equations]
    assert rows[0] == (
        "l cos(beta)^2 alpha'' - 2 l sin(beta) cos(beta) alpha' beta'"
        " - 2 l W cos(alpha) cos(beta)^2 beta'"
        " + (g - l W^2 cos(alpha) cos(beta)) sin(alpha) cos(beta) = 0"
    )
    assert "2 beta" not in rows[1]


def test_radicals_are_reduced_and_each_spring_is_one_product() -> None:
    (row,) = derive(textbook.load("bars_and_springs")).equations
    assert row.text().endswith(
        " + k (2 l q/sqrt(16 l^2 - q^2) + a) (1 - a/rho)"
        " + 4 k (4 l q/sqrt(16 l^2 - q^2) - a) (1 - a/rho2) = 0"
    )
    assert row.text().startswith("34 m l^2 (q'' + q q'^2/(16 l^2 - q^2))/(16 l^2 - q^2) + k ")


def test_radicals_are_reduced_in_the_steps_too() -> None:
    text = derive(textbook.load("bars_and_springs"), method="newton_euler").text(steps=True)
    assert (
        "     a_ABC_x = -3 q q''/(4 sqrt(16 l^2 - q^2)) - 12 l^2 q'^2/(16 l^2 - q^2)^(3/2)\n"
        in text
    )
    energy = derive(textbook.load("bars_and_springs")).text(steps=True)
    assert (
        "     E = 17 m l^2 q'^2/(2 (16 l^2 - q^2)) + k (rho - a)^2/2 + k (rho2 - a)^2\n" in energy
    )


def test_inertias_are_collected_by_their_letters() -> None:
    row = derive(textbook.load("planetary_gear")).equations[1].text()
    assert row.startswith(
        "(Ja rp^2 + 4 Jr (rs + rp)^2 rp^2/(rs + 2 rp)^2 + m (rs + rp)^2 rp^2 + Jp (rs + rp)^2) arm'"
    )


@pytest.mark.parametrize(
    ("name", "method"),
    [
        ("foucault_pendulum", "newton_euler"),
        ("two_wheeled_cart", "newton_euler"),
        ("governor", "virtual_work"),
    ],
)
def test_no_step_writes_one_less_a_square(name: str, method: str) -> None:
    """1 - cos(x)^2 is sin(x)^2, also where a product shares the cosine."""
    text = derive_system(name, method).text(steps=True)
    assert not re.search(r"\(1 - (?:sin|cos)\(\w+\)\^2\)|\((?:sin|cos)\(\w+\)\^2 - 1\)", text)


def test_a_reaction_has_the_form_of_an_expert() -> None:
    """What the bob of Foucault's pendulum needs beside moments about its hinges.

    No double angles where single ones are as short.
    """
    balances = NewtonEuler(textbook.load("foucault_pendulum")).balances
    (bob,) = balances.bodies
    whole = needs(bob)
    for rate in balances.rates:
        if rate.body == bob.body:
            whole = whole - rate.wrench * rate.component(whole)
    moment = expression(component(bob.axes.turns[0], whole.moment)).write(Text())
    expert = (
        "m l^2 sin(beta)^2 cos(beta) alpha'' - 2 m l^2 sin(beta)^3 alpha' beta'"
        " - 2 m l^2 W sin(beta)^2 cos(alpha) cos(beta) beta'"
        " + m l (g - l W^2 cos(alpha) cos(beta)) sin(alpha) sin(beta)^2"
    )
    assert count_signs(moment) <= count_signs(expert)
    assert "2 beta" not in moment


def test_the_energy_of_a_heavy_top_is_a_sum_of_squares() -> None:
    """½ I₁ (θ'² + φ'² sin²θ) + ½ I₃ (ψ' + φ' cos θ)² (Landau & Lifshitz, Mechanics, sect. 35)."""
    text = derive(textbook.load("heavy_top")).text(steps=True)
    for line in (
        "T = 3 m (r^2 + 4 h^2) (theta'^2 + sin(theta)^2 phi'^2)/40"
        " + 3 m r^2 (psi' + cos(theta) phi')^2/20",
        "p_phi = 3 m (r^2 + 4 h^2) sin(theta)^2 phi'/20"
        " + 3 m r^2 (psi' + cos(theta) phi') cos(theta)/10",
        "p_psi = 3 m r^2 (psi' + cos(theta) phi')/10",
    ):
        assert f" {line}\n" in text
