"""Bars and springs, in small motion.

The assembly of `bars_and_springs` with all horizontal displacements neglected, as for small motion
about the horizontal: two massless bars ABC and DEF of length 4 l, pinned at A and D and coupled by
the bar CF, with particles m at B and 2 m at E. Both bars turn by q / (4 l), where the generalized
coordinate q is the vertical displacement of C, positive downwards. The vertical springs, k at the
middle of ABC and 2 k at F, act on the turning bars like torsional springs of stiffness k (2 l)² at
A and 2 k (4 l)² at D, and with their forces there. Gravity is ignored.
"""

from numpy import cos, sqrt

from mecanique.model import (
    Body,
    Coordinates,
    Force,
    JointSpring,
    Loop,
    Mechanism,
    Parameter,
    Placement,
    Revolute,
    bar,
    coordinate,
    particle,
)
from mecanique.textbook.facts import (
    Acceleration,
    Frequencies,
    KineticEnergy,
    Number,
    Solution,
    Values,
)
from mecanique.textbook.system import System


def build(m: Parameter, k: Parameter, l: Parameter) -> Mechanism:
    """Return the assembly as a tree whose bars follow q together."""
    turn = coordinate("q") / (4 * l)
    return Mechanism(
        name="bars_and_springs_small",
        bodies=(
            Body("ground"),
            Body("ABC", bar(4 * l, (1, 0, 0)), particle(m, (3 * l, 0, 0))),
            Body("DEF", bar(4 * l, (1, 0, 0)), particle(2 * m, (2 * l, 0, 0))),
            Body("CF", bar(l, (0, 0, -1))),
        ),
        joints=(
            Revolute(
                "A",
                "ground",
                "ABC",
                axis=(0, 1, 0),
                origin=Placement((0, 0, l)),
                coordinate="alpha",
            ),
            Revolute("D", "ground", "DEF", axis=(0, 1, 0), coordinate="delta"),
            Revolute(
                "C",
                "ABC",
                "CF",
                axis=(0, 1, 0),
                origin=Placement((4 * l, 0, 0)),
                coordinate="gamma",
            ),
        ),
        forces=(
            JointSpring("spring_B", "A", k * (2 * l) ** 2),
            JointSpring("spring_F", "D", 2 * k * (4 * l) ** 2),
            # the springs' vertical forces, moved to the pins, where they do no work
            Force("pull_B", "ABC", (0, 0, 0), (0, 0, k * coordinate("q") / 2)),
            Force("push_F", "DEF", (0, 0, 0), (0, 0, 2 * k * coordinate("q"))),
        ),
        elements=(Loop.pin("F", "CF", (0, 0, -l), "DEF", (4 * l, 0, 0)),),
        coordinates=Coordinates(("q",), {"alpha": turn, "delta": turn, "gamma": -turn}),
        parameters=(m, k, l),
        gravity=(0, 0, 0),
    )


def frequency(s: Values) -> Number:
    """Return ω of (17/4) m q'' + 9 k q = 0."""
    return sqrt(36 * s.k / (17 * s.m))


SYSTEM = System(
    title="Two massless bars on two springs, vertical motion only",
    source="Fundamentals of Dynamics, ch. 1, Example 1.2, Figure 1.11, eqs. Ex.1.2.a-Ex.1.2.j",
    parameters=(
        Parameter("m", 1.0, "kg", "mass of the particle at B; the one at E has twice as much"),
        Parameter(
            "k", 50.0, "N/m", "stiffness of the spring at B'; the one at F has twice as much"
        ),
        Parameter("l", 0.5, "m", "a quarter of the bars' length"),
    ),
    build=build,
    start={"q": 0.2},
    duration=6.0,
    tags=("chapter", "planar", "spring", "massless", "linear", "structure"),
    facts=(
        Acceleration("(17/4) m q'' + 9 k q = 0", lambda s: [-36 * s.k * s.q / (17 * s.m)]),
        KineticEnergy("T = 17 m q'² / 32", lambda s: 17 * s.m * s["q'"] ** 2 / 32),
        Frequencies("ω = sqrt(36 k / (17 m))", lambda s: [frequency(s)]),
        Solution(
            "q = q0 cos(ω t)",
            {"q": 0.2},
            lambda s: {"q": 0.2 * cos(frequency(s) * s.t)},
            until=lambda s: 2.0,
        ),
    ),
)
