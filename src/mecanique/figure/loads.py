"""Forces, torques and drives of a figure, as arrows with their symbols."""

from __future__ import annotations

import math
import re
from collections.abc import Iterator

import numpy as np

from mecanique.figure.camera import Floats
from mecanique.figure.paper.arrows import arc, arrow
from mecanique.figure.paper.marks import Mark, Point, across, label, unit
from mecanique.figure.setting import Setting, is_zero
from mecanique.figure.solids import unit3
from mecanique.model.expression import Scalar, plain, symbols_in
from mecanique.model.force_base import BodyLoad, JointLoad, WrenchOnBody
from mecanique.model.joints import Prismatic, Revolute
from mecanique.motion.analysis.forces import Actions

ARROW = 42.0
"""Length of an arrow [pt]."""

LONG_NAME = 3
"""A longer name stands beside an arrow rather than at its tip [characters]."""

BEND, START, SWEEP = 20.0, 0.3, 1.35 * math.pi
"""Radius of a bent arrow [pt], its first angle and its extent [rad]."""


def loads(setting: Setting) -> Iterator[Mark]:
    """Yield forces, torques and drives as arrows with their symbols."""
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
                yield from _bend(at, 1.0, force.name, setting.clear_side(at))
        elif isinstance(force, JointLoad) and force.kind == "load":
            yield from _drive(setting, force)


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
    along = unit(along)
    at = setting.camera.at(setting.point(wrench.body, wrench.point))
    tail = _beyond(setting, wrench.body, at, along)
    tip = tail + ARROW * along
    yield from arrow(tail, tip, "force")
    if len(name) > LONG_NAME and abs(along[0]) < 0.95:
        side = np.array([-abs(along[1]), -abs(along[0])])
        yield label((tail + tip) / 2, name, side, 7.0, "force-letter")
    else:
        yield label(tip, name, along, 5.0, "force-letter")


def _beyond(setting: Setting, body: str, at: Point, along: Point) -> Point:
    """The tail of an arrow that points away from a body at a place on paper: just outside it."""
    inside = max(setting.reach(body, along) - float(at @ along), 0.0)
    return at + (inside + 3.0) * along


def _drive(setting: Setting, force: JointLoad) -> Iterator[Mark]:
    """A drive in a hinge or a slide, acting on the child."""
    joint, camera = setting.mechanism.joint(force.joint), setting.camera
    at = camera.at(setting.point(joint.child))
    name = (setting.name(force.coefficient) or force.name).lstrip("-")
    if isinstance(joint, Prismatic):
        along = unit(camera.at(setting.axis(joint)))
        tail = _beyond(setting, joint.child, at, along)
        yield from arrow(tail, tail + ARROW * along, "force")
        yield label(tail + ARROW * along, name, along, 5.0, "force-letter")
    elif isinstance(joint, Revolute):
        toward = float(setting.axis(joint) @ camera.toward)
        yield from _bend(at, toward, name, setting.clear_side(at))


def _bend(at: Point, toward: float, name: str, side: Point) -> Iterator[Mark]:
    """A bent arrow: counterclockwise on paper if its axis points towards the eye."""
    way, start = (1.0, START) if toward >= 0 else (-1.0, math.pi - START)
    angles = start - way * np.linspace(0.0, SWEEP, 40)
    points = at + BEND * np.stack([np.cos(angles), np.sin(angles)], axis=1)
    yield from arc(points, "force")
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
        words = f"{joint.coordinate} = {_write(law)}"
        if isinstance(joint, Prismatic):
            yield from _slide(setting, joint, words)
        else:
            yield from _turn(setting, joint, words)


def _slide(setting: Setting, joint: Prismatic, words: str) -> Iterator[Mark]:
    """An arrow beside the body that slides."""
    camera = setting.camera
    step = camera.at(setting.axis(joint)) / camera.scale
    if math.hypot(*step) < _FACING:
        return
    along = unit(step)
    middle = (camera.at(setting.seat(joint)) + camera.at(setting.point(joint.child))) / 2
    side = across(along)
    side = -side if side[0] > 0 or (abs(side[0]) < 1e-9 and side[1] > 0) else side
    shift = max(setting.reach(joint.child, side) - float(middle @ side), 0.0) + _GAP
    tail = middle + shift * side - _LENGTH / 2 * along
    yield from arrow(tail, tail + _LENGTH * along, "coordinate")
    yield label(tail + _LENGTH / 2 * along, words, side, 7.0, "coordinate-letter")


def _turn(setting: Setting, joint: Revolute, words: str) -> Iterator[Mark]:
    """An arc about the axis of the body that turns, beyond the body unless seen along the axis."""
    camera, axis = setting.camera, unit3(setting.axis(joint))
    step = camera.at(axis) / camera.scale
    at, facing = camera.at(setting.seat(joint)), math.hypot(*step) < _FACING
    if not facing:
        up = unit(step)
        above = setting.reach(joint.child, up) - float(at @ up)
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
