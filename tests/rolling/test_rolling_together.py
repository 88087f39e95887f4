"""What rolls, together with springs and cords."""

from __future__ import annotations

import numpy as np
import pytest

from mecanique import (
    Body,
    Coordinates,
    Cord,
    Mechanism,
    Placement,
    Prismatic,
    Pulley,
    Reference,
    Revolute,
    Rolling,
    Spring,
    coordinate,
    derive,
    disk,
    particle,
    simulate,
    verify,
)

MASS, RADIUS, LOAD, STIFFNESS, G = 2.0, 0.3, 0.7, 25.0, 9.81
QUARTER = 1.5707963267948966


def hauled() -> Mechanism:
    """A disk that rolls, held by a spring, pulled by a weight on a cord over an eye."""
    return Mechanism(
        "hauled",
        (
            Body("ground"),
            Body("hub"),
            Body("disk", disk(MASS, RADIUS).at(rpy=(QUARTER, 0, 0))),
            Body("weight", particle(LOAD)),
        ),
        (
            Prismatic(
                "along",
                "ground",
                "hub",
                axis=(1, 0, 0),
                origin=Placement((0, 0, RADIUS)),
                coordinate="x",
            ),
            Revolute("axle", "hub", "disk", axis=(0, 1, 0), coordinate="spin"),
            Prismatic(
                "down",
                "ground",
                "weight",
                axis=(0, 0, -1),
                origin=Placement((3, 0, -1)),
                coordinate="w",
            ),
        ),
        forces=(Spring("spring", "ground", (-2, 0, RADIUS), "hub", (0, 0, 0), STIFFNESS, 2.0),),
        coordinates=Coordinates(("x", "spin"), {"w": coordinate("x")}),
        contacts=(Rolling("rim", "disk", RADIUS),),
        elements=(
            Cord(
                "cord",
                ("hub", (0, 0, 0)),
                (Pulley("ground", center=(3, 0, RADIUS), grips=False),),
                ("weight", (0, 0, 0)),
            ),
        ),
        gravity=(0, 0, -G),
    )


def test_a_disk_between_a_spring_and_a_cord_by_hand() -> None:
    """(3 m/2 + M) x'' = M g − k x; the cord pulls with M (g − x''), friction with m x''/2."""
    machine, x = hauled(), 0.2
    a = (LOAD * G - STIFFNESS * x) / (1.5 * MASS + LOAD)
    state = {"x": x}, {"x": 0.4, "spin": 0.4 / RADIUS}
    reference = Reference(machine)
    np.testing.assert_allclose(reference.acceleration(*state), [a, a / RADIUS], rtol=1e-12, atol=0)
    for source in (reference, derive(machine, "newton_euler")):
        forces = source.multipliers(*state)
        assert forces["rim: x"] == pytest.approx(-MASS * a / 2, rel=1e-12)
    assert reference.guide_forces(*state)["cord"] == pytest.approx(LOAD * (G - a), rel=1e-12)
    assert verify(machine, 3).agrees
    by_hand = derive(machine, "newton_euler").guide_forces(*state)["cord"]
    assert by_hand == pytest.approx(LOAD * (G - a), rel=1e-12)


def test_it_swings_as_by_its_closed_form() -> None:
    machine = hauled()
    motion = simulate(machine, duration=2.0, rtol=1e-10)
    rest = LOAD * G / STIFFNESS
    rate = np.sqrt(STIFFNESS / (1.5 * MASS + LOAD))
    np.testing.assert_allclose(
        motion["x"], rest * (1 - np.cos(rate * motion.t)), rtol=0, atol=1e-10
    )
