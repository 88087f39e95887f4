"""Pendulum on a driven pivot (Kapitza).

A particle m hangs by a massless rod of length l from a pivot that is driven up and down by A cos(W
t), under gravity g. The generalized coordinate q is the angle from the downward vertical, positive
towards +x. Shaken fast enough, the pendulum stands upright.
"""

from numpy import cos, sin, sqrt

from mecanique import model as mq
from mecanique.textbook import System, facts
from mecanique.textbook.joints import hinge

m = mq.Parameter("m", 0.1, "kg", "mass of the particle")
l = mq.Parameter("l", 0.2, "m", "length of the rod")
g = mq.Parameter("g", 9.81, "m/s²", "acceleration of free fall")
A = mq.Parameter("A", 0.02, "m", "amplitude of the pivot")
W = mq.Parameter("W", 150.0, "rad/s", "angular frequency of the pivot")

# the pendulum on its pivot
mechanism = mq.Mechanism(
    name="kapitza_pendulum",
    bodies=(
        mq.Body("ground"),
        mq.Body(
            "pivot", mq.massless(mq.Visual(mq.Box((0.1, 0.1, 0.05)), rgba=(0.5, 0.5, 0.5, 1.0)))
        ),
        mq.Body("bob", mq.bar(l, radius=0.01), mq.particle(m, (0, 0, -l))),
    ),
    joints=(
        mq.Prismatic("shaker", "ground", "pivot", axis=(0, 0, 1), coordinate="z"),
        hinge("pin", "pivot", "bob", "q"),
    ),
    coordinates=mq.Coordinates(("q",), {"z": A * mq.cos(W * mq.time())}),
    parameters=(m, l, g, A, W),
    gravity=(0, 0, -g),
)


def limit(s: facts.Values) -> float:
    """Return W that makes upright stable, by Mathieu's characteristic value a0(2 A / l)."""
    from scipy.special import mathieu_a

    return float(sqrt(-4 * s.g / (s.l * mathieu_a(0, 2 * s.A / s.l))))


SYSTEM = System(
    title="Pendulum whose pivot is shaken: it can stand upright",
    source="Stephenson, Phil. Mag. 15 (1908) 233; Kapitza, 1951; Landau & Lifshitz, Mechanics, "
    "sect. 30, problem 1",
    build=mechanism,
    start={"q": 2.8},
    duration=5.0,
    tags=("pendulum", "planar", "prescribed motion", "stability"),
    facts=(
        facts.Acceleration(
            "q'' = -(g - A W² cos(W t)) sin(q) / l",
            lambda s: [-(s.g - s.A * s.W**2 * cos(s.W * s.t)) * sin(s.q) / s.l],
        ),
        facts.KineticEnergy(
            "T = m (l² q'² - 2 l q' A W sin(W t) sin(q) + A² W² sin²(W t)) / 2",
            lambda s: (
                s.m
                * (
                    (s.l * s["q'"]) ** 2
                    - 2 * s.l * s["q'"] * s.A * s.W * sin(s.W * s.t) * sin(s.q)
                    + (s.A * s.W * sin(s.W * s.t)) ** 2
                )
                / 2
            ),
        ),
        facts.StabilityLimit(
            "upright is stable above the W with -4 g / (l W²) = a0(2 A / l), "
            "Mathieu's characteristic value",
            "W",
            limit,
            stable="above",
            at={"q": 3.141592653589793},
            period=lambda s: 6.283185307179586 / s.W,
        ),
        facts.Steady("upright is an equilibrium at any time", {"q": 3.141592653589793}),
    ),
    forms={
        "q'' + (g - A W^2 cos(W t)) sin(q)/l = 0": (
            "Stephenson 1908; Landau & Lifshitz, sect. 30, problem 1"
        ),
    },
)
