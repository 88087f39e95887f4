"""Mechanisms for tests of corners: of sides, and of slip that begins in space."""

from __future__ import annotations

import math
from collections.abc import Sequence
from itertools import pairwise
from typing import Literal

import mecanique as mq
from mecanique.model.constraints.friction import Switching

__all__ = [
    "CORNER",
    "CORNERS",
    "TABLE",
    "TRIPOD",
    "make_ball",
    "make_block",
    "make_braked",
    "make_buffer",
    "make_corner",
    "make_pair",
    "make_rack",
    "make_rod",
    "make_sled",
    "make_slope",
    "make_standing_box",
    "make_tow",
    "move_in_plane",
]

TABLE = 2.0
"""Length of the table [m], which ends at x = 0."""

CORNER = {"x": -0.3, "z": 0.3 * math.tan(math.pi / 6)}
"""A place on the slope to the foot of which a particle slides."""

CORNERS = tuple((x, y) for x in (-0.2, 0.2) for y in (-0.2, 0.2))
"""Those of a box from above."""

TRIPOD = ((0.2, 0.0), (-0.15, 0.2), (-0.1, -0.2))
"""Feet below a box's center, not alike, so that it turns as it begins to slide."""

_TOP = mq.Placement((-TABLE / 2, 0, 0))


def _support(body: str, size: tuple[float, float], mu: float) -> tuple[mq.Contact, ...]:
    """Return the contacts of a block's lower corners with a table, and of its edge with the block.

    The block has a width and a height, and the origin of its frame in its center.
    """
    b, h = size
    below = mq.Placement((0, 0, -h / 2), (math.pi, 0, 0))
    corners = (
        mq.Contact(name, body, center=(x, 0, -h / 2), plane=_TOP, length=TABLE, mu=mu)
        for name, x in (("rear", -b / 2), ("front", b / 2))
    )
    return (*corners, mq.Contact("lip", "ground", on=body, plane=below, length=b, mu=mu))


def move_in_plane(shape: mq.Shape, *switching: Switching) -> mq.Mechanism:
    """Return a body that moves in the plane x, z and turns by th about −y."""
    joint = mq.Planar("plane", "ground", "body", axis=(0, -1, 0), names=("x", "z", "th"))
    bodies = (mq.Body("ground"), mq.Body("body", shape))
    return mq.Mechanism("at_the_edge", bodies, (joint,), switching=switching)


def make_block(width: float, height: float, mu: float) -> mq.Mechanism:
    """Return a block of 1 kg on a table."""
    return move_in_plane(
        mq.box(1.0, (width, width, height)), *_support("body", (width, height), mu)
    )


def make_braked() -> mq.Mechanism:
    """Return a block at a wall, with a brake of 0.8 N, 1 N at rest, and a weight on a spring."""
    block = mq.Body("block", mq.box(1.0, (0.1, 0.1, 0.1)))
    weight = mq.Body("weight", mq.particle(1.0))
    slide = mq.Prismatic("slide", "ground", "block", axis=(1, 0, 0), coordinate="x")
    line = mq.Prismatic("line", "block", "weight", axis=(1, 0, 0), coordinate="y")
    return mq.Mechanism(
        "braked",
        (mq.Body("ground"), block, weight),
        (slide, line),
        forces=(mq.JointSpring("spring", "line", 10.0),),
        switching=(
            mq.Friction("brake", "slide", 0.8, 1.0, mu_static=1.0),
            mq.Stop("wall", "slide", 0.0, restitution=0.0),
        ),
    )


def make_buffer() -> mq.Mechanism:
    """Return a block of 1 kg on a level slide with a spring of 400 N/m at 0.2 m."""
    bodies = mq.Body("ground"), mq.Body("block", mq.box(1.0, (0.1, 0.1, 0.1)))
    slide = mq.Prismatic("slide", "ground", "block", axis=(1, 0, 0), coordinate="x")
    buffer = mq.Stop("buffer", "slide", at=0.2, stiffness=400.0)
    return mq.Mechanism("buffer", bodies, (slide,), switching=(buffer,))


def make_rack(load: float, slope: float) -> mq.Mechanism:
    """Return a rack of 1 kg on a slide, which a load pulls back, and a pawl of 0.1 kg above it.

    A tooth is 0.1 m long; the pawl is pressed by its weight alone.
    """
    long, high = 0.1, 0.1 * slope
    sides = list[mq.Contact]()
    for k in range(2):
        rise = mq.Placement(((k + 0.5) * long, 0, high / 2), (0, -math.atan(slope), 0))
        face = mq.Placement(((k + 1) * long, 0, 0), (0, math.pi / 2, 0))
        size = math.hypot(long, high)
        sides.append(mq.Contact(f"rise {k}", "pawl", on="rack", plane=rise, length=size))
        # from the tip on, and as far below the foot of the next tooth
        sides.append(mq.Contact(f"face {k}", "pawl", on="rack", plane=face, length=2 * high))
    return mq.Mechanism(
        "rack",
        (
            mq.Body("ground"),
            mq.Body("rack", mq.box(1.0, (0.2, 0.02, 0.02))),
            mq.Body("pawl", mq.particle(0.1)),
        ),
        (
            mq.Prismatic("slide", "ground", "rack", axis=(1, 0, 0), coordinate="x"),
            mq.Prismatic("guide", "ground", "pawl", axis=(0, 0, 1), coordinate="z"),
        ),
        forces=(mq.JointForce("load", "slide", load),),
        switching=tuple(sides),
    )


def make_rod(law: Literal["newton", "poisson"]) -> mq.Mechanism:
    """Return a rod of 1 kg and 1 m that falls on its rough end, x + 1/2 from its center."""
    end = mq.Contact("end", "body", center=(-0.5, 0, 0), mu=0.3, restitution=0.5, law=law)
    return move_in_plane(mq.box(1.0, (1.0, 0.1, 0.1)), end)


def make_ball(radius: float, mu: float) -> mq.Mechanism:
    """Return a ball of 1 kg on a table, whose edge is a point in the plane of motion."""
    about = mq.Placement((0, 0, radius))
    return move_in_plane(
        mq.ball(1.0, radius),
        mq.Contact("top", "body", radius=radius, plane=_TOP, length=TABLE, mu=mu),
        mq.Contact("edge", "ground", on="body", plane=about, bowl=-radius, mu=mu),
    )


def make_sled(width: float) -> mq.Mechanism:
    """Return a block of 1 kg and no height that does not turn, on its front corner and the edge."""
    _, *contacts = _support("p", (width, 0.0), 0.0)
    return _move_particle("sled", *contacts)


def make_slope(mu: float) -> mq.Mechanism:
    """Return a particle of 1 kg above a slope of 30° that falls towards positive x, e = 0.6."""
    slope = mq.Placement((0, 0, 0), (0, math.pi / 6, 0))
    return _move_particle("slope", mq.Contact("slope", "p", plane=slope, mu=mu, restitution=0.6))


def make_corner(mu: float) -> mq.Mechanism:
    """Return a particle of 1 kg on a slope of 30°, at whose foot in the origin it meets a wall."""
    slope, wall = (
        mq.Placement((0, 0, 0), (0, math.pi / 6, 0)),
        mq.Placement((0, 0, 0), (0, -math.pi / 2, 0)),
    )
    return _move_particle(
        "corner",
        mq.Contact("slope", "p", plane=slope, mu=mu),
        mq.Contact("wall", "p", plane=wall, mu=mu, restitution=0.5),
    )


def _move_particle(name: str, *switching: Switching) -> mq.Mechanism:
    bodies = mq.Body("ground"), mq.Body("carriage", mq.massless()), mq.Body("p", mq.particle(1.0))
    joints = (
        mq.Prismatic("x", "ground", "carriage", axis=(1, 0, 0)),
        mq.Prismatic("z", "carriage", "p", axis=(0, 0, 1)),
    )
    return mq.Mechanism(name, bodies, joints, switching=switching)


def make_tow(coins: int = 1) -> mq.Mechanism:
    """Coins on a rough floor, towed by a ball on springs of 50 N/m that swings over them."""
    axes = {"x": (1, 0, 0), "y": (0, 1, 0), "z": (0, 0, 1)}
    bodies = [mq.Body("ground"), mq.Body("ahead", mq.massless()), mq.Body("ball", mq.particle(1.0))]
    joints = list[mq.Joint]()

    def carry(names: str, number: str, chain: tuple[str, ...]) -> None:
        for name, (parent, child) in zip(names, pairwise(chain), strict=True):
            slide = f"{name}{number}"
            joints.append(mq.Prismatic(slide, parent, child, coordinate=slide, axis=axes[name]))

    carry("xy", "", ("ground", "ahead", "ball"))
    springs, contacts = list[mq.Potential](), list[mq.Contact]()
    for k in map(str, range(1, coins + 1)):
        chain = ("ground", f"along{k}", f"across{k}", f"coin{k}")
        bodies += [mq.Body(name, mq.massless()) for name in chain[1:3]]
        bodies.append(mq.Body(chain[3], mq.particle(1.0)))
        carry("xyz", k, chain)
        stretch = sum((mq.coordinate(a) - mq.coordinate(a + k)) ** 2 for a in "xy")
        springs.append(mq.Potential(f"spring{k}", ("x", "y", f"x{k}", f"y{k}"), 25.0 * stretch))
        contacts.append(mq.Contact(f"floor{k}", chain[3], mu=0.4))
    return mq.Mechanism(
        "tow", tuple(bodies), tuple(joints), forces=tuple(springs), switching=tuple(contacts)
    )


def make_pair() -> mq.Mechanism:
    """Two alike blocks with brakes of 3 N, towed by a ball on springs of 50 N/m."""
    names = ("x", "x1", "x2")
    slides = [
        mq.Prismatic(name, "ground", f"body_{name}", coordinate=name, axis=(1, 0, 0))
        for name in names
    ]
    springs = [
        mq.Potential(f"to_{k}", ("x", k), 25.0 * (mq.coordinate("x") - mq.coordinate(k)) ** 2)
        for k in names[1:]
    ]
    return mq.Mechanism(
        "pair",
        (mq.Body("ground"), *(mq.Body(f"body_{name}", mq.particle(1.0)) for name in names)),
        tuple(slides),
        forces=tuple(springs),
        switching=tuple(mq.Friction(f"brake_{k}", k, 1.0, 3.0) for k in names[1:]),
    )


def make_standing_box(
    mu: float,
    pull: float = 0.0,
    feet: Sequence[tuple[float, float]] = CORNERS,
    aside: float = 0.0,
) -> mq.Mechanism:
    """Return a box of 1 kg on its lower corners, pulled along x [N], next to its center [m]."""
    contacts = (mq.Contact(f"c{k}", "box", (*foot, -0.1), mu=mu) for k, foot in enumerate(feet))
    return mq.Mechanism(
        "box",
        (mq.Body("ground"), mq.Body("box", mq.box(1.0, (0.4, 0.4, 0.2)))),
        (mq.Floating("free", "ground", "box"),),
        forces=(mq.Force("pull", "box", (0, aside, 0), (pull, 0, 0)),) if pull else (),
        gravity=(0, 0, -9.81),
        switching=tuple(contacts),
    )
