"""What a body looks like."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Literal, TypeAlias, final

import numpy as np

from mecanique.errors import InputError
from mecanique.model.expression import Scalar, Vector, finite, plain
from mecanique.model.placement import Placement, carry, is_zero, rotate, rpy_of, vector

Rgba: TypeAlias = "tuple[float, float, float, float]"

_MOST = 1e100
"""Squares of lengths up to it, times any mass up to it, are floats [m], [kg]."""


def extent(size: Scalar, what: str, unit: str = "m") -> Scalar:
    """Return a radius, edge, length or mass as a plain scalar; letters may have any value."""
    size = plain(size)
    if isinstance(size, float) and not 0 <= size <= _MOST:
        raise InputError(f"expected a {what} from 0 to {_MOST:g} {unit}, got {size:g}")
    return size


def extents(edges: Vector, what: str) -> tuple[Scalar, Scalar, Scalar]:
    """Return three edges as plain scalars, as `extent` does; edges (3,)."""
    a, b, c = (extent(edge, f"{what}'s edge") for edge in vector(edges, f"size of a {what}"))
    return a, b, c


@final
@dataclass(frozen=True)
class Box:
    """A box about its center.

    Args:
        size: shape (3,), edges along x, y, z [m].

    Example:
        >>> panel = mq.Visual(mq.Box((0.4, 0.2, 0.02)), rgba=(0.9, 0.6, 0.0, 1.0))
        >>> mq.Body("panel", mq.massless(panel)).visuals[0].geometry
        Box(size=(0.4, 0.2, 0.02))
    """

    size: tuple[Scalar, Scalar, Scalar]

    def __post_init__(self) -> None:
        object.__setattr__(self, "size", extents(self.size, "box"))


@final
@dataclass(frozen=True)
class Cylinder:
    """A cylinder about its center, along z.

    Args:
        radius: [m].
        length: [m].

    Example:
        >>> pipe = mq.Visual(mq.Cylinder(0.05, 0.4), mq.Placement(rpy=(0, 1.5708, 0)))
        >>> mq.massless(pipe).visuals[0].geometry
        Cylinder(radius=0.05, length=0.4)
    """

    radius: Scalar
    length: Scalar

    def __post_init__(self) -> None:
        object.__setattr__(self, "radius", extent(self.radius, "radius"))
        object.__setattr__(self, "length", extent(self.length, "length"))


@final
@dataclass(frozen=True)
class Sphere:
    """A sphere about its center.

    Args:
        radius: [m].

    Example:
        >>> mark = mq.Visual(mq.Sphere(0.03), mq.Placement((0, 0, -0.4)), rgba=(1, 0, 0, 1))
        >>> mark.geometry.radius
        0.03
    """

    radius: Scalar

    def __post_init__(self) -> None:
        object.__setattr__(self, "radius", extent(self.radius, "radius"))


@final
@dataclass(frozen=True)
class Mesh:
    """A surface in a file.

    Args:
        uri: as it is written in the URDF.
        path: the file it was found at, if it was.
        scale: shape (3,), factors along x, y, z.

    Example:
        >>> millimetres = (0.001, 0.001, 0.001)
        >>> link = mq.Visual(mq.Mesh("package://arm/meshes/link.stl", scale=millimetres))
        >>> link.geometry.scale
        (0.001, 0.001, 0.001)
    """

    uri: str
    path: Path | None = None
    scale: tuple[float, float, float] = (1.0, 1.0, 1.0)

    def __post_init__(self) -> None:
        scale = tuple(finite(x, "scale of a mesh") for x in vector(self.scale, "scale of a mesh"))
        object.__setattr__(self, "scale", scale)


Geometry: TypeAlias = Box | Cylinder | Sphere | Mesh

GeometryKind: TypeAlias = Literal["box", "cylinder", "sphere", "mesh"]


def measure(geometry: Geometry) -> tuple[GeometryKind, tuple[Scalar, ...]]:
    """Return what a geometry is, and its edges, radius and length, radius, or scale."""
    match geometry:
        case Box(edges):
            return "box", edges
        case Cylinder(radius, length):
            return "cylinder", (radius, length)
        case Sphere(radius):
            return "sphere", (radius,)
        case Mesh(scale=scale):
            return "mesh", scale


@final
@dataclass(frozen=True)
class Visual:
    """A geometry at its place in a body, in a color.

    Args:
        geometry: what is drawn.
        placement: where, in the body's frame.
        rgba: red, green, blue, opacity, each from 0 to 1; None leaves a mesh its own colors.
        name: as in a URDF; may be empty.

    Example:
        >>> cube = mq.Box((0.2, 0.2, 0.2))
        >>> blue = mq.Visual(cube, mq.Placement((0, 0, 0.1)), rgba=(0.2, 0.4, 0.9, 1.0))
        >>> mq.Body("block", mq.Shape(2.0, visuals=(blue,))).visuals[0].rgba
        (0.2, 0.4, 0.9, 1.0)
    """

    geometry: Geometry
    placement: Placement = field(default_factory=Placement)
    rgba: Rgba | None = None
    name: str = ""

    def __post_init__(self) -> None:
        if not isinstance(self.geometry, Geometry):
            raise InputError(f"expected a Box, Cylinder, Sphere or Mesh, got {self.geometry!r}")
        if not isinstance(self.placement, Placement):
            raise InputError(f"expected a Placement of a visual, got {self.placement!r}")
        if self.rgba is not None:
            if not isinstance(self.rgba, Iterable) or len(rgba := tuple(self.rgba)) != 4:
                raise InputError(
                    f"expected red, green, blue and opacity from 0 to 1, got {self.rgba!r}"
                )
            rgba = tuple(finite(share, "a color's share") for share in rgba)
            object.__setattr__(self, "rgba", rgba)

    def at(self, place: Placement) -> Visual:
        """Return the visual moved with a shape.

        Args:
            place: where the shape's frame goes in the body.
        """
        rpy = _compose(place, self.placement)
        return replace(self, placement=Placement(carry(place, self.placement.xyz), rpy))


def _compose(outer: Placement, inner: Placement) -> tuple[Scalar, Scalar, Scalar]:
    """Roll, pitch, yaw of two turns in a row."""
    if all(map(is_zero, outer.rpy)):
        return inner.rpy
    if all(map(is_zero, inner.rpy)):
        return outer.rpy
    if all(isinstance(angle, float) for angle in (*outer.rpy, *inner.rpy)):
        return rpy_of(np.array(outer.rotation, float) @ np.array(inner.rotation, float))
    from sympy import atan2, sqrt

    columns = [rotate(outer.rotation, column) for column in zip(*inner.rotation, strict=True)]
    (r00, r10, r20), (_, _, r21), (_, _, r22) = columns
    return atan2(r21, r22), atan2(-r20, sqrt(r00**2 + r10**2)), atan2(r10, r00)
