"""What makes a mechanism sound: every fault is found at once and reported in a sentence."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Iterable, Iterator, Mapping

import numpy as np

from mecanique.errors import MecaniqueError
from mecanique.model.constraint_base import ContactBase, SwitchingElement, list_cord_runs
from mecanique.model.constraints.friction import Contact, Friction
from mecanique.model.constraints.gears import Gear, Rack
from mecanique.model.constraints.loops import Loop
from mecanique.model.constraints.velocity_constraints import is_integrable
from mecanique.model.expression import (
    DISTANCE,
    FUNCTIONS,
    POSITION,
    Scalar,
    evaluate,
    plain,
    symbols_in,
)
from mecanique.model.force_base import AnyForce, FieldLoad, JointLoad
from mecanique.model.joint_base import Single
from mecanique.model.joints import Planar
from mecanique.model.mechanism.description import Description
from mecanique.model.mechanism.homogeneity import find_mismatches
from mecanique.model.statements import MechanismPart, NumberRule

MASS = "its mass is negative ({} kg)"
MOMENT = "its inertia has a negative principal moment ({} kg·m²)"
TRIANGLE = (
    "its principal moments break the triangle inequality ({} + {} < {} kg·m²): "
    "no mass is spread like that"
)


def rules_of(m: Description) -> Iterator[NumberRule]:
    """Yield what the parameters of a mechanism keep to, but for masses and inertias.

    Springs and dampers that would feed energy in are refused: write a Force for those.
    """
    for joint in m.joints:
        where = f"joint {joint.name!r}"
        yield from _finite(f"{where}: its origin", *joint.origin.xyz, *joint.origin.rpy)
        if isinstance(joint, Single):
            yield NumberRule(where, ": its armature is negative", gap=joint.armature, endless=True)
    yield from _finite("gravity", *m.gravity)
    for name, (lower, upper) in m.coordinates.intervals.items():
        where, words = f"coordinate {name!r}", ": its lower limit {} is not below its upper {}"
        width = plain(upper) - plain(lower)
        yield NumberRule(where, words, (lower, upper), width, strict=True, endless=True)
    for part in m.parts:
        yield from part.rules()
    # it would only come back as NaN
    for name, scalar in m.coordinates.driven.items():
        yield from _finite(f"the map of {name!r}", scalar)


def _finite(where: str, *scalars: Scalar) -> Iterator[NumberRule]:
    yield from (NumberRule(where, " is not finite", (scalar,)) for scalar in scalars)


def find_broken(rules: Iterable[NumberRule], values: Mapping[str, float]) -> list[str]:
    """Return the faults of rules, each once; what varies in a motion is not judged."""
    faults: list[str] = []
    fault = None
    for rule in rules:
        varies = any(not symbols_in(scalar) <= values.keys() for scalar in rule.scalars)
        if varies or (rule.follows and fault):
            continue
        fault = rule.fault(values)
        if fault and fault not in faults:
            faults.append(fault)
    return faults


def _parts(m: Description) -> Iterator[str]:
    """Yield which parts refer to what is not there, or join a body to itself."""
    bodies = {body.name for body in m.bodies}
    joints = {joint.name: joint for joint in m.joints if isinstance(joint, Single)}
    for part in m.parts:
        where = part.title
        touching = isinstance(part, ContactBase | Contact)
        ends = (part.body, part.on) if touching else part.bodies
        yield from (f"{where}: {name!r} is no body" for name in ends if name not in bodies)
        for name, kind in _seats(part).items():
            joint = joints.get(name)
            if kind and (joint is None or joint.noun != kind):
                yield f"{where}: expected the name of a {kind}, got {name!r}"
            elif joint is None:
                yield f"{where}: {name!r} is no joint with one coordinate"
        if isinstance(part, Loop) and part.body_a == part.body_b:
            yield f"{where} joins body {part.body_a!r} to itself"
        if touching and part.body == part.on:
            yield f"{where}: body {part.body!r} touches itself"
    pressing = {switch.name for switch in m.switching if not isinstance(switch, Friction)}
    for switch in m.switching:
        if switch.pressed_by is not None and switch.pressed_by not in pressing:
            yield f"{switch.title}: {switch.pressed_by!r}, its load, is no contact or stop"


def _seats(part: MechanismPart) -> Mapping[str, str]:
    """The joints that a part acts in, each a "hinge" or "slide" if no other will do."""
    match part:
        case JointLoad():
            return dict.fromkeys(part.joints, "")
        case Gear() | Rack():
            return {part.wheel: "hinge", part.other: "hinge" if isinstance(part, Gear) else "slide"}
        case SwitchingElement():
            kind = "slide" if list_cord_runs(part) else ""
            return {joint: kind for row in part.joint_rows for joint, _ in row.weights}
    return {}


def _velocity_constraints(m: Description) -> Iterator[str]:
    of_quaternions = {name for j in m.joints if j.quaternion for name in j.coordinates}
    plain_ones = [name for name in m.coordinates.names if name not in of_quaternions]
    known = {*plain_ones, *(p.symbol for p in m.parameters), "t"}
    sound = bool(m.velocity_constraints)
    for constraint in m.velocity_constraints:
        where = f"velocity constraint {constraint.name!r}"
        symbols = {symbol for scalar in constraint.scalars for symbol in symbols_in(scalar)}
        unknown = sorted(({*constraint.terms} - {*m.velocities, *plain_ones}) | (symbols - known))
        if unknown or not constraint.terms:
            sound = False
            fault = (
                f"depends on {', '.join(map(repr, unknown))}, no coordinate or parameter"
                if unknown
                else "is empty"
            )
            yield f"{where} {fault}"
    if not sound:
        return
    rates = {f"{name}'" for name in plain_ones}
    used = {name for c in m.velocity_constraints for name in c.terms}
    values = {p.symbol: p.value for p in m.parameters}
    # of quasi-velocities no position is the integral
    if used <= {*plain_ones, *rates} and is_integrable(m.velocity_constraints, plain_ones, values):
        names = ", ".join(repr(constraint.name) for constraint in m.velocity_constraints)
        yield (
            f"velocity constraint {names} is the rate of a constraint on positions; "
            "state that one instead, by the coordinate map or a loop, and the number of "
            "coordinates falls"
        )


def faults(mechanism: Description) -> list[str]:
    """Return every fault of a mechanism, one sentence each."""
    sentences = [*_names(mechanism), *_symbols(mechanism)]
    sentences += [*_tree(mechanism)]
    sentences += [*_joints(mechanism), *_parts(mechanism), *_velocity_constraints(mechanism)]
    # values can be judged only when every symbol is known
    return sentences or [
        *find_mismatches(mechanism),
        *_bodies(mechanism),
        *find_broken(rules_of(mechanism), mechanism.values),
    ]


def inertia_fault(mass: float, inertia: Iterable[float], *, real: bool = True) -> str | None:
    """Return what is physically wrong with a mass and an inertia about its center, or None.

    Units: mass [kg], inertia [kg·m²].
    """
    ixx, iyy, izz, ixy, ixz, iyz = inertia
    if not all(map(math.isfinite, (mass, ixx, iyy, izz, ixy, ixz, iyz))):
        return "its mass or inertia is not finite"
    if mass < 0:
        return MASS.format(f"{mass:g}")
    if not real:
        return None
    principal = np.linalg.eigvalsh([[ixx, ixy, ixz], [ixy, iyy, iyz], [ixz, iyz, izz]])
    # relative rounding, and moments of a body a ten-millionth of a meter wide
    slack = 1e-9 * max(abs(principal)) + 1e-14 * mass
    if principal[0] < -slack:
        return MOMENT.format(f"{principal[0]:g}")
    if principal[0] + principal[1] < principal[2] - slack:
        return TRIANGLE.format(*(f"{moment:g}" for moment in principal))
    return None


def _names(m: Description) -> Iterator[str]:
    driven = m.coordinates.driven
    kinds: dict[str, list[str]] = {
        "body": [body.name for body in m.bodies],
        "joint": [joint.name for joint in m.joints],
        "force": [force.name for force in m.forces],
        "loop or contact": [
            closing.name for closing in (*m.loops, *m.contacts, *m.velocity_constraints)
        ],
        "element": [element.name for element in (*m.elements, *m.switching)],
        "parameter or input": [p.symbol for p in m.parameters] + [i.symbol for i in m.inputs],
        "coordinate": [*m.coordinates.names, *driven],
    }
    joint_coordinates = [name for joint in m.joints for name in joint.coordinates]
    if not m.name.strip():
        yield "the mechanism has no name"
    for kind, names in kinds.items():
        for name, count in Counter(names).items():
            if not isinstance(name, str) or not name.strip():
                yield f"a {kind} has no name"
            elif not name.isprintable():
                yield f"{kind} {name!r} has unprintable characters in its name"
            if count > 1 and not (kind == "coordinate" and name in driven):
                yield f"{kind} {name!r} is there {count} times"
    for name, count in Counter(joint_coordinates).items():
        if count > 1:
            yield f"coordinate {name!r} belongs to {count} joints"
    of_joints = set(joint_coordinates)
    of_quaternions = {name for j in m.joints if j.quaternion for name in j.coordinates}
    for name in driven:
        if name not in of_joints:
            yield f"the coordinate map sets {name!r}, which is no joint coordinate"
        elif name in of_quaternions:
            yield f"the coordinate map sets {name!r}, but a quaternion's joint cannot be driven"
    moved = set(joint_coordinates).union(*(symbols_in(scalar) for scalar in driven.values()))
    for name in m.coordinates.names:
        if name in driven:
            yield f"{name!r} is both a generalized coordinate and set by the coordinate map"
        elif name not in moved:
            yield (
                f"coordinate {name!r} moves nothing: no joint has it, and the coordinate map "
                "does not depend on it"
            )
    for joint in m.joints:
        if joint.quaternion and of_quaternions <= {*m.coordinates.names}:
            start, together = m.coordinates.names.index(joint.coordinates[0]), joint.coordinates
            if m.coordinates.names[start : start + len(together)] != together:
                order = ", ".join(together)
                yield f"the coordinates of joint {joint.name!r} must follow one another: {order}"
    clash = {*m.coordinates.names} & {
        *(p.symbol for p in m.parameters),
        *(i.symbol for i in m.inputs),
        "t",
    }
    for name in sorted(clash):
        yield f"{name!r} is both a coordinate and a parameter, an input or time"


def _symbols(m: Description) -> Iterator[str]:
    constants = {p.symbol for p in m.parameters}
    moving = constants | {i.symbol for i in m.inputs} | {*m.coordinates.names, "t"}
    everything = moving | set(m.velocities)
    for body in m.bodies:
        for shape in body.shapes:
            parts = (
                ("mass", (shape.mass,)),
                ("center of mass", shape.center),
                ("inertia", shape.inertia),
            )
            for what, moments in parts:
                used = frozenset[str]().union(*map(symbols_in, moments))
                varying = everything & used - constants
                for name in sorted(varying):
                    cause = "time" if name == "t" else f"{name!r}, which varies"
                    yield f"body {body.name!r}: its {what} cannot depend on {cause}"
                yield from _unknown(f"body {body.name!r}", moments, constants | varying)
    for joint in m.joints:
        yield from _unknown(
            f"joint {joint.name!r}", (*joint.origin.xyz, *joint.origin.rpy), constants
        )
        if isinstance(joint, Single):
            yield from _unknown(f"joint {joint.name!r}", (joint.armature,), constants)
    for name, expression in m.coordinates.driven.items():
        yield from _unknown(f"the map of coordinate {name!r}", (expression,), moving)
    for name, limits in m.coordinates.intervals.items():
        if name not in m.coordinates.names:
            yield f"the limits of {name!r}, which is no generalized coordinate"
        yield from _unknown(f"the limits of coordinate {name!r}", limits, constants)
    for signal in m.inputs:
        for name in sorted(signal.symbols - constants - {"t"}):
            yield f"input {signal.symbol!r} depends on {name!r}, which is no parameter"
    for part in m.parts:
        for varies, known in ((False, constants), (True, everything)):
            its = [s for s in part.stated if s.varies == varies and not s.stores]
            yield from _unknown(part.title, [x for s in its for x in s.scalars], known)
    for force in m.forces:
        for stated in force.stated:
            if stated.stores:
                yield from _potential(m, force, stated.scalars[0], constants, everything)
    yield from _unknown("gravity", m.gravity, constants)


def _potential(
    m: Description, force: AnyForce, V: Scalar, constants: set[str], everything: set[str]
) -> Iterator[str]:
    """Yield why a potential is no function of its coordinates, time and parameters."""
    where = f"force {force.name!r}"
    its, named, what = {DISTANCE}, "distance()", "the distance of its ends"
    if isinstance(force, FieldLoad):
        its, named, what = {*POSITION}, "position()", "where its point is"
    if isinstance(force, JointLoad):
        its = {name for j in m.joints if j.name in force.joints for name in j.coordinates}
        named = " and ".join(map(repr, sorted(its))) or "the joint's coordinate"
    else:
        for name in sorted(its & everything):
            yield f"{where}: {name!r} is {what}; rename what is called so"
    its |= {"t"}
    varying = symbols_in(V) & (everything - constants) - its
    for name in sorted(varying):
        yield (
            f"{where}: its potential is to depend on {named}, time and parameters alone, "
            f"got {name!r}; what varies otherwise is a load"
        )
    yield from _unknown(where, (V,), constants | its | varying)
    for step in _functions(plain(V)):
        if type(step).__name__ == "sign" and symbols_in(step) - constants - {"t"}:
            yield (
                f"{where}: its potential holds {step}, whose slope at zero is no force; write "
                "x sign(x) as abs(x), or state the force as a load"
            )


def _unknown(where: str, scalars: Iterable[Scalar], known: set[str]) -> Iterator[str]:
    scalars = [plain(scalar) for scalar in scalars]
    for name in sorted(frozenset().union(*map(symbols_in, scalars)) - known):
        names = ", ".join(sorted(known)) or "none"
        yield f"{where} depends on {name!r}, which is not declared (known: {names})"
    from_sympy = [scalar for scalar in scalars if not isinstance(scalar, float)]
    for name in sorted(
        {type(f).__name__ for s in from_sympy for f in _functions(s)} - {*FUNCTIONS}
    ):
        yield f"{where} holds the function {name}; expected {', '.join(FUNCTIONS)}"


def _functions(scalar: Scalar) -> Iterator[Scalar]:
    if getattr(scalar, "is_Function", False):
        yield scalar
    for part in getattr(scalar, "args", ()):
        yield from _functions(part)


def _tree(m: Description) -> Iterator[str]:
    bodies = {body.name for body in m.bodies}
    if m.ground not in bodies:
        names = ", ".join(sorted(map(str, bodies))) or "none"
        yield f"the ground {m.ground!r} is no body (bodies: {names})"
    carried = Counter(joint.child for joint in m.joints)
    for joint in m.joints:
        for role, name in (("parent", joint.parent), ("child", joint.child)):
            if name not in bodies:
                yield f"joint {joint.name!r}: its {role} {name!r} is no body"
        if joint.parent == joint.child:
            yield f"joint {joint.name!r} joins body {joint.child!r} to itself"
    for name, count in carried.items():
        if name == m.ground:
            yield f"the ground {name!r} is the child of a joint"
        elif count > 1:
            yield (
                f"body {name!r} is the child of {count} joints; close loops by a loop constraint, "
                "not by a joint"
            )
    children: dict[str, list[str]] = {}
    for joint in m.joints:
        children.setdefault(joint.parent, []).append(joint.child)
    reached, waiting = {m.ground}, [m.ground]
    while waiting:
        more = [child for child in children.get(waiting.pop(), ()) if child not in reached]
        reached.update(more)
        waiting.extend(more)
    for name in sorted(bodies - reached):
        yield f"body {name!r} is not connected to the ground {m.ground!r}"


def _joints(m: Description) -> Iterator[str]:
    for joint in m.joints:
        where = f"joint {joint.name!r}"
        if isinstance(joint, (Single, Planar)):
            length = math.sqrt(sum(component**2 for component in joint.axis))
            if not abs(length - 1) < 1e-9:
                yield f"{where}: expected an axis with a finite length, got {joint.axis}"
        if isinstance(joint, Single) and joint.limits is not None:
            limits = joint.limits
            if not limits.lower <= limits.upper:
                yield (
                    f"{where}: its lower limit {limits.lower:g} is not below its upper "
                    f"{limits.upper:g}"
                )
            if not (limits.effort >= 0 and limits.velocity >= 0):
                yield f"{where}: its limits of effort and velocity must not be negative"


def _bodies(m: Description) -> Iterator[str]:
    for body in m.bodies:
        try:
            fault = inertia_fault(
                float(evaluate(body.mass, m.values)),
                [float(evaluate(i, m.values)) for i in body.inertia],
                real=not body.as_given,
            )
            center = [float(evaluate(c, m.values)) for c in body.center]
        except (MecaniqueError, ArithmeticError, TypeError) as error:
            yield f"body {body.name!r}: its mass cannot be computed ({error})"
            continue
        if fault:
            yield f"body {body.name!r}: {fault}"
        if not all(map(math.isfinite, center)):
            yield f"body {body.name!r}: its center of mass is not finite"
