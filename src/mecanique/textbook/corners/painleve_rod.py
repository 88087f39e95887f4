"""Painlevé's rod.

A uniform rod of mass m and length 2 l stands with one end on a rough floor with coefficient of
friction mu and leans, under gravity g. The generalized coordinates x and z are those of its center,
th is its angle. Where mu is above 4/3 there are positions in which sliding has no solution, or two.
"""

from math import atan, cos, pi, sin

from mecanique import model as mq
from mecanique.textbook import System, facts

m = mq.Parameter("m", 1.0, "kg", "mass of the rod")
l = mq.Parameter("l", 1.0, "m", "half the length of the rod")
mu = mq.Parameter("mu", 1.3, "1", "coefficient of friction")
g = mq.Parameter("g", 9.81, "m/s²", "acceleration of free fall")

mechanism = mq.Mechanism(
    name="painleve_rod",
    bodies=(mq.Body("ground"), mq.Body("rod", mq.rod(m, 2 * l).at((0, 0, l)))),
    joints=(mq.Planar("plane", "ground", "rod", axis=(0, -1, 0), names=("x", "z", "th")),),
    parameters=(m, l, mu, g),
    gravity=(0, 0, -g),
    switching=(mq.Contact("floor", "rod", center=(0, 0, -l), mu=mu),),
)


LEAN = pi / 2 - atan(2.0)
"""The lean at which the least coefficient of friction gives the paradox."""


def _slides(s: facts.Values) -> list[float]:
    """The accelerations while it slides forward, by the force N of the floor."""
    across = sin(s.th) - s.mu * cos(s.th)
    N = s.m * (s.g - s.l * cos(s.th) * s["th'"] ** 2) / (1 + 3 * sin(s.th) * across)
    return [-s.mu * N / s.m, N / s.m - s.g, 3 * N * across / (s.m * s.l)]


SYSTEM = System(
    title="Painlevé's rod, which slides on its end",
    source="Painlevé, C. R. Acad. Sci. 121 (1895) 112; Champneys & Várkonyi, arXiv 1601.03545",
    build=mechanism,
    start={"z": cos(LEAN), "x": 0.0, "th": LEAN},
    start_velocity={"x": 1.0},
    duration=0.2,
    tags=("planar", "friction", "contact", "corners"),
    facts=(
        facts.ModeAcceleration(
            "N (1 + 3 sin(th) (sin(th) - mu cos(th))) = m (g - l th'^2 cos(th)) where it slides",
            ("slips +",),
            _slides,
        ),
        facts.Occurs(
            "its end is at rest when it sticks",
            "floor: sticks",
            lambda s: {"x'": -s.l * cos(s.th) * s["th'"]},
        ),
    ),
)
