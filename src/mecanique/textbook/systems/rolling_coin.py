"""Coin that rolls on level ground.

A thin disk of mass m and radius r with a sharp edge rolls without slip under gravity g. The
generalized coordinates are the position x, y, z of its center, the angle yaw of its heading, its
lean to the right and the angle spin about its axis. One of its three conditions of rolling, z = r
cos(lean), restricts positions; the others, on x' and y', are not integrable: five coordinates but
only three velocities are independent. The chart ends where the coin lies flat.
"""

from numpy import cos, pi, sin, tan

from mecanique import model as mq
from mecanique.textbook import System, facts
from mecanique.textbook.joints import carriers, hinges, slides

LEAN, TURN = 0.3, 1.2
"""Of the steady circle [rad, rad/s]."""


m = mq.Parameter("m", 1.3, "kg", "mass of the coin")
r = mq.Parameter("r", 0.5, "m", "radius of the coin")
g = mq.Parameter("g", 9.81, "m/s²", "acceleration of free fall")

# the coin, led by three slides and three hinges
floor = mq.Visual(mq.Box((12 * r, 12 * r, 0.02 * r)), rgba=(0.85, 0.85, 0.85, 1.0))
mark = mq.massless(mq.Visual(mq.Box((0.2 * r, 0.08 * r, 1.6 * r)), rgba=(0.9, 0.6, 0.0, 1.0)))
chart = (
    *slides("center"),
    *hinges(
        "center", "fork", "coin", names=("turn", "tilt", "axle"), angles=("yaw", "lean", "spin")
    ),
)
mechanism = mq.Mechanism(
    name="rolling_coin",
    bodies=(
        mq.Body("ground", mq.massless(floor)),
        *carriers(chart),
        mq.Body("coin", mq.disk(m, r, 0.05 * r).at(rpy=(pi / 2, 0, 0)), mark),
    ),
    joints=chart,
    coordinates=mq.Coordinates((), limits={"lean": (-pi / 2, pi / 2)}),
    contacts=(mq.Rolling("rim", "coin", r),),
    parameters=(m, r, g),
    gravity=(0, 0, -g),
)


def angular(s: facts.Values) -> tuple[float, float, float]:
    """Return yaw'', lean'' and spin'' by Euler's equations about the contact."""
    w, n, k = s["yaw'"], s["spin'"], s["lean'"]
    sine, cosine = sin(s.lean), cos(s.lean)
    return (
        -2 * k * n / cosine,
        4 * s.g * sine / (5 * s.r) + sine * cosine * w * w + 6 * cosine * w * n / 5,
        -(5 * cosine * w - 6 * tan(s.lean) * n) * k / 3,
    )


def accelerations(s: facts.Values) -> list[float]:
    """Return all accelerations; those of the center follow from rolling."""
    w, n, k = s["yaw'"], s["spin'"], s["lean'"]
    turn, tilt, roll = angular(s)
    sine, cosine = sin(s.lean), cos(s.lean)
    # the center moves with r (n + w sin lean) ahead and r k cos(lean) to the right
    ahead, side = s.r * (n + w * sine), s.r * k * cosine
    along = s.r * (roll + turn * sine + w * k * cosine) + side * w
    across = s.r * (tilt * cosine - k * k * sine) - ahead * w
    return [
        cos(s.yaw) * along + sin(s.yaw) * across,
        sin(s.yaw) * along - cos(s.yaw) * across,
        -s.r * (cosine * k * k + sine * tilt),
        turn,
        tilt,
        roll,
    ]


def kinetic(s: facts.Values) -> facts.Number:
    """Return ½ m v² and that of the turns: m r²/4 about a diameter, m r²/2 about the axis [J]."""
    w, n, k = s["yaw'"], s["spin'"], s["lean'"]
    speed = s["x'"] ** 2 + s["y'"] ** 2 + s["z'"] ** 2
    turns = k * k + (w * cos(s.lean)) ** 2 + 2 * (n + w * sin(s.lean)) ** 2
    return s.m * (speed / 2 + s.r**2 * turns / 8)


def circle(s: facts.Values) -> float:
    """Return the spin' with which the coin keeps its lean on a circle [rad/s]."""
    push = 4 * s.g * sin(LEAN) / (5 * s.r) + sin(LEAN) * cos(LEAN) * TURN**2
    return float(-5 * push / (6 * cos(LEAN) * TURN))


def start(s: facts.Values) -> dict[str, float]:
    """Return a state of the steady circle."""
    speed = s.r * (circle(s) + TURN * sin(LEAN))
    return {
        "z": s.r * cos(LEAN),
        "lean": LEAN,
        "x'": speed,
        "yaw'": TURN,
        "spin'": circle(s),
    }


SYSTEM = System(
    title="Coin that rolls on level ground",
    source="P. Appell, Rend. Circ. Mat. Palermo 14 (1900) 1; Neimark & Fufaev, Dynamics of "
    "Nonholonomic Systems, 1972, ch. II",
    build=mechanism,
    start={"lean": 0.2, "z": 0.5 * float(cos(0.2))},
    start_velocity={"yaw": 0.5, "spin": -5.0},
    duration=8.0,
    tags=("spatial", "rolling", "nonholonomic", "contact"),
    facts=(
        facts.Acceleration(
            "lean'' = 4 g sin(lean)/(5 r) + cos(lean) (yaw'^2 sin(lean) + 6/5 yaw' spin')",
            accelerations,
        ),
        facts.KineticEnergy(
            "T = m v^2/2 + m r^2 (lean'^2 + yaw'^2 cos(lean)^2 + 2 n^2)/8", kinetic
        ),
        facts.Conserved("the energy T + m g z", lambda s: kinetic(s) + s.m * s.g * s.z),
        facts.Solution(
            "a steady circle: 4 g tan(lean)/(5 r) + yaw'^2 sin(lean) + 6/5 yaw' spin' = 0",
            start,
            lambda s: {
                "lean": LEAN,
                "yaw": TURN * s.t,
                "spin": circle(s) * s.t,
                "z": s.r * cos(LEAN),
            },
            until=lambda s: 4.0,
        ),
    ),
    forms={
        (
            "T = m (x'^2 + y'^2 + z'^2)/2 + m r^2 (lean'^2 + cos(lean)^2 yaw'^2)/8 + m r^2 (spin' "
            "+ sin(lean) yaw')^2/4"
        ): "Neimark & Fufaev, ch. II, with the moments of a disk",
        (
            "5 r lean'' - 5 r sin(lean) cos(lean) yaw'^2 - 6 r cos(lean) yaw' spin' - 4 g "
            "sin(lean) = 0"
        ): "Neimark & Fufaev, ch. II",
        "3 sin(lean) yaw'' + 3 spin'' + 5 cos(lean) yaw' lean' = 0": "Neimark & Fufaev, ch. II",
    },
)
