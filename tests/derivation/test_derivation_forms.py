"""Printed equations stay short: counted for every system, and compared with those of experts."""

from __future__ import annotations

import re
from collections.abc import Iterable
from dataclasses import replace

import numpy as np
import pytest
from derivation_reading import residual
from systems import derive_system

import mecanique as mq
from mecanique import derive, textbook
from mecanique.derivation.printing.equations import expression
from mecanique.derivation.printing.writers import Text
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


FORMS = [(name, line) for name in textbook.names() for line in textbook.entry(name).forms]


def printed(name: str) -> list[str]:
    """Return every line that the derivations of a system print."""
    mechanism, lines = textbook.load(name), textbook.entry(name).forms
    if name == "bricard_linkage":  # of which the loop alone is short enough, by its symmetry
        q1, q2 = mq.coordinate("q1"), mq.coordinate("q2")
        alike = mq.Coordinates(("q1", "q2"), {"q3": -q1, "q4": q2, "q5": q1})
        return str(derive(replace(mechanism, coordinates=alike))).splitlines()
    if name == "whipple_bicycle":
        ride = mq.expand_in_speed(mechanism, None, {"x": 1.0}, ("roll", "steer"))
        return [line.strip() for line in str(ride.letters).splitlines()]
    texts = [derive_system(name).text(steps=True)]
    if any(line.startswith("V_eff") for line in lines):
        texts.append(mq.routh(mechanism).text(steps=True))
    if mechanism.loops and name not in ("governor", "chained_four_bars", "squeezer"):
        texts.append(mq.reduce_loops(mechanism).text(steps=True))
    written = [line.strip() for text in texts for line in text.splitlines()]
    # what a letter stands for follows its unit
    return [part for line in written for part in {line, line.rpartition("], ")[2]}]


def is_alike(line: str, other: str, moving: Iterable[str]) -> bool:
    """Return whether two printed equations are the same but for a factor of parameters.

    A definition, such as that of T, has to have the same left side and no factor.
    """
    left = line.partition(" = ")[0]
    defines = left.isidentifier()
    if defines and other.partition(" = ")[0] != left:
        return False
    name = re.compile(r"[^\W\d]\w*'*(?![\w'(])")
    letters, others = {*name.findall(line)}, {*name.findall(other)}
    varied = {letter for letter in letters if letter.endswith("'")} | letters.intersection(moving)
    # parameters may have been divided out, nothing else
    if not others <= letters or varied - others:
        return False
    random, ratios = np.random.default_rng(5), []
    fixed = {letter: random.uniform(0.3, 1.2) for letter in sorted(letters)}
    for _ in range(4):
        values = fixed | {letter: random.uniform(-1, 1) for letter in sorted(varied)}
        ratios.append(residual(line, values) / residual(other, values))
    same = np.ptp(ratios) <= 1e-10 * abs(ratios[0])
    return bool(same and (not defines or abs(ratios[0] - 1) < 1e-10))


@pytest.mark.parametrize("name", sorted({name for name, _ in FORMS}))
def test_a_system_is_derived_in_the_form_of_its_book(name: str) -> None:
    lines = printed(name)
    equations = [line for line in lines if line.count(" = ") == 1 and "." not in line]
    moving = {*textbook.load(name).coordinates, "t"}
    for line, place in textbook.entry(name).forms.items():
        assert place
        alike = [line] if line in lines else [x for x in equations if is_alike(line, x, moving)]
        assert alike, line
        # ours is at most as long
        assert min(map(count_signs, alike)) <= count_signs(line)


def test_every_system_states_the_form_of_a_book_or_that_it_is_the_librarys() -> None:
    named = {name for name, _ in FORMS}
    plain = {name for name in textbook.names() if not textbook.load(name).switching}
    assert plain <= named
    assert not is_alike("m x'' + k x = 0", "m x'' - k x = 0", "x")
    assert not is_alike("T = m x'^2/2", "T = m x'^2", "x")
    assert not is_alike("x x'' = 0", "x'' = 0", "x")
    assert is_alike("m x''/2 + k x/2 = 0", "m x'' + k x = 0", "x")


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
