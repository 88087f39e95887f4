"""Free particle.

A particle m is thrown and falls freely under gravity g; nothing constrains it, so it has three
degrees of freedom. The generalized coordinates are its rectangular coordinates x, y, z, with z
upwards.
"""

from mecanique import model as mq
from mecanique.textbook import System, facts

m = mq.Parameter("m", 1.0, "kg", "mass of the particle")
g = mq.Parameter("g", 9.81, "m/s²", "acceleration of free fall")

# the particle, carried along x, y and z in turn
mechanism = mq.Mechanism(
    name="free_particle",
    bodies=(
        mq.Body("ground"),
        mq.Body("along_x"),
        mq.Body("along_y"),
        mq.Body("particle", mq.particle(m)),
    ),
    joints=(
        mq.Prismatic("x", "ground", "along_x", axis=(1, 0, 0)),
        mq.Prismatic("y", "along_x", "along_y", axis=(0, 1, 0)),
        mq.Prismatic("z", "along_y", "particle", axis=(0, 0, 1)),
    ),
    parameters=(m, g),
    gravity=(0, 0, -g),
)


def flight(s: facts.Values) -> dict[str, float]:
    """Return the parabola of the throw."""
    return {
        "x": 1.0 + 3.0 * s.t,
        "y": 2.0 * s.t,
        "z": 4.0 * s.t - s.g * s.t**2 / 2,
        "z'": 4.0 - s.g * s.t,
    }


SYSTEM = System(
    title="Particle free in space, thrown under gravity",
    source="Fundamentals of Dynamics, ch. 1, sect. 1.2 and eq. 1.1",
    build=mechanism,
    start_velocity={"x": 2.0, "y": 1.0, "z": 9.81},
    duration=2.0,
    tags=("chapter", "particle", "spatial", "free", "linear"),
    facts=(
        facts.Acceleration("m (x'', y'', z'') = (0, 0, -m g)", lambda s: [0, 0, -s.g]),
        facts.MassMatrix(
            "M = m times the unit matrix", lambda s: [[s.m, 0, 0], [0, s.m, 0], [0, 0, s.m]]
        ),
        facts.Solution(
            "r = r0 + v0 t - g t² e_z / 2",
            {"x": 1.0, "x'": 3.0, "y'": 2.0, "z'": 4.0},
            flight,
            until=lambda s: 1.0,
        ),
        facts.Conserved(
            "m x', m y' and the energy m (x'² + y'² + z'²) / 2 + m g z",
            lambda s: [
                s.m * s["x'"],
                s.m * s["y'"],
                s.m * (s["x'"] ** 2 + s["y'"] ** 2 + s["z'"] ** 2) / 2 + s.m * s.g * s.z,
            ],
        ),
    ),
    forms={
        "m z'' + m g = 0": "Fundamentals of Dynamics, eq. 1.1, along z",
    },
)
