"""Ladder that slides down a smooth wall.

A uniform ladder of mass m and length l leans against a smooth wall on a smooth floor and slides
down from rest under gravity g. The generalized coordinates x and z are those of its top, th is its
lean from the wall. It leaves the wall when its top is at two thirds of the height it began at.
"""

from math import cos, pi, sqrt

from mecanique import model as mq
from mecanique.textbook import System, facts

m = mq.Parameter("m", 10.0, "kg", "mass of the ladder")
l = mq.Parameter("l", 2.0, "m", "length of the ladder")
g = mq.Parameter("g", 9.81, "m/s²", "acceleration of free fall")

wall = mq.Placement((0, 0, 0), (0, pi / 2, 0))
mechanism = mq.Mechanism(
    name="ladder",
    bodies=(mq.Body("ground"), mq.Body("ladder", mq.rod(m, l))),
    joints=(mq.Planar("plane", "ground", "ladder", axis=(0, -1, 0), names=("x", "z", "th")),),
    parameters=(m, l, g),
    gravity=(0, 0, -g),
    switching=(
        mq.Contact("floor", "ladder", center=(0, 0, -l)),
        mq.Contact("wall", "ladder", plane=wall),
    ),
)


SYSTEM = System(
    title="Ladder that slides down a smooth wall",
    source="Routh, Dynamics of a System of Rigid Bodies, Part I",
    build=mechanism,
    start={"x": 0.0, "z": 2.0 * cos(0.3), "th": 0.3},
    duration=1.1,
    tags=("planar", "contact", "corners"),
    facts=(
        facts.Occurs(
            "it leaves the wall at two thirds of its height",
            "wall: open",
            lambda s: {"z": 2 / 3 * s.l * cos(0.3)},
        ),
        facts.Occurs(
            "its rate is then sqrt(g cos(th_0)/l)",
            "wall: open",
            lambda s: {"th'": sqrt(s.g * cos(0.3) / s.l)},
        ),
    ),
)
