"""How bodies and joints look: their shapes in their own frames, and a mark at each joint."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import TypeVar, final

import numpy as np

from mecanique.derivation.mechanics.forces import AppliedWrench
from mecanique.figure.solids import list_branch
from mecanique.model.bodies.visuals import Cylinder, Mesh, Visual, measure
from mecanique.model.constraint_base import Strung, list_cord_runs
from mecanique.model.expression import Scalar, Vector
from mecanique.model.force_base import End, LineLoad, Point, loads_in
from mecanique.model.joint_base import Single
from mecanique.model.joints import Planar, Prismatic, Revolute, Spherical, Universal
from mecanique.model.mechanism import Mechanism
from mecanique.model.placement import pose_at
from mecanique.model.teeth import visuals_of
from mecanique.motion.analysis.forces import Action
from mecanique.viewing.scene.scene import (
    GREY,
    ArrowUnit,
    JointMark,
    LineKind,
    SceneBody,
    SceneShape,
)
from mecanique.wording import to_title


def bodies_of(mechanism: Mechanism) -> tuple[SceneBody, ...]:
    """Return a mechanism's bodies as they are drawn."""
    visuals = visuals_of(mechanism)
    forms = {}
    for body in mechanism.bodies:
        forms[body.name] = {s.visuals[0]: s.form for s in body.shapes if s.visuals}
    shapes = {b: tuple(_shapes(mechanism, listed, forms[b])) for b, listed in visuals.items()}
    missing = any(
        isinstance(visual.geometry, Mesh) and visual.geometry.path is None
        for listed in visuals.values()
        for visual in listed
    )
    if mechanism.origin is not None and (missing or not any(shapes.values())):
        rods = {
            name: tuple(_join(mechanism, name))
            for name, shapes_of in shapes.items()
            if not shapes_of
        }
        shapes |= rods
    return tuple(SceneBody(body.name, shapes[body.name]) for body in mechanism.bodies)


def title_of(mechanism: Mechanism) -> str:
    """Return the title of a mechanism's page: the name in its file, or the catalogue's in words."""
    return to_title(mechanism.name) if mechanism.origin is None else mechanism.name


def _join(mechanism: Mechanism, name: str) -> Iterator[SceneShape]:
    """A link whose mesh is not there: rods from its joint to the next ones, or to its center."""
    body = mechanism.body(name)
    mass = float(mechanism.evaluate(body.mass))
    joints = [joint for joint in mechanism.joints if joint.parent == name]
    ends = [np.array(mechanism.evaluate_all(joint.origin.xyz)) for joint in joints]
    ends = ends or [np.array(mechanism.evaluate_all(body.center))]
    lengths = [float(np.linalg.norm(end)) for end in ends]
    whole = sum(lengths)
    for end, length in zip(ends, lengths, strict=True):
        if length < 1e-6:
            continue
        filled = math.sqrt(mass / (math.pi * _DENSITY * whole))
        radius = min(max(filled, _THINNEST * length), _THICKEST * length)
        axis = end / length
        # the least of its components is farthest from being parallel
        across = np.cross(np.eye(3)[int(np.argmin(np.abs(axis)))], axis)
        across /= np.linalg.norm(across)
        pose = pose_at(end / 2, np.column_stack([across, np.cross(axis, across), axis]))
        yield SceneShape("cylinder", (radius, length), pose, GREY)


_DENSITY = 1000.0
"""Of a link that is drawn as a rod [kg/m³]: arms are hollow."""

_THINNEST, _THICKEST = 0.03, 0.25
"""Radii of such rods, in terms of their lengths."""


def marks_of(mechanism: Mechanism, poses: np.ndarray) -> tuple[JointMark, ...]:
    """Return a mark for each joint, at the origin of its child, for each pin that closes a loop.

    Springs, dampers and rods that end on the bare ground stand on a foot; mean poses (nb, 4, 4).
    """
    marks = []
    for joint in mechanism.joints:
        axis = joint.axis if isinstance(joint, (Single, Planar)) else (0.0, 0.0, 0.0)
        kind = type(joint).__name__.lower()
        foot: tuple[float, ...] = ()
        if isinstance(joint, Revolute | Universal | Spherical):
            foot = _foot(mechanism, End(joint.parent, joint.origin.xyz), joint.child, poses)
        marks.append(JointMark(joint.name, kind, joint.child, (0.0, 0.0, 0.0), axis, foot))
    for loop in mechanism.loops:
        if loop.kind in ("pin", "hinge", "ball"):
            place = mechanism.matrix(loop.frame_b)
            axis = tuple(place[:3, 2]) if loop.kind != "ball" else (0.0, 0.0, 0.0)
            kind = "spherical" if loop.kind == "ball" else "revolute"
            foot = _foot(mechanism, End(loop.body_a, loop.frame_a.xyz), loop.body_b, poses)
            marks.append(JointMark(loop.name, kind, loop.body_b, tuple(place[:3, 3]), axis, foot))
    at = {body.name: pose for body, pose in zip(mechanism.bodies, poses, strict=True)}
    for span in spans_of(mechanism):
        a, b = (at[e.body] @ (*mechanism.evaluate_all(e.point), 1.0) for e in span.ends)
        for end, seat, other in ((span.ends[0], a, b), (span.ends[1], b, a)):
            away, length = (seat - other)[:3], float(np.linalg.norm(seat - other))
            if _is_bare(mechanism, end.body) and span.kind != "pull" and length > _LEVEL:
                foot = (*seat[:3], *(away / length))
                name = f"foot of {span.name}"
                marks.append(JointMark(name, "fixed", end.body, tuple(seat[:3]), foot=foot))
    return tuple(marks)


def _is_bare(mechanism: Mechanism, body: str) -> bool:
    return body == mechanism.ground and not mechanism.body(body).visuals


def _foot(mechanism: Mechanism, end: End, child: str, poses: np.ndarray) -> tuple[float, ...]:
    """Where a pin on the bare ground is, and its foot's direction: up where bodies hang from it."""
    if not _is_bare(mechanism, end.body):
        return ()
    carried = list_branch(mechanism, child)
    numbered = [(k, body) for k, body in enumerate(mechanism.bodies) if body.name in carried]
    centers = [(poses[k] @ (*mechanism.evaluate_all(body.center), 1.0))[2] for k, body in numbered]
    seat = mechanism.evaluate_all(end.point)
    hangs = sum(centers) < len(centers) * seat[2] - _LEVEL
    return (*seat, 0.0, 0.0, 1.0 if hangs else -1.0)


_LEVEL = 1e-9
"""Bodies that are less below a pin do not hang from it [m]."""


def _shapes(
    mechanism: Mechanism, visuals: Sequence[Visual], forms: Mapping[Visual, str]
) -> Iterator[SceneShape]:
    for visual in visuals:
        kind, sizes = measure(visual.geometry)
        path = visual.geometry.path if isinstance(visual.geometry, Mesh) else None
        if kind == "mesh" and path is None:
            continue  # lint reports a mesh that was not found; there is nothing to draw
        rgba = visual.rgba or (None if path else GREY)
        pose = mechanism.matrix(visual.placement)
        form = forms.get(visual, "")
        yield SceneShape(kind, tuple(mechanism.evaluate_all(sizes)), pose, rgba, path, form)


_SLENDER = 4
"""Cylinders longer than so many radii trace their end, others their center."""


@final
@dataclass(frozen=True)
class DrawnSpan:
    """Something drawn between two points."""

    name: str
    kind: LineKind
    ends: tuple[End, End]


def spans_of(mechanism: Mechanism) -> Iterator[DrawnSpan]:
    """Yield springs, dampers, attractions, massless rods, and slides that no body shows."""
    sprung = {
        joint.name for joint in mechanism.joints if loads_in(mechanism.forces, joint.name, "spring")
    }
    kinds: dict[str, LineKind] = {"spring": "spring", "damper": "damper", "load": "pull"}
    forces = [force for force in mechanism.forces if isinstance(force, LineLoad)]
    for force in forces:
        yield DrawnSpan(force.name, kinds[force.kind], force.ends)
    for loop in mechanism.loops:
        if loop.kind == "distance":
            a, b = End(loop.body_a, loop.frame_a.xyz), End(loop.body_b, loop.frame_b.xyz)
            yield DrawnSpan(loop.name, "rod", (a, b))
    runs = {name for element in mechanism.switching for name in list_cord_runs(element)}
    cords = [guide for guide in mechanism.elements if isinstance(guide, Strung)]
    held = {stop.body for cord in cords for stop in cord.stops}
    held |= {body for force in forces for body in force.bodies}
    for joint in mechanism.joints:
        # a slide without a visible body is shown by the cable or the spring that spans it, or by
        # the line along which a force acts
        moves = joint.parent != mechanism.ground and joint.child not in held
        if isinstance(joint, Prismatic) and (joint.name in sprung | runs or moves):
            a, b = End(joint.parent, joint.origin.xyz), End(joint.child, (0.0, 0.0, 0.0))
            kind: LineKind = "spring" if joint.name in sprung else "rod"
            yield DrawnSpan(f"joint {joint.name}", kind, (a, b))


def tips_of(mechanism: Mechanism) -> Iterator[End]:
    """Yield the farthest point from the joint on each last body of a chain."""
    parents = {joint.parent for joint in mechanism.joints}
    for body in mechanism.bodies:
        if body.name in parents or body.name == mechanism.ground or not body.visuals:
            continue
        tips = [tip for visual in body.visuals for tip in _tips(mechanism, visual)]
        yield End(body.name, max(tips, key=lambda tip: _distance(mechanism, tip)))


def _distance(mechanism: Mechanism, tip: Vector) -> float:
    return round(float(np.linalg.norm(mechanism.evaluate_all(tip))), 9)


def _tips(mechanism: Mechanism, visual: Visual) -> Iterator[Point]:
    center = visual.placement.xyz
    axis = [row[2] for row in visual.placement.rotation]
    half: Scalar = 0.0
    if isinstance(visual.geometry, Cylinder):
        length, radius = visual.geometry.length, visual.geometry.radius
        if mechanism.evaluate(length) > _SLENDER * mechanism.evaluate(radius):
            half = length / 2
    for side in (half, -half):
        x, y, z = (c + side * e for c, e in zip(center, axis, strict=True))
        yield x, y, z


AnyAction = TypeVar("AnyAction", Action, AppliedWrench)
"""A force on a body along a motion, or the same on a tape."""


def name_arrows(actions: Iterable[AnyAction]) -> Iterator[tuple[str, AnyAction, ArrowUnit]]:
    """Yield the name of each arrow, its action and the unit of what it shows, force or moment."""
    used: dict[str, int] = {}
    for action in actions:
        plain = {"weight": f"weight of {action.body}", "inertia": f"inertia of {action.body}"}
        base = plain.get(action.kind, f"{action.name} on {action.body}")
        parts: tuple[tuple[ArrowUnit, str], ...] = (("N", ""), ("N·m", " moment"))
        for unit, what in parts:
            name = base + what
            used[name] = used.get(name, 0) + 1
            yield (name if used[name] == 1 else f"{name} ({used[name]})"), action, unit


def group_work(
    mechanism: Mechanism, actions: Iterable[AnyAction]
) -> list[tuple[str, list[AnyAction]]]:
    """Return the actions of each force, with its name in the ledger."""
    held = {part.name for part in (*mechanism.joints, *mechanism.loops, *mechanism.contacts)}
    groups: dict[tuple[str, str], list[AnyAction]] = {}
    for action in actions:
        groups.setdefault((action.kind, action.name), []).append(action)
    named = []
    for (kind, name), group in groups.items():
        titles = {
            "weight": f"weight of {name}",
            "inertia": f"inertia of {name}",
            "reaction": f"reaction at {name}" if name in held else name,
        }
        named.append((titles.get(kind, name), group))
    return named
