"""Swinging Atwood machine.

A massless cord over two small pulleys at the distance d carries a counterweight M, which moves
up and down at the depth h − r below its pulley, and a particle m, which may also swing in the
vertical plane, under gravity g. The generalized coordinates are the length r of cord on the
particle's side, between 0 and h, and its angle theta from the downward vertical, positive
towards +x. For M = 3 m, and not otherwise, the motion has a second constant besides its energy.
"""

from numpy import cos, sin

from mecanique.model import (
    Body,
    Coordinates,
    Cord,
    Mechanism,
    Parameter,
    Placement,
    Prismatic,
    Pulley,
    Revolute,
    box,
    coordinate,
    particle,
)
from mecanique.textbook.facts import (
    Acceleration,
    Conserved,
    GuideForce,
    MassMatrix,
    Number,
    Values,
)
from mecanique.textbook.system import System

HERE = (0.0, 0.0, 0.0)


def build(M: Parameter, m: Parameter, d: Parameter, h: Parameter, g: Parameter) -> Mechanism:
    """Return the counterweight and the particle on its turning cord."""
    return Mechanism(
        name="swinging_atwood_machine",
        bodies=(
            Body("ground"),
            Body("counterweight", box(M, (0.15, 0.15, 0.15))),
            Body("cord"),
            Body("bob", particle(m)),
        ),
        joints=(
            Prismatic(
                "lift",
                "ground",
                "counterweight",
                axis=(0, 0, 1),
                origin=Placement((-d, 0, -h)),
                coordinate="up",
            ),
            Revolute("pulley", "ground", "cord", axis=(0, -1, 0), coordinate="theta"),
            Prismatic("pay_out", "cord", "bob", axis=(0, 0, -1), coordinate="r"),
        ),
        coordinates=Coordinates(("r", "theta"), {"up": coordinate("r")}, limits={"r": (0, h)}),
        elements=(
            Cord(
                "rope",
                ("counterweight", HERE),
                (
                    Pulley("ground", center=(-d, 0, 0), grips=False),
                    Pulley("ground", grips=False),
                ),
                ("bob", HERE),
            ),
        ),
        parameters=(M, m, d, h, g),
        gravity=(0, 0, -g),
    )


def acceleration(s: Values) -> tuple[Number, Number]:
    """Return r'' and theta''."""
    return (
        (s.m * s.r * s["theta'"] ** 2 + s.g * (s.m * cos(s.theta) - s.M)) / (s.M + s.m),
        -(s.g * sin(s.theta) + 2 * s["r'"] * s["theta'"]) / s.r,
    )


def energy(s: Values) -> Number:
    """Return T + V."""
    T = ((s.M + s.m) * s["r'"] ** 2 + s.m * (s.r * s["theta'"]) ** 2) / 2
    return T + s.g * s.r * (s.M - s.m * cos(s.theta))


def second(s: Values) -> Number:
    """Return the second integral of the case M = 3 m, per m r (Tufillaro 1986)."""
    half, w = s.theta / 2, s.r * s["theta'"]
    return (
        s.r * w * (s["r'"] * cos(half) - w / 2 * sin(half))
        + s.g * s.r**2 * sin(half) * cos(half) ** 2
    )


SYSTEM = System(
    title="Counterweight and a swinging particle on one cord",
    source="Tufillaro, Abbott & Griffiths, Am. J. Phys. 52 (1984) 895; Tufillaro, "
    "Am. J. Phys. 54 (1986) 142",
    parameters=(
        Parameter("M", 3.0, "kg", "mass of the counterweight"),
        Parameter("m", 1.0, "kg", "mass of the particle"),
        Parameter("d", 0.6, "m", "distance of the pulleys"),
        Parameter("h", 2.0, "m", "depth of the counterweight below its pulley at r = 0"),
        Parameter("g", 9.81, "m/s²", "acceleration of free fall"),
    ),
    build=build,
    start={"r": 1.0, "theta": 1.5},
    duration=10.0,
    tags=("pulley", "pendulum", "planar", "chaos", "mimic"),
    facts=(
        Acceleration(
            "(M + m) r'' = m r theta'² + g (m cos(theta) - M), "
            "r theta'' = -g sin(theta) - 2 r' theta'",
            acceleration,
        ),
        MassMatrix("M = diag(M + m, m r²)", lambda s: [[s.M + s.m, 0], [0, s.m * s.r**2]]),
        GuideForce(
            "the cord pulls with M (g + r'')",
            "rope",
            lambda s: s.M * (s.g + acceleration(s)[0]),
        ),
        Conserved("the energy ((M + m) r'² + m r² theta'²) / 2 + g r (M - m cos(theta))", energy),
        Conserved(
            "if M = 3 m, r² theta' (r' cos(theta/2) - r theta' sin(theta/2) / 2) "
            "+ g r² sin(theta/2) cos²(theta/2)",
            second,
            given={"M": 3.0, "m": 1.0},
        ),
    ),
)
