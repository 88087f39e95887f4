"""Two particles joined by a rigid rod.

Particles m1 and m2 are kept at the distance l by a massless rod and thrown under gravity g. Six
rectangular coordinates with one constraint leave N = 3·2 − 1 = 5 degrees of freedom. The
generalized coordinates are x, y, z of the center of mass, the azimuth phi of the rod about the
vertical, from the x axis, and its angle theta from the upward vertical (phi has no meaning while
the rod is vertical). The rod points from m1 to m2.
"""

from numpy import cos, diag, sin, tan

from mecanique import model as mq
from mecanique.textbook import System, facts

m1 = mq.Parameter("m1", 2.0, "kg", "mass of one particle")
m2 = mq.Parameter("m2", 1.0, "kg", "mass of the other particle")
l = mq.Parameter("l", 1.0, "m", "length of the rod")
g = mq.Parameter("g", 9.81, "m/s²", "acceleration of free fall")

# the particles on their rod; the rod's frame is at the center of mass
z1, z2 = -m2 * l / (m1 + m2), m1 * l / (m1 + m2)
rod = mq.bar(l, (0, 0, 1), start=(0, 0, z1), radius=0.01)
mechanism = mq.Mechanism(
    name="dumbbell",
    bodies=(
        *(mq.Body(name) for name in ("ground", "along_x", "along_y", "center", "azimuth")),
        mq.Body("rod", rod, mq.particle(m1, (0, 0, z1)), mq.particle(m2, (0, 0, z2))),
    ),
    joints=(
        mq.Prismatic("x", "ground", "along_x", axis=(1, 0, 0)),
        mq.Prismatic("y", "along_x", "along_y", axis=(0, 1, 0)),
        mq.Prismatic("z", "along_y", "center", axis=(0, 0, 1)),
        mq.Revolute("phi", "center", "azimuth", axis=(0, 0, 1)),
        mq.Revolute("theta", "azimuth", "rod", axis=(0, 1, 0)),
    ),
    parameters=(m1, m2, l, g),
    gravity=(0, 0, -g),
)


def inertia(s: facts.Values) -> facts.Number:
    """Return the moment of inertia across the rod: reduced mass times length squared."""
    return s.m1 * s.m2 / (s.m1 + s.m2) * s.l**2


def mass_matrix(s: facts.Values) -> facts.Number:
    """Return M, diagonal in these coordinates."""
    m, I = s.m1 + s.m2, inertia(s)
    return diag([m, m, m, I * sin(s.theta) ** 2, I])


def acceleration(s: facts.Values) -> list[float]:
    """Return the free fall of the center and the free turning of the rod."""
    phi, theta = s["phi'"], s["theta'"]
    return [0, 0, -s.g, -2 * phi * theta / tan(s.theta), phi**2 * sin(s.theta) * cos(s.theta)]


SYSTEM = System(
    title="Two particles joined by a massless rigid rod, thrown",
    source="Fundamentals of Dynamics, ch. 1, sect. 1.2; Goldstein, Classical Mechanics, ch. 1",
    build=mechanism,
    start={"theta": 1.2},
    start_velocity={"x": 1.0, "z": 9.81, "phi": 5.0, "theta": 2.0},
    duration=2.0,
    tags=("chapter", "particle", "spatial", "free"),
    facts=(
        facts.MassMatrix(
            "M = diag(m, m, m, I sin²(theta), I), m = m1 + m2, I = m1 m2 l² / (m1 + m2)",
            mass_matrix,
        ),
        facts.Acceleration(
            "z'' = -g, phi'' = -2 phi' theta' cot(theta), theta'' = phi'² sin(theta) cos(theta)",
            acceleration,
        ),
        facts.Conserved(
            "phi' sin²(theta), the angular momentum about the vertical per I",
            lambda s: s["phi'"] * sin(s.theta) ** 2,
        ),
        facts.Conserved(
            "theta'² + phi'² sin²(theta), the square of the rod's rate of turning",
            lambda s: s["theta'"] ** 2 + s["phi'"] ** 2 * sin(s.theta) ** 2,
        ),
    ),
    forms={
        (
            "T = (m1 + m2) (x'^2 + y'^2 + z'^2)/2 + m1 m2 l^2 (theta'^2 + sin(theta)^2 phi'^2)/(2 "
            "(m1 + m2))"
        ): "Landau & Lifshitz, Mechanics, sect. 13, by the reduced mass, with r = l in eq. 4.6",
    },
)
