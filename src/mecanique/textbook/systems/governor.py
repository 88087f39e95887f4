"""Porter's governor with a spring.

Two massless arms of length l hang on pins at the top of a spindle, which turns about the vertical
with the moment of inertia J; each carries a ball m at its end. Massless links of length l join the
balls to a sleeve M that slides on the spindle, and a spring of stiffness k and free length a joins
the sleeve to the top; gravity is g. The generalized coordinates are the angle psi of the spindle,
the angles theta1 and theta2 of the arms from the vertical, and the distance s of the sleeve from
the top; two loops, the links, leave two of these free.
"""

from numpy import cos, pi, sin, sqrt

from mecanique import model as mq
from mecanique.textbook import System, facts
from mecanique.textbook.joints import hinge

m = mq.Parameter("m", 1.0, "kg", "mass of each ball")
M = mq.Parameter("M", 2.0, "kg", "mass of the sleeve")
J = mq.Parameter("J", 0.2, "kg·m²", "moment of inertia of the spindle")
l = mq.Parameter("l", 0.5, "m", "length of arms and links")
k = mq.Parameter("k", 60.0, "N/m", "stiffness of the spring")
a = mq.Parameter("a", 0.4, "m", "free length of the spring")
g = mq.Parameter("g", 9.81, "m/s²", "acceleration of free fall")

# it ends below the lowest place of the sleeve in the motion shown
shaft = mq.Visual(mq.Cylinder(0.006, 1.8 * l), mq.Placement((0, 0, -0.85 * l)))
mechanism = mq.Mechanism(
    name="governor",
    bodies=(
        mq.Body("ground"),
        mq.Body("spindle", mq.Shape(0, inertia=(J, J, J, 0, 0, 0), visuals=(shaft,))),
        mq.Body("arm1", mq.bar(l), mq.particle(m, (0, 0, -l))),
        mq.Body("arm2", mq.bar(l), mq.particle(m, (0, 0, -l))),
        mq.Body("sleeve", mq.particle(M)),
    ),
    joints=(
        mq.Revolute("bearing", "ground", "spindle", axis=(0, 0, 1), coordinate="psi"),
        hinge("pin1", "spindle", "arm1", "theta1"),
        mq.Revolute("pin2", "spindle", "arm2", axis=(0, 1, 0), coordinate="theta2"),
        mq.Prismatic("guide", "spindle", "sleeve", axis=(0, 0, -1), coordinate="s"),
    ),
    forces=(
        mq.Spring("spring", "spindle", (0, 0, 0), "sleeve", (0, 0, 0), stiffness=k, free_length=a),
    ),
    loops=(
        mq.Loop.distance("link1", "arm1", (0, 0, -l), "sleeve", (0, 0, 0), l),
        mq.Loop.distance("link2", "arm2", (0, 0, -l), "sleeve", (0, 0, 0), l),
    ),
    parameters=(m, M, J, l, k, a, g),
    gravity=(0, 0, -g),
)


def spread(s: facts.Values) -> facts.Number:
    """Return the moment of inertia about the spindle."""
    return s.J + s.m * s.l**2 * (sin(s.theta1) ** 2 + sin(s.theta2) ** 2)


def kinetic(s: facts.Values) -> facts.Number:
    """Return T."""
    arms = s.m * s.l**2 * (s["theta1'"] ** 2 + s["theta2'"] ** 2)
    return (spread(s) * s["psi'"] ** 2 + arms + s.M * s["s'"] ** 2) / 2


def energy(s: facts.Values) -> facts.Number:
    """Return T + V."""
    height = -s.m * s.l * (cos(s.theta1) + cos(s.theta2)) - s.M * s.s
    return kinetic(s) + s.g * height + s.k * (sqrt(s.s**2) - s.a) ** 2 / 2


def turning(s: facts.Values) -> dict[str, facts.Number]:
    """Return the steady state with arms at 0.9 rad."""
    drop = 2 * s.l * cos(0.9)
    speed = sqrt(((s.m + s.M) * s.g - s.k * (drop - s.a)) / (s.m * s.l * cos(0.9)))
    return {"theta1": 0.9, "theta2": 0.9, "s": drop, "psi'": speed}


SYSTEM = System(
    title="Fly-ball governor with a loaded sleeve and a spring",
    source="C. T. Porter, US patent 1858; Shigley & Uicker, Theory of Machines, governors; "
    "Maxwell, On Governors, 1868",
    build=mechanism,
    start={"theta1": pi / 3, "theta2": pi / 3, "s": 0.5},
    start_velocity={"psi'": 8.0},
    tags=("spatial", "loop", "spring", "massless", "rotor"),
    facts=(
        facts.KineticEnergy(
            "T = ((J + m l² Σ sin² theta) psi'² + m l² Σ theta'² + M s'²) / 2", kinetic
        ),
        facts.Conserved(
            "angular momentum (J + m l² Σ sin² theta) psi'", lambda s: spread(s) * s["psi'"]
        ),
        facts.Conserved("the energy", energy),
        facts.Steady(
            "turning at psi'² = ((m + M) g - k (2 l cos theta - a)) / (m l cos theta)", turning
        ),
    ),
    forms={
        (
            "m l theta1'' - m l sin(theta1) cos(theta1) psi'^2 - s sin(theta1) lambda_link1_l + m "
            "g sin(theta1) = 0"
        ): "Pontryagin, Ordinary Differential Equations, sect. 27, with the push of the link",
        "p_psi = (J + m l^2 sin(theta1)^2 + m l^2 sin(theta2)^2) psi'": (
            "Goldstein, sect. 2.6: the momentum of an angle that T and V do not contain"
        ),
    },
)
