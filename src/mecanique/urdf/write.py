"""Write a mechanism as URDF text."""

from __future__ import annotations

import os
from collections.abc import Iterable, Iterator
from pathlib import Path
from typing import Literal

from mecanique.errors import UrdfError
from mecanique.files import write_whole
from mecanique.model.bodies import Body
from mecanique.model.bodies.visuals import Box, Cylinder, Mesh, Rgba, Sphere, Visual
from mecanique.model.expression import plain, symbols_in
from mecanique.model.joint_base import Single
from mecanique.model.joints import Helical, Joint
from mecanique.model.mechanism import Mechanism
from mecanique.model.placement import Placement
from mecanique.urdf.dialect import (
    ACTUATOR_GEAR,
    ACTUATOR_INERTIA,
    DRAKE_JOINT,
    DRAKE_NAMESPACE,
    OWN_NAMESPACE,
    SCREW,
    UNBOUNDED,
    WORLD,
)
from mecanique.urdf.reading.constraints.loops import has_own_loops
from mecanique.urdf.writing.chains import SimpleJoint, chains, free_name
from mecanique.urdf.writing.forces import (
    dynamics,
    ends_of_tags,
    forces_and_loops,
    format_scalars,
    load_lines,
)
from mecanique.urdf.xml.markup import Comment, Node, Tag, number, numbers, text

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
    - other loops become `mecanique:loop`, what rolls `mecanique:rolling`, a blade `mecanique:blade`
      and a cord `mecanique:cord`, as `mecanique.urdf.reading.constraints` describes them; other
      programs ignore these, so their loops are open and their wheels slip.

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
        UrdfError: if a number is not finite or the file cannot be written.
        UnknownNameError: if a visual depends on a symbol that is no parameter.

    Example:
        >>> mq.write_urdf(mq.textbook.load('rigid_bar_pendulum')).splitlines()[0]
        '<?xml version="1.0"?>'
    """
    links = chains(mechanism, spherical)
    prefixes = {"xmlns:drake": DRAKE_NAMESPACE}
    has_screws = any(isinstance(joint, Helical) for joint in mechanism.joints)
    if has_screws or has_own_loops(mechanism) or mechanism.rolls:
        prefixes["xmlns:mecanique"] = OWN_NAMESPACE
    written = text(Tag("robot", *_robot(mechanism, links), name=mechanism.name, **prefixes))
    if path is not None:
        try:
            with write_whole(Path(path)) as file:
                file.write(written.encode())
        except (OSError, ValueError) as error:
            raise UrdfError(f"cannot be written ({error})", file=str(path)) from None
    return written


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
    shape: Tag
    what = f"a visual of {where}"
    match visual.geometry:
        case Box(size):
            shape = Tag("box", size=numbers(mechanism.evaluate_all(size), what))
        case Cylinder(radius, length):
            measures = {"radius": radius, "length": length}
            shape = Tag(
                "cylinder",
                **{key: number(mechanism.evaluate(m), what) for key, m in measures.items()},
            )
        case Sphere(radius):
            shape = Tag("sphere", radius=number(mechanism.evaluate(radius), what))
        case Mesh(uri, _, scale):
            shape = Tag("mesh", filename=uri, scale=numbers(scale, what))
    children: list[Node] = [*_origin(mechanism, visual.placement, what), Tag("geometry", shape)]
    if visual.rgba is not None:
        children.append(Tag("material", name=colors[visual.rgba]))
    return Tag("visual", *children, **({"name": visual.name} if visual.name else {}))


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
    if step.kind not in ("continuous", "revolute", "prismatic"):
        return
    bounds = step.limits
    given = (
        {}
        if bounds is None
        else {
            "lower": bounds.lower,
            "upper": bounds.upper,
            "effort": bounds.effort,
            "velocity": bounds.velocity,
        }
    )
    if step.kind == "continuous":
        wanted = [name for name in ("effort", "velocity") if given.get(name, UNBOUNDED) < UNBOUNDED]
        if not wanted:
            return
        wanted = ["effort", "velocity"]
    else:
        wanted = ["lower", "upper", "effort", "velocity"]
    attributes = {}
    for name in wanted:
        value = given.get(name, -UNBOUNDED if name == "lower" else UNBOUNDED)
        attributes[name] = number(min(max(value, -UNBOUNDED), UNBOUNDED), where)
    yield Tag("limit", **attributes)


def _mimic(mechanism: Mechanism, coordinate: str) -> Iterator[Tag]:
    """A joint that follows one free joint linearly; comments state any other map."""
    driven = mechanism.coordinates.driven
    if coordinate not in driven:
        return
    expression = plain(driven[coordinate])
    leaders = {
        other.coordinate: other.name
        for other in mechanism.joints
        if isinstance(other, Single) and other.coordinate not in driven
    }
    if not symbols_in(expression) - mechanism.values.keys() <= leaders.keys():
        return
    followed = symbols_in(expression) & leaders.keys()
    if len(followed) != 1:
        return
    from sympy import Symbol

    (leader,) = followed
    slope = expression.diff(Symbol(leader))
    if leader in symbols_in(slope):
        return
    factor = mechanism.evaluate(slope)
    offset = mechanism.evaluate(expression.subs(Symbol(leader), 0))
    where = f"the map of {coordinate!r}"
    yield Tag(
        "mimic",
        joint=leaders[leader],
        multiplier=number(factor, where),
        offset=number(offset, where),
    )


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
