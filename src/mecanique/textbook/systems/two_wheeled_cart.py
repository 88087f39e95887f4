"""Two-wheeled cart.

Two wheels on one axle, each of mass mw, radius r and moment of inertia Jw about the axle and Kw
about a diameter, the distance b to both sides of the middle, roll on level ground without slip. The
load of mass m hangs from the axle, its center of mass h below; its principal moments of inertia are
I1, I2 and I3 about the axes ahead, along the axle and up. Gravity is g. The generalized coordinates
are the place x, y, z of the axle's middle, the heading yaw, the tilt roll of the axle, the swing
pitch of the load and the turns left and right of the wheels against the load: five positions and
three velocities are independent. Both wheels keep the axle from sliding sideways, one would do: how
they share that friction is undetermined.
"""

from numpy import cos, pi, sin, sqrt

from mecanique import model as mq
from mecanique.textbook import System, facts
from mecanique.textbook.joints import carriers, hinge, hinges, slides

ORANGE = (0.9, 0.6, 0.0, 1.0)


m = mq.Parameter("m", 30.0, "kg", "mass of the load")
h = mq.Parameter("h", 0.15, "m", "distance of its center of mass below the axle")
I1 = mq.Parameter("I1", 1.1, "kg·m²", "moment of inertia of the load about the axis ahead")
I2 = mq.Parameter("I2", 0.8, "kg·m²", "moment of inertia of the load about the axle")
I3 = mq.Parameter("I3", 1.3, "kg·m²", "moment of inertia of the load about its axis up")
mw = mq.Parameter("mw", 2.5, "kg", "mass of a wheel")
r = mq.Parameter("r", 0.3, "m", "radius of the wheels")
b = mq.Parameter("b", 0.35, "m", "distance of the wheels from the middle")
Jw = mq.Parameter("Jw", 0.11, "kg·m²", "moment of inertia of a wheel about the axle")
Kw = mq.Parameter("Kw", 0.06, "kg·m²", "moment of inertia of a wheel about a diameter")
g = mq.Parameter("g", 9.81, "m/s²", "acceleration of free fall")

# the cart, the middle of its axle led by three slides
floor = mq.Visual(
    mq.Box((6 * r, 6 * r, 0.02)), mq.Placement((0, 0, -0.01)), (0.85, 0.85, 0.85, 1.0)
)
box = mq.Visual(mq.Box((1.2 * r, 1.2 * b, 0.6 * r)), mq.Placement((0, 0, -h)))
shaft = mq.Visual(mq.Cylinder(0.06 * r, 2 * b), mq.Placement(rpy=(pi / 2, 0, 0)), ORANGE)
rim = mq.Visual(mq.Cylinder(r, 0.1 * r), mq.Placement(rpy=(pi / 2, 0, 0)))
spoke = mq.massless(mq.Visual(mq.Box((0.1 * r, 0.14 * r, 1.8 * r)), rgba=ORANGE))
wheel = mq.Shape(mw, (0, 0, 0), (Kw, Jw, Kw, 0, 0, 0), (rim,))
chart = (*slides("middle"), *hinges("middle", "axle", "load", names=("turn", "side", "swing")))
mechanism = mq.Mechanism(
    name="two_wheeled_cart",
    bodies=(
        mq.Body("ground", mq.massless(floor)),
        *carriers(chart),
        mq.Body("load", mq.Shape(m, (0, 0, -h), (I1, I2, I3, 0, 0, 0), (box, shaft))),
        mq.Body("left_wheel", wheel, spoke),
        mq.Body("right_wheel", wheel, spoke),
    ),
    joints=(
        *chart,
        hinge("left_hub", "load", "left_wheel", "left", at=(0, b, 0), axis=(0, 1, 0)),
        hinge("right_hub", "load", "right_wheel", "right", at=(0, -b, 0), axis=(0, 1, 0)),
    ),
    coordinates=mq.Coordinates((), limits={"roll": (-pi / 2, pi / 2)}),
    contacts=(
        mq.Rolling("left_contact", "left_wheel", r),
        mq.Rolling("right_contact", "right_wheel", r),
    ),
    parameters=(m, h, I1, I2, I3, mw, r, b, Jw, Kw, g),
    gravity=(0, 0, -g),
)


def speed(s: facts.Values) -> facts.Number:
    """Return the speed u ahead [m/s]."""
    return cos(s.yaw) * s["x'"] + sin(s.yaw) * s["y'"]


def about_vertical(s: facts.Values) -> facts.Number:
    """Return the moment of inertia about the vertical through the middle [kg·m²]."""
    load = s.I1 * sin(s.pitch) ** 2 + s.I3 * cos(s.pitch) ** 2 + s.m * (s.h * sin(s.pitch)) ** 2
    return load + 2 * (s.mw * s.b**2 + s.Kw + s.Jw * s.b**2 / s.r**2)


def independent(s: facts.Values) -> tuple[facts.Number, facts.Number, facts.Number]:
    """Return u', yaw'' and pitch'' by the balances of what moves ahead, turns and swings."""
    sine, cosine = sin(s.pitch), cos(s.pitch)
    u, w, k = speed(s), s["yaw'"], s["pitch'"]
    bend = (s.I1 - s.I3 + s.m * s.h**2) * sine * cosine
    turn = (s.m * s.h * sine * u * w - 2 * bend * w * k) / about_vertical(s)
    mass, arm = s.m + 2 * s.mw + 2 * s.Jw / s.r**2, s.m * s.h * cosine
    swinging = s.I2 + s.m * s.h**2
    ahead, about = -s.m * s.h * sine * (k * k + w * w), bend * w * w - s.m * s.g * s.h * sine
    # mass u' - arm pitch'' = ahead, swinging pitch'' - arm u' = about
    size = mass * swinging - arm**2
    return (swinging * ahead + arm * about) / size, turn, (mass * about + arm * ahead) / size


def accelerations(s: facts.Values) -> list[facts.Number]:
    """Return all accelerations; those of place and wheels follow from rolling."""
    change, turn, swing = independent(s)
    across = speed(s) * s["yaw'"]
    return [
        cos(s.yaw) * change - sin(s.yaw) * across,
        sin(s.yaw) * change + cos(s.yaw) * across,
        0.0,
        turn,
        0.0,
        swing,
        (change - s.b * turn) / s.r - swing,
        (change + s.b * turn) / s.r - swing,
    ]


def energy(s: facts.Values) -> facts.Number:
    """Return T + V, with the wheels' turns by rolling [J]."""
    u, w, k = speed(s), s["yaw'"], s["pitch'"]
    mass = s.m + 2 * s.mw + 2 * s.Jw / s.r**2
    kinetic = mass * u**2 / 2 + about_vertical(s) * w**2 / 2 + (s.I2 + s.m * s.h**2) * k**2 / 2
    return kinetic - s.m * s.h * cos(s.pitch) * (u * k + s.g)


def swinging(s: facts.Values) -> list[complex]:
    """Return the exponents of the swinging at rest."""
    mass = s.m + 2 * s.mw + 2 * s.Jw / s.r**2
    held = s.I2 + s.m * s.h**2 - (s.m * s.h) ** 2 / mass
    rate = float(sqrt(s.m * s.g * s.h / held))
    return [1j * rate, -1j * rate]


SYSTEM = System(
    title="Cart on two wheels with a load that swings",
    source="Neimark & Fufaev, Dynamics of Nonholonomic Systems, 1972; equations of what "
    "balances on two wheels",
    build=mechanism,
    start={"z": 0.3, "pitch": 0.8},
    start_velocity={"yaw": 1.0},
    duration=8.0,
    tags=("spatial", "rolling", "nonholonomic", "contact", "vehicle", "redundant"),
    facts=(
        facts.Acceleration(
            "M u' - m h cos(p) p'' = -m h sin(p) (p'^2 + w^2), (I2 + m h^2) p'' - m h cos(p) u' "
            "= (I1 - I3 + m h^2) sin(p) cos(p) w^2 - m g h sin(p), p = pitch, w = yaw'",
            accelerations,
        ),
        facts.KineticEnergy(
            "T = M u^2/2 + D w^2/2 + (I2 + m h^2) p'^2/2 - m h cos(p) u p'",
            lambda s: energy(s) + s.m * s.g * s.h * cos(s.pitch),
        ),
        facts.Conserved("the energy T - m g h cos(p)", energy),
        facts.Eigenvalues(
            "at rest it swings at ω² = m g h/(I2 + m h^2 - m^2 h^2/M), M = m + 2 mw + 2 Jw/r^2",
            swinging,
            at=lambda s: {"z": s.r},
        ),
    ),
    forms={
        "right' = 2 b yaw'/r + left'": (
            "Siegwart & Nourbakhsh, Autonomous Mobile Robots, ch. 3: the turn of a differential "
            "drive"
        ),
        "x' = b cos(yaw) yaw' + r cos(yaw) pitch' + r cos(yaw) left'": (
            "the same, its way ahead; the wheel turns by pitch and left"
        ),
    },
)
