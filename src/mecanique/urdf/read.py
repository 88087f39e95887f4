"""URDF text -> mechanism.

No parser of another program is used, so that their mistakes can be found. There are no warnings
here about what the equations do not use (collisions, dry friction, tags of other programs):
`mecanique.urdf.lint` reports all of it.
"""

from __future__ import annotations

import os
from collections import Counter
from collections.abc import Collection, Mapping
from dataclasses import replace
from typing import Any, Literal

from mecanique.errors import InputError, MechanismError
from mecanique.model.bodies import Body
from mecanique.model.coordinates import Coordinates
from mecanique.model.expression import Scalar, Vector, coordinate
from mecanique.model.force_base import AnyForce
from mecanique.model.forces import JointDamper
from mecanique.model.joints import Floating, Joint
from mecanique.model.mechanism import Mechanism
from mecanique.model.mechanism.origin import Origin
from mecanique.model.placement import vector
from mecanique.urdf.dialect import ACTUATOR_INERTIA, FOREIGN, SCREW, UNUSED, WORLD
from mecanique.urdf.findings import Report
from mecanique.urdf.names import Names
from mecanique.urdf.parse import parse
from mecanique.urdf.reading.document import Source, UrdfDocument, read_document
from mecanique.urdf.reading.letters import with_armature, with_letters, with_properties
from mecanique.urdf.reading.native_tags import in_coordinates
from mecanique.urdf.reading.packages import PackagePath
from mecanique.urdf.reading.xacro import Letters, choose
from mecanique.urdf.toml_loops import with_loops

GRAVITY = (0.0, 0.0, -9.81)
"""Acceleration of free fall that a URDF does not state [m/s²]."""


def say_unread(origin: Origin) -> str:
    """Say which elements of a URDF are in no mechanism, and on which line the first stands."""
    robot = parse(origin.text, Report(origin.file))
    lines: dict[str, list[int]] = {}
    for element in robot.walk() if robot else ():
        # of a transmission, the rotor is in the mechanism
        rotors = any(part.child(ACTUATOR_INERTIA) for part in element.children)
        if element.tag in UNUSED | FOREIGN | {"collision"} and not rotors:
            lines.setdefault(element.tag, []).append(element.line)
    said = (f"<{tag}> ({len(at)}, first on line {at[0]})" for tag, at in lines.items())
    return f"Read from URDF, without {', '.join(said)}." if lines else ""


def read_urdf(
    path_or_text: Source,
    *,
    gravity: Vector = GRAVITY,
    root: Literal["fixed", "floating"] = "fixed",
    package_path: PackagePath | None = None,
    damping: bool = True,
    armature: float | Mapping[str, float] | None = None,
    parameters: str | Collection[str] = (),
    strict: bool = False,
    arguments: Mapping[str, str] | None = None,
    loops: str | os.PathLike[str] | None = None,
) -> Mechanism:
    """Return the mechanism that a URDF describes.

    Masses, lengths and inertias are numbers, unless letters are asked for; the letters of a link
    `arm` and a joint `elbow`, of which `mecanique.simulate_many` and the methods of `Mechanism` can
    change the values, are

    - "masses": `m_arm` [kg];
    - "lengths": `x_elbow`, `y_elbow`, `z_elbow`, where the joint stands in its parent, and
      `cx_arm`, `cy_arm`, `cz_arm`, the center of mass in the link's frame [m];
    - "inertias": `Ixx_arm`, `Iyy_arm`, `Izz_arm`, `Ixy_arm`, `Ixz_arm`, `Iyz_arm` about the center
      of mass, in the link's axes [kg·m²].

    A character that no letter can have becomes "_"; a letter that is taken already gets a number.
    What is zero has a letter only if it is asked for by that. Each is varied alone: another mass
    leaves the inertia as it is.

    Joint coordinates bear the names of their joints. A floating root moves in the joint
    `root_joint` (with a number if that name is taken): position `root_joint_x`, `_y`, `_z` in the
    world, unit quaternion `root_joint_qx`, `_qy`, `_qz`, `_qw` (w last); velocities
    `root_joint_vx`, `_vy`, `_vz` of the root's origin and `root_joint_wx`, `_wy`, `_wz`, angular,
    both in the root's own axes; `mecanique.floating` gives them from other conventions.

    The equations of motion hold for any numbers: faults of pictures and limits, and inertias that
    no real body has, do not keep a text from being read; they are listed in
    `mechanism.origin.flaws`.

    Joint damping, springs and dampers of the drake: dialect, its ball and distance constraints,
    mimic joints and rotor inertias are read; dry friction and collisions do not enter the
    equations. `mecanique.lint` says what is not used and what other programs read differently.

    Args:
        path_or_text: the path of a URDF or xacro file, or a URDF text.
        gravity: shape (3,), acceleration of free fall in world axes [m/s²].
        root: "fixed" holds the root link in the world, "floating" lets it move freely in it.
        package_path: folders to search for packages, before those of ROS_PACKAGE_PATH and
            AMENT_PREFIX_PATH.
        damping: whether the damping of joints' <dynamics> is read.
        armature: inertia of the rotors seen at the joints, instead of what is written: one number
            for all joints with one coordinate, or by name of the joint [kg·m² or kg].
        parameters: what gets letters: "masses", "lengths" or "inertias", or a collection of these
            and of letters, e.g. ("masses", "z_elbow"); of a xacro file also the names of its
            arguments and properties, on which masses, lengths and inertias then depend as in the
            file.
        strict: whether to refuse a text with any error, also with those that its equations of
            motion do without (`mechanism.origin.flaws`).
        arguments: values of the arguments of a xacro file, which is expanded first (extra `xacro`).
        loops: path of a TOML file with loops and springs beside the URDF
            (`mecanique.urdf.toml_loops`).

    Returns:
        The mechanism.

    Raises:
        UrdfError: with every error found, each with its line.
        InputError: if an argument is not what is expected.
        UnknownNameError: if a joint of the armatures, a letter or an argument does not exist.
        MechanismError: if an armature is negative.

    Example:
        >>> text = mq.write_urdf(mq.textbook.load('rigid_bar_pendulum'))
        >>> mq.read_urdf(text).nv
        1
    """
    if not isinstance(path_or_text, (str, os.PathLike)) or not os.fspath(path_or_text):
        raise InputError(f"expected the path of a URDF file or its text, got {path_or_text!r}")
    if root not in ("fixed", "floating"):
        raise InputError(f"expected 'fixed' or 'floating' for the root, got {root!r}")
    kept = {parameters} if isinstance(parameters, str) else set(parameters)
    document, report = read_document(path_or_text, package_path, arguments, {} if kept else None)
    for name, value in (("damping", damping), ("strict", strict)):
        if not isinstance(value, bool):
            raise InputError(f"expected True or False for {name}, got {value!r}")
    mechanism = None
    if document is not None:
        mechanism = mechanism_of(document, report, gravity, root, damping=damping)
    report.refuse(strict=strict)
    if mechanism is None or document is None:
        raise InputError(f"expected a URDF, got {path_or_text!r}")
    said = list[str]()
    if any(finding.name == "xacro-in-urdf" for finding in report.findings):
        said.append("Its xacro macros were expanded.")
    if rubbing := [joint.name for joint in document.joints if joint.friction and joint.moving]:
        said.append(f"Read from URDF, without dry friction of {', '.join(rubbing)}.")
    origin = Origin(report.file, document.text, report.flaws)
    mechanism = replace(mechanism, origin=origin, about=" ".join(said))
    if loops is not None:
        mechanism = with_loops(mechanism, loops)
    values, known = choose(document.numbers, kept) if kept else ({}, [])
    if values:

        def read_with(letters: Letters) -> Mechanism:
            contents, faults = read_document(path_or_text, package_path, arguments, letters)
            varied = contents and mechanism_of(contents, faults, gravity, root, damping=damping)
            faults.refuse(strict=False)
            assert varied, "what cannot be read is refused"
            return varied if loops is None else with_loops(varied, loops)

        mechanism = with_properties(mechanism, values, read_with)
        parameters = kept - values.keys()
    return with_letters(with_armature(mechanism, armature), parameters, known)


def mechanism_of(
    document: UrdfDocument,
    report: Report,
    gravity: Vector = GRAVITY,
    root: Literal["fixed", "floating"] = "fixed",
    *,
    damping: bool = True,
) -> Mechanism | None:
    """Return the mechanism of a document; None if it has errors, which are in the report."""
    if report.stopped or document.root is None:
        return None
    joints, between = _joints(document, report)
    if report.stopped:
        return None
    bodies = [link.body() for link in document.links if link.name not in between]
    ground = document.root
    if root == "floating":
        ground = Names(body.name for body in bodies).free(WORLD)
        bodies.insert(0, Body(ground))
        name = Names(joint.name for joint in joints).free("root_joint")
        joints.insert(0, Floating(name, ground, document.root))
    joints = _with_distinct_names(joints)
    named = {joint.name: joint for joint in joints}
    parts = {**document.extensions.parts, "forces": _forces(document, damping)}
    stated: dict[str, Any] = {}
    for home, things in parts.items():
        stated[home] = tuple(in_coordinates(thing, named) for thing in things)
    try:
        return Mechanism(
            document.name,
            tuple(bodies),
            tuple(joints),
            coordinates=Coordinates((), _map(document, joints)),
            gravity=vector(gravity, "gravity"),
            ground=ground,
            **stated,
        )
    except MechanismError as error:
        for fault in error.faults:
            report.add("M115", document.element, fault)
        return None


def _joints(document: UrdfDocument, report: Report) -> tuple[list[Joint], set[str]]:
    """Return the joints, and the links within a screw, whose slide and hinge are one joint."""
    slides = {joint.child: joint for joint in document.joints if joint.screw}
    carried = Counter(joint.parent for joint in document.joints)
    bare = {link.name for link in document.links if link.massless and not link.visuals}
    joints: dict[str, Joint] = {}
    for text in document.joints:
        slide = slides.get(text.parent)
        screw = text.join_screw(slide) if slide and carried[text.parent] == 1 else None
        if screw is not None and text.parent in bare:
            del slides[text.parent]
            joints[text.name] = screw
        elif not text.screw:
            joints[text.name] = text.joint()
    for slide in slides.values():
        message = (
            f"<{SCREW}> expects a slide that mimics the hinge behind it, without offset, about the "
            "same axis, with a link without mass or anything else between them"
        )
        report.add("M115", slide, message)
    return list(joints.values()), {t.child for t in document.joints if t.screw}


def _with_distinct_names(joints: list[Joint]) -> list[Joint]:
    """Give each joint its own coordinates: a joint may be called t, or like a coordinate."""
    names = Names(["t"])
    named: dict[str, Joint] = {}
    # velocities of quaternions have fixed names, so these joints come first
    for joint in sorted(joints, key=lambda joint: not joint.quaternion):
        if joint.quaternion:
            for velocity in joint.velocities:
                names.free(velocity)
        # the mark of a velocity is reserved for velocities
        coordinates = tuple(names.free(name.replace("'", "_")) for name in joint.coordinates)
        named[joint.name] = (
            joint if coordinates == joint.coordinates else joint.renamed(coordinates)
        )
    return [named[joint.name] for joint in joints]


def _map(document: UrdfDocument, joints: list[Joint]) -> tuple[tuple[str, Scalar], ...]:
    names = {joint.name: joint.coordinates[-1] for joint in joints if joint.coordinates}
    return tuple(
        (names[name], _linear(mimic.multiplier, names[mimic.joint], mimic.offset))
        for name, mimic in document.mimics.items()
        if name in names
    )


def _linear(multiplier: float, name: str, offset: float) -> Scalar:
    if multiplier == 0:
        return offset
    term = coordinate(name) if multiplier == 1 else multiplier * coordinate(name)
    return term + offset if offset else term


def _forces(document: UrdfDocument, damping: bool) -> list[AnyForce]:
    forces = document.extensions.forces
    names = Names(force.name for force in forces)
    dampers = [
        JointDamper(names.free(f"{joint.name}_damper"), joint.name, joint.damping)
        for joint in document.joints
        if damping and joint.damping
    ]
    return [*forces, *dampers]
