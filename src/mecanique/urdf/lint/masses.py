"""Masses that make the equations singular or that engines drop."""

from __future__ import annotations

import math

from mecanique.urdf.findings import Report
from mecanique.urdf.reading.document import Document
from mecanique.urdf.reading.joints import JointText
from mecanique.urdf.reading.links import Link

_TINY = 2.2e-16


def check(document: Document, report: Report) -> None:
    """Note masses and inertias that are allowed but suspicious."""
    root = document.root
    points = [link for link in document.links if link.mass and not any(link.inertia)]
    report.together(
        "M205", [(link.element, link.where) for link in points], "a mass without inertia"
    )
    for link in document.links:
        if link.mass == 0 and any(link.inertia):
            report.add("M204", link.element, link.where, "it has inertia but no mass")
        if 0 < link.mass < _TINY:
            report.add("M207", link.element, link.where, f"its mass is {link.mass:g} kg")
        if link.name == root and not link.massless:
            report.add(
                "M211", link.element, link.where, f"the root link has a mass of {link.mass:g} kg"
            )
    if root is not None:
        _massless(document, root, report)


def _massless(document: Document, root: str, report: Report) -> None:
    links = {link.name: link for link in document.links}
    below: dict[str, list[JointText]] = {}
    for joint in document.joints:
        below.setdefault(joint.parent, []).append(joint)
    order = [root]
    for name in order:
        order.extend(joint.child for joint in below.get(name, ()))
    carried: dict[str, list[Link]] = {}
    for name in reversed(order):
        # two are enough to distinguish none, one and several
        heavy = [link for joint in below.get(name, ()) for link in carried[joint.child]][:2]
        carried[name] = [*([] if links[name].massless else [links[name]]), *heavy][:2]
    for joint in document.joints:
        if not joint.moving or joint.armature or joint.name in document.mimics:
            continue
        if not carried[joint.child]:
            report.add("M206", joint.element, joint.where, "it moves nothing that has mass")
        elif carried[joint.child] == [links[joint.child]] and _no_resistance(
            joint, links[joint.child]
        ):
            report.add(
                "M206",
                joint.element,
                joint.where,
                f"link {joint.child!r} does not resist this motion",
            )


def _no_resistance(joint: JointText, link: Link) -> bool:
    """Whether a single body has neither inertia about the joint's axis nor mass along it."""
    if joint.kind == "prismatic":
        return link.mass == 0
    if joint.kind in ("ball", "floating", "planar", "universal"):
        return not any(link.inertia) and joint.kind != "floating" and not any(link.frame.xyz)
    if any(link.inertia):
        return False
    length = math.hypot(*joint.axis)
    (x, y, z), (a, b, c) = link.frame.xyz, (component / length for component in joint.axis)
    lever = math.hypot(y * c - z * b, z * a - x * c, x * b - y * a)
    return lever <= 1e-12 * max(1.0, math.hypot(x, y, z))
