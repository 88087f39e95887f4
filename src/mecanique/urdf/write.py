"""Write a mechanism as URDF text."""

from __future__ import annotations

import math
import os
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Literal, TypeAlias, final

import numpy as np

from mecanique.arrays import Array
from mecanique.errors import InputError, UrdfError
from mecanique.files import write_whole
from mecanique.model.bodies import Body
from mecanique.model.bodies.visuals import (
    Geometry,
    GeometryKind,
    Mesh,
    Rgba,
    Visual,
    measure,
)
from mecanique.model.constraints.loops import Loop
from mecanique.model.expression import Scalar, Vector, plain, symbols_in
from mecanique.model.force_base import BodyLoad, JointLoad, LineLoad, loads_in
from mecanique.model.forces import (
    CentralForce,
    Damper,
    JointDamper,
    JointForce,
    JointSpring,
    Potential,
    PotentialField,
    Spring,
)
from mecanique.model.joint_base import Limits, Single
from mecanique.model.joints import Helical, Joint
from mecanique.model.mechanism import Mechanism
from mecanique.model.placement import Placement, rpy_of, rpy_rotation
from mecanique.urdf.dialect import (
    ACTUATOR_GEAR,
    ACTUATOR_INERTIA,
    BALL_CONSTRAINT,
    BUSHING,
    DISTANCE_CONSTRAINT,
    DRAKE_JOINT,
    DRAKE_NAMESPACE,
    IN_DRAKE,
    NAMESPACE,
    SCREW,
    SPRING_DAMPER,
    UNBOUNDED,
    WORLD,
)
from mecanique.urdf.markup import Comment, Node, Tag, number, numbers, write_xml
from mecanique.urdf.reading.native_tags import write_native

_KNOWN_COLORS: dict[Rgba, str] = {
    (0.0, 0.447, 0.698, 1.0): "blue",
    (0.902, 0.624, 0.0, 1.0): "orange",
}


def write_urdf(
    mechanism: Mechanism,
    path: str | os.PathLike[str] | None = None,
    *,
    spherical: Literal["ball", "floating"] = "ball",
) -> str:
    """Return a mechanism as URDF text, and write it to a file if one is named.

    The text is URDF 1.0 and says in comments what the format has no words for: parameters, gravity,
    the coordinate map, loads and inputs. What only Drake reads stands in `drake:` tags:

    - the ground is welded to a link `world`, unless a body has that name, so that Drake fixes it
      too; where springs or loops end at a body of that name, they end at a link welded to it,
      because Drake looks for none on the world;
    - springs and dampers between points become `drake:linear_spring_damper`. Drake demands a free
      length above zero, so a spring without length is a comment with its exact values;
    - a spring in a joint becomes a `drake:linear_bushing_rpy` along or about the joint's axis, the
      same force as long as a hinge stays within half a turn of the spring's reference;
    - the armature of a joint becomes the rotor inertia of an actuator with gear ratio 1;
    - a ball loop becomes a `drake:ball_constraint`, a rod a `drake:distance_constraint`;
    - potentials become `mecanique:potential`, `mecanique:central_force` and
      `mecanique:potential_field`;
    - other loops become `mecanique:loop`, what rolls `mecanique:rolling`, a blade `mecanique:blade`
      and a cord `mecanique:cord`, as `mecanique.urdf.reading.native_tags` describes them; friction,
      stops and contacts that open become `mecanique:friction`, `mecanique:stop` and
      `mecanique:contact`. Other programs ignore these, so their loops are open and their wheels
      slip.

    A joint that follows one other joint linearly gets a `mimic`; other maps are comments, and the
    tree is written as if it were free. Planar and universal joints become slides and hinges with
    massless links between them, in the order of their coordinates; a screw becomes a slide that
    mimics a hinge, and `mecanique:screw` in it. Numbers are written so that they
    are read back exactly.

    Args:
        mechanism: what to write.
        path: of the file; it is replaced as a whole or not at all.
        spherical: what a `Spherical` joint becomes: "ball", the exact joint, which only Drake reads
            (`drake:joint`), or "floating", which every program reads but which leaves the
            translation free.

    Returns:
        The text, whether written or not.

    Raises:
        UrdfError: if a number is not finite, a coefficient of friction varies or the file cannot
            be written.
        UnknownNameError: if a visual depends on a symbol that is no parameter.

    Example:
        >>> mq.write_urdf(mq.textbook.load('rigid_bar_pendulum')).splitlines()[0]
        '<?xml version="1.0"?>'
    """
    links = chains(mechanism, spherical)
    prefixes = {"xmlns:drake": DRAKE_NAMESPACE}
    if _has_native_tags(mechanism):
        prefixes["xmlns:mecanique"] = NAMESPACE
    written = write_xml(Tag("robot", *_robot(mechanism, links), name=mechanism.name, **prefixes))
    if path is not None:
        try:
            with write_whole(Path(path)) as file:
                file.write(written.encode())
        except (OSError, ValueError) as error:
            raise UrdfError(f"cannot be written ({error})", file=str(path)) from None
    return written


def _has_native_tags(mechanism: Mechanism) -> bool:
    """Return whether a mechanism has anything for which neither URDF nor Drake has a tag."""
    return bool(
        any(isinstance(joint, Helical) for joint in mechanism.joints)
        or any(
            isinstance(force, Potential | CentralForce | PotentialField)
            for force in mechanism.forces
        )
        or any(loop.kind not in IN_DRAKE for loop in mechanism.loops)
        or (mechanism.elements or mechanism.rolls or mechanism.switching)
    )


def _robot(mechanism: Mechanism, links: dict[str, tuple[SimpleJoint, ...]]) -> Iterator[Node]:
    yield Comment(*_preface(mechanism))
    colors = _colors(mechanism)
    for rgba, name in colors.items():
        yield Tag("material", Tag("color", rgba=numbers(rgba, f"color {name}")), name=name)
    taken = {body.name for body in mechanism.bodies}
    steps = [step for chain in links.values() for step in chain]
    anchor = ""
    if WORLD not in taken:
        yield Tag("link", name=WORLD)
        yield _weld(WORLD, mechanism.ground, steps)
    elif WORLD in ends_of_tags(mechanism):
        anchor = free_name(f"{WORLD}_anchor", taken | {step.child for step in steps})
        yield Tag("link", name=anchor)
        yield _weld(WORLD, anchor, steps)
    for body in mechanism.bodies:
        yield _link(mechanism, body, colors)
    for joint in mechanism.joints:
        chain = links[joint.name]
        if len(chain) > 1:
            yield Comment(
                f"{type(joint).__name__.lower()} joint {joint.name}, "
                f"coordinates {', '.join(joint.coordinates)}"
            )
        for step in chain[:-1]:
            yield Tag("link", name=step.child)
        for step in chain:
            yield _joint(mechanism, joint, step)
    yield from _actuators(mechanism)
    anchors = {WORLD: anchor} if anchor else {}
    mimicked = all(any(_mimic(mechanism, name)) for name in mechanism.coordinates.driven)
    yield from forces_and_loops(mechanism, anchors, mimicked=mimicked)


def _weld(parent: str, child: str, steps: Iterable[SimpleJoint]) -> Tag:
    name = free_name(f"{parent}_to_{child}", (step.name for step in steps))
    return Tag(
        "joint", Tag("parent", link=parent), Tag("child", link=child), name=name, type="fixed"
    )


def _preface(mechanism: Mechanism) -> Iterator[str]:
    yield f"{mechanism.name}, written by mecanique; SI units, angles in radians"
    for parameter in mechanism.parameters:
        meaning = f": {parameter.meaning}" if parameter.meaning else ""
        unit = "" if parameter.unit in ("", "1") else f" {parameter.unit}"
        yield f"{parameter.symbol} = {number(parameter.value, parameter.symbol)}{unit}{meaning}"
    gravity = numbers(mechanism.evaluate_all(mechanism.gravity), "gravity")
    yield f"gravity along x, y, z: {gravity} m/s² (not part of URDF)"
    if mechanism.coordinates.driven:
        names = ", ".join(mechanism.coordinates)
        yield f"generalized coordinates: {names}; what follows them (not part of URDF):"
        yield from (
            f"{name} = {expression}" for name, expression in mechanism.coordinates.driven.items()
        )
    loads = [*load_lines(mechanism)]
    if loads:
        yield "loads (not part of URDF):"
    yield from loads
    for signal in mechanism.inputs:
        given = "a function of t" if callable(signal.signal) else format_scalars(signal.signal)
        unit = "" if signal.unit in ("", "1") else f" [{signal.unit}]"
        meaning = f": {signal.meaning}" if signal.meaning else ""
        yield f"{signal.symbol} = {given}{unit}{meaning}"


def _link(mechanism: Mechanism, body: Body, colors: dict[Rgba, str]) -> Tag:
    where = f"body {body.name!r}"
    children: list[Node] = []
    mass = mechanism.evaluate(body.mass)
    inertia = mechanism.evaluate_all(body.inertia)
    if mass or any(inertia):
        ixx, iyy, izz, ixy, ixz, iyz = (number(entry, where) for entry in inertia)
        center = numbers(mechanism.evaluate_all(body.center), where)
        children.append(
            Tag(
                "inertial",
                Tag("origin", xyz=center, rpy="0 0 0"),
                Tag("mass", value=number(mass, where)),
                Tag("inertia", ixx=ixx, ixy=ixy, ixz=ixz, iyy=iyy, iyz=iyz, izz=izz),
            )
        )
    children += [_visual(mechanism, visual, where, colors) for visual in body.visuals]
    return Tag("link", *children, name=body.name)


def _visual(mechanism: Mechanism, visual: Visual, where: str, colors: dict[Rgba, str]) -> Tag:
    what = f"a visual of {where}"
    kind, measures = measure_in_words(mechanism, visual.geometry, what)
    file = {"filename": visual.geometry.uri} if isinstance(visual.geometry, Mesh) else {}
    shape = Tag(kind, **file, **measures)
    children: list[Node] = [*_origin(mechanism, visual.placement, what), Tag("geometry", shape)]
    if visual.rgba is not None:
        children.append(Tag("material", name=colors[visual.rgba]))
    return Tag("visual", *children, **({"name": visual.name} if visual.name else {}))


def measure_in_words(
    mechanism: Mechanism, geometry: Geometry, what: str
) -> tuple[GeometryKind, dict[str, str]]:
    """Return what a geometry is, and its sizes by the names that URDF and SDF have for them."""
    kind, sizes = measure(geometry)
    names = {"box": ["size"], "cylinder": ["radius", "length"], "sphere": ["radius"]}
    values = mechanism.evaluate_all(sizes)
    rows = [values] if len(values) == 3 else [[value] for value in values]
    words = (numbers(row, what) for row in rows)
    return kind, dict(zip(names.get(kind, ["scale"]), words, strict=True))


def _joint(mechanism: Mechanism, joint: Joint, step: SimpleJoint) -> Tag:
    where = f"joint {step.name!r}"
    place = Placement(step.xyz, step.rpy)
    children: list[Node] = [
        Tag("parent", link=step.parent),
        Tag("child", link=step.child),
        *_origin(mechanism, place, where),
    ]
    if step.axis is not None:
        children.append(Tag("axis", xyz=numbers(step.axis, where)))
    children += _limit(step, where)
    if isinstance(joint, Single):
        children += dynamics(mechanism, joint.name, where) if step.name == joint.name else ()
    children += _mimic(mechanism, step.coordinate or "")
    if isinstance(joint, Helical) and step.name != joint.name:
        children.append(Tag(SCREW))
    if step.kind == "ball":
        return Tag(DRAKE_JOINT, *children, name=step.name, type="ball")
    return Tag("joint", *children, name=step.name, type=step.kind)


def _limit(step: SimpleJoint, where: str) -> Iterator[Tag]:
    """URDF demands limits for slides and bounded hinges, each with effort and velocity."""
    limits = step.limits or Limits()
    bounds = {"lower": limits.lower, "upper": limits.upper}
    if step.kind == "continuous":
        bounds = {}
        if limits.effort >= UNBOUNDED and limits.velocity >= UNBOUNDED:
            return
    if step.kind in ("continuous", "revolute", "prismatic"):
        bounds |= {"effort": limits.effort, "velocity": limits.velocity}
        clipped = {name: min(max(x, -UNBOUNDED), UNBOUNDED) for name, x in bounds.items()}
        yield Tag("limit", **{name: number(x, where) for name, x in clipped.items()})


def axial_steps(mechanism: Mechanism) -> dict[str, str]:
    """Return the simple joint of each coordinate along or about an axis, by name."""
    steps = (step for chain in chains(mechanism).values() for step in chain)
    return {step.coordinate: step.name for step in steps if step.coordinate is not None}


def law_of_follower(
    mechanism: Mechanism, steps: Mapping[str, str], coordinate: str, degree: int
) -> tuple[str, list[float]] | None:
    """Return the simple joint that another follows, and the factors of its powers from the zeroth.

    The name is empty where nothing is followed; None is returned unless the law is a polynomial of
    one free joint, of this degree at most.
    """
    driven = mechanism.coordinates.driven
    law = plain(driven[coordinate])
    leaders = symbols_in(law) - mechanism.values.keys()
    if coordinate not in steps or len(leaders) > 1 or not leaders <= steps.keys() - driven.keys():
        return None
    from sympy import Poly, PolynomialError, Symbol, sympify

    (leader,) = leaders or {""}
    try:
        law = Poly(sympify(law), Symbol(leader or "_"))
        factors = [mechanism.evaluate(factor) for factor in reversed(law.all_coeffs())]
    except (PolynomialError, TypeError, ValueError):
        return None
    if len(factors) > degree + 1:
        return None
    return steps.get(leader, ""), [*factors, *([0.0] * (degree + 1 - len(factors)))]


def _mimic(mechanism: Mechanism, coordinate: str) -> Iterator[Tag]:
    """A joint that follows one free joint linearly; comments state any other map."""
    if coordinate not in mechanism.coordinates.driven:
        return
    law = law_of_follower(mechanism, axial_steps(mechanism), coordinate, 1)
    if law is None or not law[0] or not law[1][1]:
        return
    leader, (offset, factor) = law
    where = f"the map of {coordinate!r}"
    multiplier = number(factor, where)
    yield Tag("mimic", joint=leader, multiplier=multiplier, offset=number(offset, where))


def _actuators(mechanism: Mechanism) -> Iterator[Tag]:
    for joint in mechanism.joints:
        if not isinstance(joint, Single):
            continue
        inertia = mechanism.evaluate(joint.armature)
        if not inertia:
            continue
        yield Tag(
            "transmission",
            Tag("type", content="transmission_interface/SimpleTransmission"),
            Tag("joint", name=joint.name),
            Tag(
                "actuator",
                Tag(ACTUATOR_INERTIA, value=number(inertia, f"joint {joint.name!r}")),
                Tag(ACTUATOR_GEAR, value="1"),
                name=f"{joint.name}_drive",
            ),
            name=f"{joint.name}_transmission",
        )


def _origin(mechanism: Mechanism, place: Placement, where: str) -> Iterator[Tag]:
    xyz, rpy = mechanism.evaluate_all(place.xyz), mechanism.evaluate_all(place.rpy)
    if any(xyz) or any(rpy):
        yield Tag("origin", xyz=numbers(xyz, where), rpy=numbers(rpy, where))


def _colors(mechanism: Mechanism) -> dict[Rgba, str]:
    colors: dict[Rgba, str] = {}
    for body in mechanism.bodies:
        for visual in body.visuals:
            if visual.rgba is not None and visual.rgba not in colors:
                colors[visual.rgba] = _KNOWN_COLORS.get(visual.rgba, f"color{len(colors) + 1}")
    return colors


Kind: TypeAlias = Literal["fixed", "continuous", "revolute", "prismatic", "floating", "ball"]


@final
@dataclass(frozen=True)
class SimpleJoint:
    """A joint of URDF."""

    name: str
    kind: Kind  # its type; "ball" for the type that only Drake has
    parent: str
    child: str
    coordinate: str | None = None  # name of its coordinate, if it has one alone
    xyz: tuple[float, float, float] = (0.0, 0.0, 0.0)  # of its frame in the parent [m]
    rpy: tuple[float, float, float] = (0.0, 0.0, 0.0)  # of its frame in the parent [rad]
    axis: tuple[float, float, float] | None = None
    limits: Limits | None = None


def chains(
    mechanism: Mechanism, spherical: Literal["ball", "floating"] = "ball"
) -> dict[str, tuple[SimpleJoint, ...]]:
    """Return the simple joints of each joint, by its name; the last has its name and child."""
    if spherical not in ("ball", "floating"):
        raise InputError(f"expected 'ball' or 'floating' for a spherical joint, got {spherical!r}")
    joints = {joint.name for joint in mechanism.joints}
    links = {body.name for body in mechanism.bodies}
    return {
        joint.name: tuple(_chain(mechanism, joint, spherical, joints, links))
        for joint in mechanism.joints
    }


def free_name(name: str, taken: Iterable[str]) -> str:
    """Return the name, with underscores behind it until it is none of those taken."""
    taken = set(taken)
    while name in taken:
        name += "_"
    return name


def _chain(
    mechanism: Mechanism,
    joint: Joint,
    spherical: Literal["ball", "floating"],
    joints: set[str],
    links: set[str],
) -> list[SimpleJoint]:
    types: dict[str, Kind] = {
        "fixed": "fixed",
        "turn": "continuous",
        "slide": "prismatic",
        "ball": spherical,
        "free": "floating",
    }
    chain: list[SimpleJoint] = []
    parent = joint.parent
    for motion in joint.chain:
        name, child, kind = joint.name, joint.child, types[motion.kind]
        axis = motion.axis if kind in ("continuous", "prismatic") else None
        limits = None
        if motion.part:
            name = free_name(f"{name}_{motion.part}", joints)
            child = free_name(f"{child}_{motion.part}", links)
            joints.add(name)
            links.add(child)
        elif isinstance(joint, Single):
            limits = joint.limits
            if kind == "continuous" and limits is not None and limits.bounded:
                kind = "revolute"
        coordinate = motion.coordinates[0] if axis is not None else None
        chain.append(SimpleJoint(name, kind, parent, child, coordinate, axis=axis, limits=limits))
        parent = child
    place = joint.origin
    x, y, z = mechanism.evaluate_all(place.xyz)
    roll, pitch, yaw = mechanism.evaluate_all(place.rpy)
    chain[0] = replace(chain[0], xyz=(x, y, z), rpy=(roll, pitch, yaw))
    return chain


def ends_of_tags(mechanism: Mechanism) -> set[str]:
    """Return the names of the bodies at which a spring, a damper, a loop or a cord ends."""
    ends: set[str] = set()
    for force in mechanism.forces:
        if isinstance(force, LineLoad):
            ends.update(force.bodies)
        elif isinstance(force, JointSpring):
            joint = mechanism.joint(force.joint)
            ends |= {joint.parent, joint.child}
    for part in (*mechanism.loops, *mechanism.elements, *mechanism.switching):
        ends |= {*part.bodies}
    for contact in mechanism.contacts:
        ends |= {contact.body, contact.on}
    return ends


def forces_and_loops(
    mechanism: Mechanism, anchors: Mapping[str, str], *, mimicked: bool
) -> Iterator[Node]:
    """Give the tags of springs, dampers, loops and cords, each after a comment with its name."""
    for force in mechanism.forces:
        match force:
            case Spring():
                yield from _spring(mechanism, force, anchors)
            case Damper():
                yield Comment(f"damper {force.name}")
                constants = {
                    "free_length": 1.0,
                    "stiffness": 0.0,
                    "damping": mechanism.evaluate(force.damping),
                }
                yield _between(mechanism, force, anchors, constants)
            case JointSpring():
                yield from _joint_spring(mechanism, force, anchors)
            case Potential() | CentralForce() | PotentialField():
                yield from write_native(mechanism, force, anchors)
            case JointDamper() | BodyLoad() | JointForce():
                pass  # written by `dynamics` and `load_lines`
            case _:
                yield Comment(f"{force.kind} {force.name}: URDF has no tag for it")
    for loop in mechanism.loops:
        yield from _loop(mechanism, loop, anchors)
    for thing in (*mechanism.contacts, *mechanism.velocity_constraints):
        yield from write_native(mechanism, thing, anchors)
    for element in mechanism.elements:
        if isinstance(element, Loop) and not mimicked:
            yield from _loop(mechanism, element, anchors)
        else:
            yield from write_native(mechanism, element, anchors, redundant=mimicked)
    for switch in mechanism.switching:
        yield from write_native(mechanism, switch, anchors)


def _loop(mechanism: Mechanism, loop: Loop, anchors: Mapping[str, str]) -> Iterator[Node]:
    """Yield the element of a loop, Drake's if it has one for the kind."""
    if loop.kind not in IN_DRAKE:
        yield from write_native(mechanism, loop, anchors)
        return
    where = f"loop {loop.name!r}"
    ends = (loop.body_a, loop.frame_a.xyz), (loop.body_b, loop.frame_b.xyz)
    contents = _two_points(mechanism, ends, anchors, where)
    if loop.kind == "ball":
        yield Comment(f"ball loop {loop.name}")
        yield BALL_CONSTRAINT.write(contents)
        return
    length = number(mechanism.evaluate(loop.length), where)
    yield Comment(f"distance loop {loop.name}, length {length} m; Drake keeps it by a stiff spring")
    stiff = {"distance": length, "stiffness": number(UNBOUNDED, where), "damping": "0"}
    yield DISTANCE_CONSTRAINT.write({**contents, **stiff})


def _two_points(
    mechanism: Mechanism,
    ends: Iterable[tuple[str, Vector]],
    anchors: Mapping[str, str],
    where: str,
) -> dict[str, str]:
    """Return the contents of a tag of Drake's that name two points."""
    contents = {}
    for side, (body, point) in zip("ab", ends, strict=True):
        contents[f"body_{side}"] = anchors.get(body, body)
        contents[f"point_{side}"] = numbers(mechanism.evaluate_all(point), where)
    return contents


def dynamics(mechanism: Mechanism, joint: str, where: str) -> Iterator[Tag]:
    """Yield the element with a joint's damping, if it has any."""
    dampers = loads_in(mechanism.forces, joint, "damper")
    if dampers:
        damping = sum(mechanism.evaluate(damper.coefficient) for damper in dampers)
        yield Tag("dynamics", damping=number(damping, where))


def load_lines(mechanism: Mechanism) -> Iterator[str]:
    """Describe, in a line each, loads and drives that URDF cannot express."""
    for force in mechanism.forces:
        if isinstance(force, BodyLoad):
            wrench = force.wrench
            body, axes = wrench.body, f"axes of {wrench.axes}"
            if wrench.force is not None:
                at = f"{body} at ({format_scalars(*wrench.point)})"
                yield f"{force.name}: force ({format_scalars(*wrench.force)}) N on {at}, {axes}"
            if wrench.torque is not None:
                torque = format_scalars(*wrench.torque)
                yield f"{force.name}: torque ({torque}) N·m on {body}, {axes}"
        elif isinstance(force, JointLoad) and force.kind == "load":
            drive = format_scalars(force.coefficient)
            yield f"{force.name}: {drive} on the child of joint {' and '.join(force.joints)}"


def format_scalars(*scalars: Scalar) -> str:
    """Return scalars as text that reads back to the same numbers."""
    return ", ".join(number(s, "a load") if isinstance(s, float) else str(s) for s in scalars)


def _spring(mechanism: Mechanism, spring: Spring, anchors: Mapping[str, str]) -> Iterator[Node]:
    stiffness, free = mechanism.evaluate_all((spring.stiffness, spring.free_length))
    if free > 0:
        yield Comment(f"spring {spring.name}")
        constants = {"free_length": free, "stiffness": stiffness, "damping": 0.0}
        yield _between(mechanism, spring, anchors, constants)
        return
    where = f"spring {spring.name!r}"
    ends = (
        f"{end.body} ({numbers(mechanism.evaluate_all(end.point), where)})" for end in spring.ends
    )
    yield Comment(
        f"spring {spring.name}: {number(stiffness, spring.name)} N/m, free length 0, "
        f"from {' to '.join(ends)};",
        "no tag, because Drake demands a free length above zero",
    )


def _between(
    mechanism: Mechanism,
    force: LineLoad,
    anchors: Mapping[str, str],
    constants: Mapping[str, float],
) -> Tag:
    where = f"force {force.name!r}"
    ends = ((end.body, end.point) for end in force.ends)
    values = {role: number(value, where) for role, value in constants.items()}
    return SPRING_DAMPER.write({**_two_points(mechanism, ends, anchors, where), **values})


def _joint_spring(
    mechanism: Mechanism, spring: JointSpring, anchors: Mapping[str, str]
) -> Iterator[Node]:
    """A bushing between two frames with x along the joint's axis; A stands at the reference."""
    joint = mechanism.joint(spring.joint)
    if not isinstance(joint, Single):
        return
    where = f"spring {spring.name!r}"
    reference, stiffness = mechanism.evaluate_all((spring.reference, spring.stiffness))
    x, y, z = joint.axis
    # a rotation that takes x to the axis
    across = _turn((0.0, math.atan2(-z, math.hypot(x, y)), math.atan2(y, x)))
    origin = mechanism.evaluate_all(joint.origin.xyz)
    place = _turn(mechanism.evaluate_all(joint.origin.rpy))
    in_parent = place @ across
    if joint.turns:
        c, s = math.cos(reference), math.sin(reference)
        in_parent = in_parent @ np.array([[1.0, 0.0, 0.0], [0.0, c, -s], [0.0, s, c]])
        turning, pushing = (stiffness, 0.0, 0.0), (0.0, 0.0, 0.0)
        yield Comment(
            f"spring {spring.name}: {number(stiffness, where)} N·m/rad about joint {joint.name} "
            f"from {number(reference, where)} rad; the same within half a turn"
        )
    else:
        origin = (origin + reference * (place @ joint.axis)).tolist()
        turning, pushing = (0.0, 0.0, 0.0), (stiffness, 0.0, 0.0)
        yield Comment(
            f"spring {spring.name}: {number(stiffness, where)} N/m along joint {joint.name} "
            f"from {number(reference, where)} m"
        )
    frame_a, frame_c = f"{spring.name}_frame_A", f"{spring.name}_frame_C"
    for name, link, xyz, turn in (
        (frame_a, joint.parent, origin, in_parent),
        (frame_c, joint.child, (0.0, 0.0, 0.0), across),
    ):
        yield Tag(
            "frame",
            name=name,
            link=anchors.get(link, link),
            xyz=numbers(xyz, where),
            rpy=numbers(rpy_of(turn), where),
        )
    contents = {
        "frame_a": frame_a,
        "frame_c": frame_c,
        "torque_stiffness": numbers(turning, where),
        "torque_damping": "0 0 0",
        "force_stiffness": numbers(pushing, where),
        "force_damping": "0 0 0",
    }
    yield BUSHING.write(contents)


def _turn(rpy: Vector) -> Array:
    return np.array(rpy_rotation(rpy), dtype=float)
