"""Snakeboard.

A board with its rider, of mass m and moment of inertia J about its center, carries at the distance
l ahead and behind two axles with wheels that do not slip sideways, each of moment of inertia Jw.
The rider swings arms of moment of inertia Ja by A sin(W t) and turns the axles against each other,
the front one by B cos(W t), and so drives on level ground without ever pushing it. The generalized
coordinates are the place x, y of the board's center and its heading theta; the wheels leave one
velocity.
"""

from numpy import array, cos, sin

from mecanique import model as mq
from mecanique.textbook import System, facts
from mecanique.textbook.joints import hinge

ORANGE = (0.9, 0.6, 0.0, 1.0)


m = mq.Parameter("m", 6.0, "kg", "mass of the board with its rider")
J = mq.Parameter("J", 0.12, "kg·m²", "moment of inertia of the board with its rider")
Ja = mq.Parameter("Ja", 0.07, "kg·m²", "moment of inertia of the arms")
Jw = mq.Parameter("Jw", 0.01, "kg·m²", "moment of inertia of an axle with its wheels")
l = mq.Parameter("l", 0.2, "m", "distance of the axles from the center")
A = mq.Parameter("A", 0.8, "rad", "swing of the arms")
B = mq.Parameter("B", 0.4, "rad", "turn of the axles")
W = mq.Parameter("W", 3.0, "rad/s", "rate of both")


def axle(inertia: mq.Parameter, l: mq.Parameter) -> mq.Shape:
    """Return an axle with its two wheels."""
    wheels = [
        mq.Visual(
            mq.Box((0.24 * l, 0.06 * l, 0.24 * l)), mq.Placement((0, side * 0.25 * l, 0.12 * l))
        )
        for side in (1, -1)
    ]
    shaft = mq.Visual(mq.Box((0.05 * l, 0.5 * l, 0.05 * l)), mq.Placement((0, 0, 0.12 * l)), ORANGE)
    half = inertia / 2
    return mq.Shape(0, (0, 0, 0), (half, half, inertia, 0, 0, 0), (shaft, *wheels))


# the board, the arms and both axles, which turn as the rider wants
deck = mq.Visual(mq.Box((2.3 * l, 0.4 * l, 0.06 * l)), mq.Placement((0, 0, 0.3 * l)))
swung = mq.Visual(mq.Box((0.15 * l, 1.6 * l, 0.15 * l)), mq.Placement((0, 0, 1.2 * l)), ORANGE)
mechanism = mq.Mechanism(
    name="snakeboard",
    bodies=(
        mq.Body("ground"),
        mq.Body("board", mq.Shape(m, (0, 0, 0), (J / 2, J / 2, J, 0, 0, 0), (deck,))),
        mq.Body("arms", mq.Shape(0, (0, 0, 0), (Ja, Ja, Ja, 0, 0, 0), (swung,))),
        mq.Body("front", axle(Jw, l)),
        mq.Body("back", axle(Jw, l)),
    ),
    joints=(
        mq.Planar("plane", "ground", "board", names=("x", "y", "theta")),
        mq.Revolute("waist", "board", "arms", axis=(0, 0, 1), coordinate="psi"),
        hinge("front_pivot", "board", "front", "phi", at=(l, 0, 0), axis=(0, 0, 1)),
        hinge("back_pivot", "board", "back", "phi_back", at=(-l, 0, 0), axis=(0, 0, 1)),
    ),
    coordinates=mq.Coordinates(
        (),
        {
            "psi": A * mq.sin(W * mq.time()),
            "phi": B * mq.cos(W * mq.time()),
            "phi_back": -B * mq.cos(W * mq.time()),
        },
    ),
    contacts=(mq.Blade("front_wheels", "front"), mq.Blade("back_wheels", "back")),
    parameters=(m, J, Ja, Jw, l, A, B, W),
    gravity=(0, 0, 0),
)


def ahead(s: facts.Values) -> tuple[facts.Number, facts.Number]:
    """Return the speed u of the board along itself and u'."""
    phi, rate = s.B * cos(s.W * s.t), -s.B * s.W * sin(s.W * s.t)
    swing = -s.A * s.W**2 * sin(s.W * s.t)
    u = cos(s.theta) * s["x'"] + sin(s.theta) * s["y'"]
    sway = sin(phi) / cos(phi) / s.l  # theta' = sway u
    inertia = s.J + s.Ja + 2 * s.Jw
    bend = rate / (cos(phi) ** 2 * s.l)  # sway'
    push = -sway * (inertia * u * bend + s.Ja * swing)
    return u, push / (s.m + inertia * sway**2)


def accelerations(s: facts.Values) -> list[facts.Number]:
    """Return x'', y'' and theta'' from u' and theta' = tan(phi) u/l."""
    phi, rate = s.B * cos(s.W * s.t), -s.B * s.W * sin(s.W * s.t)
    u, change = ahead(s)
    turn = sin(phi) / cos(phi) / s.l
    return [
        cos(s.theta) * change - sin(s.theta) * u * s["theta'"],
        sin(s.theta) * change + cos(s.theta) * u * s["theta'"],
        turn * change + rate / (cos(phi) ** 2 * s.l) * u,
    ]


def kinetic(s: facts.Values) -> facts.Number:
    """Return m v²/2 and what turns [J]."""
    arms = s["theta'"] + s.A * s.W * cos(s.W * s.t)
    rate = -s.B * s.W * sin(s.W * s.t)
    axles = (s["theta'"] + rate) ** 2 + (s["theta'"] - rate) ** 2
    speed = s["x'"] ** 2 + s["y'"] ** 2
    return (s.m * speed + s.J * s["theta'"] ** 2 + s.Ja * arms**2 + s.Jw * axles) / 2


def front_force(s: facts.Values) -> facts.Number:
    """Return the force on the front wheels, half of what bends the path and half of what turns."""
    phi = s.B * cos(s.W * s.t)
    u, _ = ahead(s)
    turn = (s.J + s.Ja + 2 * s.Jw) * accelerations(s)[2]
    turn -= s.Ja * s.A * s.W**2 * sin(s.W * s.t)
    # across the board the wheels bear m u theta', and about its center what turns it
    side = (s.m * u * s["theta'"] + turn / s.l) / (2 * cos(phi))
    return side * array([-sin(s.theta + phi), cos(s.theta + phi), 0])


SYSTEM = System(
    title="Snakeboard driven by its rider's arms",
    source="J. Ostrowski, A. Lewis, R. Murray & J. Burdick, IEEE Int. Conf. Robotics and "
    "Automation, 1994, 2391",
    build=mechanism,
    start={"x": 0.0},
    duration=12.0,
    tags=("planar", "rolling", "nonholonomic", "rheonomic", "locomotion"),
    facts=(
        facts.Acceleration(
            "(m + I k^2) u' = -k (I u k' + Ja psi''), theta' = k u, with k = tan(phi)/l and "
            "I = J + Ja + 2 Jw",
            accelerations,
        ),
        facts.KineticEnergy(
            "T = m v^2/2 + J theta'^2/2 + Ja (theta' + psi')^2/2 + Jw (theta'^2 + phi'^2)", kinetic
        ),
        facts.Reaction(
            "the front wheels bear (m u theta' + (I theta'' + Ja psi'')/l)/(2 cos(phi))",
            "front_wheels",
            front_force,
        ),
    ),
    forms={
        (
            "(J + Ja + 2 Jw + m l^2 cos(phi)^2/sin(phi)^2) theta'' + m B l^2 W sin(W t) cos(phi) "
            "theta'/sin(phi)^3 = Ja A W^2 sin(W t)"
        ): "Ostrowski et al. 1994, reduced to the heading",
    },
)
