"""Double pendulum of uniform rods.

A rod m1, l1 hangs from a fixed pin, a second rod m2, l2 from its lower end; both swing in one vertical plane under
gravity g. The generalized coordinates q1 and q2 are the angles of the rods from the downward vertical, positive
towards +x; the second joint turns by q2 − q1.
"""

from mecanique.model import Body, Coordinates, Mechanism, Parameter, Placement, Revolute, coordinate, rod
from mecanique.textbook.system import System


def build(m1: Parameter, m2: Parameter, l1: Parameter, l2: Parameter, g: Parameter) -> Mechanism:
    """Return the pendulum."""
    q1, q2 = coordinate("q1"), coordinate("q2")
    return Mechanism(
        name="double_pendulum",
        bodies=(Body("ground"), Body("rod1", rod(m1, l1)), Body("rod2", rod(m2, l2))),
        joints=(
            Revolute("pin1", "ground", "rod1", axis=(0, -1, 0), coordinate="q1"),
            Revolute("pin2", "rod1", "rod2", axis=(0, -1, 0), origin=Placement((0, 0, -l1)), coordinate="theta2"),
        ),
        coordinates=Coordinates(("q1", "q2"), {"theta2": q2 - q1}),
        parameters=(m1, m2, l1, l2, g),
        gravity=(0, 0, -g),
    )


SYSTEM = System(
    title="Two uniform rods, one hanging from the other",
    source="Goldstein, Classical Mechanics, ch. 1, ex. 22 (point masses); Levien & Tan, Am. J. Phys. 61 (1993) 1038",
    parameters=(
        Parameter("m1", 1.0, "kg", "mass of the upper rod"),
        Parameter("m2", 1.0, "kg", "mass of the lower rod"),
        Parameter("l1", 1.0, "m", "length of the upper rod"),
        Parameter("l2", 1.0, "m", "length of the lower rod"),
        Parameter("g", 9.81, "m/s²", "acceleration of free fall"),
    ),
    build=build,
    start={"q1": 2.0, "q2": 1.5},
    tags=("pendulum", "planar", "chaos"),
)
