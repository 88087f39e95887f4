"""Extensions of a URDF by drake: tags and our own: springs, dampers, loops and rotors."""

from __future__ import annotations

import math
from collections import defaultdict
from collections.abc import Collection, Iterable, Mapping
from dataclasses import dataclass, field, replace
from typing import Any, final

import numpy as np

from mecanique.model.constraints.loops import Loop
from mecanique.model.force_base import AnyForce
from mecanique.model.forces import Damper, JointDamper, JointSpring, Spring
from mecanique.model.placement import Placement, pose_of, rpy_of
from mecanique.urdf.dialect import (
    ACTUATOR_GEAR,
    ACTUATOR_INERTIA,
    BALL_CONSTRAINT,
    BUSHING,
    DISTANCE_CONSTRAINT,
    EXTENSIONS,
    SPRING_DAMPER,
    Extension,
)
from mecanique.urdf.findings import Report
from mecanique.urdf.markup import Element
from mecanique.urdf.names import Names
from mecanique.urdf.reading.fields import name_of, number, numbers, placement_of, single
from mecanique.urdf.reading.joints import MOVING, SINGLE, JointText
from mecanique.urdf.reading.native_tags import NATIVE_TAGS, is_redundant, read_native

_CLOSE = 1e-9


@final
class BushingFaultError(Exception):
    """The bushing is not a spring in a joint; the reader turns this into a finding."""


@final
@dataclass(frozen=True)
class LinkFrame:
    """A frame on a link."""

    link: str
    place: Placement = field(default_factory=Placement)  # where it is in the link


@final
@dataclass(frozen=True)
class InJoint:
    """A spring and damper in a joint."""

    joint: str
    stiffness: float  # N·m/rad or N/m
    damping: float  # N·m·s/rad or N·s/m
    reference: float  # the joint coordinate without force [rad or m]
    turns: bool  # whether the joint may leave the range of the bushing's angle


def in_joint(
    a: LinkFrame, c: LinkFrame, between: list[JointText], values: Mapping[str, tuple[float, ...]]
) -> InJoint:
    """Return the spring and damper in a joint that a bushing equals; values have shape (3,)."""
    if len(between) != 1 or between[0].kind not in ("revolute", "continuous", "prismatic"):
        raise BushingFaultError(
            f"no revolute or prismatic joint joins its links {a.link!r} and {c.link!r}"
        )
    joint = between[0]
    on_parent, on_child = (a, c) if a.link == joint.parent else (c, a)
    inverse = np.linalg.inv(pose_of(joint.origin))
    before = inverse @ pose_of(on_parent.place)
    after = pose_of(on_child.place)
    axis = np.asarray(joint.axis) / math.hypot(*joint.axis)
    along = before[:3, :3].T @ axis
    k = int(np.argmax(abs(along)))
    if abs(abs(along[k]) - 1) > _CLOSE:
        raise BushingFaultError(f"no axis of its frame lies along the axis of {joint.where}")
    relative = np.linalg.inv(before) @ after
    sign = 1.0 if along[k] > 0 else -1.0
    others = [i for i in range(3) if i != k]
    if joint.kind == "prismatic":
        if (
            abs(relative[:3, :3] - np.eye(3)).max() > _CLOSE
            or abs(relative[others, 3]).max() > _CLOSE
        ):
            raise BushingFaultError(
                f"its frames do not lie on one line along the axis of {joint.where}"
            )
        start, what, range_ = float(relative[k, 3]), "force", math.inf
    else:
        lever = after[:3, 3] - axis * (axis @ after[:3, 3])
        if abs(relative[:3, 3]).max() > _CLOSE or abs(lever).max() > _CLOSE:
            raise BushingFaultError(f"its frames do not coincide on the axis of {joint.where}")
        if abs(relative[k, k] - 1) > _CLOSE:
            raise BushingFaultError(
                f"its frames do not differ by a turn about the axis of {joint.where}"
            )
        i, j = others if k != 1 else (2, 0)
        start, what = math.atan2(relative[j, i], relative[i, i]), "torque"
        range_ = math.pi / 2 if k == 1 else math.pi
    reference = -sign * start + 0.0
    bounds = (
        (-math.inf, math.inf) if joint.limits is None else (joint.limits.lower, joint.limits.upper)
    )
    turns = max(abs(bound - reference) for bound in bounds) > range_
    return InJoint(
        joint.name, values[f"{what}_stiffness"][k], values[f"{what}_damping"][k], reference, turns
    )


_NOT_MODELED = ("drake:tendon_constraint", "loop_joint")


@final
@dataclass
class Extensions:
    """The extensions of a robot."""

    forces: list[AnyForce] = field(default_factory=list)  # springs and dampers
    loops: list[Loop] = field(default_factory=list)
    used: list[Element] = field(default_factory=list)  # the elements of Drake's that they come from
    native: list[Element] = field(default_factory=list)  # the elements that mecanique alone reads
    names: Names = field(default_factory=Names)

    def __post_init__(self) -> None:
        self.parts: dict[str, list[Any]] = defaultdict(list, forces=self.forces, loops=self.loops)
        """What they describe, by the field of a mechanism that holds it."""


def read_extensions(
    robot: Element, links: Collection[str], joints: list[JointText], report: Report
) -> Extensions:
    """Return springs, dampers and loops of a robot; what cannot be read is reported."""
    extensions = Extensions()
    frames = _frames(robot, links, report)
    between = _list_between(joints)
    for element in robot.children:
        if element.tag in _NOT_MODELED:
            report.add("M604", element, f"<{element.tag}>", f"<{element.tag}> is not modeled")
            continue
        if element.tag in NATIVE_TAGS:
            names_of_joints = {joint.name for joint in joints}
            thing = read_native(element, links, names_of_joints, extensions.names, report)
            home = "elements" if is_redundant(element) else NATIVE_TAGS[element.tag].home
            extensions.parts[home] += [] if thing is None else [thing]
            extensions.native.append(element)
            continue
        extension = EXTENSIONS.get(element.tag)
        if extension is None:
            continue
        where = f"<{element.tag}>"
        extensions.used.append(element)
        values = _values(element, extension, report, where)
        names = {role: _name(element, extension, role, report, where) for role in _roles(extension)}
        if values is None or None in names.values():
            continue
        if extension is BUSHING:
            _bushing(element, frames, between, values, report, extensions)
            continue
        for name in names.values():
            if name not in links:
                report.add("M603", element, where, f"{name!r} is no link")
                break
        else:
            a, b = names["body_a"] or "", names["body_b"] or ""
            if a == b:
                report.add("M603", element, where, f"both of its ends are on link {a!r}")
            else:
                _two_points(element, extension, a, b, values, report, extensions)
    return extensions


def _list_between(joints: Iterable[JointText]) -> dict[frozenset[str], list[JointText]]:
    """The joints between each two links; the hinge of a screw turns against its slide's parent."""
    between: dict[frozenset[str], list[JointText]] = {}
    screws = {joint.child: joint for joint in joints if joint.screw}
    for joint in joints:
        slide = screws.get(joint.parent)
        if slide is not None:
            joint = replace(joint, parent=slide.parent, origin=slide.origin)
        between.setdefault(frozenset((joint.parent, joint.child)), []).append(joint)
    return between


def with_rotors(
    robot: Element, joints: list[JointText], report: Report
) -> tuple[list[JointText], list[Element]]:
    """Return the joints with their drives' rotors, inertia × ratio², and the elements read."""
    places = {joint.name: k for k, joint in enumerate(joints)}
    joints, used = list(joints), []
    for element in robot.all("transmission"):
        actuator = element.child("actuator")
        rotor = None if actuator is None else actuator.child(ACTUATOR_INERTIA)
        if actuator is None or rotor is None:
            continue
        where = f"transmission {element.attributes.get('name', '')!r}"
        kind = element.child("type")
        if "SimpleTransmission" not in (
            element.attributes.get("type", "") if kind is None else kind.text
        ):
            report.add(
                "M601",
                rotor,
                where,
                "the rotor counts only in a SimpleTransmission; it is left out",
            )
            continue
        inertia = number(rotor, "value", report, where)
        gear = single(actuator, ACTUATOR_GEAR, report, where)
        ratio = 1.0 if gear is None else number(gear, "value", report, where)
        target = element.child("joint")
        name = None if target is None else name_of(target, report, "name", where)
        if target is None:
            report.add("M103", element, where, "<transmission> has no <joint>")
        if inertia is None or ratio is None or name is None:
            continue
        used.append(rotor)
        if name not in places:
            report.add("M603", element, where, f"{name!r} is no joint")
            continue
        joint = joints[places[name]]
        armature = inertia * ratio**2
        if not 0 <= armature < math.inf:
            report.add(
                "M602", rotor, where, f"expected a rotor inertia of at least 0, got {inertia:g}"
            )
        elif joint.kind in SINGLE:
            joints[places[name]] = replace(joint, armature=joint.armature + armature)
        elif joint.kind in MOVING:
            report.add("M604", rotor, where, f"the rotor of a {joint.kind} joint is not modeled")
    return joints, used


def _roles(extension: Extension) -> list[str]:
    return [role for role, child in extension.children.items() if child.attribute == "name"]


def _name(
    element: Element, extension: Extension, role: str, report: Report, where: str
) -> str | None:
    tag = extension.children[role].tag
    child = single(element, tag, report, where)
    if child is None:
        report.add("M602", element, where, f"it has no <{tag}>")
        return None
    return name_of(child, report, "name", where)


def _values(
    element: Element, extension: Extension, report: Report, where: str
) -> dict[str, tuple[float, ...]] | None:
    values: dict[str, tuple[float, ...]] = {}
    complete = True
    for role, child in extension.children.items():
        if child.attribute != "value":
            continue
        holder = single(element, child.tag, report, where)
        if holder is None:
            report.add("M602", element, where, f"it has no <{child.tag}>")
        value = None if holder is None else numbers(holder, "value", child.count, report, where)
        if value is not None and not role.startswith("point") and min(value) < 0:
            report.add(
                "M602",
                holder or element,
                where,
                f"expected a {role.replace('_', ' ')} of at least 0",
            )
            value = None
        complete = complete and value is not None
        values[role] = value or ()
    return values if complete else None


def _two_points(
    element: Element,
    extension: Extension,
    a: str,
    b: str,
    values: dict[str, tuple[float, ...]],
    report: Report,
    extensions: Extensions,
) -> None:
    where = f"<{element.tag}>"
    p, q = values["point_a"], values["point_b"]
    points = a, (p[0], p[1], p[2]), b, (q[0], q[1], q[2])
    if extension is BALL_CONSTRAINT:
        extensions.loops.append(Loop.ball(extensions.names.free(f"{a}_{b}_ball"), *points))
        return
    if extension is DISTANCE_CONSTRAINT:
        (length,), (stiffness,) = values["distance"], values["stiffness"]
        if length == 0:
            report.add("M602", element, where, "expected a distance above 0")
            return
        message = (
            f"Drake keeps the distance by a spring of {stiffness:g} N/m, mecanique keeps it exactly"
        )
        report.add("M609", element, where, message)
        name = extensions.names.free(f"{a}_{b}_rod")
        extensions.loops.append(Loop.distance(name, *points, length))
        return
    if extension is not SPRING_DAMPER:
        return
    (stiffness,), (length,), (damping,) = (
        values["stiffness"],
        values["free_length"],
        values["damping"],
    )
    if stiffness or not damping:
        if length == 0:
            report.add(
                "M609",
                element,
                where,
                "Drake refuses a spring without free length, mecanique does not",
            )
        extensions.forces.append(
            Spring(extensions.names.free(f"{a}_{b}_spring"), *points, stiffness, length)
        )
    if damping:
        extensions.forces.append(Damper(extensions.names.free(f"{a}_{b}_damper"), *points, damping))


def _bushing(
    element: Element,
    frames: dict[str, LinkFrame],
    between: dict[frozenset[str], list[JointText]],
    values: dict[str, tuple[float, ...]],
    report: Report,
    extensions: Extensions,
) -> None:
    where = f"<{element.tag}>"
    ends = [element.child(BUSHING.children[role].tag) for role in ("frame_a", "frame_c")]
    names = [end.attributes.get("name", "") for end in ends if end is not None]
    for name in names:
        if name not in frames:
            report.add("M603", element, where, f"{name!r} is no frame")
            return
    a, c = (frames[name] for name in names)
    if frozenset((a.link, c.link)) not in between:
        # as at a link that is welded to the world, which stands in for it
        a, c = (_carry_through_welds(frame, between) for frame in (a, c))
    try:
        equal = in_joint(a, c, between.get(frozenset((a.link, c.link)), []), values)
    except BushingFaultError as fault:
        report.add("M605", element, where, str(fault))
        return
    if equal.turns:
        message = (
            "in Drake its angle jumps at half a turn (a quarter about y), in mecanique it continues"
        )
        report.add("M609", element, where, message)
    if equal.stiffness or not equal.damping:
        name = extensions.names.free(f"{equal.joint}_spring")
        extensions.forces.append(JointSpring(name, equal.joint, equal.stiffness, equal.reference))
    if equal.damping:
        extensions.forces.append(
            JointDamper(extensions.names.free(f"{equal.joint}_damper"), equal.joint, equal.damping)
        )


def _carry_through_welds(
    frame: LinkFrame, between: Mapping[frozenset[str], list[JointText]]
) -> LinkFrame:
    """Return a frame on the link to which fixed joints weld its own, in the same place."""
    welds = {
        joint.child: joint for joints in between.values() for joint in joints if not joint.moving
    }
    while frame.link in welds:
        weld = welds.pop(frame.link)
        pose = pose_of(weld.origin) @ pose_of(frame.place)
        x, y, z = pose[:3, 3].tolist()
        frame = LinkFrame(weld.parent, Placement((x, y, z), rpy_of(pose[:3, :3])))
    return frame


def _frames(robot: Element, links: Collection[str], report: Report) -> dict[str, LinkFrame]:
    frames = {name: LinkFrame(name) for name in links}
    for element in robot.all("frame"):
        name = name_of(element, report)
        link = name_of(element, report, "link")
        place = placement_of(element, report, f"frame {name!r}")
        if name is None or link is None:
            continue
        if link not in links:
            report.add("M603", element, f"frame {name!r}", f"{link!r} is no link")
        elif name in frames:
            report.add(
                "M106", element, f"frame {name!r}", "there is a link or frame of this name already"
            )
        else:
            frames[name] = LinkFrame(link, place)
    return frames
