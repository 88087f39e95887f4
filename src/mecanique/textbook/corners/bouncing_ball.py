"""Ball that bounces to rest.

A ball of mass m and radius r falls on a level floor under gravity g, and each impact leaves e of
its speed. The generalized coordinate z is the height of its lowest point. Dropped from h, its
impacts end at sqrt(2 h/g) (1 + e)/(1 - e).
"""

from math import sqrt

from mecanique import model as mq
from mecanique.textbook import System, facts
from mecanique.textbook.joints import slide

m = mq.Parameter("m", 1.0, "kg", "mass of the ball")
r = mq.Parameter("r", 0.1, "m", "radius of the ball")
e = mq.Parameter("e", 0.8, "1", "coefficient of restitution")
g = mq.Parameter("g", 9.81, "m/s²", "acceleration of free fall")

mechanism = mq.Mechanism(
    name="bouncing_ball",
    bodies=(mq.Body("ground"), mq.Body("ball", mq.ball(m, r))),
    joints=(slide("fall", "ground", "ball", "z", at=(0, 0, r), axis=(0, 0, 1)),),
    parameters=(m, r, e, g),
    gravity=(0, 0, -g),
    switching=(mq.Contact("floor", "ball", radius=r, restitution=e),),
)


SYSTEM = System(
    title="Ball that bounces to rest",
    source="Meriam & Kraige, Dynamics, sect. 3/12; Goldsmith, Impact, ch. 1",
    build=mechanism,
    start={"z": 1.0},
    duration=5.0,
    tags=("planar", "impact", "corners"),
    facts=(
        facts.ModeAcceleration("z'' = -g in flight", ("open",), lambda s: [-s.g]),
        facts.Occurs(
            "dropped from h it strikes after sqrt(2 h/g) and leaves at e sqrt(2 g h)",
            "floor: impact",
            lambda s: {"t": sqrt(2 / s.g), "after z'": s.e * sqrt(2 * s.g)},
        ),
        facts.Occurs(
            "it rests after sqrt(2 h/g) (1 + e)/(1 - e)",
            "floor: rest",
            lambda s: {"t": sqrt(2 / s.g) * (1 + s.e) / (1 - s.e)},
        ),
    ),
)
