"""Bodies are cut free as in a book: in axes that do not spin, with the reactions that act."""

from __future__ import annotations

import re
from functools import cache

import numpy as np
import pytest
from systems import derive_system

import mecanique as mq
from mecanique.derivation.scalars.evaluation import Evaluation
from mecanique.derivation.symbolic.cutting import Axes
from mecanique.derivation.symbolic.newton_euler import NewtonEuler
from mecanique.derivation.symbolic.symbols import Algebra
from mecanique.derivation.symbolic.vectors import SymbolicWrench

NEWTON_EULER, VIRTUAL_WORK = "newton_euler", "virtual_work"


@cache
def lines_of(name: str, method: str = NEWTON_EULER) -> list[str]:
    """The lines of formulas of a derivation."""
    text = derive_system(name, method).text(steps=True)
    return [line.strip() for line in text.splitlines() if line.startswith("     ")]


@cache
def said_in(name: str, method: str = NEWTON_EULER) -> str:
    """The words of a derivation in one line."""
    return " ".join(derive_system(name, method).text(steps=True).split())


@pytest.mark.parametrize("method", [NEWTON_EULER, VIRTUAL_WORK])
@pytest.mark.parametrize(
    ("name", "angle"), [("heavy_top", "psi"), ("gyroscope", "psi"), ("rolling_coin", "spin")]
)
def test_the_angle_of_a_spin_is_in_no_balance(name: str, angle: str, method: str) -> None:
    assert not any(re.search(rf"(sin|cos)\([^)]*{angle}", line) for line in lines_of(name, method))


def test_a_heavy_top_has_eulers_equations_in_nodal_axes() -> None:
    """Goldstein, Classical Mechanics, 3rd ed., sect. 5.7, with I₁ about the apex."""
    lines = lines_of("heavy_top")
    for line in (
        "H_top_x = 3 m (r^2 + 4 h^2) theta'/20",
        "H_top_y = 3 m (r^2 + 4 h^2) sin(theta) phi'/20",
        "H_top_z = 3 m r^2 cos(theta) phi'/10 + 3 m r^2 psi'/10",
        "3 m (r^2 + 4 h^2) theta''/20 + 3 m (r^2 - 4 h^2) sin(theta) cos(theta) phi'^2/20"
        " + 3 m r^2 sin(theta) phi' psi'/10 = 3 m g h sin(theta)/4",
        "3 m (r^2 + 4 h^2) sin(theta) phi''/20 + 6 m h^2 cos(theta) phi' theta'/5"
        " - 3 m r^2 theta' psi'/10 = 0",
        "3 m r^2 cos(theta) phi''/10 + 3 m r^2 psi''/10 - 3 m r^2 sin(theta) phi' theta'/10 = 0",
    ):
        assert line in lines
    assert "the axes of the tilted, which do not spin with the top: it is symmetric" in said_in(
        "heavy_top"
    )


def test_bodies_without_mass_are_joined_to_one_joint() -> None:
    reactions = derive_system("heavy_top", NEWTON_EULER).derivation.reactions
    assert [*reactions] == ["R_psi_x", "R_psi_y", "R_psi_z"]
    for method in (NEWTON_EULER, VIRTUAL_WORK):
        said = said_in("heavy_top", method)
        assert (
            "The bodies precessing and tilted have no mass, and nothing else acts on them: the "
            "joints phi, theta and psi together join the top to the ground."
        ) in said
        assert "Free body tilted" not in said
        assert "Equilibrium of tilted" not in said


def test_a_rolling_coin_has_the_forces_along_the_ground_and_moments_in_nodal_axes() -> None:
    """Appell: m x'' = X, m y'' = Y, m z'' = N - m g, and Euler's equations without the spin."""
    lines = lines_of("rolling_coin")
    for line in (
        "m x'' = lambda_rim_x",
        "m z'' = lambda_rim_normal - m g",
        "H_coin_y = m r^2 sin(lean) yaw'/2 + m r^2 spin'/2",
        "m r^2 cos(lean) yaw''/4 + m r^2 lean' spin'/2 = 0",
    ):
        assert line in lines


def test_a_planet_has_the_radial_and_the_transverse_equation_and_no_reaction() -> None:
    """Goldstein, Classical Mechanics, 3rd ed., eqs. 3.7, 3.11."""
    lines = lines_of("kepler_orbit")
    assert "m r'' - m r phi'^2 = -m mu/r^2" in lines
    assert "m r phi'' + 2 m phi' r' = 0" in lines
    assert not derive_system("kepler_orbit", NEWTON_EULER).derivation.reactions
    assert "transmit" not in said_in("kepler_orbit")
    assert "reaction" not in said_in("kepler_orbit", VIRTUAL_WORK)


def test_a_particle_on_a_rod_is_held_along_the_rod_alone() -> None:
    assert [*derive_system("spherical_pendulum", NEWTON_EULER).derivation.reactions] == [
        "R_swing_z"
    ]
    assert not any("H_bob" in line for line in lines_of("spherical_pendulum"))


def test_a_rolling_disk_has_the_forces_along_and_across_its_incline_alone() -> None:
    """Goldstein, Classical Mechanics, sect. 2.4: weight, normal force and friction."""
    lines = lines_of("rolling_disk")
    assert "m x'' = lambda_contact_x + m g sin(alpha)" in lines
    assert "m z'' = lambda_contact_normal - m g cos(alpha)" in lines
    assert not any("lambda_contact_y" in line or "R_roll" in line for line in lines)


def test_atwoods_tensions_contain_no_acceleration_in_the_end() -> None:
    """Goldstein, Classical Mechanics, sect. 1.6, with the inertia of the pulley."""
    lines = lines_of("atwood_machine")
    assert lines[-3:-1] == [
        "T_cord_1 = m1 (4 m2 + M) g/(2 m1 + 2 m2 + M)",
        "T_cord_2 = (4 m1 + M) m2 g/(2 m1 + 2 m2 + M)",
    ]
    assert "R_pin_t = m g sin(q)/4" in lines_of("rigid_bar_pendulum")


def test_a_cord_works_on_each_body_and_not_in_total() -> None:
    lines = lines_of("atwood_machine", VIRTUAL_WORK)
    assert "δW_T_cord_1 = -T_cord_1 δx + T_cord_1 δx" in lines
    assert "δW_T_cord_2 = T_cord_2 δx - T_cord_2 δx" in lines
    derivation = derive_system("atwood_machine", VIRTUAL_WORK).derivation
    (works,) = [s for s in derivation.stages if s.title == "Virtual work of the reactions"]
    assert all(line.right.vanishes() for line in works.results)


@pytest.mark.parametrize(
    ("name", "reason"),
    [
        ("rigid_bar_pendulum", "is free; nothing acts out of the plane of the motion."),
        (
            "atwood_machine",
            "out of the plane of the motion; no body needs R_axle_x.",
        ),
        ("spherical_pendulum", "is free; no body needs"),
    ],
)
def test_components_that_vanish_are_explained_once(name: str, reason: str) -> None:
    said = said_in(name)
    assert said.count("Components that are not listed are zero: no joint transmits anything") == 1
    assert reason in said


def test_across_a_plane_are_the_force_along_its_normal_and_the_moments_in_it() -> None:
    units = np.eye(3).tolist()
    flat = Axes(units, units, "", ("n", "t", "k"), ("n", "t", ""))
    across = [(d.kind, d.place) for d in flat.directions if flat.across_plane(d)]
    assert across == [("force", 2), ("moment", 0), ("moment", 1)]
    in_space = Axes(units, units, "")
    assert not any(map(in_space.across_plane, in_space.directions))


@pytest.mark.parametrize(
    "name",
    [
        "rigid_bar_pendulum",
        "simple_pendulum",
        "double_pendulum",
        "cart_pole",
        "elastic_pendulum",
        "kepler_orbit",
        "heavy_top",
        "gyroscope",
        "spherical_pendulum",
        "furuta_pendulum",
        "foucault_pendulum",
    ],
)
def test_the_engine_finds_the_same_forces_in_every_joint(name: str) -> None:
    """What is dropped is zero, and what passes through bodies without mass is what they pass on."""
    mechanism = mq.textbook.load(name)
    derived, reference = NewtonEuler(mechanism), mq.Reference(mechanism)
    ring, balances = derived.algebra.ring, derived.balances
    rng = np.random.default_rng(5)
    for _ in range(3):
        q, v = rng.uniform(0.2, 1.2, (2, mechanism.nv))
        a = reference.acceleration(q, v)
        values = {**mechanism.values, "t": 0.0}
        names = zip(mechanism.coordinates, q, v, a, strict=True)
        for coordinate, *moving in names:
            values |= {coordinate + "'" * k: float(x) for k, x in enumerate(moving)}
        value = Evaluation(ring, values)
        values |= {letter: value(series) for letter, series in balances.reactions.items()}
        value = Evaluation(ring, values)
        wanted = reference.reactions(q, v)
        for cut in derived.cuts.bodies:
            wrench: SymbolicWrench = balances.symbols[cut.body]
            given = wanted[cut.joint.name]
            ours = [value(part) for part in (*wrench.force, *wrench.moment)]
            theirs = [*given.force, *given.moment]
            scale = max(1.0, float(np.abs(theirs).max()))
            assert np.abs(np.subtract(ours, theirs)).max() < 1e-9 * scale, cut.joint.name


def test_equal_lengths_are_not_taken_for_one_where_reactions_are_sought() -> None:
    """Two lengths of 1 m are two letters, and may differ."""
    arm = mq.textbook.load("double_pendulum")
    assert arm.values["l1"] == arm.values["l2"]
    values = Algebra(arm).generic
    assert values["l1"] != values["l2"]
    assert all(values.values())
