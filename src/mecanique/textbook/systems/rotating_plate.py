"""Rotating floor plate.

A homogeneous rectangular floor plate of mass m and sides a and b lies in the horizontal plane and
turns about a fixed vertical axis through its corner o, held by a torsional stiffness k; gravity g
acts along the axis. The generalized coordinate theta is the angle of side a from the x axis,
positive towards y, zero where the stiffness is relaxed.
"""

from numpy import cos, sin, sqrt

from mecanique import model as mq
from mecanique.textbook import System, facts

m = mq.Parameter("m", 2.0e4, "kg", "mass of the plate")
a = mq.Parameter("a", 8.0, "m", "side along the plate's x axis")
b = mq.Parameter("b", 6.0, "m", "side along the plate's y axis")
k = mq.Parameter("k", 3.0e7, "N·m/rad", "torsional stiffness")
g = mq.Parameter("g", 9.81, "m/s²", "acceleration of free fall")

mechanism = mq.Mechanism(
    name="rotating_plate",
    bodies=(
        mq.Body("ground"),
        mq.Body("plate", mq.plate(m, (a, b), thickness=0.2).at((a / 2, b / 2, 0))),
    ),
    joints=(mq.Revolute("corner", "ground", "plate", axis=(0, 0, 1), coordinate="theta"),),
    forces=(mq.JointSpring("columns", "corner", k),),
    parameters=(m, a, b, k, g),
    gravity=(0, 0, -g),
)


def inertia(s: facts.Values) -> facts.Number:
    """Return the moment of inertia about the corner, by the parallel-axis theorem."""
    return s.m * (s.a**2 + s.b**2) / 3


def support(s: facts.Values) -> tuple[float, float, float]:
    """Return mass times acceleration of the center, and the weight."""
    alpha, w2 = -s.k * s.theta / inertia(s), s["theta'"] ** 2
    x, y = (
        s.a / 2 * cos(s.theta) - s.b / 2 * sin(s.theta),
        s.a / 2 * sin(s.theta) + s.b / 2 * cos(s.theta),
    )
    return s.m * (-alpha * y - w2 * x), s.m * (alpha * x - w2 * y), s.m * s.g


SYSTEM = System(
    title="Floor plate turning about a corner on a torsional spring",
    source="Fundamentals of Dynamics, ch. 1, eqs. 1.31-1.33",
    build=mechanism,
    start={"theta": 0.3},
    duration=5.0,
    tags=("chapter", "planar", "spring", "linear", "structure"),
    facts=(
        facts.KineticEnergy(
            "T = I_o theta'² / 2, I_o = m (a² + b²) / 3",
            lambda s: inertia(s) * s["theta'"] ** 2 / 2,
        ),
        facts.Acceleration("I_o theta'' + k theta = 0", lambda s: [-s.k * s.theta / inertia(s)]),
        facts.Frequencies("ω = sqrt(k / I_o)", lambda s: [sqrt(s.k / inertia(s))]),
        facts.Reaction("the axis bears m a_G and the weight", "corner", support),
    ),
    forms={
        "T = m (a^2 + b^2) theta'^2/6": (
            "Fundamentals of Dynamics, eq. 1.33, with I about the corner"
        ),
    },
)
