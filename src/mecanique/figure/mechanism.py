"""A mechanism as a textbook draws it: bodies, joints, ground, springs, dampers, loads, lengths and coordinates."""

from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np

from mecanique.figure.camera import Floats
from mecanique.figure.connections import connections
from mecanique.figure.coordinates import coordinates
from mecanique.figure.lettering import clear_letters
from mecanique.figure.marks import Circle, Mark, Point, Stroke
from mecanique.figure.setting import Setting
from mecanique.figure.signs import across, arc, arrow, dimension, label, pin, unit
from mecanique.figure.solids import Solid, outline, radius_of
from mecanique.figure.supports import supports
from mecanique.model.bodies import Body
from mecanique.model.forces import BodyLoad, JointLoad, LineLoad, WrenchOnBody, loads_in
from mecanique.model.joints import (
    Fixed,
    Floating,
    Planar,
    Prismatic,
    Revolute,
    Spherical,
    Universal,
)
from mecanique.model.visuals import Cylinder
from mecanique.motion.analysis.forces import Actions

__all__ = ["figure", "solid_marks"]

MOST_LABELS = 14
"""With more bodies than this a figure is drawn without letters."""


def figure(setting: Setting) -> tuple[Mark, ...]:
    """Return the marks of a mechanism's figure, in the order they are drawn.

    Args:
        setting: what is drawn.
    """
    lettered = len(setting.mechanism.bodies) <= MOST_LABELS
    marks = [
        *supports(setting),
        *_links(setting),
        *connections(setting),
        *solid_marks(setting),
        *_joints(setting),
    ]
    if lettered:
        marks += [*_lengths(setting), *coordinates(setting), *_masses(setting)]
    marks = [*clear_letters([*marks, *_loads(setting)])]
    if marks:
        marks += _gravity(setting, marks)
    return tuple(marks)


def solid_marks(setting: Setting, body: str | None = None) -> Iterator[Mark]:
    """Yield the solids, those behind first.

    Args:
        setting: what is drawn.
        body: whose; all by default.
    """
    shown = [each for each in setting.solids if body is None or each.body == body]
    for solid in sorted(
        shown, key=lambda s: (s.kind == "ball", setting.camera.depth(s.ends.mean(axis=0)))
    ):
        yield from outline(solid, setting.camera)


def _links(setting: Setting) -> Iterator[Mark]:
    """Lines along bodies that have nothing to show, from joint to joint, and along slides that span a distance."""
    mechanism, camera = setting.mechanism, setting.camera
    bare = (
        {body.name for body in mechanism.bodies}
        - {each.body for each in setting.solids}
        - {mechanism.ground}
    )
    seats = {joint.child: setting.point(joint.child) for joint in mechanism.joints}
    lines = [force for force in mechanism.forces if isinstance(force, LineLoad)]
    sprung = {body for line in lines for body in line.bodies}
    for joint in mechanism.joints:
        a, b = camera.at(setting.seat(joint)), camera.at(setting.point(joint.child))
        if joint.parent in bare and math.hypot(*(a - camera.at(seats[joint.parent]))) > 3:
            yield Stroke(np.array([camera.at(seats[joint.parent]), a]), "cable")
        if not isinstance(joint, Prismatic) or loads_in(mechanism.forces, joint.name):
            continue
        if camera.flat and abs(float(setting.axis(joint)[2])) > 0.9:
            yield from _cord(setting, joint)
        elif joint.parent in bare and joint.child not in sprung and math.hypot(*(b - a)) > 3:
            yield Stroke(np.array([a, b]), "cable")


def _cord(setting: Setting, joint: Prismatic) -> Iterator[Mark]:
    """What a weight on an upright slide hangs from: a pulley whose rim is above it, or a hinge of the ground."""
    camera, mechanism = setting.camera, setting.mechanism
    at = camera.at(setting.point(joint.child))
    wheels = [s for s in setting.solids if s.kind == "cylinder" and s.body != joint.child]
    for wheel in wheels:
        center, radius = camera.at(wheel.ends[0]), wheel.size * camera.scale
        if center[1] < at[1] and abs(abs(at[0] - center[0]) - radius) < 0.02 * radius + 1:
            yield Stroke(np.array([at, [at[0], center[1]]]), "cable")
            return
    hinges = [
        j for j in mechanism.joints if j.parent == mechanism.ground and isinstance(j, Revolute)
    ]
    if (
        hinges
        and not wheels
        and joint.coordinate in mechanism.coordinates.driven
        and setting.solids
    ):
        hinge = camera.at(setting.point(hinges[0].child))
        corner = np.array([at[0], hinge[1]])
        if corner[1] < at[1] and math.hypot(*(corner - hinge)) > 12:
            way = math.copysign(8.0, hinge[0] - corner[0])
            yield Stroke(np.array([at, corner]), "cable")
            yield Stroke(
                np.array([[corner[0] + way, corner[1] - 8.0], [hinge[0], hinge[1] - 8.0]]), "cable"
            )
            yield Circle(corner + np.array([way, 0.0]), 8.0, "pin")


def _joints(setting: Setting) -> Iterator[Mark]:
    mechanism, camera = setting.mechanism, setting.camera
    shown = {each.body for each in setting.solids}
    for joint in mechanism.joints:
        at = camera.at(setting.point(joint.child))
        if isinstance(joint, (Fixed, Prismatic, Planar, Floating)):
            continue
        if isinstance(joint, Revolute) and camera.flat:
            wheel = any(
                each.kind == "cylinder" and each.body == joint.child for each in setting.solids
            )
            if not wheel or joint.parent in shown or joint.parent == mechanism.ground:
                yield from pin(at)
        elif isinstance(joint, (Spherical, Universal)):
            yield Circle(at, 4.2, "pin")
            yield Circle(at, 1.4, "tip")
        elif isinstance(joint, Revolute):
            yield Circle(at, 3.2, "pin")
    for loop in mechanism.loops:
        ends = [
            camera.at(setting.point(body, f.xyz))
            for body, f in ((loop.body_a, loop.frame_a), (loop.body_b, loop.frame_b))
        ]
        if loop.kind == "distance":
            yield Stroke(np.array(ends), "cable")
        grounded = mechanism.ground in (loop.body_a, loop.body_b) and loop.kind != "distance"
        for end in ends if loop.kind == "distance" else ends[:1]:
            yield from pin(end, np.array([0.0, 1.0]) if grounded else None)


def _lengths(setting: Setting) -> Iterator[Mark]:
    """The symbols of rods' lengths and of disks' radii."""
    camera = setting.camera
    told: set[str] = set()
    for solid in setting.solids:
        geometry = solid.geometry
        if not isinstance(geometry, Cylinder):
            continue
        name = setting.name(geometry.length if solid.kind == "rod" else geometry.radius)
        if not name or name in told:
            continue
        if solid.kind == "rod":
            a, b = camera.at(solid.ends)
            if math.hypot(*(b - a)) < 40:
                continue
            if not camera.flat:
                yield label((a + b) / 2, name, across(unit(b - a)), 9.0)
            else:
                yield from dimension(a, b, name, _outward(setting, a, b) * 18.0)
        elif (
            solid.size * camera.scale > 18
            and camera.flat
            and abs(float(solid.pose[:3, 2] @ camera.toward)) > 0.9
        ):
            center = camera.at(solid.ends[0])
            rim = center + solid.size * camera.scale * np.array([math.cos(-0.7), math.sin(-0.7)])
            yield from arrow(center, rim, "thin")
            yield label((center + rim) / 2, name, np.array([-0.6, -0.8]), 4.0)
        else:
            continue
        told.add(name)


def _outward(setting: Setting, a: Point, b: Point) -> float:
    """The side of a line on which the figure has less: 1 to the left as one goes from a to b, -1 to the right."""
    side = across(unit(b - a))
    spread = [
        float((setting.camera.at(each.ends.mean(axis=0)) - a) @ side) for each in setting.solids
    ]
    return -1.0 if sum(spread) > 1e-6 else 1.0


def _masses(setting: Setting) -> Iterator[Mark]:
    """The symbol of each piece's mass, in or beside it."""
    camera, mechanism = setting.camera, setting.mechanism
    middle = np.mean(
        [camera.at(each.ends.mean(axis=0)) for each in setting.solids] or [np.zeros(2)], axis=0
    )
    for body in mechanism.bodies:
        pieces = iter([each for each in setting.solids if each.body == body.name])
        for name, solid in _named(setting, body, pieces):
            at = camera.at(solid.ends.mean(axis=0))
            if solid.kind == "rod":
                a, b = camera.at(solid.ends)
                side = across(unit(b - a)) * -_outward(setting, a, b)
                yield label(a + 0.62 * (b - a), name, side, 7.0)
            elif solid.kind == "ball":
                yield label(at, name, setting.clear_side(at), radius_of(solid, camera) + 4.0)
            elif solid.kind == "cylinder" and _room(solid, setting) <= 26:
                yield label(at, name, setting.clear_side(at), solid.size * camera.scale + 4.0)
            elif _room(solid, setting) > 26:
                seats = [
                    camera.at(setting.point(j.child))
                    for j in mechanism.joints
                    if body.name in (j.parent, j.child)
                ]
                busy = solid.kind == "cylinder" or any(
                    math.hypot(*(seat - at)) < 14 for seat in seats
                )
                pinned = any(
                    not isinstance(j, Prismatic)
                    for j in mechanism.joints
                    if body.name in (j.parent, j.child)
                )
                away = np.array([-1.0, 0.6]) if busy and pinned else np.array([0.0, 1.0])
                yield label(at, name, away, 8.0 if busy and pinned else -5.4)
            else:
                side = np.array([-1.0 if at[0] <= middle[0] + 1 else 1.0, 0.0])
                yield label(
                    np.array([side[0] * setting.reach(body.name, side), at[1]]), name, side, 6.0
                )


def _room(solid: Solid, setting: Setting) -> float:
    """The smaller extent of a solid on paper [pt]."""
    return float(np.ptp(setting.camera.at(solid.corners), axis=0).min())


def _named(setting: Setting, body: Body, pieces: Iterator[Solid]) -> Iterator[tuple[str, Solid]]:
    """The pieces of a body that have a mass with a short name, each with its largest solid."""
    for shape in body.shapes:
        own = [solid for _, solid in zip(shape.visuals, pieces, strict=False)]
        name = setting.name(shape.mass)
        if own and name:
            yield name, max(own, key=lambda each: float(np.ptp(each.corners, axis=0).max()))


def _loads(setting: Setting) -> Iterator[Mark]:
    """Forces, torques and drives as arrows with their symbols."""
    mechanism, camera = setting.mechanism, setting.camera
    acting = Actions(mechanism, setting.reference).applied(
        np.array([setting.t]), setting.q[None], setting.v[None]
    )
    now = {
        action.name: action.force[0]
        for action in acting
        if action.kind == "load" and np.abs(action.force).max() > 0
    }
    for force in mechanism.forces:
        if isinstance(force, BodyLoad):
            wrench = force.wrench
            if wrench.force is not None:
                yield from _push(setting, force.name, wrench, now.get(force.name))
            if wrench.torque is not None:
                at = camera.at(setting.point(wrench.body))
                yield from _bent(at, 20.0, 1.0, force.name, setting.clear_side(at))
        elif isinstance(force, JointLoad) and force.kind == "load":
            yield from _drive(setting, force)


def _push(setting: Setting, force: str, wrench: WrenchOnBody, now: Floats | None) -> Iterator[Mark]:
    """A force on a body; without a symbol of its own, as it is now."""
    given = wrench.force or ()
    present = np.array([0.0 if _nought(c) else 1.0 for c in given])
    turn = np.eye(3)
    if wrench.axes != "world":
        turn = setting.poses[setting.index(wrench.axes), :3, :3]
    name = next((setting.name(c) for c in given if not _nought(c)), "")
    if not name:
        name, present = force, present if now is None else now @ turn
    elif name.startswith("-"):
        name, present = name[1:], -present
    along = setting.camera.at(turn @ present)
    if math.hypot(*along) < 1e-9:
        return
    along = unit(along)
    at = setting.camera.at(setting.point(wrench.body, wrench.point))
    beyond = max(setting.reach(wrench.body, along) - float(at @ along), 0.0)
    tail = at + beyond * along + 3 * along
    yield from arrow(tail, tail + 42 * along, "force")
    if len(name) > 3 and abs(along[0]) < 0.95:
        side = np.array([-abs(along[1]), -abs(along[0])])
        yield label(tail + 21 * along, name, side, 7.0, "force-letter")
    else:
        yield label(tail + 42 * along, name, along, 5.0, "force-letter")


def _drive(setting: Setting, force: JointLoad) -> Iterator[Mark]:
    """A drive in a hinge or a slide, on the child."""
    joint, camera = setting.mechanism.joint(force.joint), setting.camera
    at = camera.at(setting.point(joint.child))
    name = (setting.name(force.coefficient) or force.name).lstrip("-")
    if isinstance(joint, Prismatic):
        along = unit(camera.at(setting.axis(joint)))
        tail = at + (setting.reach(joint.child, along) - float(at @ along)) * along + 3 * along
        yield from arrow(tail, tail + 42 * along, "force")
        yield label(tail + 42 * along, name, along, 5.0, "force-letter")
    elif isinstance(joint, Revolute):
        toward = float(setting.axis(joint) @ camera.toward)
        yield from _bent(at, 20.0, toward, name, setting.clear_side(at))


def _bent(at: Point, radius: float, sign: float, name: str, side: Point) -> Iterator[Mark]:
    way = 1.0 if sign >= 0 else -1.0
    turn = -way * np.linspace(0.0, 1.35 * math.pi, 40) + (0.3 if way > 0 else math.pi - 0.3)
    points = at + radius * np.stack([np.cos(turn), np.sin(turn)], axis=1)
    yield from arc(points, "force")
    yield label(at, name, side, radius + 3.0, "force-letter")


def _nought(scalar: object) -> bool:
    return isinstance(scalar, (int, float)) and scalar == 0


def _gravity(setting: Setting, marks: list[Mark]) -> Iterator[Mark]:
    """The direction of free fall, beside the figure."""
    from mecanique.figure.marks import bounds

    mechanism, camera = setting.mechanism, setting.camera
    gravity = np.array([mechanism.evaluate(g) for g in mechanism.gravity])
    down = camera.at(gravity)
    if (
        not np.linalg.norm(gravity) > 0
        or math.hypot(*down) < 0.3 * np.linalg.norm(gravity) * camera.scale
    ):
        return
    named = next((setting.name(g) for g in mechanism.gravity if not _nought(g)), "") or "g"
    _, top, right, _ = bounds(marks)
    tail = np.array([right + 22.0, top + 4.0])
    tip = tail + 36.0 * unit(down)
    yield from arrow(tail, tip, "thin")
    yield label((tail + tip) / 2, named.lstrip("-"), np.array([1.0, 0.0]), 5.0, "name")
