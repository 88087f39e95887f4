"""Crane with a hoisted load.

A trolley M runs on a horizontal beam, pushed by F(t). From it hangs a load m, a particle, by a
massless cable that is wound up at the constant rate w from the length l0: l = l0 − w t, for as long
as l > 0; gravity g acts. The generalized coordinates are the trolley's position x and the angle
theta of the cable from the downward vertical, positive towards +x. Hoisting makes the load swing
wider.
"""

from numpy import cos, sin

from mecanique import model as mq
from mecanique.textbook import System, facts
from mecanique.textbook.joints import hinge

M = mq.Parameter("M", 1000.0, "kg", "mass of the trolley")
m = mq.Parameter("m", 500.0, "kg", "mass of the load")
l0 = mq.Parameter("l0", 10.0, "m", "length of the cable at t = 0")
w = mq.Parameter("w", 0.35, "m/s", "rate of hoisting")
g = mq.Parameter("g", 9.81, "m/s²", "acceleration of free fall")

# the trolley, the direction of the cable, and the load
F = mq.Input("F", 0.0, "N", "force on the trolley")
mechanism = mq.Mechanism(
    name="crane",
    bodies=(
        mq.Body("ground"),
        mq.Body("trolley", mq.box(M, (0.8, 0.4, 0.3))),
        mq.Body("cable"),
        mq.Body("load", mq.particle(m, radius=0.2)),
    ),
    joints=(
        mq.Prismatic("beam", "ground", "trolley", axis=(1, 0, 0), coordinate="x"),
        hinge("drum", "trolley", "cable", "theta"),
        mq.Prismatic("hoist", "cable", "load", axis=(0, 0, -1), coordinate="l"),
    ),
    forces=(mq.Force("push", "trolley", (0, 0, 0), force=(F, 0, 0)),),
    coordinates=mq.Coordinates(("x", "theta"), {"l": l0 - w * mq.time()}),
    parameters=(M, m, l0, w, g),
    inputs=(F,),
    gravity=(0, 0, -g),
)


def length(s: facts.Values) -> facts.Number:
    """Return the length of the cable."""
    return s.l0 - s.w * s.t


def acceleration(s: facts.Values) -> tuple[facts.Number, facts.Number]:
    """Return x'' and theta'' without push; the cable pulls the trolley and swings the load."""
    swing = length(s) * s["theta'"] ** 2
    x = s.m * sin(s.theta) * (swing + s.g * cos(s.theta)) / (s.M + s.m * sin(s.theta) ** 2)
    return x, (2 * s.w * s["theta'"] - s.g * sin(s.theta) - x * cos(s.theta)) / length(s)


def momentum(s: facts.Values) -> facts.Number:
    """Return the horizontal momentum of trolley and load."""
    load = length(s) * s["theta'"] * cos(s.theta) - s.w * sin(s.theta)
    return (s.M + s.m) * s["x'"] + s.m * load


SYSTEM = System(
    title="Trolley with a load that swings while it is hoisted",
    source="Sakawa & Shindo, Automatica 18 (1982) 257; Abdel-Rahman, Nayfeh & Masoud, "
    "J. Vib. Control 9 (2003) 863",
    build=mechanism,
    start={"theta": 0.2},
    duration=20.0,
    tags=("crane", "pendulum", "planar", "prescribed motion", "control"),
    facts=(
        facts.MassMatrix(
            "M = [[M + m, m l cos(theta)], [m l cos(theta), m l²]], l = l0 - w t",
            lambda s: [
                [s.M + s.m, s.m * length(s) * cos(s.theta)],
                [s.m * length(s) * cos(s.theta), s.m * length(s) ** 2],
            ],
        ),
        facts.Acceleration(
            "(M + m sin²(theta)) x'' = m sin(theta) (l theta'² + g cos(theta)), "
            "l theta'' = 2 w theta' - g sin(theta) - x'' cos(theta)",
            acceleration,
        ),
        facts.Conserved(
            "the horizontal momentum (M + m) x' + m (l theta' cos(theta) - w sin(theta))", momentum
        ),
        facts.Frequencies(
            "with the hoist at rest, ω = 0 and sqrt((1 + m / M) g / l0)",
            lambda s: [0, ((1 + s.m / s.M) * s.g / s.l0) ** 0.5],
            given={"w": 0.0},
        ),
    ),
    forms={
        "(l0 - w t) theta'' - 2 w theta' + cos(theta) x'' + g sin(theta) = 0": (
            "Abdel-Rahman, Nayfeh & Masoud 2003, with l = l0 - w t"
        ),
    },
)
