"""Slider-crank.

A uniform crank of length r and mass m1 turns about a pin on the ground; a massless connecting rod
of length l joins its end to a slider of mass m2 that moves along the horizontal line through the
pin, under gravity g. The generalized coordinates are the angle theta of the crank from that line,
positive upwards, the angle beta of the rod against the crank, and the distance x of the slider from
the pin; the loop at the slider's pin leaves one of them free. Where the rod is the longer one,
theta alone carries the motion.
"""

from numpy import cos, sin

from mecanique import model as mq
from mecanique.textbook import System, facts
from mecanique.textbook.joints import hinge

r = mq.Parameter("r", 0.5, "m", "length of the crank")
l = mq.Parameter("l", 1.2, "m", "length of the connecting rod")
m1 = mq.Parameter("m1", 2.0, "kg", "mass of the crank")
m2 = mq.Parameter("m2", 1.0, "kg", "mass of the slider")
g = mq.Parameter("g", 9.81, "m/s²", "acceleration of free fall")

mechanism = mq.Mechanism(
    name="slider_crank",
    bodies=(
        mq.Body("ground"),
        mq.Body("crank", mq.rod(m1, r, (1, 0, 0))),
        mq.Body("rod", mq.bar(l, (1, 0, 0))),
        mq.Body("slider", mq.box(m2, (0.2, 0.1, 0.1))),
    ),
    joints=(
        hinge("O", "ground", "crank", "theta"),
        hinge("A", "crank", "rod", "beta", at=(r, 0, 0)),
        mq.Prismatic("guide", "ground", "slider", axis=(1, 0, 0), coordinate="x"),
    ),
    loops=(mq.Loop.pin("B", "rod", (l, 0, 0), "slider", (0, 0, 0)),),
    parameters=(r, l, m1, m2, g),
    gravity=(0, 0, -g),
)


def acceleration(s: facts.Values) -> facts.Number:
    """Return theta'', beta'', x''.

    (m1 r²/3 + m2 X²) theta'' + m2 X X' theta'² = -m1 g r cos(theta) / 2 gives theta'';
    X = dx/dtheta and X' = d²x/dtheta² follow from (x - r cos(theta))² + r² sin²(theta) = l².
    """
    c, d, w = cos(s.theta), sin(s.theta), s["theta'"]
    run = s.x - s.r * c
    X = -s.r * d * s.x / run
    slope = -s.r * c - ((X + s.r * d) ** 2 + s.r**2 * (c**2 - d**2)) / run
    turn = (-s.m1 * s.g * s.r * c / 2 - s.m2 * X * slope * w**2) / (s.m1 * s.r**2 / 3 + s.m2 * X**2)
    swing = -s.r * c * w / run
    # l sin(rod) = -r sin(theta) and l cos(rod) = run, differentiated twice
    whole = (s.r * d * w**2 - s.r * c * turn - s.r * d * swing**2) / run
    return [turn, whole - turn, X * turn + slope * w**2]


def kinetic(s: facts.Values) -> facts.Number:
    """Return T."""
    return (s.m1 * s.r**2 * s["theta'"] ** 2 / 3 + s.m2 * s["x'"] ** 2) / 2


SYSTEM = System(
    title="Crank, massless connecting rod and slider",
    source="Eksergian, J. Franklin Inst. 209 (1930) 21; Meriam & Kraige, Dynamics, "
    "sect. 5/6 (kinematics)",
    build=mechanism,
    start={"theta": 0.7, "beta": -0.97, "x": 1.54},
    tags=("linkage", "planar", "loop", "massless", "engine"),
    facts=(
        facts.Acceleration(
            "Eksergian's equation with x(theta) of the loop, on both branches", acceleration
        ),
        facts.KineticEnergy("T = m1 r² theta'² / 6 + m2 x'² / 2", kinetic),
        facts.Conserved(
            "the loop: (x - r cos theta)² + r² sin² theta = l²",
            lambda s: s.x**2 - 2 * s.r * s.x * cos(s.theta),
        ),
        facts.Conserved(
            "the energy T + m1 g r sin(theta) / 2",
            lambda s: kinetic(s) + s.m1 * s.g * s.r * sin(s.theta) / 2,
        ),
    ),
    forms={
        "J theta'' + C theta'^2 + m1 g r cos(theta)/2 = 0": "Eksergian, with weight",
        "C = m2 K_x L_x": "Eksergian",
    },
)
