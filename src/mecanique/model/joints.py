"""Joints: how a child body may move against its parent.

A joint's frame stands in its parent at `origin`; the child's frame coincides with it when the
joint's coordinates are zero. Velocities are the rates of the coordinates, except for `Spherical`
and `Floating`, whose positions hold a unit quaternion and whose velocities are components in the
child's axes (nq ≠ nv), as in Pinocchio.

A joint is a chain of elementary motions; its coordinates, their kinds and its velocities follow
from the chain. Ask the joint for them rather than for its type.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import ClassVar, TypeAlias, final

from mecanique.errors import InputError
from mecanique.model.expression import Scalar, plain
from mecanique.model.expression import coordinate as symbol
from mecanique.model.joint_base import (
    BaseJoint,
    Elementary,
    Several,
    Single,
    set_axis,
)

_X, _Y, _Z = (1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0)


@final
@dataclass(frozen=True)
class Fixed(BaseJoint):
    """The child is welded to its parent.

    Args:
        name: its name, as in URDF.
        parent: name of the parent body.
        child: name of the child body.
        origin: where the joint's frame stands in the parent.

    Example:
        >>> camera = mq.Fixed("mount", "arm", "camera", origin=mq.Placement((0, 0, 0.2)))
        >>> camera.nq
        0
    """

    @property
    def chain(self) -> tuple[Elementary, ...]:
        """No motion."""
        return (Elementary("fixed"),)

    def renamed(self, names: tuple[str, ...]) -> Fixed:
        """Return the joint itself: it has no coordinates."""
        return self


@final
@dataclass(frozen=True)
class Revolute(Single):
    """A hinge: the child turns about an axis by its coordinate [rad].

    Args:
        name: its name, as in URDF.
        parent: name of the parent body.
        child: name of the child body.
        origin: where the joint's frame stands in the parent.
        axis: shape (3,), in the joint's frame; numbers, any length but zero.
        coordinate: name of its coordinate; the joint's own name by default.
        limits: bounds, if any.
        armature: inertia of the drive's rotor seen at the joint [kg·m²].

    Example:
        >>> hinge = mq.Revolute("hinge", "ground", "rod", axis=(0, -1, 0), coordinate="q")
        >>> hinge.coordinates, hinge.velocities
        (('q',), ("q'",))
    """

    noun: ClassVar[str] = "hinge"

    @property
    def chain(self) -> tuple[Elementary, ...]:
        """A turn."""
        return (Elementary("turn", (self.coordinate,), self.axis),)


@final
@dataclass(frozen=True)
class Prismatic(Single):
    """A slide: the child moves along an axis by its coordinate [m].

    Args:
        name: its name, as in URDF.
        parent: name of the parent body.
        child: name of the child body.
        origin: where the joint's frame stands in the parent.
        axis: shape (3,), in the joint's frame; numbers, any length but zero.
        coordinate: name of its coordinate; the joint's own name by default.
        limits: bounds, if any.
        armature: inertia of the drive's rotor seen at the joint [kg].

    Example:
        >>> slide = mq.Prismatic("slide", "ground", "piston", axis=(1, 0, 0), coordinate="x")
        >>> slide.coordinates, slide.velocities
        (('x',), ("x'",))
    """

    noun: ClassVar[str] = "slide"

    @property
    def chain(self) -> tuple[Elementary, ...]:
        """A slide."""
        return (Elementary("slide", (self.coordinate,), self.axis),)


@final
@dataclass(frozen=True)
class Helical(Single):
    """A screw: the child turns about an axis by its coordinate [rad] and advances as it turns.

    The travel along the axis [m], pitch times the angle, is a coordinate of its own that follows,
    `<coordinate>_travel` (R. S. Ball, A Treatise on the Theory of Screws, 1900, ch. I). A force in
    the joint is a moment about the axis; the thread adds no friction.

    Args:
        name: its name, as in URDF.
        parent: name of the parent body.
        child: name of the child body.
        origin: where the joint's frame stands in the parent.
        axis: shape (3,), in the joint's frame; numbers, any length but zero.
        coordinate: name of its coordinate; the joint's own name by default.
        limits: bounds, if any.
        armature: inertia of the drive's rotor seen at the joint [kg·m²].
        pitch: advance along the axis per radian [m/rad], a number other than zero or an expression
            in parameters; a thread of lead l has l/2π, a left-handed one a negative pitch.

    Example:
        >>> press = mq.textbook.load("screw_press")
        >>> screw = press.joints[0]
        >>> screw.pitch, dict(screw.followers)
        (p, {'theta_travel': p*theta})
    """

    pitch: Scalar = field(default=0.0, kw_only=True)
    noun: ClassVar[str] = "screw"

    def __post_init__(self) -> None:
        super().__post_init__()
        object.__setattr__(self, "pitch", plain(self.pitch))
        if isinstance(self.pitch, float) and not 0 < abs(self.pitch) < float("inf"):
            raise InputError(
                f"joint {self.name!r}: expected a finite pitch other than zero [m/rad], "
                f"got {self.pitch:g}; a hinge is a Revolute"
            )

    @property
    def chain(self) -> tuple[Elementary, ...]:
        """A slide that follows, then the turn."""
        angle, travel = self.coordinate, f"{self.coordinate}_travel"
        follows = self.pitch * symbol(angle)
        return (
            Elementary("slide", (travel,), self.axis, part="travel", follows=follows),
            Elementary("turn", (angle,), self.axis),
        )


@final
@dataclass(frozen=True)
class Planar(Several):
    """The child moves in a plane: x and y along its axes, then a turn by θ about the normal.

    The plane's axes are the joint frame's x and y when the normal is z; in general they are those
    that the smallest turn from z to the normal gives (for the normal −y: x and z).

    Args:
        name: its name, as in URDF.
        parent: name of the parent body.
        child: name of the child body.
        origin: where the joint's frame stands in the parent.
        names: names of its coordinates in order; `<joint>_x`, `_y` and `_theta` by default.
        axis: shape (3,), normal of the plane in the joint's frame.

    Example:
        >>> puck = mq.Planar("table", "ground", "puck", names=("x", "y", "turn"))
        >>> puck.coordinates
        ('x', 'y', 'turn')
    """

    axis: tuple[float, float, float] = field(default=_Z, kw_only=True)
    _suffixes: ClassVar[tuple[str, ...]] = ("x", "y", "theta")

    def __post_init__(self) -> None:
        super().__post_init__()
        set_axis(self, self.axis)

    @property
    def directions(self) -> tuple[tuple[float, float, float], tuple[float, float, float]]:
        """The plane's two axes in the joint's frame, each shape (3,)."""
        x, y, z = self.axis
        across = x * x + y * y
        if z <= 0 and across == 0:
            return (1.0, 0.0, 0.0), (0.0, -1.0, 0.0)
        # both are the same for a unit axis; the second does not cancel near −z
        k = 1 / (1 + z) if z > 0 else (1 - z) / across
        return (1 - k * x * x, -k * x * y, -x), (-k * x * y, 1 - k * y * y, -y)

    @property
    def chain(self) -> tuple[Elementary, ...]:
        """Two slides and a turn."""
        x, y, theta = self.names
        along, across = self.directions
        return (
            Elementary("slide", (x,), along, part="x"),
            Elementary("slide", (y,), across, part="y"),
            Elementary("turn", (theta,), self.axis),
        )


@final
@dataclass(frozen=True)
class Universal(Several):
    """A Cardan joint: a turn about x, then one about the turned y [rad].

    Args:
        name: its name, as in URDF.
        parent: name of the parent body.
        child: name of the child body.
        origin: where the joint's frame stands in the parent.
        names: names of its coordinates in order; `<joint>_rx` and `_ry` by default.

    Example:
        >>> cardan = mq.Universal("cardan", "shaft", "axle", names=("alpha", "beta"))
        >>> cardan.coordinates
        ('alpha', 'beta')
    """

    _suffixes: ClassVar[tuple[str, ...]] = ("rx", "ry")

    @property
    def chain(self) -> tuple[Elementary, ...]:
        """Two turns."""
        rx, ry = self.names
        return Elementary("turn", (rx,), _X, part="x"), Elementary("turn", (ry,), (0.0, 1.0, 0.0))


@final
@dataclass(frozen=True)
class Spherical(Several):
    """A ball joint: a unit quaternion (x, y, z, w).

    Velocities are the angular velocity in the child's axes [rad/s].

    Args:
        name: its name, as in URDF.
        parent: name of the parent body.
        child: name of the child body.
        origin: where the joint's frame stands in the parent.
        names: names of its coordinates in order; `<joint>_qx` and so on by default.

    Example:
        >>> shoulder = mq.Spherical("shoulder", "trunk", "arm")
        >>> shoulder.coordinates
        ('shoulder_qx', 'shoulder_qy', 'shoulder_qz', 'shoulder_qw')
        >>> shoulder.velocities
        ('shoulder_wx', 'shoulder_wy', 'shoulder_wz')
    """

    _suffixes: ClassVar[tuple[str, ...]] = ("qx", "qy", "qz", "qw")

    @property
    def chain(self) -> tuple[Elementary, ...]:
        """A turn about a point."""
        return (Elementary("ball", self.names, quasi=tuple(f"{self.name}_w{k}" for k in "xyz")),)


@final
@dataclass(frozen=True)
class Floating(Several):
    """The child is free: position (x, y, z) [m] and unit quaternion (x, y, z, w).

    Velocities are the child origin's velocity [m/s], then the angular velocity [rad/s], both in the
    child's axes.

    Args:
        name: its name, as in URDF.
        parent: name of the parent body.
        child: name of the child body.
        origin: where the joint's frame stands in the parent.
        names: names of its coordinates in order; `<joint>_x` … `_qw` by default.

    Example:
        >>> drone = mq.Floating("air", "ground", "drone")
        >>> drone.nq, drone.nv
        (7, 6)
        >>> drone.coordinates
        ('air_x', 'air_y', 'air_z', 'air_qx', 'air_qy', 'air_qz', 'air_qw')
    """

    _suffixes: ClassVar[tuple[str, ...]] = ("x", "y", "z", "qx", "qy", "qz", "qw")

    @property
    def chain(self) -> tuple[Elementary, ...]:
        """Any motion."""
        quasi = tuple(f"{self.name}_{what}{k}" for what in "vw" for k in "xyz")
        return (Elementary("free", self.names, quasi=quasi),)


Joint: TypeAlias = (
    Fixed | Revolute | Prismatic | Helical | Planar | Universal | Spherical | Floating
)
"""Any joint.

Example:
    >>> joints = mq.textbook.load("cart_pole").joints
    >>> all(isinstance(joint, mq.Joint) for joint in joints)
    True
    >>> [joint.coordinates for joint in joints]
    [('x',), ('q',)]
"""
