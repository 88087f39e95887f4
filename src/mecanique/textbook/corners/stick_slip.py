"""Mass on a moving belt, held by a spring.

A block m lies on a belt that runs with speed v and is tied to the frame by a spring of stiffness k;
mu_0 is its coefficient of static friction, mu that of kinetic friction, under gravity g. The
generalized coordinate x is the stretch of the spring. It sticks until k x = mu_0 m g, then swings
about mu m g/k until its speed is the belt's again.
"""

from math import atan2, pi, sqrt

from mecanique import model as mq
from mecanique.textbook import System, facts

m = mq.Parameter("m", 1.0, "kg", "mass of the block")
k = mq.Parameter("k", 100.0, "N/m", "stiffness of the spring")
v = mq.Parameter("v", 0.1, "m/s", "speed of the belt")
mu = mq.Parameter("mu", 0.2, "1", "coefficient of kinetic friction")
mu_0 = mq.Parameter("mu_0", 0.4, "1", "coefficient of static friction")
g = mq.Parameter("g", 9.81, "m/s²", "acceleration of free fall")

mechanism = mq.Mechanism(
    name="stick_slip",
    bodies=(mq.Body("ground"), mq.Body("block", mq.box(m, (0.1, 0.1, 0.1)))),
    joints=(mq.Prismatic("slide", "ground", "block", axis=(1, 0, 0), coordinate="x"),),
    forces=(mq.JointSpring("spring", "slide", k),),
    parameters=(m, k, v, mu, mu_0, g),
    gravity=(0, 0, -g),
    switching=(mq.Friction("belt", "slide", mu, m * g, mu_static=mu_0, speed=v),),
)


SYSTEM = System(
    title="Mass on a moving belt, held by a spring",
    source="Den Hartog, Mechanical Vibrations, ch. 7; Popp & Stelter, Phil. Trans. A 332 (1990) 89",
    build=mechanism,
    start_velocity={"x": 0.1},
    tags=("planar", "spring", "friction", "corners"),
    facts=(
        facts.ModeAcceleration(
            "m x'' + k x = mu m g where the belt overtakes it",
            ("slips -",),
            lambda s: [s.mu * s.g - s.k * s.x / s.m],
        ),
        facts.Occurs(
            "it is torn away where k x = mu_0 m g",
            "belt: slips -",
            lambda s: {"x": s.mu_0 * s.m * s.g / s.k, "t": s.mu_0 * s.m * s.g / (s.k * s.v)},
        ),
        facts.Occurs(
            "it sticks again as far beyond mu m g/k as it was before",
            "belt: sticks",
            lambda s: {
                "x'": s.v,
                "t": s.mu_0 * s.m * s.g / (s.k * s.v)
                + 2 * (pi - atan2((s.mu_0 - s.mu) * s.g * sqrt(s.m / s.k), s.v)) * sqrt(s.m / s.k),
            },
        ),
    ),
)
