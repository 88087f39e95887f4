"""Crane with a hoisted load.

A trolley M runs on a horizontal beam, pushed by F(t). From it hangs a load m, a particle, by a
massless cable that is wound up at the constant rate w from the length l0: l = l0 − w t, for as long
as l > 0; gravity g acts. The generalized coordinates are the trolley's position x and the angle
theta of the cable from the downward vertical, positive towards +x. Hoisting makes the load swing
wider.
"""

from numpy import cos, sin

from mecanique.model import (
    Body,
    Coordinates,
    Force,
    Input,
    Mechanism,
    Parameter,
    Prismatic,
    Revolute,
    box,
    particle,
    time,
)
from mecanique.textbook.facts import (
    Acceleration,
    Conserved,
    Frequencies,
    MassMatrix,
    Number,
    Values,
)
from mecanique.textbook.system import System


def build(M: Parameter, m: Parameter, l0: Parameter, w: Parameter, g: Parameter) -> Mechanism:
    """Return the trolley, the direction of the cable, and the load."""
    F = Input("F", 0.0, "N", "force on the trolley")
    return Mechanism(
        name="crane",
        bodies=(
            Body("ground"),
            Body("trolley", box(M, (0.8, 0.4, 0.3))),
            Body("cable"),
            Body("load", particle(m, radius=0.2)),
        ),
        joints=(
            Prismatic("beam", "ground", "trolley", axis=(1, 0, 0), coordinate="x"),
            Revolute("drum", "trolley", "cable", axis=(0, -1, 0), coordinate="theta"),
            Prismatic("hoist", "cable", "load", axis=(0, 0, -1), coordinate="l"),
        ),
        forces=(Force("push", "trolley", (0, 0, 0), force=(F, 0, 0)),),
        coordinates=Coordinates(("x", "theta"), {"l": l0 - w * time()}),
        parameters=(M, m, l0, w, g),
        inputs=(F,),
        gravity=(0, 0, -g),
    )


def length(s: Values) -> Number:
    """Return the length of the cable."""
    return s.l0 - s.w * s.t


def acceleration(s: Values) -> tuple[Number, Number]:
    """Return x'' and theta'' without push; the cable pulls the trolley and swings the load."""
    swing = length(s) * s["theta'"] ** 2
    x = s.m * sin(s.theta) * (swing + s.g * cos(s.theta)) / (s.M + s.m * sin(s.theta) ** 2)
    return x, (2 * s.w * s["theta'"] - s.g * sin(s.theta) - x * cos(s.theta)) / length(s)


def momentum(s: Values) -> Number:
    """Return the horizontal momentum of trolley and load."""
    load = length(s) * s["theta'"] * cos(s.theta) - s.w * sin(s.theta)
    return (s.M + s.m) * s["x'"] + s.m * load


SYSTEM = System(
    title="Trolley with a load that swings while it is hoisted",
    source="Sakawa & Shindo, Automatica 18 (1982) 257; Abdel-Rahman, Nayfeh & Masoud, "
    "J. Vib. Control 9 (2003) 863",
    parameters=(
        Parameter("M", 1000.0, "kg", "mass of the trolley"),
        Parameter("m", 500.0, "kg", "mass of the load"),
        Parameter("l0", 10.0, "m", "length of the cable at t = 0"),
        Parameter("w", 0.35, "m/s", "rate of hoisting"),
        Parameter("g", 9.81, "m/s²", "acceleration of free fall"),
    ),
    build=build,
    start={"theta": 0.2},
    duration=20.0,
    tags=("crane", "pendulum", "planar", "prescribed motion", "control"),
    facts=(
        MassMatrix(
            "M = [[M + m, m l cos(theta)], [m l cos(theta), m l²]], l = l0 - w t",
            lambda s: [
                [s.M + s.m, s.m * length(s) * cos(s.theta)],
                [s.m * length(s) * cos(s.theta), s.m * length(s) ** 2],
            ],
        ),
        Acceleration(
            "(M + m sin²(theta)) x'' = m sin(theta) (l theta'² + g cos(theta)), "
            "l theta'' = 2 w theta' - g sin(theta) - x'' cos(theta)",
            acceleration,
        ),
        Conserved(
            "the horizontal momentum (M + m) x' + m (l theta' cos(theta) - w sin(theta))", momentum
        ),
        Frequencies(
            "with the hoist at rest, ω = 0 and sqrt((1 + m / M) g / l0)",
            lambda s: [0, ((1 + s.m / s.M) * s.g / s.l0) ** 0.5],
            given={"w": 0.0},
        ),
    ),
)
