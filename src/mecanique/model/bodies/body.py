"""Bodies: rigid, each with a frame of its own."""

from __future__ import annotations

from collections.abc import Sequence
from functools import cached_property
from typing import final

import numpy as np

from mecanique.errors import InputError
from mecanique.model.bodies.shape import Inertia, Shape, combine
from mecanique.model.bodies.visuals import Visual
from mecanique.model.expression import Scalar, Vector
from mecanique.model.placement import vector


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
