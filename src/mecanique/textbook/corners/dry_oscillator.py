"""Mass on a spring with dry friction.

A block m on a level slide is tied to its origin by a spring of stiffness k; mu is its coefficient
of friction, static and kinetic, under gravity g. The generalized coordinate x is the stretch of the
spring. Each half period pi sqrt(m/k) shifts the center by 2 mu m g/k; it rests as soon as it stops
within mu m g/k of the origin.
"""

from math import pi, sqrt

from mecanique import model as mq
from mecanique.textbook import System, facts

m = mq.Parameter("m", 1.0, "kg", "mass of the block")
k = mq.Parameter("k", 100.0, "N/m", "stiffness of the spring")
mu = mq.Parameter("mu", 0.1, "1", "coefficient of friction")
g = mq.Parameter("g", 9.81, "m/s²", "acceleration of free fall")

mechanism = mq.Mechanism(
    name="dry_oscillator",
    bodies=(mq.Body("ground"), mq.Body("block", mq.box(m, (0.1, 0.1, 0.1)))),
    joints=(mq.Prismatic("slide", "ground", "block", axis=(1, 0, 0), coordinate="x"),),
    forces=(mq.JointSpring("spring", "slide", k),),
    parameters=(m, k, mu, g),
    gravity=(0, 0, -g),
    switching=(mq.Friction("dry", "slide", mu, m * g),),
)


SYSTEM = System(
    title="Mass on a spring with dry friction",
    source="Den Hartog, Mechanical Vibrations, ch. 8; Rao, Mechanical Vibrations, ch. 2",
    build=mechanism,
    start={"x": 0.1},
    duration=3.0,
    tags=("planar", "spring", "friction", "corners"),
    facts=(
        facts.ModeAcceleration(
            "m x'' + k x = -mu m g where it slides forward",
            ("slips +",),
            lambda s: [-s.k * s.x / s.m - s.mu * s.g],
        ),
        facts.Occurs(
            "it turns first after pi sqrt(m/k), nearer by 2 mu m g/k",
            "dry: slips +",
            lambda s: {"t": pi * sqrt(s.m / s.k), "x": -0.1 + 2 * s.mu * s.m * s.g / s.k},
        ),
        facts.Occurs(
            "it rests after five half cycles, nearer by 10 mu m g/k",
            "dry: sticks",
            lambda s: {"t": 5 * pi * sqrt(s.m / s.k), "x": -0.1 + 10 * s.mu * s.m * s.g / s.k},
        ),
    ),
)
