"""Lint: the reader's findings and those of every rule."""

from __future__ import annotations

import math
import os
import re
from collections import defaultdict
from collections.abc import Callable, Collection, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from difflib import get_close_matches
from typing import Any, TypeAlias, final

import numpy as np
import numpy.typing as npt

from mecanique.arrays import Array
from mecanique.errors import InputError
from mecanique.model import slips
from mecanique.model.bodies.visuals import Box, Cylinder, Sphere, Visual
from mecanique.model.mechanism.origin import Finding
from mecanique.model.placement import Placement, pose_of
from mecanique.plugins import list_plugins, load_plugin
from mecanique.urdf.dialect import (
    ACTUATOR_GEAR,
    ACTUATOR_INERTIA,
    DRAKE_JOINT,
    EXTENSIONS,
    FOREIGN,
    SCREW,
    UNUSED,
    WORLD,
    uses_drake,
)
from mecanique.urdf.findings import Located, Report, Spot
from mecanique.urdf.limits import MOST_DEPTH, MOST_VELOCITIES
from mecanique.urdf.lint import blanks, homogeneous
from mecanique.urdf.lint.homogeneous import solid_of
from mecanique.urdf.markup import Element
from mecanique.urdf.read import mechanism_of
from mecanique.urdf.reading.document import Source, UrdfDocument, read_document
from mecanique.urdf.reading.joints import SINGLE, JointText
from mecanique.urdf.reading.links import UrdfLink
from mecanique.urdf.reading.native_tags import CHILDREN, NATIVE_TAGS
from mecanique.urdf.reading.packages import PackagePath
from mecanique.urdf.rules import Rule
from mecanique.urdf.solids import Mass

# elements and attributes that nothing reads: misspelled, misplaced, or for other programs

_JOINT = (
    {"name", "type"},
    {
        *("origin", "parent", "child", "axis", "limit", "dynamics", "mimic", "calibration"),
        *("safety_controller", SCREW),
    },
)
_WORDS: dict[str, tuple[Collection[str], Collection[str]]] = {
    "robot": (
        {"name", "version"},
        {
            *("link", "joint", "drake:joint", "material", "frame"),
            *EXTENSIONS,
            *NATIVE_TAGS,
        },
    ),
    "link": ({"name"}, {"inertial", "visual", "collision"}),
    "joint": _JOINT,
    "drake:joint": _JOINT,
    "inertial": ((), {"origin", "mass", "inertia"}),
    "visual": ({"name"}, {"origin", "geometry", "material"}),
    "collision": ({"name"}, {"origin", "geometry"}),
    "geometry": ((), {"box", "cylinder", "sphere", "mesh"}),
    "material": ({"name"}, {"color", "texture"}),
    "origin": ({"xyz", "rpy"}, ()),
    "mass": ({"value"}, ()),
    "inertia": ({"ixx", "ixy", "ixz", "iyy", "iyz", "izz"}, ()),
    "box": ({"size"}, ()),
    "cylinder": ({"radius", "length"}, ()),
    "sphere": ({"radius"}, ()),
    "mesh": ({"filename", "scale"}, ()),
    "color": ({"rgba"}, ()),
    "axis": ({"xyz"}, ()),
    "parent": ({"link"}, ()),
    "child": ({"link"}, ()),
    "limit": ({"lower", "upper", "effort", "velocity"}, ()),
    "dynamics": ({"damping", "friction"}, ()),
    "mimic": ({"joint", "multiplier", "offset"}, ()),
    "frame": ({"name", "link", "xyz", "rpy"}, ()),
    SCREW: ((), ()),
    **{tag: ({"name", *kind.attributes}, {*kind.children}) for tag, kind in NATIVE_TAGS.items()},
    **{tag: ({*kind.attributes}, ()) for tag, kind in CHILDREN.items()},
}
"""Attributes and children of each element."""

_UNUSED = UNUSED | {"texture"}
_OTHERS = FOREIGN | {"transmission", "texture", "contact"}
_HOLDERS = ("robot", "joint", "drake:joint")
"""Elements in which a tag of Drake's that is not known is told as such."""


_COMMON = {("collision", "material")}


def _check_spelling(document: UrdfDocument, report: Report) -> None:
    """Note elements and attributes that are not read, and the version and namespace."""
    robot = document.element
    version = robot.attributes.get("version", "1.0")
    if version != "1.0":
        report.add("M705", robot, f"the version is {version!r}")
    _namespace(robot, report)
    unused: dict[str, list[Spot]] = defaultdict(list)
    waiting = [Spot(robot, "")]
    while waiting:
        element, where = spot = waiting.pop()
        attributes, children = _WORDS[element.tag]
        strange: list[tuple[str, str, Collection[str], Spot]] = [
            (name, f"{name}=… of <{element.tag}>", attributes, spot)
            for name in element.attributes
            if name not in attributes and not name.startswith(("xmlns", "drake:"))
        ]
        for child in element.children:
            tag, inside = child.tag, Spot(child, where or _place(child))
            misplaced = tag in _WORDS and tag not in _OTHERS and (element.tag, tag) not in _COMMON
            if tag in children:
                if tag in _UNUSED:
                    unused[f"<{tag}>"].append(inside)
                elif tag in _WORDS:
                    waiting.append(inside)
            elif tag.startswith("drake:"):
                if element.tag in _HOLDERS:
                    report.add("M601", inside, f"<{tag}> in <{element.tag}> is not known")
            elif misplaced:
                message = f"<{tag}> has no meaning in <{element.tag}>; it is ignored"
                report.add("M113", inside, message)
            else:
                strange.append((tag, f"<{tag}> in <{element.tag}>", children, inside))
        for word, what, known, place in strange:
            if near := _guess(word, known):
                report.add("M113", place, f"{what} is ignored; did you mean {near!r}?")
            else:
                unused[what].append(place)
    for what, places in unused.items():
        report.together("M703", places, f"{what} is not used")
    _rotors(robot, report)
    _drives(robot, report)


def _place(element: Element) -> str:
    name = element.attributes.get("name")
    return f"{element.tag} {name!r}" if name else f"<{element.tag}>"


def _guess(word: str, known: Collection[str]) -> str:
    """Return the known word that was meant; "" if none is near."""
    if word in _OTHERS or len(word) > 30:
        return ""
    near = get_close_matches(word.lower(), known, n=1, cutoff=0.7)
    return near[0] if near and abs(len(near[0]) - len(word)) <= 2 else ""


def _namespace(robot: Element, report: Report) -> None:
    if "xmlns:drake" in robot.attributes:
        return
    first = next(filter(uses_drake, robot.walk()), None)
    if first is not None:
        place = Spot(first, f"<{first.tag}>")
        report.add("M607", place, "the prefix drake: is used but not declared")


_ROTOR = re.compile(r"(rotor|motor)_?inertia", re.IGNORECASE)
_REDUCTION = re.compile(r"mechanical_?reduction|gear_?ratio", re.IGNORECASE)


def _drives(robot: Element, report: Report) -> None:
    """Say what a rotor and a reduction make of which only Drake's tags are read."""
    for drive in robot.all("transmission"):
        inside = [element for element in drive.walk() if not element.tag.startswith("drake:")]
        rotors = [element for element in inside if _ROTOR.fullmatch(element.tag)]
        drakes = [element for element in drive.walk() if element.tag == ACTUATOR_INERTIA]
        ratios = [element for element in inside if _REDUCTION.fullmatch(element.tag)]
        geared = any(element.tag == ACTUATOR_GEAR for element in drive.walk())
        joint = drive.child("joint")
        if joint is None or not (rotors or (drakes and ratios and not geared)):
            continue
        inertia = _value(rotors[0] if rotors else drakes[0])
        ratio = _value(ratios[0]) if ratios else 1.0
        if inertia is None or ratio is None:
            continue
        name, armature = joint.attributes.get("name", ""), inertia * ratio**2
        at = rotors[0] if rotors else ratios[0]
        message = (
            f"<{at.tag}> is not read: with a rotor of {inertia:g} and a reduction of {ratio:g} "
            f"joint {name!r} has an armature of {armature:g}"
        )
        remedy = (
            f"Write <{ACTUATOR_INERTIA}> and <{ACTUATOR_GEAR}> in <actuator>, or read it with "
            f"armature={{{name!r}: {armature:g}}}."
        )
        report.add("M601", Spot(at, _place(drive)), message, remedy)


def _value(element: Element) -> float | None:
    try:
        return float(element.attributes.get("value", element.text))
    except ValueError:
        return None


def _rotors(robot: Element, report: Report) -> None:
    """Rotor inertias count below robot/transmission/actuator only."""
    for element in robot.walk():
        for child in () if element.tag in ("actuator", *_HOLDERS) else element.children:
            if child.tag in (ACTUATOR_INERTIA, ACTUATOR_GEAR):
                message = f"<{child.tag}> counts only in <actuator>; it is left out"
                report.add("M601", Spot(child, f"<{element.tag}>"), message)


# masses that make the equations singular or that engines drop

_TINY = 2.2e-16
"""Pinocchio loses the lever of masses below [kg]."""

_ROUNDING, _LEVER = 1e-14, 1e-12
"""What a turn or an arm leaves of an inertia and of a lever that are zero, relative to size."""


def _check_masses(document: UrdfDocument, report: Report) -> None:
    """Note masses and inertias that are allowed but suspicious."""
    root = document.root
    points = [link for link in document.links if link.mass and not any(link.inertia)]
    report.together("M205", points, "a mass without inertia")
    for link in document.links:
        if link.mass == 0 and any(link.inertia):
            report.add("M204", link, "it has inertia but no mass")
        if 0 < link.mass < _TINY:
            report.add("M207", link, f"its mass is {link.mass:g} kg")
        if link.name == root and not link.massless:
            report.add("M211", link, f"the root link has a mass of {link.mass:g} kg")
    if root is not None:
        _massless(document, report)


def _massless(document: UrdfDocument, report: Report) -> None:
    heavy = {link.name: not link.massless for link in document.links}
    for joint in reversed(document.tree):
        heavy[joint.parent] |= heavy[joint.child]
    links = {link.name: link for link in document.links}
    # the joint that moves each link, if one does, and the pose of the link where it is carried
    movers: dict[str, tuple[str, Array]] = {}
    beyond: set[str] = set()
    for joint in document.tree:
        mover, pose = movers.get(joint.parent, ("", np.eye(4)))
        if joint.moving:
            movers[joint.child] = joint.name, np.eye(4)
            beyond |= {mover} if heavy[joint.child] else set()
        elif mover:
            movers[joint.child] = mover, pose @ pose_of(joint.origin)
    carried: dict[str, list[tuple[UrdfLink, Array]]] = defaultdict(list)
    for name, (mover, pose) in movers.items():
        carried[mover] += [] if links[name].massless else [(links[name], pose)]
    for joint in document.joints:
        if not joint.moving or joint.armature or joint.name in document.mimics:
            continue
        if not heavy[joint.child]:
            report.add("M206", joint, "it moves nothing that has mass")
        # what moves further may resist in other positions
        elif joint.name not in beyond and _no_resistance(joint, carried[joint.name]):
            names = [repr(link.name) for link, _ in carried[joint.name]]
            verb = "link {} does" if len(names) == 1 else "links {} do"
            message = f"{verb.format(' and '.join(names))} not resist this motion"
            report.add("M206", joint, message)


def _no_resistance(joint: JointText, carried: Sequence[tuple[UrdfLink, Array]]) -> bool:
    """Whether a motion of the joint meets no inertia: its block of the mass matrix is singular."""
    motions = _motions(joint)
    inertia = np.zeros((6, 6))
    size = 0.0
    for link, pose in carried:
        body = link.mass_at(pose)
        # the velocity of the center is v + ω × r
        lever = np.vstack([np.cross(np.eye(3), body.center), np.eye(3)])
        inertia += body.mass * lever @ lever.T
        inertia[:3, :3] += body.inertia
        # what rounding leaves of an arm or a tensor that lies along the axis
        size += _ROUNDING * float(np.trace(body.inertia))
        size += body.mass * _LEVER**2 * max(1.0, float(body.center @ body.center))
    block = motions @ inertia @ motions.T
    if len(block) == 1:
        # a slide meets the mass, however small; a turn the inertia that is more than rounding
        return bool(block[0, 0] <= (0.0 if joint.kind == "prismatic" else size))
    scale = np.sqrt(np.maximum(np.diag(block), 1e-300))
    return bool(np.linalg.eigvalsh(block / np.outer(scale, scale))[0] <= _LEVER)


def _motions(joint: JointText) -> Array:
    """The velocities of the child's origin that a joint allows: rows (ω, v), each shape (6,)."""
    rows: list[Array] = []
    for motion in joint.joint().chain:
        match motion.kind:
            case "turn":
                rows.append(np.append(motion.axis, np.zeros(3)))
            case "slide":
                rows.append(np.append(np.zeros(3), motion.axis))
            case "ball" | "free":
                rows += [*np.eye(6)[: 3 if motion.kind == "ball" else 6]]
    return np.array(rows)


# links of the left and right side that differ although their names match

_MASS, _MOMENT = 0.01, 0.05
"""Relative differences of masses and moments of inertia that drawings of two sides may have."""

_NEAR = 2e-3
"""Distance by which mirrored points may differ [m]."""

_LIGHTEST = 1e-3
"""Links of less than this part of the robot's mass are left out."""

_MIRROR = np.array([1.0, -1.0, 1.0])
"""Left and right lie on either side of the root link's plane x–z (REP 103)."""

_ON_THE_RIGHT = {"left": "right", "l": "r", "fl": "fr", "rl": "rr", "hl": "hr", "bl": "br"}
_ON_THE_RIGHT |= {"lf": "rf", "lr": "rr", "lh": "rh", "lb": "rb"}
_ON_THE_RIGHT |= {left.upper(): right.upper() for left, right in _ON_THE_RIGHT.items()}
_ON_THE_RIGHT |= {"Left": "Right"}
"""What words of a name on the left are called on the right."""

_PARTS_OF_NAMES = re.compile(r"[A-Z]?[a-z]+|[A-Z]+(?![a-z])|[0-9]+|[^A-Za-z0-9]+")


def mirror_name(name: str) -> str:
    """Return what the same part of the right side is called; "" for one that is not on the left."""
    words = _PARTS_OF_NAMES.findall(name)
    count = sum(word in _ON_THE_RIGHT for word in words)
    if count == 1:
        return "".join(_ON_THE_RIGHT.get(word, word) for word in words)
    # LLEG_LINK1, lhip
    first = {"L": "R", "l": "r"}.get(name[:1], "")
    return first + name[1:] if first and not count else ""


def _check_sides(document: UrdfDocument, report: Report) -> None:
    """Note links of the right side that do not mirror those of the left."""
    if document.root is None:
        return
    links = {link.name: link for link in document.links}
    poses = {document.root: np.eye(4)}  # with all joints at zero, in the root
    for joint in document.tree:
        poses[joint.child] = poses[joint.parent] @ pose_of(joint.origin)
    least = _LIGHTEST * sum(link.mass for link in document.links)
    for left in document.links:
        right = links.get(mirror_name(left.name))
        if right is None or max(left.mass, right.mass) <= least:
            continue
        a, b = poses[left.name], poses[right.name]
        # what only bears such a name, as on a robot with two arms side by side
        if np.linalg.norm(b[:3, 3] - _MIRROR * a[:3, 3]) > _NEAR:
            continue
        differences = list(_differences(left.mass_at(a), right.mass_at(b), a, b))
        if differences:
            message = f"it is not link {left.name!r} mirrored: {'; '.join(differences)}"
            report.add("M212", right, message)


def _differences(left: Mass, right: Mass, a: Array, b: Array) -> Iterator[str]:
    """Yield what differs between masses on both sides, with the poses of their links."""
    if abs(left.mass - right.mass) > _MASS * max(left.mass, right.mass):
        yield f"{right.mass:g} kg, not {left.mass:g} kg"
    sides = ((left, a), (right, b))
    reach = max(float(np.linalg.norm(mass.center - pose[:3, 3])) for mass, pose in sides)
    off = float(np.linalg.norm(right.center - _MIRROR * left.center))
    if off > max(_NEAR, _MOMENT * reach):
        yield f"its center of mass is {1000 * off:.3g} mm away from there"
        return
    inertia = np.outer(_MIRROR, _MIRROR) * left.inertia
    size = max(np.abs(left.inertia).max(), np.abs(right.inertia).max())
    if np.abs(right.inertia - inertia).max() > _MOMENT * size:
        ours, theirs = np.linalg.eigvalsh(right.inertia), np.linalg.eigvalsh(inertia)
        if np.abs(ours - theirs).max() > _MOMENT * size:
            yield f"principal moments {_list(ours)}, not {_list(theirs)} kg·m²"
        else:
            yield "the same principal moments of inertia, about other axes"


def _list(values: npt.NDArray[np.floating[Any]]) -> str:
    return ", ".join(f"{value:.3g}" for value in values)


# numbers that look like millimeters, grams or degrees, or an inertia about another point

_METERS, _DEGREES, _GRAMS = (
    f": {unit[0].text}?" for unit in (slips.LENGTH, slips.ANGLE, slips.MASS)
)
"""What a distance, an angle or a mass that is too large looks like, as in `mecanique diff`."""

_FAR = 20.0
"""A distance within a robot that is likely in millimeters [m]."""

_DENSE = 30_000.0
"""A density above that of every metal [kg/m³]."""


def _check_units(document: UrdfDocument, report: Report) -> None:
    """Note numbers that seem to be in units other than kg, m, s and radians."""
    reach: dict[str, float] = {}
    for joint in document.joints:
        distance = math.hypot(*joint.origin.xyz)
        reach[joint.parent] = max(reach.get(joint.parent, 0.0), distance)
        if distance > _FAR:
            report.add("M310", joint, f"its origin is {distance:g} m away{_METERS}")
        if joint.kind == "revolute" and joint.limits is not None:
            bounds = (joint.limits.lower, joint.limits.upper)
            most = max((abs(bound) for bound in bounds if math.isfinite(bound)), default=0.0)
            if 4 * math.pi < most <= 1000:
                report.add("M309", joint, f"its limits reach {most:g} radians{_DEGREES}")
        _check_angles(joint.origin, joint, report)
    for link in document.links:
        _check_angles(link.frame, link, report)
        for visual in (*link.visuals, *link.collisions):
            _check_angles(visual.placement, link, report)
        if link.mass > 0:
            _check_link(link, reach.get(link.name, 0.0), report)


def _check_angles(place: Placement, whose: Located, report: Report) -> None:
    most = max(abs(angle) for angle in place.rpy)
    if most > 2 * math.pi + 0.01:
        report.add("M309", whose, f"an angle of its placement is {most:g} radians{_DEGREES}")


def _check_link(link: UrdfLink, reach: float, report: Report) -> None:
    center = math.hypot(*link.frame.xyz)
    if center > _FAR:
        report.add("M310", link, f"its center of mass is {center:g} m away{_METERS}")
    drawn = [visual for visual in (*link.collisions, *link.visuals) if _extent(visual) > 0]
    size = max([center, reach, *(math.hypot(*v.placement.xyz) + _extent(v) for v in drawn)])
    gyration = math.sqrt(max(sum(link.inertia[:3]) / 2, 0.0) / link.mass)
    if (size > 0 and gyration > 5 * max(size, 0.2)) or gyration > 30 or 0 < gyration < size / 300:
        message = (
            f"its inertia is that of its mass {gyration:.3g} m away from the center, "
            f"but it is {size:.3g} m large"
        )
        report.add("M208", link, message)
    shapes = [visual for visual in link.collisions if _extent(visual) > 0]
    if len(shapes) == len(link.collisions) == 1:
        solid = solid_of(shapes, meshes=False)
        if solid and link.mass > 5 and link.mass > _DENSE * solid.volume:
            density = link.mass / solid.volume
            report.add("M209", link, f"its density is {density:.3g} kg/m³{_GRAMS}")
    shapes = shapes or [visual for visual in link.visuals if _extent(visual) > 0]
    if len(shapes) == 1:
        _check_point(link, shapes[0], report)


def _check_point(link: UrdfLink, shape: Visual, report: Report) -> None:
    """Compare the inertia with that of the drawn shape, about its center and the link's origin."""
    if any(shape.placement.rpy) or any(link.frame.rpy):
        return
    place, solid = shape.placement.xyz, solid_of([shape], meshes=False)
    if solid is None:
        return
    by_shape = (np.diag(solid.inertia) * link.mass / solid.volume).tolist()
    x, y, z = place
    lever = [link.mass * d for d in (y * y + z * z, x * x + z * z, x * x + y * y)]
    about_origin = [i + d for i, d in zip(by_shape, lever, strict=True)]
    if sum(lever) < 0.2 * sum(by_shape) or not _near(link.inertia[:3], about_origin):
        return
    if not any(link.frame.xyz):
        message = (
            "its mass is at its origin, but its inertia is that of its shape, "
            "whose center is elsewhere"
        )
        report.add("M210", link, message)
    elif _near(link.frame.xyz, place):
        message = f"its inertia is that of its shape {slips.ABOUT_ORIGIN}"
        report.add("M210", link, message)


def _near(a: Sequence[float], b: Sequence[float]) -> bool:
    largest = max(map(abs, b))
    return all(abs(p - q) <= 0.02 * largest for p, q in zip(a, b, strict=True))


def _extent(visual: Visual) -> float:
    """Half the largest extent of a primitive; 0 for a mesh."""
    match visual.geometry:
        case Box(size):
            return math.hypot(*size) / 2
        case Cylinder(radius, length):
            return math.hypot(radius, length / 2)
        case Sphere(radius):
            return float(radius)
        case _:
            return 0.0


# what Pinocchio, Drake and MuJoCo read differently, ignore or cannot handle


def _check_engines(document: UrdfDocument, report: Report) -> None:
    """Note what other programs make of the text."""
    joints, extensions = document.joints, document.extensions
    _check_parts(document, report)
    report.together("M501", document.lost, f"its mesh file is not found in {document.searched}")
    colliding = [link for link in document.links if link.collisions]
    report.together("M507", colliding, "collisions are not modeled")
    mimics = [joint for joint in joints if joint.name in document.mimics]
    report.together("M404", mimics, "it mimics another joint")
    damped = [joint for joint in joints if joint.damping and joint.kind in SINGLE]
    report.together("M704", damped, "damping is applied")
    rubbing = [joint for joint in joints if joint.friction and joint.moving]
    report.together("M313", rubbing, "dry friction is left out")
    custom = [joint for joint in joints if joint.element.tag == DRAKE_JOINT]
    others = [
        joint
        for joint in joints
        if joint.kind == "floating" or (joint.kind == "planar" and joint not in custom)
    ]
    report.together("M706", others, "its type is read differently")
    drake: list[Located] = [*extensions.used]
    drake += [Spot(joint.element, f"<{DRAKE_JOINT}>") for joint in custom]
    report.together("M606", drake, "only Drake and mecanique read it")
    report.together("M610", extensions.native, "only mecanique reads it")
    report.together("M608", document.rotors, "a rotor adds inertia")
    _check_size(document, report)


def _check_parts(document: UrdfDocument, report: Report) -> None:
    by_name = {joint.name: joint for joint in document.joints}
    for joint in document.joints:
        if joint.kind == "planar" and joint.axis[2] < (1 - 1e-9) * math.hypot(*joint.axis):
            normal = " ".join(f"{component:g}" for component in joint.axis)
            report.add("M305", joint, f"the normal of its plane is {normal}")
        if joint.name in document.mimics and joint.mimic is not None:
            leader = by_name[joint.mimic.joint]
            if leader.mimic is not None:
                message = f"it mimics {leader.name!r}, which mimics {leader.mimic.joint!r}"
                report.add("M405", joint.mimic, message)
            if document.mimics[joint.name].multiplier == 0:
                report.add("M406", joint.mimic, "it mimics with the multiplier 0")
        if joint.name in ("universe", "root_joint"):
            report.add("M114", joint, "Pinocchio has a joint of this name of its own")
    for link in document.links:
        if link.name == "universe":
            report.add("M114", link, "Pinocchio has a frame of this name of its own")
        ground = link.name == document.root and link.massless
        if link.name == WORLD and document.root is not None and not ground:
            report.add("M114", link, "Drake takes this link for the inertial frame")


def _check_size(document: UrdfDocument, report: Report) -> None:
    free = (joint for joint in document.joints if joint.name not in document.mimics)
    count = sum(len(joint.joint().velocities) for joint in free)
    if count > MOST_VELOCITIES:
        report.add("M701", document.element, f"the robot has {count} velocities")
    if document.root is None:
        return
    depth = {document.root: 0}
    for joint in document.tree:
        depth[joint.child] = depth[joint.parent] + 1
    if max(depth.values()) > MOST_DEPTH:
        longest = f"the longest chain has {max(depth.values())} joints"
        report.add("M702", document.element, longest)


# all of them

_CHECKS = (
    _check_spelling,
    blanks.check,
    _check_masses,
    _check_sides,
    _check_units,
    _check_engines,
)

Fault: TypeAlias = tuple[Element, str, str]
"""The element at fault, where it is (e.g. "link 'arm'"), and what is wrong."""


@final
@dataclass(frozen=True)
class AddedRule:
    """A rule of another package, an entry point of the group `mecanique.lint_rules`.

    Args:
        rule: its code, name, severity, reason and remedy.
        check: yields the faults in a document, from its outermost element.
    """

    rule: Rule
    check: Callable[[Element], Iterable[Fault]]


def lint(
    path_or_text: Source,
    *,
    package_path: PackagePath | None = None,
    arguments: Mapping[str, str] | None = None,
    meshes: bool = False,
) -> tuple[Finding, ...]:
    """Return what is wrong in a URDF and what other programs read differently, line by line.

    The findings include errors if and only if `read_urdf` refuses the text
    when it is strict.

    Args:
        path_or_text: the path of a URDF file, or its text.
        package_path: folders to search for packages, before those of ROS_PACKAGE_PATH and
            AMENT_PREFIX_PATH.
        arguments: values of the arguments of a xacro file, which is expanded first.
        meshes: whether to read mesh files, too, for centers of mass outside of them and densities
            that no material has.

    Returns:
        What was found, to print or to loop over.

    Raises:
        InputError: if it is neither a path nor a text.

    Example:
        >>> len(mq.lint(mq.write_urdf(mq.textbook.load('rigid_bar_pendulum'))))
        0
    """
    if not isinstance(path_or_text, (str, os.PathLike)) or not os.fspath(path_or_text):
        raise InputError(f"expected the path of a URDF file or its text, got {path_or_text!r}")
    document, report = read_document(path_or_text, package_path, arguments)
    if document is not None:
        mechanism_of(document, report)
        for check in _CHECKS:
            check(document, report)
        for name in list_plugins("lint_rules"):
            added = load_plugin("lint_rules", name, AddedRule)
            for element, where, message in added.check(document.element):
                report.add(added.rule, Spot(element, where), message)
        for link in document.links:
            homogeneous.check(link, report, meshes=meshes)
    return tuple(sorted(report.findings, key=lambda finding: (finding.line, finding.code)))
