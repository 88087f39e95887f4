"""Atwood's machine.

Weights m1 and m2 hang from the ends of a massless cord that runs without slip over a
homogeneous pulley of mass M and radius R on a fixed horizontal axle, under gravity g. The
generalized coordinate x is the distance m1 has descended from where both weights hang a depth h
below the axle; m2 has risen as far, and the pulley has turned by x / R. A weight that comes to the
height of the axle ends the motion.
"""

from math import pi

from mecanique import model as mq
from mecanique.textbook import System, facts
from mecanique.textbook.joints import hinge, slide

HERE = (0.0, 0.0, 0.0)


m1 = mq.Parameter("m1", 1.2, "kg", "mass of one weight")
m2 = mq.Parameter("m2", 1.0, "kg", "mass of the other weight")
M = mq.Parameter("M", 0.4, "kg", "mass of the pulley")
R = mq.Parameter("R", 0.2, "m", "radius of the pulley")
h = mq.Parameter("h", 1.0, "m", "depth of both weights below the axle at x = 0")
g = mq.Parameter("g", 9.81, "m/s²", "acceleration of free fall")

x, size = mq.coordinate("x"), (0.1, 0.1, 0.1)
mechanism = mq.Mechanism(
    name="atwood_machine",
    bodies=(
        mq.Body("ground"),
        mq.Body("pulley", mq.disk(M, R).at(rpy=(pi / 2, 0, 0))),
        mq.Body("weight1", mq.box(m1, size)),
        mq.Body("weight2", mq.box(m2, size)),
    ),
    joints=(
        slide("rail1", "ground", "weight1", "x", at=(-R, 0, -h), axis=(0, 0, -1)),
        slide("rail2", "ground", "weight2", "x2", at=(R, 0, -h), axis=(0, 0, -1)),
        hinge("axle", "ground", "pulley", "turn"),
    ),
    coordinates=mq.Coordinates(("x",), {"x2": -x, "turn": x / R}, limits={"x": (-h, h)}),
    elements=(
        mq.Cord("cord", ("weight1", HERE), (mq.Pulley("pulley", R, -1),), ("weight2", HERE)),
    ),
    parameters=(m1, m2, M, R, h, g),
    gravity=(0, 0, -g),
)


def inertia(s: facts.Values) -> facts.Number:
    """Return the mass that the difference of the weights accelerates."""
    return s.m1 + s.m2 + s.M / 2


def fall(s: facts.Values) -> facts.Number:
    """Return the acceleration."""
    return (s.m1 - s.m2) * s.g / inertia(s)


SYSTEM = System(
    title="Two weights on a cord over a pulley",
    source="Atwood, A Treatise on the Rectilinear Motion, 1784; Goldstein, Classical Mechanics, "
    "sect. 1.6",
    build=mechanism,
    start={"x": -0.6},
    duration=1.7,
    tags=("pulley", "planar", "linear", "mimic"),
    facts=(
        facts.Acceleration("x'' = (m1 - m2) g / (m1 + m2 + M / 2)", lambda s: [fall(s)]),
        facts.MassMatrix("M = m1 + m2 + M / 2", lambda s: [[inertia(s)]]),
        facts.Solution(
            "from rest, x = x0 + x'' t² / 2",
            {"x": -0.5},
            lambda s: {"x": -0.5 + fall(s) * s.t**2 / 2, "x'": fall(s) * s.t},
            until=lambda s: 1.0,
        ),
        facts.GuideForce(
            "the cord pulls m1 up with m1 (g - x'')",
            "cord_1",
            lambda s: s.m1 * (s.g - fall(s)),
        ),
        facts.GuideForce(
            "the cord pulls m2 up with m2 (g + x'')",
            "cord_2",
            lambda s: s.m2 * (s.g + fall(s)),
        ),
        facts.Reaction(
            "the axle bears the pulley's weight and both tensions, (M + m1 + m2) g - (m1 - m2) x''",
            "axle",
            lambda s: [0, 0, (s.M + s.m1 + s.m2) * s.g - (s.m1 - s.m2) * fall(s)],
        ),
        facts.Conserved(
            "the energy (m1 + m2 + M / 2) x'² / 2 - (m1 - m2) g x",
            lambda s: inertia(s) * s["x'"] ** 2 / 2 - (s.m1 - s.m2) * s.g * s.x,
        ),
    ),
    forms={
        "x'' = 2 (m1 - m2) g/(2 m1 + 2 m2 + M)": "Goldstein, sect. 1.6, with the pulley's inertia",
    },
)
