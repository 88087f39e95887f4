"""Contacts that guide: wheels, disks and balls that roll without slip, and blades.

Where a body rolls, the point of it that touches has the velocity of the point it touches. Along the
normal that is the rate of a distance; along the plane it is in general no rate of anything, and so
restricts velocities but no position (Neimark & Fufaev, Dynamics of Nonholonomic Systems, 1972, ch.
I).
"""

from __future__ import annotations

from dataclasses import dataclass, field
from types import MappingProxyType
from typing import TypeAlias, final

from mecanique.errors import InputError
from mecanique.model.constraint_base import EdgeContact, PressingContact
from mecanique.model.expression import Scalar, Vector
from mecanique.model.placement import Placement, unit_vector
from mecanique.model.statements import FRAME, POINT, state

Direction: TypeAlias = "tuple[float, float, float]"
"""A direction in a body's frame, of unit length."""


@final
@dataclass(frozen=True)
class Rolling(PressingContact):
    """A wheel, a ball or an ellipsoid that rolls on a plane without slip, and stays on it.

    Its forces on the body are the normal one, from the plane into the body, and the friction along
    the x and y axes of the plane's frame. A ball may roll in a bowl or on a dome as well; friction
    is then along these axes turned with the normal, the shortest way.

    Args:
        name: its name.
        body: name of the body that rolls.
        radius: greatest distance of its rim from the center [m].
        center: shape (3,), in the frame of the body [m].
        axis: shape (3,), numbers, of the wheel in the frame of the body; None for a ball.
        crown: radius of the rim's cross section [m]: zero for a sharp edge, `radius` for a ball.
        on: name of the body that has the plane.
        plane: frame of the plane in that body; its z axis is the normal, on the side of the wheel.
        stretch: shape (3,), factors by which a ball is stretched along x, y and z of its body's
            frame, which makes an ellipsoid of it.
        bowl: radius of a sphere that takes the plane's place and touches it at its origin [m]: of a
            bowl that a ball rolls in, or minus that of a dome that it rolls on; zero for a plane.
        friction: coefficient of friction, the ratio of friction to normal force beyond which it
            would slip: motions say when; None if that is not asked.

    Example:
        >>> disk = mq.textbook.load("rolling_disk")
        >>> disk.contacts[0].body, disk.contacts[0].radius
        ('disk', R)
        >>> mq.degrees_of_freedom(disk).N
        1
        >>> mq.Reference(disk).reactions({"z": 0.3})["contact"].force.round(3)
        array([1.846, 0.   , 9.239])
    """

    name: str
    body: str
    radius: Scalar = field(metadata=state("m"))
    center: Vector = field(default=(0.0, 0.0, 0.0), metadata=POINT)
    axis: Vector | None = (0.0, 1.0, 0.0)
    crown: Scalar = field(default=0.0, metadata=state("m"))
    on: str = "ground"
    plane: Placement = field(default=Placement(), metadata=FRAME)
    stretch: Vector = field(default=(1.0, 1.0, 1.0), metadata=state("1", vector=True, sign="above"))
    bowl: Scalar = field(default=0.0, metadata=state("m"))
    friction: Scalar | None = field(default=None, metadata=state("1"))

    forces_of = MappingProxyType(
        {
            "normal": "normal force {}, along the normal [N]",
            "x": "friction {}, along x of its plane [N]",
            "y": "friction {}, along y of its plane [N]",
        }
    )

    def __post_init__(self) -> None:
        super().__post_init__()
        where = f"rolling {self.name!r}"
        if self.axis is None:
            object.__setattr__(self, "crown", self.radius)
        else:
            object.__setattr__(self, "axis", unit_vector(self.axis, f"the axis of {where}"))
        if (self.axis is not None or self.curved) and self.stretched:
            raise InputError(f"{where}: expected a stretch of a ball on a plane only")
        if self.axis is not None and self.curved:
            raise InputError(f"{where}: expected a ball in a bowl, got a wheel; give axis=None")

    @property
    def curved(self) -> bool:
        """Whether it rolls in a bowl or on a dome."""
        return not (isinstance(self.bowl, float) and self.bowl == 0)

    @property
    def rows(self) -> tuple[str, ...]:
        """The motions it prevents: along the normal, and along the plane's x and y."""
        return ("normal", "x", "y")


@final
@dataclass(frozen=True)
class Blade(EdgeContact):
    """A knife edge or a skate: its point moves along the edge only, not sideways.

    Its force on the body acts at the point, along normal × along, to the left of the edge.

    Args:
        name: its name.
        body: name of the body that has the edge.
        point: shape (3,), where it touches, in the frame of the body [m].
        along: shape (3,), numbers, direction of the edge in the frame of the body.
        normal: shape (3,), numbers, of the plane it moves in, in the frame of the body.
        on: name of the body that it moves on.

    Example:
        >>> sleigh = mq.textbook.load("chaplygin_sleigh")
        >>> sleigh.contacts[0].name, sleigh.contacts[0].along
        ('edge', (1.0, 0.0, 0.0))
        >>> print(mq.degrees_of_freedom(sleigh))
        N = 3 velocities - 1 independent constraint equation (of 1) = 2; 0 of the equations
        restrict positions, 1 velocities alone: 3 independent positions; as 6 n - b of 1 rigid
        body: b = 4 restraints
    """

    name: str
    body: str
    point: Vector = field(default=(0.0, 0.0, 0.0), metadata=POINT)
    along: Vector = (1.0, 0.0, 0.0)
    normal: Vector = (0.0, 0.0, 1.0)
    on: str = "ground"

    forces_of = MappingProxyType({"side": "force {}, across the edge [N]"})

    def __post_init__(self) -> None:
        super().__post_init__()
        where = f"blade {self.name!r}"
        for name in ("along", "normal"):
            unit = unit_vector(getattr(self, name), f"{name!r} of {where}")
            object.__setattr__(self, name, unit)
        unit_vector(_cross(self.normal, self.along), f"normal × along of {where}")

    @property
    def side(self) -> Direction:
        """The direction in which it does not move, in the frame of the body."""
        return unit_vector(_cross(self.normal, self.along), "the side of a blade")

    @property
    def rows(self) -> tuple[str, ...]:
        """The motion it prevents."""
        return ("side",)


Contact: TypeAlias = Rolling | Blade

SPEAKING = "a Rolling or a Blade"
"""What says by which force it acts, and where, as a velocity constraint does not."""


def row_names(contacts: tuple[Contact, ...]) -> tuple[str, ...]:
    """Return the name of each row of some contacts, "contact: motion it prevents"."""
    return tuple(f"{contact.name}: {row}" for contact in contacts for row in contact.rows)


def _cross(a: Vector, b: Vector) -> Direction:
    (p, q, r), (x, y, z) = (tuple(map(float, vector)) for vector in (a, b))
    return q * z - r * y, r * x - p * z, p * y - q * x
