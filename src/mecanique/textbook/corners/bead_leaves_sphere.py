"""Particle that leaves a sphere.

A particle m slides from rest down a smooth sphere of radius R under gravity g. The generalized
coordinates are its distance r from the center of the sphere and the angle th of its radius from the
vertical. It leaves where its height is two thirds of that at which it began.
"""

from math import acos, cos, sin, sqrt

from mecanique.model import (
    Body,
    Mechanism,
    Parameter,
    Prismatic,
    Revolute,
    Stop,
    massless,
    particle,
)
from mecanique.textbook.facts import ModeAcceleration, Occurs
from mecanique.textbook.system import System


def build(
    m: Parameter,
    R: Parameter,
    g: Parameter,
) -> Mechanism:
    """Return the mechanism."""
    return Mechanism(
        name="bead_leaves_sphere",
        bodies=(Body("ground"), Body("ray", massless()), Body("bead", particle(m))),
        joints=(
            Revolute("turn", "ground", "ray", axis=(0, 1, 0), coordinate="th"),
            Prismatic("out", "ray", "bead", axis=(0, 0, 1), coordinate="r"),
        ),
        parameters=(m, R, g),
        gravity=(0, 0, -g),
        switching=(Stop("sphere", "out", at=R, side=-1),),
    )


SYSTEM = System(
    title="Particle that leaves a sphere",
    source="Goldstein, Classical Mechanics, 3rd ed., ch. 2, exercise 22",
    parameters=(
        Parameter("m", 1.0, "kg", "mass of the particle"),
        Parameter("R", 1.0, "m", "radius of the sphere"),
        Parameter("g", 9.81, "m/s²", "acceleration of free fall"),
    ),
    build=build,
    start={"th": 0.1, "r": 1.0},
    duration=1.2,
    tags=("planar", "contact", "corners"),
    facts=(
        ModeAcceleration(
            "r th'' = g sin(th) - 2 r' th' on and off the sphere",
            ("closed",),
            lambda s: [(s.g * sin(s.th) - 2 * s["r'"] * s["th'"]) / s.r, 0.0],
        ),
        Occurs(
            "it leaves where cos(th) = 2/3 cos(th_0), at sqrt(2/3 g R cos(th_0))",
            "sphere: open",
            lambda s: {
                "th": acos(2 / 3 * cos(0.1)),
                "th'": sqrt(2 / 3 * s.g * cos(0.1) / s.R),
            },
        ),
    ),
)
