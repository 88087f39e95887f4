"""Disk rolling down an incline.

A homogeneous disk of mass m and radius R rolls down an incline of slope alpha without slip, upright
and straight, under gravity g. The generalized coordinates are the distance x that its center has
moved down the slope, the center's height z above the slope and the angle turn about its axis. The
incline keeps it off by the normal force and turns it by friction: two conditions leave one
velocity.
"""

import numpy as np
from numpy import cos, pi, sin

from mecanique import model as mq
from mecanique.textbook import System, facts

m = mq.Parameter("m", 1.0, "kg", "mass of the disk")
R = mq.Parameter("R", 0.3, "m", "radius of the disk")
alpha = mq.Parameter("alpha", 0.3, "rad", "slope of the incline")
g = mq.Parameter("g", 9.81, "m/s²", "acceleration of free fall")

# the disk; slides along and across the slope lead its center
slope = mq.Visual(
    mq.Box((6.0, 0.5, 0.02)), mq.Placement((0, 0, 0), (0, alpha, 0)), (0.8, 0.8, 0.8, 1.0)
)
# a box without mass lets the turning of the disk be seen
mark = mq.massless(mq.Visual(mq.Box((0.2 * R, 0.06, 1.6 * R)), rgba=(0.9, 0.6, 0.0, 1.0)))
mechanism = mq.Mechanism(
    name="rolling_disk",
    bodies=(
        mq.Body("ground", mq.massless(slope)),
        mq.Body("along"),
        mq.Body("center"),
        mq.Body("disk", mq.disk(m, R, 0.05).at(rpy=(pi / 2, 0, 0)), mark),
    ),
    joints=(
        mq.Prismatic(
            "slide",
            "ground",
            "along",
            axis=(1, 0, 0),
            origin=mq.Placement(rpy=(0, alpha, 0)),
            coordinate="x",
        ),
        mq.Prismatic("lift", "along", "center", axis=(0, 0, 1), coordinate="z"),
        mq.Revolute("roll", "center", "disk", axis=(0, 1, 0), coordinate="turn"),
    ),
    contacts=(mq.Rolling("contact", "disk", R, plane=mq.Placement(rpy=(0, alpha, 0))),),
    parameters=(m, R, alpha, g),
    gravity=(0, 0, -g),
)


def pull(s: facts.Values) -> facts.Number:
    """Return the acceleration down the slope [m/s²]."""
    return 2 * s.g * sin(s.alpha) / 3


def down(s: facts.Values) -> facts.Number:
    """Return the direction down the slope."""
    return np.array([cos(s.alpha), 0, -sin(s.alpha)])


def normal(s: facts.Values) -> facts.Number:
    """Return the direction off the slope."""
    return np.array([sin(s.alpha), 0, cos(s.alpha)])


SYSTEM = System(
    title="Disk that rolls down an incline without slip",
    source="Goldstein, Classical Mechanics, sect. 2.4 (hoop); Landau & Lifshitz, Mechanics, "
    "sect. 32",
    build=mechanism,
    start={"x": -1.8, "z": 0.3},
    start_velocity={"x": -1.0},
    duration=2.5,
    tags=("planar", "rolling", "linear", "contact"),
    facts=(
        facts.Acceleration(
            "x'' = 2 g sin(alpha)/3, turn'' = x''/R",
            lambda s: [pull(s), 0.0, pull(s) / s.R],
        ),
        facts.MassMatrix(
            "m for x and z, m R²/2 for turn", lambda s: np.diag([s.m, s.m, s.m * s.R**2 / 2])
        ),
        facts.KineticEnergy("T = m x'²/2 + m R² (x'/R)²/4", lambda s: s.m * s["x'"] ** 2 * 3 / 4),
        facts.Reaction(
            "the incline carries N = m g cos(alpha) and holds by the friction m g sin(alpha)/3",
            "contact",
            lambda s: s.m * s.g * (cos(s.alpha) * normal(s) - sin(s.alpha) / 3 * down(s)),
        ),
        facts.Solution(
            "x = x0 + x0' t + g sin(alpha) t²/3",
            {"x": -1.0, "z": 0.3, "x'": -2.0, "turn'": -2.0 / 0.3},
            lambda s: {"x": -1.0 - 2.0 * s.t + pull(s) * s.t**2 / 2},
            until=lambda s: 2.0,
            given={"R": 0.3},
        ),
        facts.Conserved(
            "the energy m x'²/2 + m R² turn'²/4 - m g (x sin(alpha) - z cos(alpha))",
            lambda s: (
                s.m
                * (
                    (s["x'"] ** 2 + s["z'"] ** 2) / 2
                    + (s.R * s["turn'"] / 2) ** 2
                    - s.g * (s.x * sin(s.alpha) - s.z * cos(s.alpha))
                )
            ),
        ),
    ),
    forms={
        "x'' = 2 g sin(alpha)/3": "Goldstein, sect. 2.4, for a disk",
        "lambda_contact_x = -m g sin(alpha)/3": "Goldstein, sect. 2.4, for a disk",
    },
)
