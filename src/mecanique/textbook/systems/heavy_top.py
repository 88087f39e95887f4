"""Heavy symmetric top.

A homogeneous cone of mass m, base radius r and height h spins about its axis while its apex stays
at a fixed point, under gravity g. The generalized coordinates are Euler's angles: the precession
phi about the upward vertical, the nutation theta of the axis from the upward vertical, and the spin
psi about the axis (phi and psi cannot be distinguished while the axis is vertical).
"""

from numpy import cos, sin, sqrt

from mecanique import model as mq
from mecanique.textbook import System, facts

m = mq.Parameter("m", 2.0, "kg", "mass of the cone")
r = mq.Parameter("r", 0.3, "m", "radius of the base")
h = mq.Parameter("h", 0.3, "m", "height of the cone")
g = mq.Parameter("g", 9.81, "m/s²", "acceleration of free fall")

# the top, carried by two massless frames
mechanism = mq.Mechanism(
    name="heavy_top",
    bodies=(
        mq.Body("ground"),
        mq.Body("precessing"),
        mq.Body("tilted"),
        mq.Body("top", mq.cone(m, r, h)),
    ),
    joints=(
        mq.Revolute("phi", "ground", "precessing", axis=(0, 0, 1)),
        mq.Revolute("theta", "precessing", "tilted", axis=(1, 0, 0)),
        mq.Revolute("psi", "tilted", "top", axis=(0, 0, 1)),
    ),
    parameters=(m, r, h, g),
    gravity=(0, 0, -g),
)


def inertias(s: facts.Values) -> tuple[facts.Number, facts.Number, facts.Number]:
    """Return the moments of inertia about the apex, A across and C along the axis, and m r_C."""
    A = 3 * s.m * (s.r**2 + 4 * s.h**2) / 20
    return A, 3 * s.m * s.r**2 / 10, 3 * s.m * s.h / 4


def momenta(s: facts.Values) -> tuple[facts.Number, facts.Number]:
    """Return the angular momenta about the vertical and the axis (Goldstein, eqs. 5.52, 5.53)."""
    A, C, _ = inertias(s)
    axial = C * (s["psi'"] + s["phi'"] * cos(s.theta))
    return A * s["phi'"] * sin(s.theta) ** 2 + axial * cos(s.theta), axial


def energy(s: facts.Values) -> facts.Number:
    """Return T + V."""
    A, C, S = inertias(s)
    T = (
        A * (s["theta'"] ** 2 + (s["phi'"] * sin(s.theta)) ** 2)
        + C * (s["psi'"] + s["phi'"] * cos(s.theta)) ** 2
    )
    return T / 2 + S * s.g * cos(s.theta)


def mass_matrix(s: facts.Values) -> list[list[facts.Number]]:
    """Return M for (phi, theta, psi)."""
    A, C, _ = inertias(s)
    c = cos(s.theta)
    return [[A * sin(s.theta) ** 2 + C * c**2, 0, C * c], [0, A, 0], [C * c, 0, C]]


TILT, SPIN = 0.6, 80.0
"""Nutation angle [rad] and axial rate [rad/s] of the steady precessions."""


def rate(s: facts.Values, sign: int) -> facts.Number:
    """Return the slow (−1) or fast (+1) rate of steady precession."""
    A, C, S = inertias(s)
    return (C * SPIN + sign * sqrt((C * SPIN) ** 2 - 4 * A * S * s.g * cos(TILT))) / (
        2 * A * cos(TILT)
    )


def precession(s: facts.Values, sign: int) -> dict[str, float]:
    """Return the state of steady precession."""
    return {"theta": TILT, "phi'": rate(s, sign), "psi'": SPIN - rate(s, sign) * cos(TILT)}


def nutation(s: facts.Values) -> facts.Number:
    """Return the frequency of small nutation, from the curvature of the effective potential."""
    A, C, _ = inertias(s)
    u = rate(s, -1)
    return sqrt((u * sin(TILT)) ** 2 + (C * SPIN / A - 2 * u * cos(TILT)) ** 2)


SYSTEM = System(
    title="Spinning cone on its apex under gravity",
    source="Goldstein, Classical Mechanics, 3rd ed., sect. 5.7; Landau & Lifshitz, Mechanics, "
    "sect. 35, problem 1",
    build=mechanism,
    start={"theta": 0.6},
    start_velocity={"psi": 50.0},
    duration=6.0,
    tags=("top", "spatial"),
    facts=(
        facts.MassMatrix(
            "M_phi,phi = A sin²(theta) + C cos²(theta), M_phi,psi = C cos(theta), "
            "M_theta,theta = A, M_psi,psi = C, "
            "A = 3 m (r² + 4 h²) / 20, C = 3 m r² / 10",
            mass_matrix,
        ),
        facts.Conserved(
            "p_phi = A phi' sin²(theta) + p_psi cos(theta) and p_psi = C (psi' + phi' cos(theta))",
            momenta,
        ),
        facts.Conserved("the energy, with V = 3 m g h cos(theta) / 4", energy),
        facts.Steady(
            "slow precession phi' = (p - sqrt(p² - 3 A m g h cos(theta))) / (2 A cos(theta)), "
            "p = p_psi",
            lambda s: precession(s, -1),
        ),
        facts.Steady(
            "fast precession phi' = (p + sqrt(p² - 3 A m g h cos(theta))) / (2 A cos(theta))",
            lambda s: precession(s, 1),
        ),
        facts.Eigenvalues(
            "the slow precession nutates with ω² = phi'² sin²(theta) "
            "+ (p / A - 2 phi' cos(theta))²",
            lambda s: [1j * nutation(s), -1j * nutation(s)],
            at=lambda s: precession(s, -1),
        ),
    ),
    forms={
        (
            "T = 3 m (r^2 + 4 h^2) (theta'^2 + sin(theta)^2 phi'^2)/40 + 3 m r^2 (psi' + "
            "cos(theta) phi')^2/20"
        ): "Goldstein, sect. 5.7, with the moments of a cone",
        "p_psi = 3 m r^2 (psi' + cos(theta) phi')/10": "Goldstein, eq. 5.52",
        (
            "p_phi = 3 m (r^2 + 4 h^2) sin(theta)^2 phi'/20 + 3 m r^2 (psi' + cos(theta) "
            "phi') cos(theta)/10"
        ): "Goldstein, eq. 5.53",
        (
            "V_eff = 10 (p_phi - p_psi cos(theta))^2/(3 m (r^2 + 4 h^2) sin(theta)^2) + 5 p_psi^2/"
            "(3 m r^2) + 3 m g h cos(theta)/4"
        ): "Goldstein, sect. 5.7, with the constant of the spin",
    },
)
