"""URDF text -> mechanism.

Nothing of the parsers of other programs is used, so that what they read wrongly can be found. What
the equations do not use (collisions, dry friction, tags of other programs) is not warned about
here: `mecanique.urdf.lint` tells all of it.
"""

from __future__ import annotations

import os
from collections import Counter
from typing import Literal

from mecanique.errors import InputError, MechanismError
from mecanique.model.bodies import Body
from mecanique.model.coordinates import Coordinates
from mecanique.model.expression import Scalar, Vector, coordinate
from mecanique.model.forces import AnyForce, JointDamper
from mecanique.model.joints import Floating, Joint
from mecanique.model.mechanism import Mechanism
from mecanique.model.placement import vector
from mecanique.urdf.dialect import SCREW, WORLD
from mecanique.urdf.findings import Report
from mecanique.urdf.names import Names
from mecanique.urdf.reading.document import Document, Source, read_document
from mecanique.urdf.reading.meshes import PackagePath

__all__ = ["GRAVITY", "mechanism_of", "read_urdf"]

GRAVITY = (0.0, 0.0, -9.81)
"""Acceleration of free fall that a URDF does not state [m/s²]."""


def read_urdf(
    path_or_text: Source,
    *,
    gravity: Vector = GRAVITY,
    root: Literal["fixed", "floating"] = "fixed",
    package_path: PackagePath | None = None,
) -> Mechanism:
    """Return the mechanism that a URDF describes.

    Joint coordinates bear the names of their joints. Joint damping, springs and dampers of the
    drake: dialect, its ball and distance constraints, mimic joints and rotor inertias are read; dry
    friction and collisions do not enter the equations. `mecanique.lint` says what is not used and
    what other programs read differently.

    Args:
        path_or_text: the path of a URDF file, or its text.
        gravity: shape (3,), acceleration of free fall in world axes [m/s²].
        root: "fixed" holds the root link in the world, "floating" lets it move freely in it.
        package_path: folders to search for the packages of meshes, before those of
            ROS_PACKAGE_PATH.

    Raises:
        UrdfError: with every error found, each with its line.
        InputError: if an argument is not what is expected.
    """
    if not isinstance(path_or_text, (str, os.PathLike)) or not os.fspath(path_or_text):
        raise InputError(f"expected the path of a URDF file or its text, got {path_or_text!r}")
    if root not in ("fixed", "floating"):
        raise InputError(f"expected 'fixed' or 'floating' for the root, got {root!r}")
    document, report = read_document(path_or_text, package_path)
    mechanism = None if document is None else mechanism_of(document, report, gravity, root)
    report.refuse()
    if mechanism is None:
        raise InputError(f"expected a URDF, got {path_or_text!r}")
    return mechanism


def mechanism_of(
    document: Document,
    report: Report,
    gravity: Vector = GRAVITY,
    root: Literal["fixed", "floating"] = "fixed",
) -> Mechanism | None:
    """Return the mechanism of a document; None if it has errors, which are in the report.

    Args:
        document: what the text says.
        report: its faults so far; what the model finds is added.
        gravity: shape (3,), acceleration of free fall in world axes [m/s²].
        root: "fixed" or "floating".
    """
    if report.errors or document.root is None:
        return None
    joints, between = _joints(document, report)
    if report.errors:
        return None
    bodies = [link.body() for link in document.links if link.name not in between]
    ground = document.root
    if root == "floating":
        ground = Names(body.name for body in bodies).free(WORLD)
        bodies.insert(0, Body(ground))
        name = Names(joint.name for joint in joints).free("root_joint")
        joints.insert(0, Floating(name, ground, document.root))
    joints = _with_own_names(joints)
    try:
        return Mechanism(
            document.name,
            tuple(bodies),
            tuple(joints),
            forces=_forces(document),
            loops=tuple(document.extensions.loops),
            coordinates=Coordinates((), _map(document, joints)),
            gravity=vector(gravity, "gravity"),
            ground=ground,
        )
    except MechanismError as error:
        for fault in error.faults:
            report.add("M115", document.element, "", fault)
        return None


def _joints(document: Document, report: Report) -> tuple[list[Joint], set[str]]:
    """Return the joints, and the links within a screw, whose slide and hinge are one joint."""
    slides = {joint.child: joint for joint in document.joints if joint.screw}
    carried = Counter(joint.parent for joint in document.joints)
    bare = {link.name for link in document.links if link.massless and not link.visuals}
    joints: dict[str, Joint] = {}
    for text in document.joints:
        slide = slides.get(text.parent)
        screw = text.threaded(slide) if slide and carried[text.parent] == 1 else None
        if screw is not None and text.parent in bare:
            del slides[text.parent]
            joints[text.name] = screw
        elif not text.screw:
            joints[text.name] = text.joint()
    for slide in slides.values():
        report.add(
            "M115",
            slide.element,
            slide.where,
            f"<{SCREW}> expects a slide that mimics the hinge behind it, without offset, about the "
            "same axis, with a link without mass or anything else between them",
        )
    return list(joints.values()), {t.child for t in document.joints if t.screw}


def _with_own_names(joints: list[Joint]) -> list[Joint]:
    """Give each joint coordinates of its own: a joint may be called t, or as another's are."""
    names = Names(["t"])
    named: dict[str, Joint] = {}
    # velocities of quaternions have fixed names, so these joints choose first
    for joint in sorted(joints, key=lambda joint: not joint.quaternion):
        if joint.quaternion:
            for velocity in joint.velocities:
                names.free(velocity)
        # the mark of a velocity is kept for velocities
        own = tuple(names.free(name.replace("'", "_")) for name in joint.coordinates)
        named[joint.name] = joint if own == joint.coordinates else joint.renamed(own)
    return [named[joint.name] for joint in joints]


def _map(document: Document, joints: list[Joint]) -> tuple[tuple[str, Scalar], ...]:
    names = {joint.name: joint.coordinates[-1] for joint in joints if joint.coordinates}
    return tuple(
        (names[name], _linear(follower.multiplier, names[follower.leader], follower.offset))
        for name, follower in document.mimics.items()
        if name in names
    )


def _linear(multiplier: float, name: str, offset: float) -> Scalar:
    if multiplier == 0:
        return offset
    term = coordinate(name) if multiplier == 1 else multiplier * coordinate(name)
    return term + offset if offset else term


def _forces(document: Document) -> tuple[AnyForce, ...]:
    names = Names(force.name for force in document.extensions.forces)
    dampers = [
        JointDamper(names.free(f"{joint.name}_damper"), joint.name, joint.damping)
        for joint in document.joints
        if joint.damping
    ]
    return (*document.extensions.forces, *dampers)
