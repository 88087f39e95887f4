"""Compound pendulum.

The pendulum of a clock: a homogeneous rod of mass m1 and length l, pinned at its upper end, carries
at its lower end a homogeneous disk of mass m2 and radius r, fixed by its center and upright in the
plane of the swing. It swings under gravity g. The generalized coordinate q is the angle from the
downward vertical, positive towards +x.
"""

from numpy import cos, pi, sin, sqrt

from mecanique import model as mq
from mecanique.textbook import System, facts
from mecanique.textbook.joints import hinge

m1 = mq.Parameter("m1", 0.5, "kg", "mass of the rod")
m2 = mq.Parameter("m2", 2.0, "kg", "mass of the disk")
l = mq.Parameter("l", 1.0, "m", "length of the rod")
r = mq.Parameter("r", 0.15, "m", "radius of the disk")
g = mq.Parameter("g", 9.81, "m/s²", "acceleration of free fall")

bob = mq.disk(m2, r).at((0, 0, -l), (pi / 2, 0, 0))
mechanism = mq.Mechanism(
    name="compound_pendulum",
    bodies=(mq.Body("ground"), mq.Body("pendulum", mq.rod(m1, l), bob)),
    joints=(hinge("pin", "ground", "pendulum", "q"),),
    parameters=(m1, m2, l, r, g),
    gravity=(0, 0, -g),
)


def moments(s: facts.Values) -> tuple[facts.Number, facts.Number]:
    """Return the static moment and the moment of inertia about the pin."""
    return (s.m1 / 2 + s.m2) * s.l, s.m1 * s.l**2 / 3 + s.m2 * (s.l**2 + s.r**2 / 2)


def length(s: facts.Values) -> facts.Number:
    """Return the length of the equivalent simple pendulum (Huygens's center of oscillation)."""
    S, J = moments(s)
    return J / S


def reaction(s: facts.Values) -> tuple[facts.Number, facts.Number, facts.Number]:
    """Return the pin's force: what accelerates the center of mass, and the weight."""
    S, _ = moments(s)
    n, t = s["q'"] ** 2, -s.g / length(s) * sin(s.q)
    return (
        S * (t * cos(s.q) - n * sin(s.q)),
        0.0,
        S * (t * sin(s.q) + n * cos(s.q)) + (s.m1 + s.m2) * s.g,
    )


SYSTEM = System(
    title="Rod with a disk, pinned: the pendulum of a clock",
    source="Huygens, Horologium oscillatorium, 1673, part IV; Goldstein, Classical Mechanics, "
    "ch. 5",
    build=mechanism,
    start={"q": 1.0},
    tags=("pendulum", "planar"),
    facts=(
        facts.Acceleration(
            "q'' = -g sin(q) / L, L = (m1 l²/3 + m2 (l² + r²/2)) / ((m1/2 + m2) l)",
            lambda s: [-s.g / length(s) * sin(s.q)],
        ),
        facts.Frequencies(
            "ω = sqrt(g / L), that of a simple pendulum of length L",
            lambda s: [sqrt(s.g / length(s))],
        ),
        facts.Period(
            "swings of amplitude A last 4 sqrt(L / g) K(k), k = sin(A/2)",
            {"q": 1.0},
            lambda s: facts.swing_period(length(s), s.g, 1.0),
        ),
        facts.Reaction("the pin bears m a_G and the weight", "pin", reaction),
    ),
    forms={
        "((m1/3 + m2) l^2 + m2 r^2/2) q'' + (m1/2 + m2) g l sin(q) = 0": (
            "Huygens, part IV: the moment of inertia times q'' and the moment of the weights"
        ),
    },
)
