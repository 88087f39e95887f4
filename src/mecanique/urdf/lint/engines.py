"""What Pinocchio, Drake and MuJoCo read differently, ignore or cannot handle."""

from __future__ import annotations

import math

from mecanique.urdf.dialect import DRAKE_JOINT, WORLD
from mecanique.urdf.findings import Located, Report, Spot
from mecanique.urdf.limits import MOST_DEPTH, MOST_VELOCITIES
from mecanique.urdf.reading.document import UrdfDocument
from mecanique.urdf.reading.joints import SINGLE


def check(document: UrdfDocument, report: Report) -> None:
    """Note what other programs make of the text."""
    joints, extensions = document.joints, document.extensions
    _each(document, report)
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
    _size(document, report)


def _each(document: UrdfDocument, report: Report) -> None:
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


def _size(document: UrdfDocument, report: Report) -> None:
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
