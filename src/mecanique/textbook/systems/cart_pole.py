"""Pendulum on a cart.

A cart of mass M slides along a horizontal line against a damping c and is pushed by a force F(t). A
massless rod of length l with a particle m at its end hangs from it and swings in the vertical plane
under gravity g. The generalized coordinates are the cart's position x and the angle q of the rod
from the downward vertical, positive towards +x.
"""

from numpy import cos, sin, sqrt

from mecanique import model as mq
from mecanique.textbook import System, facts
from mecanique.textbook.joints import hinge

M = mq.Parameter("M", 2.0, "kg", "mass of the cart")
m = mq.Parameter("m", 1.0, "kg", "mass of the particle")
l = mq.Parameter("l", 1.0, "m", "length of the rod")
c = mq.Parameter("c", 0.1, "N·s/m", "damping of the cart")
g = mq.Parameter("g", 9.81, "m/s²", "acceleration of free fall")

F = mq.Input("F", 0.0, "N", "force on the cart")
mechanism = mq.Mechanism(
    name="cart_pole",
    bodies=(
        mq.Body("ground"),
        mq.Body("cart", mq.box(M, (0.4, 0.2, 0.2))),
        mq.Body("pole", mq.bar(l), mq.particle(m, (0, 0, -l))),
    ),
    joints=(
        mq.Prismatic("slide", "ground", "cart", axis=(1, 0, 0), coordinate="x"),
        hinge("pin", "cart", "pole", "q"),
    ),
    forces=(
        mq.JointDamper("damping", "slide", c),
        mq.Force("push", "cart", (0, 0, 0), force=(F, 0, 0)),
    ),
    parameters=(M, m, l, c, g),
    inputs=(F,),
    gravity=(0, 0, -g),
)


def acceleration(s: facts.Values) -> tuple[float, float]:
    """Return x'' and q'' (Tedrake, eqs. of the cart-pole, without input and with damping c)."""
    push = s.m * sin(s.q) * (s.l * s["q'"] ** 2 + s.g * cos(s.q)) - s.c * s["x'"]
    x = push / (s.M + s.m * sin(s.q) ** 2)
    return x, -(x * cos(s.q) + s.g * sin(s.q)) / s.l


SYSTEM = System(
    title="Pendulum hanging from a cart that is pushed and damped",
    source="Tedrake, Underactuated Robotics, sect. 3.2; Goldstein, Classical Mechanics, ch. 1",
    build=mechanism,
    start={"q": 2.0},
    tags=("pendulum", "planar", "control"),
    facts=(
        facts.Acceleration(
            "(M + m sin²(q)) x'' = m sin(q) (l q'² + g cos(q)) - c x' "
            "and l q'' = -x'' cos(q) - g sin(q)",
            acceleration,
        ),
        facts.MassMatrix(
            "M = [[M + m, m l cos(q)], [m l cos(q), m l²]]",
            lambda s: [[s.M + s.m, s.m * s.l * cos(s.q)], [s.m * s.l * cos(s.q), s.m * s.l**2]],
        ),
        facts.Frequencies(
            "ω = 0 and sqrt((1 + m/M) g / l), hanging",
            lambda s: [0, sqrt((1 + s.m / s.M) * s.g / s.l)],
        ),
        facts.Conserved(
            "(M + m) x' + m l q' cos(q) + c x, the momentum plus the impulse of the damper",
            lambda s: (s.M + s.m) * s["x'"] + s.m * s.l * s["q'"] * cos(s.q) + s.c * s.x,
        ),
    ),
    forms={
        "(M + m) x'' + m l cos(q) q'' - m l sin(q) q'^2 + c x' = F": "Tedrake, sect. 3.2",
        "cos(q) x'' + l q'' + g sin(q) = 0": "Tedrake, sect. 3.2",
    },
)
