"""Double pendulum of uniform rods.

A rod m1, l1 hangs from a fixed pin, a second rod m2, l2 from its lower end; both swing in one
vertical plane under gravity g. The generalized coordinates q1 and q2 are the angles of the rods
from the downward vertical, positive towards +x; the second joint turns by q2 − q1.
"""

from numpy import cos, sqrt

from mecanique.model import (
    Body,
    Coordinates,
    Mechanism,
    Parameter,
    Placement,
    Revolute,
    coordinate,
    rod,
)
from mecanique.textbook.facts import Conserved, Frequencies, MassMatrix, Number, Values
from mecanique.textbook.system import System


def build(m1: Parameter, m2: Parameter, l1: Parameter, l2: Parameter, g: Parameter) -> Mechanism:
    """Return the pendulum."""
    q1, q2 = coordinate("q1"), coordinate("q2")
    return Mechanism(
        name="double_pendulum",
        bodies=(Body("ground"), Body("rod1", rod(m1, l1)), Body("rod2", rod(m2, l2))),
        joints=(
            Revolute("pin1", "ground", "rod1", axis=(0, -1, 0), coordinate="q1"),
            Revolute(
                "pin2",
                "rod1",
                "rod2",
                axis=(0, -1, 0),
                origin=Placement((0, 0, -l1)),
                coordinate="theta2",
            ),
        ),
        coordinates=Coordinates(("q1", "q2"), {"theta2": q2 - q1}),
        parameters=(m1, m2, l1, l2, g),
        gravity=(0, 0, -g),
    )


def mass_matrix(s: Values) -> list[list[Number]]:
    """Return M: each rod's inertia about its pin; the upper rod carries the lower one's mass."""
    off = s.m2 * s.l1 * s.l2 / 2 * cos(s.q1 - s.q2)
    return [[(s.m1 / 3 + s.m2) * s.l1**2, off], [off, s.m2 * s.l2**2 / 3]]


def energy(s: Values) -> Number:
    """Return T + V, with V zero where all masses are at the height of the pin."""
    (a, b), (_, d) = mass_matrix(s)
    T = (a * s["q1'"] ** 2 + 2 * b * s["q1'"] * s["q2'"] + d * s["q2'"] ** 2) / 2
    return T - (s.m1 / 2 + s.m2) * s.g * s.l1 * cos(s.q1) - s.m2 * s.g * s.l2 / 2 * cos(s.q2)


def spin(s: Values) -> Number:
    """Return the angular momentum about the upper pin."""
    (a, b), (_, d) = mass_matrix(s)
    return (a + b) * s["q1'"] + (b + d) * s["q2'"]


SYSTEM = System(
    title="Two uniform rods, one hanging from the other",
    source="Goldstein, Classical Mechanics, ch. 1, ex. 22 (point masses); Levien & Tan, "
    "Am. J. Phys. 61 (1993) 1038",
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
    facts=(
        MassMatrix(
            "M = [[(m1/3 + m2) l1², m2 l1 l2 cos(q1 - q2) / 2], [m2 l1 l2 cos(q1 - q2) / 2, "
            "m2 l2² / 3]]",
            mass_matrix,
        ),
        Frequencies(
            "equal rods: ω² = 3 (1 ± 2 / sqrt(7)) g / l",
            lambda s: [sqrt(3 * (1 + sign * 2 / sqrt(7)) * s.g / s.l1) for sign in (-1, 1)],
            given={"m1": 1.0, "m2": 1.0, "l1": 1.0, "l2": 1.0},
        ),
        Conserved("the energy T - (m1/2 + m2) g l1 cos(q1) - m2 g l2 cos(q2) / 2", energy),
        Conserved(
            "without gravity, the angular momentum about the upper pin", spin, given={"g": 0.0}
        ),
    ),
)
