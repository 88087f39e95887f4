"""The ground of a figure: hatched supports under hinges, rollers and rails under slides."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass
from typing import final

import numpy as np

from mecanique.figure.paper.marks import Circle, Mark, Point, Stroke, across, label, unit
from mecanique.figure.paper.symbols import hatch, pin
from mecanique.figure.setting import Setting, is_zero
from mecanique.model.constraint_base import PressingContact
from mecanique.model.constraints.friction import Contact, Friction, Stop
from mecanique.model.force_base import loads_in
from mecanique.model.joint_base import Single
from mecanique.model.joints import Prismatic, Revolute, Spherical, Universal

DOWN = np.array([0.0, 1.0])

NUT = (11.0, 8.0)
"""Half the width and half the height of a nut [pt]."""

RADIUS_WAY = np.array([-0.8, -0.6])
"""Where on paper the radius of a circle is drawn that a slide stops on."""

PLANE_MARGIN = 26.0
"""How far a plane is drawn beyond what touches it [pt]."""

STOP_AT, STOP_GAP = 0.8, 5.0
"""Where a stop stands along a body that turns, and how far from its middle line [pt]."""

THREADS = 3
"""How many turns of the thread are drawn in a nut."""


def supports(setting: Setting) -> Iterator[Mark]:
    """Yield what holds the joints of the ground, and what bodies touch."""
    yield from _slabs(setting)
    yield from _planes(setting)
    for element in setting.switching:
        if isinstance(element, Stop):
            yield from _stop(setting, element)
    rails: list[_Rail] = []
    for joint in setting.mechanism.joints:
        if joint.parent != setting.mechanism.ground or joint.followers:
            continue
        at = setting.camera.at(setting.point(joint.child))
        if isinstance(joint, Single) and joint.turns and not setting.camera.flat:
            yield from _bearing(setting, joint, at)
        elif isinstance(joint, (Revolute, Spherical, Universal)):
            yield from pin(at, _away(setting, joint.child, at))
        elif isinstance(joint, Prismatic):
            rails += _rail(setting, joint)
    while rails:
        first, *rest = rails
        same = [
            r
            for r in rest
            if abs(float((r.a - first.a) @ first.below)) < 1.5
            and abs(float(r.below @ first.below)) > 0.999
        ]
        rails = [r for r in rest if r not in same]
        yield from _draw_line([first, *same])


def nuts(setting: Setting) -> Iterator[Mark]:
    """Yield the nuts of screws, on the side where the spindle is; those of the ground hatched."""
    camera = setting.camera
    for joint in setting.mechanism.joints:
        if not isinstance(joint, Single) or not joint.followers:
            continue
        at, along = camera.at(setting.seat(joint)), camera.at(setting.axis(joint)) / camera.scale
        if math.hypot(*along) < 0.2:
            yield Circle(at, NUT[0], "clear")
            continue
        along = unit(along)
        spindle = [camera.at(s.corners) - at for s in setting.solids if s.body == joint.child]
        if spindle and float((np.concatenate(spindle) @ along).mean()) < 0:
            along = -along
        yield from _nut(at, along, on_ground=joint.parent == setting.mechanism.ground)


def _nut(at: Point, along: Point, *, on_ground: bool) -> Iterator[Mark]:
    side, (half, height) = across(along), NUT
    low, high = at, at + 2 * height * along
    corners = [low - half * side, low + half * side, high + half * side, high - half * side]
    yield Stroke(np.array(corners), "clear", closed=True)
    rise = 2 * height / (THREADS + 1) * along
    for turn in range(THREADS):
        start = at + (turn + 0.5) * rise
        yield Stroke(
            np.array([start - 0.6 * half * side, start + rise + 0.6 * half * side]), "thin"
        )
    if on_ground:
        yield from hatch(corners[2], corners[1])
        yield from hatch(corners[0], corners[3])


def _away(setting: Setting, body: str, at: Point) -> Point:
    """From a hinge, up or down, to the side with less of what hangs from it."""
    family = {body}
    for joint in setting.mechanism.tree:
        if joint.parent in family:
            family.add(joint.child)
    spots = [setting.paper(name) for name in family]
    middle = np.concatenate(spots).mean(axis=0) - at
    return DOWN if middle[1] < -2 else -DOWN


def _bearing(setting: Setting, joint: Single, at: Point) -> Iterator[Mark]:
    """An axle in space: its line, and a bearing at its lower end or beyond the bodies around it."""
    down = setting.camera.at(setting.axis(joint)) / setting.camera.scale
    if math.hypot(*down) < 0.2:
        yield from pin(at, _away(setting, joint.child, at))
        return
    down = unit(down if down[1] >= 0 else -down)
    broad = [s for s in setting.solids if s.body == joint.child and s.kind != "rod"]
    spans = [(setting.camera.at(s.corners) - at) @ down for s in broad]
    reach = max((float(span.max()) for span in spans), default=0.0)
    foot = at + max(reach + 6.0, 8.0) * down
    yield Stroke(np.array([at - 26 * down, foot + 10 * down]), "axis")
    yield from pin(foot, down)


def _slabs(setting: Setting) -> Iterator[Mark]:
    """Hatching below the boxes of the ground that are seen edge on."""
    if not setting.camera.flat:
        return
    for solid in setting.solids:
        if solid.body != setting.mechanism.ground or solid.kind != "box":
            continue
        paper = setting.camera.at(solid.corners)
        edges = [(a, b) for a in paper for b in paper if math.hypot(*(b - a)) > 60]
        spread = paper - paper.mean(axis=0)
        along = np.linalg.svd(spread)[2][0]
        low = across(along) if across(along)[1] > 0 else -across(along)
        if not edges or float(np.ptp(paper @ low)) > 14:
            continue
        base = paper.mean(axis=0) + float((spread @ low).max()) * low
        half = float((spread @ along).max())
        a, b = base - half * along, base + half * along
        yield from hatch(a, b) if float(-across(unit(b - a)) @ low) > 0 else hatch(b, a)


def _planes(setting: Setting) -> Iterator[Mark]:
    """The planes that bodies touch or roll on, hatched, where they are seen edge on."""
    mechanism, camera = setting.mechanism, setting.camera
    if any(solid.body == mechanism.ground for solid in setting.solids):
        return
    lines = list[tuple[Point, Point]]()
    for contact in (*mechanism.contacts, *setting.switching):
        if not isinstance(contact, PressingContact | Contact):
            continue
        on = setting.poses[setting.index(contact.on)]
        plane = on @ mechanism.matrix(contact.plane)
        normal, at = camera.at(plane[:3, 2]) / camera.scale, camera.at(plane[:3, 3])
        known = any(abs(n @ normal) > 0.999 and abs((at - o) @ n) < 1.0 for o, n in lines)
        if is_zero(contact.bowl) and math.hypot(*normal) > 0.99 and not known:
            lines.append((at, unit(normal)))
    spots = np.concatenate([setting.paper(body.name) for body in mechanism.bodies])
    for at, out in lines:
        along = across(out)
        spans = (spots - at) @ along
        low, high = float(spans.min()) - PLANE_MARGIN, float(spans.max()) + PLANE_MARGIN
        for other, normal in lines:  # a floor ends at a wall
            rise, reach = float(along @ normal), float((at - other) @ normal)
            if rise > 0.1:
                low = max(low, -reach / rise)
            elif rise < -0.1:
                high = min(high, -reach / rise)
        a, b = at + low * along, at + high * along
        yield from hatch(a, b) if float(across(along) @ out) > 0 else hatch(b, a)


def _stop(setting: Setting, stop: Stop) -> Iterator[Mark]:
    """The wall that a stop is, or the circle on which a slide that turns ends."""
    mechanism, camera = setting.mechanism, setting.camera
    joint = mechanism.joint(stop.joint)
    limit, seat = mechanism.evaluate(stop.at), setting.seat(joint)
    if not camera.flat or not isinstance(joint, (Prismatic, Revolute)):
        return
    if isinstance(joint, Prismatic):
        along = unit(camera.at(setting.axis(joint))) * stop.side
        if joint.parent == mechanism.ground:
            child = camera.at(setting.point(joint.child))
            depth = setting.reach(joint.child, along) - float(child @ along)
            place = camera.at(seat + limit * setting.axis(joint))
            yield from wall(place + depth * along, -along)
        elif not any(solid.body == joint.parent for solid in setting.solids):
            center, radius = camera.at(seat), abs(limit) * camera.scale
            yield Circle(center, radius, "clear" if stop.side < 0 else "dashed")
            rim = center + radius * RADIUS_WAY
            yield Stroke(np.array([center, rim]), "thin")
            yield label((center + rim) / 2, setting.name(stop.at), across(RADIUS_WAY), 5.0)
    elif joint.coordinate in mechanism.coordinates:
        axis = setting.axis(joint)
        angle = limit - float(setting.q[mechanism.coordinates.index(joint.coordinate)])
        corners = np.concatenate([s.ends for s in setting.solids if s.body == joint.child])
        arm = max((corner - seat for corner in corners), key=lambda r: float(np.linalg.norm(r)))
        arm = math.cos(angle) * arm + math.sin(angle) * np.cross(axis, arm)
        ahead = unit(camera.at(np.cross(axis, arm))) * stop.side
        yield from wall(camera.at(seat + STOP_AT * arm) + STOP_GAP * ahead, -ahead)


@final
@dataclass(frozen=True, eq=False)
class _Rail:
    """A rail on the ground: its two ends, the direction into the ground, and the rollers."""

    a: Point
    b: Point
    below: Point
    feet: tuple[Point, ...]


def _rail(setting: Setting, joint: Prismatic) -> Iterator[_Rail]:
    """A rail for a body that slides on the ground, unless it hangs or stands on columns."""
    camera, mechanism = setting.camera, setting.mechanism
    axis = setting.axis(joint)
    boxes = [
        solid
        for solid in setting.solids
        if solid.body == joint.child and solid.kind in ("box", "cylinder", "ball")
    ]
    if (
        not camera.flat
        or not boxes
        or abs(float(axis[2])) > 0.9
        or stands_on_columns(setting, joint)
    ):
        return
    if any(solid.body == mechanism.ground for solid in setting.solids):
        return
    along = unit(camera.at(axis))
    below = across(along)
    below = -below if below[1] < 0 else below
    center, zero = camera.at(setting.point(joint.child)), camera.at(setting.seat(joint))
    depth = setting.reach(joint.child, below) - float(center @ below)
    half = max(setting.reach(joint.child, along) - float(center @ along), 12.0)
    ends = [float((zero - center) @ along), 0.0]
    rubs = any(isinstance(e, Friction) and e.joint == joint.name for e in setting.switching)
    line = center + (depth + (0.0 if rubs else 8.0)) * below
    inset = max(half - 9.0, 0.45 * half)
    top = center + (depth + 4.0) * below
    yield _Rail(
        line + (min(ends) - half - 26) * along,
        line + (max(ends) + half + 26) * along,
        below,
        () if rubs else (top - inset * along, top + inset * along),
    )


def _draw_line(rails: list[_Rail]) -> Iterator[Mark]:
    """Join rails that lie on one line."""
    first = rails[0]
    for rail in rails:
        for foot in rail.feet:
            yield Circle(foot, 4.0, "pin")
    along = unit(first.b - first.a)
    ends = [float((end - first.a) @ along) for rail in rails for end in (rail.a, rail.b)]
    a, b = first.a + min(ends) * along, first.a + max(ends) * along
    yield from hatch(a, b) if float(-across(along) @ first.below) > 0 else hatch(b, a)


def stands_on_columns(setting: Setting, joint: Prismatic) -> bool:
    """Return whether a slide is a floor on elastic columns: it holds a spring and is raised."""
    offset, axis = setting.seat(joint) - setting.point(joint.parent), setting.axis(joint)
    raised = float(np.linalg.norm(offset - (offset @ axis) * axis)) * setting.camera.scale
    sprung = loads_in(setting.mechanism.forces, joint.name, "spring")
    return bool(sprung) and raised > 24 and not setting.has_teeth(joint.child)


def wall(at: Point, outward: Point) -> Iterator[Mark]:
    """Yield a short hatched wall."""
    side = across(outward)
    a, b = at - 20 * side, at + 20 * side
    yield from hatch(a, b) if float(-across(unit(b - a)) @ outward) < 0 else hatch(b, a)
