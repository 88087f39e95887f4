"""Double pendulum of uniform rods.

A rod m1, l1 hangs from a fixed pin, a second rod m2, l2 from its lower end; both swing in one
vertical plane under gravity g. The generalized coordinates q1 and q2 are the angles of the rods
from the downward vertical, positive towards +x; the second joint turns by q2 − q1.
"""

from numpy import cos, sqrt

from mecanique import model as mq
from mecanique.textbook import System, facts
from mecanique.textbook.joints import hinge

m1 = mq.Parameter("m1", 1.0, "kg", "mass of the upper rod")
m2 = mq.Parameter("m2", 1.0, "kg", "mass of the lower rod")
l1 = mq.Parameter("l1", 1.0, "m", "length of the upper rod")
l2 = mq.Parameter("l2", 1.0, "m", "length of the lower rod")
g = mq.Parameter("g", 9.81, "m/s²", "acceleration of free fall")

q1, q2 = mq.coordinate("q1"), mq.coordinate("q2")
mechanism = mq.Mechanism(
    name="double_pendulum",
    bodies=(
        mq.Body("ground"),
        mq.Body("rod1", mq.rod(m1, l1)),
        mq.Body("rod2", mq.rod(m2, l2)),
    ),
    joints=(
        hinge("pin1", "ground", "rod1", "q1"),
        hinge("pin2", "rod1", "rod2", "theta2", at=(0, 0, -l1)),
    ),
    coordinates=mq.Coordinates(("q1", "q2"), {"theta2": q2 - q1}),
    parameters=(m1, m2, l1, l2, g),
    gravity=(0, 0, -g),
)


def mass_matrix(s: facts.Values) -> list[list[facts.Number]]:
    """Return M: each rod's inertia about its pin; the upper rod carries the lower one's mass."""
    off = s.m2 * s.l1 * s.l2 / 2 * cos(s.q1 - s.q2)
    return [[(s.m1 / 3 + s.m2) * s.l1**2, off], [off, s.m2 * s.l2**2 / 3]]


def energy(s: facts.Values) -> facts.Number:
    """Return T + V, with V zero where all masses are at the height of the pin."""
    (a, b), (_, d) = mass_matrix(s)
    T = (a * s["q1'"] ** 2 + 2 * b * s["q1'"] * s["q2'"] + d * s["q2'"] ** 2) / 2
    return T - (s.m1 / 2 + s.m2) * s.g * s.l1 * cos(s.q1) - s.m2 * s.g * s.l2 / 2 * cos(s.q2)


def spin(s: facts.Values) -> facts.Number:
    """Return the angular momentum about the upper pin."""
    (a, b), (_, d) = mass_matrix(s)
    return (a + b) * s["q1'"] + (b + d) * s["q2'"]


SYSTEM = System(
    title="Two uniform rods, one hanging from the other",
    source="Goldstein, Classical Mechanics, ch. 1, ex. 22 (point masses); Levien & Tan, "
    "Am. J. Phys. 61 (1993) 1038",
    build=mechanism,
    start={"q1": 2.0, "q2": 1.5},
    tags=("pendulum", "planar", "chaos"),
    facts=(
        facts.MassMatrix(
            "M = [[(m1/3 + m2) l1², m2 l1 l2 cos(q1 - q2) / 2], [m2 l1 l2 cos(q1 - q2) / 2, "
            "m2 l2² / 3]]",
            mass_matrix,
        ),
        facts.Frequencies(
            "equal rods: ω² = 3 (1 ± 2 / sqrt(7)) g / l",
            lambda s: [sqrt(3 * (1 + sign * 2 / sqrt(7)) * s.g / s.l1) for sign in (-1, 1)],
            given={"m1": 1.0, "m2": 1.0, "l1": 1.0, "l2": 1.0},
        ),
        facts.Conserved("the energy T - (m1/2 + m2) g l1 cos(q1) - m2 g l2 cos(q2) / 2", energy),
        facts.Conserved(
            "without gravity, the angular momentum about the upper pin", spin, given={"g": 0.0}
        ),
    ),
    forms={
        "T = (m1 + 3 m2) l1^2 q1'^2/6 + m2 l1 l2 cos(q1 - q2) q1' q2'/2 + m2 l2^2 q2'^2/6": (
            "Woodhouse, Euphonics, on the double pendulum of two equal rods"
        ),
        "3 l1 cos(q1 - q2) q1'' + 2 l2 q2'' - 3 l1 sin(q1 - q2) q1'^2 + 3 g sin(q2) = 0": (
            "Lagrange's equation of the same T and V"
        ),
    },
)
