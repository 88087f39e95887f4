"""Block that rocks on its edges.

A block of mass m, width b and height h stands on a rough floor with coefficient of friction mu and
rocks about its edges under gravity g; each impact leaves 1 - 3/2 sin(a)^2 of its rate, where
tan(a) = b/h. The generalized coordinates x and z are those of its center, th is its tilt.
"""

from math import asin, atan2, cos, hypot, sin, sqrt

from mecanique import model as mq
from mecanique.textbook import System, facts

m = mq.Parameter("m", 1.0, "kg", "mass of the block")
b = mq.Parameter("b", 0.2, "m", "width of the block")
h = mq.Parameter("h", 0.8, "m", "height of the block")
mu = mq.Parameter("mu", 1.0, "1", "coefficient of friction")
g = mq.Parameter("g", 9.81, "m/s²", "acceleration of free fall")

mechanism = mq.Mechanism(
    name="rocking_block",
    bodies=(mq.Body("ground"), mq.Body("block", mq.box(m, (b, b, h)))),
    joints=(mq.Planar("plane", "ground", "block", axis=(0, -1, 0), names=("x", "z", "th")),),
    parameters=(m, b, h, mu, g),
    gravity=(0, 0, -g),
    switching=(
        mq.Contact("left", "block", center=(-b / 2, 0, -h / 2), mu=mu),
        mq.Contact("right", "block", center=(b / 2, 0, -h / 2), mu=mu),
    ),
)


TILT = atan2(0.2, 0.8) / 2
"""Half the tilt at which the block of the typical values is on the point of falling."""


def _pace(s: facts.Values) -> float:
    """The rate p of a block on its edge, p^2 = 3 g/(4 R)."""
    return sqrt(3 * s.g / (2 * hypot(s.b, s.h)))


def _falls(s: facts.Values) -> float:
    return _pace(s) * sqrt(2 * (cos(TILT) - cos(2 * TILT)))


def _quarter(s: facts.Values) -> float:
    """The time from rest: a pendulum of the rate p, upside down, that falls to its angle 2 TILT."""
    from scipy.special import ellipk, ellipkinc

    k = cos(TILT / 2)
    return float((ellipk(k**2) - ellipkinc(asin(cos(TILT) / k), k**2)) / _pace(s))


SYSTEM = System(
    title="Block that rocks on its edges",
    source="Housner, Bull. Seism. Soc. Am. 53 (1963) 403",
    build=mechanism,
    start={
        "x": -0.1 * cos(TILT) + 0.4 * sin(TILT),
        "z": 0.1 * sin(TILT) + 0.4 * cos(TILT),
        "th": -TILT,
    },
    duration=2.0,
    tags=("planar", "contact", "impact", "friction", "corners"),
    facts=(
        facts.Occurs(
            "the quarter period is an elliptic integral",
            "left: impact",
            lambda s: {"t": _quarter(s)},
        ),
        facts.Occurs(
            "it falls at p sqrt(2 (cos(a/2) - cos(a))), and 1 - 3/2 sin(a)^2 of that is left",
            "left: impact",
            lambda s: {"th'": _falls(s), "after th'": (1 - 1.5 * sin(2 * TILT) ** 2) * _falls(s)},
        ),
    ),
)
