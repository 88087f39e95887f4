"""Four-bar linkage.

A crank of length a and mass m1 and a rocker of length c and mass m3 turn about pins on the ground,
a distance d apart; a coupler of length b and mass m2 joins their ends. All bars are uniform and
move in one vertical plane under gravity g. The generalized coordinates are the angles phi of the
crank and psi of the rocker from the horizontal, positive upwards, and theta of the coupler against
the crank; the loop at the rocker's end leaves one of them free.
"""

from numpy import cos, pi, sin

from mecanique import model as mq
from mecanique.textbook import System, facts
from mecanique.textbook.joints import hinge

a = mq.Parameter("a", 1.0, "m", "length of the crank")
b = mq.Parameter("b", 2.2, "m", "length of the coupler")
c = mq.Parameter("c", 1.7, "m", "length of the rocker")
d = mq.Parameter("d", 2.0, "m", "distance of the pins on the ground")
m1 = mq.Parameter("m1", 1.0, "kg", "mass of the crank")
m2 = mq.Parameter("m2", 2.0, "kg", "mass of the coupler")
m3 = mq.Parameter("m3", 1.5, "kg", "mass of the rocker")
g = mq.Parameter("g", 9.81, "m/s²", "acceleration of free fall")

mechanism = mq.Mechanism(
    name="four_bar_linkage",
    bodies=(
        mq.Body("ground"),
        mq.Body("crank", mq.rod(m1, a, (1, 0, 0))),
        mq.Body("coupler", mq.rod(m2, b, (1, 0, 0))),
        mq.Body("rocker", mq.rod(m3, c, (1, 0, 0))),
    ),
    joints=(
        hinge("A", "ground", "crank", "phi"),
        hinge("B", "crank", "coupler", "theta", at=(a, 0, 0)),
        hinge("D", "ground", "rocker", "psi", at=(d, 0, 0)),
    ),
    loops=(mq.Loop.pin("C", "coupler", (b, 0, 0), "rocker", (c, 0, 0)),),
    parameters=(a, b, c, d, m1, m2, m3, g),
    gravity=(0, 0, -g),
)


def freudenstein(s: facts.Values) -> facts.Number:
    """Return (d/a) cos psi - (d/c) cos phi + K3 - cos(phi - psi), zero on the closed loop."""
    K3 = (s.a**2 - s.b**2 + s.c**2 + s.d**2) / (2 * s.a * s.c)
    return s.d / s.a * cos(s.psi) - s.d / s.c * cos(s.phi) + K3 - cos(s.phi - s.psi)


def kinetic(s: facts.Values) -> facts.Number:
    """Return T of the three bars."""
    turning, whole = s["phi'"] + s["theta'"], s.phi + s.theta
    tip = s.a * s["phi'"]
    coupler = tip**2 + s.b**2 * turning**2 / 3 + tip * s.b * turning * cos(whole - s.phi)
    return (s.m1 * tip**2 / 3 + s.m2 * coupler + s.m3 * (s.c * s["psi'"]) ** 2 / 3) / 2


def energy(s: facts.Values) -> facts.Number:
    """Return T + V."""
    height = s.m1 * s.a * sin(s.phi) / 2 + s.m3 * s.c * sin(s.psi) / 2
    height = height + s.m2 * (s.a * sin(s.phi) + s.b * sin(s.phi + s.theta) / 2)
    return kinetic(s) + s.g * height


def period(s: facts.Values) -> facts.Number:
    """Return the period of a parallelogram at amplitude 0.8 rad, by the elliptic integral K."""
    length = s.a * (s.m1 / 3 + s.m2 + s.m3 / 3) / (s.m1 / 2 + s.m2 + s.m3 / 2)
    return facts.swing_period(length, s.g, 0.8)


SYSTEM = System(
    title="Crank, coupler and rocker",
    source="F. Freudenstein, Trans. ASME 77 (1955) 853; Erdman & Sandor, Mechanism Design",
    build=mechanism,
    start={"phi": 1.1, "theta": -0.76, "psi": 1.25},
    tags=("linkage", "planar", "loop"),
    facts=(
        facts.Conserved(
            "the loop: (d/a) cos psi - (d/c) cos phi + (a²-b²+c²+d²)/(2 a c) = cos(phi - psi)",
            freudenstein,
        ),
        facts.KineticEnergy("T of three uniform bars", kinetic),
        facts.Conserved("the energy", energy),
        facts.Period(
            "as a parallelogram it swings like a pendulum of length "
            "a (m1/3 + m2 + m3/3) / (m1/2 + m2 + m3/2)",
            {"phi": 0.8 - pi / 2, "theta": pi / 2 - 0.8, "psi": 0.8 - pi / 2},
            period,
            given={"a": 0.8, "b": 1.5, "c": 0.8, "d": 1.5},
        ),
    ),
    forms={
        (
            "J phi'' + N phi'^2 + (m1 + 2 m2) g a cos(phi)/2 + m3 g c K_psi cos(psi)/2 + m2 g b "
            "(1 + K_theta) cos(phi + theta)/2 = 0"
        ): "Eksergian, J. Franklin Inst. 209 (1930) 21",
    },
)
