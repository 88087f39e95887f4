"""The solid that a link's shapes enclose: volume, centroid and second moments, and how far it goes.

Primitives in closed form; meshes by the tetrahedra between a point and their triangles (B. Mirtich,
J. Graphics Tools 1, 1996). A mesh with holes stands for its convex hull. Where shapes of one link
overlap, the common part counts twice.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache, reduce
from pathlib import Path
from typing import final

import numpy as np

from mecanique.arrays import Array
from mecanique.errors import InputError
from mecanique.model.bodies.visuals import Box, Cylinder, Mesh, Sphere, Visual
from mecanique.model.placement import Placement
from mecanique.urdf.meshes import read_mesh

_TOGETHER = 1e-8
"""Corners are one if they differ by less, relative to the mesh."""


@final
@dataclass(frozen=True, eq=False)
class Solid:
    """A homogeneous solid of density 1 in the frame of its link.

    Args:
        volume: [m³].
        center: centroid, shape (3,) [m].
        inertia: about the centroid, in the link's axes, shape (3, 3) [m⁵].
        low: the least coordinates, shape (3,) [m].
        high: the greatest, shape (3,) [m].
        kind: "box", "cylinder", "sphere", "mesh", "hull" or "several".
    """

    volume: float
    center: Array
    inertia: Array
    low: Array
    high: Array
    kind: str

    def __add__(self, other: Solid) -> Solid:
        volume = self.volume + other.volume
        center = (self.volume * self.center + other.volume * other.center) / volume
        inertia = sum(
            each.inertia + each.volume * _about(each.center - center) for each in (self, other)
        )
        low, high = np.minimum(self.low, other.low), np.maximum(self.high, other.high)
        return Solid(volume, center, np.asarray(inertia), low, high, "several")

    def outside(self, point: Array) -> float:
        """Return how far a point lies outside of the solid's bounding box [m]."""
        return float(np.linalg.norm(point - np.clip(point, self.low, self.high)))


def solid_of(
    shapes: Sequence[Visual], *, meshes: bool, faults: list[str] | None = None
) -> Solid | None:
    """Return the solid that some shapes make together; None if one of them is not known.

    Args:
        shapes: of one link.
        meshes: whether to read the files of meshes.
        faults: where the meshes that cannot be read are noted, with the reason.
    """
    parts = []
    for shape in shapes:
        try:
            parts.append(_solid(shape, meshes=meshes))
        except InputError as error:
            parts.append(None)
            if faults is not None:
                faults.append(str(error))
    known = [part for part in parts if part is not None]
    return reduce(Solid.__add__, known) if known and len(known) == len(parts) else None


def _solid(shape: Visual, *, meshes: bool) -> Solid | None:
    turn, shift = np.array(shape.placement.rotation, float), np.array(shape.placement.xyz, float)
    match shape.geometry:
        case Box(size):
            a, b, c = (float(edge) for edge in size)
            moments = [b * b + c * c, a * a + c * c, a * a + b * b]
            half = np.array([a, b, c]) / 2
            return _primitive("box", a * b * c, np.array(moments) / 12, half, turn, shift)
        case Cylinder(radius, length):
            r, h = float(radius), float(length)
            across = (3 * r * r + h * h) / 12
            half = np.array([r, r, h / 2])
            moments = [across, across, r * r / 2]
            volume = np.pi * r * r * h
            return _primitive("cylinder", volume, np.array(moments), half, turn, shift)
        case Sphere(radius):
            r = float(radius)
            volume = 4 / 3 * np.pi * r**3
            moments = [2 * r * r / 5] * 3
            return _primitive("sphere", volume, np.array(moments), np.full(3, r), np.eye(3), shift)
        case Mesh(path=path, scale=scale) if meshes and path is not None:
            changed = path.stat().st_mtime_ns if path.is_file() else 0
            return _mesh(path, changed, tuple(scale), shape.placement)
    return None


def _primitive(
    kind: str, volume: float, radii: Array, half: Array, turn: Array, shift: Array
) -> Solid | None:
    """Return a primitive with given squares of its radii of gyration."""
    if not volume > 0:
        return None
    reach = np.abs(turn) @ half
    inertia = turn @ np.diag(volume * radii) @ turn.T
    return Solid(volume, shift, inertia, shift - reach, shift + reach, kind)


@lru_cache(maxsize=256)
def _mesh(path: Path, changed: int, scale: tuple[float, ...], place: Placement) -> Solid | None:
    """The solid that a mesh encloses; a file is read again only if it has changed."""
    del changed  # enough to tell one version of the file from the next
    turn, shift = np.array(place.rotation, float), np.array(place.xyz, float)
    surfaces = read_mesh(path)
    if not surfaces:
        raise InputError(f"mesh file {path}: it holds no triangles")
    corners = np.concatenate([surface.corners.reshape(-1, 3) for surface in surfaces])
    corners = (corners * scale) @ turn.T + shift
    low, high = corners.min(axis=0), corners.max(axis=0)
    # about a point within, so that little cancels
    middle, size = (low + high) / 2, float(np.max(high - low))
    triangles = (corners - middle).reshape(-1, 3, 3)
    whole = _closed(triangles, size)
    if not whole:
        triangles = _hull(triangles)
    a, b, c = triangles.transpose(1, 0, 2)
    volumes = np.einsum("ni,ni->n", a, np.cross(b, c)) / 6
    volume = float(volumes.sum())
    if abs(volume) <= 1e-12 * size**3:
        raise InputError(f"mesh file {path}: it encloses no volume")
    total = a + b + c
    # ∫ x dV and ∫ x xᵀ dV of the tetrahedra between the middle and each triangle
    first = volumes @ total / 4 / volume
    arms = np.stack([a, b, c, total], axis=1)
    second = np.einsum("n,nki,nkj->ij", volumes, arms, arms) / 20
    moments = np.trace(second) * np.eye(3) - second
    inertia = np.sign(volume) * (moments - volume * _about(first))
    return Solid(abs(volume), middle + first, inertia, low, high, "mesh" if whole else "hull")


def _closed(triangles: Array, size: float) -> bool:
    """Whether each edge is run along as often in one way as in the other."""
    grid = np.round(triangles.reshape(-1, 3) / (_TOGETHER * size)).astype(np.int64)
    numbers = np.unique(grid, axis=0, return_inverse=True)[1].reshape(-1, 3).astype(np.int64)
    start, end = numbers.ravel(), np.roll(numbers, -1, axis=1).ravel()
    forth = start != end
    start, end = start[forth], end[forth]
    key = np.minimum(start, end) * (len(triangles) * 3 + 1) + np.maximum(start, end)
    edges, edge = np.unique(key, return_inverse=True)
    return not np.bincount(edge.ravel(), np.where(start < end, 1.0, -1.0), len(edges)).any()


def _hull(triangles: Array) -> Array:
    """The triangles of the convex hull, each counterclockwise from outside."""
    from scipy.spatial import ConvexHull, QhullError

    try:
        hull = ConvexHull(triangles.reshape(-1, 3))
    except (QhullError, ValueError):
        return np.empty((0, 3, 3))
    corners = np.asarray(hull.points[hull.simplices])
    a, b, c = corners.transpose(1, 0, 2)
    inwards = np.einsum("ni,ni->n", np.cross(b - a, c - a), hull.equations[:, :3]) < 0
    corners[inwards] = corners[inwards][:, ::-1]
    return corners


def _about(arm: Array) -> Array:
    """The inertia of a unit mass at a distance."""
    return np.asarray((arm @ arm) * np.eye(3) - np.outer(arm, arm))
