"""Springs and dampers of a figure, between points and in joints."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np

from mecanique.figure.paper.marks import Mark, Point, Stroke, across, label, unit
from mecanique.figure.paper.symbols import dashpot, hatch, spiral, spring
from mecanique.figure.setting import Setting
from mecanique.figure.supports import stands_on_columns, wall
from mecanique.model.force_base import End, JointLoad, LineLoad
from mecanique.model.joints import Prismatic, Revolute

_NEARLY = 0.8
"""Cosine of the angle to the level or the vertical up to which a wall is not tilted."""


def connections(setting: Setting) -> Iterator[Mark]:
    """Yield every spring and damper with its symbol."""
    pairs: dict[tuple[End, End], list[LineLoad]] = {}
    inside: dict[str, list[JointLoad]] = {}
    for force in setting.mechanism.forces:
        if isinstance(force, LineLoad):
            pairs.setdefault(force.ends, []).append(force)
        elif isinstance(force, JointLoad) and force.kind != "load":
            inside.setdefault(force.joint, []).append(force)
    for links in pairs.values():
        yield from _between(setting, links)
    for name, loads in inside.items():
        joint = setting.mechanism.joint(name)
        if isinstance(joint, Prismatic):
            yield from _in_slide(setting, joint, loads)
        elif isinstance(joint, Revolute):
            yield from _in_hinge(setting, joint, loads)


def _between(setting: Setting, links: Sequence[LineLoad]) -> Iterator[Mark]:
    first, camera = links[0], setting.camera
    a, b = (camera.at(setting.point(end.body, end.point)) for end in first.ends)
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
    camera = setting.camera
    a, b = camera.at(setting.seat(joint)), camera.at(setting.point(joint.child))
    along = unit(camera.at(setting.axis(joint)))
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
        yield from _bundle(setting, a, _surface(setting, joint.child, b, -along), loads)
        return
    tip = _surface(setting, joint.child, b, -along)
    foot = tip - 74.0 * along
    if joint.parent in solids:
        foot = a + (setting.reach(joint.parent, along) - float(a @ along)) * along
    else:
        yield from wall(foot, along)
    yield from _bundle(setting, foot, tip, loads)


def _columns(setting: Setting, joint: Prismatic, loads: Sequence[JointLoad]) -> Iterator[Mark]:
    """Two elastic columns that carry a floor above another floor or above the ground."""
    camera = setting.camera
    high = camera.at(setting.point(joint.child))
    parent = camera.at(setting.point(joint.parent))
    along = unit(camera.at(setting.axis(joint)))
    up = -np.array([0.0, 1.0])
    half = setting.reach(joint.child, along) - float(high @ along) - 8
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
    at = setting.camera.at(setting.point(joint.child))
    for load in loads:
        sprung = load.kind == "spring"
        name = setting.name(load.coefficient)
        if sprung:
            yield from spiral(at, 0.0)
        if name:
            side = setting.clear_side(at)
            yield label(
                at,
                name,
                side if sprung else np.array([side[0], -side[1]]),
                20.0 if sprung else 14.0,
            )
