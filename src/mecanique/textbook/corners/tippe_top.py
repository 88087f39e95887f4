"""Tippe top.

A sphere of mass m and radius r whose center of mass is the distance c below its center, with
moments of inertia J_1 across and J_3 along its axis of symmetry, spins on a floor with coefficient
of friction mu under gravity g. The generalized coordinates are the place top_x, top_y, top_z of its
center and the quaternion top_qx, top_qy, top_qz, top_qw of its attitude. Spun about the vertical,
with its center of mass at rest, it glides, turns over and rolls; spun about its own axis it rises,
rolls after a moment and stays upright. Jellett's integral, its angular momentum along the line from
the contact to the center of mass, stays as it is.
"""

from math import cos, sin

from mecanique import model as mq
from mecanique.textbook import System, facts

m = mq.Parameter("m", 0.02, "kg", "mass of the top")
r = mq.Parameter("r", 0.02, "m", "radius of the sphere")
c = mq.Parameter("c", 0.006, "m", "distance of the center of mass from the center")
J_1 = mq.Parameter("J_1", 2.994e-6, "kg·m²", "moment of inertia across the axis")
J_3 = mq.Parameter("J_3", 3.2e-6, "kg·m²", "moment of inertia along the axis")
mu = mq.Parameter("mu", 0.3, "1", "coefficient of friction")
g = mq.Parameter("g", 9.81, "m/s²", "acceleration of free fall")

stem = mq.Visual(mq.Cylinder(0.2 * r, 0.9 * r), mq.Placement((0, 0, 1.4 * r)))
visuals = (*mq.ball(m, r).visuals, stem)
top = mq.Shape(m, (0, 0, -c), (J_1, J_1, J_3, 0, 0, 0), visuals=visuals)
mechanism = mq.Mechanism(
    name="tippe_top",
    bodies=(mq.Body("ground"), mq.Body("top", top)),
    joints=(mq.Floating("top", "ground", "top"),),
    parameters=(m, r, c, J_1, J_3, mu, g),
    gravity=(0, 0, -g),
    switching=(mq.Contact("floor", "top", radius=r, mu=mu),),
)


def _jellett(s: facts.Values) -> float:
    x, y, z = (
        2 * (s.top_qx * s.top_qz - s.top_qw * s.top_qy),
        2 * (s.top_qy * s.top_qz + s.top_qw * s.top_qx),
        1 - 2 * (s.top_qx**2 + s.top_qy**2),
    )
    across = s.J_1 * s.r * (s.top_wx * x + s.top_wy * y)
    return float(across + s.J_3 * s.top_wz * (s.r * z - s.c))


def _kinetic(s: facts.Values) -> float:
    x, y = s.top_vx - s.c * s.top_wy, s.top_vy + s.c * s.top_wx
    turning = s.J_1 * (s.top_wx**2 + s.top_wy**2) + s.J_3 * s.top_wz**2
    return float((s.m * (x**2 + y**2 + s.top_vz**2) + turning) / 2)


TILT = 0.1
"""How far its axis leans at the start."""

SPIN = 155.0
"""Its rate about the vertical at the start [rad/s]."""

SYSTEM = System(
    title="Tippe top that turns over until it rolls",
    source="Jellett, A Treatise on the Theory of Friction, 1872; Ciocci, Malengier, "
    "Langerock & Grimonprez, J. Appl. Math. 2012, 268537",
    build=mechanism,
    start={"top_z": 0.02, "top_qy": sin(TILT / 2), "top_qw": cos(TILT / 2)},
    start_velocity={
        "top_wx": -SPIN * sin(TILT),
        "top_wz": SPIN * cos(TILT),
        "top_vy": 0.006 * SPIN * sin(TILT),
    },
    duration=1.2,
    tags=("spatial", "friction", "contact", "corners"),
    facts=(
        facts.KineticEnergy(
            "T = (m v_C^2 + J_1 (w_x^2 + w_y^2) + J_3 w_z^2)/2, v_C of the center of mass", _kinetic
        ),
        facts.Lasting("Jellett's integral", _jellett),
    ),
)
