"""Symbols of the dimensions of bodies: lengths of rods, radii of disks, masses of pieces."""

from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np

from mecanique.figure.paper.arrows import arrow, dimension
from mecanique.figure.paper.marks import Mark, Point, Stroke, Words, across, label, rich, unit
from mecanique.figure.setting import CONE, Setting, is_zero
from mecanique.figure.solids import Solid, radius_of
from mecanique.model.bodies import Body
from mecanique.model.bodies.visuals import Box, Cylinder
from mecanique.model.expression import symbols_in
from mecanique.model.joints import Prismatic

MEASURED_LENGTH, MEASURED_RADIUS = 40.0, 18.0
"""Shorter lengths on paper get no dimension [pt]."""

DIMENSION_OFFSET = 18.0
"""Distance from a rod to its dimension line [pt]."""

SLOPE_RADIUS = 60.0
"""Radius of the arc that shows an incline's angle [pt]."""

RAIL_GAP = 8.0
"""How far a rail lies below what slides on it [pt]."""

ASIDE = 0.3
"""Cosine of the angle to the view up to which the radius of a disk in space is drawn."""

RADIUS_ANGLE = -0.7
"""Angle at which a disk's radius is drawn, on paper, y downwards [rad]."""

ALONG_ROD = 0.62
"""Where along a rod its mass is written: beyond the middle, which holds its length."""

ROOMY = 26.0
"""The mass of a solid wider than this on paper is written inside it [pt]."""

JOINT_ROOM = 14.0
"""Space that a joint takes up around itself [pt]."""

BELOW_LEFT = np.array([-1.0, 0.6])
"""Where a mass is written in a solid whose middle is occupied."""


def lengths(setting: Setting) -> Iterator[Mark]:
    """Yield the symbols of rods' lengths and of disks' radii, each once."""
    written: set[str] = set()
    for solid in setting.solids:
        geometry = solid.geometry
        if not isinstance(geometry, Cylinder):
            continue
        rod = solid.kind == "rod"
        name = setting.name(geometry.length if rod else geometry.radius)
        if not name or name in written:
            continue
        marks = [*(_length if rod else _radius)(setting, solid, name)]
        if marks:
            written.add(name)
        yield from marks


def _length(setting: Setting, rod: Solid, name: str) -> Iterator[Mark]:
    a, b = setting.camera.at(rod.ends)
    if math.hypot(*(b - a)) < MEASURED_LENGTH:
        return
    if setting.camera.flat:
        yield from dimension(a, b, name, _outward(setting, a, b) * DIMENSION_OFFSET)
    else:
        yield label((a + b) / 2, name, across(unit(b - a)), 9.0)


def _radius(setting: Setting, disk: Solid, name: str) -> Iterator[Mark]:
    """An arrow to the rim of a disk seen face on, or in space at least from aside."""
    camera = setting.camera
    radius, facing = disk.size * camera.scale, float(disk.pose[:3, 2] @ camera.toward)
    least = 0.9 if camera.flat else 0.0 if disk.form == CONE else ASIDE
    if radius <= MEASURED_RADIUS or abs(facing) < least:
        return
    way = np.array([math.cos(RADIUS_ANGLE), math.sin(RADIUS_ANGLE)])
    if camera.flat:
        center = camera.at(disk.ends[0])
        rim = center + radius * way
    else:
        half = len(disk.corners) // 2
        edge = disk.corners[half:] if facing > 0 else disk.corners[:half]
        center, around = camera.at(edge.mean(axis=0)), camera.at(edge)
        rim = around[int(np.argmax((around - center) @ way))]
    yield from arrow(center, rim, "thin")
    yield label((center + rim) / 2, name, np.array([-0.6, -0.8]), 4.0)


def slopes(setting: Setting) -> Iterator[Mark]:
    """Yield the angles of inclines on the ground, from the horizontal to the plate."""
    mechanism, camera = setting.mechanism, setting.camera
    plates = [solid for solid in setting.solids if solid.body == mechanism.ground]
    visuals = [
        visual
        for shape in mechanism.body(mechanism.ground).shapes
        for visual in shape.visuals
        if isinstance(visual.geometry, Box)
    ]
    if not camera.flat or len(visuals) != len(plates):
        return
    yield from _rail_slopes(setting)
    for visual, plate in zip(visuals, plates, strict=True):
        names = [setting.name(angle) for angle in visual.placement.rpy if not is_zero(angle)]
        a, b = camera.at(plate.ends)
        low, high = (a, b) if a[1] > b[1] else (b, a)
        if len(names) != 1 or not names[0] or abs(high[1] - low[1]) < 1.0:
            continue
        yield from _slope(low, high, names[0])


def _rail_slopes(setting: Setting) -> Iterator[Mark]:
    """The angle by which gravity is tilted against a slide on the ground."""
    mechanism, camera = setting.mechanism, setting.camera
    letters = {p.symbol for p in mechanism.parameters if p.unit == "rad"}
    used = frozenset().union(*map(symbols_in, mechanism.gravity)) & letters
    for joint in mechanism.joints:
        if len(used) != 1 or joint.parent != mechanism.ground or not isinstance(joint, Prismatic):
            continue
        along = unit(camera.at(setting.axis(joint)))
        along = along if along[1] > 0 else -along
        below = across(along)
        below = below if below[1] > 0 else -below
        low = camera.at(setting.point(joint.child))
        low = low + (setting.reach(joint.child, below) - float(low @ below)) * below
        low = low + (setting.reach(joint.child, along) - float(low @ along) + SLOPE_RADIUS) * along
        low = low + RAIL_GAP * below
        yield from _slope(low, low - along, *used)


def _slope(low: Point, high: Point, name: str) -> Iterator[Mark]:
    """The angle at the foot of an incline, from the horizontal."""
    inward = np.array([math.copysign(1.0, high[0] - low[0]), 0.0])
    slope = math.atan2(low[1] - high[1], abs(high[0] - low[0]))
    turn = np.linspace(0.0, slope, 25)[:, None]
    points = low + SLOPE_RADIUS * (np.cos(turn) * inward - np.sin(turn) * np.array([0.0, 1.0]))
    yield Stroke(np.array([low, low + 1.3 * SLOPE_RADIUS * inward]), "axis")
    yield Stroke(points, "thin")
    yield label(points[12], name, points[12] - low, 5.0)


def _outward(setting: Setting, a: Point, b: Point) -> float:
    """The side of a line with less of the figure: 1 to the left going from a to b, or -1."""
    side = across(unit(b - a))
    middles = [setting.camera.at(solid.ends.mean(axis=0)) for solid in setting.solids]
    return -1.0 if sum(float((middle - a) @ side) for middle in middles) > 1e-6 else 1.0


def masses(setting: Setting) -> Iterator[Mark]:
    """Yield the symbol of each piece's mass, in or beside it."""
    for body in setting.mechanism.bodies:
        for name, solid in _named_pieces(setting, body):
            yield _mass(setting, name, solid)


def _named_pieces(setting: Setting, body: Body) -> Iterator[tuple[str, Solid]]:
    """The pieces of a body whose mass has a short name, each with its largest solid."""
    solids = iter([solid for solid in setting.solids if solid.body == body.name])
    for shape in body.shapes:
        pieces = [solid for _, solid in zip(shape.visuals, solids, strict=False)]
        name = setting.name(shape.mass)
        if pieces and name:
            yield name, max(pieces, key=lambda solid: float(np.ptp(solid.corners, axis=0).max()))


def _mass(setting: Setting, name: str, solid: Solid) -> Words:
    camera = setting.camera
    at = camera.at(solid.ends.mean(axis=0))
    roomy = float(np.ptp(camera.at(solid.corners), axis=0).min()) > ROOMY
    match solid.kind:
        case "rod":
            a, b = camera.at(solid.ends)
            inward = -_outward(setting, a, b) * across(unit(b - a))
            return label(a + ALONG_ROD * (b - a), name, inward, 7.0)
        case "ball":
            return label(at, name, setting.clear_side(at), radius_of(solid, camera) + 4.0)
        case "cylinder" if not roomy:
            return label(at, name, setting.clear_side(at), solid.size * camera.scale + 4.0)
    if not roomy:
        return _beside(setting, name, solid, at)
    if _is_pinned(setting, solid, at):
        return label(at, name, BELOW_LEFT, 8.0)
    return Words(at, rich(name))


def _beside(setting: Setting, name: str, solid: Solid, at: Point) -> Words:
    """A letter to the left or right of a body, on the side facing away from the rest."""
    middles = [setting.camera.at(solid.ends.mean(axis=0)) for solid in setting.solids]
    left = at[0] <= float(np.mean(middles, axis=0)[0]) + 1
    side = np.array([-1.0 if left else 1.0, 0.0])
    edge = np.array([side[0] * setting.reach(solid.body, side), at[1]])
    return label(edge, name, side, 6.0)


def _is_pinned(setting: Setting, solid: Solid, at: Point) -> bool:
    """Whether a hinge stands in the middle of a solid; a disk has one there."""
    joints = [j for j in setting.mechanism.joints if solid.body in (j.parent, j.child)]
    seats = [setting.camera.at(setting.point(joint.child)) for joint in joints]
    near = solid.kind == "cylinder" or any(math.hypot(*(s - at)) < JOINT_ROOM for s in seats)
    return near and any(not isinstance(joint, Prismatic) for joint in joints)
