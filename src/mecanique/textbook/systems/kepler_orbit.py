"""Planet in a central field (Kepler).

A planet, a particle of mass m, moves about a fixed sun that attracts it with the force mu m / r²
towards the center; mu is the gravitational constant times the mass of the sun, here of a sun small
enough for a table. The generalized coordinates are the distance r from the sun, which must stay
positive, and the angle phi of the planet's radius from the x axis in the plane of the orbit, x-y.
"""

from numpy import cos, pi, sin, sqrt

from mecanique import model as mq
from mecanique.textbook import System, facts

m = mq.Parameter("m", 1.0, "kg", "mass of the planet")
mu = mq.Parameter("mu", 10.0, "m³/s²", "gravitational parameter of the sun")

# the planet on a massless radius that turns
sun = mq.massless(mq.Visual(mq.Sphere(0.1), rgba=(0.9, 0.7, 0.0, 1.0)))
mechanism = mq.Mechanism(
    name="kepler_orbit",
    bodies=(mq.Body("ground", sun), mq.Body("radius"), mq.Body("planet", mq.particle(m))),
    joints=(
        mq.Revolute("phi", "ground", "radius", axis=(0, 0, 1)),
        mq.Prismatic("r", "radius", "planet", axis=(1, 0, 0)),
    ),
    forces=(
        mq.CentralForce(
            "attraction", "ground", (0, 0, 0), "planet", (0, 0, 0), -m * mu / mq.distance()
        ),
    ),
    parameters=(m, mu),
    gravity=(0, 0, 0),
)


def constants(s: facts.Values) -> tuple[facts.Number, facts.Number]:
    """Return angular momentum and energy, per mass."""
    return s.r**2 * s["phi'"], (s["r'"] ** 2 + (s.r * s["phi'"]) ** 2) / 2 - s.mu / s.r


def axis(s: facts.Values) -> tuple[facts.Number, facts.Number]:
    """Return the eccentricity vector v × h / mu - r / |r|, which points to the perihelion."""
    h = s.r**2 * s["phi'"]
    along, across = s.r * s["phi'"] * h / s.mu - 1, -s["r'"] * h / s.mu
    return along * cos(s.phi) - across * sin(s.phi), along * sin(s.phi) + across * cos(s.phi)


def perihelion(s: facts.Values) -> dict[str, float]:
    """Return the perihelion r = 1 of the orbit with eccentricity 0.6."""
    return {"r": 1.0, "phi'": sqrt(1.6 * s.mu)}


def circle(s: facts.Values) -> dict[str, float]:
    """Return the circular orbit r = 1.5."""
    return {"r": 1.5, "phi'": sqrt(s.mu / 1.5**3)}


SYSTEM = System(
    title="Planet on its ellipse about a fixed sun",
    source="Newton, Principia, 1687, book I, sect. III; Goldstein, Classical Mechanics, 3rd ed., "
    "sect. 3.7-3.9",
    build=mechanism,
    start={"r": 1.0},
    start_velocity={"phi": 4.0},
    duration=15.7,
    tags=("planar", "central field", "particle"),
    facts=(
        facts.Acceleration(
            "r'' = r phi'² - mu / r², phi'' = -2 r' phi' / r",
            lambda s: [
                -2 * s["r'"] * s["phi'"] / s.r,
                s.r * s["phi'"] ** 2 - s.mu / s.r**2,
            ],
        ),
        facts.Conserved("r² phi' and the energy v² / 2 - mu / r, per mass", constants),
        facts.Conserved(
            "the eccentricity vector v × (r × v) / mu - r / |r|: the ellipse stays where it is",
            axis,
        ),
        facts.Period(
            "Kepler's third law, T = 2 pi sqrt(a³ / mu), a = 2.5 from the perihelion 1 with "
            "eccentricity 0.6",
            perihelion,
            lambda s: 2 * pi * sqrt(2.5**3 / s.mu),
            advance={"phi": 2 * pi},
        ),
        facts.Steady("a circle with phi'² = mu / r³", circle),
        facts.Eigenvalues(
            "near a circle r swings with ω = phi', once per revolution",
            lambda s: [sign * 1j * sqrt(s.mu / 1.5**3) for sign in (1, -1)],
            at=circle,
        ),
    ),
    forms={
        "r'' - r phi'^2 + mu/r^2 = 0": "Goldstein, eq. 3.11, over m",
        "V = -m mu/r": "Goldstein, sect. 3.7",
        "p_phi = m r^2 phi'": "Goldstein, eq. 3.8",
        "V_eff = p_phi^2/(2 m r^2) - m mu/r": "Goldstein, sect. 3.3",
        "E = m (r'^2 + r^2 phi'^2)/2 - m mu/r": "Goldstein, eq. 3.15",
        "r = r_0/(1 + e cos(phi - phi_0))": "Goldstein, eq. 3.55",
        "e = sqrt(1 + 2 p_phi^2 E/(m^3 mu^2))": "Goldstein, eq. 3.57, with k = m mu",
    },
)
