"""What forces have in common, and the four ways in which they act.

A force acts along the line between two points (`LineLoad`), in a joint (`JointLoad`), on one body
(`BodyLoad`) or, by a potential, at the place where a point of a body is (`FieldLoad`).
"""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Iterable
from dataclasses import dataclass, field
from typing import Any, ClassVar, Literal, TypeAlias, final

from mecanique.model.expression import Scalar, symbols_in
from mecanique.model.statements import POINT, MechanismPart

Point: TypeAlias = "tuple[Scalar, Scalar, Scalar]"

ForceKind: TypeAlias = Literal["spring", "damper", "load"]
"""What a force is called and drawn as."""


@dataclass(frozen=True)
class _Force(MechanismPart):
    """What all forces have.

    Args:
        name: its name.
    """

    noun = "force"

    kind: ClassVar[ForceKind]
    """What it is called and drawn as."""

    conservative: ClassVar[bool] = False
    """Whether it has a potential."""

    letter: ClassVar[str]
    """The field whose symbol stands for it in a figure; the name of what has none."""

    @property
    @abstractmethod
    def bodies(self) -> tuple[str, ...]:
        """Names of the bodies it refers to by itself; of a force in a joint, none."""

    @property
    def symbols(self) -> frozenset[str]:
        """Names of everything it depends on."""
        return frozenset().union(*map(symbols_in, self.scalars))

    @property
    def coefficient(self) -> Any:
        """The scalar, or the three, or the name that stands for it in a figure."""
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
    point_a: Point = field(metadata=POINT)
    body_b: str
    point_b: Point = field(metadata=POINT)

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
        joint: name of a revolute or prismatic joint; of several for what acts in them together.
    """

    joint: str | tuple[str, ...]

    @property
    def joints(self) -> tuple[str, ...]:
        """Names of the joints it acts in."""
        return (self.joint,) if isinstance(self.joint, str) else self.joint

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


@dataclass(frozen=True)
class FieldLoad(_Force):
    """A force at a point of a body by where in the world the point is; nothing takes the reaction.

    Args:
        body: name of the body.
        point: shape (3,), in the body's frame [m].
    """

    body: str
    point: Point = field(metadata=POINT)

    @property
    def bodies(self) -> tuple[str, ...]:
        """Name of the body."""
        return (self.body,)


AnyForce: TypeAlias = LineLoad | JointLoad | BodyLoad | FieldLoad
"""Anything that acts: a spring, a damper, a drive or a load.

Example:
    >>> loads = mq.textbook.load("shear_building").forces
    >>> all(isinstance(load, mq.AnyForce) for load in loads)
    True
    >>> len(loads), loads[0].name
    (15, 'columns1')
"""


def loads_in(
    forces: Iterable[AnyForce], joint: str, kind: ForceKind | None = None
) -> tuple[JointLoad, ...]:
    """Return the forces that act in a joint alone, not those of a potential of several joints."""
    return tuple(
        force
        for force in forces
        if isinstance(force, JointLoad) and force.joints == (joint,) and kind in (None, force.kind)
    )
