"""Mechanisms with every joint and force, and their states, for the tests of the reference."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt
from sympy import cos, sin

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
    Limits,
    Loop,
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
    ball,
    box,
    coordinate,
    cylinder,
    particle,
    rod,
    time,
    velocity,
)

Array = npt.NDArray[np.float64]

BRICK = Shape(1.7, (0.1, -0.2, 0.3), (0.5, 0.6, 0.4, 0.05, -0.03, 0.02))
"""A body with nothing symmetric about it."""


def tree() -> Mechanism:
    """Every joint with velocities as rates, a branch, welds, an armature, every force."""
    F = Input("F", 3 * sin(2 * time()))
    k = Parameter("k", 7.0)
    q = coordinate
    return Mechanism(
        "tree",
        bodies=(
            Body("ground", box(3, (1, 1, 1)).at((0, 0, -1))),
            Body("post", rod(2, 1.0).at((0, 0, 0.5))),
            Body("arm", BRICK),
            Body("lid", ball(0.8, 0.2).at((0.1, 0.2, 0))),
            Body("knob", particle(0.3, (0.05, 0, 0.1))),
            Body("slider", BRICK),
            Body("cross", BRICK, particle(0.4, (0, 0.7, 0))),
            Body("puck", cylinder(1.2, 0.3, 0.1)),
        ),
        joints=(
            # not in the engine's order: it sorts by name
            Planar(
                "z_puck",
                "ground",
                "puck",
                axis=(0.6, 0, 0.8),
                origin=Placement((0, 2, 0), (0.3, 0, 0.1)),
            ),
            Fixed("a_post", "ground", "post", origin=Placement((0.2, 0, 0), (0, 0, 0.4))),
            Revolute(
                "elbow", "post", "arm", axis=(1, 2, -2), origin=Placement((0, 0.1, 1)), armature=0.2
            ),
            Fixed("glue", "arm", "lid", origin=Placement((0.3, 0.1, 0), (0.5, 0.1, 0.2))),
            Fixed("nail", "lid", "knob", origin=Placement((0, 0, 0.2), (0.1, 0, 0))),
            Prismatic(
                "rail",
                "lid",
                "slider",
                axis=(0, 1, 1),
                origin=Placement((0.1, 0, 0), (0.2, 0, 0)),
                armature=0.3,
            ),
            Universal("u", "arm", "cross", origin=Placement((0, -0.3, 0), (0, 0.6, 0))),
        ),
        forces=(
            Spring("tie", "knob", (0.1, 0, 0), "puck", (0, 0.2, 0), k, 0.5),
            Spring("short", "ground", (0, 0, 1), "slider", (0, 0, 0), 2.0),
            Damper("oil", "cross", (0, 0.1, 0), "post", (0, 0, 0), 0.6),
            JointSpring("coil", "elbow", 4.0, 0.3),
            JointDamper("rub", "rail", 0.7),
            JointForce("motor", "elbow", 2 - velocity("elbow") / 2 + F),
            Force("wind", "cross", (0.1, 0, 0.2), (F, q("u_rx"), k)),
            Force("jet", "slider", (0, 0, 0.1), (0.5, 0, F), axes="knob"),
            Torque("twist", "lid", (0, 0.4, F), axes="lid"),
        ),
        parameters=(k,),
        inputs=(F,),
        gravity=(0.3, -0.2, -9.81),
    )


def flyer() -> Mechanism:
    """Quaternions: a free body that carries a ball joint, in an order of names of one's own."""
    return Mechanism(
        "flyer",
        bodies=(Body("ground"), Body("hull", BRICK), Body("pod", BRICK), Body("fin", BRICK)),
        joints=(
            Floating("f", "ground", "hull", origin=Placement((1, 0, 0), (0.1, 0.2, 0.3))),
            Spherical("s", "hull", "pod", origin=Placement((0, 0.4, 0), (0, 0, 0.7))),
            Revolute("b", "pod", "fin", axis=(0, 1, 0), limits=Limits(-1, 1)),
        ),
        forces=(
            Spring("tie", "ground", (0, 0, 1), "pod", (0.2, 0, 0), 5.0, 0.3),
            Damper("drag", "hull", (0, 0, 0.2), "fin", (0.1, 0.1, 0), 0.4),
            Torque("push", "fin", (0.1, 0.2, 0.3), axes="hull"),
        ),
        coordinates=Coordinates(
            ("b", "s_qx", "s_qy", "s_qz", "s_qw", *(f"f_{n}" for n in ("x", "y", "z")))
        ),
    )


def driven() -> Mechanism:
    """A rheonomic map that is not linear, also on a planar and a universal joint, with an input."""
    a, b, t = coordinate("a"), coordinate("b"), time()
    W = Parameter("W", 1.3, "rad/s")
    S = Input("S", sin(W * t) / 5)
    return Mechanism(
        "driven",
        bodies=(Body("ground"), *(Body(f"b{k}", BRICK) for k in range(4))),
        joints=(
            Prismatic("shake", "ground", "b0", axis=(1, 0, 1)),
            Revolute("h", "b0", "b1", axis=(0, 1, 0), origin=Placement((0, 0.2, 0)), armature=0.1),
            Planar("p", "b1", "b2", origin=Placement((0.1, 0, 0.2), (0.4, 0, 0))),
            Universal("u", "b2", "b3", origin=Placement((0, 0, 0.3))),
        ),
        forces=(
            Spring("tie", "ground", (0, 0, 0), "b3", (0.1, 0, 0), 3.0, 0.2),
            JointSpring("coil", "h", 2.0, 0.1),
            JointDamper("rub", "shake", 0.4),
        ),
        parameters=(W,),
        inputs=(S,),
        coordinates=Coordinates(
            ("a", "b", "p_y"),
            {
                "shake": S + t**2 / 10,
                "h": a * b + sin(a) + W * t,
                "p_x": a**2 / 2,
                "p_theta": b - coordinate("p_y") * t,
                "u_rx": a - 2 * b,
                "u_ry": cos(b) * S,
            },
        ),
    )


def states(mechanism: Mechanism, count: int, seed: int = 3) -> list[tuple[Array, Array, float]]:
    """Random positions, velocities and times."""
    random = np.random.default_rng(seed)
    return [
        (
            mechanism.position(random.normal(size=mechanism.nq)),
            random.normal(size=mechanism.nv),
            float(random.uniform(0, 2)),
        )
        for _ in range(count)
    ]


def parallelograms(count: int, *, serial: bool) -> Mechanism:
    """A row of parallelograms of rods of 1 m and 1 kg, closed at the ground or at the uprights.

    In series each hangs on the one before, so that the tree is as long as the row.
    """
    upright, across = rod(1.0, 1.0, direction=(0, 1, 0)), rod(1.0, 1.0, direction=(1, 0, 0))
    bodies = [Body("ground"), Body("up0", upright)]
    joints = [Revolute("A0", "ground", "up0")]
    loops = []
    for k in range(1, count + 1):
        bodies.append(Body(f"across{k}", across))
        if serial:
            bodies.append(Body(f"up{k}", rod(1.0, 1.0, direction=(0, -1, 0))))
            top = (0, 1, 0) if k == 1 else (0, 0, 0)
            joints.append(Revolute(f"B{k}", f"up{k - 1}", f"across{k}", origin=Placement(top)))
            joints.append(Revolute(f"C{k}", f"across{k}", f"up{k}", origin=Placement((1, 0, 0))))
            ends = ("ground", (k, 0, 0), f"up{k}", (0, -1, 0))
        else:
            bodies.append(Body(f"up{k}", upright))
            joints.append(Revolute(f"A{k}", "ground", f"up{k}", origin=Placement((k, 0, 0))))
            before = f"up{k - 1}"
            joints.append(Revolute(f"B{k}", before, f"across{k}", origin=Placement((0, 1, 0))))
            ends = (f"across{k}", (1, 0, 0), f"up{k}", (0, 1, 0))
        loops.append(Loop.pin(f"loop{k}", *ends, normal=(0, 0, 1)))
    return Mechanism(
        "parallelograms",
        tuple(bodies),
        tuple(joints),
        loops=tuple(loops),
        gravity=(0, -9.81, 0),
    )


def four_bars(*parts: tuple[float, float]) -> Mechanism:
    """Independent four-bar linkages, each with the length and the mass of its crank."""
    bodies, joints, loops = [Body("ground")], list[Revolute](), list[Loop]()
    for k, (length, mass) in enumerate(parts):
        for name, share, long in (("a", 1.0, 1.0), ("b", 1.5, 2.0), ("c", 1.2, 1.7)):
            link = rod(share * mass, long * length, direction=(1, 0, 0))
            bodies.append(Body(f"{name}{k}", link))
        axis = (0, -1, 0)
        tip, pivot = Placement((length, 0, 0)), Placement((2.2 * length, 0, 0))
        joints += [
            Revolute(f"A{k}", "ground", f"a{k}", axis=axis),
            Revolute(f"B{k}", f"a{k}", f"b{k}", axis=axis, origin=tip),
            Revolute(f"C{k}", "ground", f"c{k}", axis=axis, origin=pivot),
        ]
        ends = (f"b{k}", (2 * length, 0, 0), f"c{k}", (1.7 * length, 0, 0))
        loops.append(Loop.pin(f"loop{k}", *ends))
    return Mechanism("four_bars", tuple(bodies), tuple(joints), loops=tuple(loops))
