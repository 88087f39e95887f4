"""Bars and springs, in small motion.

The assembly of `bars_and_springs` with all horizontal displacements neglected, as for small motion
about the horizontal: two massless bars ABC and DEF of length 4 l, pinned at A and D and coupled by
the bar CF, with particles m at B and 2 m at E. Both bars turn by q / (4 l), where the generalized
coordinate q is the vertical displacement of C, positive downwards. The vertical springs, k at the
middle of ABC and 2 k at F, act on the turning bars like torsional springs of stiffness k (2 l)² at
A and 2 k (4 l)² at D, and with their forces there. Gravity is ignored.
"""

from dataclasses import replace

from numpy import cos, sqrt

from mecanique import model as mq
from mecanique.textbook import System, facts
from mecanique.textbook.systems.bars_and_springs import k, l, m
from mecanique.textbook.systems.bars_and_springs import mechanism as tree

# the tree of `bars_and_springs`, whose bars turn by q / (4 l) and move vertically
turn = mq.coordinate("q") / (4 * l)
mechanism = replace(
    tree,
    name="bars_and_springs_small",
    forces=(
        mq.JointSpring("spring_B", "A", k * (2 * l) ** 2),
        mq.JointSpring("spring_F", "D", 2 * k * (4 * l) ** 2),
        # the springs' vertical forces, moved to the pins, where they do no work
        mq.Force("pull_B", "ABC", (0, 0, 0), (0, 0, k * mq.coordinate("q") / 2)),
        mq.Force("push_F", "DEF", (0, 0, 0), (0, 0, 2 * k * mq.coordinate("q"))),
    ),
    coordinates=mq.Coordinates(("q",), {"alpha": turn, "delta": turn, "gamma": -turn}),
    parameters=(m, k, l),
)


def frequency(s: facts.Values) -> facts.Number:
    """Return ω of (17/4) m q'' + 9 k q = 0."""
    return sqrt(36 * s.k / (17 * s.m))


SYSTEM = System(
    title="Two massless bars on two springs, vertical motion only",
    source="Fundamentals of Dynamics, ch. 1, Example 1.2, Figure 1.11, eqs. Ex.1.2.a-Ex.1.2.j",
    build=mechanism,
    start={"q": 0.2},
    duration=6.0,
    tags=("chapter", "planar", "spring", "massless", "linear", "structure"),
    facts=(
        facts.Acceleration("(17/4) m q'' + 9 k q = 0", lambda s: [-36 * s.k * s.q / (17 * s.m)]),
        facts.KineticEnergy("T = 17 m q'² / 32", lambda s: 17 * s.m * s["q'"] ** 2 / 32),
        facts.Frequencies("ω = sqrt(36 k / (17 m))", lambda s: [frequency(s)]),
        facts.Solution(
            "q = q0 cos(ω t)",
            {"q": 0.2},
            lambda s: {"q": 0.2 * cos(frequency(s) * s.t)},
            until=lambda s: 2.0,
        ),
    ),
    forms={
        "T = 17 m q'^2/32": "Fundamentals of Dynamics, Example 1.2, by Lagrange's equations",
        "V = 9 k q^2/8": "Fundamentals of Dynamics, Example 1.2, by Lagrange's equations",
        "q'' + 36 k q/(17 m) = 0": "Fundamentals of Dynamics, eq. Ex.1.2.g, over 17 m/4",
    },
)
