"""Particle on a circle, located by an angle.

A particle m moves without friction on a fixed horizontal circle of radius R, perpendicular to
gravity g. Two constraints, z = 0 and x² + y² = R², leave one degree of freedom. The generalized
coordinate theta is the angle from the x axis to the particle's radius, positive towards the y axis;
it reaches every point of the circle.
"""

from numpy import cos, sin

from mecanique import model as mq
from mecanique.textbook import System, facts

m = mq.Parameter("m", 1.0, "kg", "mass of the particle")
R = mq.Parameter("R", 1.0, "m", "radius of the circle")
g = mq.Parameter("g", 9.81, "m/s²", "acceleration of free fall")

# the particle, held by a massless spoke
mechanism = mq.Mechanism(
    name="particle_on_circle",
    bodies=(
        mq.Body("ground"),
        mq.Body("particle", mq.bar(R, (1, 0, 0), radius=0.005), mq.particle(m, (R, 0, 0))),
    ),
    joints=(mq.Revolute("center", "ground", "particle", axis=(0, 0, 1), coordinate="theta"),),
    parameters=(m, R, g),
    gravity=(0, 0, -g),
)


def constraint(s: facts.Values) -> tuple[float, float, float]:
    """Return the force that keeps the particle on the circle: towards the center and upwards."""
    C = s.m * s.R * s["theta'"] ** 2
    return -C * cos(s.theta), -C * sin(s.theta), s.m * s.g


SYSTEM = System(
    title="Particle on a horizontal circle, by its angle",
    source="Fundamentals of Dynamics, ch. 1, Figure 1.1",
    build=mechanism,
    start_velocity={"theta": 1.0},
    tags=("chapter", "particle", "planar"),
    facts=(
        facts.Acceleration("theta'' = 0", lambda s: [0]),
        facts.KineticEnergy("T = m R² theta'² / 2", lambda s: s.m * s.R**2 * s["theta'"] ** 2 / 2),
        facts.Reaction("m R theta'² towards the center and m g upwards", "center", constraint),
        facts.Period(
            "once around in 2 pi / theta'",
            {"theta'": 2.0},
            lambda s: 3.141592653589793,
            advance={"theta": 6.283185307179586},
        ),
    ),
    forms={
        "T = m R^2 theta'^2/2": "Fundamentals of Dynamics, Figure 1.1, by the angle",
    },
)
