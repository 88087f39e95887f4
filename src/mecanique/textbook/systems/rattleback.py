"""Rattleback.

A stone of mass m, half of an ellipsoid with the semi-axes a, b and c, rolls on level ground without
slip, under gravity g. Its center of mass lies h below the ellipsoid's center; about it, in the
ellipsoid's axes, its moments of inertia are A, B and C, and D is the entry xy of its tensor: its
principal axes are turned against the ellipsoid's. Spun the wrong way, it rattles, stops and turns
back. The generalized coordinates are the place x, y, z of the ellipsoid's center and the angles yaw
about the vertical, roll about the long axis and pitch about the short one.
"""

from numpy import array, cross, diag, eye, pi, real, sqrt, stack
from numpy.linalg import solve

from mecanique import model as mq
from mecanique.textbook import System, facts
from mecanique.textbook.joints import about, carriers, hinges, slides

EX, EY, EZ = eye(3)


m = mq.Parameter("m", 1.0, "kg", "mass of the stone")
a = mq.Parameter("a", 0.2, "m", "semi-axis ahead")
b = mq.Parameter("b", 0.03, "m", "semi-axis across")
c = mq.Parameter("c", 0.02, "m", "semi-axis down")
h = mq.Parameter("h", 0.01, "m", "distance of the center of mass below the ellipsoid's center")
A = mq.Parameter("A", 0.0002, "kg·m²", "moment of inertia about the long axis")
B = mq.Parameter("B", 0.0016, "kg·m²", "moment of inertia about the axis across")
C = mq.Parameter("C", 0.0017, "kg·m²", "moment of inertia about the axis up")
D = mq.Parameter("D", -0.0002, "kg·m²", "entry xy of the tensor of inertia")
g = mq.Parameter("g", 9.81, "m/s²", "acceleration of free fall")

# the stone, the ellipsoid's center led by three slides
floor = mq.Visual(
    mq.Box((3 * a, 3 * a, 0.1 * c)), mq.Placement((0, 0, -0.05 * c)), (0.85, 0.85, 0.85, 1)
)
slabs = tuple(
    mq.Visual(mq.Box((2 * x * a, 2 * y * b, 0.2 * c)), mq.Placement((0, 0, -z * c)))
    for x, y, z in ((0.95, 0.95, 0.1), (0.88, 0.88, 0.3), (0.8, 0.78, 0.5), (0.6, 0.6, 0.7))
)
mark = mq.Visual(mq.Box((1.9 * a, 0.2 * b, 0.1 * c)), rgba=(0.9, 0.6, 0.0, 1.0))
chart = (*slides("center"), *hinges("center", "leaning", "stone"))
mechanism = mq.Mechanism(
    name="rattleback",
    bodies=(
        mq.Body("ground", mq.massless(floor)),
        *carriers(chart),
        mq.Body("stone", mq.Shape(m, (0, 0, -h), (A, B, C, D, 0, 0), slabs), mq.massless(mark)),
    ),
    joints=chart,
    coordinates=mq.Coordinates((), limits={"roll": (-pi / 2, pi / 2)}),
    contacts=(mq.Rolling("below", "stone", a, axis=None, stretch=(1, b / a, c / a)),),
    parameters=(m, a, b, c, h, A, B, C, D, g),
    gravity=(0, 0, -g),
)


def axes(s: facts.Values) -> facts.Number:
    """Return the axes of the turns yaw, roll and pitch in the stone's axes, as columns."""
    lean, nod = about(1, s.pitch).T, about(0, s.roll).T
    return stack([lean @ nod @ EZ, lean @ EX, EY], axis=1)


def spin(s: facts.Values) -> facts.Number:
    """Return the angular velocity in the stone's axes."""
    return axes(s) @ array([s["yaw'"], s["roll'"], s["pitch'"]])


def tensor(s: facts.Values) -> facts.Number:
    """Return the tensor of inertia about the center of mass."""
    return array([[s.A, s.D, 0], [s.D, s.B, 0], [0, 0, s.C]])


def accelerations(s: facts.Values) -> facts.Number:
    """Return all accelerations, by the balance of moments about the point that touches."""
    w, up = real(spin(s)), real(axes(s)[:, 0])
    squares = diag([s.a**2, s.b**2, s.c**2])
    reach = sqrt(up @ squares @ up)
    change = cross(up, w)
    low = -squares @ up / reach  # from the center to the ground
    shift = -squares @ change / reach - low * (up @ squares @ change) / reach**2
    middle = array([0, 0, -s.h])
    arm = low - middle
    # of the center of mass, without w': the center moves with -w x low
    known = cross(w, cross(w, middle)) - cross(w, shift + cross(w, low))
    I, hats = tensor(s), stack([cross(arm, cross(e, arm)) for e in eye(3)], axis=1)
    moment = s.m * cross(arm, known + s.g * up) - cross(w, I @ w)
    turn = solve(I + s.m * hats, moment)
    center = -cross(turn, low) - cross(w, shift + cross(w, low))
    lean = about(1, s.pitch).T
    yawing = about(0, s.roll).T @ EZ * s["yaw'"]
    inner = s["roll'"] * EX + yawing
    drift = -s["pitch'"] * cross(EY, lean @ inner) - lean @ cross(s["roll'"] * EX, yawing)
    angles = solve(axes(s), turn - drift)
    to_world = about(2, s.yaw) @ about(0, s.roll) @ about(1, s.pitch)
    return real([*(to_world @ center), *angles])


def kinetic(s: facts.Values) -> facts.Number:
    """Return the kinetic energy, complex where s is [J]."""
    w = spin(s)
    to_world = about(2, s.yaw) @ about(0, s.roll) @ about(1, s.pitch)
    velocity = array([s["x'"], s["y'"], s["z'"]]) + to_world @ cross(w, array([0, 0, -s.h]))
    return (s.m * velocity @ velocity + w @ tensor(s) @ w) / 2


def energy(s: facts.Values) -> facts.Number:
    """Return T + m g times the height of the center of mass [J]."""
    return kinetic(s) + s.m * s.g * (s.z - s.h * axes(s)[2, 0])


SYSTEM = System(
    title="Rattleback, a stone that turns back",
    source="T. R. Kane & D. A. Levinson, Int. J. Non-Linear Mechanics 17 (1982) 175",
    build=mechanism,
    start={"z": 0.02, "roll": 0.01, "pitch": 0.01},
    start_velocity={"yaw": -5.0},
    duration=4.0,
    tags=("spatial", "rolling", "nonholonomic", "contact"),
    facts=(
        # the source has Kane's equations, without multipliers: in numbers, these are they
        facts.Acceleration(
            "I w' + m s x (w' x s) = m s x (a + g z) - w x I w about the point that touches, s "
            "from the center of mass to it",
            accelerations,
        ),
        facts.KineticEnergy("T = m v^2/2 + w I w/2", lambda s: real(kinetic(s))),
        facts.Conserved("the energy T + m g z of the center of mass", energy),
        facts.Steady(
            "it may spin about the vertical at any rate",
            lambda s: {"z": s.c, "yaw'": -5.0},
        ),
    ),
    forms={
        (
            "rho = sqrt(a^2 cos(roll)^2 sin(pitch)^2 + b^2 sin(roll)^2 + c^2 cos(roll)^2 "
            "cos(pitch)^2)"
        ): "Kane & Levinson 1982: ε, with the components of the vertical in the stone's axes",
        "z - rho = 0": "Kane & Levinson 1982: the ellipsoid touches the ground",
    },
)
