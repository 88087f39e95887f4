"""Mass, spring and damper on a moving base.

A block m slides along a horizontal line on a base that is moved as X sin(W t). A spring of
stiffness k and free length a and a damper c tie it to the base; gravity g only presses it on the
base. The generalized coordinate u is the displacement of the block relative to the base, from where
the spring is free, positive towards +x.
"""

import numpy as np

from mecanique import model as mq
from mecanique.textbook import System, facts
from mecanique.textbook.joints import slide

m = mq.Parameter("m", 1.0, "kg", "mass of the block")
c = mq.Parameter("c", 0.8, "N·s/m", "damping")
k = mq.Parameter("k", 40.0, "N/m", "stiffness of the spring")
a = mq.Parameter("a", 1.0, "m", "free length of the spring")
X = mq.Parameter("X", 0.05, "m", "amplitude of the base")
W = mq.Parameter("W", 5.0, "rad/s", "angular frequency of the base")
g = mq.Parameter("g", 9.81, "m/s²", "acceleration of free fall")

# the block on its base
wall = mq.Visual(mq.Box((0.05, 0.4, 0.3)), rgba=(0.6, 0.6, 0.6, 1.0))
mechanism = mq.Mechanism(
    name="base_excited_mass",
    bodies=(
        mq.Body("ground"),
        mq.Body("base", mq.massless(wall)),
        mq.Body("block", mq.box(m, (0.3, 0.3, 0.3))),
    ),
    joints=(
        mq.Prismatic("shaker", "ground", "base", axis=(1, 0, 0), coordinate="x_base"),
        slide("slide", "base", "block", "u", at=(a, 0, 0), axis=(1, 0, 0)),
    ),
    forces=(
        mq.Spring("spring", "base", (0, 0, 0), "block", (0, 0, 0), stiffness=k, free_length=a),
        mq.Damper("damper", "base", (0, 0, 0), "block", (0, 0, 0), damping=c),
    ),
    coordinates=mq.Coordinates(("u",), {"x_base": X * mq.sin(W * mq.time())}),
    parameters=(m, c, k, a, X, W, g),
    gravity=(0, 0, -g),
)


def amplitude(s: facts.Values) -> facts.Number:
    """Return the complex amplitude of u under the base's motion X e^(i W t)."""
    return s.m * s.X * s.W**2 / (s.k - s.m * s.W**2 + 1j * s.c * s.W)


def steady(s: facts.Values) -> dict[str, float]:
    """Return the steady oscillation."""
    turning = amplitude(s) * np.exp(1j * s.W * s.t)
    return {"u": turning.imag, "u'": (1j * s.W * turning).imag}


def roots(s: facts.Values) -> list[facts.Number]:
    """Return both roots of m λ² + c λ + k = 0."""
    root = np.sqrt(complex(s.c**2 - 4 * s.m * s.k))
    return [(-s.c + sign * root) / (2 * s.m) for sign in (1, -1)]


SYSTEM = System(
    title="Mass, spring and damper on a base that is shaken",
    source="Den Hartog, Mechanical Vibrations, sect. 2.9; Chopra, Dynamics of Structures, ch. 3",
    build=mechanism,
    duration=15.0,
    tags=("planar", "spring", "damper", "linear", "prescribed motion"),
    facts=(
        facts.Acceleration(
            "m u'' + c u' + k u = m X W² sin(W t)",
            lambda s: [s.X * s.W**2 * np.sin(s.W * s.t) - (s.c * s["u'"] + s.k * s.u) / s.m],
        ),
        facts.KineticEnergy(
            "T = m (u' + X W cos(W t))² / 2",
            lambda s: s.m * (s["u'"] + s.X * s.W * np.cos(s.W * s.t)) ** 2 / 2,
        ),
        facts.Eigenvalues("free motion decays as e^(λ t), m λ² + c λ + k = 0", roots),
        facts.Solution(
            "steady motion is the imaginary part of U e^(i W t), U = m X W² / (k - m W² + i c W)",
            lambda s: steady(facts.Values({**s.numbers, "t": 0.0})),
            steady,
            until=lambda s: 3.0,
        ),
    ),
    forms={
        "u'' + c u'/m + k u/m = X W^2 sin(W t)": "Den Hartog, sect. 2.9, the relative motion",
    },
)
