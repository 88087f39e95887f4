"""Two-link arm.

Two homogeneous links m1, l1 and m2, l2 form a planar arm in a vertical plane; motors at shoulder
and elbow exert the torques tau1(t) and tau2(t), and both bearings have the damping b; gravity g
acts. The generalized coordinates are the joint angles, as in robotics: q1 of the first link from
the horizontal x axis, positive upwards, and q2 of the second link from the direction of the first.
"""

import numpy as np
from numpy import cos, sin

from mecanique import model as mq
from mecanique.textbook import System, facts
from mecanique.textbook.joints import hinge

m1 = mq.Parameter("m1", 3.0, "kg", "mass of the first link")
m2 = mq.Parameter("m2", 2.0, "kg", "mass of the second link")
l1 = mq.Parameter("l1", 0.5, "m", "length of the first link")
l2 = mq.Parameter("l2", 0.4, "m", "length of the second link")
b = mq.Parameter("b", 0.1, "N·m·s/rad", "damping of each bearing")
g = mq.Parameter("g", 9.81, "m/s²", "acceleration of free fall")

tau1, tau2 = (mq.Input(f"tau{i}", 0.0, "N·m", f"torque of motor {i}") for i in (1, 2))
mechanism = mq.Mechanism(
    name="two_link_arm",
    bodies=(
        mq.Body("ground"),
        mq.Body("link1", mq.rod(m1, l1, (1, 0, 0))),
        mq.Body("link2", mq.rod(m2, l2, (1, 0, 0))),
    ),
    joints=(
        hinge("shoulder", "ground", "link1", "q1"),
        hinge("elbow", "link1", "link2", "q2", at=(l1, 0, 0)),
    ),
    forces=(
        mq.JointForce("motor1", "shoulder", tau1),
        mq.JointForce("motor2", "elbow", tau2),
        mq.JointDamper("bearing1", "shoulder", b),
        mq.JointDamper("bearing2", "elbow", b),
    ),
    parameters=(m1, m2, l1, l2, b, g),
    inputs=(tau1, tau2),
    gravity=(0, 0, -g),
)


def mass_matrix(s: facts.Values) -> list[list[facts.Number]]:
    """Return M (Spong, Hutchinson & Vidyasagar, two-link planar arm; for rods)."""
    outer, cross = s.m2 * s.l2**2 / 3, s.m2 * s.l1 * s.l2 / 2 * cos(s.q2)
    return [
        [(s.m1 / 3 + s.m2) * s.l1**2 + outer + 2 * cross, outer + cross],
        [outer + cross, outer],
    ]


def acceleration(s: facts.Values) -> facts.Number:
    """Return q'' without torques."""
    u, v = s["q1'"], s["q2'"]
    bend = s.m2 * s.l1 * s.l2 / 2 * sin(s.q2)
    lower = s.m2 * s.g * s.l2 / 2 * cos(s.q1 + s.q2)
    upper = (s.m1 / 2 + s.m2) * s.g * s.l1 * cos(s.q1) + lower
    right = [bend * (2 * u * v + v**2) - upper - s.b * u, -bend * u**2 - lower - s.b * v]
    return np.linalg.solve(mass_matrix(s), right)


def energy(s: facts.Values) -> facts.Number:
    """Return T + V, with V zero where both links are level."""
    (a, b), (_, d) = mass_matrix(s)
    u, v = s["q1'"], s["q2'"]
    V = (s.m1 / 2 + s.m2) * s.g * s.l1 * sin(s.q1) + s.m2 * s.g * s.l2 / 2 * sin(s.q1 + s.q2)
    return (a * u**2 + 2 * b * u * v + d * v**2) / 2 + V


SYSTEM = System(
    title="Planar robot arm of two links in a vertical plane",
    source="Spong, Hutchinson & Vidyasagar, Robot Modeling and Control; Craig, Robotics, sect. 6.7",
    build=mechanism,
    start={"q1": 0.5, "q2": 0.5},
    duration=8.0,
    tags=("robot", "planar", "control", "damper"),
    facts=(
        facts.MassMatrix(
            "M11 = (m1/3 + m2) l1² + m2 l2²/3 + m2 l1 l2 cos(q2), "
            "M12 = m2 l2²/3 + m2 l1 l2 cos(q2)/2, M22 = m2 l2²/3",
            mass_matrix,
        ),
        facts.Acceleration(
            "M q'' = (h (2 q1' q2' + q2'²) - G1 - b q1', -h q1'² - G2 - b q2'), "
            "h = m2 l1 l2 sin(q2) / 2, "
            "G2 = m2 g l2 cos(q1 + q2) / 2, G1 = (m1/2 + m2) g l1 cos(q1) + G2",
            acceleration,
        ),
        facts.Conserved("without damping, the energy", energy, given={"b": 0.0}),
        facts.Steady("hanging, q1 = -pi/2 and q2 = 0, is an equilibrium", {"q1": -np.pi / 2}),
    ),
    forms={
        (
            "(m2 l2^2/3 + m2 l1 l2 cos(q2)/2) q1'' + m2 l2^2 q2''/3 + m2 l1 l2 sin(q2) q1'^2/2 + "
            "b q2' + m2 g l2 cos(q1 + q2)/2 = tau2"
        ): "Spong, Hutchinson & Vidyasagar, with uniform links and friction",
    },
)
