"""How gears and racks are drawn: with teeth that mesh.

Nothing in the mechanics depends on teeth. Their module is one for all wheels that mesh, such that
the smallest has as few teeth as make all numbers whole; they reach one module beyond the pitch
circle and 1.25 modules to the root (ISO 53).
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from math import atan2, copysign, cos, pi, sin
from typing import NamedTuple, TypeAlias, final

import numpy as np

from mecanique.arrays import Array
from mecanique.model.bodies.visuals import Box, Cylinder, Visual
from mecanique.model.constraints.gears import Gear, Rack
from mecanique.model.expression import Scalar
from mecanique.model.joints import Prismatic, Revolute
from mecanique.model.mechanism import Mechanism
from mecanique.model.mechanism.element_laws import bevel_of
from mecanique.model.placement import Placement, rpy_of


@final
class PitchPoint(NamedTuple):
    """Where two parts in mesh touch, in the world."""

    axis: Array
    toward: Array  # from its center to where the pitch circles touch, a unit vector
    partner_axis: Array
    partner_toward: Array  # the same from its center
    # angles by which the teeth of both point out of their wheels' planes, towards the axes; zero
    # unless they are bevel wheels [rad]
    rises: tuple[float, float] = (0.0, 0.0)
    ray: float = 0.0  # from the apex of bevel wheels to there [m]


def find_pitch_point(mechanism: Mechanism, mesh: Gear | Rack, A: Array, B: Array) -> PitchPoint:
    """Return where a wheel touches another, or a rack; A (4, 4), B (4, 4)."""
    wheel, second = (mechanism.joint(name) for name in mesh.joints)
    assert isinstance(wheel, Revolute)
    assert isinstance(second, Revolute | Prismatic)
    n, line = A[:3, :3] @ np.array(wheel.axis), B[:3, :3] @ np.array(second.axis)
    bevel = bevel_of(mechanism, mesh) if isinstance(mesh, Gear) else None
    if bevel is not None and isinstance(mesh, Gear):
        c, s = bevel.cosine, bevel.sine
        r, R = mechanism.evaluate_all((mesh.radius, mesh.other_radius))
        x, y = bevel.sides[0] * r, bevel.sides[1] * R
        # from the apex the centers are at a n and b n'
        a, b = (y + c * x) / s, (x + c * y) / s
        toward, back = bevel.sides[0] * (line - c * n) / s, bevel.sides[1] * (n - c * line) / s
        # at right angles on the ray to where they touch: the teeth of the narrower cone point away
        # from its axis, whether that points to the apex or from it, and the others against them
        ups, signs = (a * toward - r * n, b * back - R * line), [copysign(1, a), copysign(1, b)]
        narrow = 0 if r * abs(b) <= R * abs(a) else 1
        signs[1 - narrow] = -copysign(1, signs[narrow] * (ups[0] @ ups[1]))
        return PitchPoint(
            axis=n,
            toward=toward,
            partner_axis=line,
            partner_toward=back,
            rises=(
                atan2(-signs[0] * r, signs[0] * a),
                atan2(-signs[1] * R, signs[1] * b),
            ),
            ray=float(np.hypot(a, r)),
        )
    point = mesh.point if isinstance(mesh, Rack) else (0.0, 0.0, 0.0)
    d = B[:3, :3] @ mechanism.evaluate_all(point) + B[:3, 3] - A[:3, 3]
    if isinstance(second, Prismatic):
        d = d - (d @ line) * line
    d = d - (d @ n) * n
    u = d / np.linalg.norm(d)
    internal = isinstance(mesh, Gear) and mesh.internal
    return PitchPoint(n, u, n, u if internal else -u)


_FEWEST, _MOST = 15, 40
"""Teeth of the smallest wheel, from … to."""

_WHOLE = 0.02
"""A number of teeth this near to a whole one is whole."""

_TIP, _ROOT = 1.0, 1.25
"""Height above and below the pitch line, in modules."""

_NARROW, _WIDE = 0.28, 0.72
"""Width of a tooth at its tip and at its root, as a part of the pitch."""


_FACE = 0.3
"""Width of the teeth of bevel wheels, as a part of the way to the apex."""


@final
@dataclass(frozen=True)
class WheelTeeth:
    """The teeth of a wheel, about the origin of its body."""

    body: str
    axes: Array  # shape (3, 3), columns: two normals to its axis, and the axis, in the body's frame
    radius: Scalar  # pitch radius [m]
    count: int
    phase: float  # angle of one of them from the first column [rad]
    internal: bool  # whether they point inwards
    width: Scalar  # along the axis, or from the pitch circle towards the apex of bevel wheels [m]
    # angle by which a tooth points out of the wheel's plane, towards the axis; 0 for spur wheels, ±
    # the pitch cone's for bevel wheels [rad]
    rise: float = 0.0

    @property
    def module(self) -> Scalar:
        """Pitch over π [m]."""
        return 2 * self.radius / self.count

    def outline(self, radius: float) -> Array:
        """Return the contour, shape (n, 3), in the body's frame; radius [m]."""
        module, sign = 2 * radius / self.count, -1 if self.internal else 1
        heights = sign * module * np.array([-_ROOT, _TIP, _TIP, -_ROOT])
        places = np.array([-_WIDE, -_NARROW, _NARROW, _WIDE]) / 2
        turn = self.phase + (np.arange(self.count)[:, None] + places) * (2 * pi / self.count)
        high = np.broadcast_to(heights, turn.shape)
        r = radius + high * cos(self.rise)
        places = np.stack([r * np.cos(turn), r * np.sin(turn), high * sin(self.rise)], axis=-1)
        corners: Array = places.reshape(-1, 3) @ self.axes.T
        return corners

    def visuals(self) -> Iterator[Visual]:
        """Yield a box for each tooth."""
        # from the pitch circle to the middle of a tooth, in radii
        middle = (_ROOT - _TIP) / self.count * (1 if self.internal else -1)
        height = (_TIP + _ROOT) * self.module
        size = (height, (_NARROW + _WIDE) / 2 * pi * self.module, self.width)
        for k in range(self.count):
            angle = self.phase + 2 * pi * k / self.count
            out = self.axes[:, 0] * cos(angle) + self.axes[:, 1] * sin(angle)
            axis, across = self.axes[:, 2], np.cross(self.axes[:, 2], out)
            high = out * cos(self.rise) + axis * sin(self.rise)
            turn = np.stack([high, across, np.cross(high, across)], axis=1)
            # the teeth of spur wheels lie on both sides of the wheel's plane
            inward = np.sign(self.rise) * turn[:, 2] / 2
            place = zip((out + middle * high).tolist(), inward.tolist(), strict=True)
            x, y, z = (self.radius * a + self.width * b for a, b in place)
            yield Visual(Box(size), Placement((x, y, z), rpy_of(turn)))


@final
@dataclass(frozen=True)
class RackTeeth:
    """The teeth of a rack."""

    body: str
    axes: Array  # shape (3, 3), columns: along the pitch line, from it to the wheel, and across
    start: Array  # shape (3,), the middle of a tooth on the pitch line, in the body's frame [m]
    module: Scalar  # pitch over π [m]
    reach: tuple[float, float]  # shape (2,), how far they go along the pitch line, from `start` [m]
    width: Scalar  # across [m]

    def _numbers(self, pitch: float) -> range:
        first, last = (reach / pitch for reach in self.reach)
        return range(int(np.ceil(first + _WIDE / 2)), int(np.floor(last - _WIDE / 2)) + 1)

    def outline(self, module: float) -> Array:
        """Return the contour of the teeth, shape (n, 3), in the body's frame; module [m]."""
        pitch = pi * module
        heights = np.array([-_ROOT, _TIP, _TIP, -_ROOT]) * module
        places = np.array([-_WIDE, -_NARROW, _NARROW, _WIDE]) / 2 * pitch
        along = np.concatenate([k * pitch + places for k in self._numbers(pitch)])
        high = np.tile(heights, len(along) // 4)
        corners: Array = (
            self.start + along[:, None] * self.axes[:, 0] + high[:, None] * self.axes[:, 1]
        )
        return corners

    def visuals(self, module: float) -> Iterator[Visual]:
        """Yield a box for each tooth; module [m]."""
        pitch = pi * module
        size = ((_NARROW + _WIDE) / 2 * pitch, (_TIP + _ROOT) * module, self.width)
        for k in self._numbers(pitch):
            at = self.start + k * pitch * self.axes[:, 0]
            at = at + (_TIP - _ROOT) / 2 * module * self.axes[:, 1]
            x, y, z = at.tolist()
            yield Visual(Box(size), Placement((x, y, z), rpy_of(self.axes)))


Toothed: TypeAlias = WheelTeeth | RackTeeth


def visuals_of(mechanism: Mechanism) -> dict[str, tuple[Visual, ...]]:
    """Return what is drawn of each body, by name: its visuals, its wheels with teeth."""
    visuals = {body.name: body.visuals for body in mechanism.bodies}
    for teeth in teeth_of(mechanism):
        drawn = visuals[teeth.body]
        if isinstance(teeth, RackTeeth):
            visuals[teeth.body] = (*drawn, *teeth.visuals(mechanism.evaluate(teeth.module)))
            continue
        rims = [v for v in drawn if teeth.internal or _is_pitch(mechanism, v, teeth.radius)]
        color = rims[0].rgba if rims else None
        drawn = tuple(_to_root(mechanism, visual, teeth) for visual in drawn)
        visuals[teeth.body] = (*drawn, *(replace(tooth, rgba=color) for tooth in teeth.visuals()))
    return visuals


def teeth_of(mechanism: Mechanism) -> tuple[Toothed, ...]:
    """Return the teeth of all wheels and racks of a mechanism; at its zero position they mesh."""
    meshes = [mesh for mesh in mechanism.elements if isinstance(mesh, (Gear, Rack))]
    if not meshes:
        return ()
    poses = mechanism.home_poses
    placed: dict[tuple[str, bool], Toothed] = {}
    waiting = [mesh for mesh in meshes if _has_axes(mechanism, mesh)]
    counts = _count(mechanism, waiting)
    carried = {joint.name: joint.child for joint in mechanism.joints}
    while waiting:
        # what meshes with wheels that have teeth comes first
        known = {body for body, _ in placed}
        mesh = next((m for m in waiting if known & {*map(carried.get, m.joints)}), waiting[0])
        waiting.remove(mesh)
        for teeth in _mesh(mechanism, mesh, poses, counts[id(mesh)], placed):
            key = teeth.body, isinstance(teeth, WheelTeeth) and teeth.internal
            placed.setdefault(key, teeth)
    return tuple(placed.values())


def _mesh(
    mechanism: Mechanism,
    mesh: Gear | Rack,
    poses: dict[str, Array],
    counts: tuple[int, int],
    placed: dict[tuple[str, bool], Toothed],
) -> Iterator[Toothed]:
    """The teeth of both parts of a mesh; a tooth of one is between two of the other."""
    wheel, partner_joint = (mechanism.joint(name) for name in mesh.joints)
    assert isinstance(wheel, Revolute)
    A, B = poses[wheel.child], poses[partner_joint.child]
    touch = find_pitch_point(mechanism, mesh, A, B)
    n, u, t = touch.axis, touch.toward, np.cross(touch.axis, touch.toward)
    radius, (count, partner_count) = mechanism.evaluate(mesh.radius), counts
    pitch = 2 * pi * radius / count
    internal = isinstance(mesh, Gear) and mesh.internal
    width = _width_of(mechanism, mesh, touch) or pitch
    known, partner = placed.get((wheel.child, internal)), placed.get((partner_joint.child, False))
    along = np.cross(touch.partner_axis, touch.partner_toward)
    sign = 1 if along @ t > 0 else -1
    apart = 0.0  # along t, of a tooth of the wheel from where the pitch circles touch [m]
    if isinstance(known, WheelTeeth):
        apart = radius * _turn_of(known, A, n, u)
    elif isinstance(partner, WheelTeeth) and isinstance(mesh, Gear):
        turn = _turn_of(partner, B, touch.partner_axis, touch.partner_toward)
        apart = sign * mechanism.evaluate(mesh.other_radius) * turn + pitch / 2
    first, second = touch.rises
    yield WheelTeeth(
        body=wheel.child,
        axes=A[:3, :3].T @ np.stack([u, t, n], axis=1),
        radius=mesh.radius,
        count=count,
        phase=apart / radius,
        internal=internal,
        width=width,
        rise=first,
    )
    between = apart + pitch / 2
    if isinstance(mesh, Gear):
        size = mechanism.evaluate(mesh.other_radius)
        frame = np.stack([touch.partner_toward, along, touch.partner_axis], axis=1)
        yield WheelTeeth(
            body=partner_joint.child,
            axes=B[:3, :3].T @ frame,
            radius=mesh.other_radius,
            count=partner_count,
            phase=sign * between / size,
            internal=False,
            width=width,
            rise=second,
        )
        return
    back = B[:3, :3].T
    start = back @ (A[:3, 3] + radius * u + between * t - B[:3, 3])
    axes = back @ np.stack([t, -u, np.cross(t, -u)], axis=1)
    module = 2 * mesh.radius / count
    reach = _reach(mechanism, partner_joint.child, start, axes[:, 0]) or (-4 * pitch, 4 * pitch)
    yield RackTeeth(
        body=partner_joint.child, axes=axes, start=start, module=module, reach=reach, width=width
    )


def _width_of(mechanism: Mechanism, mesh: Gear | Rack, touch: PitchPoint) -> Scalar | None:
    """The width of a mesh's teeth, None if no shape shows it; the other wheel's shape decides."""
    if touch.rises != (0.0, 0.0):
        return _FACE * touch.ray
    wheel, second = (mechanism.joint(name).child for name in mesh.joints)
    first_width = _width(mechanism, wheel, mesh.radius)
    if isinstance(mesh, Gear):
        return _width(mechanism, second, mesh.other_radius) or first_width
    return first_width


def _count(mechanism: Mechanism, meshes: list[Gear | Rack]) -> dict[int, tuple[int, int]]:
    """Numbers of teeth of both wheels of each mesh, by its identity."""
    radii = {}
    for mesh in meshes:
        pair = [mesh.radius, mesh.other_radius if isinstance(mesh, Gear) else mesh.radius]
        radii[id(mesh)] = tuple(mechanism.evaluate_all(pair))
    if not radii:
        return {}
    sizes = np.array(list(radii.values()))
    least = sizes.min()

    def miss(fewest: int) -> float:
        counts = fewest * sizes / least
        return float(np.abs(counts - np.round(counts)).max())

    fewest = min(range(_FEWEST, _MOST + 1), key=lambda k: (miss(k) > _WHOLE) * miss(k))
    pairs = {}
    for key, (a, b) in radii.items():
        pairs[key] = round(fewest * a / least), round(fewest * b / least)
    return pairs


def _has_axes(mechanism: Mechanism, mesh: Gear | Rack) -> bool:
    """Whether a mesh is one of wheels on hinges, or of a wheel and a rack on a slide."""
    a, b = (mechanism.joint(name) for name in mesh.joints)
    return isinstance(a, Revolute) and isinstance(b, Revolute | Prismatic)


def _is_pitch(mechanism: Mechanism, visual: Visual, radius: Scalar) -> bool:
    """Whether a visual is the cylinder of a pitch circle."""
    if not isinstance(visual.geometry, Cylinder):
        return False
    size = mechanism.evaluate(radius)
    return abs(mechanism.evaluate(visual.geometry.radius) - size) < 1e-6 * size


def _width(mechanism: Mechanism, body: str, radius: Scalar) -> Scalar | None:
    """How wide a wheel is drawn."""
    for visual in mechanism.body(body).visuals:
        if isinstance(visual.geometry, Cylinder) and _is_pitch(mechanism, visual, radius):
            return visual.geometry.length
    return None


def _to_root(mechanism: Mechanism, visual: Visual, teeth: WheelTeeth) -> Visual:
    """A wheel drawn to the root of its teeth, not to its pitch circle."""
    if teeth.internal or not _is_pitch(mechanism, visual, teeth.radius):
        return visual
    assert isinstance(visual.geometry, Cylinder)
    radius = visual.geometry.radius - _ROOT * teeth.module
    return replace(visual, geometry=replace(visual.geometry, radius=radius))


def _reach(
    mechanism: Mechanism, body: str, start: Array, along: Array
) -> tuple[float, float] | None:
    """How far a body's boxes reach along a direction."""
    reaches = []
    for visual in mechanism.body(body).visuals:
        if isinstance(visual.geometry, Box):
            pose = mechanism.matrix(visual.placement)
            half = np.array(mechanism.evaluate_all(visual.geometry.size)) / 2
            middle = float((pose[:3, 3] - start) @ along)
            wide = float(np.abs(pose[:3, :3].T @ along) @ half)
            reaches.append((middle - wide, middle + wide))
    return max(reaches, key=lambda reach: reach[1] - reach[0], default=None)


def _turn_of(teeth: WheelTeeth, pose: Array, n: Array, toward: Array) -> float:
    """By which angle about n, in the world, a tooth is away from a direction."""
    x, y, z = (pose[:3, :3] @ teeth.axes).T
    angle = teeth.phase - atan2(float(y @ toward), float(x @ toward))
    return angle if z @ n > 0 else -angle
