"""Forces: what acts on the bodies besides gravity and the reactions.

Every scalar may be a number or an expression in parameters, inputs, the generalized coordinates q,
their velocities q' and time t. Points are given in the frame of the body they belong to.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TypeAlias, final

from mecanique.model.expression import Scalar, plain
from mecanique.model.placement import vector

__all__ = [
    "AnyForce",
    "Damper",
    "Force",
    "JointDamper",
    "JointForce",
    "JointSpring",
    "Spring",
    "Torque",
]

Point: TypeAlias = "tuple[Scalar, Scalar, Scalar]"


@final
@dataclass(frozen=True)
class Spring:
    """A linear spring between two points: it pulls with k (length − free length).

    Args:
        name: its name.
        body_a: name of one body.
        point_a: shape (3,), in the frame of body a [m].
        body_b: name of the other body.
        point_b: shape (3,), in the frame of body b [m].
        stiffness: k [N/m].
        free_length: length without force [m].
    """

    name: str
    body_a: str
    point_a: Point
    body_b: str
    point_b: Point
    stiffness: Scalar
    free_length: Scalar = 0.0

    def __post_init__(self) -> None:
        _plain_fields(self, points=("point_a", "point_b"), scalars=("stiffness", "free_length"))


@final
@dataclass(frozen=True)
class Damper:
    """A linear damper between two points: it resists with c times the rate of the length.

    Args:
        name: its name.
        body_a: name of one body.
        point_a: shape (3,), in the frame of body a [m].
        body_b: name of the other body.
        point_b: shape (3,), in the frame of body b [m].
        damping: c [N·s/m].
    """

    name: str
    body_a: str
    point_a: Point
    body_b: str
    point_b: Point
    damping: Scalar

    def __post_init__(self) -> None:
        _plain_fields(self, points=("point_a", "point_b"), scalars=("damping",))


@final
@dataclass(frozen=True)
class JointSpring:
    """A linear spring in a joint with one coordinate: force −k (coordinate − reference).

    Args:
        name: its name.
        joint: name of a revolute or prismatic joint.
        stiffness: k [N·m/rad or N/m].
        reference: the joint coordinate without force [rad or m].
    """

    name: str
    joint: str
    stiffness: Scalar
    reference: Scalar = 0.0

    def __post_init__(self) -> None:
        _plain_fields(self, scalars=("stiffness", "reference"))


@final
@dataclass(frozen=True)
class JointDamper:
    """A linear damper in a joint with one coordinate: force −c times its rate.

    Args:
        name: its name.
        joint: name of a revolute or prismatic joint.
        damping: c [N·m·s/rad or N·s/m].
    """

    name: str
    joint: str
    damping: Scalar

    def __post_init__(self) -> None:
        _plain_fields(self, scalars=("damping",))


@final
@dataclass(frozen=True)
class Force:
    """A force at a point of a body; nothing takes the reaction.

    Args:
        name: its name.
        body: name of the body.
        point: shape (3,), in the body's frame [m].
        force: shape (3,), components [N].
        axes: the body in whose axes the components are; "world" for fixed axes.
    """

    name: str
    body: str
    point: Point
    force: tuple[Scalar, Scalar, Scalar]
    axes: str = "world"

    def __post_init__(self) -> None:
        _plain_fields(self, points=("point", "force"))


@final
@dataclass(frozen=True)
class Torque:
    """A pure torque on a body; nothing takes the reaction.

    Args:
        name: its name.
        body: name of the body.
        torque: shape (3,), components [N·m].
        axes: the body in whose axes the components are; "world" for fixed axes.
    """

    name: str
    body: str
    torque: tuple[Scalar, Scalar, Scalar]
    axes: str = "world"

    def __post_init__(self) -> None:
        _plain_fields(self, points=("torque",))


@final
@dataclass(frozen=True)
class JointForce:
    """A drive in a joint with one coordinate, between parent and child.

    Args:
        name: its name.
        joint: name of a revolute or prismatic joint.
        force: along or about the joint's axis, on the child [N or N·m].
    """

    name: str
    joint: str
    force: Scalar

    def __post_init__(self) -> None:
        _plain_fields(self, scalars=("force",))


AnyForce: TypeAlias = Spring | Damper | JointSpring | JointDamper | Force | Torque | JointForce


def _plain_fields(
    force: AnyForce, points: tuple[str, ...] = (), scalars: tuple[str, ...] = ()
) -> None:
    for field in points:
        value = vector(getattr(force, field), f"{field} of {force.name!r}")
        object.__setattr__(force, field, value)
    for field in scalars:
        object.__setattr__(force, field, plain(getattr(force, field)))
