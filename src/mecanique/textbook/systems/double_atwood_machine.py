"""Double Atwood machine.

A cord over a fixed pulley carries a weight m1 at one end and a second pulley at the other; a cord
over that one carries weights m2 and m3. Cords and pulleys, of radius R, are massless, and gravity g
acts. The generalized coordinates are the distance x that m1 has descended and the distance y that
m2 has descended relative to the second pulley. At x = y = 0 all hang a depth h below the pulley
that carries them; what comes to the height of that pulley ends the motion.
"""

from math import pi

from mecanique import model as mq
from mecanique.textbook import System, facts
from mecanique.textbook.joints import slide

HERE = (0.0, 0.0, 0.0)


m1 = mq.Parameter("m1", 3.0, "kg", "mass of the weight on the fixed pulley's cord")
m2 = mq.Parameter("m2", 2.0, "kg", "mass of one weight on the moving pulley's cord")
m3 = mq.Parameter("m3", 1.0, "kg", "mass of the other")
R = mq.Parameter("R", 0.2, "m", "radius of the pulleys")
h = mq.Parameter(
    "h",
    1.0,
    "m",
    "depth of the weights and of the moving pulley below their pulleys at x = y = 0",
)
g = mq.Parameter("g", 9.81, "m/s²", "acceleration of free fall")

x, y, size = mq.coordinate("x"), mq.coordinate("y"), (0.1, 0.1, 0.1)
wheel = mq.massless(
    mq.Visual(mq.Cylinder(R, 0.02), mq.Placement(rpy=(pi / 2, 0, 0)), (0.6, 0.6, 0.6, 1.0))
)
mechanism = mq.Mechanism(
    name="double_atwood_machine",
    bodies=(
        mq.Body("ground", wheel),
        mq.Body("pulley", wheel),
        mq.Body("weight1", mq.box(m1, size)),
        mq.Body("weight2", mq.box(m2, size)),
        mq.Body("weight3", mq.box(m3, size)),
    ),
    joints=(
        slide("rail1", "ground", "weight1", "x", at=(-R, 0, -h), axis=(0, 0, -1)),
        slide("hook", "ground", "pulley", "down", at=(R, 0, -h), axis=(0, 0, -1)),
        slide("rail2", "pulley", "weight2", "y", at=(-R, 0, -h), axis=(0, 0, -1)),
        slide("rail3", "pulley", "weight3", "y3", at=(R, 0, -h), axis=(0, 0, -1)),
    ),
    coordinates=mq.Coordinates(
        ("x", "y"), {"down": -x, "y3": -y}, limits={"x": (-h, h), "y": (-h, h)}
    ),
    elements=(
        mq.Cord(
            "cord",
            ("weight1", HERE),
            (mq.Pulley("ground", R, -1, grips=False),),
            ("pulley", HERE),
        ),
        mq.Cord(
            "second",
            ("weight2", HERE),
            (mq.Pulley("pulley", R, -1, grips=False),),
            ("weight3", HERE),
        ),
    ),
    parameters=(m1, m2, m3, R, h, g),
    gravity=(0, 0, -g),
)


def acceleration(s: facts.Values) -> tuple[facts.Number, facts.Number]:
    """Return x'' and y''."""
    four, both = 4 * s.m2 * s.m3, s.m1 * (s.m2 + s.m3)
    return (both - four) * s.g / (both + four), 2 * s.m1 * (s.m2 - s.m3) * s.g / (both + four)


def tension(s: facts.Values) -> facts.Number:
    """Return the tension of the cord over the moving pulley."""
    return 4 * s.m1 * s.m2 * s.m3 * s.g / (s.m1 * (s.m2 + s.m3) + 4 * s.m2 * s.m3)


def energy(s: facts.Values) -> facts.Number:
    """Return T + V, with V zero at x = y = 0."""
    T = s.m1 * s["x'"] ** 2 + s.m2 * (s["y'"] - s["x'"]) ** 2 + s.m3 * (s["y'"] + s["x'"]) ** 2
    return T / 2 - s.g * (s.m1 * s.x + s.m2 * (s.y - s.x) - s.m3 * (s.y + s.x))


SYSTEM = System(
    title="Three weights on two cords over a fixed and a moving pulley",
    source="Taylor, Classical Mechanics, problem 7.27; Goldstein, Classical Mechanics, ch. 1",
    build=mechanism,
    start={"x": -0.3, "y": -0.5},
    duration=0.7,
    tags=("pulley", "planar", "linear", "massless", "mimic"),
    facts=(
        facts.Acceleration(
            "x'' = (m1 (m2 + m3) - 4 m2 m3) g / D, y'' = 2 m1 (m2 - m3) g / D, "
            "D = m1 (m2 + m3) + 4 m2 m3",
            acceleration,
        ),
        facts.MassMatrix(
            "M = [[m1 + m2 + m3, m3 - m2], [m3 - m2, m2 + m3]]",
            lambda s: [[s.m1 + s.m2 + s.m3, s.m3 - s.m2], [s.m3 - s.m2, s.m2 + s.m3]],
        ),
        facts.GuideForce(
            "the first cord pulls with 8 m1 m2 m3 g / D",
            "cord",
            lambda s: 2 * tension(s),
        ),
        facts.GuideForce(
            "the second cord pulls with half of that, as its pulley has no mass", "second", tension
        ),
        facts.Conserved("the energy", energy),
        facts.Steady(
            "in balance if m1 = m2 + m3 and m2 = m3", {}, given={"m1": 2.0, "m2": 1.0, "m3": 1.0}
        ),
    ),
    forms={
        "x'' = (m1 m2 + m1 m3 - 4 m2 m3) g/(m1 m2 + m1 m3 + 4 m2 m3)": (
            "Taylor, problem 7.27: g/7 for masses as 4, 3 and 1"
        ),
    },
)
