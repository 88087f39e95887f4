"""Double Atwood machine.

A cord over a fixed pulley carries a weight m1 at one end and a second pulley at the other; a cord
over that one carries weights m2 and m3. Cords and pulleys, of radius R, are massless, and gravity g
acts. The generalized coordinates are the distance x that m1 has descended and the distance y that
m2 has descended relative to the second pulley. At x = y = 0 all hang a depth h below the pulley
that carries them; what comes to the height of that pulley ends the motion.
"""

from mecanique.model import (
    Body,
    Coordinates,
    Cord,
    Cylinder,
    Mechanism,
    Parameter,
    Placement,
    Prismatic,
    Pulley,
    Visual,
    box,
    coordinate,
    massless,
)
from mecanique.textbook.facts import (
    Acceleration,
    Conserved,
    GuideForce,
    MassMatrix,
    Number,
    Steady,
    Values,
)
from mecanique.textbook.system import System

HERE = (0.0, 0.0, 0.0)
QUARTER = 1.5707963267948966


def build(
    m1: Parameter, m2: Parameter, m3: Parameter, R: Parameter, h: Parameter, g: Parameter
) -> Mechanism:
    """Return the weights and both pulleys."""
    x, y, size = coordinate("x"), coordinate("y"), (0.1, 0.1, 0.1)
    wheel = massless(
        Visual(Cylinder(R, 0.02), Placement(rpy=(QUARTER, 0, 0)), (0.6, 0.6, 0.6, 1.0))
    )
    return Mechanism(
        name="double_atwood_machine",
        bodies=(
            Body("ground", wheel),
            Body("pulley", wheel),
            Body("weight1", box(m1, size)),
            Body("weight2", box(m2, size)),
            Body("weight3", box(m3, size)),
        ),
        joints=(
            Prismatic(
                "rail1",
                "ground",
                "weight1",
                axis=(0, 0, -1),
                origin=Placement((-R, 0, -h)),
                coordinate="x",
            ),
            Prismatic(
                "hook",
                "ground",
                "pulley",
                axis=(0, 0, -1),
                origin=Placement((R, 0, -h)),
                coordinate="down",
            ),
            Prismatic(
                "rail2",
                "pulley",
                "weight2",
                axis=(0, 0, -1),
                origin=Placement((-R, 0, -h)),
                coordinate="y",
            ),
            Prismatic(
                "rail3",
                "pulley",
                "weight3",
                axis=(0, 0, -1),
                origin=Placement((R, 0, -h)),
                coordinate="y3",
            ),
        ),
        coordinates=Coordinates(
            ("x", "y"), {"down": -x, "y3": -y}, limits={"x": (-h, h), "y": (-h, h)}
        ),
        elements=(
            Cord(
                "cord", ("weight1", HERE), (Pulley("ground", R, -1, grips=False),), ("pulley", HERE)
            ),
            Cord(
                "second",
                ("weight2", HERE),
                (Pulley("pulley", R, -1, grips=False),),
                ("weight3", HERE),
            ),
        ),
        parameters=(m1, m2, m3, R, h, g),
        gravity=(0, 0, -g),
    )


def acceleration(s: Values) -> tuple[Number, Number]:
    """Return x'' and y''."""
    four, both = 4 * s.m2 * s.m3, s.m1 * (s.m2 + s.m3)
    return (both - four) * s.g / (both + four), 2 * s.m1 * (s.m2 - s.m3) * s.g / (both + four)


def tension(s: Values) -> Number:
    """Return the tension of the cord over the moving pulley."""
    return 4 * s.m1 * s.m2 * s.m3 * s.g / (s.m1 * (s.m2 + s.m3) + 4 * s.m2 * s.m3)


def energy(s: Values) -> Number:
    """Return T + V, with V zero at x = y = 0."""
    T = s.m1 * s["x'"] ** 2 + s.m2 * (s["y'"] - s["x'"]) ** 2 + s.m3 * (s["y'"] + s["x'"]) ** 2
    return T / 2 - s.g * (s.m1 * s.x + s.m2 * (s.y - s.x) - s.m3 * (s.y + s.x))


SYSTEM = System(
    title="Three weights on two cords over a fixed and a moving pulley",
    source="Taylor, Classical Mechanics, problem 7.27; Goldstein, Classical Mechanics, ch. 1",
    parameters=(
        Parameter("m1", 3.0, "kg", "mass of the weight on the fixed pulley's cord"),
        Parameter("m2", 2.0, "kg", "mass of one weight on the moving pulley's cord"),
        Parameter("m3", 1.0, "kg", "mass of the other"),
        Parameter("R", 0.2, "m", "radius of the pulleys"),
        Parameter(
            "h",
            1.0,
            "m",
            "depth of the weights and of the moving pulley below their pulleys at x = y = 0",
        ),
        Parameter("g", 9.81, "m/s²", "acceleration of free fall"),
    ),
    build=build,
    start={"x": -0.3, "y": -0.5},
    duration=0.7,
    tags=("pulley", "planar", "linear", "massless", "mimic"),
    facts=(
        Acceleration(
            "x'' = (m1 (m2 + m3) - 4 m2 m3) g / D, y'' = 2 m1 (m2 - m3) g / D, "
            "D = m1 (m2 + m3) + 4 m2 m3",
            acceleration,
        ),
        MassMatrix(
            "M = [[m1 + m2 + m3, m3 - m2], [m3 - m2, m2 + m3]]",
            lambda s: [[s.m1 + s.m2 + s.m3, s.m3 - s.m2], [s.m3 - s.m2, s.m2 + s.m3]],
        ),
        GuideForce(
            "the first cord pulls with 8 m1 m2 m3 g / D",
            "cord",
            lambda s: 2 * tension(s),
        ),
        GuideForce(
            "the second cord pulls with half of that, as its pulley has no mass", "second", tension
        ),
        Conserved("the energy", energy),
        Steady(
            "in balance if m1 = m2 + m3 and m2 = m3", {}, given={"m1": 2.0, "m2": 1.0, "m3": 1.0}
        ),
    ),
)
