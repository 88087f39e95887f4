"""Compare two descriptions: what a person would say has changed."""

from __future__ import annotations

import math
import os
import re
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, fields, is_dataclass, replace
from operator import attrgetter
from typing import Any, final

import numpy as np

from mecanique.arrays import Array
from mecanique.derivation import derive
from mecanique.errors import MecaniqueError
from mecanique.formats.read import read
from mecanique.model import Body, Fixed, Joint, Limits, Mechanism, Placement, Planar, slips
from mecanique.model.bodies.tensor import entries_of, moments_of, tensor_of
from mecanique.model.expression import plain, symbols_in
from mecanique.model.force_base import JointLoad
from mecanique.model.joint_base import Single
from mecanique.model.placement import rpy_rotation
from mecanique.model.slips import DIGITS, LEFT_OUT, Factor, Slip
from mecanique.verification.rows import differ_by
from mecanique.verification.states import random_states
from mecanique.verification.verdict import Change, Difference

_CLOSE = 1e-4
"""Relative difference that digits left out in print make."""

_ALONE = (*slips.MILLIMETERS, *DIGITS[:2], Factor(-1.0, "sign", "the other sign"))
"""What may happen to a single number of several."""


def mass_slip(before: float, after: float) -> str:
    """Return what a changed mass looks like; empty if it looks like none known."""
    if before and not after:
        return LEFT_OUT
    return _factor(np.array([before]), np.array([after]), (*slips.MASS, *DIGITS))


def vector_slip(before: Array, after: Array) -> str:
    """Return what a changed position looks like, both of shape (3,) [m]."""
    text = _factor(before, after, (*slips.LENGTH, *DIGITS[:2]))
    text = text or _first(slips.mistake_vector("", before), after, before)
    if not text and before.any() and not after.any():
        return LEFT_OUT
    return text or _entry(before, after, "xyz", before)


def inertia_slip(mass: float, center: Array, before: Array, after: Array) -> str:
    """Return what a changed inertia looks like, both about the center of mass, shape (3, 3)."""
    text = _factor(before, after, (*slips.INERTIA, *DIGITS[:2]))
    if not text and before.any() and not after.any():
        return LEFT_OUT
    text = text or _first(slips.mistake_point(mass, center, before), after, after)
    text = text or _first(slips.mistake_products(before), after, before)
    text = text or _first(slips.mistake_axes(before), after, before)
    if text:
        return text
    values, others = (np.array(np.linalg.eigvalsh(x), dtype=float) for x in (before, after))
    if _near(values, others, values):
        return "the same principal moments about other axes"
    upper = np.triu_indices(3)
    names = [f"i{'xyz'[i]}{'xyz'[k]}" for i, k in zip(*upper, strict=True)]
    return _entry(before[upper], after[upper], names, before)


def turn_slip(before: Array, after: Array) -> str:
    """Return what changed roll, pitch and yaw look like, both of shape (3,) [rad]."""
    right, wrong = slips.turn_of(before), slips.turn_of(after)
    identity = np.eye(3)
    if text := _first(slips.mistake_turn(before), wrong, identity):
        return text
    for axis, name in zip(np.eye(3), "xyz", strict=True):
        for angle in (np.pi / 2, -np.pi / 2, np.pi):
            turn = slips.turn_of(angle * axis)
            if any(_near(wrong, turned, identity) for turned in (right @ turn, turn @ right)):
                return f"{np.degrees(angle):+.0f}° about {name}"
    return ""


def axis_slip(before: Array, after: Array) -> str:
    """Return what a changed axis looks like."""
    return "reversed" if _near(after, -before, before) else vector_slip(before, after)


def bounds_slip(before: Array, after: Array) -> str:
    """Return what changed limits look like."""
    factors = (*slips.ANGLE, *slips.MILLIMETERS, Factor(-1.0, "sign", "the other sign"))
    if text := _factor(before, after, factors):
        return text
    return "the other sign, exchanged" if _near(after, -before[::-1], before) else ""


def _factor(before: Array, after: Array, factors: Iterable[Factor]) -> str:
    """Return the words of the factor between two arrays; empty if it is none of these."""
    known = (f.text for f in factors if before.any() and _near(after, f.factor * before, after))
    return next(known, "")


def _first(candidates: Iterator[Slip], after: Array, size: Array) -> str:
    return next((slip.text for slip in candidates if _near(after, slip.value, size)), "")


def _entry(before: Array, after: Array, names: Sequence[str], size: Array) -> str:
    """Return the slip of a single entry, the only one that changed."""
    changed = [k for k in range(len(before)) if not _near(after[k], before[k], size)]
    if len(changed) != 1:
        return ""
    (k,) = changed
    text = _factor(before[k : k + 1], after[k : k + 1], _ALONE)
    return f"{text} of {names[k]} alone" if text else ""


def _near(x: Array, y: Array, size: Array) -> bool:
    return bool(np.abs(x - y).max() <= _CLOSE * np.abs(size).max())


_EQUAL = 1e-9
"""Relative difference of numbers that were written and read again."""


@final
@dataclass(frozen=True)
class Pairs:
    """The matching bodies and joints."""

    bodies: dict[str, str]  # name in the second description, by name in the first
    joints: dict[str, str]


def pair(a: Mechanism, b: Mechanism) -> Pairs:
    """Return the matching bodies and joints of two mechanisms."""
    bodies = _by_name((x.name for x in a.bodies), (x.name for x in b.bodies))
    joints = _by_name((x.name for x in a.joints), (x.name for x in b.joints))
    into_b = {joint.child: joint for joint in b.joints}
    grown = True
    while grown:
        grown = False
        for joint_a in a.tree:
            # a joint that keeps its name, or whose child does, shows what the other is called
            twin = b.joint(joints[joint_a.name]) if joint_a.name in joints else None
            if twin is None and joint_a.child in bodies:
                twin_joint = into_b.get(bodies[joint_a.child])
                if twin_joint is not None and twin_joint.name not in joints.values():
                    joints[joint_a.name] = twin_joint.name
                    grown = True
            elif twin is not None and joint_a.child not in bodies:
                if twin.child not in bodies.values():
                    bodies[joint_a.child] = twin.child
                    grown = True
            elif twin is None and bodies.get(joint_a.parent) is not None:
                alike = [
                    joint
                    for joint in b.joints
                    if joint.name not in joints.values()
                    and joint.parent == bodies[joint_a.parent]
                    and joint.child not in bodies.values()
                    and _alike(joint_a, joint, a.body(joint_a.child), b.body(joint.child))
                ]
                if len(alike) == 1:
                    joints[joint_a.name], bodies[joint_a.child] = alike[0].name, alike[0].child
                    grown = True
    if a.ground not in bodies and b.ground not in bodies.values():
        bodies[a.ground] = b.ground
    return Pairs(bodies, joints)


def numbers_of(body: Body) -> tuple[float, Array, Array]:
    """Return mass, center of mass and inertia tensor about it, as numbers."""
    center = np.array(body.center, dtype=float)
    return float(body.mass), center, tensor_of(map(float, body.inertia))


def _by_name(first: Iterable[str], second: Iterable[str]) -> dict[str, str]:
    known = set(second)
    return {name: name for name in first if name in known}


def _alike(joint_a: Joint, twin_joint: Joint, body: Body, twin: Body) -> bool:
    """Whether two joints with other names and their children are the same in all numbers."""
    if type(joint_a) is not type(twin_joint):
        return False
    origins = [
        np.array([*joint.origin.xyz, *np.ravel(joint.origin.rotation)], dtype=float)
        for joint in (joint_a, twin_joint)
    ]
    (m, c, inertia), (n, d, moment) = numbers_of(body), numbers_of(twin)
    return (
        np.allclose(origins[0], origins[1], rtol=0, atol=_EQUAL)
        and abs(m - n) <= _EQUAL * max(m, n)
        and np.allclose(c, d, rtol=0, atol=_EQUAL)
        and np.allclose(inertia, moment, rtol=1e-6, atol=_EQUAL * max(np.abs(inertia).max(), 1e-12))
    )


_SAME = 1e-9
"""Numbers that differ by less, relative to their size, are the same, written another way."""

_STATES = 4
"""Number of random states at which a change is weighed."""


def diff(
    first: Mechanism | str | os.PathLike[str], second: Mechanism | str | os.PathLike[str]
) -> Difference:
    """Return what differs between two descriptions: the structure, then numbers by their weight.

    Links and joints are matched by name, else by what they are; fixed links that were merged into
    their parents are told as such. Each changed number is applied to the first description alone,
    and weighed by the relative change of its mass matrix and bias at random states. Where it looks
    like a known slip (another unit, a mirrored or exchanged axis, another point), that is said.

    Args:
        first: a mechanism, or the path or text of a URDF.
        second: the other.

    Returns:
        What differs, to print or to loop over.

    Raises:
        UrdfError: if a text cannot be read.

    Example:
        >>> right, wrong = (mq.textbook.load("double_pendulum", l1=l) for l in (1.0, 0.001))
        >>> print(mq.diff(right, wrong).changes[0])
        joint 'pin2': origin xyz 0 0 -1 → 0 0 -0.001 m: meters for millimeters
    """
    a, b = map(_read, (first, second))
    pairs = pair(a, b)
    notes: list[str] = []
    numeric = [*_bodies(a, b, pairs), *_joints(a, b, pairs), *_elements(a, b, pairs)]
    weighed = _weigh(a, numeric, notes)
    weighed.sort(key=lambda change: -change.weight if change.weight == change.weight else 0.0)
    names = (a.name, b.name if b.name != a.name else f"the other {b.name}")
    return Difference(*names, (*_structure(a, b, pairs), *weighed), tuple(notes))


def _read(given: Mechanism | str | os.PathLike[str]) -> Mechanism:
    """Return a mechanism in numbers."""
    m = given if isinstance(given, Mechanism) else read(given)
    bodies = []
    for body in m.bodies:
        center, inertia = m.evaluate_all(body.center), m.evaluate_all(body.inertia)
        bodies.append(body.replace(mass=m.evaluate(body.mass), center=center, inertia=inertia))
    joints: list[Joint] = []
    for joint in m.joints:
        x, y, z = m.evaluate_all(joint.origin.xyz)
        roll, pitch, yaw = m.evaluate_all(joint.origin.rpy)
        joints.append(replace(joint, origin=Placement((x, y, z), (roll, pitch, yaw))))
    return replace(m, bodies=tuple(bodies), joints=tuple(joints))


_Numeric = tuple[Change, Body | Joint | None]
"""A change of numbers, and the body or joint of the first description that has it."""


def _structure(a: Mechanism, b: Mechanism, pairs: Pairs) -> Iterator[Change]:
    """What is added, removed, renamed, merged, reordered or hung elsewhere."""
    for kind, named, ours, theirs in (
        ("link", pairs.bodies, [x.name for x in a.bodies], [x.name for x in b.bodies]),
        ("joint", pairs.joints, [x.name for x in a.joints], [x.name for x in b.joints]),
    ):
        for name, renamed in named.items():
            if name != renamed:
                yield Change(f"{kind} {name!r}", "renamed", repr(name), repr(renamed))
        for name in ours:
            if name not in named:
                yield Change(f"{kind} {name!r}", _fate(a, b, pairs, name, kind, "removed"))
        back = Pairs(
            {v: k for k, v in pairs.bodies.items()}, {v: k for k, v in pairs.joints.items()}
        )
        for name in theirs:
            if name not in named.values():
                yield Change(f"{kind} {name!r}", _fate(b, a, back, name, kind, "added"))
    shared = [joint.name for joint in a.joints if joint.name in pairs.joints]
    order = [joint.name for joint in b.joints if joint.name in pairs.joints.values()]
    if [pairs.joints[name] for name in shared] != order:
        yield Change("", "the joints stand in another order, and so do the coordinates")


def _fate(a: Mechanism, b: Mechanism, pairs: Pairs, name: str, kind: str, verb: str) -> str:
    """Say what became of a link or joint of `a` that `b` has not."""
    into = {joint.child: joint for joint in a.joints}
    joint = into.get(name) if kind == "link" else a.joint(name)
    if not isinstance(joint, Fixed) or joint.parent not in pairs.bodies:
        return verb
    whole = _total(a, joint.parent)
    rest = _total(b, pairs.bodies[joint.parent])
    size = max(np.abs(whole).max(), 1e-300)
    if np.abs(whole - rest).max() > 1e-6 * size:
        return verb
    step = "merged into" if verb == "removed" else "split off from"
    return f"{step} link {joint.parent!r}, with the same mass and inertia in all"


def _total(m: Mechanism, body: str) -> Array:
    """Return mass, first and second moments of all that is welded to a body, in its frame."""
    parts = [pose @ moments_of(*numbers_of(m.body(k))) @ pose.T for k, pose in _welds(m, body)]
    total: Array = np.sum(parts, axis=0)
    return total


def _welds(m: Mechanism, body: str) -> Iterator[tuple[str, Array]]:
    """Yield a body and all that is welded to it, each with its pose in the body's frame."""
    waiting = [(body, np.eye(4))]
    while waiting:
        name, pose = waiting.pop()
        yield name, pose
        waiting += [
            (joint.child, pose @ m.matrix(joint.origin))
            for joint in m.joints
            if joint.parent == name and isinstance(joint, Fixed)
        ]


def _only_merge(a: Mechanism, b: Mechanism, pairs: Pairs, body: Body, twin: Body) -> bool:
    """Whether links were merged into a body or split off, and all they weigh is the same."""
    # without such links a mass that differs by a millionth is another mass
    welds = {pairs.bodies.get(name) for name, _ in _welds(a, body.name)}
    if welds == {name for name, _ in _welds(b, twin.name)}:
        return False
    return np.allclose(_total(a, body.name), _total(b, twin.name), rtol=1e-6, atol=1e-12)


def _bodies(a: Mechanism, b: Mechanism, pairs: Pairs) -> Iterator[_Numeric]:
    for body in a.bodies:
        if body.name not in pairs.bodies:
            continue
        twin = b.body(pairs.bodies[body.name])
        where = f"link {body.name!r}"
        (m, c, inertia), (n, d, moment) = numbers_of(body), numbers_of(twin)
        if abs(m - n) > _SAME * max(m, n) and _only_merge(a, b, pairs, body, twin):
            continue
        if abs(m - n) > _SAME * max(abs(m), abs(n)):
            percent = f" ({100 * (n / m - 1):+.3g} %)" if m else ""
            before, after = _show(m, n)
            change = Change(where, "mass", before, f"{after} kg{percent}", mass_slip(m, n))
            yield change, body.replace(mass=n)
        if _differ(c, d):
            slip = vector_slip(c, d)
            yield _change(where, "center of mass", c, d, "m", slip), body.replace(center=d)
        if _differ(inertia, moment, 1e-7):
            slip = inertia_slip(m, c, inertia, moment)
            old, new = (np.array(entries_of(tensor)) for tensor in (inertia, moment))
            yield (
                _change(where, "inertia xx yy zz xy xz yz", old, new, "kg·m²", slip),
                Body(body.name, *body.replace(inertia=twin.inertia).shapes, as_given=True),
            )


def _joints(a: Mechanism, b: Mechanism, pairs: Pairs) -> Iterator[_Numeric]:
    for joint_a in a.joints:
        if joint_a.name not in pairs.joints:
            continue
        twin = b.joint(pairs.joints[joint_a.name])
        where = f"joint {joint_a.name!r}"
        if pairs.bodies.get(joint_a.parent, "") != twin.parent:
            yield Change(where, "parent", repr(joint_a.parent), repr(twin.parent)), None
        if pairs.bodies.get(joint_a.child, "") != twin.child:
            yield Change(where, "child", repr(joint_a.child), repr(twin.child)), None
        if type(joint_a) is not type(twin):
            kinds = [type(joint).__name__.lower() for joint in (joint_a, twin)]
            yield Change(where, "type", kinds[0], kinds[1]), None
            continue
        yield from _frames(where, joint_a, twin)
        if isinstance(joint_a, (Single, Planar)) and isinstance(twin, (Single, Planar)):
            old, new = (np.array(joint.axis, dtype=float) for joint in (joint_a, twin))
            if _differ(old, new):
                slip = axis_slip(old, new)
                yield _change(where, "axis", old, new, "", slip), replace(joint_a, axis=twin.axis)
        if isinstance(joint_a, Single) and isinstance(twin, Single):
            yield from _single(a, b, where, joint_a, twin)


def _frames(where: str, joint_a: Joint, twin: Joint) -> Iterator[_Numeric]:
    here, there = (np.array(joint.origin.xyz, dtype=float) for joint in (joint_a, twin))
    if _differ(here, there):
        slip = vector_slip(here, there)
        moved = replace(joint_a, origin=replace(joint_a.origin, xyz=twin.origin.xyz))
        yield _change(where, "origin xyz", here, there, "m", slip), moved
    turns = [np.array(joint.origin.rotation, dtype=float) for joint in (joint_a, twin)]
    if np.abs(turns[0] - turns[1]).max() > _SAME:
        before, after = (np.array(joint.origin.rpy, dtype=float) for joint in (joint_a, twin))
        slip = turn_slip(before, after)
        turned = replace(joint_a, origin=replace(joint_a.origin, rpy=twin.origin.rpy))
        yield _change(where, "origin rpy", before, after, "rad", slip), turned


def _single(
    a: Mechanism, b: Mechanism, where: str, joint_a: Single, twin: Single
) -> Iterator[_Numeric]:
    for what, names in (("limits", ("lower", "upper")), ("effort and velocity", _BOUNDS)):
        limits = [joint.limits or Limits() for joint in (joint_a, twin)]
        before, after = np.array([*map(attrgetter(*names), limits)])
        if not np.array_equal(before, after):
            finite = np.isfinite([before, after]).all()
            slip = bounds_slip(before, after) if finite else ""
            yield _change(where, what, before, after, "", slip), None
    for what, values in (
        ("armature", [a.evaluate(joint_a.armature), b.evaluate(twin.armature)]),
        ("damping", [_damping(a, joint_a), _damping(b, twin)]),
    ):
        if abs(values[0] - values[1]) > _SAME * max(map(abs, values)):
            yield Change(where, what, *_show(*values)), None
    laws = [str(m.coordinates.driven.get(j.coordinate, "")) for m, j in ((a, joint_a), (b, twin))]
    if laws[0] != laws[1]:
        yield Change(where, "law of its coordinate", laws[0] or "free", laws[1] or "free"), None


def _elements(a: Mechanism, b: Mechanism, pairs: Pairs) -> Iterator[_Numeric]:
    """What differs in gravity, forces, constraints and all else that is neither link nor joint."""
    here, there = (np.array(m.evaluate_all(m.gravity)) for m in (a, b))
    if _differ(here, there):
        yield _change("", "gravity", here, there, "m/s²", axis_slip(here, there)), None
    for group in _GROUPS:
        for element, twin in _pair_elements(_members(a, group), _members(b, group)):
            present = element or twin
            kind = re.sub(r"(?<=[a-z])(?=[A-Z])", " ", type(present).__name__).lower()
            where = f"{kind} {present.name!r}"
            if element is None or twin is None:
                yield Change(where, "added" if element is None else "removed"), None
                continue
            before, after = dict(_parts(a, element, pairs)), dict(_parts(b, twin, None))
            for what in dict.fromkeys([*before, *after]):
                old, new = before.get(what, "none"), after.get(what, "none")
                if isinstance(old, str) or isinstance(new, str):
                    if not (isinstance(old, str) and old == new):
                        shown = [x if isinstance(x, str) else _write(x, 6) for x in (old, new)]
                        yield Change(where, what, shown[0], shown[1]), None
                elif old.shape != new.shape or _differ(old, new):
                    yield _change(where, what, old, new, "", ""), None


_GROUPS = ("forces", "loops", "contacts", "velocity_constraints", "elements", "switching")
"""What a mechanism has beside bodies and joints."""


def _members(m: Mechanism, group: str) -> list[Any]:
    """Return a group of elements, but dampers in joints, which are compared with these."""
    members = getattr(m, group)
    return [x for x in members if not (isinstance(x, JointLoad) and x.kind == "damper")]


def _pair_elements(first: Sequence[Any], second: Sequence[Any]) -> Iterator[tuple[Any, Any]]:
    """Yield elements of one type with their twins: of one name, else in order; None without one."""
    rest = list(second)
    unpaired = []
    for element in first:
        alike = [x for x in rest if type(x) is type(element) and x.name == element.name]
        if alike:
            rest.remove(alike[0])
            yield element, alike[0]
        else:
            unpaired.append(element)
    for element in unpaired:
        alike = [x for x in rest if type(x) is type(element)]
        if alike:
            rest.remove(alike[0])
        yield element, alike[0] if alike else None
    for twin in rest:
        yield None, twin


def _parts(m: Mechanism, record: Any, pairs: Pairs | None) -> Iterator[tuple[str, Array | str]]:
    """Yield the fields of an element but its name: numbers as an array, all else as words."""
    for field in fields(record):
        if field.name == "name" or field.name.startswith("_"):
            continue
        what = field.name.replace("_", " ")
        for k, (inner, value) in enumerate(_values(m, getattr(record, field.name), pairs)):
            yield " ".join([what, *([inner] if inner else []), *([str(k)] if k else [])]), value


def _values(m: Mechanism, value: Any, pairs: Pairs | None) -> Iterator[tuple[str, Array | str]]:
    """Yield a value's parts, each with its name within the value."""
    if isinstance(value, Placement):
        yield "xyz", np.array(m.evaluate_all(value.xyz))
        yield "rotation", np.ravel(np.array(rpy_rotation(m.evaluate_all(value.rpy)), dtype=float))
    elif is_dataclass(value):
        yield from _parts(m, value, pairs)
    elif isinstance(value, Mapping):
        for key, entry in value.items():
            yield from ((f"of {key}", part) for _, part in _values(m, entry, pairs))
    elif isinstance(value, str):
        known = {} if pairs is None else {**pairs.bodies, **pairs.joints}
        yield "", known.get(value, value)
    elif value is None or isinstance(value, bool) or callable(value):
        yield "", str(value)
    elif isinstance(value, tuple) and any(isinstance(x, str) or is_dataclass(x) for x in value):
        for entry in value:
            yield from _values(m, entry, pairs)
    else:
        scalars = [plain(x) for x in (value if isinstance(value, tuple) else (value,))]
        if any(symbols_in(scalar) - m.values.keys() for scalar in scalars):
            yield "", ", ".join(map(str, scalars))
        else:
            yield "", np.array([m.evaluate(scalar) for scalar in scalars])


_BOUNDS = ("effort", "velocity")


def _damping(m: Mechanism, joint: Single) -> float:
    dampers = [force for force in m.forces if hasattr(force, "damping")]
    return sum(m.evaluate(d.damping) for d in dampers if getattr(d, "joint", "") == joint.name)


def _weigh(a: Mechanism, numeric: Sequence[_Numeric], notes: list[str]) -> list[Change]:
    """Apply each change to the first description alone, and measure its effect on M and bias."""
    if not any(changed is not None for _, changed in numeric):
        return [change for change, _ in numeric]
    bare = replace(a, forces=(), loops=(), contacts=(), elements=())
    try:
        states = random_states(bare, _STATES, 0)
        mass, bias = _dynamics(bare, states)
    except MecaniqueError as error:
        notes.append(f"changes are not weighed: {error}")
        return [change for change, _ in numeric]
    weighed = []
    for change, changed in numeric:
        if changed is None:
            weighed.append(change)
            continue
        if isinstance(changed, Body):
            bodies = tuple(changed if x.name == changed.name else x for x in bare.bodies)
            mechanism = replace(bare, bodies=bodies)
        else:
            joints = tuple(changed if x.name == changed.name else x for x in bare.joints)
            mechanism = replace(bare, joints=joints)
        changed_mass, changed_bias = _dynamics(mechanism, states)
        differences = (
            differ_by("mass matrix", mass, changed_mass, mass),
            differ_by("bias", bias, changed_bias, mass),
        )
        weighed.append(replace(change, weight=float(np.mean(differences, axis=1).max())))
    return weighed


def _dynamics(m: Mechanism, states: Any) -> tuple[Array, Array]:
    equations = derive(m)
    mass = np.asarray(equations.mass_matrix(states.q, states.t))
    return mass, np.asarray(equations.bias(states.q, states.v, states.t))


def _change(where: str, what: str, before: Array, after: Array, unit: str, slip: str) -> Change:
    old, new = _show(before, after)
    return Change(where, what, old, f"{new} {unit}".strip(), slip)


def _show(before: Array | float, after: Array | float) -> tuple[str, str]:
    """Return two numbers or vectors with as many digits as show that they differ, 6 at least."""
    for digits in range(6, 18):
        old, new = _write(before, digits), _write(after, digits)
        if old != new:
            break
    return old, new


def _write(values: Array | float, digits: int) -> str:
    return " ".join(f"{x:.{digits}g}" for x in np.ravel(values) + 0.0)


def _differ(x: Array, y: Array, tolerance: float = _SAME) -> bool:
    size = max(float(np.abs(x).max()), float(np.abs(y).max()))
    return not math.isclose(size, 0.0, abs_tol=1e-300) and bool(
        np.abs(x - y).max() > tolerance * size
    )
