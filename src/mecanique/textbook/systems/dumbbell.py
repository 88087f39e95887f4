"""Two particles joined by a rigid rod.

Particles m1 and m2 are kept at the distance l by a massless rod and thrown under gravity g. Six
rectangular coordinates with one constraint leave N = 3·2 − 1 = 5 degrees of freedom. The
generalized coordinates are x, y, z of the center of mass, the azimuth phi of the rod about the
vertical, from the x axis, and its angle theta from the upward vertical (phi has no meaning while
the rod is vertical). The rod points from m1 to m2.
"""

from numpy import cos, diag, sin, tan

from mecanique.model import Body, Mechanism, Parameter, Prismatic, Revolute, bar, particle
from mecanique.textbook.facts import Acceleration, Conserved, MassMatrix, Number, Values
from mecanique.textbook.system import System


def build(m1: Parameter, m2: Parameter, l: Parameter, g: Parameter) -> Mechanism:
    """Return the particles on their rod; the rod's frame is at the center of mass."""
    z1, z2 = -m2 * l / (m1 + m2), m1 * l / (m1 + m2)
    rod = bar(l, (0, 0, 1), start=(0, 0, z1), radius=0.01)
    return Mechanism(
        name="dumbbell",
        bodies=(
            *(Body(name) for name in ("ground", "along_x", "along_y", "center", "azimuth")),
            Body("rod", rod, particle(m1, (0, 0, z1)), particle(m2, (0, 0, z2))),
        ),
        joints=(
            Prismatic("x", "ground", "along_x", axis=(1, 0, 0)),
            Prismatic("y", "along_x", "along_y", axis=(0, 1, 0)),
            Prismatic("z", "along_y", "center", axis=(0, 0, 1)),
            Revolute("phi", "center", "azimuth", axis=(0, 0, 1)),
            Revolute("theta", "azimuth", "rod", axis=(0, 1, 0)),
        ),
        parameters=(m1, m2, l, g),
        gravity=(0, 0, -g),
    )


def inertia(s: Values) -> Number:
    """Return the moment of inertia across the rod: reduced mass times length squared."""
    return s.m1 * s.m2 / (s.m1 + s.m2) * s.l**2


def mass_matrix(s: Values) -> Number:
    """Return M, diagonal in these coordinates."""
    m, I = s.m1 + s.m2, inertia(s)
    return diag([m, m, m, I * sin(s.theta) ** 2, I])


def acceleration(s: Values) -> list[float]:
    """Return the free fall of the center and the free turning of the rod."""
    phi, theta = s["phi'"], s["theta'"]
    return [0, 0, -s.g, -2 * phi * theta / tan(s.theta), phi**2 * sin(s.theta) * cos(s.theta)]


SYSTEM = System(
    title="Two particles joined by a massless rigid rod, thrown",
    source="Fundamentals of Dynamics, ch. 1, sect. 1.2; Goldstein, Classical Mechanics, ch. 1",
    parameters=(
        Parameter("m1", 2.0, "kg", "mass of one particle"),
        Parameter("m2", 1.0, "kg", "mass of the other particle"),
        Parameter("l", 1.0, "m", "length of the rod"),
        Parameter("g", 9.81, "m/s²", "acceleration of free fall"),
    ),
    build=build,
    start={"theta": 1.2},
    start_velocity={"x": 1.0, "z": 9.81, "phi": 5.0, "theta": 2.0},
    duration=2.0,
    tags=("chapter", "particle", "spatial", "free"),
    facts=(
        MassMatrix(
            "M = diag(m, m, m, I sin²(theta), I), m = m1 + m2, I = m1 m2 l² / (m1 + m2)",
            mass_matrix,
        ),
        Acceleration(
            "z'' = -g, phi'' = -2 phi' theta' cot(theta), theta'' = phi'² sin(theta) cos(theta)",
            acceleration,
        ),
        Conserved(
            "phi' sin²(theta), the angular momentum about the vertical per I",
            lambda s: s["phi'"] * sin(s.theta) ** 2,
        ),
        Conserved(
            "theta'² + phi'² sin²(theta), the square of the rod's rate of turning",
            lambda s: s["theta'"] ** 2 + s["phi'"] ** 2 * sin(s.theta) ** 2,
        ),
    ),
)
