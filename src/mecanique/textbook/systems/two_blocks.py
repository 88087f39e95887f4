"""Two blocks and two springs.

Two blocks m1 and m2 slide without friction along a horizontal line. A spring k1 of free length a
ties the first to a wall, an equally long spring k2 ties the second to the first, and a force F(t) =
F0 cos(W t) acts on the second; gravity g only presses the blocks on the line. The generalized
coordinates q1 and q2 are the displacements of the blocks from where both springs are free, positive
away from the wall.
"""

import numpy as np

from mecanique import model as mq
from mecanique.textbook import System, facts
from mecanique.textbook.joints import slide

m1 = mq.Parameter("m1", 2.0, "kg", "mass of block 1")
m2 = mq.Parameter("m2", 1.0, "kg", "mass of block 2")
k1 = mq.Parameter("k1", 40.0, "N/m", "stiffness of the spring to the wall")
k2 = mq.Parameter("k2", 20.0, "N/m", "stiffness of the spring between the blocks")
a = mq.Parameter("a", 1.0, "m", "free length of each spring")
F0 = mq.Parameter("F0", 1.0, "N", "amplitude of the force")
W = mq.Parameter("W", 3.0, "rad/s", "angular frequency of the force")
g = mq.Parameter("g", 9.81, "m/s²", "acceleration of free fall")

size = (0.3, 0.3, 0.3)
mechanism = mq.Mechanism(
    name="two_blocks",
    bodies=(
        mq.Body("ground"),
        mq.Body("block1", mq.box(m1, size)),
        mq.Body("block2", mq.box(m2, size)),
    ),
    joints=(
        slide("slide1", "ground", "block1", "q1", at=(a, 0, 0), axis=(1, 0, 0)),
        slide("slide2", "ground", "block2", "q2", at=(2 * a, 0, 0), axis=(1, 0, 0)),
    ),
    forces=(
        mq.Spring("spring1", "ground", (0, 0, 0), "block1", (0, 0, 0), stiffness=k1, free_length=a),
        mq.Spring("spring2", "block1", (0, 0, 0), "block2", (0, 0, 0), stiffness=k2, free_length=a),
        mq.Force(
            "load",
            "block2",
            (0, 0, 0),
            force=(F := mq.Input("F", F0 * mq.cos(W * mq.time()), "N", "force on block 2"), 0, 0),
        ),
    ),
    parameters=(m1, m2, k1, k2, a, F0, W, g),
    inputs=(F,),
    gravity=(0, 0, -g),
)


def frequencies(s: facts.Values) -> tuple[float, float]:
    """Return both roots of ω⁴ m1 m2 - ω² (m1 k2 + m2 (k1 + k2)) + k1 k2 = 0."""
    b = s.m1 * s.k2 + s.m2 * (s.k1 + s.k2)
    root = np.sqrt(b**2 - 4 * s.m1 * s.m2 * s.k1 * s.k2)
    return np.sqrt((b - root) / (2 * s.m1 * s.m2)), np.sqrt((b + root) / (2 * s.m1 * s.m2))


def amplitudes(s: facts.Values) -> tuple[float, float]:
    """Return the amplitudes of the forced motion at the force's frequency, by Cramer's rule."""
    d1, d2 = s.k1 + s.k2 - s.m1 * s.W**2, s.k2 - s.m2 * s.W**2
    return s.k2 * s.F0 / (d1 * d2 - s.k2**2), d1 * s.F0 / (d1 * d2 - s.k2**2)


def respond(s: facts.Values) -> dict[str, float]:
    """Return the forced motion."""
    Q1, Q2 = amplitudes(s)
    return {"q1": Q1 * np.cos(s.W * s.t), "q2": Q2 * np.cos(s.W * s.t)}


SYSTEM = System(
    title="Two blocks on a line, two springs and a force",
    source="Fundamentals of Dynamics, ch. 1, Example 1.1, Figure 1.8",
    build=mechanism,
    start={"q1": 0.2, "q2": -0.1},
    tags=("chapter", "planar", "spring", "linear"),
    facts=(
        facts.Acceleration(
            "m1 q1'' + (k1 + k2) q1 - k2 q2 = 0 and m2 q2'' - k2 q1 + k2 q2 = F0 cos(W t)",
            lambda s: [
                (-(s.k1 + s.k2) * s.q1 + s.k2 * s.q2) / s.m1,
                (s.k2 * s.q1 - s.k2 * s.q2 + s.F0 * np.cos(s.W * s.t)) / s.m2,
            ],
        ),
        facts.Frequencies("ω⁴ m1 m2 - ω² (m1 k2 + m2 (k1 + k2)) + k1 k2 = 0", frequencies),
        facts.Solution(
            "the forced motion is (Q1, Q2) cos(W t), Q1 = k2 F0 / D, "
            "Q2 = (k1 + k2 - m1 W²) F0 / D, D = det(K - W² M)",
            lambda s: dict(zip(("q1", "q2"), amplitudes(s), strict=True)),
            respond,
            until=lambda s: 3.0,
            given={"W": 5.0},
        ),
        facts.Conserved(
            "without the force, the energy (m1 q1'² + m2 q2'² + k1 q1² + k2 (q2 - q1)²) / 2",
            lambda s: (
                (
                    s.m1 * s["q1'"] ** 2
                    + s.m2 * s["q2'"] ** 2
                    + s.k1 * s.q1**2
                    + s.k2 * (s.q2 - s.q1) ** 2
                )
                / 2
            ),
            given={"F0": 0.0},
        ),
    ),
    forms={
        "m1 q1'' + (k1 + k2) q1 - k2 q2 = 0": "Fundamentals of Dynamics, Example 1.1",
        "m2 q2'' + k2 (q2 - q1) = F": "Fundamentals of Dynamics, Example 1.1",
        "V = k1 q1^2/2 + k2 (q2 - q1)^2/2": (
            "Fundamentals of Dynamics, Example 1.1, by Lagrange's equations"
        ),
    },
)
