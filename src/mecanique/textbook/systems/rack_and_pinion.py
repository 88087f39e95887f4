"""Rack and pinion.

A homogeneous pinion of mass m and pitch radius r, which a constant moment D drives about a fixed
axle, moves a rack of mass M on a level slide against a spring k; their teeth have the pressure
angle alpha. Gravity is g. The generalized coordinate x is the rack's way from where the spring is
slack; the pinion has turned by x / r. The teeth push along the line of action, and so part the
wheel and the rack as well.
"""

from numpy import cos, pi, sqrt, tan

from mecanique.model import (
    Body,
    Box,
    Coordinates,
    JointForce,
    JointSpring,
    Mechanism,
    Parameter,
    Placement,
    Prismatic,
    Rack,
    Revolute,
    Visual,
    box,
    coordinate,
    disk,
    massless,
)
from mecanique.textbook.facts import (
    Acceleration,
    Conserved,
    Frequencies,
    GuideForce,
    MassMatrix,
    Number,
    Period,
    Reaction,
    Values,
)
from mecanique.textbook.system import System

QUARTER = 1.5707963267948966


def build(
    m: Parameter,
    r: Parameter,
    M: Parameter,
    k: Parameter,
    D: Parameter,
    alpha: Parameter,
    g: Parameter,
) -> Mechanism:
    """Return the pinion above the rack."""
    mark = massless(Visual(Box((0.2 * r, 0.06, 1.3 * r)), rgba=(0.9, 0.6, 0.0, 1.0)))
    return Mechanism(
        name="rack_and_pinion",
        bodies=(
            Body("ground"),
            Body("pinion", disk(m, r, 0.05).at(rpy=(QUARTER, 0, 0)), mark),
            Body("rack", box(M, (8 * r, 0.05, 0.4 * r)).at((0, 0, -0.37 * r))),
        ),
        joints=(
            Revolute("axle", "ground", "pinion", axis=(0, -1, 0), coordinate="turn"),
            Prismatic(
                "slide",
                "ground",
                "rack",
                axis=(1, 0, 0),
                origin=Placement((0, 0, -r)),
                coordinate="x",
            ),
        ),
        forces=(JointForce("drive", "axle", D), JointSpring("spring", "slide", k)),
        coordinates=Coordinates(("x",), {"turn": coordinate("x") / r}),
        elements=(Rack("teeth", "axle", "slide", r, pressure_angle=alpha),),
        parameters=(m, r, M, k, D, alpha, g),
        gravity=(0, 0, -g),
    )


def inertia(s: Values) -> Number:
    """Return the mass that the drive has to move [kg]."""
    return s.M + s.m / 2


def pull(s: Values) -> Number:
    """Return the acceleration of the rack [m/s²]."""
    return (s.D / s.r - s.k * s.x) / inertia(s)


def push(s: Values) -> Number:
    """Return the force of the teeth along the rack [N]."""
    return s.M * pull(s) + s.k * s.x


def rate(s: Values) -> float:
    """Return the natural frequency [rad/s]."""
    return float(sqrt(s.k / inertia(s)))


SYSTEM = System(
    title="Rack and pinion",
    source="line of action and pressure angle as in J. J. Uicker, G. R. Pennock & J. E. Shigley, "
    "Theory of Machines and Mechanisms, 2003, ch. 7",
    parameters=(
        Parameter("m", 1.2, "kg", "mass of the pinion"),
        Parameter("r", 0.1, "m", "pitch radius of the pinion"),
        Parameter("M", 3.0, "kg", "mass of the rack"),
        Parameter("k", 60.0, "N/m", "stiffness of the spring"),
        Parameter("D", 1.5, "N·m", "moment that drives the pinion"),
        Parameter("alpha", pi / 9, "rad", "pressure angle"),
        Parameter("g", 9.81, "m/s²", "acceleration of free fall"),
    ),
    build=build,
    start={},
    duration=6.0,
    tags=("planar", "gear", "drive", "spring", "linear", "mimic"),
    facts=(
        Acceleration("(M + m/2) x'' = D/r - k x", lambda s: [pull(s)]),
        MassMatrix("M + m/2", lambda s: [[inertia(s)]]),
        Frequencies("ω = sqrt(k/(M + m/2))", lambda s: [rate(s)]),
        GuideForce(
            "the teeth push with (M x'' + k x)/cos(alpha)",
            "teeth",
            lambda s: push(s) / cos(s.alpha),
        ),
        Reaction(
            "the slide carries the rack and what parts them, |M x'' + k x| tan(alpha)",
            "slide",
            lambda s: [0.0, 0.0, s.M * s.g + abs(push(s)) * tan(s.alpha)],
        ),
        Conserved(
            "the energy (M + m/2) x'^2/2 + k x^2/2 - D x/r",
            lambda s: inertia(s) * s["x'"] ** 2 / 2 + s.k * s.x**2 / 2 - s.D * s.x / s.r,
        ),
        Period(
            "from rest it swings about D/(r k), T = 2 π sqrt((M + m/2)/k)",
            {},
            lambda s: 2 * pi / rate(s),
        ),
    ),
)
