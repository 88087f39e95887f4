"""Ladder that slides down a smooth wall.

A uniform ladder of mass m and length l leans against a smooth wall on a smooth floor and slides
down from rest under gravity g. The generalized coordinates x and z are those of its top, th is its
lean from the wall. It leaves the wall when its top is at two thirds of the height it began at.
"""

from math import cos, pi, sqrt

from mecanique.model import Body, Contact, Mechanism, Parameter, Placement, Planar, rod
from mecanique.textbook.facts import Occurs
from mecanique.textbook.system import System


def build(
    m: Parameter,
    l: Parameter,
    g: Parameter,
) -> Mechanism:
    """Return the mechanism."""
    wall = Placement((0, 0, 0), (0, pi / 2, 0))
    return Mechanism(
        name="ladder",
        bodies=(Body("ground"), Body("ladder", rod(m, l))),
        joints=(Planar("plane", "ground", "ladder", axis=(0, -1, 0), names=("x", "z", "th")),),
        parameters=(m, l, g),
        gravity=(0, 0, -g),
        switching=(
            Contact("floor", "ladder", center=(0, 0, -l)),
            Contact("wall", "ladder", plane=wall),
        ),
    )


SYSTEM = System(
    title="Ladder that slides down a smooth wall",
    source="Routh, Dynamics of a System of Rigid Bodies, Part I, art. 144",
    parameters=(
        Parameter("m", 10.0, "kg", "mass of the ladder"),
        Parameter("l", 2.0, "m", "length of the ladder"),
        Parameter("g", 9.81, "m/s²", "acceleration of free fall"),
    ),
    build=build,
    start={"x": 0.0, "z": 2.0 * cos(0.3), "th": 0.3},
    duration=1.1,
    tags=("planar", "contact", "corners"),
    facts=(
        Occurs(
            "it leaves the wall at two thirds of its height",
            "wall: open",
            lambda s: {"z": 2 / 3 * s.l * cos(0.3)},
        ),
        Occurs(
            "its rate is then sqrt(g cos(th_0)/l)",
            "wall: open",
            lambda s: {"th'": sqrt(s.g * cos(0.3) / s.l)},
        ),
    ),
)
