"""Ball in a bowl.

A homogeneous ball of mass m and radius r rolls without slip in a spherical bowl of radius R, whose
lowest point is the origin, under gravity g. Its generalized coordinates are the place x, y, z of
its center and its attitude, a unit quaternion (qx, qy, qz, qw). Besides its energy it keeps the
part of its angular velocity along the normal, and a sum about the vertical.
"""

import numpy as np

from mecanique import model as mq
from mecanique.textbook import System, facts
from mecanique.textbook.joints import carriers, to_body, to_world
from mecanique.textbook.systems.ball_on_a_turntable import chart, kinetic

SLOPE = 0.5
"""Of the bowl where the ball goes round on a level circle [rad]."""


m = mq.Parameter("m", 0.3, "kg", "mass of the ball")
r = mq.Parameter("r", 0.1, "m", "radius of the ball")
R = mq.Parameter("R", 0.6, "m", "radius of the bowl")
g = mq.Parameter("g", 9.81, "m/s²", "acceleration of free fall")

# the ball, its center led by three slides; the bowl is drawn by level circles
levels = tuple(
    mq.Visual(
        mq.Cylinder(R * wide, 0.004 * R), mq.Placement((0, 0, R * high)), (0.6, 0.7, 0.8, 0.25)
    )
    for wide, high in ((0.28, 0.04), (0.6, 0.2), (0.8, 0.4), (0.92, 0.6))
)
mark = mq.Visual(mq.Box((2.02 * r, 0.3 * r, 0.3 * r)), rgba=(0.9, 0.6, 0.0, 1.0))
mechanism = mq.Mechanism(
    name="ball_in_a_bowl",
    bodies=(
        mq.Body("ground", mq.massless(*levels)),
        *carriers(chart),
        mq.Body("ball", mq.ball(m, r), mq.massless(mark)),
    ),
    joints=chart,
    contacts=(mq.Rolling("contact", "ball", r, axis=None, bowl=R),),
    parameters=(m, r, R, g),
    gravity=(0, 0, -g),
)


def spin(s: facts.Values) -> facts.Number:
    """Return the angular velocity in world axes."""
    return to_world(s, np.array([s[f"roll_w{axis}"] for axis in "xyz"]))


def normal(s: facts.Values) -> facts.Number:
    """Return the unit vector from the ball to the middle of the sphere."""
    return np.array([-s.x, -s.y, s.R - s.z]) / (s.R - s.r)


def accelerations(s: facts.Values) -> facts.Number:
    """Return all accelerations: 7 w'/5 = (n·w) n' + n × g/r, and v = r w × n differentiated."""
    n, w = normal(s), spin(s)
    change = np.array([-s["x'"], -s["y'"], -s["z'"]]) / (s.R - s.r)
    turn = 5 / 7 * (n @ w * change + np.cross(n, [0, 0, -s.g]) / s.r)
    place = s.r * (np.cross(turn, n) + np.cross(w, change))
    return np.concatenate([place, to_body(s, turn)])


def integrals(s: facts.Values) -> facts.Number:
    """Return the energy and both sums that are kept."""
    n, w = normal(s), spin(s)
    along = n @ w
    return np.array([kinetic(s) + s.m * s.g * s.z, along, 7 * w[2] - 5 * along * n[2]])


def rate(s: facts.Values) -> float:
    """Return the rate of the level circle [rad/s]."""
    return float(np.sqrt(5 * s.g / (7 * (s.R - s.r) * np.cos(SLOPE))))


def circle(s: facts.Values) -> dict[str, float]:
    """Return the center on a level circle."""
    way, depth = (s.R - s.r) * np.sin(SLOPE), (s.R - s.r) * np.cos(SLOPE)
    phase = rate(s) * s.t
    return {"x": way * np.cos(phase), "y": way * np.sin(phase), "z": s.R - depth}


def start(s: facts.Values) -> dict[str, float]:
    """Return the ball on its circle, rolling without spin about the normal: w = n × v/r."""
    way = (s.R - s.r) * np.sin(SLOPE)
    speed = rate(s) * way
    return {
        "x": way,
        "z": s.R - (s.R - s.r) * np.cos(SLOPE),
        "qw": 1.0,
        "y'": speed,
        "roll_wx": -np.cos(SLOPE) * speed / s.r,
        "roll_wz": -np.sin(SLOPE) * speed / s.r,
    }


SYSTEM = System(
    title="Ball that rolls in a spherical bowl",
    source="E. J. Routh, Advanced Dynamics of a System of Rigid Bodies, 1905, on rolling spheres; "
    "Neimark & Fufaev, Dynamics of Nonholonomic Systems, 1972",
    build=mechanism,
    start={"x": 0.3, "z": 0.2},
    start_velocity={"y": 0.6, "roll_wz": 12.0},
    duration=8.0,
    tags=("spatial", "rolling", "nonholonomic", "contact", "quaternion"),
    facts=(
        # the books' axes are the normal and the meridian, so that this is compared in numbers
        facts.Acceleration("7 w'/5 = (n·w) n' + n x g/r, v = r w x n", accelerations),
        facts.KineticEnergy("T = m v^2/2 + m r^2 w^2/5", kinetic),
        facts.Conserved("the energy, n·w, and 7 w_z - 5 (n·w) n_z", integrals),
        facts.Solution(
            "level circles at sqrt(5 g/(7 (R - r) cos(slope)))", start, circle, until=lambda s: 1.5
        ),
    ),
    forms={
        "r + rho - R = 0": "Routh, on rolling spheres: the centers stay R - r apart",
        "T = m (x'^2 + y'^2 + z'^2)/2 + m r^2 (roll_wx^2 + roll_wy^2 + roll_wz^2)/5": (
            "Routh, on rolling spheres, with the square 2 r^2/5 of the radius of gyration"
        ),
    },
)
