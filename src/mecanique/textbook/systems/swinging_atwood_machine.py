"""Swinging Atwood machine.

A massless cord over two small pulleys at the distance d carries a counterweight M, which moves
up and down at the depth h − r below its pulley, and a particle m, which may also swing in the
vertical plane, under gravity g. The generalized coordinates are the length r of cord on the
particle's side, between 0 and h, and its angle theta from the downward vertical, positive
towards +x. For M = 3 m, and not otherwise, the motion has a second constant besides its energy.
"""

from numpy import cos, sin

from mecanique import model as mq
from mecanique.textbook import System, facts
from mecanique.textbook.joints import hinge, slide

HERE = (0.0, 0.0, 0.0)


M = mq.Parameter("M", 3.0, "kg", "mass of the counterweight")
m = mq.Parameter("m", 1.0, "kg", "mass of the particle")
d = mq.Parameter("d", 0.6, "m", "distance of the pulleys")
h = mq.Parameter("h", 2.0, "m", "depth of the counterweight below its pulley at r = 0")
g = mq.Parameter("g", 9.81, "m/s²", "acceleration of free fall")

# the counterweight and the particle on its turning cord
mechanism = mq.Mechanism(
    name="swinging_atwood_machine",
    bodies=(
        mq.Body("ground"),
        mq.Body("counterweight", mq.box(M, (0.15, 0.15, 0.15))),
        mq.Body("cord"),
        mq.Body("bob", mq.particle(m)),
    ),
    joints=(
        slide("lift", "ground", "counterweight", "up", at=(-d, 0, -h), axis=(0, 0, 1)),
        hinge("pulley", "ground", "cord", "theta"),
        mq.Prismatic("pay_out", "cord", "bob", axis=(0, 0, -1), coordinate="r"),
    ),
    coordinates=mq.Coordinates(("r", "theta"), {"up": mq.coordinate("r")}, limits={"r": (0, h)}),
    elements=(
        mq.Cord(
            "rope",
            ("counterweight", HERE),
            (
                mq.Pulley("ground", center=(-d, 0, 0), grips=False),
                mq.Pulley("ground", grips=False),
            ),
            ("bob", HERE),
        ),
    ),
    parameters=(M, m, d, h, g),
    gravity=(0, 0, -g),
)


def acceleration(s: facts.Values) -> tuple[facts.Number, facts.Number]:
    """Return r'' and theta''."""
    return (
        (s.m * s.r * s["theta'"] ** 2 + s.g * (s.m * cos(s.theta) - s.M)) / (s.M + s.m),
        -(s.g * sin(s.theta) + 2 * s["r'"] * s["theta'"]) / s.r,
    )


def energy(s: facts.Values) -> facts.Number:
    """Return T + V."""
    T = ((s.M + s.m) * s["r'"] ** 2 + s.m * (s.r * s["theta'"]) ** 2) / 2
    return T + s.g * s.r * (s.M - s.m * cos(s.theta))


def second(s: facts.Values) -> facts.Number:
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
    build=mechanism,
    start={"r": 1.0, "theta": 1.5},
    tags=("pulley", "pendulum", "planar", "chaos", "mimic"),
    facts=(
        facts.Acceleration(
            "(M + m) r'' = m r theta'² + g (m cos(theta) - M), "
            "r theta'' = -g sin(theta) - 2 r' theta'",
            acceleration,
        ),
        facts.MassMatrix("M = diag(M + m, m r²)", lambda s: [[s.M + s.m, 0], [0, s.m * s.r**2]]),
        facts.GuideForce(
            "the cord pulls with M (g + r'')",
            "rope",
            lambda s: s.M * (s.g + acceleration(s)[0]),
        ),
        facts.Conserved(
            "the energy ((M + m) r'² + m r² theta'²) / 2 + g r (M - m cos(theta))", energy
        ),
        facts.Conserved(
            "if M = 3 m, r² theta' (r' cos(theta/2) - r theta' sin(theta/2) / 2) "
            "+ g r² sin(theta/2) cos²(theta/2)",
            second,
            given={"M": 3.0, "m": 1.0},
        ),
    ),
    forms={
        "(M + m) r'' - m r theta'^2 + M g - m g cos(theta) = 0": (
            "Tufillaro, Abbott & Griffiths, with both masses"
        ),
        "r^2 theta'' + 2 r r' theta' + g r sin(theta) = 0": "Tufillaro, Abbott & Griffiths",
    },
)
