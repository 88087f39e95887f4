"""A body cut free, with every force on it as a labelled arrow, inertia forces dashed."""

from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np

from mecanique.figure.mechanism import solid_marks
from mecanique.figure.paper.marks import Circle, Mark, Point, Words, bounds
from mecanique.figure.paper.signs import arc, arrow, label, unit
from mecanique.figure.setting import Setting
from mecanique.model.elements import Cord
from mecanique.motion.analysis.forces import TOGETHER, Action, Actions

__all__ = ["cut_free"]

LONGEST, SHORTEST = 110.0, 18.0
"""Lengths of the largest and of the smallest arrow [pt]."""

_UNKNOWN = "S, C: reactions and guides together; each by itself is undetermined"
"""Note below a body on which forces act that the mechanism does not describe."""

WIDE = 150.0
"""Labels nearer to one another than this, at one height, overlap [pt]."""

NEGLIGIBLE = 1e-6
"""Forces smaller than this fraction of the largest are not drawn."""


def cut_free(setting: Setting, body: str) -> tuple[Mark, ...]:
    """Return the marks of a body's free-body diagram."""
    actions = [action for action in _acting(setting) if action.body == body]
    force = max((float(np.linalg.norm(each.force)) for each in actions), default=0.0)
    moment = max((float(np.linalg.norm(each.moment)) for each in actions), default=0.0)
    marks: list[Mark] = list(solid_marks(setting, body))
    arrows: list[Mark] = []
    taken: list[Point] = []
    for each in actions:
        at = setting.camera.at(each.origin[0])
        if np.linalg.norm(each.force) > NEGLIGIBLE * force:
            arrows += _force(setting, each, at, force, taken)
        if np.linalg.norm(each.moment) > max(NEGLIGIBLE * moment, 1e-9 * force):
            arrows += _moment(setting, each, at, taken)
    spots = {tuple(np.round(setting.camera.at(each.origin[0]), 1)) for each in actions}
    marks += [*arrows, *(Circle(np.array(spot), 2.4, "tip") for spot in sorted(spots))]
    if marks:
        left, top, right, bottom = bounds(marks)
        middle = (left + right) / 2
        marks.append(Words(np.array([middle, top - 14.0]), ((body, "upright"),), "name"))
        if any(each.name == TOGETHER for each in actions):
            marks.append(Words(np.array([middle, bottom + 22.0]), ((_UNKNOWN, "upright"),), "name"))
    return tuple(marks)


def _acting(setting: Setting) -> Iterator[Action]:
    acting = Actions(setting.mechanism, setting.reference)
    t, q, v = np.array([setting.t]), setting.q[None], setting.v[None]
    yield from acting.applied(t, q, v)
    yield from acting.reactions(t, q, v)
    yield from acting.inertia(t, q, v, np.asarray(setting.reference.acceleration(q, v, t)))


def _force(
    setting: Setting, action: Action, at: Point, largest: float, taken: list[Point]
) -> Iterator[Mark]:
    size = float(np.linalg.norm(action.force))
    paper = setting.camera.at(action.force[0]) / setting.camera.scale
    seen = float(np.hypot(*paper)) / size
    if seen < 0.05:
        return
    along = unit(paper)
    length = (SHORTEST + (LONGEST - SHORTEST) * size / largest) * seen
    style = "inertia" if action.kind == "inertia" else "force"
    tip = at + length * along
    yield from arrow(at, tip, style)
    yield _label(_free(tip, along, taken), _symbol(setting, action, False), size, "N", along, style)


def _moment(setting: Setting, action: Action, at: Point, taken: list[Point]) -> Iterator[Mark]:
    size = float(np.linalg.norm(action.moment))
    along = float(action.moment[0] @ setting.camera.toward) / size
    if abs(along) < 0.05:
        return
    style = "inertia" if action.kind == "inertia" else "force"
    way, radius = math.copysign(1.0, along), 24.0 if style == "inertia" else 30.0
    turn = -way * np.linspace(0.0, 1.3 * math.pi, 40) - 0.4 * way
    points = at + radius * np.stack([np.cos(turn), np.sin(turn)], axis=1)
    yield from arc(points, style)
    side = np.array([0.7, 0.7])
    yield _label(
        _free(at + radius * side, side, taken),
        _symbol(setting, action, True),
        size,
        "N·m",
        side,
        style,
    )


def _free(at: Point, along: Point, taken: list[Point]) -> Point:
    """A place for a label, moved outwards past the labels already placed."""
    while any(abs(at[1] - other[1]) < 16 and abs(at[0] - other[0]) < WIDE for other in taken):
        at = at + np.array([0.0, 17.0 if along[1] >= 0 else -17.0])
    taken.append(at)
    return at


def _label(at: Point, symbol: str, size: float, unit_: str, along: Point, style: str) -> Words:
    words = label(at, symbol, along, 8.0, f"{style}-letter")
    parts = (*words.parts, (f" = {size:.3g} {unit_}", "upright"))
    whole = Words(words.at, parts, words.style)
    # the near side of the longer label stays where the symbol's was
    return Words(
        words.at + np.array([along[0] * (whole.width - words.width) / 2, 0.0]), parts, words.style
    )


def _symbol(setting: Setting, action: Action, moment: bool) -> str:
    mass = setting.name(setting.mechanism.body(action.body).mass)
    if action.kind == "weight":
        return f"{mass}*g" if mass.isidentifier() else "G"
    if action.kind == "inertia":
        letter = mass if mass.isidentifier() else "m"
        return "-I*alpha" if moment else f"-{letter}*a"
    if action.name == TOGETHER:
        return "C" if moment else "S"
    cords = [each for each in setting.mechanism.elements if isinstance(each, Cord)]
    if any(action.name in cord.forces for cord in cords):
        return f"T_{action.name}"
    stem = "".join(sign if sign.isalnum() else "_" for sign in action.name).strip("_") or "force"
    letters = {
        "reaction": "M" if moment else "R",
        "spring": "M" if moment else "F",
        "damper": "M" if moment else "D",
    }
    return f"{letters.get(action.kind, 'M' if moment else 'F')}_{stem}"
