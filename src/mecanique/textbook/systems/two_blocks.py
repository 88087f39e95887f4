"""Two blocks and two springs.

Two blocks slide without friction along a horizontal line. A spring k1 ties the first to a wall, a spring k2 ties the
second to the first, and a force F(t) acts on the second. The generalized coordinates q1 and q2 are the displacements
of the blocks from where both springs are free, positive away from the wall.
"""

from mecanique.model import Body, Force, Input, Mechanism, Parameter, Placement, Prismatic, Spring, box, time
from mecanique.textbook.system import System


def build(
    m1: Parameter, m2: Parameter, k1: Parameter, k2: Parameter, a: Parameter, F0: Parameter, W: Parameter
) -> Mechanism:
    """Return the blocks."""
    from sympy import cos

    size = (0.3, 0.3, 0.3)
    return Mechanism(
        name="two_blocks",
        bodies=(Body("ground"), Body("block1", box(m1, size)), Body("block2", box(m2, size))),
        joints=(
            Prismatic("slide1", "ground", "block1", axis=(1, 0, 0), origin=Placement((a, 0, 0)), coordinate="q1"),
            Prismatic("slide2", "ground", "block2", axis=(1, 0, 0), origin=Placement((2 * a, 0, 0)), coordinate="q2"),
        ),
        forces=(
            Spring("spring1", "ground", (0, 0, 0), "block1", (0, 0, 0), stiffness=k1, free_length=a),
            Spring("spring2", "block1", (0, 0, 0), "block2", (0, 0, 0), stiffness=k2, free_length=a),
            Force(
                "load",
                "block2",
                (0, 0, 0),
                force=(F := Input("F", F0 * cos(W * time()), "N", "force on block 2"), 0, 0),
            ),
        ),
        parameters=(m1, m2, k1, k2, a, F0, W),
        inputs=(F,),
    )


SYSTEM = System(
    title="Two blocks on a line, two springs and a force",
    source="Fundamentals of Dynamics, ch. 1, Example 1.1, Figure 1.8",
    parameters=(
        Parameter("m1", 2.0, "kg", "mass of block 1"),
        Parameter("m2", 1.0, "kg", "mass of block 2"),
        Parameter("k1", 40.0, "N/m", "stiffness of the spring to the wall"),
        Parameter("k2", 20.0, "N/m", "stiffness of the spring between the blocks"),
        Parameter("a", 1.0, "m", "free length of each spring"),
        Parameter("F0", 2.0, "N", "amplitude of the force"),
        Parameter("W", 3.0, "rad/s", "angular frequency of the force"),
    ),
    build=build,
    start={"q1": 0.2, "q2": -0.1},
    tags=("chapter", "planar", "spring", "linear"),
)
