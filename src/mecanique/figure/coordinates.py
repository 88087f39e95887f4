"""Coordinates and dimensions in a figure: arcs for angles, arrows for distances, each labeled.

To find what a coordinate measures, it is set to zero: the first body whose pose then changes has
turned by an angle or moved by a distance.
"""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from itertools import combinations
from typing import Literal, TypeAlias, final

import numpy as np

from mecanique.figure.paper.marks import (
    Mark,
    Point,
    Stroke,
    Words,
    across,
    arc,
    arrow,
    center_of_mass,
    dimension,
    downward,
    label,
    named_arrow,
    rich,
    unit,
)
from mecanique.figure.setting import CONE, RING, Setting
from mecanique.figure.solids import Floats, Outline, list_branch, radius_of, unit3
from mecanique.model import quaternions
from mecanique.model.bodies import Body
from mecanique.model.bodies.visuals import Box, Cylinder
from mecanique.model.constraint_base import PressingContact
from mecanique.model.constraints.friction import Contact
from mecanique.model.constraints.loops import Loop
from mecanique.model.expression import Vector, plain, symbols_in
from mecanique.model.force_base import LineLoad
from mecanique.model.joint_base import Single
from mecanique.model.joints import Joint, Prismatic, Revolute
from mecanique.model.placement import is_zero

MEASURED_LENGTH, MEASURED_RADIUS = 40.0, 18.0
"""Shorter lengths on paper get no dimension [pt]."""

SHORTEST_SPAN, OFFSETS = 8.0, {"rod": 18.0, "edge": 12.0, "place": 36.0}
"""Least length of a dimension, and its distance from a rod, an edge and pins [pt]."""

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

SAME_LENGTH = 1e-9
"""Lengths that differ by a smaller part are the same, up to rounding."""

STEEP = 0.5
"""Sine of the angle to the ground beyond which an axis meets it near its wheel."""

BELOW_LEFT = np.array([-1.0, 0.6])
"""Where a mass is written in a solid whose middle is occupied, and at the rim of a ring."""


def lengths(setting: Setting) -> Iterator[Mark]:
    """Yield the symbols of rods' lengths and of disks' radii, each once."""
    written: set[str] = set()
    for solid in sorted(setting.solids, key=lambda solid: _is_crossed(setting, solid)):
        geometry = solid.geometry
        if isinstance(geometry, Box) or solid.point:
            continue
        rod = solid.kind == "rod"
        stated = geometry.length if rod and isinstance(geometry, Cylinder) else geometry.radius
        name = setting.name(stated)
        if not name or name in written:
            continue
        marks = [*(_draw_length if rod else _radius)(setting, solid, name)]
        if marks:
            written.add(name)
        yield from marks


def missing(setting: Setting, symbol: str) -> tuple[Mark, ...]:
    """Return the dimension of an edge, of a place in a body or of a joint's tilt by its letter."""
    spans = (span for span in _spans(setting) if _is_multiple(span.name, symbol))
    for span in spans:
        a, b = setting.camera.at(span.a), setting.camera.at(span.b)
        if math.hypot(*(b - a)) >= SHORTEST_SPAN:
            return tuple(_draw_span(setting, span, a, b))
    for joint in setting.mechanism.joints:
        if symbol in (str(angle).lstrip("-") for angle in joint.origin.rpy):
            return tuple(_tilt(setting, joint, setting.letter(symbol)))
    return ()


def _is_multiple(text: str, symbol: str) -> bool:
    """Whether a length is a letter, or a whole number of times it."""
    factor, _, rest = text.lstrip("-").rpartition("*")
    return rest == symbol and (not factor or factor.isdecimal())


SpanKind: TypeAlias = Literal["rod", "edge", "place", "axis", "center"]


@final
@dataclass(frozen=True, eq=False)
class _Span:
    """A length that the description states, between two points in the world."""

    name: str
    a: Floats
    b: Floats
    kind: SpanKind


def _spans(setting: Setting) -> Iterator[_Span]:
    """The components of what lies in a body's frame, and the edges of homogeneous solids."""
    for body, xyz, kind in _places(setting):
        for k, component in enumerate(xyz):
            foot = [0.0 if j == k else c for j, c in enumerate(xyz)]
            a, b = setting.point(body, foot), setting.point(body, xyz)
            yield _Span(setting.name(component), a, b, kind)
    for contact in setting.mechanism.contacts:
        if isinstance(contact, PressingContact) and contact.stretched:
            for k, factor in enumerate(contact.stretch):
                half = contact.radius if factor == 1 else plain(contact.radius * factor)
                tip = [*contact.center]
                tip[k] = tip[k] + half
                a, b = (setting.point(contact.body, xyz) for xyz in (contact.center, tip))
                yield _Span(setting.name(half), a, b, "axis")
    for solid in setting.solids:
        if not solid.form or solid.kind == "rod":
            continue
        if isinstance(solid.geometry, Box):
            corners = solid.corners.reshape(2, 2, 2, 3)
            for k, edge in enumerate(solid.geometry.size):
                edges = np.moveaxis(corners, k, 0).reshape(2, 4, 3)
                yield _Span(setting.name(edge), *_find_edge(setting, edges), "edge")
        elif isinstance(solid.geometry, Cylinder):
            edges = solid.corners.reshape(2, -1, 3)
            name = setting.name(solid.geometry.length)
            yield _Span(name, *_find_edge(setting, edges), "edge")
    yield from _tracks(setting)


def _tracks(setting: Setting) -> Iterator[_Span]:
    """Distances on the ground that are a letter where all coordinates are zero, as a wheelbase."""
    mechanism = setting.mechanism
    wheels = [
        c for c in mechanism.contacts if isinstance(c, PressingContact) and c.axis is not None
    ]
    if len(wheels) < 2 or mechanism.quaternions:
        return
    upright = setting.reference.poses(np.zeros(mechanism.nq), setting.t)
    here = _marks_on_ground(setting, wheels)
    there = _marks_on_ground(replace(setting, poses=upright), wheels)
    lengths = {p.value: p.symbol for p in mechanism.parameters if p.unit == "m" and p.value}
    for i, j in combinations(range(len(here)), 2):
        far = float(np.linalg.norm(there[j] - there[i]))
        for length, symbol in lengths.items():
            if math.isclose(far, length, rel_tol=SAME_LENGTH):
                yield _Span(symbol, here[i], here[j], "place")


def _marks_on_ground(setting: Setting, wheels: Sequence[PressingContact]) -> list[Floats]:
    """Return where wheels stand, and where axes of hinges meet the plane of the first."""
    marks, ups = list[Floats](), [setting.frame(w.on, w.plane)[:3, 2] for w in wheels]
    for wheel, up in zip(wheels, ups, strict=True):
        axis = setting.poses[setting.index(wheel.body), :3, :3] @ np.array(wheel.axis)
        rise = unit3(up - (up @ axis) * axis)
        center = setting.point(wheel.body, wheel.center)
        marks.append(center - setting.mechanism.evaluate(wheel.radius) * rise)
    for joint in setting.mechanism.joints:
        steep = float(setting.axis(joint) @ ups[0]) if isinstance(joint, Revolute) else 0.0
        if abs(steep) > STEEP:
            seat = setting.seat(joint)
            marks.append(seat - (seat - marks[0]) @ ups[0] / steep * setting.axis(joint))
    return marks


def _places(setting: Setting) -> Iterator[tuple[str, Vector, SpanKind]]:
    """Points stated in a body's frame: of joints, loops, springs, contacts; centers of mass."""
    mechanism = setting.mechanism
    for joint in mechanism.joints:
        slides = [np.abs(motion.axis) for motion in joint.chain if motion.kind == "slide"]
        along = np.sum(slides, axis=0) if slides else np.zeros(3)
        # along a slide nothing need be where its zero is
        x, y, z = (0.0 if a > 0.5 else c for a, c in zip(along, joint.origin.xyz, strict=True))
        yield joint.parent, (x, y, z), "place"
    for loop in (*mechanism.loops, *(e for e in mechanism.elements if isinstance(e, Loop))):
        yield loop.body_a, loop.frame_a.xyz, "place"
        yield loop.body_b, loop.frame_b.xyz, "place"
    for force in mechanism.forces:
        if isinstance(force, LineLoad):
            yield from ((end.body, end.point, "place") for end in force.ends)
    for contact in setting.switching:
        if isinstance(contact, Contact):
            yield contact.body, contact.center, "edge"
    for body in mechanism.bodies:
        yield from ((body.name, s.center, "center") for s in body.shapes if not is_zero(s.mass))


def _find_edge(setting: Setting, edges: Floats) -> tuple[Floats, Floats]:
    """Of parallel edges, shape (2, n, 3), the ends of the outermost and lowest on paper."""
    paper = setting.camera.at(edges)
    out = paper.mean(axis=0) - paper.mean(axis=(0, 1))
    aside = np.abs(out @ across(unit(paper[1, 0] - paper[0, 0])))
    k = int(np.argmax(np.round(aside, 6) + 1e-3 * out[:, 1]))
    return edges[0, k], edges[1, k]


def _draw_length(setting: Setting, rod: Outline, name: str) -> Iterator[Mark]:
    a, b = setting.camera.at(rod.ends)
    if math.hypot(*(b - a)) >= MEASURED_LENGTH:
        kind = _span_of(setting, rod)
        yield from _draw_span(setting, _Span(name, rod.ends[0], rod.ends[1], kind), a, b)


def _draw_span(setting: Setting, span: _Span, a: Point, b: Point) -> Iterator[Mark]:
    """A dimension: beside a rod or an edge, beyond the pins of joints, or up to a center."""
    name, outward = span.name.lstrip("-"), _outward(setting, a, b)
    if span.kind == "edge" or (span.kind in OFFSETS and setting.camera.flat):
        yield from dimension(a, b, name, outward * OFFSETS[span.kind])
    elif span.kind == "rod":
        yield label((a + b) / 2, name, across(unit(b - a)), 9.0)
    else:
        yield from arrow(a, b, "thin", double=True)
        yield label((a + b) / 2, name, across(unit(b - a)) * outward, 4.0)
    if span.kind == "center":
        yield from center_of_mass(b)


def _is_crossed(setting: Setting, rod: Outline) -> bool:
    """Whether a spring or another force between points crosses the dimension of a rod."""
    if rod.kind != "rod" or not setting.camera.flat:
        return False
    a, b = setting.camera.at(rod.ends)
    if math.hypot(*(b - a)) < MEASURED_LENGTH:
        return False
    aside = _outward(setting, a, b) * OFFSETS[_span_of(setting, rod)] * across(unit(b - a))
    for line in (force for force in setting.mechanism.forces if isinstance(force, LineLoad)):
        c, d = (setting.camera.at(setting.point(end.body, end.point)) - aside for end in line.ends)
        # with the ends of each on both sides of the other, or on it
        corners = ((a, b, c), (a, b, d), (c, d, a), (c, d, b))
        sides = [float(np.linalg.det([q - p, x - p])) for p, q, x in corners]
        if sides[0] * sides[1] <= 0 and sides[2] * sides[3] <= 0:
            return True
    return False


def _span_of(setting: Setting, rod: Outline) -> SpanKind:
    """Return how far off the dimension of a rod is: beyond the letters of particles on it."""
    length = float(np.linalg.norm(np.ptp(rod.ends, axis=0)))
    for solid in setting.solids:
        ways = np.linalg.norm(rod.ends - solid.ends.mean(axis=0), axis=1)
        if solid.kind == "ball" and solid.body == rod.body and ways.min() > 0.1 * length:
            return "place"
    return "rod"


def _tilt(setting: Setting, joint: Joint, name: str) -> Iterator[Mark]:
    """The angle between the axis of a joint and the same axis of its parent, at the joint."""
    if not isinstance(joint, Single):
        return
    camera, seat = setting.camera, setting.seat(joint)
    parent = setting.poses[setting.index(joint.parent), :3, :3]
    axis, straight = setting.axis(joint), parent @ np.array(joint.axis)
    up = math.copysign(1.0, -float(camera.at(axis)[1]))
    at, ends = camera.at(seat), camera.at(np.array([straight, axis])) * up / camera.scale
    yield from _corner(at, ends[0], ends[1], name)


def _radius(setting: Setting, disk: Outline, name: str) -> Iterator[Mark]:
    """An arrow to the rim of a ball, of a disk seen face on, or in space at least from aside."""
    camera = setting.camera
    radius, facing = disk.size * camera.scale, float(disk.pose[:3, 2] @ camera.toward)
    if disk.kind == "ball":
        facing = 1.0
    in_space = 0.0 if disk.form == CONE else ASIDE
    least = 0.9 if camera.flat else in_space
    if radius <= MEASURED_RADIUS or abs(facing) < least:
        return
    way = np.array([math.cos(RADIUS_ANGLE), math.sin(RADIUS_ANGLE)])
    if camera.flat or disk.kind == "ball":
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
    yield from _rail_slopes(setting, plated=bool(plates))
    for visual, plate in zip(visuals, plates, strict=True):
        names = [setting.name(angle) for angle in visual.placement.rpy if not is_zero(angle)]
        a, b = camera.at(plate.ends)
        low, high = (a, b) if a[1] > b[1] else (b, a)
        if len(names) != 1 or not names[0] or abs(high[1] - low[1]) < 1.0:
            continue
        yield from _slope(low, high, names[0])


def _rail_slopes(setting: Setting, *, plated: bool) -> Iterator[Mark]:
    """The angle by which a slide on the ground is tilted, unless a plate is, or gravity is."""
    mechanism = setting.mechanism
    letters = {p.symbol for p in mechanism.parameters if p.unit == "rad"}
    for joint in mechanism.joints:
        tilts = mechanism.gravity + (() if plated else joint.origin.rpy)
        used = frozenset().union(*map(symbols_in, tilts)) & letters
        if len(used) != 1 or joint.parent != mechanism.ground or not isinstance(joint, Prismatic):
            continue
        along = downward(unit(setting.along(joint)))
        below = downward(across(along))
        low = setting.at(joint.child)
        low = low + setting.reach_from(low, joint.child, below) * below
        low = low + (setting.reach_from(low, joint.child, along) + SLOPE_RADIUS) * along
        low = low + RAIL_GAP * below
        yield from _slope(low, low - along, *map(setting.letter, used))


def _slope(low: Point, high: Point, name: str) -> Iterator[Mark]:
    """The angle at the foot of an incline, from the horizontal."""
    yield from _corner(low, np.array([math.copysign(1.0, high[0] - low[0]), 0.0]), high - low, name)


def _corner(at: Point, level: Point, sloping: Point, name: str) -> Iterator[Mark]:
    """The angle between two directions on paper, the first of them drawn."""
    start, turn = unit(level), np.linspace(0.0, 1.0, 25)[:, None]
    side = unit(sloping)
    slope = math.atan2(float(start[0] * side[1] - start[1] * side[0]), float(start @ side))
    points = at + SLOPE_RADIUS * (
        np.cos(slope * turn) * start - np.sin(slope * turn) * across(start)
    )
    yield Stroke(np.array([at, at + 1.3 * SLOPE_RADIUS * start]), "axis")
    yield Stroke(points, "thin")
    yield label(points[12], name, points[12] - at, 5.0)


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


def _named_pieces(setting: Setting, body: Body) -> Iterator[tuple[str, Outline]]:
    """The pieces of a body whose mass has a short name, each with its largest solid."""
    solids = iter([solid for solid in setting.solids if solid.body == body.name])
    for shape in body.shapes:
        pieces = [solid for _, solid in zip(shape.visuals, solids, strict=False)]
        name = setting.name(shape.mass)
        if pieces and name:
            yield name, max(pieces, key=lambda solid: float(np.ptp(solid.corners, axis=0).max()))


def _mass(setting: Setting, name: str, solid: Outline) -> Words:
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
    if solid.form == RING and not camera.flat:
        rim = camera.at(solid.corners[: len(solid.corners) // 2])
        place = rim[int(np.argmax((rim - at) @ BELOW_LEFT))]
        return label(place, name, place - at, 5.0)
    if not roomy:
        return _beside(setting, name, solid, at)
    # a disk has a hinge in its middle
    joints = [j for j in setting.mechanism.joints if solid.body in (j.parent, j.child)]
    seats = [setting.at(joint.child) for joint in joints]
    near = solid.kind == "cylinder" or any(math.hypot(*(s - at)) < JOINT_ROOM for s in seats)
    if near and any(not isinstance(joint, Prismatic) for joint in joints):
        return label(at, name, BELOW_LEFT, 8.0)
    return Words(at, rich(name))


def _beside(setting: Setting, name: str, solid: Outline, at: Point) -> Words:
    """A letter to the left or right of a body, on the side facing away from the rest."""
    middles = [setting.camera.at(solid.ends.mean(axis=0)) for solid in setting.solids]
    left = at[0] <= float(np.mean(middles, axis=0)[0]) + 1
    side = np.array([-1.0 if left else 1.0, 0.0])
    edge = np.array([side[0] * setting.reach(solid.body, side), at[1]])
    return label(edge, name, side, 6.0)


_INSIDE = 1e-6
"""A coordinate that cannot be zero is read this far within its limits."""

SMALL = 14.0
"""Shorter distances are drawn as a direction only [pt]."""

RADIUS, LEAST_RADIUS, RADIUS_STEP = 46.0, 24.0, 16.0
"""Largest and smallest radius of the first arc about a point, and the step to the next [pt]."""

ANGLE_AT_REST = 0.5
"""Length of the arc of an angle that is zero in the figure [rad]."""

SAME_PLACE = 6.0
"""Arcs about points closer than this are drawn outside one another [pt]."""

TRIAD = 44.0
"""Length of the arrows of coordinates that are zero [pt]."""

CLEARANCE, CLEARANCE_ABOVE = 30.0, 18.0
"""Distance from a body to the arrow beside it [pt]."""

FLAT = 12.0
"""A body thinner than this on paper is a plate [pt]."""


@final
@dataclass(frozen=True, eq=False)
class _Angle:
    """A coordinate that turns a body: the body, its poses at zero, and the rotation."""

    name: str
    body: int
    value: float
    before: Floats
    turn: Floats


@final
@dataclass(frozen=True, eq=False)
class _Distance:
    """A coordinate that moves a point: the body's number, the point, and its displacement."""

    name: str
    body: int
    value: float
    end: Floats
    step: Floats

    @property
    def length(self) -> float:
        return float(np.linalg.norm(self.step))

    @property
    def forward(self) -> Floats:
        """Direction in which the point moves as the coordinate grows, of unit length."""
        return unit3(self.step) * math.copysign(1.0, self.value)


def coordinates(setting: Setting, body: str | None = None) -> Iterator[Mark]:
    """Yield the marks of a mechanism's generalized coordinates."""
    mechanism = setting.mechanism
    # of a body that floats at the origin the directions are shown
    moved = {name for name, x in zip(mechanism.coordinates, setting.q, strict=True) if x}
    inside = set[str]()
    for joint in mechanism.joints:
        aside = joint.quaternion and not moved.isdisjoint(joint.linear_coordinates)
        inside.update(joint.coordinates if aside else joint.quaternion)
    distances: list[_Distance] = []
    arcs: Counter[tuple[float, ...]] = Counter()
    for k, name in enumerate(mechanism.coordinates):
        if name in inside:
            continue
        match _read(setting, k, name):
            case _Angle() as angle if body in (None, mechanism.bodies[angle.body].name):
                center = setting.camera.at(setting.poses[angle.body, :3, 3])
                place = tuple(np.round(center / SAME_PLACE).tolist())
                yield from _draw_angle(setting, angle, arcs[place])
                arcs[place] += 1
            case _Distance() as distance if body is None:
                distances.append(distance)
    small = [distance for distance in distances if distance.length * setting.camera.scale < SMALL]
    ways = [unit3(distance.step) for distance in small]
    if len(small) > 1 and all(abs(float(a @ b)) < 0.9 for a, b in combinations(ways, 2)):
        yield from _triad(setting, small)
        distances = [distance for distance in distances if distance not in small]
    for distance in distances:
        yield from _draw_distance(setting, distance)


def _read(setting: Setting, k: int, name: str) -> _Angle | _Distance | None:
    """What a coordinate measures: the first body that it moves, compared with its pose at zero."""
    q = setting.q.copy()
    q[k] = 0.0 if abs(q[k]) > 1e-9 else 1e-3
    lower, upper = setting.mechanism.limits.get(name, (-math.inf, math.inf))
    q[k] = min(max(q[k], lower + _INSIDE), upper - _INSIDE)
    before = np.asarray(setting.reference.poses(q, setting.t))
    body = _moved_body(setting, name, before)
    if body is None:
        return None
    value = float(setting.q[k] - q[k])
    turn = setting.poses[body, :3, :3] @ before[body, :3, :3].T
    size = math.acos(min(max((float(np.trace(turn)) - 1) / 2, -1.0), 1.0))
    if size > 1e-9 and abs(math.cos(size) - math.cos(value)) < 1e-6:
        return _Angle(name, body, value if abs(setting.q[k]) > 1e-9 else 0.0, before, turn)
    moved = _displace(setting, before, body, value)
    return None if moved is None else _Distance(name, body, value, *moved)


def _moved_body(setting: Setting, name: str, before: Floats) -> int | None:
    """The index of the body on this coordinate's joint, or else of the first body it moves."""
    for joint in setting.mechanism.joints:
        if isinstance(joint, Prismatic | Revolute) and joint.coordinate == name:
            return setting.index(joint.child)
    for joint in setting.mechanism.tree:
        k = setting.index(joint.child)
        if np.abs(setting.poses[k] - before[k]).max() > 1e-7:
            return k
    return None


def _draw_angle(setting: Setting, angle: _Angle, level: int) -> Iterator[Mark]:
    """An arc from the body's direction at zero to its present one, outside arcs already drawn."""
    camera = setting.camera
    whole = quaternions.from_matrices(angle.turn)
    if whole[3] < 0:
        whole = -whole  # the shorter way round
    axis = unit3(whole[:3])
    half_angle = math.atan2(float(np.linalg.norm(whole[:3])), float(whole[3]))
    middle = setting.poses[angle.body, :3, 3] + _rise(setting, angle, axis)
    if not angle.value:  # the turn leads back from a small angle: its sense is the opposite one
        half_angle = -ANGLE_AT_REST / 2
    arm = _arm(setting, angle, axis)
    long = float(np.linalg.norm(arm)) * camera.scale
    radius = min(RADIUS, max(0.55 * long, LEAST_RADIUS)) + level * RADIUS_STEP
    start = unit3(arm) * radius / camera.scale
    halves = np.linspace(0.0, half_angle, 49)[:, None]
    around = quaternions.turn(np.hstack([np.sin(halves) * axis, np.cos(halves)]), start)
    points = camera.at(middle + around)
    yield Stroke(camera.at(np.array([middle, middle + 1.35 * start])), "axis")
    if not camera.flat:
        yield Stroke(camera.at(np.array([middle, middle + 1.2 * around[-1]])), "axis")
    # the arrow shows the positive sense, whichever way the body has turned
    yield from arc(points if angle.value >= 0 else points[::-1], "coordinate")
    center, half = camera.at(middle), points[len(points) // 2]
    away = half - center if math.hypot(*(half - center)) > 6 else np.array([0.0, -1.0])
    yield label(half, setting.letter(angle.name), away, 5.0, "coordinate-letter")


def _rise(setting: Setting, angle: _Angle, axis: Floats) -> Floats:
    """From the center of rotation to the far end of a cone or cylinder that turns about itself."""
    name = setting.mechanism.bodies[angle.body].name
    arms = _span(setting, name) - setting.poses[angle.body, :3, 3]
    heights = arms @ axis
    aside = np.linalg.norm((arms - heights[:, None] * axis).mean(axis=0))
    far = float(heights[int(np.argmax(np.round(np.abs(heights), 9)))])
    alone = not setting.camera.flat and aside < 1e-6 * abs(far)
    return far * axis if alone else np.zeros(3)


def _arm(setting: Setting, angle: _Angle, axis: Floats) -> Floats:
    """From the center of rotation to the body, across the axis, before the rotation."""
    pose, before = setting.poses[angle.body], angle.before[angle.body]
    for member in list_branch(setting.mechanism, setting.mechanism.bodies[angle.body].name):
        local = (_span(setting, member) - pose[:3, 3]) @ pose[:3, :3]
        arms = local @ before[:3, :3].T
        arms = arms - (arms @ axis)[:, None] * axis
        # the middle of a broad body, the far end of a long one
        # of arms that differ by rounding alone, the rightmost on the paper
        lengths = np.linalg.norm(arms, axis=1)
        longest = arms[lengths >= (1 - 1e-9) * lengths.max()]
        places = np.round(setting.camera.at(longest), 6)
        far = np.asarray(longest[np.lexsort((places[:, 1], places[:, 0]))[-1]])
        mean = arms.mean(axis=0)
        arm: Floats = mean if np.linalg.norm(mean) > 0.3 * np.linalg.norm(far) else far
        if np.linalg.norm(arm) > 1e-6:
            return arm
    side = before[:3, 0] - (before[:3, 0] @ axis) * axis
    across_axis = side if np.linalg.norm(side) > 0.1 else before[:3, 1]
    return unit3(across_axis) * 30.0 / setting.camera.scale


def _span(setting: Setting, body: str) -> Floats:
    """Points that span a body in the world, its origin among them, shape (n, 3)."""
    solids = [solid for solid in setting.solids if solid.body == body]
    spans = [solid.ends if solid.kind == "rod" else solid.corners for solid in solids]
    return np.concatenate([*spans, setting.point(body)[None]])


def _displace(
    setting: Setting, before: Floats, body: int, value: float
) -> tuple[Floats, Floats] | None:
    """A point that the coordinate has moved by its value, and its displacement."""
    step = setting.poses[body, :3, 3] - before[body, :3, 3]
    if abs(float(np.linalg.norm(step)) - abs(value)) < 1e-6 * abs(value):
        return setting.poses[body, :3, 3], step
    best: tuple[float, Floats, Floats] | None = None
    for solid in setting.solids:
        k = setting.index(solid.body)
        for spot in (*solid.ends, solid.ends.mean(axis=0)):
            local = setting.poses[k, :3, :3].T @ (spot - setting.poses[k, :3, 3])
            move = spot - (before[k, :3, 3] + before[k, :3, :3] @ local)
            for axis in np.eye(3):
                error = abs(abs(float(move @ axis)) - abs(value))
                if error < 0.02 * abs(value) and (best is None or error < best[0] - 1e-9):
                    best = (error, spot, float(move @ axis) * axis)
    return None if best is None else best[1:]


def _triad(setting: Setting, distances: list[_Distance]) -> Iterator[Mark]:
    """Directions of several coordinates that are zero, from one point to the left of the figure."""
    paper = np.concatenate([setting.paper(body.name) for body in setting.mechanism.bodies])
    left, bottom = float(paper[:, 0].min()), float(paper[:, 1].max())
    origin = np.array([left - TRIAD, bottom - 4.0])
    for distance in distances:
        tip = origin + TRIAD * setting.camera.at(distance.forward) / setting.camera.scale
        if math.hypot(*(tip - origin)) < 8:
            continue
        yield from named_arrow(origin, tip, distance.name, "coordinate", gap=3.0)


def _draw_distance(setting: Setting, distance: _Distance) -> Iterator[Mark]:
    """An arrow beside the body from the point's place at zero to its present one."""
    camera = setting.camera
    if abs(float(distance.forward @ camera.toward)) > 1 - 1e-6:
        return
    a, b = camera.at(distance.end - distance.step), camera.at(distance.end)
    owner = setting.mechanism.bodies[distance.body].name
    along = unit(camera.at(distance.forward))
    side = _free_side(setting, owner, along)
    clearance = CLEARANCE_ABOVE if side[1] < -0.7 else CLEARANCE
    drawn = {solid.body for solid in setting.solids}
    # of a body that only carries others, beside these
    carried = [owner] if owner in drawn else [*list_branch(setting.mechanism, owner)]
    shift = max([setting.reach_from(a, body, side) for body in carried] + [0.0]) + clearance
    # the arrow shows the positive sense: where the body stands on the other side, nothing else
    small = distance.length * camera.scale < SMALL or distance.value < 0
    flat = len(setting.paper(owner)) > 1 and float(np.ptp(setting.paper(owner) @ side)) < FLAT
    if small and flat:
        # in front of the plate it points at
        before = setting.reach_from(b, owner, along) - 62.0
        foot = b + before * along + np.array([0.0, -11.0])
        tip = foot + 26 * along
        name = label(foot, distance.name, -along, 5.0, "coordinate-letter")
    else:
        foot = (b if small else a) + shift * side
        tip = foot + 34 * along if small else b + shift * side
        name = label((foot + tip) / 2, distance.name, side, 7.0, "coordinate-letter")
    yield Stroke(np.array([foot - 6 * side, foot + 6 * side]), "coordinate")
    if not small:
        begin = shift - 12 if owner in drawn else 0.0
        yield Stroke(np.array([b + begin * side, tip + 5 * side]), "thin")
    yield from arrow(foot, tip, "coordinate")
    yield name


def _free_side(setting: Setting, owner: str, along: Point) -> Point:
    """The side of a body for the arrow of its displacement: above, unless something hangs below."""
    hinged = any(isinstance(j, Revolute) and j.parent == owner for j in setting.mechanism.joints)
    side = -across(along)
    downwards = side[1] > 1e-6 or (abs(side[1]) <= 1e-6 and side[0] > 0)
    # a body from which something hangs has room above it
    return -side if downwards == (hinged and abs(along[0]) > 0.7) else side
