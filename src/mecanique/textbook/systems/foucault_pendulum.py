"""Pendulum on a rotating platform (Foucault).

A particle m hangs by a massless rod of length l from a frame that stands on a platform; the
platform turns at the constant rate W about the vertical through the point of suspension, under
gravity g. The generalized coordinates are the angles of the Cardan joint the rod hangs from, as
seen on the platform: alpha about the platform's x axis, then beta about the turned y axis; the
particle is at (−l sin(beta), l sin(alpha) cos(beta), −l cos(alpha) cos(beta)). On the platform the
plane of small swings turns backwards at W. On the earth, W is the vertical component of the earth's
rate of rotation.
"""

from numpy import cos, sin, sqrt

from mecanique import model as mq
from mecanique.textbook import System, facts

m = mq.Parameter("m", 1.0, "kg", "mass of the particle")
l = mq.Parameter("l", 2.0, "m", "length of the rod")
g = mq.Parameter("g", 9.81, "m/s²", "acceleration of free fall")
W = mq.Parameter("W", 0.2, "rad/s", "rate of the platform")

# the pendulum on its platform
floor = mq.Visual(mq.Box((l, l, l / 50)), mq.Placement((0, 0, -1.1 * l)), (0.8, 0.8, 0.8, 1.0))
mechanism = mq.Mechanism(
    name="foucault_pendulum",
    bodies=(
        mq.Body("ground"),
        mq.Body("platform", mq.massless(floor)),
        mq.Body("bob", mq.bar(l), mq.particle(m, (0, 0, -l))),
    ),
    joints=(
        mq.Revolute("turntable", "ground", "platform", axis=(0, 0, 1), coordinate="turn"),
        mq.Universal("cardan", "platform", "bob", names=("alpha", "beta")),
    ),
    coordinates=mq.Coordinates(("alpha", "beta"), {"turn": W * mq.time()}),
    parameters=(m, l, g, W),
    gravity=(0, 0, -g),
)


def place(s: facts.Values) -> tuple[facts.Number, facts.Number]:
    """Return x + i y of the particle on the platform and its rate, by real and imaginary part."""
    x, y = -s.l * sin(s.beta), s.l * sin(s.alpha) * cos(s.beta)
    x_rate = -s.l * cos(s.beta) * s["beta'"]
    y_rate = s.l * (
        cos(s.alpha) * cos(s.beta) * s["alpha'"] - sin(s.alpha) * sin(s.beta) * s["beta'"]
    )
    return (x, y), (x_rate, y_rate)


def spin(s: facts.Values) -> facts.Number:
    """Return the angular momentum about the vertical in the inertial frame."""
    (x, y), (u, v) = place(s)
    return s.m * (x * (v + s.W * x) - y * (u - s.W * y))


def jacobi(s: facts.Values) -> facts.Number:
    """Return Jacobi's integral: energy relative to the platform, with the centrifugal potential."""
    (x, y), _ = place(s)
    T = s.m * s.l**2 * (cos(s.beta) ** 2 * s["alpha'"] ** 2 + s["beta'"] ** 2) / 2
    return T - s.m * s.g * s.l * cos(s.alpha) * cos(s.beta) - s.m * s.W**2 * (x**2 + y**2) / 2


SYSTEM = System(
    title="Pendulum on a platform that turns steadily",
    source="Foucault, C. R. Acad. Sci. Paris 32 (1851) 135; Landau & Lifshitz, Mechanics, "
    "sect. 39, problem 3",
    build=mechanism,
    start={"beta": -0.3},
    duration=32.0,
    tags=("pendulum", "spatial", "prescribed motion", "rotating frame"),
    facts=(
        facts.MassMatrix(
            "M = m l² diag(cos²(beta), 1)",
            lambda s: [[s.m * (s.l * cos(s.beta)) ** 2, 0], [0, s.m * s.l**2]],
        ),
        facts.Eigenvalues(
            "small swings turn at -W on the platform: λ = ±i (sqrt(g / l) ± W)",
            lambda s: [a * 1j * (sqrt(s.g / s.l) + b * s.W) for a in (1, -1) for b in (1, -1)],
        ),
        facts.Conserved("the angular momentum about the vertical, in the inertial frame", spin),
        facts.Conserved("Jacobi's integral T_rel + V - m W² (x² + y²) / 2", jacobi),
        facts.Steady(
            "it circles at angle beta if the platform has W² = g / (l cos(beta))",
            {"beta": 1.0},
            given={"g": 9.81, "l": 2.0, "W": (9.81 / 2.0 / 0.5403023058681398) ** 0.5},
        ),
    ),
    forms={
        "l alpha'' - 2 l W beta' + (g - l W^2) alpha = 0": (
            "Landau & Lifshitz, sect. 39, problem 3, where W^2 is left out"
        ),
        "l beta'' + 2 l W alpha' + (g - l W^2) beta = 0": "the same, across",
    },
)
