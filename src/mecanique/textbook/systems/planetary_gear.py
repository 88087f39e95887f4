"""Planetary gear.

A sun wheel of pitch radius rs and moment of inertia Js, an arm of moment of inertia Ja and a ring
with teeth inside, of moment of inertia Jr, turn about one axis. The arm carries a planet of mass m,
pitch radius rp and moment of inertia Jp, which meshes with both; all teeth have the pressure angle
alpha. The moment D drives the sun, the moment B brakes the ring, gravity g pulls at the planet. The
generalized coordinates are the turns sun and arm; planet and ring follow (Willis): the planet has
turned against the arm by (sun - arm) rs/rp the other way, the ring by (sun - arm) rs/(rs + 2 rp).
"""

from numpy import array, cos, pi, sin
from numpy.linalg import solve

from mecanique.model import (
    Body,
    Box,
    Coordinates,
    Cylinder,
    Gear,
    JointForce,
    Mechanism,
    Parameter,
    Placement,
    Revolute,
    Shape,
    Visual,
    coordinate,
)
from mecanique.model.bodies.visuals import Rgba
from mecanique.textbook.facts import (
    Acceleration,
    Conserved,
    GuideForce,
    KineticEnergy,
    MassMatrix,
    Number,
    Values,
)
from mecanique.textbook.system import System

QUARTER = 1.5707963267948966
ACROSS = (0.0, -1.0, 0.0)
ORANGE = (0.9, 0.6, 0.0, 1.0)
BLUE, GREEN, PALE = (0.0, 0.38, 0.63, 1.0), (0.0, 0.52, 0.42, 1.0), (0.72, 0.76, 0.8, 1.0)


def build(
    rs: Parameter,
    Js: Parameter,
    Ja: Parameter,
    Jr: Parameter,
    m: Parameter,
    rp: Parameter,
    Jp: Parameter,
    alpha: Parameter,
    D: Parameter,
    B: Parameter,
    g: Parameter,
) -> Mechanism:
    """Return the four wheels, the sun driven and the ring braked."""
    sun, arm = coordinate("sun"), coordinate("arm")
    ring = rs + 2 * rp
    bar = Visual(Box((0.03, 0.02, rs + rp)), Placement((0, -0.06, (rs + rp) / 2)), ORANGE)
    band = Visual(Cylinder(1.1 * ring, 0.02), Placement((0, 0.03, 0), (QUARTER, 0, 0)), PALE)
    return Mechanism(
        name="planetary_gear",
        bodies=(
            Body("ground"),
            Body("sun", wheel(0, rs, Js, BLUE)),
            Body("arm", Shape(0, (0, 0, 0), (Ja, Ja, Ja, 0, 0, 0), (bar,))),
            Body("planet", wheel(m, rp, Jp, GREEN)),
            Body("ring", Shape(0, (0, 0, 0), (Jr / 2, Jr, Jr / 2, 0, 0, 0), (band,))),
        ),
        joints=(
            Revolute("sun_axle", "ground", "sun", coordinate="sun", axis=ACROSS),
            Revolute("arm_axle", "ground", "arm", coordinate="arm", axis=ACROSS),
            Revolute(
                "planet_pin",
                "arm",
                "planet",
                origin=Placement((0, 0, rs + rp)),
                coordinate="planet",
                axis=ACROSS,
            ),
            Revolute("ring_axle", "ground", "ring", coordinate="ring", axis=ACROSS),
        ),
        forces=(JointForce("drive", "sun_axle", D), JointForce("brake", "ring_axle", B)),
        coordinates=Coordinates(
            ("sun", "arm"),
            {"planet": -(sun - arm) * rs / rp, "ring": arm - (sun - arm) * rs / ring},
        ),
        elements=(
            Gear("inner", "sun_axle", "planet_pin", rs, other_radius=rp, pressure_angle=alpha),
            Gear(
                "outer",
                "ring_axle",
                "planet_pin",
                ring,
                other_radius=rp,
                internal=True,
                pressure_angle=alpha,
            ),
        ),
        parameters=(rs, Js, Ja, Jr, m, rp, Jp, alpha, D, B, g),
        gravity=(0, 0, -g),
    )


def wheel(mass: Parameter | int, r: Parameter, inertia: Parameter, color: Rgba) -> Shape:
    """Return a wheel with a mark."""
    rim = Visual(Cylinder(r, 0.04), Placement(rpy=(QUARTER, 0, 0)), color)
    mark = Visual(Box((0.1 * r, 0.06, 1.4 * r)), rgba=ORANGE)
    return Shape(mass, (0, 0, 0), (inertia / 2, inertia, inertia / 2, 0, 0, 0), (rim, mark))


def turns(s: Values) -> Number:
    """Return how sun, arm, planet and ring turn with sun and arm, shape (4, 2)."""
    p, k = s.rs / s.rp, s.rs / (s.rs + 2 * s.rp)
    return array([[1, 0], [0, 1], [-p, 1 + p], [-k, 1 + k]])


def mass_matrix(s: Values) -> Number:
    """Return the sum of all moments of inertia, each as its wheel turns, shape (2, 2)."""
    moments = array([s.Js, s.Ja + s.m * (s.rs + s.rp) ** 2, s.Jp, s.Jr])
    return turns(s).T @ (moments[:, None] * turns(s))


def accelerations(s: Values) -> Number:
    """Return sun'' and arm''."""
    weight = s.m * s.g * (s.rs + s.rp) * sin(s.arm)
    return solve(mass_matrix(s), turns(s).T @ array([s.D, 0, 0, s.B]) + array([0, weight]))


def kinetic(s: Values) -> Number:
    """Return the kinetic energy [J]."""
    rates = array([s["sun'"], s["arm'"]])
    return rates @ mass_matrix(s) @ rates / 2


def energy(s: Values) -> Number:
    """Return T + V, less the work of the drives [J]."""
    work = array([s.D, 0, 0, s.B]) @ turns(s) @ array([s.sun, s.arm])
    return kinetic(s) + s.m * s.g * (s.rs + s.rp) * cos(s.arm) - work


def inner(s: Values) -> Number:
    """Return the force of the sun on the planet, which the sun's balance demands [N]."""
    return (s.D - s.Js * accelerations(s)[0]) / (s.rs * cos(s.alpha))


def outer(s: Values) -> Number:
    """Return the force of the ring on the planet, which the ring's balance demands [N]."""
    ring = (turns(s) @ accelerations(s))[3]
    return (s.B - s.Jr * ring) / ((s.rs + 2 * s.rp) * cos(s.alpha))


SYSTEM = System(
    title="Planetary gear with two inputs",
    source="R. Willis, Principles of Mechanism, 1841; J. J. Uicker, G. R. Pennock & J. E. Shigley, "
    "Theory of Machines and Mechanisms, 2003, ch. 9",
    parameters=(
        Parameter("rs", 0.1, "m", "pitch radius of the sun"),
        Parameter("Js", 0.004, "kg·m²", "moment of inertia of the sun"),
        Parameter("Ja", 0.01, "kg·m²", "moment of inertia of the arm"),
        Parameter("Jr", 0.06, "kg·m²", "moment of inertia of the ring"),
        Parameter("m", 0.5, "kg", "mass of the planet"),
        Parameter("rp", 0.06, "m", "pitch radius of the planet"),
        Parameter("Jp", 0.001, "kg·m²", "moment of inertia of the planet"),
        Parameter("alpha", pi / 9, "rad", "pressure angle"),
        Parameter("D", 0.05, "N·m", "moment that drives the sun"),
        Parameter("B", 0.03, "N·m", "moment on the ring"),
        Parameter("g", 9.81, "m/s²", "acceleration of free fall"),
    ),
    build=build,
    start={},
    duration=5.0,
    tags=("planar", "gear", "drive", "linear", "mimic"),
    facts=(
        Acceleration(
            "M (sun'', arm'') = D and B as sun and ring turn, and m g (rs + rp) sin(arm) on arm",
            accelerations,
        ),
        MassMatrix("M = sum of J c c^T, c the turns of a wheel with sun and arm", mass_matrix),
        KineticEnergy("T = (sun', arm') M (sun', arm')/2", kinetic),
        GuideForce("the sun pushes the planet with (D - Js sun'')/(rs cos(alpha))", "inner", inner),
        GuideForce(
            "the ring pushes it with (B - Jr ring'')/((rs + 2 rp) cos(alpha))", "outer", outer
        ),
        Conserved(
            "the energy T + m g (rs + rp) cos(arm), less the work D sun + B ring of the drives",
            energy,
        ),
    ),
)
