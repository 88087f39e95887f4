"""Loops: holonomic closures between two bodies of the tree."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field
from math import asin, atan2
from typing import Literal, TypeAlias, final

from mecanique.errors import InputError
from mecanique.model.constraint_base import GuidingElement
from mecanique.model.expression import Scalar, Vector
from mecanique.model.placement import Placement, rpy_along, unit_vector, vector
from mecanique.model.statements import FRAME, NumberRule, state

Kind: TypeAlias = Literal["ball", "hinge", "weld", "distance", "pin", "plate"]

CLOSED: dict[str, tuple[str, ...]] = {
    "ball": ("x", "y", "z"),
    "hinge": ("x", "y", "z", "rx", "ry"),
    "weld": ("x", "y", "z", "rx", "ry", "rz"),
    "distance": ("length",),
    "pin": ("x", "y"),
    "plate": ("x", "y", "rz"),
}
"""The relative motions each kind closes, in the axes of frame a: along x, about x (rx), etc."""


@final
@dataclass(frozen=True)
class Loop(GuidingElement):
    """A holonomic closure between a frame on body a and a frame on body b.

    Make one by `Loop.ball`, `Loop.hinge`, `Loop.weld`, `Loop.distance`, `Loop.pin` or `Loop.plate`.

    Args:
        name: its name.
        kind: which relative motions it closes, see `CLOSED`.
        body_a: name of one body.
        frame_a: the frame on body a; a hinge turns about its z axis, a pin and a plate lie in its
            x-y plane.
        body_b: name of the other body.
        frame_b: the frame on body b.
        length: distance of the two origins, for the kind "distance" [m].

    Example:
        >>> rods = mq.Body("left", mq.rod(1.0, 0.5)), mq.Body("right", mq.rod(1.0, 0.5))
        >>> feet = mq.Placement((0.8, 0, 0))
        >>> pins = (
        ...     mq.Revolute("a", "ground", "left", axis=(0, -1, 0)),
        ...     mq.Revolute("b", "ground", "right", axis=(0, -1, 0), origin=feet),
        ... )
        >>> bar = mq.Loop.distance("bar", "left", (0, 0, -0.5), "right", (0, 0, -0.5), 0.8)
        >>> linkage = mq.Mechanism("linkage", (mq.Body("ground"), *rods), pins, loops=(bar,))
        >>> mq.degrees_of_freedom(linkage).N
        1
    """

    name: str
    kind: Kind
    body_a: str
    frame_a: Placement = field(metadata=FRAME)
    body_b: str
    frame_b: Placement = field(metadata=FRAME)
    length: Scalar = field(default=0.0, metadata=state("m"))

    noun = "loop"

    def __post_init__(self) -> None:
        super().__post_init__()
        if self.kind not in CLOSED:
            raise InputError(
                f"loop {self.name!r}: expected a kind among {', '.join(CLOSED)}, got {self.kind!r}"
            )

    @property
    def forces(self) -> tuple[str, ...]:
        """Names of what it transmits, row by row."""
        return tuple(f"{self.name}: {row}" for row in CLOSED[self.kind])

    @property
    def bodies(self) -> tuple[str, ...]:
        """The bodies it joins."""
        return self.body_a, self.body_b

    @property
    def rows(self) -> int:
        """Number of scalar constraint equations."""
        return len(CLOSED[self.kind])

    def rules(self) -> Iterator[NumberRule]:
        """Yield what its numbers keep to."""
        if self.kind == "distance":
            words = ": expected a length above 0, got {}"
            yield NumberRule(self.title, words, (self.length,), self.length, strict=True)
        yield from super().rules()

    @classmethod
    def ball(cls, name: str, body_a: str, point_a: Vector, body_b: str, point_b: Vector) -> Loop:
        """Keep two points together.

        Args:
            name: its name.
            body_a: name of one body.
            point_a: shape (3,), in the frame of body a [m].
            body_b: name of the other body.
            point_b: shape (3,), in the frame of body b [m].
        """
        return cls(name, "ball", body_a, _frame(point_a), body_b, _frame(point_b))

    @classmethod
    def hinge(
        cls,
        name: str,
        body_a: str,
        point_a: Vector,
        body_b: str,
        point_b: Vector,
        axis_a: Vector,
        axis_b: Vector | None = None,
    ) -> Loop:
        """Keep two points together and two axes parallel.

        Args:
            name: its name.
            body_a: name of one body.
            point_a: shape (3,), in the frame of body a [m].
            body_b: name of the other body.
            point_b: shape (3,), in the frame of body b [m].
            axis_a: shape (3,), numbers, in the frame of body a.
            axis_b: shape (3,), numbers, in the frame of body b; as axis a by default.
        """
        frames = _frame(point_a, axis_a), _frame(point_b, axis_a if axis_b is None else axis_b)
        return cls(name, "hinge", body_a, frames[0], body_b, frames[1])

    @classmethod
    def weld(
        cls, name: str, body_a: str, frame_a: Placement, body_b: str, frame_b: Placement
    ) -> Loop:
        """Keep two frames together.

        Args:
            name: its name.
            body_a: name of one body.
            frame_a: in body a.
            body_b: name of the other body.
            frame_b: in body b.
        """
        return cls(name, "weld", body_a, frame_a, body_b, frame_b)

    @classmethod
    def distance(
        cls, name: str, body_a: str, point_a: Vector, body_b: str, point_b: Vector, length: Scalar
    ) -> Loop:
        """Keep two points at a distance: a rigid massless rod with a ball at each end.

        Args:
            name: its name.
            body_a: name of one body.
            point_a: shape (3,), in the frame of body a [m].
            body_b: name of the other body.
            point_b: shape (3,), in the frame of body b [m].
            length: the distance, greater than zero [m].
        """
        return cls(name, "distance", body_a, _frame(point_a), body_b, _frame(point_b), length)

    @classmethod
    def pin(
        cls,
        name: str,
        body_a: str,
        point_a: Vector,
        body_b: str,
        point_b: Vector,
        normal: Vector = (0.0, -1.0, 0.0),
    ) -> Loop:
        """Keep two points together within a plane: the planar ball, without the third equation.

        Args:
            name: its name.
            body_a: name of one body.
            point_a: shape (3,), in the frame of body a [m].
            body_b: name of the other body.
            point_b: shape (3,), in the frame of body b [m].
            normal: shape (3,), numbers, of the plane, in the frame of body a.
        """
        return cls(name, "pin", body_a, _plane(point_a, normal), body_b, _plane(point_b, normal))

    @classmethod
    def plate(
        cls,
        name: str,
        body_a: str,
        point_a: Vector,
        body_b: str,
        point_b: Vector,
        normal: Vector = (0.0, -1.0, 0.0),
    ) -> Loop:
        """Keep two points together and two bodies parallel within a plane: the planar weld.

        Args:
            name: its name.
            body_a: name of one body.
            point_a: shape (3,), in the frame of body a [m].
            body_b: name of the other body.
            point_b: shape (3,), in the frame of body b [m].
            normal: shape (3,), numbers, of the plane, in the frame of body a.
        """
        return cls(name, "plate", body_a, _plane(point_a, normal), body_b, _plane(point_b, normal))


def explain_lock(name: str) -> str:
    """Return why the equations of a mechanism that is locked in a singular position are refused."""
    return (
        f"mechanism {name!r} is locked in a singular position: nothing in it can move, but small "
        "motions meet no resistance, so that its loops would need forces without bound to hold "
        "it; change its lengths, or leave out a loop"
    )


def _frame(point: Vector, axis: Vector | None = None) -> Placement:
    """A frame at a point, its z along the axis by pitch then yaw."""
    xyz = vector(point, "point of a loop")
    if axis is None:
        return Placement(xyz)
    return Placement(xyz, rpy_along(unit_vector(axis, "the axis of a loop")))


def _plane(point: Vector, normal: Vector) -> Placement:
    """A frame at a point, its z along the normal by roll then pitch: across -y, x stays x."""
    x, y, z = unit_vector(normal, "the axis of a loop")
    return Placement(vector(point, "point of a loop"), (-asin(y), atan2(x, z), 0.0))
