"""Coupled pendulums.

Two equal pendulums, particles m on massless rods of length l, hang from pins a distance d apart on
a horizontal line. A spring of stiffness k and free length d joins the rods at the distance a below
the pins. They swing in one vertical plane under gravity g. The generalized coordinates q1 and q2
are the angles from the downward vertical, positive towards +x. Energy passes back and forth between
the pendulums.
"""

from numpy import cos, sin, sqrt

from mecanique import model as mq
from mecanique.textbook import System, facts
from mecanique.textbook.joints import hinge

m = mq.Parameter("m", 1.0, "kg", "mass of each particle")
l = mq.Parameter("l", 1.0, "m", "length of each rod")
d = mq.Parameter("d", 0.5, "m", "distance of the pins and free length of the spring")
a = mq.Parameter("a", 0.5, "m", "distance of the spring below the pins")
k = mq.Parameter("k", 4.0, "N/m", "stiffness of the spring")
g = mq.Parameter("g", 9.81, "m/s²", "acceleration of free fall")

mechanism = mq.Mechanism(
    name="coupled_pendulums",
    bodies=(
        mq.Body("ground"),
        *(mq.Body(f"bob{i}", mq.bar(l), mq.particle(m, (0, 0, -l))) for i in (1, 2)),
    ),
    joints=(
        hinge("pin1", "ground", "bob1", "q1"),
        hinge("pin2", "ground", "bob2", "q2", at=(d, 0, 0)),
    ),
    forces=(
        mq.Spring("spring", "bob1", (0, 0, -a), "bob2", (0, 0, -a), stiffness=k, free_length=d),
    ),
    parameters=(m, l, d, a, k, g),
    gravity=(0, 0, -g),
)


def energy(s: facts.Values) -> facts.Number:
    """Return T + V with the spring's length exact."""
    T = s.m * s.l**2 * (s["q1'"] ** 2 + s["q2'"] ** 2) / 2
    across = s.d + s.a * (sin(s.q2) - sin(s.q1))
    up = s.a * (cos(s.q1) - cos(s.q2))
    stretch = sqrt(across**2 + up**2) - s.d
    return T - s.m * s.g * s.l * (cos(s.q1) + cos(s.q2)) + s.k * stretch**2 / 2


SYSTEM = System(
    title="Two equal pendulums joined by a weak spring",
    source="French, Vibrations and Waves, ch. 5; Goldstein, Classical Mechanics, ch. 6",
    build=mechanism,
    start={"q1": 0.4},
    duration=30.0,
    tags=("pendulum", "planar", "spring", "modes"),
    facts=(
        facts.MassMatrix(
            "M = m l² times the unit matrix", lambda s: [[s.m * s.l**2, 0], [0, s.m * s.l**2]]
        ),
        facts.Frequencies(
            "ω² = g / l side by side, g / l + 2 k a² / (m l²) against each other",
            lambda s: [sqrt(s.g / s.l), sqrt(s.g / s.l + 2 * s.k * s.a**2 / (s.m * s.l**2))],
        ),
        facts.Period(
            "side by side with amplitude A they swing as one alone, 4 sqrt(l / g) K(k), "
            "k = sin(A/2)",
            {"q1": 1.0, "q2": 1.0},
            lambda s: facts.swing_period(s.l, s.g, 1.0),
        ),
        facts.Conserved("the energy with the spring's exact elongation", energy),
    ),
    forms={
        "omega_1^2 = g/l": "French, ch. 5, in phase",
        "omega_2^2 = (m g l + 2 k a^2)/(m l^2)": "French, ch. 5, against each other; there a = l",
    },
)
