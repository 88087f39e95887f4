"""Particle on a cord that goes slack.

A particle m hangs by a cord of length l and is thrown from below under gravity g, too slow to go
round. The generalized coordinates are its distance r from the pivot and the angle th of its radius
from the downward vertical. With v^2 = 4 g l the cord goes slack 2 l/3 above the pivot and is taut
again further down.
"""

from math import acos, pi, sqrt

from mecanique import model as mq
from mecanique.textbook import System, facts
from mecanique.textbook.joints import hinge

m = mq.Parameter("m", 1.0, "kg", "mass of the particle")
l = mq.Parameter("l", 1.0, "m", "length of the cord")
g = mq.Parameter("g", 9.81, "m/s²", "acceleration of free fall")

mechanism = mq.Mechanism(
    name="slack_cord",
    bodies=(mq.Body("ground"), mq.Body("ray", mq.massless()), mq.Body("bob", mq.particle(m))),
    joints=(
        hinge("turn", "ground", "ray", "th"),
        mq.Prismatic("out", "ray", "bob", axis=(0, 0, -1), coordinate="r"),
    ),
    parameters=(m, l, g),
    gravity=(0, 0, -g),
    switching=(mq.Stop("cord", "out", at=l, side=1),),
)


SYSTEM = System(
    title="Particle on a cord that goes slack",
    source="Meriam & Kraige, Dynamics, sect. 3/5; Lamb, Dynamics",
    build=mechanism,
    start={"th": 0.0, "r": 1.0},
    start_velocity={"th": sqrt(4 * 9.81)},
    duration=1.5,
    tags=("planar", "contact", "impact", "corners"),
    facts=(
        facts.Occurs(
            "it goes slack where cos(th) = -2/3, at sqrt(2/3 g l)",
            "cord: open",
            lambda s: {"th": acos(-2 / 3), "th'": sqrt(2 / 3 * s.g / s.l)},
        ),
        facts.Occurs(
            "it is taut again where the parabola meets the circle, at th = 4 pi - 3 acos(-2/3)",
            "cord: impact",
            lambda s: {"th": 4 * pi - 3 * acos(-2 / 3)},
        ),
    ),
)
