"""Prescribed motions in a figure: an arrow along or about the joint, with the law it follows."""

from __future__ import annotations

import math
import re
from collections.abc import Iterator

import numpy as np

from mecanique.figure.camera import Floats
from mecanique.figure.paper.marks import Mark
from mecanique.figure.paper.signs import across, arc, arrow, label, unit
from mecanique.figure.setting import Setting
from mecanique.figure.solids import unit3
from mecanique.model.expression import Scalar, plain, symbols_in
from mecanique.model.joints import Prismatic, Revolute

_LENGTH, _GAP = 34.0, 16.0
"""Length of the arrow, and its distance from the body that it moves [pt]."""

_RADIUS, _TURN = 22.0, np.linspace(-0.4, 1.6, 33)
"""Radius of an arc about the axis [pt], and the angles that it spans."""

_FACING = 0.2
"""Sine of the angle to the view below which an arrow would be seen from its end."""


def given_motions(setting: Setting) -> Iterator[Mark]:
    """Yield an arrow for each slide and each hinge that moves as time prescribes.

    Args:
        setting: what is drawn.
    """
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
