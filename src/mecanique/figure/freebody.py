"""A body cut free: every force on it as an arrow with its letter, inertia forces dashed.

In a plane, reactions are drawn by their components, in the sense in which the equations count them
positive: along the axes on the child of a joint, against them on its parent, as R_pin_n and R_pin_t
of a pendulum. Known forces point where they act.
"""

from __future__ import annotations

import math
import re
from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from typing import final

import numpy as np

from mecanique.derivation.scalars.evaluation import Evaluation
from mecanique.derivation.symbolic.cutting import axes_of, normal_of
from mecanique.derivation.symbolic.kinematics import Kinematics
from mecanique.derivation.symbolic.symbols import Algebra
from mecanique.derivation.symbolic.vectors import lift
from mecanique.errors import MecaniqueError
from mecanique.figure.coordinates import coordinates, lengths
from mecanique.figure.mechanism import solid_marks
from mecanique.figure.paper.lettering import clear_letters
from mecanique.figure.paper.marks import (
    Circle,
    Mark,
    Point,
    Stroke,
    Words,
    across,
    arc,
    arrow,
    bounds,
    directions,
    label,
    named_arrow,
    unit,
)
from mecanique.figure.setting import Setting
from mecanique.figure.solids import Floats
from mecanique.model import Loop, Revolute
from mecanique.model.constraint_base import PressingContact
from mecanique.model.force_base import BodyLoad, JointLoad
from mecanique.motion.analysis.forces import TOGETHER, Action, Actions
from mecanique.motion.record.loops import begin_on_loops
from mecanique.reference import Reference

LONGEST, SHORTEST, LETTERED = 110.0, 18.0, 62.0
"""Lengths of the largest and of the smallest arrow, and of all where there are no numbers [pt]."""

_UNKNOWN = "S, C: reactions and guides together; each by itself is undetermined"
"""Note below a body on which forces act that the mechanism does not describe."""

NEGLIGIBLE = 1e-6
"""Forces smaller than this fraction of the largest are not drawn."""

NUDGE = 1e-3
"""How far a mechanism is moved, and time goes on, to see which forces can act [rad, m, s]."""

POSSIBLE = 1e-5
"""Forces smaller than this fraction of the largest in a general motion are none."""

BESIDE, STAGGER, SAME = 14.0, 16.0, 4.0
"""Distance between arrows along one line, how much longer the next is, and of tails that count as
one place [pt]."""

EXTENT, ENLARGED = (200.0, 120.0), 3.0
"""The largest extent of a body cut free [pt], and how much larger than in its figure it may be."""

OFF = 6.0
"""Distance from which on a point is off a body and a line leads to it [pt]."""

AXIS, AWAY = 30.0, 34.0
"""Length of the arrows of the axes, and their distance from the figure [pt]."""


@final
@dataclass(frozen=True)
class _Axis:
    """A direction along which forces are resolved: its letter, and the sense of reactions."""

    letter: str
    along: Floats
    sign: int = 1


@final
@dataclass(frozen=True)
class _Arrow:
    """A force to be drawn: where, which way on paper, its size, its letter, how far aside."""

    at: Point
    along: Point
    size: float
    symbol: str
    style: str
    seen: float = 1.0
    aside: float = 0.0


def cut_free(
    setting: Setting, body: str, *, resultants: bool = False, numbers: bool = False
) -> tuple[Mark, ...]:
    """Return the marks of a body's free-body diagram."""
    setting = fit_body(setting, body)
    actions = [action for action in acting(setting) if action.body == body]
    guides = _measure_guides(setting)
    possible, later = (actions, guides) if numbers else _perturb(setting, actions)
    force = max((float(np.linalg.norm(action.force)) for action in actions), default=0.0)
    moment = max((float(np.linalg.norm(action.moment)) for action in actions), default=0.0)
    axes, turn = list[_Axis](), 0.0
    if setting.camera.flat and not resultants:
        axes, turn = _axes(setting, body)
    marks: list[Mark] = [*_arms(setting, body, actions), *solid_marks(setting, body)]
    arrows: list[_Arrow] = []
    # without numbers a letter stands for every value, zero too: what can act is drawn
    strongest = max((float(np.linalg.norm(action.force)) for action in possible), default=0.0)
    for action, perturbed in zip(actions, possible, strict=True):
        parts = [
            component
            for component in _resolve(setting, action, axes, guides)
            if abs(component.size) > NEGLIGIBLE * force
        ]
        drawn = {component.symbol for component in parts}
        for component in _resolve(setting, perturbed, axes, later):
            if component.symbol not in drawn and abs(component.size) > POSSIBLE * strongest:
                parts.append(component)
        for component in parts:
            arrows.append(_step_aside(component, arrows))
    for component in arrows:
        marks += _draw(component, force, numbers)
    turning = max((float(np.linalg.norm(action.moment)) for action in possible), default=0.0)
    bent = Counter[tuple[float, ...]]()  # arcs about each point, the next of them wider
    for action, perturbed in zip(actions, possible, strict=True):
        acts = np.linalg.norm(action.moment) > max(NEGLIGIBLE * moment, 1e-9 * force)
        shown = action if acts else perturbed
        if np.linalg.norm(shown.moment) > max(POSSIBLE * turning, 1e-9 * strongest) or acts:
            place = tuple(np.round(setting.camera.at(shown.origin[0])).tolist())
            marks += _moment(setting, shown, numbers, turn, 30.0 + 12.0 * bent[place])
            bent[place] += shown.kind != "inertia"
    spots = {tuple(np.round(setting.camera.at(action.origin[0]), 1)) for action in actions}
    marks += [Circle(np.array(spot), 2.4, "tip") for spot in sorted(spots)]
    if not marks:
        return ()
    if axes:
        alone = replace(setting, solids=tuple(s for s in setting.solids if s.body == body))
        marks += [*lengths(alone), *coordinates(alone, body)]
        marks += _cross(marks, setting, axes)
    marks = [*clear_letters(marks, crowded=True)]
    left, top, right, bottom = bounds(marks)
    middle = (left + right) / 2
    marks.append(
        Words(np.array([middle, top - 14.0]), ((body.replace("_", " "), "upright"),), "name")
    )
    if any(action.name == TOGETHER for action in actions):
        marks.append(Words(np.array([middle, bottom + 22.0]), ((_UNKNOWN, "upright"),), "name"))
    return tuple(marks)


def fit_body(setting: Setting, body: str) -> Setting:
    """Bring a body to a size at which its forces and their letters stand beside it."""
    own = [solid.corners for solid in setting.solids if solid.body == body]
    if not own:
        return setting
    wide, high = np.ptp(setting.camera.at(np.concatenate(own)), axis=0)
    factor = min(EXTENT[0] / max(wide, 1.0), EXTENT[1] / max(high, 1.0), ENLARGED)
    return replace(setting, camera=replace(setting.camera, scale=setting.camera.scale * factor))


def _arms(setting: Setting, body: str, actions: Sequence[Action]) -> Iterator[Mark]:
    """Lines from a body to the points off it where forces act, such as a particle's joint."""
    solids = [action for action in setting.solids if action.body == body]
    present = [action for action in actions if np.any(action.force) or np.any(action.moment)]
    spots = {tuple(setting.camera.at(action.origin[0]).tolist()) for action in present}
    for spot in sorted(spots) if solids else ():
        gaps = []
        for solid in solids:
            paper = setting.camera.at(solid.corners)
            beyond = np.maximum(paper.min(axis=0) - spot, np.array(spot) - paper.max(axis=0))
            gaps.append(float(np.hypot(*np.maximum(beyond, 0.0))))
        if min(gaps) > OFF:
            middle = setting.camera.at(solids[int(np.argmin(gaps))].ends.mean(axis=0))
            yield Stroke(np.array([spot, middle]), "dashed")


def acting(setting: Setting) -> Iterator[Action]:
    """Yield every force on every body, inertia forces too."""
    t, q, v = np.array([setting.t]), setting.q[None], setting.v[None]
    a = np.asarray(setting.reference.acceleration(q, v, t))
    yield from Actions(setting.mechanism, setting.reference).all(t, q, v, a)


def _measure_guides(setting: Setting) -> dict[str, float]:
    """The forces of elements that guide, each by the direction in which it counts positive."""
    values = setting.reference.guide_forces(setting.q, setting.v, setting.t)
    return {name: float(value) for name, value in values.items() if abs(float(value)) > 0}


def _perturb(setting: Setting, actions: Sequence[Action]) -> tuple[list[Action], dict[str, float]]:
    """The same forces a little later, in a general motion, so that accidental zeros vanish."""
    mechanism, random = setting.mechanism, np.random.default_rng(0)
    reference = setting.reference
    idle = {s: replace(s, signal=1.0) for s in mechanism.inputs if s.signal == 0.0}
    if idle:  # such a drive is there to be given a value
        given = tuple(idle.get(signal, signal) for signal in mechanism.inputs)
        mechanism = replace(mechanism, inputs=given)
        reference = Reference(mechanism)
    q, v, t = setting.q, setting.v + random.uniform(0.5, 1.0, mechanism.nv), setting.t + NUDGE
    if mechanism.nq == mechanism.nv:
        q = q + NUDGE * random.uniform(0.5, 1.0, mechanism.nq)
    try:
        if mechanism.constrained:
            closed = begin_on_loops(reference, q.tolist(), v.tolist(), t).state
            q, v = closed[: mechanism.nq], closed[mechanism.nq :]
        moved = replace(setting, mechanism=mechanism, reference=reference, q=q, v=v, t=t)
        stirred = [*acting(moved)]
    except MecaniqueError:  # there is no motion near, as in a singular position
        return [*actions], {}
    later = {(action.kind, action.name, action.body, action.other): action for action in stirred}
    kept = []
    for action in actions:
        moved_on = later.get((action.kind, action.name, action.body, action.other), action)
        kept.append(replace(moved_on, origin=action.origin))
    return kept, _measure_guides(moved)


def _axes(setting: Setting, body: str) -> tuple[list[_Axis], float]:
    """The axes of the body's equations in the picture, and 1 if moments count counterclockwise."""
    mechanism, toward = setting.mechanism, setting.camera.toward
    labels, signs, rows, normals = [*"xyz"], (1, 1, 1), np.eye(3), np.eye(3)
    with suppress(MecaniqueError):  # such as of a hinge on what turns by a quaternion
        kinematics = Kinematics(Algebra(mechanism))
        normal = normal_of(kinematics)
        if normal is not None:
            chosen = axes_of(kinematics, body, normal)
            values = dict(zip(mechanism.coordinates.names, setting.q.tolist(), strict=True))
            ring = kinematics.algebra.ring
            evaluate = Evaluation(ring, {**mechanism.values, **values, "t": setting.t})
            labels, signs = [*chosen.labels], chosen.signs
            directions = [lift(ring, row) for row in (*chosen.rows, *chosen.turns)]
            rows, normals = np.split(np.array([[*map(evaluate, row)] for row in directions]), 2)
    axes = [_Axis(*axis) for axis in zip(labels, rows, signs, strict=True)]
    flat = [axis for axis in axes if abs(axis.along @ toward) < NEGLIGIBLE]
    return flat, math.copysign(1.0, max((n @ toward for n in normals), key=abs))


def _resolve(
    setting: Setting, action: Action, axes: Sequence[_Axis], guides: Mapping[str, float]
) -> Iterator[_Arrow]:
    """The arrows of a force: of a reaction and of inertia by components, of any other as it is."""
    at, force = setting.camera.at(action.origin[0]), action.force[0]
    style = "inertia" if action.kind == "inertia" else "force"
    symbol = _symbol(setting, action, moment=False)
    plane = _plane_of(setting, action) if axes else []
    if plane:  # the multipliers of a contact count along its plane
        axes, symbol = plane, f"lambda_{action.name}"
    guided = bool(axes) and action.name in guides
    if not axes or action.kind not in ("reaction", "inertia") or action.name == TOGETHER or guided:
        size = float(np.linalg.norm(force))
        if not size:
            return
        if guided:  # in the sense in which it counts positive
            size = math.copysign(size, guides[action.name])
            symbol = _name_world(setting, action, symbol, force / size)
        paper = setting.camera.at(force) / setting.camera.scale * math.copysign(1.0, size)
        seen = float(np.hypot(*paper)) / abs(size)
        if seen > 0.05:
            yield _Arrow(at=at, along=unit(paper), size=size, symbol=symbol, style=style, seen=seen)
        return
    for axis in axes:
        sense = axis.along * axis.sign * _sense(setting, action)
        if action.kind == "inertia":
            sense, symbol = -axis.along, symbol.removeprefix("-")
        size = float(force @ sense)
        yield _Arrow(at, unit(setting.camera.at(sense)), size, f"{symbol}_{axis.letter}", style)


def _name_world(setting: Setting, action: Action, symbol: str, way: Floats) -> str:
    """The letter of an element's force, by the axis of the world that it is along, if any."""
    for element in setting.mechanism.elements:
        if isinstance(element, Loop) and action.name in element.forces and symbol[-1] in "xyz":
            along = way if element.body_b == action.body else -way
            letters = [x for x, part in zip("xyz", along, strict=True) if part > 1 - NEGLIGIBLE]
            return symbol[:-1] + (letters or symbol[-1:])[0]
    return symbol


def _plane_of(setting: Setting, action: Action) -> list[_Axis]:
    """The axes of the plane that a contact's force counts along, those that lie in the picture."""
    mechanism = setting.mechanism
    for contact in mechanism.contacts:
        if contact.name == action.name and isinstance(contact, PressingContact):
            frame = setting.frame(contact.on, contact.plane)
            ways = zip(("x", "y", "normal"), frame[:3, :3].T, strict=True)
            axes = [_Axis(letter, way) for letter, way in ways] if not contact.curved else []
            return [axis for axis in axes if abs(axis.along @ setting.camera.toward) < NEGLIGIBLE]
    return []


def _sense(setting: Setting, action: Action) -> int:
    """1 where the force counts positive along the axes: on a joint's child; −1 on its parent."""
    mechanism = setting.mechanism
    held = {joint.name: joint.child for joint in mechanism.joints}
    held |= {loop.name: loop.body_b for loop in mechanism.loops}
    held |= {contact.name: contact.body for contact in mechanism.contacts}
    return 1 if held.get(action.name, action.body) == action.body else -1


def _step_aside(candidate: _Arrow, drawn: Sequence[_Arrow]) -> _Arrow:
    """An arrow beside those that it would lie on."""
    same = sum(_lies_on(candidate, placed) for placed in drawn)
    return replace(candidate, aside=BESIDE * ((same + 1) // 2) * (1 if same % 2 else -1))


def _lies_on(candidate: _Arrow, placed: _Arrow) -> bool:
    """Whether two arrows share a stretch of one line."""
    offset, turn = candidate.at - placed.at, float(candidate.along @ placed.along)
    start = float(offset @ placed.along)
    low, high = sorted((start, start + LETTERED * turn))
    shared = min(high, LETTERED) - max(low, 0.0)
    return abs(turn) > 0.99 and abs(float(offset @ across(placed.along))) < SAME < shared


def _draw(drawn: _Arrow, largest: float, numbers: bool) -> Iterator[Mark]:
    # tips of arrows beside each other are apart, so that each letter has one near it
    rank = 2 * abs(drawn.aside) / BESIDE - (drawn.aside > 0)
    length = LETTERED + STAGGER * rank
    if numbers:
        length = SHORTEST + (LONGEST - SHORTEST) * min(abs(drawn.size) / largest, 1.0)
    tail = drawn.at + drawn.aside * across(drawn.along)
    tip = tail + length * drawn.seen * drawn.along
    yield from arrow(tail, tip, drawn.style)
    yield _label(tip, drawn.symbol, drawn.size if numbers else None, "N", drawn.along, drawn.style)


def _moment(
    setting: Setting, action: Action, numbers: bool, counted: float, radius: float
) -> Iterator[Mark]:
    """A bent arrow, in the sense in which the equations count the moment, or as it acts."""
    # A couple of inertia is drawn against the sense in which moments count, as forces of inertia
    # against the axes, so that its letter has no sign
    at, size = setting.camera.at(action.origin[0]), float(np.linalg.norm(action.moment))
    along = float(action.moment[0] @ setting.camera.toward)
    if abs(along) < 0.05 * size:
        return
    sense, style = math.copysign(1.0, along), "inertia" if action.kind == "inertia" else "force"
    symbol = _symbol(setting, action, moment=True)
    if counted and action.kind in ("reaction", "inertia"):
        reaction = action.kind == "reaction"
        sense = _find_turn(setting, action) * _sense(setting, action) if reaction else -counted
        size, symbol = along * sense, symbol.removeprefix("-")
    way, radius = sense, 24.0 if style == "inertia" else radius
    turn = -way * np.linspace(0.0, 1.3 * math.pi, 40) - 0.4 * way
    yield from arc(at + radius * directions(turn), style)
    side = np.array([0.7, 0.7])
    yield _label(at + radius * side, symbol, size if numbers else None, "N·m", side, style)


def _find_turn(setting: Setting, action: Action) -> float:
    """1 if moments in a joint count positive counterclockwise on paper, −1 if clockwise."""
    for joint in setting.mechanism.joints:
        if joint.name == action.name and isinstance(joint, Revolute):
            return math.copysign(1.0, float(setting.axis(joint) @ setting.camera.toward))
    return 1.0


def _cross(marks: Sequence[Mark], setting: Setting, axes: Sequence[_Axis]) -> Iterator[Mark]:
    """The axes of the components, beside the body."""
    left, _, _, bottom = bounds(marks)
    corner = np.array([left - AWAY, bottom])
    for axis in axes:
        along = unit(setting.camera.at(axis.along))
        yield from named_arrow(corner, corner + AXIS * along, axis.letter, "thin")


def _label(
    at: Point, symbol: str, size: float | None, unit_: str, along: Point, style: str
) -> Words:
    words = label(at, symbol, along, 8.0, f"{style}-letter")
    parts = tuple(
        (text.replace("_", ",") if how == "below" else text, how) for text, how in words.parts
    )
    if size is not None:
        parts = (*parts, (f" = {size:.3g} {unit_}".replace("-", "−"), "upright"))
    whole = Words(words.at, parts, words.style)
    # the near side of the longer label stays where the symbol's was
    shift = np.array([along[0] * (whole.width - words.width) / 2, 0.0])
    return replace(whole, at=words.at + shift)


def _symbol(setting: Setting, action: Action, *, moment: bool) -> str:
    mechanism = setting.mechanism
    mass = setting.name(mechanism.body(action.body).mass)
    if "+" in mass or "-" in mass:
        mass = f"({mass})"
    if action.kind == "weight":
        return f"{mass}*g" if mass else f"G_{action.body}"
    if action.kind == "inertia":
        printed = map(setting.letter, mechanism.coordinates)
        taken = {p.symbol for p in mechanism.parameters}.union(printed)
        rate = "epsilon" if "alpha" in taken else "alpha"
        acceleration = f"a_{action.body}" if "a" in taken else "a"
        return f"-I*{rate}" if moment else f"-{mass or f'm_{action.body}'}*{acceleration}"
    if action.name == TOGETHER:
        return "C" if moment else "S"
    if any(action.name in element.tensions for element in mechanism.elements):
        return f"T_{action.name}"
    if action.kind == "load":
        stated = _find_letter(setting, action.name)
        if stated:
            return stated
    stem = re.sub(r"[\W_]+", "_", action.name).strip("_") or "force"
    if action.kind == "reaction" and action.name in (loop.name for loop in mechanism.loops):
        return f"lambda_{stem}"
    force = "R" if action.kind == "reaction" else "F"
    return f"{'M' if moment else force}_{stem}"


def _find_letter(setting: Setting, name: str) -> str:
    """The letter of a load, where it is stated by a single one."""
    (force,) = (force for force in setting.mechanism.forces if force.name == name)
    if not isinstance(force, (BodyLoad, JointLoad)):
        return ""
    given = force.coefficient
    parts = given if isinstance(given, tuple) else (given,)
    letters = [setting.name(part).lstrip("-") for part in parts if not isinstance(part, float)]
    return letters[0] if len(letters) == 1 and letters[0].isidentifier() else ""
