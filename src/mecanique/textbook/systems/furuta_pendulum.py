"""Pendulum on a rotating arm (Furuta).

A homogeneous arm of mass M and length r turns in a horizontal plane about a fixed vertical axis at
one end; a torque tau(t) drives it. From its other end a particle m hangs by a massless rod of
length l and swings across the arm under gravity g. The generalized coordinates are the angle alpha
of the arm from the x axis, positive towards y, and the angle theta of the rod from the downward
vertical, positive towards the arm's own turning.
"""

import numpy as np
from numpy import cos, sin, sqrt

from mecanique import model as mq
from mecanique.textbook import System, facts
from mecanique.textbook.joints import hinge

M = mq.Parameter("M", 0.3, "kg", "mass of the arm")
m = mq.Parameter("m", 0.2, "kg", "mass of the particle")
r = mq.Parameter("r", 0.4, "m", "length of the arm")
l = mq.Parameter("l", 0.4, "m", "length of the rod")
g = mq.Parameter("g", 9.81, "m/s²", "acceleration of free fall")

tau = mq.Input("tau", 0.0, "N·m", "torque on the arm")
mechanism = mq.Mechanism(
    name="furuta_pendulum",
    bodies=(
        mq.Body("ground"),
        mq.Body("arm", mq.rod(M, r, (1, 0, 0))),
        mq.Body("bob", mq.bar(l), mq.particle(m, (0, 0, -l))),
    ),
    joints=(
        mq.Revolute("motor", "ground", "arm", axis=(0, 0, 1), coordinate="alpha"),
        hinge("pin", "arm", "bob", "theta", at=(r, 0, 0), axis=(1, 0, 0)),
    ),
    forces=(mq.JointForce("drive", "motor", tau),),
    parameters=(M, m, r, l, g),
    inputs=(tau,),
    gravity=(0, 0, -g),
)


def mass_matrix(s: facts.Values) -> list[list[facts.Number]]:
    """Return M."""
    arm = s.M * s.r**2 / 3 + s.m * (s.r**2 + s.l**2 * sin(s.theta) ** 2)
    off = s.m * s.r * s.l * cos(s.theta)
    return [[arm, off], [off, s.m * s.l**2]]


def acceleration(s: facts.Values) -> facts.Number:
    """Return alpha'' and theta'' of the arm without torque."""
    a, th = s["alpha'"], s["theta'"]
    cross = s.m * s.l**2 * sin(2 * s.theta)
    right = [
        s.m * s.r * s.l * sin(s.theta) * th**2 - cross * a * th,
        cross * a**2 / 2 - s.m * s.g * s.l * sin(s.theta),
    ]
    return np.linalg.solve(mass_matrix(s), right)


def momentum(s: facts.Values) -> facts.Number:
    """Return the angular momentum about the vertical axis."""
    (a, b), _ = mass_matrix(s)
    return a * s["alpha'"] + b * s["theta'"]


SYSTEM = System(
    title="Pendulum at the end of an arm that turns horizontally",
    source="Furuta, Yamakita & Kobayashi, IECON 1991; Cazzolato & Prime, "
    "J. Control Sci. Eng. 2011, 528341",
    build=mechanism,
    start={"theta": 3.0},
    tags=("pendulum", "spatial", "control"),
    facts=(
        facts.MassMatrix(
            "M = [[M r²/3 + m (r² + l² sin²(theta)), m r l cos(theta)], [m r l cos(theta), m l²]]",
            mass_matrix,
        ),
        facts.Acceleration(
            "M v' = (m r l sin(theta) theta'² - m l² sin(2 theta) alpha' theta', "
            "m l² sin(2 theta) alpha'² / 2 - m g l sin(theta))",
            acceleration,
        ),
        facts.Conserved("without torque, the angular momentum about the vertical", momentum),
        facts.Steady(
            "it circles with the rod out at theta when alpha'² = g / (l cos(theta))",
            lambda s: {"theta": 0.8, "alpha'": sqrt(s.g / (s.l * cos(0.8)))},
        ),
        facts.Frequencies(
            "hanging, ω = 0 and sqrt((1 + 3 m / M) g / l)",
            lambda s: [0, sqrt((1 + 3 * s.m / s.M) * s.g / s.l)],
        ),
    ),
    forms={
        "r cos(theta) alpha'' + l theta'' - l sin(theta) cos(theta) alpha'^2 + g sin(theta) = 0": (
            "Cazzolato & Prime 2011, with a particle at a massless rod"
        ),
    },
)
