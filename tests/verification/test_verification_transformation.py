"""Equations in different generalized coordinates are compared through the map between them."""

from __future__ import annotations

from dataclasses import replace

import pytest
from sympy import acos, cos, sin

from mecanique import textbook
from mecanique.errors import InputError, UnknownNameError
from mecanique.model import (
    Body,
    Coordinates,
    JointDamper,
    JointForce,
    JointSpring,
    Mechanism,
    Prismatic,
    Revolute,
    box,
    coordinate,
    particle,
    time,
)
from mecanique.verification import compare_coordinates


def test_the_double_pendulum_in_absolute_and_in_relative_angles() -> None:
    absolute = textbook.load("double_pendulum")
    relative = replace(absolute, name="relative", coordinates=Coordinates(()))
    found = compare_coordinates(absolute, relative, {"q2": coordinate("q1") + coordinate("theta2")})
    assert found.agrees, str(found)
    assert max(found.worst.values()) < 1e-12
    assert found.jacobian == ((1, 0), (1, 1))
    assert "q2 = q1 + theta2" in str(found)
    assert "agree at 100 random states" in str(found)


def test_the_particle_on_a_circle_by_its_angle_and_by_its_abscissa() -> None:
    by_angle, by_abscissa = (
        textbook.load("particle_on_circle"),
        textbook.load("particle_on_circle_x"),
    )
    found = compare_coordinates(by_angle, by_abscissa, {"theta": acos(coordinate("x") / 1.0)})
    assert found.agrees, str(found)
    back = compare_coordinates(by_abscissa, by_angle, {"x": cos(coordinate("theta"))}, samples=20)
    # near x = ±R the chart ends, and numbers cancel
    assert max(back.worst.values()) < 1e-7, str(back)
    assert str(back.jacobian[0][0]) == "-sin(theta)"


def test_a_coordinate_may_be_held() -> None:
    free = textbook.load("free_particle")
    held = replace(free, name="held", coordinates=Coordinates(("x", "y"), {"z": 0.4}))
    found = compare_coordinates(free, held, {"z": 0.4}, samples=10)
    assert found.agrees, str(found)
    assert found.jacobian == ((1, 0), (0, 1), (0, 0))


def test_a_map_that_depends_on_time() -> None:
    """A free particle seen from a lift that moves steadily: the same equations."""
    particle = textbook.load("free_particle")
    found = compare_coordinates(particle, particle, {"z": coordinate("z") + 3.0 * time()})
    assert found.agrees, str(found)


def test_springs_and_dampers_pull_alike_in_both_coordinates() -> None:
    forces = (JointSpring("spring", "joint", 3.0), JointDamper("damper", "joint", 0.4))
    joint = Revolute("joint", "ground", "rod", axis=(0, 1, 0), coordinate="q")
    rod = Body("rod", box(1.0, (0.1, 0.1, 0.1)))
    mechanism = Mechanism("sprung", (Body("ground"), rod), (joint,), forces)
    doubled = replace(
        mechanism, name="half", coordinates=Coordinates(("x",), {"q": 2 * coordinate("x")})
    )
    found = compare_coordinates(mechanism, doubled, {"q": 2 * coordinate("x")}, samples=10)
    assert found.agrees, str(found)


@pytest.mark.parametrize("mass", [9.0, 1e-4])
def test_terms_are_judged_by_the_moving_mass(mass: float) -> None:
    """Where nothing else acts, by a thousandth of its weight at 1 m/s²."""
    slide = Prismatic("slide", "ground", "block", axis=(1, 0, 0), coordinate="x")
    block = Body("block", particle(mass))
    free = Mechanism("free", (Body("ground"), block), (slide,))
    pushed = replace(free, name="pushed", forces=(JointForce("push", "slide", 2e-4 * mass),))
    found = compare_coordinates(free, pushed, {}, samples=3)
    assert found.worst["all other terms"] == pytest.approx(0.2, rel=1e-9)


def test_another_system_does_not_agree() -> None:
    absolute = textbook.load("double_pendulum")
    heavier = replace(absolute.replace(m2=1.1), coordinates=Coordinates(()))
    found = compare_coordinates(
        absolute, heavier, {"q2": coordinate("q1") + coordinate("theta2")}, samples=5
    )
    assert not found.agrees
    assert "DISAGREE" in str(found)


def test_what_cannot_be_compared_is_refused() -> None:
    pendulum = textbook.load("double_pendulum")
    with pytest.raises(UnknownNameError, match="unknown coordinate 'q3'"):
        compare_coordinates(pendulum, pendulum, {"q3": 1.0})
    with pytest.raises(UnknownNameError, match="symbol in the map of 'q1' 'x'"):
        compare_coordinates(pendulum, pendulum, {"q1": sin(coordinate("x"))})
    with pytest.raises(InputError, match="quaternion"):
        compare_coordinates(textbook.load("free_rigid_body"), textbook.load("free_rigid_body"), {})
    with pytest.raises(InputError, match="no finite value"):
        compare_coordinates(pendulum, pendulum, {"q1": acos(2 + coordinate("q1") ** 2)})
