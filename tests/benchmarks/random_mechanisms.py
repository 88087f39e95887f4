"""Verify random mechanisms: none may disagree, hang, or give what is no number.

Run it by hand: python tests/benchmarks/random_mechanisms.py [NUMBER] [--seed S] [--only KIND]
The kinds take turns: trees of all joints with springs, dampers and drives; planar loops of every
kind in any tilt, far away, from 1 mm to 1 km, some with an idle loop; spatial loops; wheels, balls
and ellipsoids on tilted planes, in bowls and on domes; blades and velocity constraints that depend
on time; carts, trailers and wheels on axles; gears, racks, cords, belts; coordinate maps; trees
with potentials, links without mass and ties; and what switches: friction, stops, latches, capstans
and contacts, in every mode. Each is verified at a few states and moved from one of them, in a
process of its own that is ended after `LIMIT` seconds of processor time. A line tells each failure
with what reproduces it, a table the outcomes by kind.
"""

from __future__ import annotations

import argparse
import os
import resource
import signal
import time
from collections import Counter
from math import pi

import numpy as np
import sympy

import mecanique as mq
from mecanique.model import (
    Blade,
    Body,
    Coordinates,
    Cord,
    Damper,
    Fixed,
    Floating,
    Force,
    Gear,
    Helical,
    Joint,
    JointDamper,
    JointForce,
    JointSpring,
    Loop,
    Mechanism,
    Placement,
    Planar,
    Prismatic,
    Pulley,
    Rack,
    Revolute,
    Rolling,
    Shape,
    Spherical,
    Spring,
    Universal,
    VelocityConstraint,
    coordinate,
)
from mecanique.model.constraints.loops import CLOSED
from mecanique.verification.states import random_states

LIMIT = 60
"""Seconds of processor time that one mechanism may take."""

SAMPLES = 4

MOVED = 0.1
"""How long each is moved [s]."""

STRIDE = 50
"""How often it is told how many were tried."""

Random = np.random.Generator
Triple = tuple[float, float, float]


def triple(values: np.ndarray) -> Triple:
    """Return three floats."""
    x, y, z = values.tolist()
    return x, y, z


def direction(random: Random) -> Triple:
    """Return a unit vector, along an axis of the frame in half of all cases."""
    if random.random() < 0.5:
        return triple(np.eye(3)[random.integers(3)] * random.choice([-1, 1]))
    vector = random.normal(size=3)
    return triple(vector / np.linalg.norm(vector))


def placement(random: Random, size: float = 1.0) -> Placement:
    """Return a frame anywhere within a size, turned in half of all cases."""
    turn = random.uniform(-3, 3, 3) * (random.random() < 0.5)
    return Placement(triple(size * random.uniform(-1, 1, 3)), triple(turn))


def shape(random: Random, size: float = 1.0) -> Shape:
    """Return a box of any proportions, mass and place in its frame."""
    mass = 10 ** random.uniform(-2, 2)
    sides = triple(size * 10 ** random.uniform(-1, 0, 3))
    return mq.box(mass, sides).at(triple(size * random.uniform(-0.5, 0.5, 3)))


def tree(random: Random) -> Mechanism:
    """Return a tree of all joints, with forces of all kinds."""
    bodies, joints = [Body("ground")], list[Joint]()
    for k in range(random.integers(1, 6)):
        parent, child = bodies[random.integers(len(bodies))].name, f"b{k}"
        name, origin, axis = f"j{k}", placement(random), direction(random)
        match random.choice(7, p=[0.4, 0.2, 0.08, 0.08, 0.08, 0.08, 0.08]):
            case 0:
                joints.append(Revolute(name, parent, child, axis=axis, origin=origin))
            case 1:
                joints.append(Prismatic(name, parent, child, axis=axis, origin=origin))
            case 2:
                joints.append(Helical(name, parent, child, axis=axis, origin=origin, pitch=0.1))
            case 3:
                joints.append(Universal(name, parent, child, origin=origin))
            case 4:
                joints.append(Spherical(name, parent, child, origin=origin))
            case 5:
                joints.append(Planar(name, parent, child, origin=origin))
            case _:
                joints.append(Floating(name, parent, child, origin=origin))
        bodies.append(Body(child, shape(random)))
    single = [j.name for j in joints if isinstance(j, Revolute | Prismatic)]
    forces: list[object] = []
    if single:
        at = single[random.integers(len(single))]
        forces += [JointSpring("coil", at, 5.0), JointDamper("dash", at, 0.3)]
        forces += [JointForce("drive", at, sympy.sin(2 * sympy.Symbol("t")))]
    far = triple(random.uniform(2, 3, 3))
    forces += [Spring("spring", "ground", far, bodies[-1].name, (0.1, 0, 0), 20.0, 1.0)]
    forces += [Damper("damper", "ground", far, bodies[-1].name, (0.1, 0, 0), 2.0)]
    forces += [Force("load", bodies[-1].name, (0, 0.1, 0), (1.0, -2.0, 0.5))]
    return Mechanism("tree", tuple(bodies), tuple(joints), forces=tuple(forces))  # type: ignore[arg-type]  # collected


def planar_loop(random: Random) -> Mechanism:
    """Return a polygon of bars in one plane, closed by a loop of any kind, in any tilt."""
    size, away = 10 ** random.uniform(-3, 3), 10 ** random.uniform(-3, 3)
    kind = str(random.choice(list(CLOSED)))
    base = Placement(triple(away * random.uniform(-1, 1, 3)), triple(random.uniform(-3, 3, 3)))
    lengths = size * random.uniform(0.8, 1.2, random.integers(3, 6))
    far = Placement((size * float(random.uniform(0.8, 1.2)), 0.0, 0.0))
    around, bodies = (0, -1, 0), [Body("ground"), Body("base")]
    joints: list[Joint] = [Fixed("mount", "ground", "base", origin=base)]
    last, end = "base", Placement()
    bars = [*lengths.tolist()]
    for k, length in enumerate(bars[:-1]):
        bodies.append(Body(f"b{k}", mq.rod(10 ** random.uniform(-1, 1), length, (1, 0, 0))))
        joints.append(Revolute(f"j{k}", last, f"b{k}", axis=around, origin=end))
        last, end = f"b{k}", Placement((length, 0, 0))
    tip = bars[-2]
    bodies.append(Body("rocker", mq.rod(1.0, bars[-1], (1, 0, 0))))
    joints.append(Revolute("rock", "base", "rocker", axis=around, origin=far))
    seat = "rocker", Placement((bars[-1], 0, 0), (pi / 2, 0, 0))
    if kind in ("weld", "plate"):
        bodies.append(Body("half", mq.rod(1.0, tip, (-1, 0, 0))))
        joints.append(
            Revolute("close", "rocker", "half", axis=around, origin=Placement((bars[-1], 0, 0)))
        )
        seat = "half", Placement((-0.5 * tip, 0, 0), (pi / 2, 0, 0))
    apart = 0.5 * size if kind == "distance" else 0.0
    mouth = Placement((tip, 0, 0), (pi / 2, 0, 0))
    loops = [Loop("C", kind, last, mouth, *seat, apart)]  # type: ignore[arg-type]  # of CLOSED
    if random.random() < 0.3:
        loops.append(Loop.ball("idle", "base", far.xyz, "rocker", (0, 0, 0)))
    gravity = (0.0, 0.0, -9.81 * size)
    return Mechanism("polygon", tuple(bodies), tuple(joints), loops=tuple(loops), gravity=gravity)


def spatial_loop(random: Random) -> Mechanism:
    """Return a chain of six motions or more in space, closed by a ball, a rod or a hinge."""
    bodies, joints = [Body("ground")], list[Joint]()
    for k in range(random.integers(5, 7)):
        axis, origin = direction(random), placement(random, 0.6)
        joints.append(Revolute(f"j{k}", bodies[-1].name, f"b{k}", axis=axis, origin=origin))
        bodies.append(Body(f"b{k}", shape(random, 0.4)))
    ends = bodies[-1].name, triple(random.uniform(-0.3, 0.3, 3))
    start = triple(random.uniform(-0.5, 0.5, 3))
    if random.random() < 0.5:
        loop = Loop.ball("loop", "ground", start, *ends)
    else:
        loop = Loop.distance("loop", "ground", start, *ends, 0.7)
    return Mechanism("spatial", tuple(bodies), tuple(joints), loops=(loop,))


def rolling(random: Random) -> Mechanism:
    """Return a wheel, a ball or an ellipsoid, free on a plane, in a bowl or on a dome."""
    radius, center = 10 ** random.uniform(-2, 0.5), (0.0, 0.0, 0.0)
    if random.random() < 0.3:
        center = triple(0.2 * radius * random.uniform(-1, 1, 3))
    plane = placement(random)
    kinds = [
        Rolling("c", "body", radius, center, plane=plane),
        Rolling("c", "body", radius, center, crown=0.3 * radius, plane=plane),
        Rolling("c", "body", radius, center, None, plane=plane),
        Rolling("c", "body", radius, center, None, plane=plane, stretch=(1.0, 0.7, 0.5)),
        Rolling("c", "body", radius, center, None, plane=plane, bowl=4 * radius),
        Rolling("c", "body", radius, center, None, plane=plane, bowl=-3 * radius),
    ]
    contact = kinds[random.integers(len(kinds))]
    bodies = [Body("ground"), Body("body", shape(random, radius))]
    joints: list[Joint] = [Floating("free", "ground", "body")]
    forces: tuple[Force, ...] = ()
    if random.random() < 0.5:
        forces = (Force("load", "body", center, triple(random.normal(size=3))),)
    return Mechanism("rolling", tuple(bodies), tuple(joints), forces=forces, contacts=(contact,))


def sliding(random: Random) -> Mechanism:
    """Return a sleigh on a blade, or held by a velocity constraint that depends on time."""
    bodies = [Body("ground"), Body("sleigh", shape(random))]
    joints: list[Joint] = [Planar("plane", "ground", "sleigh", names=("x", "y", "theta"))]
    if random.random() < 0.5:
        bodies.append(Body("arm", shape(random)))
        joints.append(
            Revolute("arm", "sleigh", "arm", axis=(0, 0, 1), origin=placement(random, 0.5))
        )
    gravity = triple(random.normal(size=3))
    if random.random() < 0.5:
        edge = Blade("edge", "sleigh", triple(np.append(random.uniform(-1, 1, 2), 0.0)))
        return Mechanism("sleigh", tuple(bodies), tuple(joints), contacts=(edge,), gravity=gravity)
    theta, t = coordinate("theta"), sympy.Symbol("t")
    row = VelocityConstraint(
        "row",
        {"x": -sympy.sin(theta), "y": sympy.cos(theta), "theta": float(random.normal())},
        float(random.normal()) * sympy.cos(1.3 * t),
    )
    return Mechanism(
        "driven", tuple(bodies), tuple(joints), velocity_constraints=(row,), gravity=gravity
    )


def guided(random: Random) -> Mechanism:
    """Return wheels in mesh, a pinion on a rack, or weights on a cord."""
    across, flat = (0.0, -1.0, 0.0), (pi / 2, 0.0, 0.0)
    big, small = (float(value) for value in random.uniform(0.1, 0.5, 2))
    wheels = [Body(name, mq.disk(10 ** random.uniform(-1, 1), 0.2).at(rpy=flat)) for name in "ab"]
    pick = random.integers(3)
    if pick == 0:
        return Mechanism(
            "gears",
            (Body("ground"), *wheels),
            (
                Revolute("A", "ground", "a", axis=across),
                Revolute("B", "ground", "b", axis=across, origin=Placement((big + small, 0, 0))),
            ),
            forces=(JointForce("drive", "A", 2.0),),
            elements=(Gear("mesh", "A", "B", big, other_radius=small),),
        )
    if pick == 1:
        return Mechanism(
            "rack",
            (Body("ground"), wheels[0], Body("r", shape(random))),
            (
                Revolute("P", "ground", "a", axis=across),
                Prismatic("S", "ground", "r", axis=(1, 0, 0), origin=Placement((0, 0, -big))),
            ),
            forces=(JointForce("drive", "P", 2.0),),
            elements=(Rack("mesh", "P", "S", big),),
        )
    left, right = Placement((-big, 0, -1)), Placement((big, 0, -1))
    return Mechanism(
        "weights",
        (Body("ground"), wheels[0], Body("m1", shape(random, 0.2)), Body("m2", shape(random, 0.2))),
        (
            Revolute("axle", "ground", "a", axis=across),
            Prismatic("up", "ground", "m1", axis=(0, 0, 1), origin=left),
            Prismatic("down", "ground", "m2", axis=(0, 0, -1), origin=right),
        ),
        elements=(Cord("cord", ("m1", (0, 0, 0)), (Pulley("a", big, -1),), ("m2", (0, 0, 0))),),
    )


def mapped(random: Random) -> Mechanism:
    """Return a chain some of whose joints follow others, or time."""
    bodies, joints = [Body("ground")], list[Joint]()
    for k in range(random.integers(2, 5)):
        kind = Revolute if random.random() < 0.6 else Prismatic
        joints.append(
            kind(
                f"j{k}",
                bodies[-1].name,
                f"b{k}",
                axis=direction(random),
                origin=placement(random),
                coordinate=f"r{k}",
            )
        )
        bodies.append(Body(f"b{k}", shape(random)))
    first, t = coordinate("r0"), sympy.Symbol("t")
    number = float(random.uniform(0.3, 2))
    laws = [number * first, sympy.sin(first) * number, number * sympy.cos(2 * t), first**2 / 3]
    driven = {
        f"r{k}": laws[random.integers(len(laws))]
        for k in range(1, len(joints))
        if random.random() < 0.7
    }
    coordinates = Coordinates((), driven)
    return Mechanism("mapped", tuple(bodies), tuple(joints), coordinates=coordinates)


def function_of(random: Random, name: str) -> sympy.Expr:
    """Return a smooth function of a letter."""
    x, a = sympy.Symbol(name), float(random.uniform(0.3, 2))
    functions = [x**2, sympy.cos(x), sympy.exp(-(x**2)), sympy.sin(2 * x) / 3]
    return a * functions[random.integers(len(functions))]


def mixed(random: Random) -> Mechanism:
    """Return a tree with links without mass, potentials, and what ties or leads some joints."""
    bodies, joints = [Body("ground")], list[Revolute | Prismatic]()
    for k in range(random.integers(3, 8)):
        parent, child = bodies[random.integers(max(0, k - 2), k + 1)].name, f"b{k}"
        kind = Prismatic if random.random() < 0.33 else Revolute
        origin = placement(random, 0.5)
        joints.append(kind(f"j{k}", parent, child, axis=direction(random), origin=origin))
        bodies.append(Body(child, shape(random, 0.5)))
    inner = {joint.parent for joint in joints} - {"ground"}
    light = {name for name in inner if random.random() < 0.25}
    bodies = [Body(body.name) if body.name in light else body for body in bodies]
    names, last = [joint.coordinate for joint in joints], bodies[-1].name
    some = joints[random.integers(len(joints))]
    x, y, z = mq.position()
    far = triple(random.uniform(1.5, 2.5, 3))
    drive, axes = sympy.sin(3 * mq.time()), str(random.choice(["world", last]))
    choice = (
        mq.Potential("well", some.name, function_of(random, some.coordinate)),
        mq.PotentialField("field", last, (0.1, 0.0, 0.2), sympy.sin(x) * y + z**2 / 2),
        mq.CentralForce("pull", "ground", far, last, (0.0, 0.1, 0.0), -3.0 / mq.distance()),
        mq.Torque("couple", last, (drive, 1.0, 0.0), axes),
    )
    forces = tuple(force for force in choice if random.random() < 0.5)
    conditions, loops, led = list[VelocityConstraint](), list[Loop](), dict[str, sympy.Expr]()
    number, (first, second) = float(random.uniform(0.5, 1)), (names[0], names[-1])
    match random.integers(5):
        case 0 if len(joints) > 3:
            start = triple(random.uniform(-0.4, 0.4, 3))
            loops.append(Loop.distance("tie", "ground", start, last, (0.1, 0.0, 0.0), number))
        case 1:
            terms = {first: 1.0 + 0.3 * sympy.sin(coordinate(second)), second: number}
            conditions.append(VelocityConstraint("row", terms, 0.2 * sympy.sin(mq.time())))
        case 2:
            led[second] = number * coordinate(first)
    return Mechanism(
        "mixed",
        tuple(bodies),
        tuple(joints),
        forces=forces,
        loops=tuple(loops),
        velocity_constraints=tuple(conditions),
        coordinates=Coordinates((), led),
        gravity=triple(9.81 * np.array(direction(random))),
    )


def vehicle(random: Random) -> Mechanism:
    """Return wheels on an axle, or a cart that draws trailers on blades."""
    radius, width = (float(x) for x in random.uniform(0.1, 0.6, 2))
    plane = Placement(triple(random.uniform(-1, 1, 3)), triple(random.uniform(-0.5, 0.5, 3)))
    if random.random() < 0.5:
        flat = (0.5 * pi, 0.0, 0.0)
        names = ("left", "right")[: random.integers(1, 3)]
        wheels = [Body(n, mq.disk(10 ** random.uniform(-1, 1), radius).at(rpy=flat)) for n in names]
        bodies = [Body("ground"), Body("axle", shape(random, width)), *wheels]
        joints: list[Joint] = [Floating("free", "ground", "axle")]
        for name, side in zip(names, (1, -1), strict=False):
            hub = Placement((0.0, side * width, 0.0))
            joints.append(Revolute(f"{name} hub", "axle", name, axis=(0, 1, 0), origin=hub))
        crown = float(random.choice([0.0, 0.2 * radius]))
        rims = tuple(Rolling(n, n, radius, crown=crown, plane=plane) for n in names)
        return Mechanism("axle", tuple(bodies), tuple(joints), contacts=rims)
    bodies = [Body("ground"), Body("cart", shape(random))]
    joints = [Planar("plane", "ground", "cart", origin=plane)]
    edges = [Blade("edge", "cart", (float(random.uniform(-1, 1)), 0.0, 0.0))]
    for k in range(random.integers(1, 3)):
        hitch = Placement((float(random.uniform(-1, -0.3)), 0.0, 0.0))
        joints.append(Revolute(f"h{k}", bodies[-1].name, f"t{k}", axis=(0, 0, 1), origin=hitch))
        bodies.append(Body(f"t{k}", shape(random)))
        edges.append(Blade(f"edge {k}", f"t{k}", (float(random.uniform(-1, -0.2)), 0.0, 0.0)))
    torque = (JointForce("steers", "h0", mq.sin(3 * mq.time())),)
    return Mechanism("trailers", tuple(bodies), tuple(joints), forces=torque, contacts=tuple(edges))


def belted(random: Random) -> Mechanism:
    """Return wheels that a belt turns, open or crossed, one of them loaded, in any plane."""
    tilt = Placement(triple(random.uniform(-1, 1, 3)), triple(random.uniform(-3, 3, 3)))
    count = int(random.integers(2, 4))
    radii = [float(x) for x in random.uniform(0.05, 0.3, count)]
    places = [(0.0, 0.0, 0.0), (1.0, 0.2, 0.0), (0.4, 1.1, 0.0)][:count]
    bodies = [
        Body("ground"),
        Body("frame"),
        *(Body(f"w{k}", mq.disk(2.0, r)) for k, r in enumerate(radii)),
    ]
    joints: list[Joint] = [Fixed("mount", "ground", "frame", origin=tilt)]
    for k, place in enumerate(places):
        joints.append(Revolute(f"a{k}", "frame", f"w{k}", axis=(0, 0, 1), origin=Placement(place)))
    crossed = count == 2 and random.random() < 0.5
    senses = [1, -1] if crossed else [1] * count
    over = tuple(
        Pulley(f"w{k}", radius, sense)
        for k, (radius, sense) in enumerate(zip(radii, senses, strict=True))
    )
    preload = float(random.uniform(10, 90)) if random.random() < 0.5 else None
    belt = mq.Belt("belt", over, preload, (0.0, 0.0, 1.0), "frame")
    drive = (JointForce("drive", "a0", 2.0), JointDamper("drag", f"a{count - 1}", 0.4))
    return Mechanism("belt", tuple(bodies), tuple(joints), forces=drive, elements=(belt,))


def switching(random: Random) -> Mechanism:
    """Return a chain with friction and stops, a body on a rough floor, or a capstan."""
    mu, more = float(random.uniform(0.05, 0.8)), float(random.uniform(1.0, 1.5))
    gravity = triple(9.81 * np.array(direction(random)))
    pick = random.integers(4)
    if pick == 0:
        bodies, joints = [Body("ground")], list[Joint]()
        for k in range(random.integers(1, 4)):
            kind = Revolute if random.random() < 0.5 else Prismatic
            axis, origin = direction(random), placement(random)
            joints.append(kind(f"j{k}", bodies[-1].name, f"b{k}", axis=axis, origin=origin))
            bodies.append(Body(f"b{k}", shape(random)))
        load, rate = float(random.uniform(1, 9)), float(random.choice([0.0, 0.4]))
        last = joints[-1].name
        elements: list[object] = [mq.Friction("dry", "j0", mu, load, more * mu, rate)]
        stiff = float(random.uniform(50, 500)) if random.random() < 0.4 else None
        holds = 2.0 if stiff is None and random.random() < 0.4 else 0.0
        side = int(random.choice([1, -1]))
        elements.append(mq.Stop("stop", last, 0.3, side, 0.5, stiff, holds=holds))
        forces = (JointSpring("coil", last, 30.0),)
        return Mechanism(
            "rubbing",
            tuple(bodies),
            tuple(joints),
            forces=forces,
            gravity=gravity,
            switching=tuple(elements),  # type: ignore[arg-type]  # collected
        )
    if pick == 3:
        bodies = [Body("ground"), Body("a", shape(random, 0.2)), Body("b", shape(random, 0.2))]
        joints = [
            Prismatic("down", "ground", "a", axis=(0, 0, -1), origin=Placement((-0.1, 0, 0))),
            Prismatic("along", "ground", "b", axis=(0, 0, -1), origin=Placement((0.1, 0, 0))),
        ]
        cord = mq.Capstan("drum", "down", "along", 3.0, float(random.uniform(1, 9)), 0.3 * mu)
        return Mechanism("capstan", tuple(bodies), tuple(joints), switching=(cord,))
    radius = float(random.uniform(0.05, 0.5))
    center = triple(0.3 * radius * random.uniform(-1, 1, 3) * (random.random() < 0.5))
    if pick == 1:
        center = (center[0], 0.0, center[2])
        joints = [Planar("plane", "ground", "body", axis=(0, -1, 0))]
        gravity = (float(random.normal()), 0.0, -9.81)
        floor = mq.Contact("floor", "body", center, radius, mu=mu, mu_static=more * mu)
    else:
        joints = [Floating("free", "ground", "body")]
        bowl = float(random.choice([0.0, 5 * radius, -4 * radius]))
        floor = mq.Contact(
            "floor",
            "body",
            center,
            radius,
            plane=placement(random),
            bowl=bowl,
            mu=mu,
            restitution=0.4,
        )
    bodies = [Body("ground"), Body("body", mq.ball(10 ** random.uniform(-1, 1), radius))]
    return Mechanism("floor", tuple(bodies), tuple(joints), gravity=gravity, switching=(floor,))


KINDS = {
    "tree": tree,
    "planar loop": planar_loop,
    "spatial loop": spatial_loop,
    "rolling": rolling,
    "sliding": sliding,
    "guided": guided,
    "map": mapped,
    "mixed": mixed,
    "vehicle": vehicle,
    "belt": belted,
    "switching": switching,
}


def judge(kind: str, seed: int) -> str:
    """Return what became of one mechanism: "agrees", or what is wrong."""
    mechanism = KINDS[kind](np.random.default_rng([seed, *kind.encode()]))
    try:
        verdict = mq.verify(mechanism, SAMPLES, seed)
    except mq.MecaniqueError as error:
        return f"declined: {type(error).__name__}: {error}"
    if verdict.agrees:
        return move(mechanism, seed)
    rows = [row for row in verdict.rows if not row.agrees]
    return "disagrees: " + ", ".join(
        f"{row.quantity} of {row.sources[0]} {row.worst:.1e} > {row.allowed:.1e}"
        for row in rows[:3]
    )


def move(mechanism: Mechanism, seed: int) -> str:
    """Return whether it moves from a random state, in numbers: "agrees" if so or if it says why."""
    states = random_states(mechanism, 1, seed)
    try:
        motion = mq.simulate(mechanism, q=states.q[0], v=states.v[0], duration=MOVED)
    except mq.MecaniqueError as error:
        return f"stands: {type(error).__name__}: {error}"
    numbers = (motion.t, motion.q, motion.v, motion.a, motion.energy().total)
    if not all(np.isfinite(values).all() for values in numbers):
        return "gives what is no number in its motion"
    return "agrees"


def try_one(kind: str, seed: int) -> str:
    """Judge one mechanism in a fork of this process, which ends after its limit."""
    reading, writing = os.pipe()
    child = os.fork()
    if not child:
        resource.setrlimit(resource.RLIMIT_CPU, (LIMIT, LIMIT + 5))
        try:
            outcome = judge(kind, seed)
        except BaseException as error:  # any exception but the documented ones is a fault
            outcome = f"raises: {type(error).__name__}: {error}"
        os.write(writing, outcome[:2000].encode())
        os._exit(0)
    os.close(writing)
    with os.fdopen(reading, encoding="utf-8", errors="replace") as pipe:
        outcome = pipe.read()
    status = os.waitpid(child, 0)[1]
    if os.WIFSIGNALED(status) and os.WTERMSIG(status) in (signal.SIGXCPU, signal.SIGKILL):
        return f"hangs: no end in {LIMIT} s of processor time"
    return outcome or f"raises: ended with status {status}"


def main(options: argparse.Namespace) -> int:
    """Return the number of failures."""
    kinds = [options.only] if options.only else list(KINDS)
    counts: dict[str, Counter[str]] = {kind: Counter() for kind in kinds}
    slowest = dict.fromkeys(kinds, 0.0)
    os.nice(10)
    for k in range(options.number):
        kind, seed = kinds[k % len(kinds)], options.seed + k
        begin = time.perf_counter()
        outcome = try_one(kind, seed)
        slowest[kind] = max(slowest[kind], time.perf_counter() - begin)
        counts[kind][outcome.split(":")[0].split()[0]] += 1
        if outcome != "agrees":
            print(f"{kind}, seed {seed}: {outcome[:400]}", flush=True)
        if not (k + 1) % STRIDE:
            print(f"{k + 1} tried", flush=True)
    heads = ("agrees", "declined", "stands", "disagrees", "gives", "raises", "hangs")
    print(f"\n{'kind':14}", *(f"{head:>10}" for head in (*heads, "slowest s")))
    for kind, count in counts.items():
        print(f"{kind:14}", *(f"{count[head]:10}" for head in heads), f"{slowest[kind]:10.1f}")
    return sum(count[head] for count in counts.values() for head in heads[3:])


def read_options() -> argparse.Namespace:
    """Return what the command line asks for."""
    parser = argparse.ArgumentParser(description="Verify random mechanisms.")
    parser.add_argument("number", nargs="?", type=int, default=500, help="how many")
    parser.add_argument("--seed", type=int, default=0, help="of the first; the others follow")
    parser.add_argument("--only", choices=KINDS, help="one kind alone")
    return parser.parse_args()


if __name__ == "__main__":
    raise SystemExit(min(1, main(read_options())))
