"""Masses that make the equations singular or that engines drop."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Sequence

import numpy as np

from mecanique.arrays import Array
from mecanique.model.placement import pose_of
from mecanique.urdf.findings import Report
from mecanique.urdf.reading.document import UrdfDocument
from mecanique.urdf.reading.joints import JointText
from mecanique.urdf.reading.links import UrdfLink

_TINY = 2.2e-16
"""Pinocchio loses the lever of masses below [kg]."""

_ROUNDING, _LEVER = 1e-14, 1e-12
"""What a turn or an arm leaves of an inertia and of a lever that are zero, relative to size."""


def check(document: UrdfDocument, report: Report) -> None:
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
