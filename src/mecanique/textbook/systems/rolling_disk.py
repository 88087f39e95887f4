"""Disk rolling down an incline.

A homogeneous disk of mass m and radius R rolls down an incline of slope alpha without slip, upright
and straight, under gravity g. Rolling along a line is a holonomic constraint: the disk turns by x /
R, where the generalized coordinate x is the distance its center has moved down the slope.
"""

from numpy import sin

from mecanique.model import (
    Body,
    Box,
    Coordinates,
    Mechanism,
    Parameter,
    Placement,
    Prismatic,
    Revolute,
    Visual,
    coordinate,
    disk,
    massless,
)
from mecanique.textbook.facts import Acceleration, Conserved, KineticEnergy, MassMatrix, Solution
from mecanique.textbook.system import System

QUARTER = 1.5707963267948966


def build(m: Parameter, R: Parameter, alpha: Parameter, g: Parameter) -> Mechanism:
    """Return the disk; its center slides along the slope and it turns as it goes."""
    slope = Visual(Box((6.0, 0.5, 0.02)), Placement((0, 0, 0), (0, alpha, 0)), (0.8, 0.8, 0.8, 1.0))
    # a box without mass lets the turning of the disk be seen
    mark = massless(Visual(Box((0.2 * R, 0.06, 1.6 * R)), rgba=(0.9, 0.6, 0.0, 1.0)))
    return Mechanism(
        name="rolling_disk",
        bodies=(
            Body("ground", massless(slope)),
            Body("center"),
            Body("disk", disk(m, R, 0.05).at(rpy=(QUARTER, 0, 0)), mark),
        ),
        joints=(
            Prismatic(
                "slide",
                "ground",
                "center",
                axis=(1, 0, 0),
                origin=Placement(rpy=(0, alpha, 0)),
                coordinate="x",
            ),
            Revolute(
                "roll",
                "center",
                "disk",
                axis=(0, 1, 0),
                origin=Placement((0, 0, R)),
                coordinate="turn",
            ),
        ),
        coordinates=Coordinates(("x",), {"turn": coordinate("x") / R}),
        parameters=(m, R, alpha, g),
        gravity=(0, 0, -g),
    )


SYSTEM = System(
    title="Disk that rolls down an incline without slip",
    source="Goldstein, Classical Mechanics, sect. 2.4 (hoop); Landau & Lifshitz, Mechanics, "
    "sect. 32",
    parameters=(
        Parameter("m", 1.0, "kg", "mass of the disk"),
        Parameter("R", 0.3, "m", "radius of the disk"),
        Parameter("alpha", 0.3, "rad", "slope of the incline"),
        Parameter("g", 9.81, "m/s²", "acceleration of free fall"),
    ),
    build=build,
    start={"x": -1.8},
    start_velocity={"x": -1.0},
    duration=2.5,
    tags=("planar", "rolling", "linear", "mimic"),
    facts=(
        Acceleration("x'' = 2 g sin(alpha) / 3", lambda s: [2 * s.g * sin(s.alpha) / 3]),
        MassMatrix("M = 3 m / 2", lambda s: [[1.5 * s.m]]),
        KineticEnergy("T = m x'² / 2 + m R² (x' / R)² / 4", lambda s: 0.75 * s.m * s["x'"] ** 2),
        Solution(
            "x = x0 + x0' t + g sin(alpha) t² / 3",
            {"x": -1.0, "x'": -2.0},
            lambda s: {"x": -1.0 - 2.0 * s.t + s.g * sin(s.alpha) * s.t**2 / 3},
            until=lambda s: 2.0,
        ),
        Conserved(
            "the energy 3 m x'² / 4 - m g x sin(alpha)",
            lambda s: 0.75 * s.m * s["x'"] ** 2 - s.m * s.g * s.x * sin(s.alpha),
        ),
    ),
)
