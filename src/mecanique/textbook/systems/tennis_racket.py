"""Free asymmetric body (tennis racket).

A homogeneous box of mass m with the unequal edges a > b > c along its x, y, z axes turns freely
about its center, where no force has a moment. Its attitude is a unit quaternion (qx, qy, qz, qw),
its velocities are the components of the angular velocity in its own axes. Spun about the y axis,
that of the intermediate moment of inertia, it turns over again and again.
"""

import numpy as np

from mecanique import model as mq
from mecanique.textbook import System, facts
from mecanique.textbook.joints import to_world

m = mq.Parameter("m", 0.5, "kg", "mass of the box")
a = mq.Parameter("a", 0.3, "m", "edge along x")
b = mq.Parameter("b", 0.2, "m", "edge along y")
c = mq.Parameter("c", 0.04, "m", "edge along z")

mechanism = mq.Mechanism(
    name="tennis_racket",
    bodies=(mq.Body("ground"), mq.Body("box", mq.box(m, (a, b, c)))),
    joints=(mq.Spherical("center", "ground", "box", names=("qx", "qy", "qz", "qw")),),
    parameters=(m, a, b, c),
    gravity=(0, 0, 0),
)


def inertia(s: facts.Values) -> facts.Number:
    """Return the principal moments of inertia, shape (3,); they increase from x to z."""
    return s.m / 12 * np.array([s.b**2 + s.c**2, s.a**2 + s.c**2, s.a**2 + s.b**2])


def turning(s: facts.Values) -> facts.Number:
    """Return the angular velocity in the body's axes, shape (3,)."""
    return np.array([s[f"center_w{axis}"] for axis in "xyz"])


def constants(s: facts.Values) -> facts.Number:
    """Return the energy and the angular momentum in world axes."""
    w = turning(s)
    L = inertia(s) * w
    return np.array([w @ L / 2, *to_world(s, L)])


def euler(s: facts.Values) -> dict[str, float]:
    """Return ω from (1, 0, 2) at t = 0 by Jacobi's functions (Landau & Lifshitz, eq. 37.10)."""
    from scipy.special import ellipj

    I1, I2, I3 = inertia(s)
    E2, M2 = I1 + 4 * I3, I1**2 + 4 * I3**2
    rate = np.sqrt((I3 - I2) * (M2 - E2 * I1) / (I1 * I2 * I3))
    sn, cn, dn, _ = ellipj(rate * s.t, (I2 - I1) * (E2 * I3 - M2) / ((I3 - I2) * (M2 - E2 * I1)))
    return {
        "center_wx": np.sqrt((E2 * I3 - M2) / (I1 * (I3 - I1))) * cn,
        "center_wy": np.sqrt((E2 * I3 - M2) / (I2 * (I3 - I2))) * sn,
        "center_wz": np.sqrt((M2 - E2 * I1) / (I3 * (I3 - I1))) * dn,
    }


SYSTEM = System(
    title="Box that spins freely and turns over: the tennis racket",
    source="Landau & Lifshitz, Mechanics, sect. 37; Ashbaugh, Chicone & Cushman, "
    "J. Dyn. Diff. Eq. 3 (1991) 67",
    build=mechanism,
    start_velocity={"center_wx": 0.01, "center_wy": 6.0},
    duration=12.0,
    tags=("spatial", "free", "quaternion", "stability"),
    facts=(
        facts.Acceleration(
            "I w' = (I w) × w in the body's axes",
            lambda s: np.cross(inertia(s) * turning(s), turning(s)) / inertia(s),
        ),
        facts.Conserved("the energy w·I w / 2 and the angular momentum R I w", constants),
        facts.Solution(
            "w = (w1 cn, w2 sn, w3 dn)(rate t, k), Jacobi's functions",
            {"center_wx": 1.0, "center_wz": 2.0},
            euler,
            until=lambda s: 5.0,
        ),
        facts.Steady("steady, but unstable, spin about the intermediate axis", {"center_wy": 6.0}),
    ),
    forms={
        "(b^2 + c^2) center_wx' + (b^2 - c^2) center_wy center_wz = 0": (
            "Landau & Lifshitz, eq. 36.5, with the moments of a box"
        ),
    },
)
