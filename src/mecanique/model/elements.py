"""Elements that guide: cords over pulleys, gears, racks and belts, and pins that the map closes.

An element holds bodies on the coordinate map by forces of its own. Each of its forces is unknown in
size, and acts along a line that follows from where the bodies are; none does work in a virtual
displacement, for the map moves the bodies as the element lets them move.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple, TypeAlias, final

from mecanique.errors import InputError
from mecanique.model.expression import Scalar, Vector, plain
from mecanique.model.loops import Loop
from mecanique.model.placement import vector

__all__ = ["Cord", "Element", "Pulley", "Stop", "force_names"]


@final
@dataclass(frozen=True)
class Pulley:
    """A wheel that a cord runs over.

    Args:
        body: name of the body that the wheel is, or that carries it.
        radius: of the line of the cord around it [m]; zero for a ring or an eye.
        sense: how the cord runs around it from its start on: 1 counterclockwise, −1 clockwise, seen
            against the cord's normal.
        center: shape (3,), in the frame of the body [m].
        grips: whether the cord turns the body with it, without slip; a cord that slides without
            friction, or over a wheel whose turning is left out, has the same tension on both sides.
    """

    body: str
    radius: Scalar = 0.0
    sense: int = 1
    center: Vector = (0.0, 0.0, 0.0)
    grips: bool = True

    def __post_init__(self) -> None:
        object.__setattr__(self, "radius", plain(self.radius))
        object.__setattr__(self, "center", vector(self.center, "center of a pulley"))
        if self.sense not in (1, -1):
            raise InputError(f"pulley on {self.body!r}: expected sense 1 or -1, got {self.sense!r}")


class Stop(NamedTuple):
    """A place that a cord runs to: an end of it, or a pulley.

    Args:
        body: its name.
        center: shape (3,), in the frame of the body [m].
        radius: of the cord's line around it, zero at an end [m].
        sense: 1 counterclockwise, −1 clockwise.
    """

    body: str
    center: Vector
    radius: Scalar = 0.0
    sense: int = 1


@final
@dataclass(frozen=True)
class Cord:
    """A cord without mass that does not stretch, from a point over pulleys to another point.

    Its stretches are straight and lie in planes at right angles to its normal. A stretch pulls at
    both its ends with its tension; one that would have to push is slack, and the map does not hold.

    Args:
        name: its name.
        start: name of the body where it begins, and the point there, shape (3,), in its frame [m].
        over: the pulleys it runs over, in order.
        end: where it ends, as for `start`.
        normal: shape (3,), numbers, unit normal of its plane in world axes.
    """

    name: str
    start: tuple[str, Vector]
    over: tuple[Pulley, ...]
    end: tuple[str, Vector]
    normal: tuple[float, float, float] = (0.0, -1.0, 0.0)

    def __post_init__(self) -> None:
        object.__setattr__(self, "over", tuple(self.over))
        for side in ("start", "end"):
            body, point = getattr(self, side)
            where = f"{side} of cord {self.name!r}"
            object.__setattr__(self, side, (body, vector(point, where)))
        x, y, z = map(float, self.normal)
        if abs(x * x + y * y + z * z - 1) > 1e-9:
            raise InputError(
                f"cord {self.name!r}: expected a normal of unit length, got {self.normal}"
            )
        object.__setattr__(self, "normal", (x, y, z))

    @property
    def stops(self) -> tuple[Stop, ...]:
        """Where it runs, the ends included."""
        wheels = [Stop(wheel.body, wheel.center, wheel.radius, wheel.sense) for wheel in self.over]
        return Stop(*self.start), *wheels, Stop(*self.end)

    @property
    def parts(self) -> tuple[int, ...]:
        """Which of its tensions each stretch has: it changes at pulleys that the cord turns."""
        found = [0]
        for wheel in self.over:
            found.append(found[-1] + int(wheel.grips))
        return tuple(found)

    @property
    def forces(self) -> tuple[str, ...]:
        """Names of its tensions."""
        count = self.parts[-1] + 1
        return tuple(f"{self.name}_{k + 1}" for k in range(count)) if count > 1 else (self.name,)

    @property
    def bodies(self) -> tuple[str, ...]:
        """The bodies it touches."""
        return tuple(dict.fromkeys(stop.body for stop in self.stops))

    @property
    def scalars(self) -> tuple[Scalar, ...]:
        """All expressions in it."""
        return tuple(scalar for stop in self.stops for scalar in (*stop.center, stop.radius))


Element: TypeAlias = Cord | Loop


def force_names(elements: tuple[Element, ...]) -> tuple[str, ...]:
    """Return the names of the unknown forces of some elements, in order.

    Those of a loop are its rows, "loop: motion it closes".

    Args:
        elements: of a mechanism.
    """
    return tuple(name for element in elements for name in element.forces)
