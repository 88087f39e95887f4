"""Pendulum on a driven pivot (Kapitza).

A particle m hangs by a massless rod of length l from a pivot that is driven up and down by A cos(W
t), under gravity g. The generalized coordinate q is the angle from the downward vertical, positive
towards +x. Shaken fast enough, the pendulum stands upright.
"""

from numpy import cos, sin, sqrt

from mecanique.model import (
    Body,
    Box,
    Coordinates,
    Mechanism,
    Parameter,
    Prismatic,
    Revolute,
    Visual,
    bar,
    massless,
    particle,
    time,
)
from mecanique.textbook.facts import Acceleration, KineticEnergy, StabilityLimit, Steady, Values
from mecanique.textbook.system import System


def build(m: Parameter, l: Parameter, g: Parameter, A: Parameter, W: Parameter) -> Mechanism:
    """Return the pendulum on its pivot."""
    from sympy import cos

    return Mechanism(
        name="kapitza_pendulum",
        bodies=(
            Body("ground"),
            Body("pivot", massless(Visual(Box((0.1, 0.1, 0.05)), rgba=(0.5, 0.5, 0.5, 1.0)))),
            Body("bob", bar(l, radius=0.01), particle(m, (0, 0, -l))),
        ),
        joints=(
            Prismatic("shaker", "ground", "pivot", axis=(0, 0, 1), coordinate="z"),
            Revolute("pin", "pivot", "bob", axis=(0, -1, 0), coordinate="q"),
        ),
        coordinates=Coordinates(("q",), {"z": A * cos(W * time())}),
        parameters=(m, l, g, A, W),
        gravity=(0, 0, -g),
    )


def limit(s: Values) -> float:
    """Return W that makes upright stable, by Mathieu's characteristic value a0(2 A / l)."""
    from scipy.special import mathieu_a

    return float(sqrt(-4 * s.g / (s.l * mathieu_a(0, 2 * s.A / s.l))))


SYSTEM = System(
    title="Pendulum whose pivot is shaken: it can stand upright",
    source="Stephenson, Phil. Mag. 15 (1908) 233; Kapitza, 1951; Landau & Lifshitz, Mechanics, "
    "sect. 30, problem 1",
    parameters=(
        Parameter("m", 0.1, "kg", "mass of the particle"),
        Parameter("l", 0.2, "m", "length of the rod"),
        Parameter("g", 9.81, "m/s²", "acceleration of free fall"),
        Parameter("A", 0.02, "m", "amplitude of the pivot"),
        Parameter("W", 150.0, "rad/s", "angular frequency of the pivot"),
    ),
    build=build,
    start={"q": 2.8},
    duration=5.0,
    tags=("pendulum", "planar", "prescribed motion", "stability"),
    facts=(
        Acceleration(
            "q'' = -(g - A W² cos(W t)) sin(q) / l",
            lambda s: [-(s.g - s.A * s.W**2 * cos(s.W * s.t)) * sin(s.q) / s.l],
        ),
        KineticEnergy(
            "T = m (l² q'² - 2 l q' A W sin(W t) sin(q) + A² W² sin²(W t)) / 2",
            lambda s: (
                s.m
                * (
                    (s.l * s["q'"]) ** 2
                    - 2 * s.l * s["q'"] * s.A * s.W * sin(s.W * s.t) * sin(s.q)
                    + (s.A * s.W * sin(s.W * s.t)) ** 2
                )
                / 2
            ),
        ),
        StabilityLimit(
            "upright is stable above the W with -4 g / (l W²) = a0(2 A / l), "
            "Mathieu's characteristic value",
            "W",
            limit,
            stable="above",
            at={"q": 3.141592653589793},
            period=lambda s: 6.283185307179586 / s.W,
        ),
        Steady("upright is an equilibrium at any time", {"q": 3.141592653589793}),
    ),
)
