"""Bodies: rigid, each made of pieces, with a frame of its own."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property, reduce
from operator import add
from typing import Any, TypeAlias, cast, final

import numpy as np

from mecanique.errors import InputError
from mecanique.model.bodies.visuals import Rgba, Visual
from mecanique.model.expression import Scalar, Vector, plain
from mecanique.model.placement import Matrix3, Placement, carry, is_zero, rotate, vector

Inertia: TypeAlias = "tuple[Scalar, Scalar, Scalar, Scalar, Scalar, Scalar]"
"""ixx, iyy, izz, ixy, ixz, iyz: entries of the tensor, as in URDF (ixy is no product)."""


@final
@dataclass(frozen=True)
class Shape:
    """A piece of a body: its mass, inertia and appearance, in the body's frame.

    Args:
        mass: [kg].
        center: shape (3,), center of mass [m].
        inertia: ixx, iyy, izz, ixy, ixz, iyz about the center of mass, in body axes [kg·m²].
        visuals: what is drawn.
        form: what it is if it is homogeneous, e.g. "slender rod"; else empty.

    Example:
        >>> flywheel = mq.Shape(3.0, inertia=(0.02, 0.02, 0.04, 0, 0, 0))
        >>> flywheel.at((0, 0, 0.5)).center
        (0.0, 0.0, 0.5)
    """

    mass: Scalar
    center: tuple[Scalar, Scalar, Scalar] = (0.0, 0.0, 0.0)
    inertia: Inertia = (0.0, 0.0, 0.0, 0.0, 0.0, 0.0)
    visuals: tuple[Visual, ...] = ()
    form: str = field(default="", compare=False, repr=False)

    def __post_init__(self) -> None:
        object.__setattr__(self, "mass", plain(self.mass))
        object.__setattr__(self, "center", vector(self.center, "center of mass"))
        given = as_tuple(self.inertia, "six entries ixx, iyy, izz, ixy, ixz, iyz of an inertia")
        inertia = tuple(plain(entry) for entry in given)
        if len(inertia) != 6:
            raise InputError(
                "expected six entries ixx, iyy, izz, ixy, ixz, iyz of an inertia, "
                f"got {len(inertia)}"
            )
        object.__setattr__(self, "inertia", inertia)
        object.__setattr__(self, "visuals", as_tuple(self.visuals, "visuals", Visual))

    def at(self, xyz: Vector = (0.0, 0.0, 0.0), rpy: Vector = (0.0, 0.0, 0.0)) -> Shape:
        """Return the shape moved to another place in the body.

        Args:
            xyz: shape (3,), where its origin goes [m].
            rpy: shape (3,), how it is turned: roll, pitch, yaw [rad].
        """
        place = Placement(xyz, rpy)  # type: ignore[arg-type]  # it takes any three
        return replace(
            self,
            center=carry(place, self.center),
            inertia=_turn_inertia(place.rotation, self.inertia),
            visuals=tuple(visual.at(place) for visual in self.visuals),
        )

    def colored(self, rgba: Rgba) -> Shape:
        """Return the shape drawn in another color.

        Args:
            rgba: red, green, blue, opacity, each from 0 to 1.
        """
        return replace(self, visuals=tuple(replace(visual, rgba=rgba) for visual in self.visuals))


def as_tuple(values: object, what: str, kind: type = object) -> tuple[Any, ...]:
    """Return a sequence as a tuple."""
    if not isinstance(values, Iterable) or isinstance(values, (str, bytes)):
        raise InputError(f"expected {what}, got {values!r}")
    items = tuple(values)
    for item in items:
        if not isinstance(item, kind):
            raise InputError(f"expected {what}, got {item!r} among them")
    return items


def combine(shapes: Sequence[Shape]) -> Shape:
    """Return several shapes as one: masses add, inertias add about the common center of mass."""
    heavy = [shape for shape in shapes if not all(map(is_zero, (shape.mass, *shape.inertia)))]
    visuals = tuple(visual for shape in shapes for visual in shape.visuals)
    if len(heavy) == 1:
        return replace(heavy[0], visuals=visuals)
    if not heavy:
        return Shape(0.0, visuals=visuals)
    mass = _total(shape.mass for shape in heavy)
    center: list[Scalar] = []
    for column in zip(*(shape.center for shape in heavy), strict=True):
        moments = [shape.mass * c for shape, c in zip(heavy, column, strict=True)]
        center.append(0.0 if all(map(is_zero, moments)) else _total(moments) / mass)
    x, y, z = center
    inertia: list[Scalar] = [0.0] * 6
    for shape in heavy:
        dx, dy, dz = (c - r for c, r in zip(shape.center, (x, y, z), strict=True))
        steiner = (dy**2 + dz**2, dx**2 + dz**2, dx**2 + dy**2, -dx * dy, -dx * dz, -dy * dz)
        inertia = [
            i + about_center + shape.mass * s
            for i, about_center, s in zip(inertia, shape.inertia, steiner, strict=True)
        ]
    return Shape(mass, (x, y, z), tuple(inertia), visuals)


def _total(terms: Any) -> Scalar:
    # sum() rounds floats otherwise from Python 3.12 on
    return cast("Scalar", reduce(add, terms))


def _turn_inertia(turn: Matrix3, inertia: Inertia) -> Inertia:
    """R I Rᵀ, entry by entry."""
    ixx, iyy, izz, ixy, ixz, iyz = inertia
    columns = zip(
        *(rotate(turn, row) for row in ((ixx, ixy, ixz), (ixy, iyy, iyz), (ixz, iyz, izz))),
        strict=True,
    )
    rows = [rotate(turn, column) for column in columns]
    return rows[0][0], rows[1][1], rows[2][2], rows[0][1], rows[0][2], rows[1][2]


@final
class Body:
    """A rigid body: a name and the shapes it is made of, in its own frame.

    Args:
        name: its name, as link name in URDF.
        shapes: its pieces; none makes a massless body that is not drawn.
        as_given: whether its inertia is taken as it is, even if no real body has it: equations of
            motion hold for any numbers.

    Raises:
        InputError: if a piece is not a shape.

    Example:
        >>> hammer = mq.Body("hammer", mq.rod(0.5, 0.4), mq.particle(1.5, (0, 0, -0.4)))
        >>> hammer.mass
        2.0
    """

    def __init__(self, name: str, *shapes: Shape, as_given: bool = False) -> None:
        if not isinstance(name, str):
            raise InputError(f"expected a text for the name of a body, got {name!r}")
        for shape in shapes:
            if not isinstance(shape, Shape):
                raise InputError(f"expected shapes for body {name!r}, got {shape!r}")
        self.name = name
        self.shapes = shapes
        self.as_given = as_given

    @cached_property
    def _whole(self) -> Shape:
        return combine(self.shapes)

    @property
    def mass(self) -> Scalar:
        """Mass [kg]."""
        return self._whole.mass

    @property
    def center(self) -> tuple[Scalar, Scalar, Scalar]:
        """Center of mass in the body's frame, shape (3,) [m]."""
        return self._whole.center

    @property
    def inertia(self) -> Inertia:
        """Entries ixx, iyy, izz, ixy, ixz, iyz about the center of mass, in body axes [kg·m²]."""
        return self._whole.inertia

    @property
    def visuals(self) -> tuple[Visual, ...]:
        """What is drawn of it."""
        return self._whole.visuals

    def replace(
        self,
        *,
        mass: Scalar | None = None,
        center: Vector | np.ndarray | None = None,
        inertia: Sequence[Scalar] | np.ndarray | None = None,
    ) -> Body:
        """Return the body in one piece with another mass, center or inertia, drawn as before.

        What is not given stays as it is: a new mass does not change the inertia.

        Args:
            mass: [kg].
            center: shape (3,), center of mass in the body's frame [m].
            inertia: ixx, iyy, izz, ixy, ixz, iyz about the center of mass, body axes [kg·m²].

        Raises:
            InputError: if there are not three components of the center or six of the inertia.
        """
        whole = self._whole
        return Body(
            self.name,
            Shape(
                whole.mass if mass is None else mass,
                whole.center if center is None else vector(tuple(center), "center of mass"),
                whole.inertia if inertia is None else tuple(inertia),
                whole.visuals,
            ),
            as_given=self.as_given,
        )

    def __eq__(self, other: object) -> bool:
        return isinstance(other, Body) and (self.name, self.shapes) == (other.name, other.shapes)

    def __hash__(self) -> int:
        return hash((self.name, self.shapes))

    def __repr__(self) -> str:
        given = ["as_given=True"] if self.as_given else []
        return f"Body({', '.join([*map(repr, (self.name, *self.shapes)), *given])})"
