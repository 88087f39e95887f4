"""Billiard ball that slides until it rolls.

A ball of mass m and radius r is pushed along a cloth with coefficient of friction mu, under gravity
g. The generalized coordinates x and z are those of its center, th is its angle against the sense of
rolling. From the speed v it rolls at 5/7 of it, from 2 v/(7 mu g) on.
"""

from mecanique import model as mq
from mecanique.textbook import System, facts

m = mq.Parameter("m", 0.17, "kg", "mass of the ball")
r = mq.Parameter("r", 0.03, "m", "radius of the ball")
mu = mq.Parameter("mu", 0.2, "1", "coefficient of friction")
g = mq.Parameter("g", 9.81, "m/s²", "acceleration of free fall")

mechanism = mq.Mechanism(
    name="billiard_ball",
    bodies=(mq.Body("ground"), mq.Body("ball", mq.ball(m, r))),
    joints=(mq.Planar("plane", "ground", "ball", axis=(0, -1, 0), names=("x", "z", "th")),),
    parameters=(m, r, mu, g),
    gravity=(0, 0, -g),
    switching=(mq.Contact("cloth", "ball", radius=r, mu=mu),),
)


SYSTEM = System(
    title="Billiard ball that slides until it rolls",
    source="Coriolis, Théorie mathématique des effets du jeu de billard, 1835",
    build=mechanism,
    start={"z": 0.03},
    start_velocity={"x": 1.0},
    duration=1.0,
    tags=("planar", "friction", "corners"),
    facts=(
        facts.Occurs(
            "it rolls after 2 v/(7 mu g)",
            "cloth: sticks",
            lambda s: {"t": 2 / (7 * s.mu * s.g), "x": 12 / (49 * s.mu * s.g)},
        ),
        facts.Occurs(
            "five sevenths of its speed are left",
            "end",
            lambda s: {"x'": 5 / 7, "th'": -5 / (7 * s.r)},
        ),
    ),
)
