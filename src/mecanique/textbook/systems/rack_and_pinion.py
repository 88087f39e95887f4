"""Rack and pinion.

A homogeneous pinion of mass m and pitch radius r, which a constant moment D drives about a fixed
axle, moves a rack of mass M on a level slide against a spring k; their teeth have the pressure
angle alpha. Gravity is g. The generalized coordinate x is the rack's way from where the spring is
slack; the pinion has turned by x / r. The teeth push along the line of action, and so part the
wheel and the rack as well.
"""

from numpy import cos, pi, sqrt, tan

from mecanique import model as mq
from mecanique.textbook import System, facts
from mecanique.textbook.joints import hinge, slide

m = mq.Parameter("m", 1.2, "kg", "mass of the pinion")
r = mq.Parameter("r", 0.1, "m", "pitch radius of the pinion")
M = mq.Parameter("M", 3.0, "kg", "mass of the rack")
k = mq.Parameter("k", 60.0, "N/m", "stiffness of the spring")
D = mq.Parameter("D", 1.5, "N·m", "moment that drives the pinion")
alpha = mq.Parameter("alpha", pi / 9, "rad", "pressure angle")
g = mq.Parameter("g", 9.81, "m/s²", "acceleration of free fall")

mark = mq.massless(mq.Visual(mq.Box((0.2 * r, 0.06, 1.3 * r)), rgba=(0.9, 0.6, 0.0, 1.0)))
mechanism = mq.Mechanism(
    name="rack_and_pinion",
    bodies=(
        mq.Body("ground"),
        mq.Body("pinion", mq.disk(m, r, 0.05).at(rpy=(pi / 2, 0, 0)), mark),
        mq.Body("rack", mq.box(M, (8 * r, 0.05, 0.4 * r)).at((0, 0, -0.37 * r))),
    ),
    joints=(
        hinge("axle", "ground", "pinion", "turn"),
        slide("slide", "ground", "rack", "x", at=(0, 0, -r), axis=(1, 0, 0)),
    ),
    forces=(mq.JointForce("drive", "axle", D), mq.JointSpring("spring", "slide", k)),
    coordinates=mq.Coordinates(("x",), {"turn": mq.coordinate("x") / r}),
    elements=(mq.Rack("teeth", "axle", "slide", r, pressure_angle=alpha),),
    parameters=(m, r, M, k, D, alpha, g),
    gravity=(0, 0, -g),
)


def inertia(s: facts.Values) -> facts.Number:
    """Return the mass that the drive has to move [kg]."""
    return s.M + s.m / 2


def pull(s: facts.Values) -> facts.Number:
    """Return the acceleration of the rack [m/s²]."""
    return (s.D / s.r - s.k * s.x) / inertia(s)


def push(s: facts.Values) -> facts.Number:
    """Return the force of the teeth along the rack [N]."""
    return s.M * pull(s) + s.k * s.x


def rate(s: facts.Values) -> float:
    """Return the natural frequency [rad/s]."""
    return float(sqrt(s.k / inertia(s)))


SYSTEM = System(
    title="Rack and pinion",
    source="line of action and pressure angle as in J. J. Uicker, G. R. Pennock & J. E. Shigley, "
    "Theory of Machines and Mechanisms, 2003, ch. 7",
    build=mechanism,
    duration=6.0,
    tags=("planar", "gear", "drive", "spring", "linear", "mimic"),
    facts=(
        facts.Acceleration("(M + m/2) x'' = D/r - k x", lambda s: [pull(s)]),
        facts.MassMatrix("M + m/2", lambda s: [[inertia(s)]]),
        facts.Frequencies("ω = sqrt(k/(M + m/2))", lambda s: [rate(s)]),
        facts.GuideForce(
            "the teeth push with (M x'' + k x)/cos(alpha)",
            "teeth",
            lambda s: push(s) / cos(s.alpha),
        ),
        facts.Reaction(
            "the slide carries the rack and what parts them, |M x'' + k x| tan(alpha)",
            "slide",
            lambda s: [0.0, 0.0, s.M * s.g + abs(push(s)) * tan(s.alpha)],
        ),
        facts.Conserved(
            "the energy (M + m/2) x'^2/2 + k x^2/2 - D x/r",
            lambda s: inertia(s) * s["x'"] ** 2 / 2 + s.k * s.x**2 / 2 - s.D * s.x / s.r,
        ),
        facts.Period(
            "from rest it swings about D/(r k), T = 2 π sqrt((M + m/2)/k)",
            {},
            lambda s: 2 * pi / rate(s),
        ),
    ),
    forms={
        "(M + m/2) x'' + k x - D/r = 0": (
            "Rao, Mechanical Vibrations, ch. 1, the equivalent mass m + J/R^2 of rack and pinion"
        ),
    },
)
