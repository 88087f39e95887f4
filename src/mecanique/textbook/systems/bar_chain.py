"""Chain of bars with rotational springs (Hencky).

n homogeneous bars of mass m and length l stand one on another, the lowest on the ground, joined by
hinges with rotational springs of stiffness k: a column or cantilever in small pieces. The tip
carries a downward force P and a couple C; the weight of the bars is ignored. The generalized
coordinates q1 … qn are the angles of the bars from the upward vertical, positive towards +x; each
spring is bent by the difference of two of them.
"""

import numpy as np

from mecanique.model import (
    Body,
    Coordinates,
    Force,
    JointSpring,
    Mechanism,
    Parameter,
    Placement,
    Revolute,
    Torque,
    coordinate,
    rod,
)
from mecanique.textbook.facts import (
    Conserved,
    Frequencies,
    MassMatrix,
    Number,
    StabilityLimit,
    Steady,
    Values,
)
from mecanique.textbook.system import System


def build(
    m: Parameter, l: Parameter, k: Parameter, P: Parameter, C: Parameter, n: int
) -> Mechanism:
    """Return the chain of n bars."""
    bars = range(1, n + 1)
    names = {0: "ground", **{i: f"bar{i}" for i in bars}}
    return Mechanism(
        name="bar_chain",
        bodies=(Body("ground"), *(Body(names[i], rod(m, l, (0, 0, 1))) for i in bars)),
        joints=tuple(
            Revolute(
                f"hinge{i}",
                names[i - 1],
                names[i],
                axis=(0, 1, 0),
                origin=Placement((0, 0, 0 if i == 1 else l)),
                coordinate="q1" if i == 1 else f"bend{i}",
            )
            for i in bars
        ),
        forces=(
            *(JointSpring(f"spring{i}", f"hinge{i}", k) for i in bars),
            Force("load", names[n], (0, 0, l), force=(0, 0, -P)),
            Torque("couple", names[n], torque=(0, C, 0)),
        ),
        coordinates=Coordinates(
            tuple(f"q{i}" for i in bars),
            {f"bend{i}": coordinate(f"q{i}") - coordinate(f"q{i - 1}") for i in bars[1:]},
        ),
        parameters=(m, l, k, P, C),
        gravity=(0, 0, 0),
    )


def angles(s: Values) -> tuple[Number, Number]:
    """Return q and q', shape (n,) each."""
    bars = range(1, s.n + 1)
    return np.array([s[f"q{i}"] for i in bars]), np.array([s[f"q{i}'"] for i in bars])


def mass_matrix(s: Values) -> Number:
    """Return M: m l² (n - max(i, j) + 1/2) cos(qi - qj), and m l² (n - i + 1/3) on the diagonal."""
    q, _ = angles(s)
    i = np.arange(1, s.n + 1)
    carried = s.n - np.maximum.outer(i, i) + 0.5 - np.eye(s.n) / 6
    return s.m * s.l**2 * carried * np.cos(np.subtract.outer(q, q))


def energy(s: Values) -> Number:
    """Return T + V, the work of both loads included."""
    q, v = angles(s)
    bends = q - np.concatenate(([0.0], q[:-1]))
    return (
        v @ mass_matrix(s) @ v / 2
        + s.k * bends @ bends / 2
        + s.P * s.l * np.sum(np.cos(q))
        - s.C * q[-1]
    )


def polygon(s: Values) -> dict[str, float]:
    """Return the shape under the couple alone: a regular polygon."""
    return {f"q{i}": i * s.C / s.k for i in range(1, s.n + 1)}


def buckling(s: Values) -> Number:
    """Return the load at which the straight column buckles."""
    return 4 * s.k / s.l * np.sin(np.pi / (4 * s.n + 2)) ** 2


SYSTEM = System(
    title="Column of n bars joined by rotational springs",
    source="Hencky, Der Eisenbau 11 (1920) 437; Timoshenko & Gere, Theory of Elastic Stability, "
    "sect. 2.1",
    parameters=(
        Parameter("m", 0.2, "kg", "mass of each bar"),
        Parameter("l", 0.25, "m", "length of each bar"),
        Parameter("k", 8.0, "N·m/rad", "stiffness of each spring"),
        Parameter("P", 1.5, "N", "downward force on the tip"),
        Parameter("C", 1.0, "N·m", "couple on the tip"),
    ),
    options={"n": 4},
    build=build,
    duration=6.0,
    tags=("structure", "planar", "spring", "chain", "stability"),
    facts=(
        MassMatrix(
            "M_ij = m l² (n - max(i, j) + 1/2) cos(qi - qj), M_ii = m l² (n - i + 1/3)", mass_matrix
        ),
        Conserved("the energy T + k Σ (qi - q_(i-1))² / 2 + P l Σ cos(qi) - C qn", energy),
        Steady(
            "under the couple alone it bends into a regular polygon, qi = i C / k",
            polygon,
            given={"P": 0.0},
        ),
        StabilityLimit(
            "upright is stable below P = (4 k / l) sin²(pi / (4 n + 2)), "
            "in the limit Euler's pi² E I / (4 L²)",
            "P",
            buckling,
            stable="below",
            given={"C": 0.0},
        ),
        Frequencies(
            "one bar alone: ω² = 3 (k - P l) / (m l²)",
            lambda s: [np.sqrt(3 * (s.k - s.P * s.l) / (s.m * s.l**2))],
            given={"C": 0.0, "n": 1},
        ),
    ),
)
