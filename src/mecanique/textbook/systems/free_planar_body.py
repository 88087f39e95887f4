"""Free planar body.

A homogeneous rectangular plate of mass m and sides a and b is thrown in its own, vertical plane
under gravity g: at most three degrees of freedom are possible in planar motion. The generalized
coordinates are x and z of the center of mass and the angle theta of the plate, positive from x
towards z.
"""

from math import pi

from mecanique import model as mq
from mecanique.textbook import System, facts

m = mq.Parameter("m", 2.0, "kg", "mass of the plate")
a = mq.Parameter("a", 0.6, "m", "side along the body's x axis")
b = mq.Parameter("b", 0.4, "m", "side along the body's z axis")
g = mq.Parameter("g", 9.81, "m/s²", "acceleration of free fall")

# the plate, turned into the x-z plane
mechanism = mq.Mechanism(
    name="free_planar_body",
    bodies=(mq.Body("ground"), mq.Body("plate", mq.plate(m, (a, b)).at(rpy=(pi / 2, 0, 0)))),
    joints=(mq.Planar("plane", "ground", "plate", axis=(0, -1, 0), names=("x", "z", "theta")),),
    parameters=(m, a, b, g),
    gravity=(0, 0, -g),
)


def inertia(s: facts.Values) -> facts.Number:
    """Return the plate's moment of inertia about its normal through the center."""
    return s.m * (s.a**2 + s.b**2) / 12


def flight(s: facts.Values) -> dict[str, float]:
    """Return the throw: a parabola and a steady turn."""
    return {
        "x": 2.0 * s.t,
        "z": 5.0 * s.t - s.g * s.t**2 / 2,
        "theta": 0.5 + 3.0 * s.t,
        "theta'": 3.0,
    }


SYSTEM = System(
    title="Plate thrown in its own vertical plane",
    source="Fundamentals of Dynamics, ch. 1, Figure 1.2, eqs. 1.13 and 1.32",
    build=mechanism,
    start_velocity={"x": 1.5, "z": 9.81, "theta": 6.0},
    duration=2.0,
    tags=("chapter", "planar", "free", "linear"),
    facts=(
        facts.Acceleration("x'' = 0, z'' = -g, theta'' = 0", lambda s: [0, -s.g, 0]),
        facts.MassMatrix(
            "M = diag(m, m, I), I = m (a² + b²) / 12",
            lambda s: [[s.m, 0, 0], [0, s.m, 0], [0, 0, inertia(s)]],
        ),
        facts.KineticEnergy(
            "T = m v² / 2 + I theta'² / 2",
            lambda s: s.m * (s["x'"] ** 2 + s["z'"] ** 2) / 2 + inertia(s) * s["theta'"] ** 2 / 2,
        ),
        facts.Solution(
            "a parabola and a steady turn",
            {"theta": 0.5, "x'": 2.0, "z'": 5.0, "theta'": 3.0},
            flight,
            until=lambda s: 1.0,
        ),
    ),
    forms={
        "T = m (x'^2 + z'^2)/2 + m (a^2 + b^2) theta'^2/24": (
            "Fundamentals of Dynamics, eq. 1.32, with the moment of a plate"
        ),
    },
)
