"""Mass on a spring with dry friction.

A block m on a level slide is tied to its origin by a spring of stiffness k; mu is its coefficient
of friction, static and kinetic, under gravity g. The generalized coordinate x is the stretch of the
spring. Each half period pi sqrt(m/k) shifts the center by 2 mu m g/k; it rests as soon as it stops
within mu m g/k of the origin.
"""

from math import pi, sqrt

from mecanique.model import Body, Friction, JointSpring, Mechanism, Parameter, Prismatic, box
from mecanique.textbook.facts import ModeAcceleration, Occurs
from mecanique.textbook.system import System


def build(
    m: Parameter,
    k: Parameter,
    mu: Parameter,
    g: Parameter,
) -> Mechanism:
    """Return the mechanism."""
    return Mechanism(
        name="dry_oscillator",
        bodies=(Body("ground"), Body("block", box(m, (0.1, 0.1, 0.1)))),
        joints=(Prismatic("slide", "ground", "block", axis=(1, 0, 0), coordinate="x"),),
        forces=(JointSpring("spring", "slide", k),),
        parameters=(m, k, mu, g),
        gravity=(0, 0, -g),
        switching=(Friction("dry", "slide", mu, m * g),),
    )


SYSTEM = System(
    title="Mass on a spring with dry friction",
    source="Den Hartog, Mechanical Vibrations, sect. 8.3; Rao, Mechanical Vibrations, sect. 2.7",
    parameters=(
        Parameter("m", 1.0, "kg", "mass of the block"),
        Parameter("k", 100.0, "N/m", "stiffness of the spring"),
        Parameter("mu", 0.1, "1", "coefficient of friction"),
        Parameter("g", 9.81, "m/s²", "acceleration of free fall"),
    ),
    build=build,
    start={"x": 0.1},
    duration=3.0,
    tags=("planar", "spring", "friction", "corners"),
    facts=(
        ModeAcceleration(
            "m x'' + k x = -mu m g where it slides forward",
            ("slips +",),
            lambda s: [-s.k * s.x / s.m - s.mu * s.g],
        ),
        Occurs(
            "it turns first after pi sqrt(m/k), nearer by 2 mu m g/k",
            "dry: slips +",
            lambda s: {"t": pi * sqrt(s.m / s.k), "x": -0.1 + 2 * s.mu * s.m * s.g / s.k},
        ),
        Occurs(
            "it rests after five half cycles, nearer by 10 mu m g/k",
            "dry: sticks",
            lambda s: {"t": 5 * pi * sqrt(s.m / s.k), "x": -0.1 + 10 * s.mu * s.m * s.g / s.k},
        ),
    ),
)
