"""Elastic pendulum.

A particle m hangs from a fixed pin by a spring of stiffness k and free length l0 and swings in a
vertical plane under gravity g. The generalized coordinates are the spring's length r, which must
stay positive, and the angle theta of the spring from the downward vertical, positive towards +x.
Where k = 3 m g / l0, swinging and bouncing are in 1:2 resonance and energy wanders from one to the
other and back.
"""

from numpy import cos, sin, sqrt

from mecanique import model as mq
from mecanique.textbook import System, facts
from mecanique.textbook.joints import hinge

m = mq.Parameter("m", 1.0, "kg", "mass of the particle")
k = mq.Parameter("k", 29.43, "N/m", "stiffness of the spring")
l0 = mq.Parameter("l0", 1.0, "m", "free length of the spring")
g = mq.Parameter("g", 9.81, "m/s²", "acceleration of free fall")

# the pendulum: the particle slides on a massless guide that turns about the pin
mechanism = mq.Mechanism(
    name="elastic_pendulum",
    bodies=(mq.Body("ground"), mq.Body("guide"), mq.Body("bob", mq.particle(m))),
    joints=(
        hinge("pin", "ground", "guide", "theta"),
        mq.Prismatic("slide", "guide", "bob", axis=(0, 0, -1), coordinate="r"),
    ),
    forces=(mq.JointSpring("spring", "slide", k, l0),),
    coordinates=mq.Coordinates(("r", "theta")),
    parameters=(m, k, l0, g),
    gravity=(0, 0, -g),
)


def acceleration(s: facts.Values) -> tuple[float, float]:
    """Return r'' and theta''."""
    return (
        s.r * s["theta'"] ** 2 + s.g * cos(s.theta) - s.k / s.m * (s.r - s.l0),
        -(s.g * sin(s.theta) + 2 * s["r'"] * s["theta'"]) / s.r,
    )


def energy(s: facts.Values) -> facts.Number:
    """Return T + V."""
    T = s.m * (s["r'"] ** 2 + s.r**2 * s["theta'"] ** 2) / 2
    return T + s.k * (s.r - s.l0) ** 2 / 2 - s.m * s.g * s.r * cos(s.theta)


SYSTEM = System(
    title="Particle on a spring that swings",
    source="Vitt & Gorelik, Zh. Tekh. Fiz. 3 (1933) 294; Lynch, "
    "Int. J. Non-Linear Mech. 37 (2002) 345",
    build=mechanism,
    start={"r": 1.63, "theta": 0.1},
    duration=40.0,
    tags=("pendulum", "planar", "spring", "chaos"),
    facts=(
        facts.Acceleration(
            "r'' = r theta'² + g cos(theta) - k (r - l0) / m, "
            "r theta'' = -g sin(theta) - 2 r' theta'",
            acceleration,
        ),
        facts.Frequencies(
            "at rest r = l0 + m g / k, and ω = sqrt(k / m), sqrt(g / (l0 + m g / k))",
            lambda s: [sqrt(s.k / s.m), sqrt(s.g / (s.l0 + s.m * s.g / s.k))],
            at=lambda s: {"r": s.l0 + s.m * s.g / s.k},
        ),
        facts.Conserved(
            "the energy m (r'² + r² theta'²) / 2 + k (r - l0)² / 2 - m g r cos(theta)", energy
        ),
    ),
    forms={
        "m r'' - m r theta'^2 + k (r - l0) - m g cos(theta) = 0": (
            "Thornton & Marion, Classical Dynamics, problem 7-15, along the spring"
        ),
        "r^2 theta'' + 2 r r' theta' + g r sin(theta) = 0": "the same, across it",
    },
)
