"""The view of a mechanism on paper, and the outlines of its bodies: boxes, balls, rods as bars."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from typing import Any, final

import numpy as np
from numpy.typing import ArrayLike, NDArray

from mecanique.figure.paper.marks import Circle, Mark, Point, Stroke, across, directions, unit
from mecanique.model import Body, Box, Cylinder, Mechanism, Mesh, Sphere, Visual
from mecanique.model.bodies.visuals import measure
from mecanique.model.constraint_base import PressingContact
from mecanique.model.teeth import RackTeeth, Toothed, WheelTeeth, teeth_of
from mecanique.reference import Reference

Floats = NDArray[np.float64]


def _looking(azimuth: float, elevation: float) -> Floats:
    """Rows: right, up and towards the eye, in world axes."""
    ca, sa, ce, se = math.cos(azimuth), math.sin(azimuth), math.cos(elevation), math.sin(elevation)
    return np.array([[-sa, ca, 0.0], [-ca * se, -sa * se, ce], [ca * ce, sa * ce, se]])


FRONT = np.array([[1.0, 0, 0], [0, 0, 1.0], [0, -1.0, 0]])
TOP = np.array([[1.0, 0, 0], [0, 1.0, 0], [0, 0, 1.0]])
IN_SPACE = tuple(
    _looking(math.radians(-33.0 + turn), math.radians(18.0)) for turn in (0, 90, 30, -30, 60, -60)
)
ISOMETRIC = IN_SPACE[0]
"""The usual view in space, then others from around the vertical."""


@final
@dataclass(frozen=True, eq=False)
class Camera:
    """A parallel projection onto paper."""

    axes: Floats  # shape (3, 3), rows right, up and towards the eye, in world axes
    scale: float

    def at(self, position: ArrayLike) -> Point:
        """Project positions onto paper, shape (..., 2)."""
        seen = np.asarray(position, dtype=float) @ self.axes[:2].T * self.scale
        paper: Point = seen * np.array([1.0, -1.0])
        return paper

    def depth(self, position: ArrayLike) -> float:
        """Return how far a position lies towards the eye [m]."""
        return float(np.asarray(position, dtype=float) @ self.axes[2])

    @property
    def toward(self) -> Floats:
        """Unit vector from the paper to the eye."""
        eye: Floats = self.axes[2]
        return eye

    @property
    def flat(self) -> bool:
        """Whether it looks along an axis of the world."""
        return bool(np.abs(self.axes[2]).max() > 1 - 1e-9)


def side_of(mechanism: Mechanism, poses: Floats) -> Floats:
    """Return the axes of the best view of a mechanism: front or top if it is planar."""
    for view in (FRONT, TOP):
        if moves_parallel(mechanism, poses, view[2]):
            # turned until gravity points down on paper, as beside an incline
            up = -np.array(mechanism.evaluate_all(mechanism.gravity))
            size = float(np.linalg.norm(up))
            if not size or abs(up @ view[2]) > 1e-9 * size or abs(up @ view[0]) < 1e-9 * size:
                return view
            up = up / size
            return np.array([np.cross(up, view[2]), up, view[2]])
    return ISOMETRIC


def moves_parallel(mechanism: Mechanism, poses: Floats, normal: Floats) -> bool:
    """Return whether the joints let bodies move along a plane alone, given by its normal."""
    at = {body.name: k for k, body in enumerate(mechanism.bodies)}
    for joint in mechanism.joints:
        if joint.quaternion:
            return False
        for motion in joint.chain if joint.nv else ():
            # along the normal a slide has no component, an axis of rotation nothing else
            along = abs(float(poses[at[joint.child], :3, :3] @ motion.axis @ normal))
            if abs(along - (0.0 if motion.kind == "slide" else 1.0)) >= 1e-6:
                return False
    return True


def list_branch(mechanism: Mechanism, body: str) -> list[str]:
    """Return a body and all bodies that it carries."""
    names = [body]
    for joint in mechanism.tree:
        if joint.parent in names:
            names.append(joint.child)
    return names


def cord_stretches(
    mechanism: Mechanism, reference: Reference, q: Floats, v: Floats, t: Any
) -> Iterator[tuple[Floats, Floats]]:
    """Yield both ends of each stretch of cords, from where it leaves one thing to the next [m]."""
    names = {name for element in mechanism.elements for name in element.tensions}
    actions = reference.guide_actions(q, v, t) if names else ()
    ends = [action.point for action in actions if action.name in names]
    yield from zip(ends[::2], ends[1::2], strict=True)


SLENDER = 6.0
"""A cylinder longer than this many radii is a rod, drawn as a bar whatever its radius."""

RIM = 49
"""Points of the rim of a stone that rolls."""

RING = 0.92
"""Inner radius of a ring drawn in space, in its outer one."""


@final
@dataclass(frozen=True, eq=False)
class Outline:
    """A solid of a body, in the world."""

    body: str
    kind: str
    ends: Floats
    size: float  # radius of a ball, rod or cylinder [m]; half diagonal of a box
    corners: Floats  # shape (n, 3), points that span it [m]
    pose: Floats  # shape (4, 4), its frame
    geometry: Box | Cylinder | Sphere
    clear: bool
    point: bool = False
    contour: Floats | None = None
    hollow: bool = False
    form: str = ""  # what the piece of the body is, if it is homogeneous, e.g. "solid cone"


def solids(mechanism: Mechanism, poses: Floats) -> Iterator[Outline]:
    """Yield the geometries of a mechanism's bodies; surfaces in files are left out."""
    toothed = teeth_of(mechanism)
    stones = {
        c.body: c for c in mechanism.contacts if isinstance(c, PressingContact) and c.stretched
    }
    for body, pose in zip(mechanism.bodies, poses, strict=True):
        drawn = [*_solids_of(mechanism, body, pose, toothed)]
        if drawn and body.name in stones:
            drawn = [_stone(mechanism, stones[body.name], pose, drawn)]
        yield from drawn


def _solids_of(
    mechanism: Mechanism, body: Body, pose: Floats, toothed: tuple[Toothed, ...]
) -> Iterator[Outline]:
    for shape in body.shapes:
        point = all(isinstance(entry, (int, float)) and entry == 0 for entry in shape.inertia)
        for visual in shape.visuals:
            solid = _solid(mechanism, body.name, pose, visual)
            if solid is None:
                continue
            teeth = _find_teeth(mechanism, solid, toothed)
            yield replace(
                solid,
                form=shape.form,
                point=point and solid.kind == "ball",
                contour=None if teeth is None else _outline(mechanism, teeth, pose),
                hollow=isinstance(teeth, WheelTeeth) and teeth.internal,
            )


def _stone(
    mechanism: Mechanism, contact: PressingContact, pose: Floats, drawn: Sequence[Outline]
) -> Outline:
    """The ellipsoid on which a body rolls, as high as the body's solids reach."""
    at = pose.copy()
    at[:3, 3] += pose[:3, :3] @ np.array(mechanism.evaluate_all(contact.center))
    axes = mechanism.evaluate(contact.radius) * np.array(mechanism.evaluate_all(contact.stretch))
    reach = (np.concatenate([solid.corners for solid in drawn]) - at[:3, 3]) @ at[:3, 2]
    top = min(float(reach.max()) / axes[2], 1.0)
    turn, rise = np.meshgrid(np.linspace(0, 2 * math.pi, RIM), np.linspace(-1.0, top, 25))
    wide = np.sqrt(1.0 - rise**2)
    local = axes * np.stack([wide * np.cos(turn), wide * np.sin(turn), rise], axis=-1)
    far = at[:3, :3] @ np.diag(axes)[int(np.argmax(axes))]
    return replace(
        drawn[0],
        kind="stone",
        ends=np.array([at[:3, 3] - far, at[:3, 3] + far]),
        size=float(axes.max()),
        corners=at[:3, 3] + local.reshape(-1, 3) @ at[:3, :3].T,
        pose=at,
        form="",
    )


def _find_teeth(
    mechanism: Mechanism, solid: Outline, toothed: tuple[Toothed, ...]
) -> Toothed | None:
    """The teeth on a wheel's or a ring's cylinder, or a rack's box."""
    for teeth in toothed:
        if teeth.body != solid.body:
            continue
        if isinstance(teeth, RackTeeth):
            fits = solid.kind == "box"
        else:
            more = solid.size / mechanism.evaluate(teeth.radius) - 1
            fits = solid.kind == "cylinder" and (more > 0 if teeth.internal else abs(more) < 1e-6)
        if fits:
            return teeth
    return None


def _outline(mechanism: Mechanism, teeth: Toothed, pose: Floats) -> Floats:
    """The contour of teeth in the world, shape (n, 3)."""
    size = teeth.module if isinstance(teeth, RackTeeth) else teeth.radius
    local = teeth.outline(mechanism.evaluate(size))
    return np.asarray(local @ pose[:3, :3].T + pose[:3, 3])


def _solid(mechanism: Mechanism, body: str, pose: Floats, visual: Visual) -> Outline | None:
    """The outline of a primitive; none of a surface in a file."""
    kind, measures = measure(visual.geometry)
    if isinstance(visual.geometry, Mesh):
        return None
    at = pose @ mechanism.matrix(visual.placement)
    center, axes = at[:3, 3], at[:3, :3]
    sizes = mechanism.evaluate_all(measures)
    match kind:
        case "box":
            arm, size, corners = span_box(center, axes, np.array(sizes) / 2)
        case "cylinder":
            size, arm = sizes[0], sizes[1] / 2 * axes[:, 2]
            turn = np.linspace(0, 2 * math.pi, 48, endpoint=False)
            ring = size * (np.cos(turn)[:, None] * axes[:, 0] + np.sin(turn)[:, None] * axes[:, 1])
            corners = np.concatenate([center - arm + ring, center + arm + ring])
        case _:
            size, arm = sizes[0], np.zeros(3)
            corners = center + size * np.concatenate([np.eye(3), -np.eye(3)])
    rod = kind == "cylinder" and sizes[1] > SLENDER * size
    return Outline(
        body=body,
        kind="rod" if rod else {"sphere": "ball"}.get(kind, kind),
        ends=np.array([center - arm, center + arm]),
        size=size,
        corners=corners,
        pose=at,
        geometry=visual.geometry,
        clear=visual.rgba is not None and visual.rgba[3] < 1,
    )


def span_box(center: Floats, axes: Floats, half: Floats) -> tuple[Floats, float, Floats]:
    """Return half the longest edge of a box, half its diagonal, and its corners, shape (8, 3)."""
    signs = np.array([[i, j, k] for i in (-1, 1) for j in (-1, 1) for k in (-1, 1)])
    far = int(np.argmax(half))
    arm = half[far] * axes[:, far]
    return arm, float(np.linalg.norm(half)), center + (signs * half) @ axes.T


def outline(solid: Outline, camera: Camera) -> Iterator[Mark]:
    """Yield the marks of a solid."""
    if solid.kind == "ball":
        yield Circle(camera.at(solid.ends[0]), radius_of(solid, camera), "mass")
    elif solid.kind == "box":
        yield from _box(solid, camera)
    elif solid.kind == "stone":
        paper = camera.at(solid.corners)
        yield Stroke(hull(paper), "shade", closed=True)
        if solid.pose[:3, 2] @ camera.toward > 0:
            yield Stroke(paper[-RIM:], "body", closed=True)
    elif solid.form == "solid cone":
        yield from _cone(solid, camera)
    elif solid.form == "thin ring" and not camera.flat:
        # its width is a tenth of its radius
        edge = solid.corners[: len(solid.corners) // 2]
        middle = edge.mean(axis=0)
        inner = middle + RING * (edge - middle)
        outer = np.concatenate([edge, edge[:1]])
        for loop in (outer, np.concatenate([inner, inner[:1]])):
            yield Stroke(camera.at(loop), "spring")
    elif solid.kind == "rod":
        yield from _bar(solid, camera)
    elif solid.contour is None or solid.hollow:
        yield from _cylinder(solid, camera)
    if solid.contour is not None:
        yield Stroke(camera.at(solid.contour), "bar" if solid.hollow else "body", closed=True)


def radius_of(solid: Outline, camera: Camera) -> float:
    """Return the radius of a ball on paper; a particle is a dot of moderate size [pt]."""
    return min(max(solid.size * camera.scale, 5.5), 9.0 if solid.point else math.inf)


def _bar(solid: Outline, camera: Camera) -> Iterator[Mark]:
    a, b = camera.at(solid.ends)
    half = min(max(solid.size * camera.scale, 2.6), 4.5)
    if math.hypot(*(b - a)) < 2 * half:
        yield Circle((a + b) / 2, half, "bar")
        return
    side = across(unit(b - a))
    # a bar ends in half circles, as if cut from a strip
    cap = half * directions(math.atan2(side[1], side[0]) + np.linspace(0.0, math.pi, 9))
    yield Stroke(np.concatenate([b + cap, a - cap]), "bar", closed=True)


def _cylinder(solid: Outline, camera: Camera) -> Iterator[Mark]:
    look = "clear" if solid.clear or not camera.flat else "body"
    axis = unit3(solid.ends[1] - solid.ends[0])
    tilt = float(axis @ camera.toward)
    if abs(tilt) > 1 - 1e-9:
        yield Circle(camera.at(solid.ends[0]), solid.size * camera.scale, look)
        return
    paper = camera.at(solid.corners)
    yield Stroke(hull(paper), look, closed=True)
    if abs(tilt) > 1e-6:
        half = len(paper) // 2
        yield Stroke(paper[half:] if tilt > 0 else paper[:half], "clear", closed=True)


def _cone(solid: Outline, camera: Camera) -> Iterator[Mark]:
    """A cone from the disk that stands for its base: the apex is 15/2 disks before its middle."""
    if solid.kind == "rod":
        return
    half = (solid.ends[1] - solid.ends[0]) / 2
    apex = solid.ends.mean(axis=0) - 15.0 * half
    edge = solid.corners[len(solid.corners) // 2 :]
    base = camera.at(edge)
    yield Stroke(hull(np.concatenate([base, camera.at(apex)[None]])), "body", closed=True)
    if (half @ camera.toward) <= 0:
        yield Stroke(base, "dashed", closed=True)
        return
    yield Stroke(base, "clear", closed=True)
    # seen from its base, its outline is the base's: two of its lines behind it show the apex
    side = across(unit(base.mean(axis=0) - camera.at(apex)))
    for k in (int(np.argmax(base @ side)), int(np.argmin(base @ side))):
        yield Stroke(np.stack([camera.at(apex), base[k]]), "dashed")


def _box(solid: Outline, camera: Camera) -> Iterator[Mark]:
    corners = solid.corners.reshape(2, 2, 2, 3)
    if camera.flat or solid.clear:
        yield Stroke(
            hull(camera.at(solid.corners)), "clear" if solid.clear else "body", closed=True
        )
        return
    for k in range(3):
        sign = 1 if solid.pose[:3, k] @ camera.toward > 0 else 0
        face = np.take(corners, sign, axis=k).reshape(4, 3)[[0, 1, 3, 2]]
        lies_flat = abs(solid.pose[2, k]) > 0.7
        style = "face" if k == 1 else "shade"
        yield Stroke(camera.at(face), "body" if lies_flat else style, closed=True)


def unit3(vector: Floats) -> Floats:
    """Return a vector's direction in space."""
    length = float(np.linalg.norm(vector))
    return vector / length if length > 0 else np.array([0.0, 0.0, 1.0])


def hull(points: Point) -> Point:
    """Return the convex hull of points on paper (Andrew, Inf. Process. Lett. 9 (1979) 216)."""
    ordered = sorted(map(tuple, np.round(points, 6)))
    chains: list[list[tuple[float, ...]]] = []
    for way in (ordered, ordered[::-1]):
        chain: list[tuple[float, ...]] = []
        for p in way:
            while len(chain) > 1 and _turn(chain[-2], chain[-1], p) <= 0:
                chain.pop()
            chain.append(p)
        chains.append(chain[:-1])
    return np.array(chains[0] + chains[1])


def _turn(o: tuple[float, ...], a: tuple[float, ...], b: tuple[float, ...]) -> float:
    return (a[0] - o[0]) * (b[1] - o[1]) - (a[1] - o[1]) * (b[0] - o[0])
