"""A mechanism as a textbook draws it: bodies, joints, ground, springs, loads, coordinates."""

from __future__ import annotations

import math
import re
from collections.abc import Iterator, Sequence

import numpy as np

from mecanique.figure.camera import Floats
from mecanique.figure.coordinates import coordinates
from mecanique.figure.measures import lengths, masses, slopes
from mecanique.figure.paper.arrows import arc, arrow
from mecanique.figure.paper.lettering import clear_letters
from mecanique.figure.paper.marks import Circle, Mark, Point, Stroke, across, bounds, label, unit
from mecanique.figure.paper.symbols import dashpot, hatch, pin, spiral, spring
from mecanique.figure.setting import Setting, is_zero
from mecanique.figure.solids import Solid, outline, unit3
from mecanique.figure.supports import nuts, stands_on_columns, supports, wall
from mecanique.model.constraint_base import Strung
from mecanique.model.constraints.loops import Loop
from mecanique.model.expression import DISTANCE, Scalar, coordinate, evaluate, plain, symbols_in
from mecanique.model.force_base import BodyLoad, End, JointLoad, LineLoad, WrenchOnBody, loads_in
from mecanique.model.forces import CentralForce
from mecanique.model.joints import Prismatic, Revolute, Spherical, Universal
from mecanique.motion.analysis.forces import Actions

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
    for force in links:
        if isinstance(force, CentralForce):
            yield from _attract(setting, force, a, b)
    links = [force for force in links if not isinstance(force, CentralForce)]
    if not links:
        return
    ground = [end.body == setting.mechanism.ground for end in first.ends]
    # a spring ends at the surface of the body it holds
    a = _surface(setting, first.body_a, a, along)
    b = _surface(setting, first.body_b, b, -along)
    if ground[0]:
        yield from wall(a, _level(along))
    if ground[1]:
        yield from wall(b, _level(-along))
    yield from _bundle(setting, a, b, links)


def _attract(setting: Setting, force: CentralForce, a: Point, b: Point) -> Iterator[Mark]:
    """A central force on each body that can move, as it points at this instant."""
    reach = setting.point(force.body_b, force.point_b) - setting.point(force.body_a, force.point_a)
    slope = plain(force.potential).diff(coordinate(DISTANCE))
    values = {**setting.mechanism.values, DISTANCE: float(np.linalg.norm(reach))}
    pulls = math.copysign(1.0, evaluate(slope, values))
    for body, at, along in ((force.body_a, a, unit(b - a)), (force.body_b, b, unit(a - b))):
        if body != setting.mechanism.ground:
            tail = _beyond(setting, body, at, pulls * along)
            tip = tail + ARROW * pulls * along
            yield from arrow(tail, tip, "force")
            yield label(tip, force.name, pulls * along, 5.0, "force-letter")


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
        if joint.parent == setting.mechanism.ground and joint.parent not in solids:
            yield from wall(a, along)
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
