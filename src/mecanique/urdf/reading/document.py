"""A URDF text as written: links, joints and the additions of drake: tags, with their lines."""

from __future__ import annotations

import os
import stat
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import final

from mecanique.errors import InputError
from mecanique.urdf.dialect import DRAKE_JOINT
from mecanique.urdf.findings import Report, Spot
from mecanique.urdf.markup import Element
from mecanique.urdf.parse import MOST_BYTES, parse
from mecanique.urdf.reading.extensions import Extensions, read_extensions, with_rotors
from mecanique.urdf.reading.fields import Passage
from mecanique.urdf.reading.joints import JointText, Mimic, followers, read_joints
from mecanique.urdf.reading.links import Pictures, UrdfLink, implied_world, read_links
from mecanique.urdf.reading.packages import MeshSearch, PackagePath
from mecanique.urdf.reading.xacro import Letters, Numbers, XacroLines, expand


def root_of(
    links: list[UrdfLink], joints: list[JointText], report: Report, complete: bool
) -> str | None:
    """Return the root link's name; report joints that form no tree, and parts apart if complete."""
    by_name = {link.name: link for link in links}
    carrier: dict[str, JointText] = {}
    sound = complete and bool(links)
    for joint in joints:
        before = len(report.findings)
        for role, name in (("parent", joint.parent), ("child", joint.child)):
            if name not in by_name:
                report.add("M107", joint, f"its {role} {name!r} is no link")
        if joint.parent == joint.child:
            report.add("M108", joint, f"it joins link {joint.child!r} to itself")
        elif joint.child in carrier:
            earlier = carrier[joint.child]
            message = (
                f"its child {joint.child!r} is the child of {earlier.where} "
                f"at line {earlier.element.line} already"
            )
            report.add("M109", joint, message)
        carrier.setdefault(joint.child, joint)
        sound = sound and len(report.findings) == before
    if not sound:
        return None
    roots = [link for link in links if link.name not in carrier]
    children: dict[str, list[str]] = {}
    for joint in joints:
        children.setdefault(joint.parent, []).append(joint.child)
    reached: set[str] = set()
    _reach([link.name for link in roots], children, reached)
    for link in links:
        if link.name not in reached:
            cycle = _cycle(link.name, carrier)
            report.add("M110", link, f"it hangs on itself: {cycle}")
            _reach([link.name], children, reached)
    for link in roots[1:]:
        message = f"it is no joint's child, and neither is link {roots[0].name!r}"
        report.add("M111", link, message)
    return roots[0].name if len(roots) == 1 and not report.stopped else None


def _reach(start: list[str], children: dict[str, list[str]], reached: set[str]) -> None:
    """Add all links that hang from some links."""
    reached.update(start)
    waiting = list(start)
    while waiting:
        for child in children.get(waiting.pop(), ()):
            if child not in reached:
                reached.add(child)
                waiting.append(child)


def _cycle(link: str, carrier: dict[str, JointText]) -> str:
    chain = [link]
    while carrier[chain[-1]].parent not in chain[:6] and len(chain) < 6:
        chain.append(carrier[chain[-1]].parent)
    names = [*chain, carrier[chain[-1]].parent]
    return " ← ".join(names)


Source = str | os.PathLike[str]
"""A URDF text, or the path of a file: a string with "<" in it is a text."""

_FORMATS = {
    "sdf": ": this is SDF, Gazebo's format; `mecanique.read` reads it",
    "mujoco": ": this is MJCF, MuJoCo's own format; `mecanique.read` reads it",
    "mujocoinclude": ": this is a part of MJCF; name the file that includes it",
    "gazebo": ": this is SDF before 1.3, which is not read",
    "COLLADA": ": this is a mesh, not a robot",
}
"""What other outermost elements say a file is."""


@final
@dataclass(frozen=True)
class UrdfDocument:
    """The contents of a URDF text."""

    text: bytes
    name: str
    element: Element
    links: tuple[UrdfLink, ...]
    joints: tuple[JointText, ...]
    root: str | None  # name of the root link; None if there is not one
    mimics: dict[str, Mimic]  # how mimicking joints follow free ones, by name
    extensions: Extensions  # what the drake: tags add
    rotors: tuple[Spot, ...]  # the elements that give rotor inertias
    lost: tuple[Passage, ...]  # the meshes that were not found
    searched: str  # where packages were looked for, in words
    numbers: Numbers  # of a xacro file's arguments and properties; none of another's

    @cached_property
    def tree(self) -> tuple[JointText, ...]:
        """The joints from the root on, each behind that which carries its parent."""
        below: dict[str, list[JointText]] = {}
        for joint in self.joints:
            below.setdefault(joint.parent, []).append(joint)
        order = [] if self.root is None else below.get(self.root, [])[:]
        for joint in order:
            order += below.get(joint.child, ())
        return tuple(order)


def read_document(
    source: Source,
    package_path: PackagePath | None = None,
    arguments: Mapping[str, str] | None = None,
    letters: Letters | None = None,
) -> tuple[UrdfDocument | None, Report]:
    """Return the contents of a URDF and the faults found; no contents if it is not a robot."""
    file = None if isinstance(source, str) and "<" in source else Path(source)
    report = Report(None if file is None else str(source))
    search = MeshSearch(file, package_path)
    places: XacroLines | None = None
    numbers: Numbers = {}
    data = source if file is None and isinstance(source, str) else _bytes(file, report)
    named = file is not None and file.suffix.lower() == ".xacro"
    if file is not None and isinstance(data, bytes) and (named or _holds_macros(data)):
        data, places, numbers = expand(file, arguments or {}, letters, search, report)
        if not named and data is not None:
            report.add("M008", 1, "it holds xacro macros, and was expanded")
    elif arguments and data is not None:
        raise InputError(f"expected a .xacro file with arguments, got {report.file or 'a text'}")
    robot = None if data is None else parse(data, report)
    if robot is not None and places is not None:
        robot = places.put(robot)
    if data is None or robot is None or not _is_robot(robot, report):
        return None, report
    text = data.encode() if isinstance(data, str) else data
    return _read_robot(robot, text, search, numbers, report), report


def _holds_macros(data: bytes) -> bool:
    """Return whether a text has elements of xacro outside its comments."""
    first, *rest = data.split(b"<!--")
    behind = (part.partition(b"-->")[2] for part in rest)
    return b"<xacro:" in first or any(b"<xacro:" in part for part in behind)


def _is_robot(element: Element, report: Report) -> bool:
    """Return whether an outermost element is a robot's, with its macros expanded."""
    if element.tag != "robot":
        known = _FORMATS.get(element.tag, "")
        message = f"expected <robot> as the outermost element, got <{element.tag[:60]}>{known}"
        report.add("M005", element, message)
        return False
    macro = next((part for part in element.walk() if part.tag.startswith("xacro:")), None)
    if macro is not None:
        message = "the text holds xacro macros that are not expanded"
        report.add("M006", Spot(macro, f"<{macro.tag}>"), message)
    return macro is None


def _read_robot(
    robot: Element, text: bytes, search: MeshSearch, numbers: Numbers, report: Report
) -> UrdfDocument:
    """Return the contents of a robot, and report their faults."""
    if "name" not in robot.attributes:
        report.aside.add("M101", robot, "the robot has no name")
    named = "name" in robot.attributes and Passage(robot, report.aside).name()
    pictures = Pictures(report.aside, search)
    pictures.declare(robot)
    links = read_links(robot, report, pictures)
    joints = read_joints(robot, report)
    links += implied_world(links, joints, report)
    joints, rotors = with_rotors(robot, joints, report)
    tags = [element.tag for element in robot.children]
    written = sum(link.element.tag == "link" for link in links)
    complete = written == tags.count("link")
    complete = complete and len(joints) == tags.count("joint") + tags.count(DRAKE_JOINT)
    root = root_of(links, joints, report, complete)
    mimics = followers(joints, report)
    extensions = read_extensions(robot, {link.name for link in links}, joints, report)
    return UrdfDocument(
        text=text,
        name=named or "robot",
        element=robot,
        links=tuple(links),
        joints=tuple(joints),
        root=root,
        mimics=mimics,
        extensions=extensions,
        rotors=tuple(rotors),
        lost=tuple(pictures.lost),
        searched=search.searched,
        numbers=numbers,
    )


def _bytes(file: Path | None, report: Report) -> bytes | None:
    """The content of a regular file; devices and pipes might never end."""
    if file is None:
        return None
    try:
        if not stat.S_ISREG(os.stat(file).st_mode):
            report.add("M001", 1, "it is no file but a folder or device")
            return None
        with file.open("rb") as stream:
            return stream.read(MOST_BYTES + 1)
    except (OSError, ValueError) as error:
        reason = getattr(error, "strerror", None) or str(error)
        report.add("M001", 1, f"the file cannot be read: {reason}")
        return None
