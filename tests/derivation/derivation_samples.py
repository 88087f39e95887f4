"""Mechanisms made by hand: every joint type, force and kind of coordinate map."""

from __future__ import annotations

from functools import cache

import numpy as np
from sympy import asin, cos, exp, sin, sqrt, tanh

import mecanique as mq
from mecanique.model import (
    Body,
    Coordinates,
    Damper,
    Fixed,
    Floating,
    Force,
    Input,
    JointDamper,
    JointForce,
    JointSpring,
    Mechanism,
    Parameter,
    Placement,
    Planar,
    Prismatic,
    Revolute,
    Shape,
    Spherical,
    Spring,
    Torque,
    Universal,
    coordinate,
    time,
    velocity,
)
from mecanique.model.states import States

SAMPLES = ("everything", "driven", "rheonomic", "planar", "three_dimensional", "functions", "free")


@cache
def sample(name: str) -> Mechanism:
    """Return one of the mechanisms by name."""
    builders = (everything, driven, rheonomic, planar, three_dimensional, functions, free)
    return {builder.__name__: builder for builder in builders}[name]()


def states(mechanism: Mechanism, n: int, seed: int = 0) -> States:
    """Return random states."""
    rng = np.random.default_rng(seed)
    return States.of(
        mechanism,
        rng.normal(size=(n, mechanism.nq)),
        rng.normal(size=(n, mechanism.nv)),
        rng.normal(size=n),
    )


def everything(map_: dict[str, object] | None = None, names: tuple[str, ...] = ()) -> Mechanism:
    """Return a tree with all joint types, turned placements, armature and all forces."""
    rng = np.random.default_rng(1)

    def three() -> tuple[float, float, float]:
        x, y, z = rng.normal(size=3).tolist()
        return x, y, z

    def shape() -> Shape:
        spread = rng.normal(size=(3, 3))
        second = spread @ spread.T
        inertia = np.trace(second) * np.eye(3) - second
        (ixx, ixy, ixz), (_, iyy, iyz), (_, _, izz) = inertia.tolist()
        return Shape(float(rng.uniform(0.5, 2)), three(), (ixx, iyy, izz, ixy, ixz, iyz))

    def place() -> Placement:
        return Placement(three(), three())

    A, W = Parameter("A", 0.3), Parameter("W", 2.0)
    u = Input("u", A * sin(W * time()))
    F = Input("F", lambda t: float(np.sin(3 * t)) + 1)
    return Mechanism(
        name="everything",
        bodies=(Body("ground"), *(Body(f"b{k}", shape(), shape()) for k in range(8))),
        joints=(
            Floating("free", "ground", "b0", origin=place()),
            Revolute("turn", "b0", "b1", axis=three(), origin=place(), armature=0.3),
            Planar("plane", "b0", "b3", axis=three(), origin=place()),
            Prismatic("slide", "b1", "b2", axis=three(), origin=place(), armature=0.2),
            Universal("cardan", "b3", "b4", origin=place()),
            Spherical("ball", "b4", "b5", origin=place()),
            Fixed("weld", "b5", "b6", origin=place()),
            Revolute("last", "b6", "b7", axis=(0, -1, 0), origin=place()),
        ),
        forces=(
            Spring("spring", "ground", three(), "b2", three(), stiffness=3.0, free_length=1.0),
            Spring("band", "b4", three(), "b7", three(), stiffness=2.0),
            Damper("damper", "ground", three(), "b2", three(), damping=3.0),
            Damper("inner", "b6", three(), "b3", three(), damping=2.0),
            JointSpring("winding", "turn", stiffness=2.0, reference=0.1),
            JointDamper("grease", "slide", damping=2.0),
            JointDamper("friction", "turn", damping=1.5),
            JointForce("motor", "last", F * velocity("last") + time()),
            Force("push", "b6", three(), three(), axes="b3"),
            Force("pull", "b7", three(), (F, coordinate("last") ** 2, 2.0)),
            Torque("couple", "b4", three(), axes="b1"),
            Torque("twist", "b4", (F, 0.0, 1.0)),
        ),
        parameters=(A, W),
        inputs=(u, F),
        coordinates=Coordinates(names, map_ or {}),
        gravity=(1.0, 2.0, -9.0),
    )


def driven() -> Mechanism:
    """Return the same with joints that follow two coordinates, time and an input."""
    q1, q2, t = coordinate("q1"), coordinate("q2"), time()
    A, W, u = (coordinate(name) for name in ("A", "W", "u"))
    return everything(
        {
            "turn": q1 - q2**2 + u,
            "slide": A * sin(q2) + sqrt(1 + q1**2),
            "plane_x": A * cos(W * t),
            "plane_theta": q1 * t,
            "cardan_ry": q2 / 2,
        },
        ("q1", "q2"),
    )


def rheonomic() -> Mechanism:
    """Return a pendulum on a turning arm whose pivot shakes: A cos(W t) up, Omega t about z."""
    m, length, A, W, Omega = (
        Parameter(s, value, unit)
        for s, value, unit in (
            ("m", 1.3, "kg"),
            ("l", 0.7, "m"),
            ("A", 0.2, "m"),
            ("W", 3.0, "rad/s"),
            ("Omega", 1.1, "rad/s"),
        )
    )
    g = Parameter("g", 9.81, "m/s²")
    return Mechanism(
        name="rheonomic",
        bodies=(
            Body("ground"),
            Body("shaker"),
            Body("arm"),
            Body("bob", Shape(m).at((0, 0, -length))),
        ),
        joints=(
            Prismatic("shake", "ground", "shaker", axis=(0, 0, 1), coordinate="z"),
            Revolute("spin", "shaker", "arm", axis=(0, 0, 1), coordinate="phi"),
            Revolute("pin", "arm", "bob", axis=(0, -1, 0), coordinate="q"),
        ),
        forces=(JointDamper("grease", "pin", 0.3),),
        parameters=(m, length, A, W, Omega, g),
        coordinates=Coordinates(("q",), {"z": A * cos(W * time()), "phi": Omega * time()}),
        gravity=(0, 0, -g),
    )


def planar() -> Mechanism:
    """Return a plate in the x-z plane with two springs, a drive and a force in its own axes."""
    m, J, k, a, c, g = (
        Parameter(s, value, unit)
        for s, value, unit in (
            ("m", 2.0, "kg"),
            ("J", 0.5, "kg·m²"),
            ("k", 30.0, "N/m"),
            ("a", 0.6, "m"),
            ("c", 0.4, "N·s/m"),
            ("g", 9.81, "m/s²"),
        )
    )
    F = Input("F", 1.5)
    return Mechanism(
        name="planar",
        bodies=(Body("ground"), Body("plate", Shape(m, inertia=(J, J, J, 0, 0, 0)))),
        joints=(Planar("plane", "ground", "plate", axis=(0, -1, 0), names=("x", "z", "theta")),),
        forces=(
            Spring("left", "ground", (-a, 0, -a), "plate", (-a, 0, 0), k, a),
            Spring("right", "ground", (a, 0, -a), "plate", (a, 0, 0), k, a),
            Damper("damper", "ground", (0, 0, -a), "plate", (0, 0, 0), c),
            Force("thrust", "plate", (0, 0, a), (F, 0, 0), axes="plate"),
            Torque("motor", "plate", (0, -F * velocity("theta"), 0)),
        ),
        parameters=(m, J, k, a, c, g),
        inputs=(F,),
        gravity=(0, 0, -g),
    )


def three_dimensional() -> Mechanism:
    """Return an arm with inclined axes, turned placements, armature and forces in its own axes."""
    m, length, k = Parameter("m", 1.2, "kg"), Parameter("l", 0.8, "m"), Parameter("k", 5.0, "N/m")
    body = Shape(
        m,
        (0, 0, length / 2),
        (m * length**2 / 12, m * length**2 / 9, m * length**2 / 18, 0, 0, 0.01),
    )
    return Mechanism(
        name="three_dimensional",
        bodies=(Body("ground"), Body("first", body), Body("second", body)),
        joints=(
            Revolute("tilted", "ground", "first", axis=(1, 1, 0), armature=0.1, coordinate="alpha"),
            Universal(
                "cardan",
                "first",
                "second",
                origin=Placement((0, 0, length), (np.pi / 4, 0, np.pi / 3)),
            ),
        ),
        forces=(
            Spring("spring", "ground", (1, 0, 0), "second", (0, 0, length), k, 0.5),
            Force("push", "second", (0, 0, length), (1, 2, 3), axes="first"),
            Torque("twist", "second", (0.3, 0.2, 0.1), axes="second"),
        ),
        parameters=(m, length, k),
        gravity=(0, 0, -9.81),
    )


def functions() -> Mechanism:
    """Return a bead on a curve, driven through arcs and roots, with non-polynomial loads."""
    m, R = Parameter("m", 0.5), Parameter("R", 6.0)
    s, u = coordinate("s"), Input("u", 0.3 * sin(2 * time()))
    return Mechanism(
        name="functions",
        bodies=(Body("ground"), Body("slider", Shape(m)), Body("arm", Shape(2 * m).at((R, 0, 0)))),
        joints=(
            Prismatic("slide", "ground", "slider", axis=(1, 0, 0), coordinate="x"),
            Revolute("turn", "slider", "arm", axis=(0, -1, 0), coordinate="theta"),
        ),
        forces=(
            Force("drag", "slider", (0, 0, 0), (-tanh(velocity("s")) * exp(-s / R), 0, 0)),
            JointSpring("spring", "turn", 3.0, 0.2),
            JointDamper("grease", "turn", 0.4),
        ),
        parameters=(m, R),
        inputs=(u,),
        coordinates=Coordinates(("s",), {"x": sqrt(R**2 + s**2) + u, "theta": asin(s / R)}),
    )


def free() -> Mechanism:
    """Return a free body with a swinging arm, a load in its own axes and one in the world's."""
    m, J = Parameter("m", 2.0, "kg"), Parameter("J", 0.4, "kg·m²")
    return Mechanism(
        name="free",
        bodies=(
            Body("ground"),
            Body("base", Shape(m, (0, 0, 0.1), (J, 2 * J, J, 0, 0, 0))),
            Body("arm", Shape(1.0)),
        ),
        joints=(
            Floating("flight", "ground", "base", origin=Placement((1, 2, 3), (0, 0, np.pi / 3))),
            Prismatic(
                "slide",
                "base",
                "arm",
                axis=(0, 1, 0),
                origin=Placement((0.5, 0, 0)),
                coordinate="y",
            ),
        ),
        forces=(
            Force("thrust", "base", (0, 0, -1), (0, 1, 5), axes="base"),
            Force("wind", "arm", (0, 0, 0), (1, 0, 0)),
            Torque("wheel", "arm", (0, 0, 2), axes="base"),
        ),
        parameters=(m, J),
        gravity=(0, 0, -9.81),
    )


def linkage(
    kind: str,
    rpy: tuple[float, float, float] = (0.3, 0.2, 0.1),
    offset: tuple[float, float, float] = (0.0, 0.0, 0.0),
    scale: float = 1.0,
    axis: tuple[float, float, float] = (0.0, -1.0, 0.0),
) -> mq.Mechanism:
    """Return a four-bar linkage of uniform bars in a tilted plane, closed by a loop."""
    a, b, c, d = (scale * length for length in (0.5, 1.4, 1.2, 1.3))
    along = (1.0, 0.0, 0.0)
    x, y, z = offset
    bodies = [mq.Body(name) for name in ("ground", "frame")]
    bodies += [
        mq.Body("crank", mq.rod(1.0, a, along)),
        mq.Body("rocker", mq.rod(1.5, c, along)),
    ]
    joints: list[mq.Joint] = [
        mq.Fixed(
            "tilt", "ground", "frame", origin=mq.Placement((scale * x, scale * y, scale * z), rpy)
        ),
        mq.Revolute("A", "frame", "crank", axis=axis, coordinate="phi"),
        mq.Revolute(
            "D",
            "frame",
            "rocker",
            axis=axis,
            origin=mq.Placement((d, 0.0, 0.0)),
            coordinate="psi",
        ),
    ]
    if kind == "distance":
        loop = mq.Loop.distance("C", "crank", (a, 0, 0), "rocker", (c, 0, 0), b)
    else:
        bodies.append(mq.Body("coupler", mq.rod(2.0, b, along)))
        tip = mq.Placement((a, 0.0, 0.0))
        joints.append(
            mq.Revolute("B", "crank", "coupler", axis=axis, origin=tip, coordinate="theta")
        )
        ends = ("coupler", (b, 0.0, 0.0), "rocker", (c, 0.0, 0.0))
        match kind:
            case "hinge":
                loop = mq.Loop.hinge("C", *ends, axis)
            case "pin":
                loop = mq.Loop.pin("C", *ends)
            case "ball":
                loop = mq.Loop.ball("C", *ends)
            case _:
                bodies.append(mq.Body("block", mq.rod(0.3, 0.2 * scale, along)))
                end = mq.Placement((c, 0.0, 0.0))
                joints.append(
                    mq.Revolute("E", "rocker", "block", axis=axis, origin=end, coordinate="chi")
                )
                if kind == "plate":
                    loop = mq.Loop.plate("C", *ends[:2], "block", (0.0, 0.0, 0.0))
                else:
                    frames = mq.Placement((b, 0.0, 0.0)), mq.Placement()
                    loop = mq.Loop.weld("C", "coupler", frames[0], "block", frames[1])
    return mq.Mechanism(
        "linkage",
        tuple(bodies),
        tuple(joints),
        loops=(loop,),
        gravity=(0.0, 0.0, -9.81 * scale),
    )
