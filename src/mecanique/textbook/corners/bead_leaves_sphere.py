"""Particle that leaves a sphere.

A particle m slides from rest down a smooth sphere of radius R under gravity g. The generalized
coordinates are its distance r from the center of the sphere and the angle th of its radius from the
vertical. It leaves where its height is two thirds of that at which it began.
"""

from math import acos, cos, sin, sqrt

from mecanique import model as mq
from mecanique.textbook import System, facts

m = mq.Parameter("m", 1.0, "kg", "mass of the particle")
R = mq.Parameter("R", 1.0, "m", "radius of the sphere")
g = mq.Parameter("g", 9.81, "m/s²", "acceleration of free fall")

mechanism = mq.Mechanism(
    name="bead_leaves_sphere",
    bodies=(mq.Body("ground"), mq.Body("ray", mq.massless()), mq.Body("bead", mq.particle(m))),
    joints=(
        mq.Revolute("turn", "ground", "ray", axis=(0, 1, 0), coordinate="th"),
        mq.Prismatic("out", "ray", "bead", axis=(0, 0, 1), coordinate="r"),
    ),
    parameters=(m, R, g),
    gravity=(0, 0, -g),
    switching=(mq.Stop("sphere", "out", at=R, side=-1),),
)


SYSTEM = System(
    title="Particle that leaves a sphere",
    source="Goldstein, Classical Mechanics, 3rd ed., ch. 2, exercises",
    build=mechanism,
    start={"th": 0.1, "r": 1.0},
    duration=1.2,
    tags=("planar", "contact", "corners"),
    facts=(
        facts.ModeAcceleration(
            "r th'' = g sin(th) - 2 r' th' on and off the sphere",
            ("closed",),
            lambda s: [(s.g * sin(s.th) - 2 * s["r'"] * s["th'"]) / s.r, 0.0],
        ),
        facts.Occurs(
            "it leaves where cos(th) = 2/3 cos(th_0), at sqrt(2/3 g R cos(th_0))",
            "sphere: open",
            lambda s: {
                "th": acos(2 / 3 * cos(0.1)),
                "th'": sqrt(2 / 3 * s.g * cos(0.1) / s.R),
            },
        ),
    ),
)
