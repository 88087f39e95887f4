"""A mechanism as a textbook draws it: bodies, joints, ground, springs, loads, coordinates."""

from __future__ import annotations

import math
import re
import textwrap
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import final

import numpy as np

from mecanique.figure.coordinates import coordinates, lengths, masses, missing, slopes
from mecanique.figure.paper.lettering import clear_letters
from mecanique.figure.paper.marks import (
    Circle,
    Mark,
    Point,
    Stroke,
    Words,
    across,
    arc,
    bounds,
    dashpot,
    directions,
    downward,
    hatch,
    label,
    named_arrow,
    pin,
    rich,
    spiral,
    spring,
    unit,
)
from mecanique.figure.setting import Setting
from mecanique.figure.solids import (
    Floats,
    Outline,
    cord_stretches,
    list_branch,
    outline,
    radius_of,
    unit3,
)
from mecanique.model.constraint_base import PressingContact, Strung, list_cord_runs
from mecanique.model.constraints.friction import Contact, Friction, Stop
from mecanique.model.constraints.loops import Loop
from mecanique.model.expression import Scalar, plain, symbols_in
from mecanique.model.force_base import (
    BodyLoad,
    End,
    JointLoad,
    LineLoad,
    WrenchOnBody,
    loads_in,
)
from mecanique.model.joint_base import Single
from mecanique.model.joints import Joint, Prismatic, Revolute, Spherical, Universal
from mecanique.model.parameters import Parameter
from mecanique.model.placement import is_zero
from mecanique.motion.analysis.forces import Action, Actions

DOWN = np.array([0.0, 1.0])

NUT = (11.0, 8.0)
"""Half the width and half the height of a nut [pt]."""

RADIUS_WAY = np.array([-0.8, -0.6])
"""Where on paper the radius of a circle is drawn that a slide stops on."""

CURVE_LEAST, CURVE_POINTS = 40.0, 41
"""How far a curve reaches at least along its coordinate [pt], and the points drawn of it."""

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
    for joint in setting.mechanism.joints:
        leader = _find_leader(setting, joint)
        if leader:
            k = setting.mechanism.coordinates.index(leader)
            reach = 1.2 * max(abs(float(setting.q[k])), CURVE_LEAST / setting.camera.scale)
            places = np.tile(setting.q, (CURVE_POINTS, 1))
            places[:, k] = np.linspace(-reach, reach, CURVE_POINTS)
            poses = (
                setting.reference.poses(q, setting.t)[setting.index(joint.child)] for q in places
            )
            yield Stroke(setting.camera.at([pose[:3, 3] for pose in poses]), "ground")
    for element in setting.switching:
        if isinstance(element, Stop):
            yield from _stop(setting, element)
    rails: list[_Rail] = []
    for joint in setting.mechanism.joints:
        if joint.followers or not _stands_on_ground(setting, joint):
            continue
        at = setting.at(joint.child)
        if isinstance(joint, Single) and joint.turns and not setting.camera.flat:
            yield from _bearing(setting, joint, at)
        elif isinstance(joint, (Revolute, Spherical, Universal)):
            if not _is_center(setting, joint):
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


def _stands_on_ground(setting: Setting, joint: Joint) -> bool:
    """Whether a joint is one of the ground, or a slide along a body that slides there likewise."""
    if joint.parent == setting.mechanism.ground or not isinstance(joint, Prismatic):
        return joint.parent == setting.mechanism.ground
    below = next(other for other in setting.mechanism.joints if other.child == joint.parent)
    along = isinstance(below, Prismatic) and np.abs(setting.axis(below) - setting.axis(joint)).max()
    return along is not False and along < 1e-9 and _stands_on_ground(setting, below)


def _is_center(setting: Setting, joint: Joint) -> bool:
    """Whether a joint stands in a ball of the ground, such as the sun, that needs no pin."""
    balls = [s for s in setting.solids if s.kind == "ball" and s.body == joint.parent]
    seat = setting.seat(joint)
    return any(np.linalg.norm(ball.ends.mean(axis=0) - seat) < ball.size for ball in balls)


def nuts(setting: Setting) -> Iterator[Mark]:
    """Yield the nuts of screws, on the side where the spindle is; those of the ground hatched."""
    camera = setting.camera
    for joint in setting.mechanism.joints:
        if not isinstance(joint, Single) or not joint.followers:
            continue
        at, along = setting.seat_at(joint), setting.along(joint)
        if math.hypot(*along) < 0.2:
            yield Circle(at, NUT[0], "clear")
            continue
        along = unit(along)
        spindle = [camera.at(s.corners) - at for s in setting.solids if s.body == joint.child]
        if spindle and float((np.concatenate(spindle) @ along).mean()) < 0:
            along = -along
        on_ground = joint.parent == setting.mechanism.ground
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
    spots = [setting.paper(name) for name in list_branch(setting.mechanism, body)]
    middle = np.concatenate(spots).mean(axis=0) - at
    return DOWN if middle[1] < -2 else -DOWN


def _bearing(setting: Setting, joint: Single, at: Point) -> Iterator[Mark]:
    """An axle in space: its line, and a bearing at its lower end or beyond the bodies around it."""
    down = setting.along(joint)
    if math.hypot(*down) < 0.2:
        yield from pin(at, _away(setting, joint.child, at))
        return
    down = unit(downward(down))
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
        low = downward(across(along))
        if not edges or float(np.ptp(paper @ low)) > 14:
            continue
        base = paper.mean(axis=0) + float((spread @ low).max()) * low
        half = float((spread @ along).max()) * along
        yield from hatch(base - half, base + half, low)


def _find_leader(setting: Setting, joint: Joint) -> str:
    """Return the coordinate along which the map leads a slide on a curve, "" if there is none."""
    mechanism = setting.mechanism
    if not isinstance(joint, Prismatic):
        return ""
    law = mechanism.coordinates.driven.get(joint.coordinate, 0.0)
    leaders = symbols_in(law) & {*mechanism.coordinates}
    carried, before = {joint.parent}, set[str]()
    for earlier in reversed(mechanism.tree):
        if earlier.child in carried:
            carried.add(earlier.parent)
            before |= {*earlier.coordinates} if isinstance(earlier, Prismatic) else set()
    moving = symbols_in(law) - {*mechanism.values}
    return next(iter(leaders)) if len(moving) == 1 and leaders <= before and leaders else ""


def _planes(setting: Setting) -> Iterator[Mark]:
    """The planes that bodies touch or roll on, hatched, where they are seen edge on."""
    mechanism, camera = setting.mechanism, setting.camera
    if any(solid.body == mechanism.ground for solid in setting.solids):
        return
    lines, halves = list[tuple[Point, Point]](), list[float]()
    for contact in (*mechanism.contacts, *setting.switching):
        if not isinstance(contact, PressingContact | Contact):
            continue
        half = math.inf
        if isinstance(contact, Contact) and contact.ends:
            if any(solid.body == contact.on for solid in setting.solids):
                continue  # its outline shows the side
            half = mechanism.evaluate(contact.length) / 2 * camera.scale
        plane = setting.frame(contact.on, contact.plane)
        if not camera.flat:
            if is_zero(contact.bowl) and all(s.body != contact.on for s in setting.solids):
                yield from _floor(setting, plane)
                return
            continue
        normal, at = camera.at(plane[:3, 2]) / camera.scale, camera.at(plane[:3, 3])
        known = any(abs(n @ normal) > 0.999 and abs((at - o) @ n) < 1.0 for o, n in lines)
        if is_zero(contact.bowl) and math.hypot(*normal) > 0.99 and not known:
            lines.append((at, unit(normal)))
            halves.append(half)
    spots = np.concatenate([setting.paper(body.name) for body in mechanism.bodies])
    for (at, out), half in zip(lines, halves, strict=True):
        along = across(out)
        spans = (spots - at) @ along
        low = max(float(spans.min()) - PLANE_MARGIN, -half)
        high = min(float(spans.max()) + PLANE_MARGIN, half)
        for other, normal in lines:  # a floor ends at a wall
            rise, reach = float(along @ normal), float((at - other) @ normal)
            if rise > 0.1:
                low = max(low, -reach / rise)
            elif rise < -0.1:
                high = min(high, -reach / rise)
        a, b = at + low * along, at + high * along
        yield from hatch(a, b, -out)


def _floor(setting: Setting, plane: Floats) -> Iterator[Mark]:
    """A plane in space, under all that stands on it."""
    spots = [setting.point(body.name)[None] for body in setting.mechanism.bodies]
    spots += [solid.corners for solid in setting.solids]
    feet = (np.concatenate(spots) - plane[:3, 3]) @ plane[:3, :2]
    margin = PLANE_MARGIN / setting.camera.scale
    (left, near), (right, far) = feet.min(axis=0) - margin, feet.max(axis=0) + margin
    corners = np.array([[left, near], [right, near], [right, far], [left, far]])
    yield Stroke(setting.camera.at(plane[:3, 3] + corners @ plane[:3, :2].T), "clear", closed=True)


def _stop(setting: Setting, stop: Stop) -> Iterator[Mark]:
    """The wall that a stop is, or the circle on which a slide that turns ends."""
    mechanism, camera = setting.mechanism, setting.camera
    joint = mechanism.joint(stop.joint)
    limit, seat = mechanism.evaluate(stop.at), setting.seat(joint)
    if not camera.flat or not isinstance(joint, (Prismatic, Revolute)):
        return
    if isinstance(joint, Prismatic):
        along = unit(setting.along(joint)) * stop.side
        if joint.parent == mechanism.ground:
            child = setting.at(joint.child)
            depth = setting.reach_from(child, joint.child, along)
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
    # of a pivot that slides nothing else is to be seen
    bare = all(solid.body != joint.child for solid in setting.solids)
    pivot = bare and any(
        isinstance(j, Revolute) and j.parent == joint.child for j in mechanism.joints
    )
    if (
        not camera.flat
        or not (boxes or pivot)
        or abs(float(axis[2])) > 0.9
        or stands_on_columns(setting, joint)
    ):
        return
    if any(solid.body == mechanism.ground for solid in setting.solids):
        return
    along = unit(camera.at(axis))
    below = downward(across(along))
    center, zero = setting.at(joint.child), setting.seat_at(joint)
    if pivot and float(below @ _away(setting, joint.child, center)) < 0:
        below = -below
    depth = setting.reach_from(center, joint.child, below)
    half = max(setting.reach_from(center, joint.child, along), 12.0)
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
    yield from hatch(a, b, first.below)


def stands_on_columns(setting: Setting, joint: Prismatic) -> bool:
    """Return whether a slide is a floor on elastic columns: it holds a spring and is raised."""
    offset, axis = setting.seat(joint) - setting.point(joint.parent), setting.axis(joint)
    raised = float(np.linalg.norm(offset - (offset @ axis) * axis)) * setting.camera.scale
    sprung = loads_in(setting.mechanism.forces, joint.name, "spring")
    return bool(sprung) and raised > 24 and not setting.has_teeth(joint.child)


def wall(at: Point, outward: Point) -> Iterator[Mark]:
    """Yield a short hatched wall."""
    side = across(outward)
    yield from hatch(at - 20 * side, at + 20 * side, -outward)


_NEARLY = 0.8
"""Cosine of the angle to the level or the vertical up to which a wall is not tilted."""


def connections(setting: Setting) -> Iterator[Mark]:
    """Yield every spring and damper with its symbol."""
    pairs: dict[tuple[End, End], list[LineLoad]] = {}
    for force in setting.mechanism.forces:
        if isinstance(force, LineLoad) and force.kind != "load":
            pairs.setdefault(force.ends, []).append(force)
    for links in pairs.values():
        yield from _between(setting, links)
    for joint in setting.mechanism.joints:
        inside = loads_in(setting.mechanism.forces, joint.name)
        loads = [load for load in inside if load.kind != "load"]
        if loads and isinstance(joint, Prismatic):
            yield from _in_slide(setting, joint, loads)
        elif loads and isinstance(joint, Revolute):
            yield from _in_hinge(setting, joint, loads)


def _between(setting: Setting, links: Sequence[LineLoad]) -> Iterator[Mark]:
    first = links[0]
    a, b = (setting.at(end.body, end.point) for end in first.ends)
    along = unit(b - a)
    ground = [end.body == setting.mechanism.ground for end in first.ends]
    # a spring ends at the surface of the body it holds
    a = _surface(setting, first.body_a, a, along)
    b = _surface(setting, first.body_b, b, -along)
    if ground[0]:
        yield from wall(a, _level(along))
    if ground[1]:
        yield from wall(b, _level(-along))
    yield from _bundle(setting, a, b, links)


def _level(outward: Point) -> Point:
    """The way out of a wall: level or upright, unless the spring is far from either."""
    nearest = np.where(np.abs(outward) == np.abs(outward).max(), np.sign(outward), 0.0)
    return nearest if float(nearest @ outward) > _NEARLY else outward


def _surface(setting: Setting, body: str, at: Point, outward: Point) -> Point:
    boxes = [s for s in setting.solids if s.body == body and s.kind in ("box", "ball", "cylinder")]
    for box in boxes:
        paper = setting.camera.at(box.corners)
        inside = (
            np.ptp(paper, axis=0) / 2 + 1
            >= np.abs(at - (paper.max(axis=0) + paper.min(axis=0)) / 2)
        ).all()
        if inside:
            edge = float((paper @ outward).max()) - float(at @ outward)
            if box.kind == "ball":  # drawn as a dot, whatever its size
                center = setting.camera.at(box.ends[0])
                edge = float((center - at) @ outward) + radius_of(box, setting.camera)
            return at + max(edge, 0.0) * outward
    return at


def _bundle(
    setting: Setting, a: Point, b: Point, links: Sequence[LineLoad | JointLoad]
) -> Iterator[Mark]:
    """Springs and dampers side by side."""
    side = across(unit(b - a))
    side = -side if side[1] > 1e-9 else side
    for k, link in enumerate(links):
        shift = (k - (len(links) - 1) / 2) * -20.0 * side
        yield from (spring if link.kind == "spring" else dashpot)(a + shift, b + shift)
        name = setting.name(link.coefficient)
        if name:
            outward = side if k == 0 else -side
            yield label((a + b) / 2 + shift, name, outward, 10.0)


def _in_slide(setting: Setting, joint: Prismatic, loads: Sequence[JointLoad]) -> Iterator[Mark]:
    a, b = setting.seat_at(joint), setting.at(joint.child)
    along = unit(setting.along(joint))
    solids = {solid.body: solid for solid in setting.solids}
    if joint.child in solids and stands_on_columns(setting, joint):
        yield from _columns(setting, joint, loads)
        return
    if joint.child not in solids:
        return
    if setting.has_teeth(joint.child):
        # beside the teeth, not among them
        middle = setting.paper(joint.child).mean(axis=0) - b
        shift = middle - (middle @ along) * along
        a, b = a + shift, b + shift
    if float((b - a) @ along) > 46:
        if joint.parent == setting.mechanism.ground and joint.parent not in solids:
            yield from wall(a, along)
        yield from _bundle(setting, a, _surface(setting, joint.child, b, -along), loads)
        return
    tip = _surface(setting, joint.child, b, -along)
    foot = tip - 74.0 * along
    if joint.parent in solids:
        foot = a + setting.reach_from(a, joint.parent, along) * along
    else:
        yield from wall(foot, along)
    yield from _bundle(setting, foot, tip, loads)


def _columns(setting: Setting, joint: Prismatic, loads: Sequence[JointLoad]) -> Iterator[Mark]:
    """Two elastic columns that carry a floor above another floor or above the ground."""
    high, parent = setting.at(joint.child), setting.at(joint.parent)
    along, up = unit(setting.along(joint)), -DOWN
    half = setting.reach_from(high, joint.child, along) - 8
    bottom, top = parent, _surface(setting, joint.child, high, -up)
    if joint.parent != setting.mechanism.ground:
        bottom = _surface(setting, joint.parent, parent, up)
    else:
        yield from hatch(bottom - (half + 26) * along, bottom + (half + 26) * along)
    bend = np.linspace(0.0, 1.0, 25)
    smooth = bend * bend * (3 - 2 * bend)
    for sign in (-1, 1):
        foot, head = bottom + sign * half * along, top + sign * half * along
        straight, drift = (head - foot) @ up * up, (head - foot) - (head - foot) @ up * up
        yield Stroke(foot + bend[:, None] * straight + smooth[:, None] * drift, "spring")
    names: dict[str, str] = {}  # of the first spring and the first damper that has one
    for load in loads:
        if name := setting.name(load.coefficient):
            names.setdefault(load.kind, name)
    if "spring" in names:
        yield label((bottom + top) / 2 + half * along, names["spring"], along, 8.0)
    if "damper" in names:
        a, b = bottom - 0.5 * half * along, top + 0.3 * half * along
        yield from dashpot(a, b)
        yield label((a + b) / 2, names["damper"], along, 10.0)


def _in_hinge(setting: Setting, joint: Revolute, loads: Sequence[JointLoad]) -> Iterator[Mark]:
    at = setting.at(joint.child)
    for load in loads:
        sprung = load.kind == "spring"
        name = setting.name(load.coefficient)
        if sprung:
            yield from spiral(at)
        if name:
            side = setting.clear_side(at) * ((1.0, 1.0) if sprung else (1.0, -1.0))
            yield label(at, name, side, 20.0 if sprung else 14.0)


ARROW = 42.0
"""Length of an arrow [pt]."""

LONG_NAME = 3
"""A longer name stands beside an arrow rather than at its tip [characters]."""

BEND, START, SWEEP = 20.0, 0.3, 1.35 * math.pi
"""Radius of a bent arrow [pt], its first angle and its extent [rad]."""


def loads(setting: Setting) -> Iterator[Mark]:
    """Yield forces, torques and drives as arrows with their symbols."""
    mechanism = setting.mechanism
    now: dict[str, list[Action]] = {}
    for action in Actions(mechanism, setting.reference).applied(
        np.array([setting.t]), setting.q[None], setting.v[None]
    ):
        if action.kind == "load" and np.abs(action.force).max() > 0:
            now.setdefault(action.name, []).append(action)
    for force in mechanism.forces:
        if isinstance(force, BodyLoad):
            wrench = force.wrench
            if wrench.force is not None:
                acting = now.get(force.name)
                present = acting[0].force[0] if acting else None
                yield from _push(setting, force.name, wrench, present)
            if wrench.torque is not None:
                at = setting.at(wrench.body)
                yield from _bend(at, 1.0, force.name, setting.clear_side(at))
        elif isinstance(force, JointLoad):
            if force.kind == "load":
                yield from _drive(setting, force)
        else:  # on each body that can move, as it is at this instant
            for action in now.get(force.name, ()):
                along, at = map(setting.camera.at, (action.force[0], action.origin[0]))
                if action.body != mechanism.ground and math.hypot(*along) > 1e-9:
                    yield from _draw_force(setting, action.body, at, unit(along), force.name)


def _push(setting: Setting, force: str, wrench: WrenchOnBody, now: Floats | None) -> Iterator[Mark]:
    """A force on a body, as it is at this instant if it has no symbol of its own."""
    given = wrench.force or ()
    present = np.array([0.0 if is_zero(c) else 1.0 for c in given])
    turn = np.eye(3)
    if wrench.axes != "world":
        turn = setting.poses[setting.index(wrench.axes), :3, :3]
    name = next((setting.name(c) for c in given if not is_zero(c)), "")
    if not name:
        name, present = force, present if now is None else now @ turn
    elif name.startswith("-"):
        name, present = name[1:], -present
    along = setting.camera.at(turn @ present)
    if math.hypot(*along) < 1e-9:
        return
    at = setting.at(wrench.body, wrench.point)
    yield from _draw_force(setting, wrench.body, at, unit(along), name)


def _draw_force(setting: Setting, body: str, at: Point, along: Point, name: str) -> Iterator[Mark]:
    """An arrow that points away from a body at a place on paper, from just outside it."""
    inside = max(setting.reach_from(at, body, along), 0.0)
    tail = at + (inside + 3.0) * along
    side = None
    if len(name) > LONG_NAME and abs(along[0]) < 0.95:
        side = np.array([-abs(along[1]), -abs(along[0])])
    gap = 5.0 if side is None else 7.0
    yield from named_arrow(tail, tail + ARROW * along, name, "force", side, gap)


def _drive(setting: Setting, force: JointLoad) -> Iterator[Mark]:
    """A drive in a hinge or a slide, acting on the child."""
    joint, camera = setting.mechanism.joint(force.joints[0]), setting.camera
    at = setting.at(joint.child)
    name = (setting.name(force.coefficient) or force.name).lstrip("-")
    if isinstance(joint, Prismatic):
        yield from _draw_force(setting, joint.child, at, unit(setting.along(joint)), name)
    elif isinstance(joint, Revolute):
        toward = float(setting.axis(joint) @ camera.toward)
        yield from _bend(at, toward, name, setting.clear_side(at))


def _bend(at: Point, toward: float, name: str, side: Point) -> Iterator[Mark]:
    """A bent arrow: counterclockwise on paper if its axis points towards the eye."""
    way, start = (1.0, START) if toward >= 0 else (-1.0, math.pi - START)
    angles = start - way * np.linspace(0.0, SWEEP, 40)
    yield from arc(at + BEND * directions(angles), "force")
    yield label(at, name, side, BEND + 3.0, "force-letter")


_LENGTH, _GAP = 34.0, 16.0
"""Length of the arrow, and its distance from the body that it moves [pt]."""

_RADIUS, _TURN = 22.0, np.linspace(-0.4, 1.6, 33)
"""Radius of an arc about the axis [pt], and the angles that it spans."""

_FACING = 0.2
"""Sine of the angle to the view below which an arrow would be seen from its end."""


def given_motions(setting: Setting) -> Iterator[Mark]:
    """Yield an arrow for each slide and each hinge that moves as time prescribes."""
    mechanism, driven = setting.mechanism, setting.mechanism.coordinates.driven
    for joint in mechanism.joints:
        if not isinstance(joint, (Prismatic, Revolute)):
            continue
        law = driven.get(joint.coordinate, 0.0)
        names = symbols_in(law)
        if "t" not in names or names & set(mechanism.coordinates):
            continue
        words = f"{setting.letter(joint.coordinate)} = {_write(law)}"
        if isinstance(joint, Prismatic):
            yield from _slide(setting, joint, words)
        else:
            yield from _turn(setting, joint, words)


def _slide(setting: Setting, joint: Prismatic, words: str) -> Iterator[Mark]:
    """An arrow beside the body that slides."""
    step = setting.along(joint)
    if math.hypot(*step) < _FACING:
        return
    along = unit(step)
    middle = (setting.seat_at(joint) + setting.at(joint.child)) / 2
    side = across(along)
    side = -side if side[0] > 0 or (abs(side[0]) < 1e-9 and side[1] > 0) else side
    shift = max(setting.reach_from(middle, joint.child, side), 0.0) + _GAP
    tail = middle + shift * side - _LENGTH / 2 * along
    yield from named_arrow(tail, tail + _LENGTH * along, words, "coordinate", side, 7.0)


def _turn(setting: Setting, joint: Revolute, words: str) -> Iterator[Mark]:
    """An arc about the axis of the body that turns, beyond the body unless seen along the axis."""
    camera, axis = setting.camera, unit3(setting.axis(joint))
    step = camera.at(axis) / camera.scale
    at, facing = setting.seat_at(joint), math.hypot(*step) < _FACING
    if not facing:
        up = unit(step)
        above = setting.reach_from(at, joint.child, up)
        if above > 0:
            at = at + (above + _GAP) * up
    # seen along the axis, the arc begins where the body points
    ahead = setting.poses[setting.index(joint.child), :3, 0]
    first = unit3(np.cross(ahead, axis) if facing else np.cross(axis, camera.toward))
    second: Floats = np.cross(axis, first)
    ways = np.cos(_TURN)[:, None] * first + np.sin(_TURN)[:, None] * second
    points = at + camera.at(ways * _RADIUS / camera.scale)
    yield from arc(points, "coordinate")
    half = points[len(points) // 2]
    yield label(half, words, half - at, 5.0, "coordinate-letter")


def _write(law: Scalar) -> str:
    """A law as it is printed: factors without signs between them, time last."""
    text = str(plain(law)).replace("**", "^").replace("*", " ")
    return re.sub(r"\bt ((?:\w+ )*\w+)", r"\1 t", text)


POINT, BAR = re.compile("[A-Z]'?"), re.compile("[A-Z]{2,}")
"""The name of a joint that is the letter of a point, and of a bar by the points along it."""

MOST_LABELS = 14
"""A figure of more bodies than this is drawn without letters."""

SHORTEST_LINE = 3.0
"""Shorter lines between two joints are not drawn [pt]."""

LEGEND_GAP, LEGEND_SIZE, LEGEND_WIDTH = 18.0, 12.0, 60
"""Distance of a legend from its figure and size of its letters [pt], and characters of a line."""

PULLEY = 8.0
"""Radius of a pulley that only guides a cord around a corner [pt]."""


def figure(setting: Setting, *, legend: bool = True) -> tuple[Mark, ...]:
    """Return the marks of a mechanism's figure, in the order they are drawn."""
    lettered = len(setting.mechanism.bodies) <= MOST_LABELS
    marks = [
        *supports(setting),
        *_links(setting),
        *connections(setting),
        *solid_marks(setting),
        *_joints(setting),
        *nuts(setting),
    ]
    if lettered:
        marks += [*lengths(setting), *slopes(setting)]
        marks += [*coordinates(setting), *given_motions(setting)]
        marks += [*masses(setting), *_points(setting)]
    if lettered and legend:
        for parameter in _missing(setting, marks):
            marks += missing(setting, parameter.symbol)
    marks = [*clear_letters([*marks, *loads(setting)])]
    if marks:
        marks += _gravity(setting, marks)
    if marks and lettered and legend:
        marks += _legend(setting, marks)
    return tuple(marks)


def _missing(setting: Setting, marks: Sequence[Mark]) -> Iterator[Parameter]:
    """The lengths and angles of a mechanism whose letters stand nowhere in its figure."""
    for parameter in setting.mechanism.parameters:
        symbol = rich(setting.letter(parameter.symbol))
        written = (mark.parts for mark in marks if isinstance(mark, Words))
        if parameter.unit in ("m", "rad") and not any(_holds(parts, symbol) for parts in written):
            yield parameter


def _legend(setting: Setting, marks: list[Mark]) -> Iterator[Mark]:
    """What lengths and angles are that stand nowhere in the figure, in lines below it."""
    left, _, _, bottom = bounds(marks)
    place = np.array([left, bottom + LEGEND_GAP])
    letters = "|".join(map(re.escape, setting.mechanism.coordinates))
    for parameter in [*_missing(setting, marks)]:
        lines = textwrap.wrap(parameter.meaning, LEGEND_WIDTH) or [""]
        for k, line in enumerate(lines):
            words = re.split(rf"\b({letters})\b", f"   {line}" if k else f": {line}")
            parts = () if k else rich(setting.letter(parameter.symbol))
            for place_in_line, word in enumerate(words):
                parts += rich(setting.letter(word)) if place_in_line % 2 else ((word, "upright"),)
            yield Words(place, parts, "name", "start", LEGEND_SIZE)
            place = place + np.array([0.0, 1.3 * LEGEND_SIZE])


def _holds(parts: tuple[tuple[str, str], ...], symbol: tuple[tuple[str, str], ...]) -> bool:
    """Whether a symbol stands in a text, and not with another index."""
    for k in range(len(parts)):
        part, after = parts[k : k + len(symbol)], parts[k + len(symbol) :]
        if part == symbol and not (after and after[0][1] == "below"):
            return True
    return False


def solid_marks(setting: Setting, body: str | None = None) -> Iterator[Mark]:
    """Yield the solids, those of the ground and those behind first."""
    shown = [solid for solid in setting.solids if body is None or solid.body == body]
    ground = setting.mechanism.ground

    def order(solid: Outline) -> tuple[bool, bool, float]:
        depth = setting.camera.depth(solid.ends.mean(axis=0))
        # parts with one center keep their order, whatever rounding says
        return solid.body != ground, solid.kind == "ball", round(depth, 9)

    for solid in sorted(shown, key=order):
        yield from outline(solid, setting.camera)


def _links(setting: Setting) -> Iterator[Mark]:
    """Lines along bodies without solids, from joint to joint, and along extended slides.

    A ground that has a mass and carries several limbs is the trunk of a robot, which joins them.
    """
    mechanism, ground = setting.mechanism, setting.mechanism.ground
    shown = {solid.body for solid in setting.solids}
    limbs = [joint.parent for joint in mechanism.joints].count(ground)
    if limbs < 2 or is_zero(mechanism.body(ground).mass):
        shown.add(ground)
    lines = [force for force in mechanism.forces if isinstance(force, LineLoad)]
    sprung = {body for line in lines if line.kind != "load" for body in line.bodies}
    pulled = {body for line in lines for body in line.bodies} - sprung
    for joint in mechanism.joints:
        bare = joint.parent not in shown
        if bare:
            yield from _line(setting.at(joint.parent), setting.seat_at(joint))
        if not isinstance(joint, Prismatic) or loads_in(mechanism.forces, joint.name):
            continue
        if bare and joint.child not in sprung and not _find_leader(setting, joint):
            style = "axis" if joint.child in pulled else "cable"
            yield from _line(setting.seat_at(joint), setting.at(joint.child), style)

    yield from _cords(setting)


def _line(a: Point, b: Point, style: str = "cable") -> Iterator[Mark]:
    if math.hypot(*(b - a)) > SHORTEST_LINE:
        yield Stroke(np.array([a, b]), style)


def _cords(setting: Setting) -> Iterator[Mark]:
    """The stretches of cords from where they leave one thing to where they touch the next."""
    mechanism, camera = setting.mechanism, setting.camera
    for element in setting.switching:
        for run in map(mechanism.joint, list_cord_runs(element)):
            yield from _line(setting.seat_at(run), setting.at(run.child))
    state = setting.q, setting.v, setting.t
    for start, end in cord_stretches(mechanism, setting.reference, *state):
        yield from _line(camera.at(start), camera.at(end))
    for cord in mechanism.elements:
        for wheel in cord.over if isinstance(cord, Strung) else ():
            if is_zero(wheel.radius):
                yield Circle(setting.at(wheel.body, wheel.center), PULLEY / 2, "pin")


def _joints(setting: Setting) -> Iterator[Mark]:
    mechanism, camera = setting.mechanism, setting.camera
    shown = {solid.body for solid in setting.solids} | {mechanism.ground}
    wheels = {solid.body for solid in setting.solids if solid.kind == "cylinder"}
    for joint in mechanism.joints:
        at = setting.at(joint.child)
        if isinstance(joint, Revolute) and not camera.flat:
            yield Circle(at, 3.2, "pin")
        elif isinstance(joint, Revolute):
            if joint.parent == mechanism.ground and _is_center(setting, joint):
                continue
            if joint.child not in wheels or joint.parent in shown:
                yield from pin(at)
        elif isinstance(joint, (Spherical, Universal)):
            yield Circle(at, 4.2, "pin")
            yield Circle(at, 1.4, "tip")
    pins = [element for element in mechanism.elements if isinstance(element, Loop)]
    for loop in (*mechanism.loops, *pins):
        yield from _loop(setting, loop)


def _points(setting: Setting) -> Iterator[Words]:
    """The letters of points: of joints, of loops, and along bars that are named by them, as ABC."""
    mechanism = setting.mechanism
    places = {joint.name: setting.at(joint.child) for joint in mechanism.joints}
    for loop in mechanism.loops:
        places[loop.name] = setting.at(loop.body_a, loop.frame_a.xyz)
    for body in mechanism.bodies:
        own = [solid for solid in setting.solids if solid.body == body.name]
        rods = [end for solid in own if solid.kind == "rod" for end in solid.ends]
        spots = [*rods, *(solid.ends.mean(axis=0) for solid in own if solid.kind == "ball")]
        if BAR.fullmatch(body.name) and len(spots) == len(body.name):
            start = setting.point(body.name)
            spots.sort(key=lambda spot: float(np.linalg.norm(spot - start)))
            for name, spot in zip(body.name, spots, strict=True):
                places.setdefault(name, setting.camera.at(spot))
    for name, at in places.items():
        if POINT.fullmatch(name) and name not in mechanism.values:
            yield label(at, name, setting.clear_side(at), 7.0)


def _loop(setting: Setting, loop: Loop) -> Iterator[Mark]:
    """The pin that closes a loop, on the ground if that holds it; two and a line for a distance."""
    a = setting.at(loop.body_a, loop.frame_a.xyz)
    b = setting.at(loop.body_b, loop.frame_b.xyz)
    if loop.kind == "distance":
        yield Stroke(np.array([a, b]), "cable")
        yield from (*pin(a), *pin(b))
    else:
        grounded = setting.mechanism.ground in (loop.body_a, loop.body_b)
        yield from pin(a, np.array([0.0, 1.0]) if grounded else None)


def _gravity(setting: Setting, marks: list[Mark]) -> Iterator[Mark]:
    """The direction of free fall, beside the figure, unless it points into the paper."""
    mechanism, camera = setting.mechanism, setting.camera
    gravity = np.array(mechanism.evaluate_all(mechanism.gravity))
    size = float(np.linalg.norm(gravity)) * camera.scale
    down = camera.at(gravity)
    if size == 0 or math.hypot(*down) < 0.3 * size:
        return
    names = [setting.name(component) for component in mechanism.gravity if not is_zero(component)]
    _, top, right, _ = bounds(marks)
    tail = np.array([right + 22.0, top + 4.0])
    name = (names[0] or "g").lstrip("-")
    yield from named_arrow(tail, tail + 36.0 * unit(down), name, "thin", np.array([1.0, 0.0]))
