"""A mechanism as a textbook draws it: bodies, joints, ground, springs, loads, coordinates."""

from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np

from mecanique.figure.connections import connections
from mecanique.figure.coordinates import coordinates
from mecanique.figure.loads import given_motions, loads
from mecanique.figure.measures import lengths, masses, slopes
from mecanique.figure.paper.arrows import arrow
from mecanique.figure.paper.lettering import clear_letters
from mecanique.figure.paper.marks import Circle, Mark, Point, Stroke, bounds, label, unit
from mecanique.figure.paper.symbols import pin
from mecanique.figure.setting import Setting, is_zero
from mecanique.figure.solids import Solid, outline
from mecanique.figure.supports import nuts, supports
from mecanique.model.constraint_base import Strung
from mecanique.model.constraints.loops import Loop
from mecanique.model.force_base import LineLoad, loads_in
from mecanique.model.joints import Prismatic, Revolute, Spherical, Universal

MOST_LABELS = 14
"""A figure of more bodies than this is drawn without letters."""

SHORTEST_LINE = 3.0
"""Shorter lines between two joints are not drawn [pt]."""

PULLEY = 8.0
"""Radius of a pulley that only guides a cord around a corner [pt]."""


def figure(setting: Setting) -> tuple[Mark, ...]:
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
        marks += [*masses(setting)]
    marks = [*clear_letters([*marks, *loads(setting)])]
    if marks:
        marks += _gravity(setting, marks)
    return tuple(marks)


def solid_marks(setting: Setting, body: str | None = None) -> Iterator[Mark]:
    """Yield the solids, those of the ground and those behind first."""
    shown = [solid for solid in setting.solids if body is None or solid.body == body]
    ground = setting.mechanism.ground

    def order(solid: Solid) -> tuple[bool, bool, float]:
        depth = setting.camera.depth(solid.ends.mean(axis=0))
        return solid.body != ground, solid.kind == "ball", depth

    for solid in sorted(shown, key=order):
        yield from outline(solid, setting.camera)


def _links(setting: Setting) -> Iterator[Mark]:
    """Lines along bodies without solids, from joint to joint, and along extended slides."""
    mechanism, camera = setting.mechanism, setting.camera
    shown = {solid.body for solid in setting.solids} | {mechanism.ground}
    lines = [force for force in mechanism.forces if isinstance(force, LineLoad)]
    sprung = {body for line in lines for body in line.bodies}
    for joint in mechanism.joints:
        bare = joint.parent not in shown
        if bare:
            yield from _line(camera.at(setting.point(joint.parent)), camera.at(setting.seat(joint)))
        if not isinstance(joint, Prismatic) or loads_in(mechanism.forces, joint.name):
            continue
        if bare and joint.child not in sprung:
            yield from _line(camera.at(setting.seat(joint)), camera.at(setting.point(joint.child)))

    yield from _cords(setting)


def _line(a: Point, b: Point) -> Iterator[Mark]:
    if math.hypot(*(b - a)) > SHORTEST_LINE:
        yield Stroke(np.array([a, b]), "cable")


def _cords(setting: Setting) -> Iterator[Mark]:
    """The stretches of cords from where they leave one thing to where they touch the next."""
    mechanism, camera = setting.mechanism, setting.camera
    cords = [element for element in mechanism.elements if isinstance(element, Strung)]
    if not cords:
        return
    names = {name for cord in cords for name in cord.forces}
    every = setting.reference.guide_actions(setting.q, setting.v, setting.t)
    ends = [camera.at(end.point) for end in every if end.name in names]
    for start, end in zip(ends[::2], ends[1::2], strict=True):
        yield from _line(start, end)
    for cord in cords:
        for wheel in cord.over:
            if is_zero(wheel.radius):
                yield Circle(camera.at(setting.point(wheel.body, wheel.center)), PULLEY / 2, "pin")


def _joints(setting: Setting) -> Iterator[Mark]:
    mechanism, camera = setting.mechanism, setting.camera
    shown = {solid.body for solid in setting.solids} | {mechanism.ground}
    wheels = {solid.body for solid in setting.solids if solid.kind == "cylinder"}
    for joint in mechanism.joints:
        at = camera.at(setting.point(joint.child))
        if isinstance(joint, Revolute) and not camera.flat:
            yield Circle(at, 3.2, "pin")
        elif isinstance(joint, Revolute):
            if joint.child not in wheels or joint.parent in shown:
                yield from pin(at)
        elif isinstance(joint, (Spherical, Universal)):
            yield Circle(at, 4.2, "pin")
            yield Circle(at, 1.4, "tip")
    pins = [element for element in mechanism.elements if isinstance(element, Loop)]
    for loop in (*mechanism.loops, *pins):
        yield from _loop(setting, loop)


def _loop(setting: Setting, loop: Loop) -> Iterator[Mark]:
    """The pin that closes a loop, on the ground if that holds it; two and a line for a distance."""
    a = setting.camera.at(setting.point(loop.body_a, loop.frame_a.xyz))
    b = setting.camera.at(setting.point(loop.body_b, loop.frame_b.xyz))
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
    tip = tail + 36.0 * unit(down)
    yield from arrow(tail, tip, "thin")
    name = (names[0] or "g").lstrip("-")
    yield label((tail + tip) / 2, name, np.array([1.0, 0.0]), 5.0, "name")
