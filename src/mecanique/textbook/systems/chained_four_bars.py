"""Chain of n four-bar linkages.

n + 1 uniform bars of length l and mass m stand on pins on the ground, a distance l apart, and the
tops of neighbors are joined by n more of these bars; gravity is g. Every window is a parallelogram
and may fold into an antiparallelogram when all bars lie on the ground line: there the mechanism is
singular, and a solver must pass through it. The generalized coordinates are the angles theta0 …
thetan of the standing bars from the horizontal, positive upwards, and phi1 … phin of the joining
bars against the standing bar before them; n loops of two equations leave one of the 2 n + 1 free.
"""

import numpy as np
from numpy import cos, pi, sin

from mecanique import model as mq
from mecanique.textbook import System, facts
from mecanique.textbook.joints import hinge

m = mq.Parameter("m", 1.0, "kg", "mass of each bar")
l = mq.Parameter("l", 1.0, "m", "length of each bar")
g = mq.Parameter("g", 9.81, "m/s²", "acceleration of free fall")


def build(n: int) -> mq.Mechanism:
    """Return the chain of n windows."""
    windows = range(1, n + 1)
    return mq.Mechanism(
        name="chained_four_bars",
        bodies=(
            mq.Body("ground"),
            *(mq.Body(f"post{i}", mq.rod(m, l, (1, 0, 0))) for i in range(n + 1)),
            *(mq.Body(f"beam{i}", mq.rod(m, l, (1, 0, 0))) for i in windows),
        ),
        joints=(
            *(
                hinge(f"foot{i}", "ground", f"post{i}", f"theta{i}", at=(i * l, 0, 0))
                for i in range(n + 1)
            ),
            *(
                hinge(f"corner{i}", f"post{i - 1}", f"beam{i}", f"phi{i}", at=(l, 0, 0))
                for i in windows
            ),
        ),
        loops=tuple(
            mq.Loop.pin(f"closing{i}", f"beam{i}", (l, 0, 0), f"post{i}", (l, 0, 0))
            for i in windows
        ),
        parameters=(m, l, g),
        gravity=(0, 0, -g),
    )


def angles(s: facts.Values) -> tuple[facts.Number, facts.Number, facts.Number, facts.Number]:
    """Return the angles of posts and beams from the horizontal, and their rates."""
    posts = np.array([s[f"theta{i}"] for i in range(s.n + 1)])
    turning = np.array([s[f"theta{i}'"] for i in range(s.n + 1)])
    beams = posts[:-1] + np.array([s[f"phi{i}"] for i in range(1, s.n + 1)])
    rolling = turning[:-1] + np.array([s[f"phi{i}'"] for i in range(1, s.n + 1)])
    return posts, turning, beams, rolling


def kinetic(s: facts.Values) -> facts.Number:
    """Return T of all bars."""
    posts, turning, beams, rolling = angles(s)
    before = turning[:-1]
    joined = before**2 + rolling**2 / 3 + before * rolling * cos(beams - posts[:-1])
    return s.m * s.l**2 * (np.sum(turning**2) / 3 + np.sum(joined)) / 2


def energy(s: facts.Values) -> facts.Number:
    """Return T + V."""
    posts, _, beams, _ = angles(s)
    return kinetic(s) + s.m * s.g * s.l * (
        np.sum(sin(posts)) / 2 + np.sum(sin(posts[:-1]) + sin(beams) / 2)
    )


def hanging(s: facts.Values) -> dict[str, facts.Number]:
    """Return the state in which all posts hang, turned aside by one radian."""
    posts = {f"theta{i}": 1 - pi / 2 for i in range(s.n + 1)}
    return posts | {f"phi{i}": pi / 2 - 1 for i in range(1, s.n + 1)}


def period(s: facts.Values) -> facts.Number:
    """Return the period of swinging by one radian, by the complete elliptic integral."""
    length = s.l * ((s.n + 1) / 3 + s.n) / ((s.n + 1) / 2 + s.n)
    return facts.swing_period(length, s.g, 1.0)


SYSTEM = System(
    title="Chain of n four-bar linkages",
    source="González, Dopico, Luaces & Cuadrado, Multibody Syst. Dyn. 16 (2006) 179; "
    "IFToMM library, problem A02",
    options={"n": 2},
    build=build,
    start={"theta0": 1.0, "theta1": 1.0, "phi1": -1.0},
    tags=("linkage", "planar", "loop", "chain", "singular", "benchmark"),
    facts=(
        facts.KineticEnergy("T of 2 n + 1 uniform bars", kinetic),
        facts.Conserved("the energy", energy),
        facts.Period(
            "hanging, it swings like a pendulum of length l ((n + 1)/3 + n) / ((n + 1)/2 + n)",
            hanging,
            period,
        ),
    ),
    forms={
        "1 - cos(theta0) + cos(theta1) - cos(theta0 + phi1) = 0": (
            "Erdman & Sandor, Mechanism Design, the vector loop of a four-bar linkage, over l"
        ),
    },
)
