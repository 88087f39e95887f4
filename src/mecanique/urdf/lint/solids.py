"""The solid that a link's shapes enclose: volume, centroid and second moments, and how far it goes.

Primitives in closed form; meshes by trimesh (extra `mesh`). A mesh with holes stands for its convex
hull. Where shapes of one link overlap, the common part counts twice.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import reduce
from typing import Any, final

import numpy as np

from mecanique.arrays import Array
from mecanique.errors import InputError
from mecanique.model.bodies.visuals import Box, Cylinder, Mesh, Sphere, Visual


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


def solid_of(shapes: Sequence[Visual], *, meshes: bool) -> Solid | None:
    """Return the solid that some shapes make together; None if one of them is not known.

    Args:
        shapes: of one link.
        meshes: whether to read the files of meshes.

    Raises:
        InputError: if a mesh is to be read and trimesh is not installed.
    """
    parts = [_solid(shape, meshes=meshes) for shape in shapes]
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
            return _mesh(str(path), scale, turn, shift)
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


def _mesh(path: str, scale: Sequence[float], turn: Array, shift: Array) -> Solid | None:
    try:
        import trimesh
    except ImportError:
        raise InputError(
            "meshes are read by trimesh, which is not installed: pip install 'mecanique[mesh]'"
        ) from None
    try:
        mesh: Any = trimesh.load(path, force="mesh")
        whole = bool(mesh.is_watertight)
        solid = mesh.copy() if whole else mesh.convex_hull
    except Exception:
        # the library lets any error of a broken file through
        return None
    matrix = np.eye(4)
    matrix[:3, :3], matrix[:3, 3] = turn * np.array(scale), shift
    solid.apply_transform(matrix)
    volume = float(solid.volume)
    if volume < 0:  # a mesh whose faces look inwards
        solid.invert()
        volume = -volume
    if not volume > 0:
        return None
    low, high = np.array(solid.bounds)
    center, inertia = np.array(solid.center_mass), np.array(solid.moment_inertia)
    return Solid(volume, center, inertia, low, high, "mesh" if whole else "hull")


def _about(arm: Array) -> Array:
    """The inertia of a unit mass at a distance."""
    return np.asarray((arm @ arm) * np.eye(3) - np.outer(arm, arm))
