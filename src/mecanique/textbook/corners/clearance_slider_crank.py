"""Slider-crank whose slider has clearance in its guide.

A crank of length l_1 and a rod of length l_2, with masses m_1, m_2 and inertias J_1, J_2 about
their middles, drive a block of mass m_3, inertia J_3, length 2 a and height 2 b in a guide wider by
the clearance c on either side. The block's corners strike and slide along the guide, with the
coefficients of restitution e and of friction mu, under gravity g. The generalized coordinates are
the angle p of the crank, and the turns q of the rod against it and s of the block against the rod.
"""

from math import pi

from numpy import array, cos

from mecanique import model as mq
from mecanique.textbook import System, facts
from mecanique.textbook.joints import hinge

l_1 = mq.Parameter("l_1", 0.153, "m", "length of the crank")
l_2 = mq.Parameter("l_2", 0.306, "m", "length of the rod")
m_1 = mq.Parameter("m_1", 0.038, "kg", "mass of the crank")
m_2 = mq.Parameter("m_2", 0.038, "kg", "mass of the rod")
m_3 = mq.Parameter("m_3", 0.076, "kg", "mass of the block")
J_1 = mq.Parameter("J_1", 7.4e-5, "kg·m²", "inertia of the crank")
J_2 = mq.Parameter("J_2", 5.9e-4, "kg·m²", "inertia of the rod")
J_3 = mq.Parameter("J_3", 2.7e-6, "kg·m²", "inertia of the block")
a = mq.Parameter("a", 0.025, "m", "half the length of the block")
b = mq.Parameter("b", 0.0125, "m", "half the height of the block")
c = mq.Parameter("c", 0.001, "m", "clearance on either side")
e = mq.Parameter("e", 0.4, "1", "coefficient of restitution")
mu = mq.Parameter("mu", 0.01, "1", "coefficient of friction")
g = mq.Parameter("g", 9.81, "m/s²", "acceleration of free fall")


def link(m: mq.Parameter, J: mq.Parameter, l: mq.Parameter) -> mq.Shape:
    """Return a bar of the linkage with its own moment of inertia."""
    drawn = mq.rod(m, l).at(rpy=(0, -pi / 2, 0)).visuals
    return mq.Shape(m, (l / 2, 0, 0), (J, J, J, 0, 0, 0), visuals=drawn)


drawn = mq.box(m_3, (2 * a, 2 * b, 2 * b)).visuals
block = mq.Shape(m_3, inertia=(J_3, J_3, J_3, 0, 0, 0), visuals=drawn)
walls = {
    1: mq.Placement((0, 0, b + c), (pi, 0, 0)),
    -1: mq.Placement((0, 0, -b - c)),
}
names = {1: "upper", -1: "lower"}
mechanism = mq.Mechanism(
    name="clearance_slider_crank",
    bodies=(
        mq.Body("ground"),
        mq.Body("crank", link(m_1, J_1, l_1)),
        mq.Body("rod", link(m_2, J_2, l_2)),
        mq.Body("block", block),
    ),
    joints=(
        hinge("shaft", "ground", "crank", "p"),
        hinge("crank_pin", "crank", "rod", "q", at=(l_1, 0, 0)),
        hinge("wrist_pin", "rod", "block", "s", at=(l_2, 0, 0)),
    ),
    parameters=(l_1, l_2, m_1, m_2, m_3, J_1, J_2, J_3, a, b, c, e, mu, g),
    gravity=(0, 0, -g),
    switching=tuple(
        mq.Contact(
            f"{names[side]} {where}",
            "block",
            center=(end * a, 0, side * b),
            plane=walls[side],
            mu=mu,
            restitution=e,
        )
        for side in (1, -1)
        for end, where in ((-1, "left"), (1, "right"))
    ),
)


def _absolute_mass(s: facts.Values) -> list[list[float]]:
    """The mass matrix of the rates of the three angles against the guide."""
    crank = s.J_1 + (s.m_1 / 4 + s.m_2 + s.m_3) * s.l_1**2
    coupled = (s.m_2 / 2 + s.m_3) * s.l_1 * s.l_2 * cos(s.q)
    coupler = s.J_2 + (s.m_2 / 4 + s.m_3) * s.l_2**2
    return [[crank, coupled, 0.0], [coupled, coupler, 0.0], [0.0, 0.0, s.J_3]]


def _mass_matrix(s: facts.Values) -> list[list[float]]:
    """The same of the rates of p, q and s, each an angle less than the one before."""
    M = array(_absolute_mass(s))
    # a rate turns its body and all beyond it: sums from the end, along rows and along columns
    sums = M[::-1, ::-1].cumsum(axis=0).cumsum(axis=1)[::-1, ::-1]
    rows: list[list[float]] = sums.tolist()
    return rows


def _kinetic_energy(s: facts.Values) -> float:
    M, rates = _absolute_mass(s), [s["p'"], s["p'"] + s["q'"], s["p'"] + s["q'"] + s["s'"]]
    return float(sum(M[i][k] * rates[i] * rates[k] for i in range(3) for k in range(3)) / 2)


SYSTEM = System(
    title="Slider-crank with clearance in its guide",
    source="Flores, Leine & Glocker, Multibody Syst. Dyn. 23 (2010) 165",
    build=mechanism,
    start_velocity={"p": 150.0, "q": -225.0, "s": 75.0},
    duration=0.05,
    tags=("planar", "impact", "friction", "contact", "corners"),
    facts=(
        facts.MassMatrix("M of the three angles, taken one from the other", _mass_matrix),
        facts.KineticEnergy(
            "T = ((J_1 + (m_1/4 + m_2 + m_3) l_1^2) w_1^2 + (J_2 + (m_2/4 + m_3) l_2^2) w_2^2"
            " + (m_2 + 2 m_3) l_1 l_2 w_1 w_2 cos(q) + J_3 w_3^2)/2",
            _kinetic_energy,
        ),
    ),
)
