"""Mechanisms that roll."""

from __future__ import annotations

import math

from mecanique.model import (
    Blade,
    Body,
    Coordinates,
    Floating,
    Mechanism,
    Parameter,
    Placement,
    Planar,
    Prismatic,
    Revolute,
    Rolling,
    Shape,
    VelocityConstraint,
    ball,
    box,
    coordinate,
    disk,
    time,
)

QUARTER = 1.5707963267948966
m, r, g = Parameter("m", 1.3, "kg"), Parameter("r", 0.5, "m"), Parameter("g", 9.81, "m/s²")
W = Parameter("W", 0.9, "rad/s")


def coin() -> Mechanism:
    """A thin disk with a sharp edge, by yaw, lean and spin."""
    return Mechanism(
        "coin",
        (
            Body("ground"),
            *(Body(name) for name in "abcde"),
            Body("disk", disk(m, r).at(rpy=(QUARTER, 0, 0))),
        ),
        (
            Prismatic("jx", "ground", "a", axis=(1, 0, 0), coordinate="x"),
            Prismatic("jy", "a", "b", axis=(0, 1, 0), coordinate="y"),
            Prismatic("jz", "b", "c", axis=(0, 0, 1), coordinate="z"),
            Revolute("yawing", "c", "d", axis=(0, 0, 1), coordinate="yaw"),
            Revolute("leaning", "d", "e", axis=(1, 0, 0), coordinate="lean"),
            Revolute("spinning", "e", "disk", axis=(0, 1, 0), coordinate="spin"),
        ),
        parameters=(m, r, g),
        gravity=(0, 0, -g),
        contacts=(Rolling("rim", "disk", r),),
    )


def wheel(
    crown: float = 0.0, plane: Placement | None = None, friction: float | None = None
) -> Mechanism:
    """A free disk on a plane."""
    return Mechanism(
        "wheel",
        (Body("ground"), Body("disk", disk(m, r).at(rpy=(QUARTER, 0, 0)))),
        (Floating("free", "ground", "disk"),),
        parameters=(m, r, g),
        gravity=(0, 0, -g),
        contacts=(
            Rolling("rim", "disk", r, crown=crown, plane=plane or Placement(), friction=friction),
        ),
    )


def turntable() -> Mechanism:
    """A homogeneous ball on a table that turns at W."""
    return Mechanism(
        "turntable",
        (Body("ground"), Body("table", disk(5.0, 2.0)), Body("ball", ball(m, r))),
        (
            Revolute("axle", "ground", "table", axis=(0, 0, 1), coordinate="turn"),
            Floating("free", "ground", "ball"),
        ),
        coordinates=Coordinates((), {"turn": W * time()}),
        parameters=(m, r, g, W),
        gravity=(0, 0, -g),
        contacts=(Rolling("contact", "ball", r, axis=None, on="table"),),
    )


def sleigh(ahead: float = 0.3, *, by_element: bool = True) -> Mechanism:
    """Chaplygin's sleigh: its center of mass lies ahead of the blade."""
    from sympy import cos, sin

    theta = coordinate("theta")
    edge = VelocityConstraint("edge", {"x": -sin(theta), "y": cos(theta)})
    return Mechanism(
        "sleigh",
        (Body("ground"), Body("sleigh", box(2.0, (1, 0.4, 0.1)).at((ahead, 0, 0)))),
        (Planar("plane", "ground", "sleigh", names=("x", "y", "theta")),),
        contacts=(Blade("edge", "sleigh"),) if by_element else (),
        velocity_constraints=() if by_element else (edge,),
    )


def bicycle() -> Mechanism:
    """Whipple's bicycle with the benchmark's numbers (Meijaard et al. 2007, table 1).

    Their x points forward, their z down: heights and products of inertia change their sign. Roll
    and steer count positive to the right, as theirs.
    """
    tilt, wheelbase, trail, rear, front = math.pi / 10, 1.02, 0.08, 0.3, 0.35
    steering = wheelbase + trail - rear * math.tan(tilt)

    fork = (0.05892, 0.06, 0.00708, -0.00756)

    def piece(mass: float, x: float, z: float, inertia: tuple[float, ...]) -> Shape:
        xx, yy, zz, xz = inertia
        return Shape(mass, (x, 0.0, z), (xx, yy, zz, 0.0, -xz, 0.0))

    return Mechanism(
        "bicycle",
        (
            Body("ground"),
            *(Body(name) for name in "abcde"),
            Body("frame", piece(85.0, 0.3, 0.9 - rear, (9.2, 11.0, 2.8, 2.4))),
            Body("rear", piece(2.0, 0.0, 0.0, (0.0603, 0.12, 0.0603, 0.0))),
            Body("fork", piece(4.0, 0.9 - steering, 0.7 - rear, fork)),
            Body("front", piece(3.0, 0.0, 0.0, (0.1405, 0.28, 0.1405, 0.0))),
        ),
        (
            Prismatic("jx", "ground", "a", axis=(1, 0, 0), coordinate="x"),
            Prismatic("jy", "a", "b", axis=(0, 1, 0), coordinate="y"),
            Prismatic("jz", "b", "c", axis=(0, 0, 1), coordinate="z"),
            Revolute("yawing", "c", "d", axis=(0, 0, 1), coordinate="yaw"),
            Revolute("rolling", "d", "e", axis=(1, 0, 0), coordinate="roll"),
            Revolute("pitching", "e", "frame", coordinate="pitch", axis=(0, 1, 0)),
            Revolute("rear_hub", "frame", "rear", coordinate="rear_spin", axis=(0, 1, 0)),
            Revolute(
                "headset",
                "frame",
                "fork",
                axis=(math.sin(tilt), 0, -math.cos(tilt)),
                origin=Placement((steering, 0, 0)),
                coordinate="steer",
            ),
            Revolute(
                "front_hub",
                "fork",
                "front",
                origin=Placement((wheelbase - steering, 0, front - rear)),
                coordinate="front_spin",
                axis=(0, 1, 0),
            ),
        ),
        gravity=(0, 0, -9.81),
        contacts=(Rolling("rear_contact", "rear", rear), Rolling("front_contact", "front", front)),
    )


def bowl(radius: float = 2.0, plane: Placement | None = None) -> Mechanism:
    """A homogeneous ball in a bowl; on a dome, if its radius is negative."""
    inside = Rolling("inside", "ball", r, axis=None, plane=plane or Placement(), bowl=radius)
    return Mechanism(
        "bowl",
        (Body("ground"), Body("ball", ball(m, r))),
        (Floating("free", "ground", "ball"),),
        parameters=(m, r, g),
        gravity=(0, 0, -g),
        contacts=(inside,),
    )


def turning_bowl() -> Mechanism:
    """A ball whose body's origin is not its center, in a bowl askew that swings about a hinge."""
    center = (0.1, -0.2, 0.15)
    place = Placement((0.3, -0.1, 0.2), (0.2, 0.3, 0.1))
    inside = Rolling(
        "inside", "ball", r, axis=None, center=center, on="shell", plane=place, bowl=2.0
    )
    return Mechanism(
        "turning_bowl",
        (Body("ground"), Body("shell", ball(5.0, 2.0)), Body("ball", ball(m, r).at(center))),
        (
            Revolute("hinge", "ground", "shell", axis=(0.6, 0, 0.8)),
            Floating("free", "ground", "ball"),
        ),
        parameters=(m, r, g),
        gravity=(0, 0, -g),
        contacts=(inside,),
    )


def stone() -> Mechanism:
    """An ellipsoid about no origin, its center of mass below and its axes askew, on a board."""
    center, place = (0.03, 0.02, -0.04), Placement((0.1, -0.2, 0.05), (0.2, -0.1, 0.3))
    shape = Shape(1.0, (0.0, 0.0, -0.01), (2e-3, 1.6e-2, 1.7e-2, -2e-3, 0.0, 0.0))
    below = Rolling(
        "below",
        "stone",
        0.2,
        axis=None,
        center=center,
        stretch=(1.0, 0.6, 0.4),
        on="board",
        plane=place,
    )
    return Mechanism(
        "stone",
        (Body("ground"), Body("board", box(3.0, (1, 1, 0.1))), Body("stone", shape)),
        (
            Revolute("hinge", "ground", "board", axis=(0.6, 0, 0.8)),
            Floating("free", "ground", "stone"),
        ),
        gravity=(0, 0, -9.81),
        contacts=(below,),
    )


ALL = {
    "coin": coin(),
    "edge": wheel(),
    "crowned_wheel_on_a_slope": wheel(0.1, Placement((0, 0, 0.1), (0.2, 0.3, 0.1))),
    "turntable": turntable(),
    "sleigh": sleigh(),
    "velocity_constraint": sleigh(by_element=False),
    "bowl": bowl(plane=Placement((0, 0, 0.1), (0.2, 0.3, 0.1))),
    "dome": bowl(-2.0),
    "turning_bowl": turning_bowl(),
    "ellipsoid": stone(),
}
"""A sample of every law of contact."""
