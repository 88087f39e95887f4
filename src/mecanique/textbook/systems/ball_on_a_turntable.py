"""Ball on a turntable.

A homogeneous ball of mass m and radius r rolls without slip on a level table that is turned at the
constant rate W, under gravity g. Its generalized coordinates are the place x, y, z of its center
and its attitude, a unit quaternion (qx, qy, qz, qw). Friction turns the velocity of its center at 2
W/7: the center goes round a circle that stays where it is, while the table passes below.
"""

import numpy as np

from mecanique import model as mq
from mecanique.textbook import System, facts
from mecanique.textbook.joints import carriers, slides, to_body, to_world

START, SPEED = (0.3, 0.1), (0.2, -0.1)
"""Place and velocity of the center at the start of a circle [m, m/s]."""


m = mq.Parameter("m", 0.4, "kg", "mass of the ball")
r = mq.Parameter("r", 0.12, "m", "radius of the ball")
W = mq.Parameter("W", 2.1, "rad/s", "rate of the table")
g = mq.Parameter("g", 9.81, "m/s²", "acceleration of free fall")

# the table and the ball, its center led by three slides
top = mq.Visual(mq.Cylinder(1.5, 0.04), mq.Placement((0, 0, -0.02)), (0.85, 0.85, 0.85, 1.0))
line = mq.Visual(mq.Box((2.8, 0.03, 0.004)), rgba=(0.0, 0.447, 0.698, 1.0))
mark = mq.Visual(mq.Box((2.02 * r, 0.3 * r, 0.3 * r)), rgba=(0.9, 0.6, 0.0, 1.0))
turn = mq.Spherical("roll", "center", "ball", names=("qx", "qy", "qz", "qw"))
chart = (*slides("center"), turn)
mechanism = mq.Mechanism(
    name="ball_on_a_turntable",
    bodies=(
        mq.Body("ground"),
        mq.Body("table", mq.massless(top, line)),
        *carriers(chart),
        mq.Body("ball", mq.ball(m, r), mq.massless(mark)),
    ),
    joints=(
        mq.Revolute("axle", "ground", "table", axis=(0, 0, 1), coordinate="turn"),
        *chart,
    ),
    coordinates=mq.Coordinates((), {"turn": W * mq.time()}),
    contacts=(mq.Rolling("contact", "ball", r, axis=None, on="table"),),
    parameters=(m, r, W, g),
    gravity=(0, 0, -g),
)


def spin(s: facts.Values) -> facts.Number:
    """Return the angular velocity in the axes of the ball, shape (3,)."""
    return np.array([s[f"roll_w{axis}"] for axis in "xyz"])


def forward(s: facts.Values) -> facts.Number:
    """Return the acceleration of the center: (2/7) W z × v, shape (3,) [m/s²]."""
    return 2 * s.W / 7 * np.array([-s["y'"], s["x'"], 0.0])


def accelerations(s: facts.Values) -> list[float]:
    """Return all accelerations; friction m a turns the ball, too."""
    along, across, _ = a = forward(s)
    turn = 5 / (2 * s.r) * np.array([across, -along, 0.0])
    return [*a, *to_body(s, turn)]


def kinetic(s: facts.Values) -> facts.Number:
    """Return m v²/2 + m r² w²/5 [J]."""
    speed = s["x'"] ** 2 + s["y'"] ** 2 + s["z'"] ** 2
    return s.m * (speed / 2 + s.r**2 * np.sum(spin(s) ** 2) / 5)


def middle(s: facts.Values) -> facts.Number:
    """Return the center of the circle and the spin about the vertical."""
    rate = 2 * s.W / 7
    return np.array([s.x - s["y'"] / rate, s.y + s["x'"] / rate, to_world(s, spin(s))[2]])


def start(s: facts.Values) -> dict[str, float]:
    """Return a state in which the ball rolls: its lowest point moves with the table."""
    (x, y), (u, v) = START, SPEED
    return {
        "x": x,
        "y": y,
        "z": s.r,
        "qw": 1.0,
        "x'": u,
        "y'": v,
        "roll_wx": (s.W * x - v) / s.r,
        "roll_wy": (u + s.W * y) / s.r,
    }


def circle(s: facts.Values) -> dict[str, float]:
    """Return the center on its circle."""
    (x, y), (u, v) = START, SPEED
    rate = 2 * s.W / 7
    c, k = 1 - np.cos(rate * s.t), np.sin(rate * s.t)
    return {"x": x + (u * k - v * c) / rate, "y": y + (v * k + u * c) / rate, "z": s.r}


SYSTEM = System(
    title="Ball that rolls on a turntable",
    source="E. A. Milne, Vectorial Mechanics, 1948; Neimark & Fufaev, Dynamics of "
    "Nonholonomic Systems, 1972",
    build=mechanism,
    start={"x": 0.6, "z": 0.12},
    start_velocity={"y": 0.4},
    duration=10.5,
    tags=("spatial", "rolling", "nonholonomic", "contact", "rheonomic", "quaternion"),
    facts=(
        facts.Acceleration(
            "x'' = -2 W y'/7, y'' = 2 W x'/7, w' = 5 (x'', y'') x z/(2 r)", accelerations
        ),
        facts.KineticEnergy("T = m v^2/2 + m r^2 w^2/5", kinetic),
        facts.Conserved("the middle of the circle, x - 7 y'/(2 W) and y + 7 x'/(2 W); w_z", middle),
        facts.Reaction(
            "the table carries the weight and turns the path by friction, 2 m W v/7",
            "contact",
            lambda s: s.m * (forward(s) + np.array([0, 0, s.g])),
        ),
        facts.Solution("circles at 2 W/7", start, circle, until=lambda s: 2.0),
    ),
    forms={
        "x'' = -2 W y'/7": "Neimark & Fufaev, Dynamics of Nonholonomic Systems, 1972",
        "y'' = 2 W x'/7": "Neimark & Fufaev, Dynamics of Nonholonomic Systems, 1972",
    },
)
