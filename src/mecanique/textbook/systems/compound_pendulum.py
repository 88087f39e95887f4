"""Compound pendulum.

The pendulum of a clock: a homogeneous rod of mass m1 and length l, pinned at its upper end, carries
at its lower end a homogeneous disk of mass m2 and radius r, fixed by its center and upright in the
plane of the swing. It swings under gravity g. The generalized coordinate q is the angle from the
downward vertical, positive towards +x.
"""

from numpy import cos, sin, sqrt

from mecanique.model import Body, Mechanism, Parameter, Revolute, disk, rod
from mecanique.textbook.facts import Acceleration, Frequencies, Number, Period, Reaction, Values
from mecanique.textbook.system import System

QUARTER = 1.5707963267948966


def build(m1: Parameter, m2: Parameter, l: Parameter, r: Parameter, g: Parameter) -> Mechanism:
    """Return the pendulum."""
    bob = disk(m2, r).at((0, 0, -l), (QUARTER, 0, 0))
    return Mechanism(
        name="compound_pendulum",
        bodies=(Body("ground"), Body("pendulum", rod(m1, l), bob)),
        joints=(Revolute("pin", "ground", "pendulum", axis=(0, -1, 0), coordinate="q"),),
        parameters=(m1, m2, l, r, g),
        gravity=(0, 0, -g),
    )


def moments(s: Values) -> tuple[Number, Number]:
    """Return the static moment and the moment of inertia about the pin."""
    return (s.m1 / 2 + s.m2) * s.l, s.m1 * s.l**2 / 3 + s.m2 * (s.l**2 + s.r**2 / 2)


def length(s: Values) -> Number:
    """Return the length of the equivalent simple pendulum (Huygens's center of oscillation)."""
    S, J = moments(s)
    return J / S


def reaction(s: Values) -> tuple[Number, Number, Number]:
    """Return the pin's force: what accelerates the center of mass, and the weight."""
    S, _ = moments(s)
    n, t = s["q'"] ** 2, -s.g / length(s) * sin(s.q)
    return (
        S * (t * cos(s.q) - n * sin(s.q)),
        0.0,
        S * (t * sin(s.q) + n * cos(s.q)) + (s.m1 + s.m2) * s.g,
    )


def period(s: Values) -> Number:
    """Return the period of swings of amplitude 1 rad."""
    from scipy.special import ellipk

    return 4 * sqrt(length(s) / s.g) * ellipk(sin(0.5) ** 2)


SYSTEM = System(
    title="Rod with a disk, pinned: the pendulum of a clock",
    source="Huygens, Horologium oscillatorium, 1673, part IV; Goldstein, Classical Mechanics, "
    "ch. 5",
    parameters=(
        Parameter("m1", 0.5, "kg", "mass of the rod"),
        Parameter("m2", 2.0, "kg", "mass of the disk"),
        Parameter("l", 1.0, "m", "length of the rod"),
        Parameter("r", 0.15, "m", "radius of the disk"),
        Parameter("g", 9.81, "m/s²", "acceleration of free fall"),
    ),
    build=build,
    start={"q": 1.0},
    tags=("pendulum", "planar"),
    facts=(
        Acceleration(
            "q'' = -g sin(q) / L, L = (m1 l²/3 + m2 (l² + r²/2)) / ((m1/2 + m2) l)",
            lambda s: [-s.g / length(s) * sin(s.q)],
        ),
        Frequencies(
            "ω = sqrt(g / L), that of a simple pendulum of length L",
            lambda s: [sqrt(s.g / length(s))],
        ),
        Period("swings of amplitude A last 4 sqrt(L / g) K(k), k = sin(A/2)", {"q": 1.0}, period),
        Reaction("the pin bears m a_G and the weight", "pin", reaction),
    ),
)
