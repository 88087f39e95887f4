"""Bricard's linkage of six hinges.

Six uniform rods of length l and mass m, one of them the ground, make a closed chain of hinges whose
axes are perpendicular to the rods and, from one hinge to the next, to each other: six edges of a
cube. Counting restraints, nothing should move, yet the linkage has one degree of freedom; gravity
is g. The generalized coordinates q1, q2, q3, q4 and q5 are the angles of five hinges, zero on the
cube; the sixth hinge is the loop, one of whose five equations is redundant.
"""

from numpy import array, cross, eye, real, sin

from mecanique import model as mq
from mecanique.textbook import System, facts
from mecanique.textbook.joints import about, hinge

EDGES = ((1, 0, 0), (0, 1, 0), (0, 0, 1), (-1, 0, 0), (0, -1, 0), (0, 0, -1))
"""Directions of the rods on the cube, the ground's first."""

AXES = ((0, 0, 1), (1, 0, 0), (0, 1, 0), (0, 0, 1), (1, 0, 0), (0, 1, 0))
"""Axes of the hinges at the ends of the rods; the last one closes the chain."""


m = mq.Parameter("m", 1.0, "kg", "mass of each rod")
l = mq.Parameter("l", 1.0, "m", "length of each rod")
g = mq.Parameter("g", 9.81, "m/s²", "acceleration of free fall")

places = [(l * x, l * y, l * z) for x, y, z in EDGES]
names = ["ground", *(f"rod{k}" for k in range(1, 6))]
mechanism = mq.Mechanism(
    name="bricard_linkage",
    bodies=(mq.Body("ground"), *(mq.Body(names[k], mq.rod(m, l, EDGES[k])) for k in range(1, 6))),
    joints=tuple(
        hinge(f"hinge{k}", names[k - 1], names[k], f"q{k}", at=places[k - 1], axis=AXES[k - 1])
        for k in range(1, 6)
    ),
    loops=(mq.Loop.hinge("hinge6", "ground", (0, 0, 0), "rod5", places[5], AXES[5]),),
    parameters=(m, l, g),
    gravity=(0, 0, -g),
)


def kinetic(s: facts.Values) -> facts.Number:
    """Return T, complex where s is, of rods with the directions e: m v²/2 + m l² |ω × e|²/24."""
    turn, spin, speed, total = eye(3), array([0, 0, 0]), 0.0, 0.0
    for k in range(1, 6):
        axis = turn @ array(AXES[k - 1])
        spin = spin + axis * s[f"q{k}'"]
        turn = turn @ about(AXES[k - 1].index(1), s[f"q{k}"])
        along = turn @ array(EDGES[k])
        across = cross(spin, along) * s.l
        middle = speed + across / 2
        total = total + s.m * (sum(middle**2) / 2 + sum(across**2) / 24)
        speed = speed + across
    return total


def height(s: facts.Values) -> facts.Number:
    """Return the sum of the heights of the rods' centers."""
    turn, place, total = eye(3), 0.0, 0.0
    for k in range(1, 6):
        turn = turn @ about(AXES[k - 1].index(1), s[f"q{k}"])
        rise = s.l * (turn @ array(EDGES[k]))[2]
        total = total + place + rise / 2
        place = place + rise
    return total


def energy(s: facts.Values) -> facts.Number:
    """Return T + V."""
    return kinetic(s) + s.m * s.g * height(s)


SYSTEM = System(
    title="Six hinges on the edges of a cube, one freedom by geometry",
    source="R. Bricard, J. Math. Pures Appl. 3 (1897) 113; Chen, You & Tarnai, "
    "Int. J. Solids Struct. 42 (2005) 2287",
    build=mechanism,
    tags=("linkage", "spatial", "loop", "overconstrained", "benchmark"),
    facts=(
        # the sources have its geometry alone, and its equations are too long to be read
        facts.KineticEnergy("T = Σ m v²/2 + m l² |ω × e|²/24", lambda s: real(kinetic(s))),
        facts.Conserved("the energy", energy),
        facts.Conserved(
            "the loop: sin q1 sin q2 = sin q1 + sin q2",
            lambda s: sin(s.q1) * sin(s.q2) - sin(s.q1) - sin(s.q2),
        ),
        facts.Conserved(
            "the loop is symmetric: q1 + q3, q1 - q5, q2 - q4",
            lambda s: array([s.q1 + s.q3, s.q1 - s.q5, s.q2 - s.q4]),
        ),
    ),
    forms={
        "((sin(q2) - 1) sin(q1) - sin(q2)) cos(q1) cos(q2) = 0": (
            "Chen, You & Tarnai 2005, for a twist of π/2: cos θ1 + cos θ2 + cos θ1 cos θ2 = 0, "
            "with θ = q + π/2; here times cos q1 cos q2, a row of the loop with its symmetry"
        )
    },
)
