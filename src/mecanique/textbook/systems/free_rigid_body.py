"""Free rigid body.

A homogeneous cylinder of mass m, radius r and length l, along its z axis, is thrown spinning, under
gravity g. Its six degrees of freedom are the position x, y, z of the center and the attitude, a
unit quaternion (qx, qy, qz, qw), which has no singular direction; the velocities are those of the
center and of the turning, in the body's own axes.
"""

import numpy as np

from mecanique import model as mq
from mecanique.textbook import System, facts
from mecanique.textbook.joints import to_body, to_world

m = mq.Parameter("m", 2.0, "kg", "mass of the cylinder")
r = mq.Parameter("r", 0.2, "m", "radius of the cylinder")
l = mq.Parameter("l", 0.8, "m", "length of the cylinder")
g = mq.Parameter("g", 9.81, "m/s²", "acceleration of free fall")

mechanism = mq.Mechanism(
    name="free_rigid_body",
    bodies=(mq.Body("ground"), mq.Body("cylinder", mq.cylinder(m, r, l))),
    joints=(
        mq.Floating("free", "ground", "cylinder", names=("x", "y", "z", "qx", "qy", "qz", "qw")),
    ),
    parameters=(m, r, l, g),
    gravity=(0, 0, -g),
)


def inertia(s: facts.Values) -> facts.Number:
    """Return the principal moments of inertia, shape (3,)."""
    across = s.m * (3 * s.r**2 + s.l**2) / 12
    return np.array([across, across, s.m * s.r**2 / 2])


def velocities(s: facts.Values) -> tuple[facts.Number, facts.Number]:
    """Return the center's velocity and the angular velocity in the body's axes, shape (3,) each."""
    return np.array([s[f"free_v{axis}"] for axis in "xyz"]), np.array(
        [s[f"free_w{axis}"] for axis in "xyz"]
    )


def acceleration(s: facts.Values) -> facts.Number:
    """Return both accelerations: free fall seen from turning axes, and Euler's equations."""
    v, w = velocities(s)
    fall = to_body(s, np.array([0, 0, -s.g])) - np.cross(w, v)
    return np.concatenate((fall, np.cross(inertia(s) * w, w) / inertia(s)))


def constants(s: facts.Values) -> facts.Number:
    """Return the angular momentum about the center, the horizontal momentum and the energy."""
    v, w = velocities(s)
    T = (s.m * v @ v + w @ (inertia(s) * w)) / 2
    return np.concatenate(
        (to_world(s, inertia(s) * w), s.m * to_world(s, v)[:2], [T + s.m * s.g * s.z])
    )


def throw(s: facts.Values) -> dict[str, float]:
    """Return the center's parabola, and the angular velocity turning about the body's axis."""
    A, _, C = inertia(s)
    turn = (C - A) / A * 8.0 * s.t
    return {
        "x": 1.0 * s.t,
        "y": 0.0,
        "z": 5.0 * s.t - s.g * s.t**2 / 2,
        "free_wx": 2.0 * np.cos(turn),
        "free_wy": 2.0 * np.sin(turn),
        "free_wz": 8.0,
    }


SYSTEM = System(
    title="Cylinder thrown spinning, free in space",
    source="Fundamentals of Dynamics, ch. 1, sect. 1.2 and eq. 1.31; Landau & Lifshitz, "
    "Mechanics, sect. 33 and 36",
    build=mechanism,
    start_velocity={"free_vx": 1.0, "free_vz": 9.81, "free_wx": 4.0, "free_wz": 6.0},
    duration=2.0,
    tags=("chapter", "spatial", "free", "quaternion"),
    facts=(
        facts.Acceleration(
            "v' = R^T g - w × v and I w' = (I w) × w in the body's axes", acceleration
        ),
        facts.KineticEnergy(
            "T = m v² / 2 + w·I w / 2",
            lambda s: sum(
                s.m * v**2 / 2 + i * w**2 / 2
                for v, w, i in zip(*velocities(s), inertia(s), strict=True)
            ),
        ),
        facts.Conserved(
            "the angular momentum R I w, the horizontal momentum and the energy", constants
        ),
        facts.Solution(
            "the center flies a parabola, and w turns about the body's axis at (C - A) w_z / A",
            {"free_vx": 1.0, "free_vz": 5.0, "free_wx": 2.0, "free_wz": 8.0},
            throw,
            until=lambda s: 1.0,
        ),
    ),
    forms={
        "(m r^2/4 + m l^2/12) free_wx' + (m r^2/2 - m r^2/4 - m l^2/12) free_wy free_wz = 0": (
            "Landau & Lifshitz, eq. 36.5, with the moments of a cylinder"
        ),
    },
)
