"""Pendulum on a cart.

A cart of mass M slides along a horizontal line against a damping c and is pushed by a force F(t). A
massless rod of length l with a particle m at its end hangs from it and swings in the vertical plane
under gravity g. The generalized coordinates are the cart's position x and the angle q of the rod
from the downward vertical, positive towards +x.
"""

from numpy import cos, sin, sqrt

from mecanique.model import (
    Body,
    Force,
    Input,
    JointDamper,
    Mechanism,
    Parameter,
    Prismatic,
    Revolute,
    bar,
    box,
    particle,
)
from mecanique.textbook.facts import Acceleration, Conserved, Frequencies, MassMatrix, Values
from mecanique.textbook.system import System


def build(M: Parameter, m: Parameter, l: Parameter, c: Parameter, g: Parameter) -> Mechanism:
    """Return the cart and its pendulum."""
    F = Input("F", 0.0, "N", "force on the cart")
    return Mechanism(
        name="cart_pole",
        bodies=(
            Body("ground"),
            Body("cart", box(M, (0.4, 0.2, 0.2))),
            Body("pole", bar(l), particle(m, (0, 0, -l))),
        ),
        joints=(
            Prismatic("slide", "ground", "cart", axis=(1, 0, 0), coordinate="x"),
            Revolute("pin", "cart", "pole", axis=(0, -1, 0), coordinate="q"),
        ),
        forces=(
            JointDamper("damping", "slide", c),
            Force("push", "cart", (0, 0, 0), force=(F, 0, 0)),
        ),
        parameters=(M, m, l, c, g),
        inputs=(F,),
        gravity=(0, 0, -g),
    )


def acceleration(s: Values) -> tuple[float, float]:
    """Return x'' and q'' (Tedrake, eqs. of the cart-pole, without input and with damping c)."""
    push = s.m * sin(s.q) * (s.l * s["q'"] ** 2 + s.g * cos(s.q)) - s.c * s["x'"]
    x = push / (s.M + s.m * sin(s.q) ** 2)
    return x, -(x * cos(s.q) + s.g * sin(s.q)) / s.l


SYSTEM = System(
    title="Pendulum hanging from a cart that is pushed and damped",
    source="Tedrake, Underactuated Robotics, sect. 3.2; Goldstein, Classical Mechanics, ch. 1",
    parameters=(
        Parameter("M", 2.0, "kg", "mass of the cart"),
        Parameter("m", 1.0, "kg", "mass of the particle"),
        Parameter("l", 1.0, "m", "length of the rod"),
        Parameter("c", 0.1, "N·s/m", "damping of the cart"),
        Parameter("g", 9.81, "m/s²", "acceleration of free fall"),
    ),
    build=build,
    start={"q": 2.0},
    tags=("pendulum", "planar", "control"),
    facts=(
        Acceleration(
            "(M + m sin²(q)) x'' = m sin(q) (l q'² + g cos(q)) - c x' "
            "and l q'' = -x'' cos(q) - g sin(q)",
            acceleration,
        ),
        MassMatrix(
            "M = [[M + m, m l cos(q)], [m l cos(q), m l²]]",
            lambda s: [[s.M + s.m, s.m * s.l * cos(s.q)], [s.m * s.l * cos(s.q), s.m * s.l**2]],
        ),
        Frequencies(
            "ω = 0 and sqrt((1 + m/M) g / l), hanging",
            lambda s: [0, sqrt((1 + s.m / s.M) * s.g / s.l)],
        ),
        Conserved(
            "(M + m) x' + m l q' cos(q) + c x, the momentum plus the impulse of the damper",
            lambda s: (s.M + s.m) * s["x'"] + s.m * s.l * s["q'"] * cos(s.q) + s.c * s.x,
        ),
    ),
    forms={
        "(M + m) x'' + m l cos(q) q'' - m l sin(q) q'^2 + c x' = F": "Tedrake, sect. 3.2",
    },
)
