"""Newton's cradle.

Three equal balls of mass m and radius r slide along a line and meet without loss. The generalized
coordinates are the way x of the first ball and the gaps s1 and s2 between each ball and the next.
The impacts follow one another, so the momentum of the first ball passes to the last.
"""

from mecanique.model import Body, Mechanism, Parameter, Placement, Prismatic, Stop, ball
from mecanique.textbook.facts import Occurs
from mecanique.textbook.system import System


def build(m: Parameter, r: Parameter) -> Mechanism:
    """Return the mechanism."""
    apart = Placement((2 * r, 0, 0))
    return Mechanism(
        name="newtons_cradle",
        bodies=(Body("ground"), *(Body(f"ball{i}", ball(m, r)) for i in (1, 2, 3))),
        joints=(
            Prismatic("way", "ground", "ball1", axis=(1, 0, 0), coordinate="x"),
            Prismatic("gap1", "ball1", "ball2", axis=(1, 0, 0), origin=apart, coordinate="s1"),
            Prismatic("gap2", "ball2", "ball3", axis=(1, 0, 0), origin=apart, coordinate="s2"),
        ),
        parameters=(m, r),
        gravity=(0, 0, 0),
        switching=tuple(
            Stop(f"touch{i}", f"gap{i}", at=0.0, side=-1, restitution=1.0, in_turn=True)
            for i in (1, 2)
        ),
    )


SYSTEM = System(
    title="Newton's cradle of three balls",
    source="Herrmann & Seitz, Am. J. Phys. 50 (1982) 977",
    parameters=(
        Parameter("m", 1.0, "kg", "mass of each ball"),
        Parameter("r", 0.05, "m", "radius of each ball"),
    ),
    build=build,
    start={"x": -0.3, "s1": 0.3},
    start_velocity={"x": 1.0, "s1": -1.0},
    duration=1.0,
    tags=("planar", "impact", "corners"),
    facts=(
        Occurs("the first ball stops at the second", "end", lambda s: {"x'": 0.0, "x": 0.0}),
        Occurs(
            "the last ball takes all of the momentum",
            "touch1: impact",
            lambda s: {"t": 0.3, "after x'": 0.0, "after s1'": 0.0, "after s2'": 1.0},
        ),
    ),
)
