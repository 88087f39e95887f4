"""Forces, torques and drives of a figure, as arrows with their symbols."""

from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np

from mecanique.figure.camera import Floats
from mecanique.figure.paper.marks import Mark, Point
from mecanique.figure.paper.signs import arc, arrow, label, unit
from mecanique.figure.setting import Setting, is_zero
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
