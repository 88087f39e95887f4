"""Bars and springs, as a closed loop.

Two massless bars ABC and DEF of length 4 l are pinned to the ground at A, a height l above D; a
massless bar CF of length l hangs on C and is pinned to the other bar's end at F, which closes the
loop. A particle m sits at B on ABC, 3 l from A, a particle 2 m at E in the middle of DEF. A spring
k holds the middle B' of ABC from above, a spring 2 k holds F from below, both of free length a,
relaxed and vertical while the bars are horizontal; gravity is ignored. The generalized coordinates
are the angles alpha of ABC and delta of DEF, positive downwards, and gamma of CF against ABC; the
loop leaves one of them free. The motion may be large: C falls by 4 l sin(alpha). The bar CF carries
no mass and stays vertical, so that its pins transmit vertical forces only. `bars_and_springs` is
the same assembly in the one coordinate 4 l sin(alpha), without a loop and with its equation in
letters.
"""

from dataclasses import replace

from numpy import cos, sin, sqrt

from mecanique import model as mq
from mecanique.textbook import System, facts
from mecanique.textbook.systems.bars_and_springs import k, l, m
from mecanique.textbook.systems.bars_and_springs import mechanism as tree

a = mq.Parameter("a", 0.8, "m", "free length of the springs")

# the assembly of `bars_and_springs` with a loop at F instead of its map
mechanism = replace(
    tree,
    name="bars_and_springs_loop",
    loops=(mq.Loop.pin("F", "CF", (0, 0, -l), "DEF", (4 * l, 0, 0)),),
    elements=(),
    coordinates=mq.Coordinates(()),
    parameters=(m, k, l, a),
)


def energy(s: facts.Values) -> facts.Number:
    """Return T + V."""
    drop, run = 2 * s.l * sin(s.alpha), 2 * s.l * (1 - cos(s.alpha))
    upper = sqrt(run**2 + (s.a + drop) ** 2) - s.a
    fall, way = 4 * s.l * sin(s.delta), 4 * s.l * (1 - cos(s.delta))
    lower = sqrt(way**2 + (s.a - fall) ** 2) - s.a
    return kinetic(s) + s.k * upper**2 / 2 + s.k * lower**2


def kinetic(s: facts.Values) -> facts.Number:
    """Return T."""
    return s.m * s.l**2 * (9 * s["alpha'"] ** 2 + 8 * s["delta'"] ** 2) / 2


SYSTEM = System(
    title="Two massless bars on springs, closed by a massless link",
    source="Fundamentals of Dynamics, ch. 1, Example 1.2, Figure 1.11, eqs. Ex.1.2.a-Ex.1.2.j; "
    "large motion exact",
    build=mechanism,
    start={"alpha": 0.4, "delta": 0.4, "gamma": -0.4},
    duration=6.0,
    tags=("chapter", "planar", "spring", "massless", "loop", "nonlinear", "structure"),
    facts=(
        facts.KineticEnergy("T = m l² (9 alpha'² + 8 delta'²) / 2", kinetic),
        facts.Conserved(
            "the energy T + k (upper - a)² / 2 + k (lower - a)², with the springs' exact lengths",
            energy,
        ),
    ),
    forms={
        "J = 9 m l^2 + 8 m l^2 K_delta^2": (
            "Eksergian, J. Franklin Inst. 209 (1930) 21; 17 m l^2 for the small motions of Example "
            "1.2"
        ),
    },
)
