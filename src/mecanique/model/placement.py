"""Where one frame stands in another."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any, TypeAlias, final

import numpy as np
from numpy.typing import ArrayLike

from mecanique.arrays import Array
from mecanique.errors import InputError
from mecanique.model.expression import Scalar, Vector, plain

Matrix3: TypeAlias = "tuple[tuple[Scalar, Scalar, Scalar], ...]"
"""Three rows of three scalars."""

_UPRIGHT = 1e-15
"""Cosine of the pitch, of the size of rounding, below which roll and yaw turn about one axis."""

_SHORTEST = 1e-12
"""Vectors up to this length, such as a product of parallel ones, have no direction."""


@final
@dataclass(frozen=True)
class Placement:
    """Pose of a frame in its parent: turned by roll, pitch, yaw about fixed x, y, z, then moved.

    Args:
        xyz: shape (3,), position of the origin [m].
        rpy: shape (3,), roll, pitch and yaw [rad], as in URDF.

    Raises:
        InputError: if one of them has not three components.

    Example:
        >>> mq.Placement((0, 0, 1.0), (0, 0, mq.Parameter("alpha", 0.3, "rad"))).rotation
        ((cos(alpha), -sin(alpha), 0), (sin(alpha), cos(alpha), 0), (0, 0, 1))
    """

    xyz: tuple[Scalar, Scalar, Scalar] = (0.0, 0.0, 0.0)
    rpy: tuple[Scalar, Scalar, Scalar] = (0.0, 0.0, 0.0)

    def __post_init__(self) -> None:
        object.__setattr__(self, "xyz", vector(self.xyz, "position xyz"))
        object.__setattr__(self, "rpy", vector(self.rpy, "angles rpy"))

    @property
    def rotation(self) -> Matrix3:
        """Rotation matrix, rows of scalars."""
        return rpy_rotation(self.rpy)


def vector(components: Vector, what: str) -> tuple[Scalar, Scalar, Scalar]:
    """Return three components as plain scalars; components (3,)."""
    try:
        x, y, z = components
    except (TypeError, ValueError):
        raise InputError(f"expected three components for {what}, got {components!r}") from None
    return plain(x), plain(y), plain(z)


def unit_vector(components: Array | Vector, what: str) -> tuple[float, float, float]:
    """Return three numbers, in any length but zero, as a vector of unit length; components (3,)."""
    try:
        x, y, z = (float(component) for component in components)
    except (TypeError, ValueError):
        raise InputError(f"expected three numbers for {what}, got {components!r}") from None
    length = math.hypot(x, y, z)
    if not _SHORTEST < length < math.inf:
        raise InputError(f"expected a finite vector with a length for {what}, got {components!r}")
    return x / length, y / length, z / length


def rpy_along(axis: tuple[float, float, float]) -> tuple[float, float, float]:
    """Return the roll, pitch and yaw that turn z to an axis, without any roll."""
    x, y, z = axis
    return 0.0, math.atan2(math.hypot(x, y), z), math.atan2(y, x)


def rpy_rotation(rpy: Vector) -> Matrix3:
    """Return the rotation matrix Rz(yaw) Ry(pitch) Rx(roll) (URDF specification, `origin`).

    Shapes: rpy (3,).
    """
    (cr, sr), (cp, sp), (cy, sy) = (_cos_sin(angle) for angle in rpy)
    return (
        (cy * cp, cy * sp * sr - sy * cr, cy * sp * cr + sy * sr),
        (sy * cp, sy * sp * sr + cy * cr, sy * sp * cr - cy * sr),
        (-sp, cp * sr, cp * cr),
    )


def rpy_of(turn: Array) -> tuple[float, float, float]:
    """Return roll, pitch and yaw of a rotation matrix; roll is zero where only two count.

    Shapes: turn (3, 3).
    """
    (a, d, g), (b, e, h), (c, s, k) = turn.tolist()
    level = math.hypot(a, b)
    roll = math.atan2(s, k) if level >= _UPRIGHT else 0.0
    # near a pitch of a quarter turn only the sum of roll and yaw is well determined: yaw follows
    # from what roll leaves of the matrix, not from the small entries a and b
    cr, sr = math.cos(roll), math.sin(roll)
    yaw = math.atan2(sr * g - cr * d, cr * e - sr * h)
    return roll, math.atan2(-c, level), yaw


def pose_of(place: Placement) -> Array:
    """Return a placement in numbers as a homogeneous matrix, shape (4, 4)."""
    return pose_at(place.xyz, place.rotation)


def pose_at(shift: ArrayLike = 0.0, turn: ArrayLike | None = None) -> Array:
    """Return the homogeneous matrix of a shift (3,) after a turn (3, 3), shape (4, 4)."""
    pose = np.eye(4)
    pose[:3, 3] = shift
    if turn is not None:
        pose[:3, :3] = turn
    return pose


def turn_about(axis: Array | Vector, angle: Scalar, functions: Any = math) -> Array:
    """Rodrigues' formula, R = 1 + sin α K + (1 − cos α) K², in numbers or by sympy in letters."""
    x, y, z = unit_vector(axis, "the axis of a turn")
    k = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
    return np.asarray(np.eye(3) + functions.sin(angle) * k + (1 - functions.cos(angle)) * k @ k)


def pose_along(axis: Array, at: float, turns: bool) -> Array:
    """Return where a joint's frame stands after a turn about its axis or a shift along it."""
    return pose_at(turn=turn_about(axis, at)) if turns else pose_at(at * axis)


def carry(place: Placement, point: Vector) -> tuple[Scalar, Scalar, Scalar]:
    """Return a point of a frame as one of its parent; point (3,)."""
    x, y, z = (p + q for p, q in zip(place.xyz, rotate(place.rotation, point), strict=True))
    return x, y, z


def rotate(matrix: Matrix3, components: Vector) -> tuple[Scalar, Scalar, Scalar]:
    """Return matrix times vector, both of scalars; matrix (3, 3), components (3,)."""
    x, y, z = (_dot(row, components) for row in matrix)
    return x, y, z


def _dot(row: Vector, components: Vector) -> Scalar:
    total: Any = 0
    for a, b in zip(row, components, strict=True):
        if not is_zero(a):
            total = total + a * b
    return total


def is_zero(scalar: Scalar) -> bool:
    """Return whether a scalar is the number zero."""
    return isinstance(scalar, (int, float)) and scalar == 0


def _cos_sin(angle: Scalar) -> tuple[Any, Any]:
    """Cosine and sine, exact at multiples of a quarter turn, as a description means them."""
    angle = plain(angle)
    if not isinstance(angle, float):
        from sympy import cos, sin

        return cos(angle), sin(angle)
    quarters = angle / (math.pi / 2)
    nearest = round(quarters) if math.isfinite(quarters) else 0
    if math.isfinite(quarters) and abs(quarters - nearest) < 1e-15 * max(1, abs(nearest)):
        return ((1, 0), (0, 1), (-1, 0), (0, -1))[nearest % 4]
    return math.cos(angle), math.sin(angle)
