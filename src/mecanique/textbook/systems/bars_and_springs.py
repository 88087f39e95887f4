"""Bars and springs, in large motion.

Two massless bars ABC and DEF of length 4 l are pinned to the ground at A, a height l above D; a
massless bar CF of length l joins their free ends, so that ACFD is a parallelogram and CF stays
vertical. A particle m sits at B on ABC, 3 l from A, a particle 2 m at E in the middle of DEF. A
spring k holds the middle B' of ABC from above, a spring 2 k holds F from below, both of free length
a, relaxed and vertical while the bars are horizontal; gravity is ignored. The generalized
coordinate q is the vertical displacement of C, positive downwards; both bars turn by asin(q / (4
l)), exactly, for |q| < 4 l. The joint at F is closed by the parallelogram itself.
"""

from numpy import sqrt

from mecanique import model as mq
from mecanique.textbook import System, facts
from mecanique.textbook.joints import hinge

m = mq.Parameter("m", 1.0, "kg", "mass of the particle at B; the one at E has twice as much")
k = mq.Parameter("k", 50.0, "N/m", "stiffness of the spring at B'; the one at F has twice as much")
l = mq.Parameter("l", 0.5, "m", "a quarter of the bars' length")
a = mq.Parameter("a", 2.0, "m", "free length of the springs")

turn = mq.asin(mq.coordinate("q") / (4 * l))
mechanism = mq.Mechanism(
    name="bars_and_springs",
    bodies=(
        mq.Body("ground"),
        mq.Body("ABC", mq.bar(4 * l, (1, 0, 0)), mq.particle(m, (3 * l, 0, 0))),
        mq.Body("DEF", mq.bar(4 * l, (1, 0, 0)), mq.particle(2 * m, (2 * l, 0, 0))),
        mq.Body("CF", mq.bar(l, (0, 0, -1))),
    ),
    joints=(
        hinge("A", "ground", "ABC", "alpha", at=(0, 0, l), axis=(0, 1, 0)),
        mq.Revolute("D", "ground", "DEF", axis=(0, 1, 0), coordinate="delta"),
        hinge("C", "ABC", "CF", "gamma", at=(4 * l, 0, 0), axis=(0, 1, 0)),
    ),
    forces=(
        mq.Spring(
            "spring_B",
            "ground",
            (2 * l, 0, l + a),
            "ABC",
            (2 * l, 0, 0),
            stiffness=k,
            free_length=a,
        ),
        mq.Spring(
            "spring_F",
            "ground",
            (4 * l, 0, -a),
            "DEF",
            (4 * l, 0, 0),
            stiffness=2 * k,
            free_length=a,
        ),
    ),
    elements=(mq.Loop.pin("F", "CF", (0, 0, -l), "DEF", (4 * l, 0, 0)),),
    coordinates=mq.Coordinates(("q",), {"alpha": turn, "delta": turn, "gamma": -turn}),
    parameters=(m, k, l, a),
    gravity=(0, 0, 0),
)


def mass(s: facts.Values) -> facts.Number:
    """Return M: both particles on bars that turn at q' / sqrt(16 l² - q²)."""
    return 17 * s.m * s.l**2 / (16 * s.l**2 - s.q**2)


def energy(s: facts.Values) -> facts.Number:
    """Return T + V, with the springs' lengths exact."""
    drop, run = s.q / 2, 2 * s.l - sqrt(4 * s.l**2 - s.q**2 / 4)
    upper = sqrt(run**2 + (s.a + drop) ** 2) - s.a
    lower = sqrt((2 * run) ** 2 + (s.a - 2 * drop) ** 2) - s.a
    return mass(s) * s["q'"] ** 2 / 2 + s.k * upper**2 / 2 + s.k * lower**2


SYSTEM = System(
    title="Two massless bars coupled as a parallelogram, on two springs",
    source="Fundamentals of Dynamics, ch. 1, Example 1.2, Figure 1.11, "
    "without the restriction to small motion",
    build=mechanism,
    start={"q": 0.8},
    duration=6.0,
    tags=("chapter", "planar", "spring", "massless", "structure"),
    facts=(
        facts.MassMatrix("M = 17 m l² / (16 l² - q²)", lambda s: [[mass(s)]]),
        facts.KineticEnergy(
            "T = M q'² / 2, which is 17 m q'² / 32 while the bars are horizontal",
            lambda s: mass(s) * s["q'"] ** 2 / 2,
        ),
        facts.Frequencies(
            "linearized, (17/4) m q'' + 9 k q = 0", lambda s: [sqrt(36 * s.k / (17 * s.m))]
        ),
        facts.Conserved(
            "the energy M q'² / 2 + k (e_B² + 2 e_F²) / 2 with the springs' exact elongations",
            energy,
        ),
        facts.Steady("q = 0 is an equilibrium", {}),
    ),
    forms={
        "q'' + 36 k q/(17 m) = 0": "Fundamentals of Dynamics, eq. Ex.1.2.g, for small q",
    },
)
