"""Numbers that look like millimeters, grams or degrees, or an inertia about another point."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from mecanique.model import slips
from mecanique.model.bodies.visuals import Box, Cylinder, Sphere, Visual
from mecanique.model.placement import Placement
from mecanique.urdf.findings import Located, Report
from mecanique.urdf.lint.homogeneous import solid_of
from mecanique.urdf.reading.document import UrdfDocument
from mecanique.urdf.reading.links import UrdfLink

_METERS, _DEGREES, _GRAMS = (
    f": {unit[0].text}?" for unit in (slips.LENGTH, slips.ANGLE, slips.MASS)
)
"""What a distance, an angle or a mass that is too large looks like, as in `mecanique diff`."""

_FAR = 20.0
"""A distance within a robot that is likely in millimeters [m]."""

_DENSE = 30_000.0
"""A density above that of every metal [kg/m³]."""


def check(document: UrdfDocument, report: Report) -> None:
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
        _angles(joint.origin, joint, report)
    for link in document.links:
        _angles(link.frame, link, report)
        for visual in (*link.visuals, *link.collisions):
            _angles(visual.placement, link, report)
        if link.mass > 0:
            _link(link, reach.get(link.name, 0.0), report)


def _angles(place: Placement, whose: Located, report: Report) -> None:
    most = max(abs(angle) for angle in place.rpy)
    if most > 2 * math.pi + 0.01:
        report.add("M309", whose, f"an angle of its placement is {most:g} radians{_DEGREES}")


def _link(link: UrdfLink, reach: float, report: Report) -> None:
    center = math.hypot(*link.frame.xyz)
    if center > _FAR:
        report.add("M310", link, f"its center of mass is {center:g} m away{_METERS}")
    drawn = [visual for visual in (*link.collisions, *link.visuals) if _size(visual) > 0]
    size = max([center, reach, *(math.hypot(*v.placement.xyz) + _size(v) for v in drawn)])
    gyration = math.sqrt(max(sum(link.inertia[:3]) / 2, 0.0) / link.mass)
    if (size > 0 and gyration > 5 * max(size, 0.2)) or gyration > 30 or 0 < gyration < size / 300:
        message = (
            f"its inertia is that of its mass {gyration:.3g} m away from the center, "
            f"but it is {size:.3g} m large"
        )
        report.add("M208", link, message)
    shapes = [visual for visual in link.collisions if _size(visual) > 0]
    if len(shapes) == len(link.collisions) == 1:
        solid = solid_of(shapes, meshes=False)
        if solid and link.mass > 5 and link.mass > _DENSE * solid.volume:
            density = link.mass / solid.volume
            report.add("M209", link, f"its density is {density:.3g} kg/m³{_GRAMS}")
    shapes = shapes or [visual for visual in link.visuals if _size(visual) > 0]
    if len(shapes) == 1:
        _point(link, shapes[0], report)


def _point(link: UrdfLink, shape: Visual, report: Report) -> None:
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


def _size(visual: Visual) -> float:
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
