"""Newton's cradle.

Three equal balls of mass m and radius r slide along a line and meet without loss. The generalized
coordinates are the way x of the first ball and the gaps s1 and s2 between each ball and the next.
The impacts follow one another, so the momentum of the first ball passes to the last.
"""

from mecanique import model as mq
from mecanique.textbook import System, facts

m = mq.Parameter("m", 1.0, "kg", "mass of each ball")
r = mq.Parameter("r", 0.05, "m", "radius of each ball")

apart = mq.Placement((2 * r, 0, 0))
mechanism = mq.Mechanism(
    name="newtons_cradle",
    bodies=(mq.Body("ground"), *(mq.Body(f"ball{i}", mq.ball(m, r)) for i in (1, 2, 3))),
    joints=(
        mq.Prismatic("way", "ground", "ball1", axis=(1, 0, 0), coordinate="x"),
        mq.Prismatic("gap1", "ball1", "ball2", axis=(1, 0, 0), origin=apart, coordinate="s1"),
        mq.Prismatic("gap2", "ball2", "ball3", axis=(1, 0, 0), origin=apart, coordinate="s2"),
    ),
    parameters=(m, r),
    gravity=(0, 0, 0),
    switching=tuple(
        mq.Stop(f"touch{i}", f"gap{i}", at=0.0, side=-1, restitution=1.0, in_turn=True)
        for i in (1, 2)
    ),
)


SYSTEM = System(
    title="Newton's cradle of three balls",
    source="Herrmann & Seitz, Am. J. Phys. 50 (1982) 977",
    build=mechanism,
    start={"x": -0.3, "s1": 0.3},
    start_velocity={"x": 1.0, "s1": -1.0},
    duration=1.0,
    tags=("planar", "impact", "corners"),
    facts=(
        facts.Occurs("the first ball stops at the second", "end", lambda s: {"x'": 0.0, "x": 0.0}),
        facts.Occurs(
            "the last ball takes all of the momentum",
            "touch1, touch2: impact",
            lambda s: {"t": 0.3, "after x'": 0.0, "after s1'": 0.0, "after s2'": 1.0},
        ),
    ),
)
