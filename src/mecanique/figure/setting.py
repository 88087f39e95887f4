"""The setting of a figure: a mechanism at one instant, its solids, and the view."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from contextlib import suppress
from dataclasses import dataclass, replace
from typing import Any, final

import numpy as np
from numpy.typing import NDArray

from mecanique.errors import MecaniqueError
from mecanique.figure.paper.marks import Point, directions
from mecanique.figure.solids import (
    IN_SPACE,
    ISOMETRIC,
    Camera,
    Floats,
    Outline,
    side_of,
    solids,
    span_box,
)
from mecanique.model import Box, Contact, Joint, Mechanism, Placement, Prismatic, Spring, Stop
from mecanique.model.constraints.friction import Switching
from mecanique.model.expression import Scalar
from mecanique.model.force_base import LineLoad
from mecanique.model.mechanism.letters import letters_of_words, to_letter
from mecanique.model.mechanism_units import units
from mecanique.model.placement import is_zero
from mecanique.reference import Reference

WIDTH, HEIGHT = 400.0, 300.0
"""The largest extent of a figure's solids [pt]."""

PLATE_MARGIN = 0.3
"""A plate of the ground reaches this share of the figure beyond what stands on it."""

FLATNESS = 0.1
"""A box of the ground thinner than this share of its length is a plate."""

CONE, RING = "solid cone", "thin ring"
ROUND = {CONE: (0.2, 0.5), "thin disk": (0.2, 0.95), RING: (0.2, 0.95)}
"""Cosines of the angle between the axis and the view at which a round body is known as one."""

STEPS = np.linspace(0.0, 1.0, 13)
"""Places along a solid that are tried for a letter."""

LONGEST_NAME = 9
"""Longer formulas are not written beside what they measure [characters]."""


@final
@dataclass(frozen=True, eq=False)
class Setting:
    """A mechanism at one instant, in a view."""

    mechanism: Mechanism
    reference: Reference
    q: Floats  # shape (nq,)
    v: Floats  # shape (nv,)
    t: float  # [s]
    poses: Floats  # shape (nb, 4, 4)
    camera: Camera
    solids: tuple[Outline, ...]
    switching: tuple[Switching, ...] = ()  # friction, stops and contacts, which only show

    def index(self, body: str) -> int:
        """Return the index of a body among the poses."""
        return [member.name for member in self.mechanism.bodies].index(body)

    def point(self, body: str, xyz: Any = (0.0, 0.0, 0.0)) -> Floats:
        """Return the position of a point of a body in the world, shape (3,) [m]."""
        pose = self.poses[self.index(body)]
        local = np.array(self.mechanism.evaluate_all(xyz))
        position: Floats = pose[:3, 3] + pose[:3, :3] @ local
        return position

    def seat(self, joint: Joint) -> Floats:
        """Return a joint's origin in the world, from its parent's pose, shape (3,) [m]."""
        return self.point(joint.parent, joint.origin.xyz)

    def axis(self, joint: Any) -> Floats:
        """Return the axis of a joint in the world, shape (3,)."""
        axis: Floats = self.poses[self.index(joint.child), :3, :3] @ np.array(joint.axis)
        return axis

    def frame(self, body: str, place: Placement) -> Floats:
        """Return a frame of a body in the world, as that of a plane it carries, shape (4, 4)."""
        frame: Floats = self.poses[self.index(body)] @ self.mechanism.matrix(place)
        return frame

    def has_teeth(self, body: str) -> bool:
        """Return whether a body is drawn with teeth."""
        return any(solid.contour is not None for solid in self.solids if solid.body == body)

    def at(self, body: str, xyz: Any = (0.0, 0.0, 0.0)) -> Point:
        """Return a point of a body on paper."""
        return self.camera.at(self.point(body, xyz))

    def seat_at(self, joint: Joint) -> Point:
        """Return a joint's origin on paper."""
        return self.camera.at(self.seat(joint))

    def along(self, joint: Any) -> Point:
        """Return a joint's axis on paper, as long as it is seen: 0 to 1."""
        return self.camera.at(self.axis(joint)) / self.camera.scale

    def paper(self, body: str) -> Point:
        """Return the points that span a body on paper, shape (n, 2), or its origin."""
        spans = [solid.corners for solid in self.solids if solid.body == body]
        return self.camera.at(np.concatenate(spans) if spans else self.point(body)[None])

    def reach(self, body: str, direction: Point) -> float:
        """Return how far a body extends on paper from the world's origin along a direction [pt]."""
        return float((self.paper(body) @ direction).max())

    def reach_from(self, at: Point, body: str, direction: Point) -> float:
        """Return how far a body extends on paper from a place along a direction [pt]."""
        return self.reach(body, direction) - float(at @ direction)

    def clear_side(self, at: Point) -> Point:
        """Return the emptiest direction from a place on paper, shape (2,)."""
        spots = [
            self.camera.at(solid.ends[0] + s * (solid.ends[1] - solid.ends[0]))
            for solid in self.solids
            for s in STEPS
        ]
        around = np.array(spots or [at]) - at
        ways = directions(np.arange(16) * np.pi / 8)
        near = around[np.hypot(*around.T) > 2.0]
        if not len(near):
            return np.array([1.0, 0.0])
        weight = 1.0 / (1.0 + (np.hypot(*near.T) / 30.0) ** 2)
        crowded = (np.maximum(ways @ (near / np.hypot(*near.T)[:, None]).T, 0.0) ** 2 * weight).sum(
            axis=1
        )
        best: Point = ways[int(np.argmin(np.round(crowded, 6) + 1e-4 * np.abs(ways[:, 1])))]
        return best

    def letter(self, name: str) -> str:
        """Return the letter that a name has in equations."""
        return to_letter(name, letters_of_words(self.mechanism))

    def name(self, scalar: Scalar) -> str:
        """Return the text of a scalar beside what it measures: its formula, if that is short."""
        if isinstance(scalar, (int, float)):
            return ""
        text = str(scalar).replace(" ", "")
        if "." in text:  # a measure that only the drawing needs
            return ""
        return text if len(text) <= LONGEST_NAME else ""


def setting(
    mechanism: Mechanism,
    reference: Reference,
    q: Floats,
    v: Floats,
    t: float,
    extent: tuple[float, float] = (WIDTH, HEIGHT),
    switching: tuple[Switching, ...] = (),
) -> Setting:
    """Return a mechanism at one instant, in the view and at the scale that suit it best."""
    poses = np.asarray(reference.poses(q, t))
    drawn = tuple(_trim_plates(mechanism, poses, tuple(solids(mechanism, poses))))
    axes = side_of(mechanism, poses)
    if axes is ISOMETRIC:
        axes = min(IN_SPACE, key=lambda view: round(_penalize_view(drawn, view), 6))
    seen = Setting(
        mechanism=mechanism,
        reference=reference,
        q=q,
        v=v,
        t=t,
        poses=poses,
        camera=Camera(axes, 1.0),
        solids=drawn,
        switching=switching,
    )
    room = {"ball": 14.0, "rod": 0.0}
    sizes = [s.size * room.get(s.kind, 2.6) for s in drawn if s.body != mechanism.ground]
    least = max(sizes, default=0.0) or 1e-3
    paper = seen.camera.at(np.concatenate([*_spots(seen)] or [np.zeros((1, 3))]))
    wide, high = (max(float(length), least) for length in np.ptp(paper, axis=0))
    return replace(seen, camera=Camera(axes, min(extent[0] / wide, extent[1] / high)))


def _penalize_view(drawn: tuple[Outline, ...], axes: Floats) -> float:
    """Return how far round bodies are from a view in which they are known as such."""
    total = 0.0
    for solid in drawn:
        least, most = ROUND.get(solid.form, (0.0, 1.0))
        facing = abs(float(solid.pose[:3, 2] @ axes[2]))
        total += max(least - facing, facing - most, 0.0)
    return total


def _spots(seen: Setting) -> Iterator[Floats]:
    """Yield the places that a figure holds: of bodies, of what acts on them, of what they touch."""
    mechanism = seen.mechanism
    yield from (solid.corners for solid in seen.solids)
    grounded = any(joint.parent == mechanism.ground for joint in mechanism.joints)
    for body in mechanism.bodies:
        if body.name != mechanism.ground or grounded:
            yield seen.point(body.name)[None]
    for force in mechanism.forces:
        if isinstance(force, LineLoad):
            yield from (seen.point(end.body, end.point)[None] for end in force.ends)
    for element in seen.switching:
        if isinstance(element, Contact) and is_zero(element.bowl):
            center = seen.point(element.body, element.center)
            plane = seen.frame(element.on, element.plane)
            normal = plane[:3, 2]
            yield (center - (center - plane[:3, 3]) @ normal * normal)[None]
        elif isinstance(element, Stop):
            joint = mechanism.joint(element.joint)
            if isinstance(joint, Prismatic) and joint.parent != mechanism.ground:
                radius = mechanism.evaluate(element.at)  # of the circle on which it stops
                yield seen.seat(joint) + radius * np.concatenate([np.eye(3), -np.eye(3)])


def _trim_plates(
    mechanism: Mechanism, poses: Floats, drawn: tuple[Outline, ...]
) -> Iterator[Outline]:
    """Yield the solids, with plates of the ground cut off where nothing stands on them."""
    ground = mechanism.ground
    spots = [solid.corners for solid in drawn if solid.body != ground]
    origins = np.concatenate([*spots, poses[:, :3, 3]])
    reach = PLATE_MARGIN * float(np.ptp(origins, axis=0).max())
    for solid in drawn:
        if solid.body != ground or not isinstance(solid.geometry, Box):
            yield solid
            continue
        center, axes = solid.pose[:3, 3], solid.pose[:3, :3]
        half = np.array(mechanism.evaluate_all(solid.geometry.size)) / 2
        if half.min() > FLATNESS * half.max():
            yield solid
            continue
        places = (origins - center) @ axes
        low = np.maximum(-half, np.minimum(places.min(axis=0) - reach, half))
        high = np.minimum(half, np.maximum(places.max(axis=0) + reach, -half))
        # across the plate it keeps its thickness
        thin = int(np.argmin(half))
        low[thin], high[thin] = -half[thin], half[thin]
        if (high <= low).any():
            yield solid
            continue
        pose = solid.pose.copy()
        pose[:3, 3] = middle = center + axes @ (low + high) / 2
        arm, size, corners = span_box(middle, axes, (high - low) / 2)
        ends = np.array([middle - arm, middle + arm])
        yield replace(solid, ends=ends, size=size, corners=corners, pose=pose)


ANGLES = (0.55, 0.95, 0.75, 1.15)
"""Values of the first, second … angle, unless it starts at a moderate angle of its own [rad]."""

SLIGHT, GREAT = 0.25, 1.3
"""Range of moderate angles [rad]."""


MOST_TURNED = 12
"""Of a robot with more coordinates each joint is drawn as its file has it: else it is a tangle."""

_SAME = 1e-9
"""Largest change of coordinates that do not depend on another [rad or m]."""

_STEPS_APART, _SMALL = 20, 1e-6
"""Most steps of Newton's method that bring points outside planes, and the steps of coordinates by
which slopes are taken [rad or m]."""

_SHARES, _FAR = (1.0, 0.5, 0.25, 0.125), 0.8
"""Parts of the way from the start to moderate angles that are tried, and how far a coordinate may
then move to bring points outside planes [rad or m]."""

_HALVINGS = 3
"""How often a start is halved in search of one that crushes no spring."""


def posture(mechanism: Mechanism, start: Mapping[str, float] | None = None) -> NDArray[np.float64]:
    """Return a position in which the figure shows what each coordinate is, shape (nq,)."""
    start = _usual_start(mechanism) if start is None else start
    if mechanism.constrained:
        from mecanique.reference import assemble

        given = dict(start)
        for _ in range(_HALVINGS):
            with suppress(MecaniqueError):
                q = np.asarray(assemble(mechanism, given), dtype=np.float64)
                if not _crushes(mechanism, q):
                    return _turn_what_is_free(mechanism, q)
            given = {name: value / 2 for name, value in given.items()}
        with suppress(MecaniqueError):
            return np.asarray(assemble(mechanism, dict(start)), dtype=np.float64)
    q = mechanism.position(dict(start))
    if mechanism.origin is not None and len(q) > MOST_TURNED:
        return q
    inside = {name for j in mechanism.joints if j.quaternion for name in j.coordinates}
    unit_of = units(mechanism)
    count = 0
    for k, name in enumerate(mechanism.coordinates):
        if name not in inside and unit_of[name] == "rad":
            if not SLIGHT <= abs(q[k]) <= GREAT:
                q[k] = ANGLES[count % len(ANGLES)]
            count += 1
    there = mechanism.position(dict(start))
    for share in () if inside else _SHARES:
        parted = _part_what_touches(mechanism, aim := there + share * (q - there))
        if parted is not None and np.abs(parted - aim).max(initial=0.0) < _FAR:
            return parted
    return q if inside else there


def _part_what_touches(mechanism: Mechanism, q: NDArray[np.float64]) -> NDArray[np.float64] | None:
    """Return a position near another with no point beyond the plane that it touches, or None."""
    switching = (e for e in mechanism.switching if isinstance(e, Contact) and e.axis is None)
    planes = [contact for contact in switching if is_zero(contact.bowl)]
    if not planes:
        return q
    reference = Reference.of(replace(mechanism, switching=()))
    at = {body.name: k for k, body in enumerate(mechanism.bodies)}

    def find_gaps(places: Floats) -> Floats:
        poses = np.asarray(reference.poses(places, 0.0))
        gaps = [-mechanism.evaluate(contact.radius) for contact in planes]
        for k, contact in enumerate(planes):
            frame = poses[at[contact.on]] @ mechanism.matrix(contact.plane)
            center = poses[at[contact.body]] @ (*mechanism.evaluate_all(contact.center), 1.0)
            gaps[k] += frame[:3, 2] @ (center[:3] - frame[:3, 3])
        return np.array(gaps)

    for _ in range(_STEPS_APART):
        gaps = find_gaps(q)
        if gaps.min(initial=0.0) > -_SAME:
            return q
        slopes = [(find_gaps(q + _SMALL * row) - gaps) / _SMALL for row in np.eye(len(q))]
        inside = gaps < 0
        q = q - np.linalg.pinv(np.array(slopes).T[inside], rcond=1e-6) @ gaps[inside]
    return None


def _turn_what_is_free(mechanism: Mechanism, q: NDArray[np.float64]) -> NDArray[np.float64]:
    """Turn what stands at zero by angles on which no other coordinate depends."""
    from mecanique.reference import assemble

    unit_of, count = units(mechanism), 0
    for k, name in enumerate(mechanism.coordinates):
        if unit_of[name] != "rad" or q[k] != 0.0:
            continue
        guess = {**dict(zip(mechanism.coordinates, q.tolist(), strict=True))}
        guess[name] = ANGLES[count % len(ANGLES)]
        with suppress(MecaniqueError):
            turned = np.asarray(assemble(mechanism, guess, keep=(name,)), dtype=np.float64)
            if np.abs(np.delete(turned - q, k)).max(initial=0.0) < _SAME:
                q, count = turned, count + 1
    return q


def _usual_start(mechanism: Mechanism) -> Mapping[str, float]:
    """Where the motion of a system of the catalogue starts; nothing for any other."""
    from mecanique.textbook.catalogue import entry, is_known

    if not is_known(mechanism.name):
        return {}
    start = entry(mechanism.name).start
    return start if start.keys() <= set(mechanism.coordinates) else {}


def _crushes(mechanism: Mechanism, q: NDArray[np.float64]) -> bool:
    """Whether a spring between two points is shorter than half its free length."""
    reference = Reference.of(mechanism)
    for force in mechanism.forces:
        if isinstance(force, Spring):
            a, b = (
                reference.point(end.body, mechanism.evaluate_all(end.point), q).position
                for end in force.ends
            )
            if np.linalg.norm(b - a) < mechanism.evaluate(force.free_length) / 2:
                return True
    return False
