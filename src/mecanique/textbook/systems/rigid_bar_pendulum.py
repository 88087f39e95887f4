"""Rigid-bar pendulum.

A homogeneous rod of mass m and length l hangs from a pin at its upper end and swings in a vertical plane under
gravity g. The generalized coordinate q is the angle from the downward vertical, positive towards +x.
"""

from mecanique.model import Body, Mechanism, Parameter, Revolute, rod
from mecanique.textbook.system import System


def build(m: Parameter, l: Parameter, g: Parameter) -> Mechanism:  # noqa: E741 - the field's letter for a length
    """Return the pendulum."""
    return Mechanism(
        name="rigid_bar_pendulum",
        bodies=(Body("ground"), Body("rod", rod(m, l))),
        joints=(Revolute("pin", "ground", "rod", axis=(0, -1, 0), coordinate="q"),),
        parameters=(m, l, g),
        gravity=(0, 0, -g),
    )


SYSTEM = System(
    title="Homogeneous rod, pinned at one end, under gravity",
    source="Fundamentals of Dynamics, ch. 1, Figure 1.4, eqs. 1.14-1.26",
    parameters=(
        Parameter("m", 1.0, "kg", "mass of the rod"),
        Parameter("l", 1.0, "m", "length of the rod"),
        Parameter("g", 9.81, "m/s²", "acceleration of free fall"),
    ),
    build=build,
    start={"q": 2.0},
    tags=("chapter", "pendulum", "planar"),
)
