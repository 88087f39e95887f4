"""Bead on a rotating hoop.

A bead m slides without friction on a circular hoop of radius R that turns at the constant rate W
about its vertical diameter, under gravity g. The generalized coordinate theta is the angle of the
bead's radius from the downward vertical. If the hoop turns fast enough, the bead leaves the bottom
for one side.
"""

from dataclasses import replace

from numpy import arccos, cos, sin, sqrt

from mecanique.model import (
    Body,
    Coordinates,
    Mechanism,
    Parameter,
    Revolute,
    particle,
    ring,
    time,
)
from mecanique.textbook.facts import Acceleration, Conserved, Frequencies, StabilityLimit, Steady
from mecanique.textbook.system import System

QUARTER = 1.5707963267948966


def build(m: Parameter, R: Parameter, W: Parameter, g: Parameter) -> Mechanism:
    """Return the hoop, which is only drawn, and its bead."""
    hoop = replace(ring(0.0, R, thickness=0.01), inertia=(0.0,) * 6).at(rpy=(QUARTER, 0, 0))
    return Mechanism(
        name="bead_on_hoop",
        bodies=(Body("ground"), Body("hoop", hoop), Body("bead", particle(m, (0, 0, -R)))),
        joints=(
            Revolute("turntable", "ground", "hoop", axis=(0, 0, 1), coordinate="turn"),
            Revolute("slide", "hoop", "bead", axis=(0, -1, 0), coordinate="theta"),
        ),
        coordinates=Coordinates(("theta",), {"turn": W * time()}),
        parameters=(m, R, W, g),
        gravity=(0, 0, -g),
    )


SYSTEM = System(
    title="Bead on a hoop that turns steadily about a vertical diameter",
    source="Taylor, Classical Mechanics, examples 7.6 and 7.7; Marsden & Ratiu, "
    "Mechanics and Symmetry, sect. 2.8",
    parameters=(
        Parameter("m", 0.1, "kg", "mass of the bead"),
        Parameter("R", 0.5, "m", "radius of the hoop"),
        Parameter("W", 6.0, "rad/s", "rate of the hoop"),
        Parameter("g", 9.81, "m/s²", "acceleration of free fall"),
    ),
    build=build,
    start={"theta": 0.1},
    tags=("planar", "prescribed motion", "rotating frame", "stability"),
    facts=(
        Acceleration(
            "theta'' = (W² cos(theta) - g / R) sin(theta)",
            lambda s: [(s.W**2 * cos(s.theta) - s.g / s.R) * sin(s.theta)],
        ),
        StabilityLimit(
            "the bottom is stable below W = sqrt(g / R)",
            "W",
            lambda s: sqrt(s.g / s.R),
            stable="below",
        ),
        Steady(
            "above it, cos(theta) = g / (W² R) is an equilibrium",
            lambda s: {"theta": arccos(s.g / (s.W**2 * s.R))},
        ),
        Frequencies(
            "about which the bead swings with ω = W sin(theta)",
            lambda s: [s.W * sqrt(1 - (s.g / (s.W**2 * s.R)) ** 2)],
            at=lambda s: {"theta": arccos(s.g / (s.W**2 * s.R))},
        ),
        Conserved(
            "Jacobi's integral R² (theta'² - W² sin²(theta)) / 2 - g R cos(theta), not the energy",
            lambda s: (
                s.R**2 * (s["theta'"] ** 2 - s.W**2 * sin(s.theta) ** 2) / 2
                - s.g * s.R * cos(s.theta)
            ),
        ),
    ),
)
