"""The ground of a figure: hatched supports under hinges, rollers and rails under slides."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass
from typing import final

import numpy as np

from mecanique.figure.paper.marks import Circle, Mark, Point, Stroke, across, unit
from mecanique.figure.paper.symbols import hatch, pin
from mecanique.figure.setting import Setting
from mecanique.model.force_base import loads_in
from mecanique.model.joint_base import Single
from mecanique.model.joints import Prismatic, Revolute, Spherical, Universal

DOWN = np.array([0.0, 1.0])

NUT = (11.0, 8.0)
"""Half the width and half the height of a nut [pt]."""

THREADS = 3
"""How many turns of the thread are drawn in a nut."""


def supports(setting: Setting) -> Iterator[Mark]:
    """Yield what holds the joints of the ground."""
    yield from _slabs(setting)
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
    line = center + (depth + 8.0) * below
    inset = max(half - 9.0, 0.45 * half)
    top = center + (depth + 4.0) * below
    yield _Rail(
        line + (min(ends) - half - 26) * along,
        line + (max(ends) + half + 26) * along,
        below,
        (top - inset * along, top + inset * along),
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
