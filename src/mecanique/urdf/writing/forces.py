"""Forces and loops as the tags Drake has for them; elsewhere a comment or a tag of our own."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping

from mecanique.model.expression import Scalar
from mecanique.model.force_base import BodyLoad, JointLoad, LineLoad, loads_in
from mecanique.model.forces import Damper, JointDamper, JointForce, JointSpring, Spring
from mecanique.model.joint_base import Single
from mecanique.model.mechanism import Mechanism
from mecanique.model.placement import Matrix3, rotate, rotation
from mecanique.urdf.dialect import BUSHING, SPRING_DAMPER, Extension
from mecanique.urdf.reading.constraints.contacts import contact_tag
from mecanique.urdf.reading.constraints.elements import element_nodes
from mecanique.urdf.reading.constraints.loops import loop_nodes
from mecanique.urdf.reading.constraints.velocities import constraint_node
from mecanique.urdf.xml.markup import Comment, Node, Tag, number, numbers


def ends_of_tags(mechanism: Mechanism) -> set[str]:
    """Return the names of the bodies at which a spring, a damper, a loop or a cord ends.

    Args:
        mechanism: whose forces and loops they are.
    """
    ends: set[str] = set()
    for force in mechanism.forces:
        if isinstance(force, LineLoad):
            ends.update(force.bodies)
        elif isinstance(force, JointSpring):
            joint = mechanism.joint(force.joint)
            ends |= {joint.parent, joint.child}
    for closure in (*mechanism.loops, *mechanism.elements):
        ends |= {*closure.bodies}
    for contact in mechanism.contacts:
        ends |= {contact.body, contact.on}
    return ends


def forces_and_loops(
    mechanism: Mechanism, anchors: Mapping[str, str], *, mimicked: bool
) -> Iterator[Node]:
    """Give the tags of springs, dampers, loops and cords, each after a comment with its name.

    Args:
        mechanism: whose forces and loops they are.
        anchors: body -> the link that stands for it in the tags.
        mimicked: whether mimic joints say all that the coordinate map does.
    """
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
            case JointDamper() | BodyLoad() | JointForce():
                pass  # written by `dynamics` and `load_lines`
            case _:
                yield Comment(f"{force.kind} {force.name}: URDF has no tag for it")
    for loop in mechanism.loops:
        yield from loop_nodes(mechanism, loop, anchors)
    for contact in mechanism.contacts:
        yield contact_tag(mechanism, contact, anchors)
    for constraint in mechanism.velocity_constraints:
        yield constraint_node(mechanism, constraint)
    yield from element_nodes(mechanism, anchors, mimicked=mimicked)


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
            yield f"{force.name}: {drive} on the child of joint {force.joint}"


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
    point_a, point_b = map(mechanism.evaluate_all, (force.point_a, force.point_b))
    contents = {
        "body_a": anchors.get(force.body_a, force.body_a),
        "point_a": numbers(point_a, where),
        "body_b": anchors.get(force.body_b, force.body_b),
        "point_b": numbers(point_b, where),
        **{role: number(value, where) for role, value in constants.items()},
    }
    return _extension(SPRING_DAMPER, contents)


def _joint_spring(
    mechanism: Mechanism, spring: JointSpring, anchors: Mapping[str, str]
) -> Iterator[Node]:
    """A bushing between two frames with x along the joint's axis; A stands at the reference."""
    joint = mechanism.joint(spring.joint)
    if not isinstance(joint, Single):
        return
    where = f"spring {spring.name!r}"
    reference, stiffness = mechanism.evaluate_all((spring.reference, spring.stiffness))
    across = _x_along(joint.axis)
    origin = mechanism.evaluate_all(joint.origin.xyz)
    place = rotation(mechanism.evaluate_all(joint.origin.rpy))
    in_parent = _product(place, across)
    if joint.turns:
        c, s = math.cos(reference), math.sin(reference)
        in_parent = _product(in_parent, ((1.0, 0.0, 0.0), (0.0, c, -s), (0.0, s, c)))
        turning, pushing = (stiffness, 0.0, 0.0), (0.0, 0.0, 0.0)
        yield Comment(
            f"spring {spring.name}: {number(stiffness, where)} N·m/rad about joint {joint.name} "
            f"from {number(reference, where)} rad; the same within half a turn"
        )
    else:
        axis = _times(place, joint.axis)
        origin = [o + reference * a for o, a in zip(origin, axis, strict=True)]
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
            rpy=numbers(_rpy(turn), where),
        )
    contents = {
        "frame_a": frame_a,
        "frame_c": frame_c,
        "torque_stiffness": numbers(turning, where),
        "torque_damping": "0 0 0",
        "force_stiffness": numbers(pushing, where),
        "force_damping": "0 0 0",
    }
    yield _extension(BUSHING, contents)


def _extension(extension: Extension, contents: dict[str, str]) -> Tag:
    children = (
        Tag(child.tag, **{child.attribute: contents[role]})
        for role, child in extension.children.items()
    )
    return Tag(extension.tag, *children)


def _x_along(axis: tuple[float, float, float]) -> Matrix3:
    """A rotation that takes x to the axis."""
    x, y, z = axis
    pitch, yaw = math.atan2(-z, math.hypot(x, y)), math.atan2(y, x)
    return rotation((0.0, pitch, yaw))


def _product(a: Matrix3, b: Matrix3) -> Matrix3:
    columns = [_times(a, column) for column in zip(*b, strict=True)]
    return tuple(zip(*columns, strict=True))


def _times(matrix: Matrix3, vector: tuple[float, ...]) -> tuple[float, float, float]:
    x, y, z = map(float, rotate(matrix, vector))
    return x, y, z


def _rpy(turn: Matrix3) -> tuple[float, float, float]:
    """Roll, pitch, yaw of a rotation (inverse of the URDF formula)."""
    (r00, r01, _), (r10, r11, _), (r20, r21, r22) = turn
    level = math.hypot(r00, r10)
    if level > 1e-12:
        return math.atan2(r21, r22), math.atan2(-r20, level), math.atan2(r10, r00)
    return 0.0, math.atan2(-r20, level), math.atan2(-r01, r11)
