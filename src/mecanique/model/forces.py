"""Forces: all actions on the bodies besides gravity and the reactions.

Every scalar may be a number or an expression in parameters, inputs, the generalized coordinates q,
their velocities q' and time t. Points are given in the frame of the body they belong to.

A force acts in one of three ways, its base class: along the line between two points (`LineLoad`),
in a joint (`JointLoad`) or on one body (`BodyLoad`). It describes itself, who, where and with which
expressions; what it does, its law, is written twice, in `mecanique.derivation.laws` and in
`mecanique.reference.engine.forces.laws`, independently.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field, fields
from typing import Any, ClassVar, Literal, TypeAlias, final

from mecanique.model.expression import Scalar, plain, symbols_in
from mecanique.model.placement import vector

__all__ = [
    "AnyForce",
    "BodyLoad",
    "Damper",
    "End",
    "Force",
    "ForceKind",
    "JointDamper",
    "JointForce",
    "JointLoad",
    "JointSpring",
    "LineLoad",
    "Spring",
    "Stated",
    "Torque",
    "WrenchOnBody",
    "loads_in",
]

Point: TypeAlias = "tuple[Scalar, Scalar, Scalar]"

ForceKind: TypeAlias = Literal["spring", "damper", "load"]
"""What a force is called and drawn as."""


@final
@dataclass(frozen=True)
class Stated:
    """What one field of a force states.

    Args:
        name: of the field in words, e.g. "free length".
        scalars: one, or three components.
        varies: whether it may depend on the state, time and inputs, not on parameters alone.
        positive: whether it must not be negative.
        length: whether it is a length or a point [m].
        units: its unit; of a force in a joint, on a slide and about an axis.
    """

    name: str
    scalars: tuple[Scalar, ...]
    varies: bool
    positive: bool
    length: bool
    units: tuple[str, ...]


_Trait: TypeAlias = Mapping[str, Any]
"""Metadata of a field that states scalars."""

_CONSTANT: _Trait = {"vector": False, "varies": False, "positive": False, "length": False}
_LENGTH = {**_CONSTANT, "positive": True, "length": True, "units": ("m",)}
_POINT = {**_CONSTANT, "vector": True, "length": True, "units": ("m",)}


def _constant(*units: str) -> _Trait:
    return {**_CONSTANT, "units": units}


def _positive(*units: str) -> _Trait:
    return {**_CONSTANT, "positive": True, "units": units}


def _variable(*units: str) -> _Trait:
    return {**_CONSTANT, "varies": True, "units": units}


def _vector(unit: str) -> _Trait:
    return {**_variable(unit), "vector": True}


@dataclass(frozen=True)
class _Force(ABC):
    """What all forces have.

    Args:
        name: its name.
    """

    name: str

    kind: ClassVar[ForceKind]
    """What it is called and drawn as."""

    conservative: ClassVar[bool] = False
    """Whether it has a potential."""

    letter: ClassVar[str]
    """The field whose symbol stands for it in a figure."""

    def __post_init__(self) -> None:
        for each in fields(self):
            if each.metadata:
                given = getattr(self, each.name)
                is_vector = each.metadata["vector"]
                value = (
                    vector(given, f"{each.name} of {self.name!r}") if is_vector else plain(given)
                )
                object.__setattr__(self, each.name, value)

    @property
    @abstractmethod
    def bodies(self) -> tuple[str, ...]:
        """Names of the bodies it refers to by itself; of a force in a joint, none."""

    @property
    def stated(self) -> tuple[Stated, ...]:
        """Its points, constants and expressions, field by field."""
        return tuple(
            Stated(
                each.name.replace("_", " "),
                _as_tuple(getattr(self, each.name)),
                each.metadata["varies"],
                each.metadata["positive"],
                each.metadata["length"],
                each.metadata["units"],
            )
            for each in fields(self)
            if each.metadata
        )

    @property
    def symbols(self) -> frozenset[str]:
        """Names of everything it depends on."""
        return frozenset().union(*(symbols_in(s) for one in self.stated for s in one.scalars))

    @property
    def coefficient(self) -> Any:
        """The scalar, or the three, whose symbol stands for it in a figure."""
        return getattr(self, self.letter)


@final
@dataclass(frozen=True)
class End:
    """Where a force between two points acts.

    Args:
        body: name of the body.
        point: shape (3,), in its frame [m].
    """

    body: str
    point: Point


@dataclass(frozen=True)
class LineLoad(_Force):
    """A force along the line between two points, equal and opposite on them.

    Args:
        body_a: name of one body.
        point_a: shape (3,), in the frame of body a [m].
        body_b: name of the other body.
        point_b: shape (3,), in the frame of body b [m].
    """

    body_a: str
    point_a: Point = field(metadata=_POINT)
    body_b: str
    point_b: Point = field(metadata=_POINT)

    @property
    def ends(self) -> tuple[End, End]:
        """The two points."""
        return End(self.body_a, self.point_a), End(self.body_b, self.point_b)

    @property
    def bodies(self) -> tuple[str, ...]:
        """Names of the two bodies."""
        return self.body_a, self.body_b


@dataclass(frozen=True)
class JointLoad(_Force):
    """A force along or about the axis of a joint with one coordinate, opposite on parent and child.

    Args:
        joint: name of a revolute or prismatic joint.
    """

    joint: str

    @property
    def bodies(self) -> tuple[str, ...]:
        """None: the joint knows them."""
        return ()


@final
@dataclass(frozen=True)
class WrenchOnBody:
    """A force at a point of a body, a torque on it, or both.

    Args:
        body: name of the body.
        axes: the body in whose axes the components are; "world" for fixed axes.
        point: shape (3,), where the force acts, in the body's frame [m].
        force: shape (3,), components [N]; None if there is none.
        torque: shape (3,), components [N·m]; None if there is none.
    """

    body: str
    axes: str
    point: Point = (0.0, 0.0, 0.0)
    force: Point | None = None
    torque: Point | None = None


@dataclass(frozen=True)
class BodyLoad(_Force):
    """What acts on one body; nothing takes the reaction.

    Args:
        body: name of the body.
    """

    body: str

    @property
    @abstractmethod
    def wrench(self) -> WrenchOnBody:
        """Its action on its body."""

    @property
    def bodies(self) -> tuple[str, ...]:
        """Names of the body, and of the one in whose axes its components are."""
        axes = self.wrench.axes
        return (self.body,) if axes == "world" else (self.body, axes)


@final
@dataclass(frozen=True)
class Spring(LineLoad):
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

    kind = "spring"
    conservative = True
    letter = "stiffness"

    stiffness: Scalar = field(metadata=_positive("N/m"))
    free_length: Scalar = field(default=0.0, metadata=_LENGTH)


@final
@dataclass(frozen=True)
class Damper(LineLoad):
    """A linear damper between two points: it resists with c times the rate of the length.

    Args:
        name: its name.
        body_a: name of one body.
        point_a: shape (3,), in the frame of body a [m].
        body_b: name of the other body.
        point_b: shape (3,), in the frame of body b [m].
        damping: c [N·s/m].
    """

    kind = "damper"
    letter = "damping"

    damping: Scalar = field(metadata=_positive("N·s/m"))


@final
@dataclass(frozen=True)
class JointSpring(JointLoad):
    """A linear spring in a joint with one coordinate: force −k (coordinate − reference).

    Args:
        name: its name.
        joint: name of a revolute or prismatic joint.
        stiffness: k [N·m/rad or N/m].
        reference: the joint coordinate without force [rad or m].
    """

    kind = "spring"
    conservative = True
    letter = "stiffness"

    stiffness: Scalar = field(metadata=_positive("N/m", "N·m/rad"))
    reference: Scalar = field(default=0.0, metadata=_constant("m", "rad"))


@final
@dataclass(frozen=True)
class JointDamper(JointLoad):
    """A linear damper in a joint with one coordinate: force −c times its rate.

    Args:
        name: its name.
        joint: name of a revolute or prismatic joint.
        damping: c [N·m·s/rad or N·s/m].
    """

    kind = "damper"
    letter = "damping"

    damping: Scalar = field(metadata=_positive("N·s/m", "N·m·s/rad"))


@final
@dataclass(frozen=True)
class JointForce(JointLoad):
    """A drive in a joint with one coordinate, between parent and child.

    Args:
        name: its name.
        joint: name of a revolute or prismatic joint.
        force: along or about the joint's axis, on the child [N or N·m].
    """

    kind = "load"
    letter = "force"

    force: Scalar = field(metadata=_variable("N", "N·m"))


@final
@dataclass(frozen=True)
class Force(BodyLoad):
    """A force at a point of a body; nothing takes the reaction.

    Args:
        name: its name.
        body: name of the body.
        point: shape (3,), in the body's frame [m].
        force: shape (3,), components [N].
        axes: the body in whose axes the components are; "world" for fixed axes.
    """

    kind = "load"
    letter = "force"

    point: Point = field(metadata=_POINT)
    force: Point = field(metadata=_vector("N"))
    axes: str = "world"

    @property
    def wrench(self) -> WrenchOnBody:
        """The force at its point."""
        return WrenchOnBody(self.body, self.axes, point=self.point, force=self.force)


@final
@dataclass(frozen=True)
class Torque(BodyLoad):
    """A pure torque on a body; nothing takes the reaction.

    Args:
        name: its name.
        body: name of the body.
        torque: shape (3,), components [N·m].
        axes: the body in whose axes the components are; "world" for fixed axes.
    """

    kind = "load"
    letter = "torque"

    torque: Point = field(metadata=_vector("N·m"))
    axes: str = "world"

    @property
    def wrench(self) -> WrenchOnBody:
        """The torque."""
        return WrenchOnBody(self.body, self.axes, torque=self.torque)


AnyForce: TypeAlias = LineLoad | JointLoad | BodyLoad


def loads_in(
    forces: Iterable[AnyForce], joint: str, kind: ForceKind | None = None
) -> tuple[JointLoad, ...]:
    """Return the forces that act in a joint.

    Args:
        forces: of the mechanism.
        joint: name of the joint.
        kind: which of them; all by default.
    """
    return tuple(
        force
        for force in forces
        if isinstance(force, JointLoad) and force.joint == joint and kind in (None, force.kind)
    )


def _as_tuple(given: Any) -> tuple[Scalar, ...]:
    return given if isinstance(given, tuple) else (given,)
