"""Block on an incline with dry friction.

A block m lies on a plane inclined by alpha, with static friction mu_0 and kinetic friction mu,
under gravity g. The generalized coordinate x is its way down the incline. It rests while tan(alpha)
is at most mu_0; otherwise x'' = g (sin(alpha) - mu cos(alpha)).
"""

from math import cos, sin

from mecanique import model as mq
from mecanique.textbook import System, facts

m = mq.Parameter("m", 1.0, "kg", "mass of the block")
alpha = mq.Parameter("alpha", 0.4, "rad", "inclination of the plane")
mu = mq.Parameter("mu", 0.2, "1", "coefficient of kinetic friction")
mu_0 = mq.Parameter("mu_0", 0.3, "1", "coefficient of static friction")
g = mq.Parameter("g", 9.81, "m/s²", "acceleration of free fall")

mechanism = mq.Mechanism(
    name="block_on_incline",
    bodies=(mq.Body("ground"), mq.Body("block", mq.box(m, (0.3, 0.2, 0.2)))),
    joints=(
        mq.Prismatic(
            "slide",
            "ground",
            "block",
            origin=mq.Placement((0, 0, 0), (0, alpha, 0)),
            axis=(1, 0, 0),
            coordinate="x",
        ),
    ),
    parameters=(m, alpha, mu, mu_0, g),
    gravity=(0, 0, -g),
    switching=(mq.Friction("dry", "slide", mu, m * g * mq.cos(alpha), mu_static=mu_0),),
)


SYSTEM = System(
    title="Block on an incline with dry friction",
    source="Meriam & Kraige, Engineering Mechanics: Statics, sect. 6/3; Beer & Johnston, ch. 8",
    build=mechanism,
    start_velocity={"x": -1.0},
    duration=2.0,
    tags=("planar", "friction", "corners"),
    facts=(
        facts.ModeAcceleration(
            "x'' = g (sin(alpha) - mu cos(alpha)) where it slides down",
            ("slips +",),
            lambda s: [s.g * (sin(s.alpha) - s.mu * cos(s.alpha))],
        ),
        facts.ModeAcceleration(
            "x'' = g (sin(alpha) + mu cos(alpha)) where it slides up",
            ("slips -",),
            lambda s: [s.g * (sin(s.alpha) + s.mu * cos(s.alpha))],
        ),
        facts.Occurs(
            "pushed up at v it turns after v/(g (sin(alpha) + mu cos(alpha)))",
            "dry: slips +",
            lambda s: {
                "t": 1 / (s.g * (sin(s.alpha) + s.mu * cos(s.alpha))),
                "x": -0.5 / (s.g * (sin(s.alpha) + s.mu * cos(s.alpha))),
            },
        ),
    ),
)
