"""Homogeneous solids: of simple forms, of what triangles enclose, and several as one."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, TypeAlias, final

import numpy as np

from mecanique.arrays import Array
from mecanique.errors import InputError
from mecanique.model.bodies import Body
from mecanique.model.bodies.body import Shape
from mecanique.model.bodies.tensor import entries_of
from mecanique.model.bodies.visuals import Visual
from mecanique.model.mechanism.validation import inertia_fault

Corners: TypeAlias = Array
"""Triangles by their corners, shape (m, 3, 3)."""


@final
@dataclass
class Mass:
    """Mass, center and inertia about it, in one frame."""

    mass: float
    center: Array
    inertia: Array
    axes: Array | None = None  # principal axes, where they are stated

    def move(self, pose: Array) -> Mass:
        """Return it in the frame in which its own has this pose."""
        turn, axes = pose[:3, :3], None if self.axes is None else pose[:3, :3] @ self.axes
        center, inertia = turn @ self.center + pose[:3, 3], turn @ self.inertia @ turn.T
        return Mass(self.mass, center, inertia, axes)

    def body(self, name: str, visuals: Sequence[Visual] = ()) -> Body:
        """Return a body with this mass, its inertia as given even if no real body has it."""
        x, y, z = self.center.tolist()
        entries: Any = entries_of(self.inertia)
        shape = Shape(self.mass, (x, y, z), entries, tuple(visuals))
        return Body(name, shape, as_given=bool(inertia_fault(self.mass, entries)))


def no_mass() -> Mass:
    """Return the mass of nothing."""
    return Mass(0.0, np.zeros(3), np.zeros((3, 3)))


def sum_masses(parts: Sequence[Mass]) -> Mass:
    """Return several masses as one, by Steiner's theorem."""
    if len(parts) == 1:
        return parts[0]
    total = sum(part.mass for part in parts)
    if not total > 0:
        return no_mass()
    center = sum((part.mass * part.center for part in parts), np.zeros(3)) / total
    inertia = np.zeros((3, 3))
    for part in parts:
        arm = part.center - center
        # Steiner's theorem
        inertia += part.inertia + part.mass * ((arm @ arm) * np.eye(3) - np.outer(arm, arm))
    return Mass(total, center, inertia)


def solid_of(form: str, size: Array) -> tuple[float, Array]:
    """Return volume, and squares of the radii of gyration about the axes, by half the sizes."""
    a, b, c = size
    match form:
        case "sphere":
            return 4 / 3 * math.pi * a**3, np.full(3, 2 / 5 * a**2)
        case "ellipsoid":
            return 4 / 3 * math.pi * a * b * c, moments_of_squares(size**2) / 5
        case "box":
            return 8 * a * b * c, moments_of_squares(size**2) / 3
        case "cylinder":
            across = a * a / 4 + b * b / 3
            return 2 * math.pi * a * a * b, np.array([across, across, a * a / 2])
    # a capsule: a cylinder and two halves of a ball, whose centers lie 3/8 r beyond its ends
    tube, ball = 2 * math.pi * a * a * b, 4 / 3 * math.pi * a**3
    across = tube * (a * a / 4 + b * b / 3) + ball * (2 / 5 * a * a + b * b + 3 / 4 * a * b)
    along = tube * a * a / 2 + ball * 2 / 5 * a * a
    return tube + ball, np.array([across, across, along]) / (tube + ball)


def moments_of_squares(squares: Array) -> Array:
    """Return moments about the axes from second moments along them."""
    return np.asarray(squares.sum() - squares)


def pyramids(corners: Corners, apex: Array) -> Array:
    """Return the volumes of the pyramids from an apex over triangles, negative from behind."""
    a, b, c = np.moveaxis(corners - apex, 1, 0)
    return np.asarray(np.einsum("mi,mi->m", a, np.cross(b, c)) / 6)


def inertia_of(arms: Corners, weights: Array, *, shell: bool = False) -> Array:
    """Return the inertia of pyramids over triangles, or of these alone, about their apex."""
    # ∫ x xᵀ is m (Σ a aᵀ + s sᵀ)/20 of a pyramid with corners a and their sum s, and m (…)/12 of a
    # triangle
    sums = arms.sum(axis=1)
    squares = np.einsum("m,mi,mj->ij", weights, sums, sums)
    squares += np.einsum("m,mci,mcj->ij", weights, arms, arms)
    squares /= 12 if shell else 20
    return np.asarray(np.trace(squares) * np.eye(3) - squares)


def hull_of(points: Array) -> Corners:
    """Return the convex hull's triangles, counterclockwise from outside."""
    from scipy.spatial import ConvexHull, QhullError

    try:
        hull = ConvexHull(points)
    except (QhullError, ValueError) as error:
        reason = str(error).split("\n", 1)[0]
        raise InputError(f"the mesh has no convex hull ({reason})") from None
    corners = points[hull.simplices]
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    inwards = np.einsum("mi,mi->m", normals, hull.equations[:, :3]) < 0
    corners[inwards] = corners[inwards][:, ::-1]
    return np.asarray(corners)
