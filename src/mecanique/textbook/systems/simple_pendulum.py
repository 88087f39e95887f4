"""Simple pendulum.

A particle m hangs from a fixed pin by a massless rod of length l and swings in a vertical plane
under gravity g. The generalized coordinate q is the angle from the downward vertical, positive
towards +x.
"""

from numpy import arcsin, cos, sin, sqrt

from mecanique import model as mq
from mecanique.textbook import System, facts
from mecanique.textbook.joints import hinge

m = mq.Parameter("m", 1.0, "kg", "mass of the particle")
l = mq.Parameter("l", 1.0, "m", "length of the rod")
g = mq.Parameter("g", 9.81, "m/s²", "acceleration of free fall")

mechanism = mq.Mechanism(
    name="simple_pendulum",
    bodies=(mq.Body("ground"), mq.Body("bob", mq.bar(l), mq.particle(m, (0, 0, -l)))),
    joints=(hinge("pin", "ground", "bob", "q"),),
    parameters=(m, l, g),
    gravity=(0, 0, -g),
)


def tension(s: facts.Values) -> tuple[float, float, float]:
    """Return the pin's force on the rod: the tension along it, nothing across."""
    S = s.m * s.g * cos(s.q) + s.m * s.l * s["q'"] ** 2
    return -S * sin(s.q), 0.0, S * cos(s.q)


def swing(s: facts.Values) -> dict[str, float]:
    """Return the motion of amplitude 2.5 rad, lowest at t = 0, by Jacobi's elliptic functions."""
    from scipy.special import ellipj

    k, n = sin(1.25), sqrt(s.g / s.l)
    sn, cn, _, _ = ellipj(n * s.t, k**2)
    return {"q": 2 * arcsin(k * sn), "q'": 2 * k * n * cn}


SYSTEM = System(
    title="Particle on a massless rod, pinned, under gravity",
    source="Landau & Lifshitz, Mechanics, 3rd ed., sect. 11, problem 1; Whittaker, "
    "Analytical Dynamics, sect. 44",
    build=mechanism,
    start={"q": 2.5},
    tags=("pendulum", "planar"),
    facts=(
        facts.Acceleration("q'' = -g sin(q) / l", lambda s: [-s.g / s.l * sin(s.q)]),
        facts.Reaction("the rod pulls with m g cos(q) + m l q'²", "pin", tension),
        facts.Period(
            "swings of amplitude A last 4 sqrt(l / g) K(k), k = sin(A/2)",
            {"q": 2.5},
            lambda s: facts.swing_period(s.l, s.g, 2.5),
        ),
        facts.Solution(
            "sin(q/2) = k sn(sqrt(g/l) t, k), from the lowest point",
            lambda s: {"q'": 2 * sin(1.25) * sqrt(s.g / s.l)},
            swing,
            until=lambda s: 1.5 * facts.swing_period(s.l, s.g, 2.5),
        ),
    ),
    forms={
        "q'' + g sin(q)/l = 0": "Whittaker, sect. 44",
        "E = m l^2 q'^2/2 - m g l cos(q)": "Landau & Lifshitz, sect. 11, problem 1",
    },
)
