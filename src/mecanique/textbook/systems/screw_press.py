"""Screw press.

A massless spindle of length l carries a flywheel, a thin disk of mass m and radius R, at its upper
end. It turns in the thread of a fixed nut and descends by p per radian. At its lower end it pushes
a ram of mass M, which guides keep from turning, by a bearing. A constant moment D drives the
spindle; gravity g acts on both. The generalized coordinate theta is the angle that the spindle has
turned since its lower end was at the height H. All contacts are frictionless.
"""

from mecanique import model as mq
from mecanique.textbook import System, facts

DOWN, UP = (0.0, 0.0, -1.0), (0.0, 0.0, 1.0)


m = mq.Parameter("m", 60.0, "kg", "mass of the flywheel")
R = mq.Parameter("R", 0.4, "m", "radius of the flywheel")
M = mq.Parameter("M", 80.0, "kg", "mass of the ram")
l = mq.Parameter("l", 0.6, "m", "length of the spindle")
p = mq.Parameter("p", 0.012, "m/rad", "pitch: advance of the spindle per radian")
H = mq.Parameter("H", 0.5, "m", "height of the spindle's lower end at theta = 0")
D = mq.Parameter("D", 30.0, "N·m", "moment that drives the spindle")
g = mq.Parameter("g", 9.81, "m/s²", "acceleration of free fall")

# the spindle with its flywheel, and the ram
theta = mq.coordinate("theta")
spindle = mq.bar(l, UP, radius=0.03), mq.disk(m, R, thickness=0.05).at((0, 0, l))
mechanism = mq.Mechanism(
    name="screw_press",
    bodies=(
        mq.Body("ground"),
        mq.Body("spindle", *spindle),
        mq.Body("ram", mq.box(M, (0.3, 0.3, 0.2)).at((0, 0, -0.1))),
    ),
    joints=(
        mq.Helical(
            "thread",
            "ground",
            "spindle",
            axis=DOWN,
            pitch=p,
            origin=mq.Placement((0, 0, H)),
            coordinate="theta",
        ),
        mq.Revolute("bearing", "spindle", "ram", axis=DOWN, coordinate="slip"),
    ),
    forces=(mq.JointForce("drive", "thread", D),),
    coordinates=mq.Coordinates(("theta",), {"slip": -theta}),
    parameters=(m, R, M, l, p, H, D, g),
    gravity=(0, 0, -g),
)


def inertia(s: facts.Values) -> facts.Number:
    """Return the inertia the moment accelerates: the flywheel's, and that of all that descends."""
    return s.m * s.R**2 / 2 + (s.m + s.M) * s.p**2


def spin(s: facts.Values) -> facts.Number:
    """Return the angular acceleration."""
    return (s.D + (s.m + s.M) * s.g * s.p) / inertia(s)


SYSTEM = System(
    title="Screw press with a flywheel",
    source="pitch and screw after Ball, A Treatise on the Theory of Screws, 1900, ch. I",
    build=mechanism,
    duration=2.0,
    tags=("screw", "drive", "linear", "mimic"),
    facts=(
        facts.Acceleration(
            "(m R² / 2 + (m + M) p²) theta'' = D + (m + M) g p",
            lambda s: [spin(s)],
        ),
        facts.MassMatrix("m R² / 2 + (m + M) p²", lambda s: [[inertia(s)]]),
        facts.KineticEnergy(
            "T = (m R² / 2 + (m + M) p²) theta'² / 2",
            lambda s: inertia(s) * s["theta'"] ** 2 / 2,
        ),
        facts.Solution(
            "from rest, theta = theta'' t² / 2",
            {},
            lambda s: {"theta": spin(s) * s.t**2 / 2, "theta'": spin(s) * s.t},
            until=lambda s: 1.5,
        ),
        facts.Reaction(
            "the thread holds spindle and ram up with (m + M) (g - p theta'')",
            "thread",
            lambda s: [0, 0, (s.m + s.M) * (s.g - s.p * spin(s))],
        ),
        facts.Reaction(
            "the spindle holds the ram up with M (g - p theta'')",
            "bearing",
            lambda s: [0, 0, s.M * (s.g - s.p * spin(s))],
        ),
        facts.Conserved(
            "the energy T - (m + M) g p theta, less the work D theta of the drive",
            lambda s: inertia(s) * s["theta'"] ** 2 / 2 - ((s.m + s.M) * s.g * s.p + s.D) * s.theta,
        ),
    ),
    forms={
        "T = (m R^2/2 + (m + M) p^2) theta'^2/2": (
            "Ball, Theory of Screws: a body's twist has the squares of p and of its radius of "
            "gyration"
        ),
    },
)
