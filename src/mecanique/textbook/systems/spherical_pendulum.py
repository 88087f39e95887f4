"""Spherical pendulum.

A particle m hangs from a fixed point by a massless rod of length l and moves on a sphere under
gravity g. The generalized coordinates are the angle theta of the rod from the downward vertical and
the azimuth phi of its vertical plane about the upward vertical, from the x axis (phi has no meaning
while the rod is vertical).
"""

from numpy import cos, sin, sqrt, tan

from mecanique import model as mq
from mecanique.textbook import System, facts
from mecanique.textbook.joints import hinge

m = mq.Parameter("m", 1.0, "kg", "mass of the particle")
l = mq.Parameter("l", 1.0, "m", "length of the rod")
g = mq.Parameter("g", 9.81, "m/s²", "acceleration of free fall")

# the pendulum: a massless yoke turns by phi, the rod swings in it by theta
mechanism = mq.Mechanism(
    name="spherical_pendulum",
    bodies=(
        mq.Body("ground"),
        mq.Body("yoke"),
        mq.Body("bob", mq.bar(l), mq.particle(m, (0, 0, -l))),
    ),
    joints=(
        mq.Revolute("turn", "ground", "yoke", axis=(0, 0, 1), coordinate="phi"),
        hinge("swing", "yoke", "bob", "theta"),
    ),
    coordinates=mq.Coordinates(("theta", "phi")),
    parameters=(m, l, g),
    gravity=(0, 0, -g),
)


def acceleration(s: facts.Values) -> tuple[float, float]:
    """Return theta'' and phi'' (Landau & Lifshitz, sect. 14, problem 1)."""
    return (
        sin(s.theta) * cos(s.theta) * s["phi'"] ** 2 - s.g / s.l * sin(s.theta),
        -2 * s["theta'"] * s["phi'"] / tan(s.theta),
    )


def tension(s: facts.Values) -> tuple[float, float, float]:
    """Return the pull of the rod along itself."""
    S = s.m * s.g * cos(s.theta) + s.m * s.l * (s["theta'"] ** 2 + (s["phi'"] * sin(s.theta)) ** 2)
    return -S * sin(s.theta) * cos(s.phi), -S * sin(s.theta) * sin(s.phi), S * cos(s.theta)


def cone(s: facts.Values) -> dict[str, float]:
    """Return the steady circle at theta = 1."""
    return {"theta": 1.0, "phi'": sqrt(s.g / (s.l * cos(1.0)))}


SYSTEM = System(
    title="Particle on a massless rod, free to move on a sphere",
    source="Landau & Lifshitz, Mechanics, 3rd ed., sect. 14, problem 1; Whittaker, "
    "Analytical Dynamics, sect. 55",
    build=mechanism,
    start={"theta": 1.2},
    start_velocity={"phi": 1.5},
    tags=("pendulum", "spatial"),
    facts=(
        facts.Acceleration(
            "theta'' = sin(theta) cos(theta) phi'² - g sin(theta) / l, "
            "phi'' = -2 theta' phi' cot(theta)",
            acceleration,
        ),
        facts.Conserved(
            "phi' sin²(theta) and l (theta'² + phi'² sin²(theta)) / 2 - g cos(theta)",
            lambda s: [
                s["phi'"] * sin(s.theta) ** 2,
                s.l * (s["theta'"] ** 2 + s["phi'"] ** 2 * sin(s.theta) ** 2) / 2
                - s.g * cos(s.theta),
            ],
        ),
        facts.Steady("it circles at constant theta with phi'² = g / (l cos(theta))", cone),
        facts.Eigenvalues(
            "near that circle theta swings with ω² = (g / l) (1 + 3 cos²(theta)) / cos(theta)",
            lambda s: [
                sign * 1j * sqrt(s.g / s.l * (1 + 3 * cos(1.0) ** 2) / cos(1.0)) for sign in (1, -1)
            ],
            at=cone,
        ),
        facts.Reaction(
            "the rod pulls with m g cos(theta) + m l (theta'² + phi'² sin²(theta))",
            "swing",
            tension,
        ),
    ),
    forms={
        "theta'' - sin(theta) cos(theta) phi'^2 + g sin(theta)/l = 0": "Whittaker, sect. 55",
        "V_eff = p_phi^2/(2 m l^2 sin(theta)^2) - m g l cos(theta)": (
            "Landau & Lifshitz, sect. 14, problem 1"
        ),
        "E = m l^2 (theta'^2 + sin(theta)^2 phi'^2)/2 - m g l cos(theta)": (
            "Landau & Lifshitz, sect. 14, problem 1"
        ),
    },
)
