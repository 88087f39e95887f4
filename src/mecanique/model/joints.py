"""Joints: how a child body may move against its parent.

A joint's frame stands in its parent at `origin`; the child's frame coincides with it when the
joint's coordinates are zero. Velocities are the rates of the coordinates, except for `Spherical`
and `Floating`, whose positions hold a unit quaternion and whose velocities are components in the
child's axes (nq ≠ nv), as in Pinocchio.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import ClassVar, TypeAlias, final

from mecanique.errors import InputError
from mecanique.model.expression import Scalar, Vector, plain
from mecanique.model.placement import Placement, vector

__all__ = [
    "Fixed",
    "Floating",
    "Joint",
    "Limits",
    "Planar",
    "Prismatic",
    "Revolute",
    "Spherical",
    "Universal",
]


@final
@dataclass(frozen=True)
class Limits:
    """Bounds of a joint with one coordinate; they are written to URDF, the equations do not know them.

    Args:
        lower: least position [rad or m].
        upper: greatest position [rad or m].
        effort: greatest force or torque [N or N·m].
        velocity: greatest rate [rad/s or m/s].
    """

    lower: float = float("-inf")
    upper: float = float("inf")
    effort: float = float("inf")
    velocity: float = float("inf")


@dataclass(frozen=True)
class _Joint:
    """What all joints have.

    Args:
        name: its name, as in URDF.
        parent: name of the parent body.
        child: name of the child body.
        origin: where the joint's frame stands in the parent.
    """

    name: str
    parent: str
    child: str
    origin: Placement = field(default_factory=Placement, kw_only=True)

    @property
    def coordinates(self) -> tuple[str, ...]:
        """Names of its position coordinates."""
        return ()

    @property
    def velocities(self) -> tuple[str, ...]:
        """Names of its velocities: q' for a coordinate q."""
        return tuple(f"{name}'" for name in self.coordinates)


@final
@dataclass(frozen=True)
class Fixed(_Joint):
    """The child is welded to its parent."""


@dataclass(frozen=True)
class _Single(_Joint):
    """A joint with one coordinate along or about an axis.

    Args:
        axis: shape (3,), in the joint's frame; numbers, any length but zero.
        coordinate: name of its coordinate; the joint's own name by default.
        limits: bounds, if any.
        armature: inertia of the drive's rotor seen at the joint [kg·m² or kg].
    """

    axis: tuple[float, float, float] = field(default=(0.0, 0.0, 1.0), kw_only=True)
    coordinate: str = field(default="", kw_only=True)
    limits: Limits | None = field(default=None, kw_only=True)
    armature: Scalar = field(default=0.0, kw_only=True)

    def __post_init__(self) -> None:
        _set_axis(self, self.axis)
        object.__setattr__(self, "coordinate", self.coordinate or self.name)
        object.__setattr__(self, "armature", plain(self.armature))

    @property
    def coordinates(self) -> tuple[str, ...]:
        """Name of its coordinate."""
        return (self.coordinate,)


@final
@dataclass(frozen=True)
class Revolute(_Single):
    """A hinge: the child turns about an axis by its coordinate [rad]."""


@final
@dataclass(frozen=True)
class Prismatic(_Single):
    """A slide: the child moves along an axis by its coordinate [m]."""


@dataclass(frozen=True)
class _Named(_Joint):
    """A joint with several coordinates.

    Args:
        names: names of its coordinates in order; `<joint>_x` and so on by default.
    """

    names: tuple[str, ...] = field(default=(), kw_only=True)
    _suffixes: ClassVar[tuple[str, ...]]

    def __post_init__(self) -> None:
        names = tuple(self.names) or tuple(f"{self.name}_{suffix}" for suffix in self._suffixes)
        if len(names) != len(self._suffixes):
            expected = ", ".join(self._suffixes)
            raise InputError(
                f"joint {self.name!r}: expected {len(self._suffixes)} names ({expected}), got {names!r}"
            )
        object.__setattr__(self, "names", names)

    @property
    def coordinates(self) -> tuple[str, ...]:
        """Names of its coordinates."""
        return self.names


@final
@dataclass(frozen=True)
class Planar(_Named):
    """The child moves in a plane: x and y along the plane's axes, then it turns by θ about the normal.

    The plane's axes are the joint frame's x and y when the normal is z; in general they are those
    that the smallest turn from z to the normal gives (for the normal −y: x and z).

    Args:
        axis: shape (3,), normal of the plane in the joint's frame.
    """

    axis: tuple[float, float, float] = field(default=(0.0, 0.0, 1.0), kw_only=True)
    _suffixes: ClassVar[tuple[str, ...]] = ("x", "y", "theta")

    def __post_init__(self) -> None:
        super().__post_init__()
        _set_axis(self, self.axis)

    @property
    def directions(self) -> tuple[tuple[float, float, float], tuple[float, float, float]]:
        """The plane's two axes in the joint's frame, each shape (3,)."""
        x, y, z = self.axis
        across = x * x + y * y
        if z < 0 and across == 0:
            return (1.0, 0.0, 0.0), (0.0, -1.0, 0.0)
        # both are the same for a unit axis; the second does not cancel near −z
        k = 1 / (1 + z) if z > 0 else (1 - z) / across
        return (1 - k * x * x, -k * x * y, -x), (-k * x * y, 1 - k * y * y, -y)


@final
@dataclass(frozen=True)
class Universal(_Named):
    """A Cardan joint: the child turns by the first coordinate about x, then by the second about the turned y [rad]."""

    _suffixes: ClassVar[tuple[str, ...]] = ("rx", "ry")


@final
@dataclass(frozen=True)
class Spherical(_Named):
    """A ball joint: a unit quaternion (x, y, z, w); velocities are the angular velocity in the child's axes [rad/s]."""

    _suffixes: ClassVar[tuple[str, ...]] = ("qx", "qy", "qz", "qw")

    @property
    def velocities(self) -> tuple[str, ...]:
        """Names of the three components of the angular velocity, child's axes."""
        return tuple(f"{self.name}_w{axis}" for axis in "xyz")


@final
@dataclass(frozen=True)
class Floating(_Named):
    """The child is free: position (x, y, z) [m] and unit quaternion (x, y, z, w).

    Velocities are the child origin's velocity [m/s], then the angular velocity [rad/s], both in the
    child's axes.
    """

    _suffixes: ClassVar[tuple[str, ...]] = ("x", "y", "z", "qx", "qy", "qz", "qw")

    @property
    def velocities(self) -> tuple[str, ...]:
        """Names of the velocity's three components, then the angular velocity's, child's axes."""
        return tuple(f"{self.name}_{kind}{axis}" for kind in "vw" for axis in "xyz")


Joint: TypeAlias = Fixed | Revolute | Prismatic | Planar | Universal | Spherical | Floating


def _set_axis(joint: _Joint, axis: Vector) -> None:
    """Store the axis with unit length; one without length is left for the mechanism to report."""
    try:
        x, y, z = (float(component) for component in vector(axis, f"axis of joint {joint.name!r}"))
    except TypeError:
        raise InputError(
            f"expected three numbers for the axis of joint {joint.name!r}, got {axis!r}"
        ) from None
    length = (x * x + y * y + z * z) ** 0.5
    unit = (
        (x / length, y / length, z / length)
        if 0 < length < float("inf") and length != 1
        else (x, y, z)
    )
    object.__setattr__(joint, "axis", unit)
