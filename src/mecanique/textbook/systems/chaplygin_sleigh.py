"""Chaplygin's sleigh.

A body of mass m on smooth level ground has a knife edge that does not move sideways; its center of
mass lies at the distance a ahead of the edge, about which it has the moment of inertia I. The
generalized coordinates are the position x, y of the edge and the angle theta of the body. The
condition of the edge, x' sin(theta) = y' cos(theta), is not integrable: three coordinates but only
two velocities are independent. Energy is conserved, and yet every motion ends straight ahead.
"""

from numpy import cos, cosh, sin, sqrt, tanh

from mecanique import model as mq
from mecanique.textbook import System, facts

m = mq.Parameter("m", 2.0, "kg", "mass of the sleigh")
a = mq.Parameter("a", 0.3, "m", "distance of the center of mass ahead of the edge")
I = mq.Parameter("I", 0.15, "kg·m²", "moment of inertia about the center of mass")

# the sleigh, its edge at the origin of its frame
hull = mq.Visual(mq.Box((3 * a, 1.2 * a, 0.1 * a)))
blade = mq.massless(mq.Visual(mq.Box((0.8 * a, 0.04 * a, 0.3 * a)), rgba=(0.9, 0.6, 0.0, 1.0)))
mechanism = mq.Mechanism(
    name="chaplygin_sleigh",
    bodies=(
        mq.Body("ground"),
        mq.Body("sleigh", mq.Shape(m, (a, 0, 0), (I / 2, I / 2, I, 0, 0, 0), (hull,)), blade),
    ),
    joints=(mq.Planar("plane", "ground", "sleigh", names=("x", "y", "theta")),),
    contacts=(mq.Blade("edge", "sleigh"),),
    parameters=(m, a, I),
    gravity=(0, 0, 0),
)


def radius(s: facts.Values) -> float:
    """Return b with m b² the moment of inertia about the edge [m]."""
    return float(sqrt(s.I / s.m + s.a**2))


def ahead(s: facts.Values) -> facts.Number:
    """Return the speed of the edge along itself [m/s]."""
    return cos(s.theta) * s["x'"] + sin(s.theta) * s["y'"]


def accelerations(s: facts.Values) -> list[facts.Number]:
    """Return x'', y'' and theta'': u' = a ω², ω' = −a u ω/b², and ω across."""
    u, w = ahead(s), s["theta'"]
    along, across = s.a * w * w, u * w
    return [
        cos(s.theta) * along - sin(s.theta) * across,
        sin(s.theta) * along + cos(s.theta) * across,
        -s.a * u * w / radius(s) ** 2,
    ]


def side_force(s: facts.Values) -> list[facts.Number]:
    """Return the force on the edge, m (a ω' + u ω) across it [N]."""
    force = s.m * ahead(s) * s["theta'"] * (1 - (s.a / radius(s)) ** 2)
    return [-force * sin(s.theta), force * cos(s.theta), 0.0]


def energy(s: facts.Values) -> facts.Number:
    """Return m (u² + b² ω²)/2 [J]."""
    return s.m * (ahead(s) ** 2 + (radius(s) * s["theta'"]) ** 2) / 2


def spun(s: facts.Values) -> dict[str, float]:
    """Return the velocities after a start without speed: u = U tanh(a U t/b²)."""
    b = radius(s)
    U = 1.5 * b
    phase = s.a * U * s.t / b**2
    return {"theta'": U / b / cosh(phase), "theta": b / s.a * _gudermannian(phase)}


def _gudermannian(x: float) -> float:
    """∫ dx / cosh x."""
    from numpy import arctan

    return float(2 * arctan(tanh(x / 2)))


SYSTEM = System(
    title="Chaplygin's sleigh",
    source="S. A. Chaplygin, Mat. Sb. 28 (1911) 303; Neimark & Fufaev, Dynamics of Nonholonomic "
    "Systems, 1972, ch. II",
    build=mechanism,
    start={"x": 0.0},
    start_velocity={"theta": 1.5},
    duration=6.0,
    tags=("planar", "rolling", "nonholonomic", "free"),
    facts=(
        facts.Acceleration("u' = a w^2, w' = -a u w/b^2 with b^2 = I/m + a^2", accelerations),
        facts.KineticEnergy("T = m (u^2 + b^2 w^2)/2", energy),
        facts.Reaction("the edge holds with m (a w' + u w)", "edge", side_force),
        facts.Conserved("the energy m (u^2 + b^2 w^2)/2", energy),
        facts.Solution(
            "w = w0/cosh(a w0 t/b), theta = (b/a) gd(a w0 t/b) from a turn on the spot",
            {"theta'": 1.5},
            spun,
            until=lambda s: 4.0,
        ),
    ),
    forms={
        "theta'' = -m a (sin(theta) y' + cos(theta) x') theta'/(m a^2 + I)": (
            "Neimark & Fufaev, ch. II, with the speed cos(theta) x' + sin(theta) y'"
        ),
    },
)
