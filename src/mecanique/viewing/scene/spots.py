"""Points of bodies that the picture follows: ends of springs, dampers and rods, tips that trace."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import final

import numpy as np

from mecanique.model.bodies.visuals import Cylinder, Visual
from mecanique.model.constraints.cords import Belt, Cord
from mecanique.model.expression import Scalar, Vector
from mecanique.model.force_base import LineLoad, loads_in
from mecanique.model.joints import Prismatic
from mecanique.model.mechanism import Mechanism
from mecanique.viewing.scene.scene import LineKind

_SLENDER = 4
"""Cylinders longer than so many radii trace their end, others their center."""


@final
@dataclass(frozen=True)
class Spot:
    """A point of a body.

    Args:
        body: its name.
        point: shape (3,), in the body's frame; numbers or expressions in the parameters [m].
    """

    body: str
    point: Vector


@final
@dataclass(frozen=True)
class Span:
    """Something drawn between two points.

    Args:
        name: unique in the scene.
        kind: how it is drawn.
        ends: the points.
    """

    name: str
    kind: LineKind
    ends: tuple[Spot, Spot]


def spans_of(mechanism: Mechanism) -> Iterator[Span]:
    """Yield springs, dampers and massless rods, and slides that no body shows."""
    sprung = {
        joint.name for joint in mechanism.joints if loads_in(mechanism.forces, joint.name, "spring")
    }
    for force in mechanism.forces:
        if isinstance(force, LineLoad):
            a, b = (Spot(end.body, end.point) for end in force.ends)
            yield Span(force.name, "spring" if force.kind == "spring" else "damper", (a, b))
    for loop in mechanism.loops:
        if loop.kind == "distance":
            a, b = Spot(loop.body_a, loop.frame_a.xyz), Spot(loop.body_b, loop.frame_b.xyz)
            yield Span(loop.name, "rod", (a, b))
    cords = [each for each in mechanism.elements if isinstance(each, Cord | Belt)]
    held = {stop.body for cord in cords for stop in cord.stops}
    for joint in mechanism.joints:
        # a slide without a visible body is shown by the cable or the spring that spans it
        if isinstance(joint, Prismatic) and (
            joint.name in sprung or (joint.parent != mechanism.ground and joint.child not in held)
        ):
            a, b = Spot(joint.parent, joint.origin.xyz), Spot(joint.child, (0.0, 0.0, 0.0))
            kind: LineKind = "spring" if joint.name in sprung else "rod"
            yield Span(f"joint {joint.name}", kind, (a, b))


def tips_of(mechanism: Mechanism) -> Iterator[Spot]:
    """Yield the farthest point from the joint on each last body of a chain."""
    parents = {joint.parent for joint in mechanism.joints}
    for body in mechanism.bodies:
        if body.name in parents or body.name == mechanism.ground or not body.visuals:
            continue
        tips = [tip for visual in body.visuals for tip in _tips(mechanism, visual)]
        yield Spot(body.name, max(tips, key=lambda tip: _distance(mechanism, tip)))


def _distance(mechanism: Mechanism, tip: Vector) -> float:
    return round(float(np.linalg.norm(mechanism.evaluate_all(tip))), 9)


def _tips(mechanism: Mechanism, visual: Visual) -> Iterator[Vector]:
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
