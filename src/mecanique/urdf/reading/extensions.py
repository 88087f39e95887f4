"""Extensions of a URDF by drake: tags and our own: springs, dampers, loops and rotors."""

from __future__ import annotations

import math
from collections import defaultdict
from collections.abc import Collection, Iterable, Mapping
from dataclasses import dataclass, field, replace
from typing import Any, NamedTuple, final

import numpy as np

from mecanique.model.constraints.loops import Loop
from mecanique.model.force_base import AnyForce
from mecanique.model.forces import Damper, JointDamper, JointSpring, Spring
from mecanique.model.joint_base import Limits
from mecanique.model.placement import Placement, pose_of, rpy_of
from mecanique.urdf.dialect import (
    ACTUATOR_GEAR,
    ACTUATOR_INERTIA,
    BALL_CONSTRAINT,
    BUSHING,
    DISTANCE_CONSTRAINT,
    EXTENSIONS,
    Extension,
)
from mecanique.urdf.findings import Report, Spot
from mecanique.urdf.markup import Element
from mecanique.urdf.names import Names
from mecanique.urdf.reading.fields import Passage
from mecanique.urdf.reading.joints import MOVING, SINGLE, JointText
from mecanique.urdf.reading.native_tags import NATIVE_TAGS, is_redundant, read_native

_CLOSE = 1e-9

_NOT_MODELED = ("drake:tendon_constraint", "loop_joint")


@final
@dataclass
class Extensions:
    """The extensions of a robot."""

    forces: list[AnyForce] = field(default_factory=list)  # springs and dampers
    loops: list[Loop] = field(default_factory=list)
    used: list[Passage] = field(default_factory=list)  # the elements of Drake's that they come from
    native: list[Passage] = field(default_factory=list)  # the elements that mecanique alone reads
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
    known = {joint.name for joint in joints}
    for element in robot.children:
        text = Passage(element, report, f"<{element.tag}>")
        extension = EXTENSIONS.get(element.tag)
        if element.tag in _NOT_MODELED:
            text.fault("M604", f"{text.where} is not modeled")
        elif element.tag in NATIVE_TAGS:
            thing = read_native(element, links, known, extensions.names, report)
            home = "elements" if is_redundant(element) else NATIVE_TAGS[element.tag].home
            extensions.parts[home] += [] if thing is None else [thing]
            extensions.native.append(text)
        elif extension is not None:
            extensions.used.append(text)
            contents = _contents(text, extension)
            if contents is not None and extension is BUSHING:
                _bushing(text, frames, between, contents, extensions)
            elif contents is not None:
                _two_points(text, extension, links, contents, extensions)
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
) -> tuple[list[JointText], list[Spot]]:
    """Return the joints with their drives' rotors, inertia × ratio², and the elements read."""
    places = {joint.name: k for k, joint in enumerate(joints)}
    joints, used = list(joints), []
    for element in robot.all("transmission"):
        actuator = element.child("actuator")
        inside = None if actuator is None else actuator.child(ACTUATOR_INERTIA)
        if actuator is None or inside is None:
            continue
        text = Passage(element, report, f"transmission {element.attributes.get('name', '')!r}")
        rotor, kind = text.at(inside), element.child("type")
        said = element.attributes.get("type", "") if kind is None else kind.text
        if "SimpleTransmission" not in said:
            rotor.fault("M601", "the rotor counts only in a SimpleTransmission; it is left out")
            continue
        inertia = rotor.number("value")
        gear = text.at(actuator).only(ACTUATOR_GEAR)
        ratio = 1.0 if gear is None else gear.number("value")
        target = element.child("joint")
        name = None if target is None else text.at(target).name()
        if target is None:
            text.fault("M103", "<transmission> has no <joint>")
        if inertia is None or ratio is None or name is None:
            continue
        used.append(Spot(inside, f"<{inside.tag}>"))
        if name not in places:
            text.fault("M603", f"{name!r} is no joint")
            continue
        joint = joints[places[name]]
        armature = inertia * ratio**2
        if not 0 <= armature < math.inf:
            rotor.fault("M602", f"expected a rotor inertia of at least 0, got {inertia:g}")
        elif joint.kind in SINGLE:
            joints[places[name]] = replace(joint, armature=joint.armature + armature)
        elif joint.kind in MOVING:
            rotor.fault("M604", f"the rotor of a {joint.kind} joint is not modeled")
    return joints, used


def _contents(text: Passage, extension: Extension) -> dict[str, Any] | None:
    """Return the names and numbers that an element holds, by role; None if faults were reported."""
    contents: dict[str, Any] = {}
    for role, child in extension.children.items():
        holder = text.only(child.tag)
        if holder is None:
            text.fault("M602", f"it has no <{child.tag}>")
            continue
        numbers = holder.numbers("value", child.count) if child.count else None
        if numbers is not None and not role.startswith("point") and min(numbers) < 0:
            holder.fault("M602", f"expected a {role.replace('_', ' ')} of at least 0")
            numbers = None
        contents[role] = numbers if child.count else holder.name()
    complete = len(contents) == len(extension.children) and None not in contents.values()
    return contents if complete else None


def _two_points(
    text: Passage,
    extension: Extension,
    links: Collection[str],
    contents: Mapping[str, Any],
    extensions: Extensions,
) -> None:
    """Add what acts between two points of links."""
    a, b = contents["body_a"], contents["body_b"]
    strange = [name for name in (a, b) if name not in links]
    if strange or a == b:
        same = f"both of its ends are on link {a!r}"
        text.fault("M603", f"{strange[0]!r} is no link" if strange else same)
        return
    points = a, contents["point_a"], b, contents["point_b"]
    names, forces = extensions.names, extensions.forces
    if extension is BALL_CONSTRAINT:
        extensions.loops.append(Loop.ball(names.free(f"{a}_{b}_ball"), *points))
        return
    (stiffness,) = contents["stiffness"]
    if extension is DISTANCE_CONSTRAINT:
        (length,) = contents["distance"]
        if length == 0:
            text.fault("M602", "expected a distance above 0")
            return
        kept = f"Drake keeps the distance by a spring of {stiffness:g} N/m"
        text.fault("M609", f"{kept}, mecanique keeps it exactly")
        extensions.loops.append(Loop.distance(names.free(f"{a}_{b}_rod"), *points, length))
        return
    (length,), (damping,) = contents["free_length"], contents["damping"]
    if stiffness or not damping:
        if length == 0:
            text.fault("M609", "Drake refuses a spring without free length, mecanique does not")
        forces.append(Spring(names.free(f"{a}_{b}_spring"), *points, stiffness, length))
    if damping:
        forces.append(Damper(names.free(f"{a}_{b}_damper"), *points, damping))


class LinkFrame(NamedTuple):
    """A frame on a link."""

    link: str
    place: Placement = Placement()  # where it is in the link


def _bushing(
    text: Passage,
    frames: Mapping[str, LinkFrame],
    between: Mapping[frozenset[str], list[JointText]],
    contents: Mapping[str, Any],
    extensions: Extensions,
) -> None:
    """Add the spring and damper in a joint that a bushing equals."""
    ends = [contents[role] for role in ("frame_a", "frame_c")]
    strange = [name for name in ends if name not in frames]
    if strange:
        text.fault("M603", f"{strange[0]!r} is no frame")
        return
    a, c = (frames[name] for name in ends)
    if frozenset((a.link, c.link)) not in between:
        # as at a link that is welded to the world, which stands in for it
        a, c = (_carry_through_welds(frame, between) for frame in (a, c))
    joints = between.get(frozenset((a.link, c.link)), [])
    if len(joints) != 1 or joints[0].kind not in SINGLE:
        message = f"no revolute or prismatic joint joins its links {a.link!r} and {c.link!r}"
        text.fault("M605", message)
        return
    (joint,) = joints
    on_parent, on_child = (a, c) if a.link == joint.parent else (c, a)
    before = np.linalg.inv(pose_of(joint.origin)) @ pose_of(on_parent.place)
    after = pose_of(on_child.place)
    axis = np.asarray(joint.axis) / math.hypot(*joint.axis)
    along = before[:3, :3].T @ axis
    k = int(np.argmax(abs(along)))
    relative = np.linalg.inv(before) @ after
    others = [i for i in range(3) if i != k]
    lever = after[:3, 3] - axis * (axis @ after[:3, 3])
    if joint.kind == "prismatic":
        what, start, reach = "force", float(relative[k, 3]), math.inf
        turned = relative[:3, :3] - np.eye(3)
        gaps = {"do not lie on one line along": np.append(turned, relative[others, 3])}
    else:
        i, j = others if k != 1 else (2, 0)
        what, start = "torque", math.atan2(relative[j, i], relative[i, i])
        reach = math.pi / 2 if k == 1 else math.pi
        gaps = {
            "do not coincide on": np.append(relative[:3, 3], lever),
            "do not differ by a turn about": np.array(relative[k, k] - 1),
        }
    faults = [
        f"its frames {words} the axis of {joint.where}"
        for words, gap in gaps.items()
        if np.abs(gap).max() > _CLOSE
    ]
    if abs(abs(along[k]) - 1) > _CLOSE:
        faults.insert(0, f"no axis of its frame lies along the axis of {joint.where}")
    if faults:
        text.fault("M605", faults[0])
        return
    reference = (-start if along[k] > 0 else start) + 0.0
    limits = joint.limits or Limits()
    if max(abs(bound - reference) for bound in (limits.lower, limits.upper)) > reach:
        jumps = "in Drake its angle jumps at half a turn (a quarter about y)"
        text.fault("M609", f"{jumps}, in mecanique it continues")
    stiffness, damping = contents[f"{what}_stiffness"][k], contents[f"{what}_damping"][k]
    names, forces = extensions.names, extensions.forces
    if stiffness or not damping:
        name = names.free(f"{joint.name}_spring")
        forces.append(JointSpring(name, joint.name, stiffness, reference))
    if damping:
        forces.append(JointDamper(names.free(f"{joint.name}_damper"), joint.name, damping))


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
        text = Passage(element, report)
        name, link = text.name(), text.name("link")
        text = replace(text, where=f"frame {name!r}")
        place = text.placement()
        if name is None or link is None:
            continue
        if link not in links:
            text.fault("M603", f"{link!r} is no link")
        elif name in frames:
            text.fault("M106", "there is a link or frame of this name already")
        else:
            frames[name] = LinkFrame(link, place)
    return frames
