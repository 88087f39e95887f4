"""Bead on a rotating hoop.

A bead m slides without friction on a circular hoop of radius R that turns at the constant rate W
about its vertical diameter, under gravity g. The generalized coordinate theta is the angle of the
bead's radius from the downward vertical. If the hoop turns fast enough, the bead leaves the bottom
for one side.
"""

from dataclasses import replace

from numpy import arccos, cos, pi, sin, sqrt

from mecanique import model as mq
from mecanique.textbook import System, facts
from mecanique.textbook.joints import hinge

m = mq.Parameter("m", 0.1, "kg", "mass of the bead")
R = mq.Parameter("R", 0.5, "m", "radius of the hoop")
W = mq.Parameter("W", 6.0, "rad/s", "rate of the hoop")
g = mq.Parameter("g", 9.81, "m/s²", "acceleration of free fall")

# the hoop, which is only drawn, and its bead
hoop = replace(mq.ring(0.0, R, thickness=0.01), inertia=(0.0,) * 6).at(rpy=(pi / 2, 0, 0))
mechanism = mq.Mechanism(
    name="bead_on_hoop",
    bodies=(
        mq.Body("ground"),
        mq.Body("hoop", hoop),
        mq.Body("bead", mq.particle(m, (0, 0, -R))),
    ),
    joints=(
        mq.Revolute("turntable", "ground", "hoop", axis=(0, 0, 1), coordinate="turn"),
        hinge("slide", "hoop", "bead", "theta"),
    ),
    coordinates=mq.Coordinates(("theta",), {"turn": W * mq.time()}),
    parameters=(m, R, W, g),
    gravity=(0, 0, -g),
)


SYSTEM = System(
    title="Bead on a hoop that turns steadily about a vertical diameter",
    source="Taylor, Classical Mechanics, examples 7.6 and 7.7; Marsden & Ratiu, "
    "Mechanics and Symmetry, sect. 2.8",
    build=mechanism,
    start={"theta": 0.1},
    tags=("planar", "prescribed motion", "rotating frame", "stability"),
    facts=(
        facts.Acceleration(
            "theta'' = (W² cos(theta) - g / R) sin(theta)",
            lambda s: [(s.W**2 * cos(s.theta) - s.g / s.R) * sin(s.theta)],
        ),
        facts.StabilityLimit(
            "the bottom is stable below W = sqrt(g / R)",
            "W",
            lambda s: sqrt(s.g / s.R),
            stable="below",
        ),
        facts.Steady(
            "above it, cos(theta) = g / (W² R) is an equilibrium",
            lambda s: {"theta": arccos(s.g / (s.W**2 * s.R))},
        ),
        facts.Frequencies(
            "about which the bead swings with ω = W sin(theta)",
            lambda s: [s.W * sqrt(1 - (s.g / (s.W**2 * s.R)) ** 2)],
            at=lambda s: {"theta": arccos(s.g / (s.W**2 * s.R))},
        ),
        facts.Conserved(
            "Jacobi's integral R² (theta'² - W² sin²(theta)) / 2 - g R cos(theta), not the energy",
            lambda s: (
                s.R**2 * (s["theta'"] ** 2 - s.W**2 * sin(s.theta) ** 2) / 2
                - s.g * s.R * cos(s.theta)
            ),
        ),
    ),
    forms={
        "theta'' = (W^2 cos(theta) - g/R) sin(theta)": "Taylor, example 7.6",
    },
)
