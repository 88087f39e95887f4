"""Rigid-bar pendulum.

A homogeneous rod of mass m and length l hangs from a pin at its upper end and swings in a vertical
plane under gravity g. The generalized coordinate q is the angle from the downward vertical,
positive towards +x.
"""

from numpy import cos, sin

from mecanique import model as mq
from mecanique.textbook import System, facts
from mecanique.textbook.joints import hinge

m = mq.Parameter("m", 1.0, "kg", "mass of the rod")
l = mq.Parameter("l", 1.0, "m", "length of the rod")
g = mq.Parameter("g", 9.81, "m/s²", "acceleration of free fall")

mechanism = mq.Mechanism(
    name="rigid_bar_pendulum",
    bodies=(mq.Body("ground"), mq.Body("rod", mq.rod(m, l))),
    joints=(hinge("pin", "ground", "rod", "q"),),
    parameters=(m, l, g),
    gravity=(0, 0, -g),
)


def reaction(s: facts.Values) -> tuple[float, float, float]:
    """Return the pin's force on the rod in world axes: R_n and R_t of eqs. 1.23 and 1.24."""
    qdd = -3 * s.g / (2 * s.l) * sin(s.q)
    Rn = s.m * s.g * cos(s.q) + s.m * s.l * s["q'"] ** 2 / 2
    Rt = s.m * s.g * sin(s.q) + s.m * s.l * qdd / 2
    return Rt * cos(s.q) - Rn * sin(s.q), 0.0, Rt * sin(s.q) + Rn * cos(s.q)


SYSTEM = System(
    title="Homogeneous rod, pinned at one end, under gravity",
    source="Fundamentals of Dynamics, ch. 1, Figure 1.4, eqs. 1.14-1.26",
    build=mechanism,
    start={"q": 2.0},
    tags=("chapter", "pendulum", "planar"),
    facts=(
        facts.Acceleration(
            "q'' = -3 g sin(q) / (2 l)", lambda s: [-3 * s.g / (2 * s.l) * sin(s.q)]
        ),
        facts.KineticEnergy("T = m l² q'² / 6", lambda s: s.m * s.l**2 * s["q'"] ** 2 / 6),
        facts.Conserved(
            "the energy m l² q'² / 6 - m g l cos(q) / 2",
            lambda s: s.m * s.l**2 * s["q'"] ** 2 / 6 - s.m * s.g * s.l * cos(s.q) / 2,
        ),
        facts.Reaction(
            "R_n = m g cos(q) + m l q'² / 2 and R_t = m g sin(q) + m l q'' / 2", "pin", reaction
        ),
        facts.Period(
            "swings of amplitude A last 4 sqrt(2 l / (3 g)) K(k), k = sin(A/2)",
            {"q": 2.0},
            lambda s: facts.swing_period(2 * s.l / 3, s.g, 2.0),
        ),
    ),
    forms={
        "q'' + 3 g sin(q)/(2 l) = 0": "Fundamentals of Dynamics, eq. 1.19",
        "q'' + 3 g q/(2 l) = 0": "Fundamentals of Dynamics, eq. 1.20",
        "T = m l^2 q'^2/6": "Fundamentals of Dynamics, eq. 1.33, with I about the pin",
    },
)
