"""Mistakes put into sound models, by other means than the search for causes uses."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

import mecanique as mq
from mecanique.derivation.numeric.recursion import Recursion
from mecanique.errors import MecaniqueError
from mecanique.model.coordinates import Coordinates
from mecanique.model.placement import Placement, rpy_rotation
from mecanique.model.states import States
from mecanique.verification.states import random_states

Array = Any
Ours = mq.Mechanism
Theirs = Callable[[States], dict[str, Array]]


@dataclass(frozen=True, eq=False)
class Injection:
    kind: str
    where: str
    ours: mq.Mechanism
    theirs: Theirs


def told_by(mechanism: mq.Mechanism) -> Theirs:
    def values(states: States) -> dict[str, Array]:
        numeric, some = Recursion(mechanism), States.of(mechanism, states.q, states.v, states.t)
        return {
            "mass matrix": numeric.mass_matrix(some),
            "bias": numeric.bias(some),
            "gravity": numeric.gravity(some),
            "forces": numeric.forces(some),
        }

    return values


def chosen(rng: np.random.Generator, items: list[Any]) -> Iterator[Any]:
    for k in rng.permutation(len(items)):
        yield items[k]


def hinges(m: mq.Mechanism, turning: bool = False) -> list[Any]:
    kinds = (mq.Revolute,) if turning else (mq.Revolute, mq.Prismatic)
    return [j for j in m.joints if isinstance(j, kinds) and j.coordinate in m.coordinates]


def heavy(m: mq.Mechanism) -> list[mq.Body]:
    return [b for b in m.bodies if b.name != m.ground and m.evaluate(b.mass) > 0]


def parts(m: mq.Mechanism, body: mq.Body) -> tuple[float, Array, Array]:
    ixx, iyy, izz, ixy, ixz, iyz = (m.evaluate(i) for i in body.inertia)
    return (
        m.evaluate(body.mass),
        np.array([m.evaluate(c) for c in body.center]),
        np.array([[ixx, ixy, ixz], [ixy, iyy, iyz], [ixz, iyz, izz]]),
    )


def with_body(
    m: mq.Mechanism, name: str, mass: float, center: Array, inertia: Array
) -> mq.Mechanism:
    entries: Any = tuple(
        float(inertia[i, k]) for i, k in ((0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2))
    )
    shape = mq.Shape(mass, (center[0], center[1], center[2]), entries)
    return replace(m, bodies=tuple(mq.Body(name, shape) if b.name == name else b for b in m.bodies))


def with_joint(m: mq.Mechanism, name: str, **fields: Any) -> mq.Mechanism:
    return replace(m, joints=tuple(replace(j, **fields) if j.name == name else j for j in m.joints))


def steiner(mass: float, at: Array) -> Array:
    return mass * (at @ at * np.eye(3) - np.outer(at, at))


def changed_body(
    m: mq.Mechanism,
    rng: np.random.Generator,
    kind: str,
    change: Callable[[float, Array, Array], Any],
) -> Iterator[Injection]:
    for body in chosen(rng, heavy(m)):
        try:
            theirs = with_body(m, body.name, *change(*parts(m, body)))
        except MecaniqueError:
            continue
        # either side may be wrong
        pair = (m, theirs) if rng.random() < 0.5 else (theirs, m)
        yield Injection(kind, f"link {body.name!r}", pair[0], told_by(pair[1]))


def armature(m: mq.Mechanism, rng: np.random.Generator) -> Iterator[Injection]:
    for joint in chosen(rng, hinges(m)):
        amount = float(10 ** rng.uniform(-2, 0.5))
        yield Injection(
            "armature",
            f"joint {joint.name!r}",
            m,
            told_by(with_joint(m, joint.name, armature=amount)),
        )


def damping(m: mq.Mechanism, rng: np.random.Generator) -> Iterator[Injection]:
    for joint in chosen(rng, hinges(m)):
        more = mq.JointDamper("injected damper", joint.name, float(10 ** rng.uniform(-2, 1)))
        damped = replace(m, forces=(*m.forces, more))
        pair = (m, damped) if rng.random() < 0.5 else (damped, m)
        yield Injection("damping", f"joint {joint.name!r}", pair[0], told_by(pair[1]))


def friction(m: mq.Mechanism, rng: np.random.Generator) -> Iterator[Injection]:
    for joint in chosen(rng, hinges(m)):
        index, amount = m.velocities.index(f"{joint.coordinate}'"), float(10 ** rng.uniform(-2, 1))

        def values(states: States, index: int = index, amount: float = amount) -> dict[str, Array]:
            given = told_by(m)(states)
            given["forces"] = given["forces"].copy()
            given["forces"][:, index] -= amount * np.sign(states.v[:, index])
            return given

        yield Injection("friction", f"joint {joint.name!r}", m, values)


def root_mass(m: mq.Mechanism, rng: np.random.Generator) -> Iterator[Injection]:
    children = {j.child for j in m.joints if j.parent == m.ground}
    for body in chosen(rng, [b for b in heavy(m) if b.name in children]):
        mass, center, inertia = parts(m, body)
        kinds = {
            "missing": (1e-12 * mass, center, 1e-12 * inertia),
            "twice": (2 * mass, center, 2 * inertia),
            "load": (1.7 * mass, center, inertia),
        }
        name = str(rng.choice(list(kinds)))
        try:
            theirs = with_body(m, body.name, *kinds[name])
        except MecaniqueError:
            continue
        yield Injection("root mass", f"link {body.name!r}", m, told_by(theirs))


def wrong_point(m: mq.Mechanism, rng: np.random.Generator) -> Iterator[Injection]:
    poses = dict(zip([b.name for b in m.bodies], mq.Reference(m).poses(m.neutral()), strict=True))
    for body in chosen(rng, heavy(m)):
        mass, center, inertia = parts(m, body)
        R, p = poses[body.name][:3, :3], poses[body.name][:3, 3]
        wrong = with_body(m, body.name, mass, center, inertia + steiner(mass, center + R.T @ p))
        if np.allclose(R.T @ p, 0, rtol=0, atol=1e-9):
            continue
        pair = (m, wrong) if rng.random() < 0.5 else (wrong, m)
        yield Injection("wrong point", f"link {body.name!r}", pair[0], told_by(pair[1]))


def wrong_axes(m: mq.Mechanism, rng: np.random.Generator) -> Iterator[Injection]:
    frames = {
        j.child: np.array(rpy_rotation([m.evaluate(a) for a in j.origin.rpy]), dtype=float)
        for j in m.joints
    }
    for body in chosen(rng, heavy(m)):
        mass, center, inertia = parts(m, body)
        turns = [
            np.eye(3)[[1, 2, 0]],
            np.eye(3)[[2, 0, 1]],
            np.array([[0.0, -1, 0], [1, 0, 0], [0, 0, 1]]),
        ]
        if not np.allclose(abs(frames[body.name]), np.eye(3), rtol=0, atol=1e-3):
            turns.append(frames[body.name])
        R = turns[rng.integers(len(turns))]
        theirs = with_body(m, body.name, mass, center, R @ inertia @ R.T)
        yield Injection("wrong axes", f"link {body.name!r}", m, told_by(theirs))


def parallel_axis(m: mq.Mechanism, rng: np.random.Generator) -> Iterator[Injection]:
    yield from changed_body(
        m, rng, "parallel axis", lambda mass, c, i: (mass, c, i + steiner(mass, c))
    )


def degree(m: mq.Mechanism, rng: np.random.Generator) -> Iterator[Injection]:
    for joint in chosen(rng, hinges(m, turning=True)):
        if rng.random() < 0.5 and any(m.evaluate(a) for a in joint.origin.rpy):
            rpy: Any = tuple(m.evaluate(a) * np.pi / 180 for a in joint.origin.rpy)
            theirs = with_joint(m, joint.name, origin=Placement(joint.origin.xyz, rpy))
            yield Injection("degree", f"joint {joint.name!r}", m, told_by(theirs))
            continue
        at = m.coordinates.index(joint.coordinate)

        def values(states: States, at: int = at) -> dict[str, Array]:
            q = states.q.copy()
            q[:, at] = np.deg2rad(q[:, at])
            return told_by(m)(replace(states, q=q))

        yield Injection("degree", f"coordinate {joint.coordinate!r}", m, values)


def axis_sign(m: mq.Mechanism, rng: np.random.Generator) -> Iterator[Injection]:
    for joint in chosen(rng, hinges(m)):
        theirs = with_joint(m, joint.name, axis=tuple(-x for x in joint.axis))
        yield Injection("axis sign", f"joint {joint.name!r}", m, told_by(theirs))


def gravity_sign(m: mq.Mechanism, rng: np.random.Generator) -> Iterator[Injection]:
    g: Any = tuple(-m.evaluate(x) for x in m.gravity)
    if any(g):
        yield Injection("gravity sign", "", m, told_by(replace(m, gravity=g)))


def gravity_direction(m: mq.Mechanism, rng: np.random.Generator) -> Iterator[Injection]:
    size = float(np.linalg.norm([m.evaluate(x) for x in m.gravity]))
    if size:
        ways: list[Any] = [
            (0.0, size, 0.0),
            (size, 0.0, 0.0),
            tuple((size * np.array([0.36, -0.48, -0.8])).tolist()),
        ]
        g = ways[rng.integers(len(ways))]
        yield Injection("gravity direction", "", m, told_by(replace(m, gravity=g)))


def joint_order(m: mq.Mechanism, rng: np.random.Generator) -> Iterator[Injection]:
    names = [j.coordinate for j in hinges(m)]
    if len(names) < 2:
        return
    i, k = rng.choice(len(names), 2, replace=False)
    order = list(m.coordinates)
    a, b = order.index(names[i]), order.index(names[k])
    order[a], order[b] = order[b], order[a]
    theirs = replace(m, coordinates=Coordinates(tuple(order), m.coordinates.map))
    # the other side takes and gives plain arrays in its own order
    yield Injection("joint order", "", m, told_by(theirs))


def mimic(m: mq.Mechanism, rng: np.random.Generator) -> Iterator[Injection]:
    for name in chosen(rng, list(m.coordinates.driven)):
        still = Coordinates(tuple(m.coordinates), {**m.coordinates.driven, name: 0.0})
        try:
            yield Injection("mimic", name, m, told_by(replace(m, coordinates=still)))
        except MecaniqueError:
            continue


def mass_unit(m: mq.Mechanism, rng: np.random.Generator) -> Iterator[Injection]:
    factor = 1000.0
    both = rng.random() < 0.5
    yield from changed_body(
        m, rng, "mass unit", lambda mass, c, i: (factor * mass, c, factor * i if both else i)
    )


def length_unit(m: mq.Mechanism, rng: np.random.Generator) -> Iterator[Injection]:
    if rng.random() < 0.5:
        yield from changed_body(m, rng, "length unit", lambda mass, c, i: (mass, 1e-3 * c, i))
    else:
        for joint in chosen(rng, hinges(m)):
            xyz: Any = tuple(1000 * m.evaluate(x) for x in joint.origin.xyz)
            theirs = with_joint(m, joint.name, origin=Placement(xyz, joint.origin.rpy))
            yield Injection("length unit", f"joint {joint.name!r}", m, told_by(theirs))


def product_sign(m: mq.Mechanism, rng: np.random.Generator) -> Iterator[Injection]:
    for body in chosen(rng, heavy(m)):
        mass, center, inertia = parts(m, body)
        other = 2 * np.diag(np.diag(inertia)) - inertia
        if np.abs(other - inertia).max() < 1e-3 * np.abs(inertia).max():
            continue
        try:
            theirs = with_body(m, body.name, mass, center, other)
        except MecaniqueError:
            continue
        yield Injection("product sign", f"link {body.name!r}", m, told_by(theirs))


INJECTIONS: dict[str, Callable[[mq.Mechanism, np.random.Generator], Iterator[Injection]]] = {
    "armature": armature,
    "damping": damping,
    "friction": friction,
    "root mass": root_mass,
    "wrong point": wrong_point,
    "wrong axes": wrong_axes,
    "parallel axis": parallel_axis,
    "degree": degree,
    "axis sign": axis_sign,
    "gravity sign": gravity_sign,
    "gravity direction": gravity_direction,
    "joint order": joint_order,
    "mimic": mimic,
    "mass unit": mass_unit,
    "length unit": length_unit,
    "product sign": product_sign,
}


def seen(injection: Injection, seed: int) -> tuple[States, dict[str, Array]] | None:
    """States and what the other side says there; None if the mistake changes nothing."""
    states = random_states(injection.ours, 40, seed)
    theirs, ours = injection.theirs(states), told_by(injection.ours)(states)
    changes = [
        float(np.abs(theirs[name] - ours[name]).max())
        / max(float(np.abs(theirs[name]).max()), 1e-12)
        for name in theirs
    ]
    return (states, theirs) if max(changes) > 1e-6 else None
