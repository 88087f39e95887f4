"""Routh's reduction: closed forms, the full equations, and the refusals."""

from __future__ import annotations

import re
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from click.testing import CliRunner
from derivation_reading import residual, value_of_text
from sympy import Symbol, sin

import mecanique as mq
from mecanique import textbook
from mecanique.cli import app
from mecanique.derivation.printing.equations import expression
from mecanique.derivation.symbolic.derivation import Left

RATE = Symbol("x'")

WITH_CYCLIC = {
    "dumbbell": ("x", "y", "phi"),
    "free_particle": ("x", "y"),
    "free_planar_body": ("x", "theta"),
    "gyroscope": ("phi", "psi"),
    "heavy_top": ("phi", "psi"),
    "kepler_orbit": ("phi",),
    "particle_on_circle": ("theta",),
    "spherical_pendulum": ("phi",),
}

PRINTED = {
    "spherical_pendulum": (
        "m l^2 theta'' - p_phi^2 cos(theta)/(m l^2 sin(theta)^3) + m g l sin(theta) = 0"
    ),
    "kepler_orbit": "m r'' - p_phi^2/(m r^3) + m mu/r^2 = 0",
    "heavy_top": (
        "3 m (r^2 + 4 h^2) theta''/20 + 20 (p_phi - p_psi cos(theta)) (p_psi - p_phi cos(theta))"
        "/(3 m (r^2 + 4 h^2) sin(theta)^3) - 3 m g h sin(theta)/4 = 0"
    ),
}
"""As in Landau and Lifshitz, Mechanics, sects. 14 (problem 1) and 35 (problem 1)."""


@pytest.mark.parametrize("name", WITH_CYCLIC)
def test_reduced_equations_hold_along_motions_of_the_full_ones(name: str) -> None:
    reduced = mq.routh(textbook.load(name))
    assert reduced.cyclic == WITH_CYCLIC[name]
    assert reduced.momenta == tuple(f"p_{q}" for q in WITH_CYCLIC[name])
    assert len(reduced.equations) == reduced.mechanism.nv - len(reduced.cyclic)
    assert reduced.compare() < 1e-9


@pytest.mark.parametrize("name", PRINTED)
def test_printed_as_in_the_books(name: str) -> None:
    (equation,) = mq.routh(textbook.load(name)).equations
    assert str(equation) == PRINTED[name]


def test_what_is_printed_reads_back() -> None:
    mechanism = textbook.load("gyroscope")
    reduced = mq.routh(mechanism)
    values = reduced._compute_states(5, np.random.default_rng(3))
    (equation,) = map(str, reduced.equations)
    assert np.abs(residual(equation, values)).max() < 1e-10
    wrong = {**values, "p_phi": 1.001 * values["p_phi"]}
    assert np.abs(residual(equation, wrong)).max() > 1e-6


def coupled(P: mq.Parameter, damped: bool = True) -> mq.Mechanism:
    """A cart that nothing pushes, with a pendulum whose hinge is damped, and a turning disk."""
    m, M, l, c, g = (
        mq.Parameter("m", 0.7, "kg"),
        mq.Parameter("M", 2.0, "kg"),
        mq.Parameter("l", 1.2, "m"),
        mq.Parameter("c", 0.3, "N·m·s/rad"),
        mq.Parameter("g", 9.81, "m/s²"),
    )
    return mq.Mechanism(
        "coupled",
        (
            mq.Body("ground"),
            mq.Body("cart", mq.particle(M)),
            mq.Body("bob", mq.particle(m, (0, 0, -l))),
        ),
        (
            mq.Prismatic("rail", "ground", "cart", axis=(1, 0, 0), coordinate="x"),
            mq.Revolute("pin", "cart", "bob", axis=(0, -1, 0), coordinate="q"),
        ),
        forces=(mq.JointDamper("damper", "pin" if damped else "rail", c),),
        parameters=(m, M, l, c, g, P),
        gravity=(0, 0, -g),
    )


def test_coupled_velocities_and_a_damper_on_another_coordinate() -> None:
    reduced = mq.routh(coupled(mq.Parameter("p_x", 1.0)))
    assert (reduced.cyclic, reduced.momenta) == (("x",), ("P_x",))
    assert reduced.compare() < 1e-9
    assert "∂D/∂q'" in reduced.text()


def test_a_cyclic_coordinate_along_a_track_that_shakes() -> None:
    """T has terms that are linear in x', which are part of p_x."""
    cart = coupled(mq.Parameter("p_x", 1.0))
    shaken = replace(
        cart,
        bodies=(*cart.bodies, mq.Body("track")),
        joints=(
            mq.Prismatic("shaker", "ground", "track", axis=(1, 0, 0), coordinate="X"),
            replace(cart.joint("rail"), parent="track"),
            cart.joint("pin"),
        ),
        coordinates=mq.Coordinates((), {"X": 0.1 * sin(5 * mq.time())}),
    )
    reduced = mq.routh(shaken)
    assert reduced.cyclic == ("x",)
    assert reduced.compare() < 1e-9


def test_a_wide_denominator_is_written_in_latex() -> None:
    written = mq.routh(textbook.load("gyroscope")).latex()
    assert "\\frac{" in written
    assert "\\frac{1}{" not in written  # the letters of a product stay over its denominator
    assert "Equations of motion" in written


def test_what_is_driven_keeps_no_momentum() -> None:
    free = coupled(mq.Parameter("P", 1.0))
    pushed, by_speed = mq.JointForce("drive", "rail", 2.0), mq.JointForce("drive", "pin", RATE)
    for drive in (pushed, by_speed):
        with pytest.raises(
            mq.DerivationError, match="has no cyclic coordinate: T or V depends on each of x, q,"
        ):
            mq.routh(replace(free, forces=(drive,)))


def test_no_cyclic_coordinate_is_said() -> None:
    with pytest.raises(
        mq.DerivationError, match="has no cyclic coordinate: T or V depends on each of q1, q2,"
    ):
        mq.routh(textbook.load("double_pendulum"))
    with pytest.raises(mq.DerivationError, match="got constraints on them"):
        mq.routh(textbook.load("slider_crank"))


def test_the_command_prints_steps_and_a_document() -> None:
    text = CliRunner().invoke(app, ["derive", "particle_on_circle", "--routh", "--steps"]).output
    assert "p_theta = m R^2 theta'" in text
    assert "momentum of theta, constant [kg·m²/s]" in text
    assert "No equation of motion is left to solve." in " ".join(text.split())
    assert "Beware: R stands for" in text
    found = CliRunner().invoke(app, ["derive", "heavy_top", "--routh", "--document"])
    assert found.output.startswith("\\documentclass")
    assert "relative difference of" in found.output
    none = CliRunner().invoke(app, ["derive", "double_pendulum", "--routh"])
    assert none.exit_code == 2
    assert "no cyclic coordinate" in none.output


def test_the_effective_potential_is_minus_routh_s_function_at_rest() -> None:
    """Goldstein, sect. 3.3: V_eff = l²/(2 m r²) + V; it is explained among the symbols."""
    text = mq.routh(mq.textbook.load("kepler_orbit")).text(steps=True)
    assert "V_eff = p_phi^2/(2 m r^2) - m mu/r" in text
    assert "R = m r'^2/2 - p_phi^2/(2 m r^2) + m mu/r" in text
    assert re.search(r"V_eff +effective potential \[J\]", text)


def test_momenta_have_the_units_of_their_coordinates() -> None:
    text = mq.routh(coupled(mq.Parameter("k", 1.0))).text(steps=True)
    assert "momentum of x, constant [kg·m/s]" in text
    assert "momentum of phi, constant [kg·m²/s]" in mq.routh(textbook.load("kepler_orbit")).text()


@pytest.mark.parametrize("name", ["heavy_top", "spherical_pendulum"])
def test_a_wrong_reduction_is_told_by_the_full_equations(name: str) -> None:
    reduced = mq.routh(textbook.load(name))
    ((inertia, *rest),) = reduced.found.parts
    for parts in ((1.001 * inertia, *rest), (inertia, *(-part for part in rest))):
        found = replace(reduced.found, parts=(parts,))
        assert replace(reduced, found=found).compare(8) > 1e-5
    first, *others = reduced.found.ignored
    found = replace(reduced.found, ignored=(replace(first, inertia=2 * first.inertia), *others))
    assert replace(reduced, found=found).compare(8) > 1e-5


@pytest.mark.parametrize("name", WITH_CYCLIC)
def test_each_step_is_printed_with_its_value(name: str) -> None:
    """The Routhian, the effective potential and the energy are sums that are printed by parts."""
    random, values = np.random.default_rng(3), dict[str, Any]()
    for stage in mq.routh(textbook.load(name)).document.derivation.stages:
        for result in stage.results:
            usual, printed = expression(result.right).text(), result.expression().text()
            letters = re.findall(r"[^\W\d]\w*'*(?![\w'(])", f"{usual} {printed}")
            for letter in sorted({*letters} - values.keys()):
                values[letter] = random.uniform(0.5, 1.5)
            value = value_of_text(usual, values)
            assert value_of_text(printed, values) == pytest.approx(value, rel=1e-12), printed
            if isinstance(result.left, Left) and not result.left.by:
                values[result.left.quantity] = value  # a later line may be in it


def test_the_energy_contains_the_potential_of_a_constant_load() -> None:
    m, P = mq.Parameter("m", 2.0, "kg"), mq.Parameter("P", 3.0, "N")
    bead = mq.Mechanism(
        "bead",
        (mq.Body("ground"), mq.Body("arm", mq.massless()), mq.Body("bead", mq.particle(m))),
        (
            mq.Revolute("turn", "ground", "arm", axis=(0, 0, 1), coordinate="phi"),
            mq.Prismatic("slide", "arm", "bead", axis=(1, 0, 0), coordinate="r"),
        ),
        forces=(mq.JointForce("push", "slide", P),),
        parameters=(m, P),
        gravity=(0, 0, 0),
    )
    text = mq.derive(bead).text(steps=True)
    assert "with the potential -P r of the constant load," in " ".join(text.split())
    assert "    E = m (r'^2 + r^2 phi'^2)/2 - P r\n" in text
    assert "    E = m r'^2/2 - P r + V_eff\n" in text
    # to the judge it is an integral, and neither it nor V is one without the load
    assert mq.check(bead, "m r^2 phi'^2/2 + m r'^2/2 - P r", "conserved quantity").right
    assert not mq.check(bead, "m r^2 phi'^2/2 + m r'^2/2", "conserved quantity").right
    # what time gives is no constant load
    timed = replace(bead, forces=(mq.JointForce("push", "slide", P * mq.cos(mq.time())),))
    assert "E =" not in mq.derive(timed).text(steps=True)
