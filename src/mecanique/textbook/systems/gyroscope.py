"""Gyroscope on gimbals.

A disk of mass m and radius r spins about its axle in an inner gimbal, a ring m2 of radius r2; the
inner gimbal turns about a horizontal axle in an outer gimbal, a ring m1 of radius r1, which turns
about the vertical. All axes meet in the center. A small weight w on the rotor's axle, at the
distance d from the center, makes the gyroscope precess under gravity g. The generalized coordinates
are the turn phi of the outer gimbal about the upward vertical, the tilt theta of the rotor's axle
from the upward vertical, and the spin psi of the rotor in the inner gimbal.
"""

from numpy import cos, pi, sin, sqrt

from mecanique import model as mq
from mecanique.textbook import System, facts

m = mq.Parameter("m", 1.0, "kg", "mass of the rotor")
r = mq.Parameter("r", 0.1, "m", "radius of the rotor")
m1 = mq.Parameter("m1", 0.3, "kg", "mass of the outer gimbal")
r1 = mq.Parameter("r1", 0.16, "m", "radius of the outer gimbal")
m2 = mq.Parameter("m2", 0.2, "kg", "mass of the inner gimbal")
r2 = mq.Parameter("r2", 0.13, "m", "radius of the inner gimbal")
w = mq.Parameter("w", 0.05, "kg", "mass of the weight")
d = mq.Parameter("d", 0.13, "m", "distance of the weight from the center")
g = mq.Parameter("g", 9.81, "m/s²", "acceleration of free fall")

# both gimbals, the weight on the inner one, and the rotor
upright = (pi / 2, 0, 0)
mechanism = mq.Mechanism(
    name="gyroscope",
    bodies=(
        mq.Body("ground"),
        mq.Body("outer", mq.ring(m1, r1).at(rpy=upright)),
        mq.Body(
            "inner",
            mq.ring(m2, r2).at(rpy=upright),
            mq.bar(d, (0, 0, 1), radius=0.004),
            mq.particle(w, (0, 0, d), 0.015),
        ),
        mq.Body("rotor", mq.disk(m, r)),
    ),
    joints=(
        mq.Revolute("phi", "ground", "outer", axis=(0, 0, 1)),
        mq.Revolute("theta", "outer", "inner", axis=(1, 0, 0)),
        mq.Revolute("psi", "inner", "rotor", axis=(0, 0, 1)),
    ),
    parameters=(m, r, m1, r1, m2, r2, w, d, g),
    gravity=(0, 0, -g),
)


def inertias(s: facts.Values) -> tuple[facts.Number, facts.Number, facts.Number]:
    """Return the moments of inertia J, B and C.

    J is that about the vertical with the axle upright, B what tilting adds to it and what resists
    tilting, C that about the axle.
    """
    J = (s.m1 * s.r1**2 + s.m2 * s.r2**2) / 2
    return J, s.m2 * s.r2**2 / 2 + s.m * s.r**2 / 4 + s.w * s.d**2, s.m * s.r**2 / 2


def mass_matrix(s: facts.Values) -> list[list[facts.Number]]:
    """Return M for (phi, theta, psi)."""
    J, B, C = inertias(s)
    c = cos(s.theta)
    return [[J + B * sin(s.theta) ** 2 + C * c**2, 0, C * c], [0, B, 0], [C * c, 0, C]]


def momenta(s: facts.Values) -> tuple[facts.Number, facts.Number]:
    """Return the momenta of phi and psi."""
    J, B, C = inertias(s)
    axial = C * (s["psi'"] + s["phi'"] * cos(s.theta))
    return (J + B * sin(s.theta) ** 2) * s["phi'"] + axial * cos(s.theta), axial


TILT, SPIN = 1.2, 120.0
"""Tilt [rad] and axial rate [rad/s] of the states in the facts."""


def drift(s: facts.Values) -> dict[str, float]:
    """Return the slow steady precession, the small root in a form that loses no digits."""
    _, B, C = inertias(s)
    p, moment = C * SPIN, s.w * s.g * s.d
    phi = 2 * moment / (p + sqrt(p**2 - 4 * B * cos(TILT) * moment))
    return {"theta": TILT, "phi'": phi, "psi'": SPIN - phi * cos(TILT)}


def nutation(s: facts.Values) -> facts.Number:
    """Return the frequency of small nutation about a free steady spin."""
    J, B, C = inertias(s)
    return C * SPIN * sin(TILT) / sqrt(B * (J + B * sin(TILT) ** 2))


SYSTEM = System(
    title="Spinning disk in two gimbals, with a small weight",
    source="Arnold, Mathematical Methods of Classical Mechanics, sect. 30; Magnus, Kreisel, 1971",
    build=mechanism,
    start={"theta": 1.2},
    start_velocity={"psi": 60.0},
    duration=8.0,
    tags=("top", "spatial"),
    facts=(
        facts.MassMatrix(
            "M = [[J + B sin²(theta) + C cos²(theta), 0, C cos(theta)], [0, B, 0], [C cos(theta), "
            "0, C]], "
            "J = (m1 r1² + m2 r2²) / 2, B = m2 r2² / 2 + m r² / 4 + w d², C = m r² / 2",
            mass_matrix,
        ),
        facts.Conserved("p_phi and p_psi = C (psi' + phi' cos(theta))", momenta),
        facts.Steady("it precesses with B cos(theta) phi'² - p_psi phi' + w g d = 0", drift),
        facts.Steady(
            "without the weight the axle keeps its direction",
            {"theta": TILT, "psi'": SPIN},
            given={"w": 0.0},
        ),
        facts.Eigenvalues(
            "without the weight it nutates with ω = p_psi sin(theta) / sqrt(B (J + B sin²(theta)))",
            lambda s: [1j * nutation(s), -1j * nutation(s)],
            at={"theta": TILT, "psi'": SPIN},
            given={"w": 0.0},
        ),
    ),
    forms={
        (
            "T_rotor = m r^2 (theta'^2 + sin(theta)^2 phi'^2)/8 + m r^2 (psi' + cos(theta) "
            "phi')^2/4"
        ): "Goldstein, sect. 5.7, with the moments of a disk",
    },
)
