"""What joints have in common: a chain of elementary motions, names, an axis where there is one."""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import ClassVar, Literal, TypeAlias, TypeVar, final

from mecanique.errors import InputError
from mecanique.model.expression import Scalar, Vector, plain
from mecanique.model.placement import Placement, vector

_J = TypeVar("_J", bound="BaseJoint")
_S = TypeVar("_S", bound="Single")
_N = TypeVar("_N", bound="Several")

Kind: TypeAlias = Literal["linear", "angular", "quaternion"]
"""What a coordinate or a velocity is: a length, an angle, or a component of a unit quaternion."""

UNITS: Mapping[Kind, str] = {"linear": "m", "angular": "rad", "quaternion": "1"}
"""SI unit of each kind of coordinate; velocities have it per second."""

_COORDINATES: Mapping[str, tuple[Kind, ...]] = {
    "fixed": (),
    "turn": ("angular",),
    "slide": ("linear",),
    "ball": ("quaternion",) * 4,
    "free": ("linear",) * 3 + ("quaternion",) * 4,
}
"""What the coordinates of each motion are."""

_VELOCITIES: Mapping[str, tuple[Kind, ...]] = {
    "fixed": (),
    "turn": ("angular",),
    "slide": ("linear",),
    "ball": ("angular",) * 3,
    "free": ("linear",) * 3 + ("angular",) * 3,
}
"""What the velocities of each motion are."""


@final
@dataclass(frozen=True)
class Elementary:
    """One of the elementary motions that a joint is a chain of.

    Args:
        kind: a turn about or a slide along an axis, a turn about a point, any motion, or none.
        coordinates: names of its coordinates.
        axis: shape (3,), unit axis of a turn or a slide, in the frame before it.
        quasi: names of its velocities where they are no rates of coordinates.
        part: what the joint's name is followed by in URDF, where the joint is a chain of several;
            empty for the last motion, which bears the joint's name.
        follows: what its coordinate is, in another coordinate of the joint, if it is not free.
    """

    kind: Literal["fixed", "turn", "slide", "ball", "free"]
    coordinates: tuple[str, ...] = ()
    axis: tuple[float, float, float] = (0.0, 0.0, 1.0)
    quasi: tuple[str, ...] = ()
    part: str = ""
    follows: Scalar | None = None

    @property
    def velocities(self) -> tuple[str, ...]:
        """Names of its velocities: q' for a coordinate q."""
        return self.quasi or tuple(f"{name}'" for name in self.coordinates)


_SLANT = 2e-12
"""An axis that leaves a coordinate axis by less means it [rad]."""


@final
@dataclass(frozen=True)
class Limits:
    """Bounds of a joint with one coordinate; URDF states them, the equations ignore them.

    Args:
        lower: least position [rad or m].
        upper: greatest position [rad or m].
        effort: greatest force or torque [N or N·m].
        velocity: greatest rate [rad/s or m/s].

    Example:
        >>> reach = mq.Limits(-0.5, 2.5, effort=40.0)
        >>> elbow = mq.Revolute("elbow", "upper arm", "forearm", limits=reach)
        >>> elbow.limits.upper
        2.5
    """

    lower: float = float("-inf")
    upper: float = float("inf")
    effort: float = float("inf")
    velocity: float = float("inf")

    def __post_init__(self) -> None:
        for name in ("lower", "upper", "effort", "velocity"):
            value = plain(getattr(self, name))
            if not isinstance(value, float) or math.isnan(value):
                raise InputError(f"expected a number for {name} of limits, got {value!r}")
            object.__setattr__(self, name, value)

    @property
    def bounded(self) -> bool:
        """Whether its position has a bound."""
        return self.lower > float("-inf") or self.upper < float("inf")


@dataclass(frozen=True)
class BaseJoint(ABC):
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

    def __post_init__(self) -> None:
        for what in ("name", "parent", "child"):
            if not isinstance(value := getattr(self, what), str):
                raise InputError(f"expected a text for the {what} of a joint, got {value!r}")
        if not isinstance(self.origin, Placement):
            raise InputError(
                f"joint {self.name!r}: expected a Placement for its origin, got {self.origin!r}"
            )

    @property
    @abstractmethod
    def chain(self) -> tuple[Elementary, ...]:
        """Its elementary motions, from the parent to the child; all else follows from them."""

    @abstractmethod
    def renamed(self: _J, names: tuple[str, ...]) -> _J:
        """Return the joint with other names for its coordinates."""

    @property
    def followers(self) -> Mapping[str, Scalar]:
        """Its coordinates that follow another of its own, by name; they join the coordinate map."""
        return {
            motion.coordinates[0]: motion.follows
            for motion in self.chain
            if motion.follows is not None
        }

    @property
    def coordinates(self) -> tuple[str, ...]:
        """Names of its position coordinates."""
        return tuple(name for motion in self.chain for name in motion.coordinates)

    @property
    def velocities(self) -> tuple[str, ...]:
        """Names of its velocities."""
        return tuple(name for motion in self.chain for name in motion.velocities)

    @property
    def nq(self) -> int:
        """Number of its coordinates."""
        return len(self.coordinates)

    @property
    def nv(self) -> int:
        """Number of its velocities."""
        return len(self.velocities)

    @property
    def kinds(self) -> tuple[Kind, ...]:
        """What each of its coordinates is."""
        return tuple(kind for motion in self.chain for kind in _COORDINATES[motion.kind])

    @property
    def linear_coordinates(self) -> tuple[str, ...]:
        """Names of its coordinates that are lengths."""
        return self._of_kind("linear")

    @property
    def angular_coordinates(self) -> tuple[str, ...]:
        """Names of its coordinates that are angles."""
        return self._of_kind("angular")

    @property
    def quaternion(self) -> tuple[str, ...]:
        """Names of the components (x, y, z, w) of its unit quaternion; empty if it has none."""
        return self._of_kind("quaternion")

    @property
    def linear_velocities(self) -> tuple[str, ...]:
        """Names of its velocities in m/s."""
        return self._moving("linear")

    @property
    def angular_velocities(self) -> tuple[str, ...]:
        """Names of its velocities in rad/s."""
        return self._moving("angular")

    def _of_kind(self, kind: Kind) -> tuple[str, ...]:
        pairs = zip(self.coordinates, self.kinds, strict=True)
        return tuple(name for name, its in pairs if its == kind)

    def _moving(self, kind: Kind) -> tuple[str, ...]:
        kinds = [its for motion in self.chain for its in _VELOCITIES[motion.kind]]
        pairs = zip(self.velocities, kinds, strict=True)
        return tuple(name for name, its in pairs if its == kind)


@dataclass(frozen=True)
class Single(BaseJoint):
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
    noun: ClassVar[str]

    def __post_init__(self) -> None:
        super().__post_init__()
        set_axis(self, self.axis)
        if not isinstance(self.coordinate, str):
            raise InputError(
                f"joint {self.name!r}: expected a text for its coordinate, got {self.coordinate!r}"
            )
        if not isinstance(self.limits, Limits | None):
            raise InputError(f"joint {self.name!r}: expected Limits, got {self.limits!r}")
        object.__setattr__(self, "coordinate", self.coordinate or self.name)
        object.__setattr__(self, "armature", plain(self.armature))

    def renamed(self: _S, names: tuple[str, ...]) -> _S:
        """Return the joint with another name for its coordinate."""
        return replace(self, coordinate=names[-1])

    @property
    def turns(self) -> bool:
        """Whether its coordinate is an angle, its force a moment about the axis."""
        return self.kinds[-1] == "angular"


@dataclass(frozen=True)
class Several(BaseJoint):
    """A joint with several coordinates.

    Args:
        names: names of its coordinates in order; `<joint>_x` and so on by default.
    """

    names: tuple[str, ...] = field(default=(), kw_only=True)
    _suffixes: ClassVar[tuple[str, ...]]

    def __post_init__(self) -> None:
        super().__post_init__()
        given = self.names if isinstance(self.names, (tuple, list)) else (self.names,)
        names = tuple(given) or tuple(f"{self.name}_{suffix}" for suffix in self._suffixes)
        if len(names) != len(self._suffixes) or not all(isinstance(name, str) for name in names):
            expected = ", ".join(self._suffixes)
            raise InputError(
                f"joint {self.name!r}: expected {len(self._suffixes)} names ({expected}), "
                f"got {names!r}"
            )
        object.__setattr__(self, "names", names)

    def renamed(self: _N, names: tuple[str, ...]) -> _N:
        """Return the joint with other names for its coordinates."""
        return replace(self, names=names)


def set_axis(joint: BaseJoint, axis: Vector) -> None:
    """Store the axis with unit length; one without length is left for the mechanism to report."""
    try:
        x, y, z = (float(component) for component in vector(axis, f"axis of joint {joint.name!r}"))
    except TypeError:
        raise InputError(
            f"expected three numbers for the axis of joint {joint.name!r}, got {axis!r}"
        ) from None
    length = (x * x + y * y + z * z) ** 0.5
    if 0 < length < float("inf"):
        x, y, z = _straighten((x / length, y / length, z / length) if length != 1 else (x, y, z))
    object.__setattr__(joint, "axis", (x, y, z))


def _straighten(axis: tuple[float, float, float]) -> tuple[float, float, float]:
    """Return the coordinate axis that a unit axis means, or the axis itself.

    CAD programs leave 1e-13 in components that mean 0, and parsers drop less than 1e-12.
    """
    rest = [abs(component) for component in axis if abs(component) < 0.5]
    if len(rest) < 2 or sum(rest) > _SLANT:
        return axis
    x, y, z = (float(round(component)) for component in axis)
    return x, y, z
