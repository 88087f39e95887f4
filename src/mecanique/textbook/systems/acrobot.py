"""Acrobot.

A gymnast of two homogeneous links m1, l1 and m2, l2 hangs from a bar: the hands are a free hinge,
and only the hips exert a torque, tau(t) = K sin(W t). Gravity g acts in the plane of the swing. The
generalized coordinates are the angle q1 of the first link from the downward vertical, positive
towards +x, and the angle q2 of the second link from the direction of the first.
"""

import numpy as np
from numpy import sin, sqrt

from mecanique import model as mq
from mecanique.textbook import System, facts
from mecanique.textbook.joints import hinge
from mecanique.textbook.systems.two_link_arm import mass_matrix

m1 = mq.Parameter("m1", 1.0, "kg", "mass of the first link")
m2 = mq.Parameter("m2", 1.0, "kg", "mass of the second link")
l1 = mq.Parameter("l1", 1.0, "m", "length of the first link")
l2 = mq.Parameter("l2", 1.0, "m", "length of the second link")
K = mq.Parameter("K", 2.0, "N·m", "amplitude of the torque")
W = mq.Parameter("W", 2.7, "rad/s", "angular frequency of the torque")
g = mq.Parameter("g", 9.81, "m/s²", "acceleration of free fall")

tau = mq.Input("tau", K * mq.sin(W * mq.time()), "N·m", "torque of the hips")
mechanism = mq.Mechanism(
    name="acrobot",
    bodies=(
        mq.Body("ground"),
        mq.Body("link1", mq.rod(m1, l1)),
        mq.Body("link2", mq.rod(m2, l2)),
    ),
    joints=(
        hinge("hands", "ground", "link1", "q1"),
        hinge("hips", "link1", "link2", "q2", at=(0, 0, -l1)),
    ),
    forces=(mq.JointForce("motor", "hips", tau),),
    parameters=(m1, m2, l1, l2, K, W, g),
    inputs=(tau,),
    gravity=(0, 0, -g),
)


def weights(s: facts.Values) -> tuple[facts.Number, facts.Number]:
    """Return the static moments of both links times g."""
    return (s.m1 / 2 + s.m2) * s.g * s.l1, s.m2 * s.g * s.l2 / 2


def acceleration(s: facts.Values) -> facts.Number:
    """Return q''."""
    u, v = s["q1'"], s["q2'"]
    upper, lower = weights(s)
    bend, pull = s.m2 * s.l1 * s.l2 / 2 * sin(s.q2), lower * sin(s.q1 + s.q2)
    tau = s.K * sin(s.W * s.t)
    right = [bend * (2 * u * v + v**2) - upper * sin(s.q1) - pull, -bend * u**2 - pull + tau]
    return np.linalg.solve(mass_matrix(s), right)


def squares(s: facts.Values) -> tuple[facts.Number, facts.Number]:
    """Return both roots ω² of det(K - ω² M) = 0 for the hanging gymnast."""
    (a, b), (_, d) = mass_matrix(facts.Values({**s.numbers, "q2": 0.0}))
    upper, lower = weights(s)
    A, B, C = a * d - b**2, a * lower + d * (upper + lower) - 2 * b * lower, upper * lower
    return (B - sqrt(B**2 - 4 * A * C)) / (2 * A), (B + sqrt(B**2 - 4 * A * C)) / (2 * A)


SYSTEM = System(
    title="Gymnast on the bar: two links, torque at the hips only",
    source="Spong, IEEE Control Systems 15 (1995) 49; Tedrake, Underactuated Robotics, sect. 3.1",
    build=mechanism,
    duration=20.0,
    tags=("robot", "pendulum", "planar", "control", "underactuated"),
    facts=(
        facts.MassMatrix(
            "M11 = (m1/3 + m2) l1² + m2 l2²/3 + m2 l1 l2 cos(q2), "
            "M12 = m2 l2²/3 + m2 l1 l2 cos(q2)/2, M22 = m2 l2²/3",
            mass_matrix,
        ),
        facts.Acceleration(
            "M q'' = (h (2 q1' q2' + q2'²) - G sin(q1) - G2, -h q1'² - G2 + tau), "
            "h = m2 l1 l2 sin(q2) / 2, "
            "G = (m1/2 + m2) g l1, G2 = m2 g l2 sin(q1 + q2) / 2",
            acceleration,
        ),
        facts.Frequencies(
            "hanging, det(K - ω² M) = 0", lambda s: sqrt(squares(s)), given={"K": 0.0}
        ),
        facts.Steady("upright is an equilibrium", {"q1": np.pi}, given={"K": 0.0}),
        facts.Eigenvalues(
            "upright, the frequencies of hanging turn into growth rates: λ = ±ω",
            lambda s: [*sqrt(squares(s)), *-sqrt(squares(s))],
            at={"q1": np.pi},
            given={"K": 0.0},
        ),
    ),
    forms={
        (
            "(m2 l2^2/3 + m2 l1 l2 cos(q2)/2) q1'' + m2 l2^2 q2''/3 + m2 l1 l2 sin(q2) q1'^2/2 + "
            "m2 g l2 sin(q1 + q2)/2 = tau"
        ): "Spong 1995, d12 q1'' + d22 q2'' + h2 + φ2 = τ, with uniform links",
    },
)
