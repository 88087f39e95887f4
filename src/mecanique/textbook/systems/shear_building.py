"""Shear building of n storeys.

n equal rigid floor plates of mass m, each h above the one below, may only shift horizontally along
x. The columns of each storey resist the shift of one floor against the next with stiffness k and
damping c. The ground shakes with the acceleration ag(t) = A sin(W t), which acts on every floor as
the force −m ag; gravity g acts along the columns. The generalized coordinates u1 … un are the
displacements of the floors relative to the ground, positive towards +x.
"""

import numpy as np

from mecanique import model as mq
from mecanique.textbook import System, facts
from mecanique.textbook.joints import slide

m = mq.Parameter("m", 2.0e4, "kg", "mass of each floor")
k = mq.Parameter("k", 2.0e7, "N/m", "stiffness of each storey")
c = mq.Parameter("c", 4.0e4, "N·s/m", "damping of each storey")
h = mq.Parameter("h", 3.0, "m", "height of each storey")
A = mq.Parameter("A", 1.0, "m/s²", "amplitude of the ground's acceleration")
W = mq.Parameter("W", 9.0, "rad/s", "angular frequency of the ground's acceleration")
g = mq.Parameter("g", 9.81, "m/s²", "acceleration of free fall")


def build(n: int) -> mq.Mechanism:
    """Return the building; each floor slides on the one below by its drift."""
    ag = mq.Input("ag", A * mq.sin(W * mq.time()), "m/s²", "acceleration of the ground")
    floors = range(1, n + 1)
    names = {0: "ground", **{i: f"floor{i}" for i in floors}}
    u = {0: 0, **{i: mq.coordinate(f"u{i}") for i in floors}}
    return mq.Mechanism(
        name="shear_building",
        bodies=(
            mq.Body("ground"),
            *(mq.Body(names[i], mq.plate(m, (2 * h, 2 * h), thickness=h / 20)) for i in floors),
        ),
        joints=tuple(
            slide(
                f"storey{i}",
                names[i - 1],
                names[i],
                "u1" if i == 1 else f"drift{i}",
                at=(0, 0, h),
                axis=(1, 0, 0),
            )
            for i in floors
        ),
        forces=(
            *(mq.JointSpring(f"columns{i}", f"storey{i}", k) for i in floors),
            *(mq.JointDamper(f"damping{i}", f"storey{i}", c) for i in floors),
            *(mq.Force(f"quake{i}", names[i], (0, 0, 0), force=(-m * ag, 0, 0)) for i in floors),
        ),
        coordinates=mq.Coordinates(
            tuple(f"u{i}" for i in floors), {f"drift{i}": u[i] - u[i - 1] for i in floors[1:]}
        ),
        parameters=(m, k, c, h, A, W, g),
        inputs=(ag,),
        gravity=(0, 0, -g),
    )


def motion(s: facts.Values) -> tuple[facts.Number, facts.Number]:
    """Return u and u', shape (n,) each."""
    floors = range(1, s.n + 1)
    return np.array([s[f"u{i}"] for i in floors]), np.array([s[f"u{i}'"] for i in floors])


def stencil(n: int) -> facts.Number:
    """Return the tridiagonal matrix 2, −1 with 1 at the top floor, shape (n, n)."""
    matrix = 2 * np.eye(n) - np.eye(n, k=1) - np.eye(n, k=-1)
    matrix[-1, -1] = 1.0
    return matrix


def acceleration(s: facts.Values) -> facts.Number:
    """Return u''."""
    u, v = motion(s)
    return -stencil(s.n) @ (s.k * u + s.c * v) / s.m - s.A * np.sin(s.W * s.t)


def frequencies(s: facts.Values) -> facts.Number:
    """Return the natural frequencies."""
    j = np.arange(1, s.n + 1)
    return 2 * np.sqrt(s.k / s.m) * np.sin((2 * j - 1) * np.pi / (4 * s.n + 2))


def roots(s: facts.Values) -> list[complex]:
    """Return λ of every mode: λ² + (c/k) ω² λ + ω² = 0."""
    half = s.c / s.k * frequencies(s) ** 2 / 2
    root = np.sqrt(half**2 - frequencies(s) ** 2 + 0j)
    return [*(-half + root), *(-half - root)]


SYSTEM = System(
    title="Building of n rigid floors on elastic columns, shaken",
    source="Chopra, Dynamics of Structures, sect. 9.1 and 13.2; Clough & Penzien, "
    "Dynamics of Structures, part II",
    options={"n": 5},
    build=build,
    tags=("structure", "planar", "spring", "damper", "linear", "chain", "modes"),
    facts=(
        facts.MassMatrix("M = m times the unit matrix", lambda s: s.m * np.eye(s.n)),
        facts.Acceleration(
            "m ui'' + c (2 ui' - u_(i-1)' - u_(i+1)') + k (2 ui - u_(i-1) - u_(i+1)) = -m ag",
            acceleration,
        ),
        facts.Frequencies("ω_j = 2 sqrt(k / m) sin((2 j - 1) pi / (4 n + 2))", frequencies),
        facts.Eigenvalues("free motion decays as e^(λ t), λ² + (c / k) ω_j² λ + ω_j² = 0", roots),
    ),
    forms={
        "m u5'' + c (u5' - u4') + k (u5 - u4) = -m ag": (
            "Chopra, sect. 9.1 and 13.2, the row of the roof"
        ),
    },
)
