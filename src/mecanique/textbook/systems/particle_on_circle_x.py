"""Particle on a circle, located by its abscissa.

The same particle m on the same horizontal circle of radius R, perpendicular to gravity g, as in
`particle_on_circle`, with its rectangular coordinate x as generalized coordinate: y = +sqrt(R² -
x²), so that theta = acos(x/R). The coordinate serves on the half y > 0 only; at x = ±R, where the
circle turns back, its mass matrix grows without bound and the chart ends: a motion that continues
beyond needs the angle.
"""

from dataclasses import replace

from numpy import arccos, cos, sin, sqrt

from mecanique import model as mq
from mecanique.textbook import System, facts
from mecanique.textbook.systems.particle_on_circle import R
from mecanique.textbook.systems.particle_on_circle import mechanism as by_angle

# the particle of `particle_on_circle`, the angle of whose spoke follows x
turn = mq.acos(mq.coordinate("x") / R)
mechanism = replace(
    by_angle,
    name="particle_on_circle_x",
    coordinates=mq.Coordinates(("x",), {"theta": turn}, limits={"x": (-R, R)}),
)


def around(s: facts.Values) -> dict[str, float]:
    """Return the motion that starts at x = 0.8 R with theta' = 1."""
    theta = arccos(0.8) + s.t
    return {"x": s.R * cos(theta), "x'": -s.R * sin(theta)}


SYSTEM = System(
    title="Particle on a horizontal circle, by its abscissa",
    source="Fundamentals of Dynamics, ch. 1, Figure 1.1",
    build=mechanism,
    start={"x": 0.8},
    start_velocity={"x": -0.6},
    duration=2.4,
    tags=("chapter", "particle", "planar", "chart"),
    facts=(
        facts.Acceleration(
            "x'' = -x x'² / (R² - x²)", lambda s: [-s.x * s["x'"] ** 2 / (s.R**2 - s.x**2)]
        ),
        facts.MassMatrix("M = m R² / (R² - x²)", lambda s: [[s.m * s.R**2 / (s.R**2 - s.x**2)]]),
        facts.Conserved("theta' = -x' / sqrt(R² - x²)", lambda s: -s["x'"] / sqrt(s.R**2 - s.x**2)),
        facts.Solution(
            "x = R cos(theta0 + theta' t), the same motion as by the angle",
            lambda s: {"x": 0.8 * s.R, "x'": -0.6 * s.R},
            around,
            until=lambda s: 2.0,
        ),
    ),
    forms={
        "T = m R^2 x'^2/(2 (R^2 - x^2))": "Fundamentals of Dynamics, Figure 1.1, by the abscissa",
        "x'' + x x'^2/(R^2 - x^2) = 0": "Lagrange's equation of this T",
    },
)
