"""Chain of bars with rotational springs (Hencky).

n homogeneous bars of mass m and length l stand one on another, the lowest on the ground, joined by
hinges with rotational springs of stiffness k: a column or cantilever in small pieces. The tip
carries a downward force P and a couple C; the weight of the bars is ignored. The generalized
coordinates q1 … qn are the angles of the bars from the upward vertical, positive towards +x; each
spring is bent by the difference of two of them.
"""

import numpy as np

from mecanique import model as mq
from mecanique.textbook import System, facts
from mecanique.textbook.joints import hinge

m = mq.Parameter("m", 0.2, "kg", "mass of each bar")
l = mq.Parameter("l", 0.25, "m", "length of each bar")
k = mq.Parameter("k", 8.0, "N·m/rad", "stiffness of each spring")
P = mq.Parameter("P", 1.5, "N", "downward force on the tip")
C = mq.Parameter("C", 1.0, "N·m", "couple on the tip")


def build(n: int) -> mq.Mechanism:
    """Return the chain of n bars."""
    bars = range(1, n + 1)
    names = {0: "ground", **{i: f"bar{i}" for i in bars}}
    return mq.Mechanism(
        name="bar_chain",
        bodies=(mq.Body("ground"), *(mq.Body(names[i], mq.rod(m, l, (0, 0, 1))) for i in bars)),
        joints=tuple(
            hinge(
                f"hinge{i}",
                names[i - 1],
                names[i],
                "q1" if i == 1 else f"bend{i}",
                at=(0, 0, 0 if i == 1 else l),
                axis=(0, 1, 0),
            )
            for i in bars
        ),
        forces=(
            *(mq.JointSpring(f"spring{i}", f"hinge{i}", k) for i in bars),
            mq.Force("load", names[n], (0, 0, l), force=(0, 0, -P)),
            mq.Torque("couple", names[n], torque=(0, C, 0)),
        ),
        coordinates=mq.Coordinates(
            tuple(f"q{i}" for i in bars),
            {f"bend{i}": mq.coordinate(f"q{i}") - mq.coordinate(f"q{i - 1}") for i in bars[1:]},
        ),
        parameters=(m, l, k, P, C),
        gravity=(0, 0, 0),
    )


def angles(s: facts.Values) -> tuple[facts.Number, facts.Number]:
    """Return q and q', shape (n,) each."""
    bars = range(1, s.n + 1)
    return np.array([s[f"q{i}"] for i in bars]), np.array([s[f"q{i}'"] for i in bars])


def mass_matrix(s: facts.Values) -> facts.Number:
    """Return M: m l² (n - max(i, j) + 1/2) cos(qi - qj), and m l² (n - i + 1/3) on the diagonal."""
    q, _ = angles(s)
    i = np.arange(1, s.n + 1)
    carried = s.n - np.maximum.outer(i, i) + 0.5 - np.eye(s.n) / 6
    return s.m * s.l**2 * carried * np.cos(np.subtract.outer(q, q))


def energy(s: facts.Values) -> facts.Number:
    """Return T + V, the work of both loads included."""
    q, v = angles(s)
    bends = q - np.concatenate(([0.0], q[:-1]))
    return (
        v @ mass_matrix(s) @ v / 2
        + s.k * bends @ bends / 2
        + s.P * s.l * np.sum(np.cos(q))
        - s.C * q[-1]
    )


def polygon(s: facts.Values) -> dict[str, float]:
    """Return the shape under the couple alone: a regular polygon."""
    return {f"q{i}": i * s.C / s.k for i in range(1, s.n + 1)}


def buckling(s: facts.Values) -> facts.Number:
    """Return the load at which the straight column buckles."""
    return 4 * s.k / s.l * np.sin(np.pi / (4 * s.n + 2)) ** 2


SYSTEM = System(
    title="Column of n bars joined by rotational springs",
    source="Hencky, Der Eisenbau 11 (1920) 437; Timoshenko & Gere, Theory of Elastic Stability, "
    "sect. 2.1",
    options={"n": 4},
    build=build,
    duration=6.0,
    tags=("structure", "planar", "spring", "chain", "stability"),
    facts=(
        facts.MassMatrix(
            "M_ij = m l² (n - max(i, j) + 1/2) cos(qi - qj), M_ii = m l² (n - i + 1/3)", mass_matrix
        ),
        facts.Conserved("the energy T + k Σ (qi - q_(i-1))² / 2 + P l Σ cos(qi) - C qn", energy),
        facts.Steady(
            "under the couple alone it bends into a regular polygon, qi = i C / k",
            polygon,
            given={"P": 0.0},
        ),
        facts.StabilityLimit(
            "upright is stable below P = (4 k / l) sin²(pi / (4 n + 2)), "
            "in the limit Euler's pi² E I / (4 L²)",
            "P",
            buckling,
            stable="below",
            given={"C": 0.0},
        ),
        facts.Frequencies(
            "one bar alone: ω² = 3 (k - P l) / (m l²)",
            lambda s: [np.sqrt(3 * (s.k - s.P * s.l) / (s.m * s.l**2))],
            given={"C": 0.0, "n": 1},
        ),
    ),
    forms={
        (
            "V = k (q1^2 + (q2 - q1)^2 + (q3 - q2)^2 + (q4 - q3)^2)/2 + P l (cos(q1) + cos(q2) + "
            "cos(q3) + cos(q4))"
        ): "Hencky 1920, the energy of the hinges and of the load, here for four bars",
    },
)
