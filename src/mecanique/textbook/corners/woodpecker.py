"""Woodpecker toy.

A sleeve of mass m_M and inertia J_M, wider than the pole of radius r_0 by its hole of radius r_M
and 2 h_M long, carries at the distance l_M from the pole a woodpecker of mass m_S and inertia J_S,
with its center l_G further out, on a spring c. The sleeve jams and slips, and the beak, h_S above
and l_S inside that center, strikes the pole, with coefficients of friction mu and restitution e_1
of the beak and e_3 of the sleeve's upper edge, under gravity g. The generalized coordinates are the
height y of the sleeve, its tilt a, and the turn s of the woodpecker against it.
"""

from math import pi

from numpy import arcsin, arctan2, cos, hypot

from mecanique import model as mq
from mecanique.textbook import System, facts
from mecanique.textbook.joints import hinge

m_M = mq.Parameter("m_M", 0.0003, "kg", "mass of the sleeve")
J_M = mq.Parameter("J_M", 5e-9, "kg·m²", "inertia of the sleeve")
m_S = mq.Parameter("m_S", 0.0045, "kg", "mass of the woodpecker")
J_S = mq.Parameter("J_S", 7e-7, "kg·m²", "inertia of the woodpecker")
c = mq.Parameter("c", 0.0056, "N·m/rad", "stiffness of the spring")
r_0 = mq.Parameter("r_0", 0.0025, "m", "radius of the pole")
r_M = mq.Parameter("r_M", 0.0031, "m", "radius of the sleeve's hole")
h_M = mq.Parameter("h_M", 0.0058, "m", "half the length of the sleeve")
l_M = mq.Parameter("l_M", 0.010, "m", "distance of the spring from the pole")
l_G = mq.Parameter("l_G", 0.015, "m", "distance of the woodpecker's center from the spring")
h_S = mq.Parameter("h_S", 0.02, "m", "height of the beak")
l_S = mq.Parameter("l_S", 0.0201, "m", "distance of the beak from the center")
mu = mq.Parameter("mu", 0.3, "1", "coefficient of friction")
e_1 = mq.Parameter("e_1", 0.5, "1", "coefficient of restitution of the beak")
e_3 = mq.Parameter("e_3", 0.0, "1", "coefficient of restitution of the sleeve's upper edge")
g = mq.Parameter("g", 9.81, "m/s²", "acceleration of free fall")

pole = mq.Placement((r_0, 0, 0), (0, pi / 2, 0))
hole = mq.box(m_M, (2 * r_M, 2 * r_M, 2 * h_M)).visuals
sleeve = mq.Shape(m_M, inertia=(J_M, J_M, J_M, 0, 0, 0), visuals=hole)
feathers = mq.box(m_S, (l_S / 2, r_0, 2 * h_S)).visuals
bird = mq.Shape(m_S, inertia=(J_S, J_S, J_S, 0, 0, 0), visuals=feathers).at((l_G, 0, 0))
mechanism = mq.Mechanism(
    name="woodpecker",
    bodies=(
        mq.Body("ground"),
        mq.Body("carriage", mq.massless()),
        mq.Body("sleeve", sleeve),
        mq.Body("woodpecker", bird),
    ),
    joints=(
        mq.Prismatic("pole", "ground", "carriage", axis=(0, 0, 1), coordinate="y"),
        hinge("tilt", "carriage", "sleeve", "a"),
        hinge("spring", "sleeve", "woodpecker", "s", at=(l_M, 0, 0)),
    ),
    forces=(mq.JointSpring("leaf", "spring", c),),
    parameters=(m_M, J_M, m_S, J_S, c, r_0, r_M, h_M, l_M, l_G, h_S, l_S, mu, e_1, e_3, g),
    gravity=(0, 0, -g),
    switching=(
        mq.Contact(
            "beak",
            "woodpecker",
            center=(l_G - l_S, 0, h_S),
            plane=pole,
            mu=mu,
            restitution=e_1,
            law="poisson",
        ),
        mq.Contact("lower", "sleeve", center=(r_M, 0, -h_M), plane=pole, mu=mu, law="poisson"),
        mq.Contact(
            "upper",
            "sleeve",
            center=(r_M, 0, h_M),
            plane=pole,
            mu=mu,
            restitution=e_3,
            law="poisson",
        ),
    ),
)


def _mass_matrix(s: facts.Values) -> list[list[float]]:
    both = s.a + s.s
    lever, reach = s.l_M * cos(s.a), s.l_G * cos(both)
    cross = s.J_S + s.m_S * s.l_G**2 + s.m_S * s.l_M * s.l_G * cos(s.s)
    swing = s.J_S + s.m_S * s.l_G**2
    tilt = s.J_M + s.m_S * s.l_M**2 + s.m_S * s.l_M * s.l_G * cos(s.s) + cross
    lift = s.m_S * (lever + reach)
    return [
        [s.m_M + s.m_S, lift, s.m_S * reach],
        [lift, tilt, cross],
        [s.m_S * reach, cross, swing],
    ]


SYSTEM = System(
    title="Woodpecker toy, which pecks its way down a pole",
    source="Glocker & Studer, Multibody Syst. Dyn. 13 (2005) 447; Pfeiffer & Glocker, "
    "Multibody Dynamics with Unilateral Contacts, 1996",
    build=mechanism,
    start={"a": -0.1, "s": -0.15},
    start_velocity={"s": -7.4583, "y": -0.3411},
    duration=0.3,
    tags=("planar", "friction", "impact", "contact", "corners"),
    facts=(
        facts.MassMatrix("M of the two bodies on their slide and hinges", _mass_matrix),
        facts.Occurs(
            "the sleeve jams where r_M cos(a) + h_M sin(a) = r_0",
            "lower: sticks",
            lambda s: {"a": arcsin(s.r_0 / hypot(s.r_M, s.h_M)) - arctan2(s.r_M, s.h_M)},
        ),
    ),
)
