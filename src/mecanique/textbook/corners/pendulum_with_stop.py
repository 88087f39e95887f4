"""Bar pendulum that strikes a stop.

A bar of mass m and length l swings about a pin at its end under gravity g; a stop below the pin
throws it back with e of its rate. The generalized coordinate q is the angle from the downward
vertical.
"""

from math import cos, sqrt

from mecanique import model as mq
from mecanique.textbook import System, facts
from mecanique.textbook.joints import hinge

m = mq.Parameter("m", 1.0, "kg", "mass of the bar")
l = mq.Parameter("l", 1.0, "m", "length of the bar")
e = mq.Parameter("e", 0.5, "1", "coefficient of restitution")
g = mq.Parameter("g", 9.81, "m/s²", "acceleration of free fall")

mechanism = mq.Mechanism(
    name="pendulum_with_stop",
    bodies=(mq.Body("ground"), mq.Body("bar", mq.rod(m, l))),
    joints=(hinge("pin", "ground", "bar", "q"),),
    parameters=(m, l, e, g),
    gravity=(0, 0, -g),
    switching=(mq.Stop("stop", "pin", at=0.0, side=-1, restitution=e),),
)


SYSTEM = System(
    title="Bar pendulum that strikes a stop",
    source="Shaw & Rand, Int. J. Non-Linear Mech. 24 (1989) 41; Goldsmith, Impact, ch. 2",
    build=mechanism,
    start={"q": 1.0},
    duration=6.0,
    tags=("planar", "pendulum", "impact", "corners"),
    facts=(
        facts.Occurs(
            "it strikes after a quarter period, K(sin(1/2)) sqrt(2 l/(3 g))",
            "stop: impact",
            lambda s: {"t": facts.swing_period(2 * s.l / 3, s.g, 1.0) / 4},
        ),
        facts.Occurs(
            "it strikes at sqrt(3 g (1 - cos(1))/l), and e of that is left",
            "stop: impact",
            lambda s: {
                "q'": -sqrt(3 * s.g * (1 - cos(1.0)) / s.l),
                "after q'": s.e * sqrt(3 * s.g * (1 - cos(1.0)) / s.l),
            },
        ),
    ),
)
