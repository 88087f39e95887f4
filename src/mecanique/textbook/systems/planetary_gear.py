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

from mecanique import model as mq
from mecanique.model.bodies.visuals import Rgba
from mecanique.textbook import System, facts
from mecanique.textbook.joints import hinge

ORANGE = (0.9, 0.6, 0.0, 1.0)
BLUE, GREEN, PALE = (0.0, 0.38, 0.63, 1.0), (0.0, 0.52, 0.42, 1.0), (0.72, 0.76, 0.8, 1.0)

rs = mq.Parameter("rs", 0.1, "m", "pitch radius of the sun")
Js = mq.Parameter("Js", 0.004, "kg·m²", "moment of inertia of the sun")
Ja = mq.Parameter("Ja", 0.01, "kg·m²", "moment of inertia of the arm")
Jr = mq.Parameter("Jr", 0.06, "kg·m²", "moment of inertia of the ring")
m = mq.Parameter("m", 0.5, "kg", "mass of the planet")
rp = mq.Parameter("rp", 0.06, "m", "pitch radius of the planet")
Jp = mq.Parameter("Jp", 0.001, "kg·m²", "moment of inertia of the planet")
alpha = mq.Parameter("alpha", pi / 9, "rad", "pressure angle")
D = mq.Parameter("D", 0.05, "N·m", "moment that drives the sun")
B = mq.Parameter("B", 0.03, "N·m", "moment on the ring")
g = mq.Parameter("g", 9.81, "m/s²", "acceleration of free fall")


def wheel(
    mass: mq.Parameter | int, r: mq.Parameter, inertia: mq.Parameter, color: Rgba
) -> mq.Shape:
    """Return a wheel with a mark."""
    rim = mq.Visual(mq.Cylinder(r, 0.04), mq.Placement(rpy=(pi / 2, 0, 0)), color)
    mark = mq.Visual(mq.Box((0.1 * r, 0.06, 1.4 * r)), rgba=ORANGE)
    return mq.Shape(mass, (0, 0, 0), (inertia / 2, inertia, inertia / 2, 0, 0, 0), (rim, mark))


# the four wheels, the sun driven and the ring braked
sun, arm = mq.coordinate("sun"), mq.coordinate("arm")
ring = rs + 2 * rp
bar = mq.Visual(mq.Box((0.03, 0.02, rs + rp)), mq.Placement((0, -0.06, (rs + rp) / 2)), ORANGE)
band = mq.Visual(mq.Cylinder(1.1 * ring, 0.02), mq.Placement((0, 0.03, 0), (pi / 2, 0, 0)), PALE)
mechanism = mq.Mechanism(
    name="planetary_gear",
    bodies=(
        mq.Body("ground"),
        mq.Body("sun", wheel(0, rs, Js, BLUE)),
        mq.Body("arm", mq.Shape(0, (0, 0, 0), (Ja, Ja, Ja, 0, 0, 0), (bar,))),
        mq.Body("planet", wheel(m, rp, Jp, GREEN)),
        mq.Body("ring", mq.Shape(0, (0, 0, 0), (Jr / 2, Jr, Jr / 2, 0, 0, 0), (band,))),
    ),
    joints=(
        hinge("sun_axle", "ground", "sun", "sun"),
        hinge("arm_axle", "ground", "arm", "arm"),
        hinge("planet_pin", "arm", "planet", "planet", at=(0, 0, rs + rp)),
        hinge("ring_axle", "ground", "ring", "ring"),
    ),
    forces=(mq.JointForce("drive", "sun_axle", D), mq.JointForce("brake", "ring_axle", B)),
    coordinates=mq.Coordinates(
        ("sun", "arm"),
        {"planet": -(sun - arm) * rs / rp, "ring": arm - (sun - arm) * rs / ring},
    ),
    elements=(
        mq.Gear("inner", "sun_axle", "planet_pin", rs, other_radius=rp, pressure_angle=alpha),
        mq.Gear(
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


def turns(s: facts.Values) -> facts.Number:
    """Return how sun, arm, planet and ring turn with sun and arm, shape (4, 2)."""
    p, k = s.rs / s.rp, s.rs / (s.rs + 2 * s.rp)
    return array([[1, 0], [0, 1], [-p, 1 + p], [-k, 1 + k]])


def mass_matrix(s: facts.Values) -> facts.Number:
    """Return the sum of all moments of inertia, each as its wheel turns, shape (2, 2)."""
    moments = array([s.Js, s.Ja + s.m * (s.rs + s.rp) ** 2, s.Jp, s.Jr])
    return turns(s).T @ (moments[:, None] * turns(s))


def accelerations(s: facts.Values) -> facts.Number:
    """Return sun'' and arm''."""
    weight = s.m * s.g * (s.rs + s.rp) * sin(s.arm)
    return solve(mass_matrix(s), turns(s).T @ array([s.D, 0, 0, s.B]) + array([0, weight]))


def kinetic(s: facts.Values) -> facts.Number:
    """Return the kinetic energy [J]."""
    rates = array([s["sun'"], s["arm'"]])
    return rates @ mass_matrix(s) @ rates / 2


def energy(s: facts.Values) -> facts.Number:
    """Return T + V, less the work of the drives [J]."""
    work = array([s.D, 0, 0, s.B]) @ turns(s) @ array([s.sun, s.arm])
    return kinetic(s) + s.m * s.g * (s.rs + s.rp) * cos(s.arm) - work


def inner(s: facts.Values) -> facts.Number:
    """Return the force of the sun on the planet, which the sun's balance demands [N]."""
    return (s.D - s.Js * accelerations(s)[0]) / (s.rs * cos(s.alpha))


def outer(s: facts.Values) -> facts.Number:
    """Return the force of the ring on the planet, which the ring's balance demands [N]."""
    ring = (turns(s) @ accelerations(s))[3]
    return (s.B - s.Jr * ring) / ((s.rs + 2 * s.rp) * cos(s.alpha))


SYSTEM = System(
    title="Planetary gear with two inputs",
    source="R. Willis, Principles of Mechanism, 1841; J. J. Uicker, G. R. Pennock & J. E. Shigley, "
    "Theory of Machines and Mechanisms, 2003, ch. 9",
    build=mechanism,
    duration=5.0,
    tags=("planar", "gear", "drive", "linear", "mimic"),
    facts=(
        facts.Acceleration(
            "M (sun'', arm'') = D and B as sun and ring turn, and m g (rs + rp) sin(arm) on arm",
            accelerations,
        ),
        facts.MassMatrix(
            "M = sum of J c c^T, c the turns of a wheel with sun and arm", mass_matrix
        ),
        facts.KineticEnergy("T = (sun', arm') M (sun', arm')/2", kinetic),
        facts.GuideForce(
            "the sun pushes the planet with (D - Js sun'')/(rs cos(alpha))", "inner", inner
        ),
        facts.GuideForce(
            "the ring pushes it with (B - Jr ring'')/((rs + 2 rp) cos(alpha))", "outer", outer
        ),
        facts.Conserved(
            "the energy T + m g (rs + rp) cos(arm), less the work D sun + B ring of the drives",
            energy,
        ),
    ),
    forms={
        "planet = rs (arm - sun)/rp": "Willis: against the arm, planet and sun turn as -rs to rp",
        "ring = 2 (rs + rp) arm/(rs + 2 rp) - rs sun/(rs + 2 rp)": (
            "Willis: against the arm, ring and sun turn as -rs to rs + 2 rp"
        ),
    },
)
