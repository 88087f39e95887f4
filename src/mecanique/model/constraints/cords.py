"""Cords over pulleys and belts around them: straight runs that pull, without stretch or mass."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import final

from mecanique.errors import InputError
from mecanique.model.constraint_base import CordStop, Strung
from mecanique.model.expression import Scalar, Vector, plain
from mecanique.model.placement import vector
from mecanique.model.statements import state


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

    Example:
        >>> crossed = mq.Belt("belt", (mq.Pulley("motor", 0.1), mq.Pulley("drum", 0.3, sense=-1)))
        >>> [pulley.sense for pulley in crossed.over]
        [1, -1]
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


@final
@dataclass(frozen=True)
class Cord(Strung):
    """A massless, inextensible cord from a point over pulleys to another, or wound on the last one.

    Its stretches are straight and lie in planes at right angles to its normal. A stretch pulls at
    both its ends with its tension; one that would have to push is slack, and the map does not hold.

    Args:
        name: its name.
        start: name of the body where it begins, and the point there, shape (3,), in its frame [m].
        over: the pulleys it runs over, in order.
        end: where it ends, as for `start`; None if it is wound on the last pulley and turns it, as
            the thread of a yo-yo or of a winch.
        normal: shape (3,), numbers, unit normal of its plane.
        axes: the body in whose axes the normal is; "world" for fixed axes.

    Example:
        >>> machine = mq.textbook.load("atwood_machine")
        >>> machine.elements[0].over[0].body
        'pulley'
        >>> tensions = mq.Reference(machine).guide_forces({"x": 0.0})
        >>> {name: round(float(tension), 2) for name, tension in tensions.items()}
        {'cord_1': 10.79, 'cord_2': 10.63}
    """

    name: str
    start: tuple[str, Vector]
    over: tuple[Pulley, ...]
    end: tuple[str, Vector] | None = None
    normal: tuple[float, float, float] = (0.0, -1.0, 0.0)
    axes: str = "world"

    def __post_init__(self) -> None:
        object.__setattr__(self, "over", tuple(self.over))
        if self.end is None and not (self.over and self.over[-1].grips):
            raise InputError(
                f"cord {self.name!r}: expected a last pulley that it is wound on and turns; "
                "give an end, or such a pulley"
            )
        for side in ("start", "end") if self.end else ("start",):
            body, point = getattr(self, side)
            where = f"{side} of cord {self.name!r}"
            object.__setattr__(self, side, (body, vector(point, where)))
        object.__setattr__(self, "normal", _unit(self.normal, f"cord {self.name!r}"))

    @property
    def stops(self) -> tuple[CordStop, ...]:
        """Where it runs, the ends included."""
        ends = [CordStop(*end) for end in (self.start, self.end) if end]
        return *ends[:1], *map(_stop_at, self.over), *ends[1:]

    @property
    def parts(self) -> tuple[int, ...]:
        """Which of its tensions each stretch has: it changes at pulleys that the cord turns."""
        tensions = [0]
        for wheel in self.over:
            tensions.append(tensions[-1] + int(wheel.grips))
        return tuple(tensions[: len(self.stops) - 1])

    @property
    def forces(self) -> tuple[str, ...]:
        """Names of its tensions."""
        count = self.parts[-1] + 1
        return tuple(f"{self.name}_{k + 1}" for k in range(count)) if count > 1 else (self.name,)


@final
@dataclass(frozen=True)
class Belt(Strung):
    """A closed, inextensible belt without mass that turns all its pulleys, without slip.

    Its runs are straight and lie in a plane at right angles to its normal. Around pulleys of one
    sense it is open, it crosses from one to the next of the other sense. What its pulleys need
    determines the tensions except for a part that all runs share; the preload gives that part.

    Args:
        name: its name.
        over: the pulleys it runs around, in order; from the last it runs to the first.
        preload: mean of the tensions of its runs, which a tensioner keeps [N]; None leaves them
            undetermined.
        normal: shape (3,), numbers, unit normal of its plane.
        axes: the body in whose axes the normal is; "world" for fixed axes.

    Example:
        >>> over = mq.Pulley("motor", 0.1), mq.Pulley("drum", 0.3)
        >>> belt = mq.Belt("belt", over, normal=(0, 0, 1))
        >>> wheels = mq.Body("motor", mq.disk(1.0, 0.1)), mq.Body("drum", mq.disk(4.0, 0.3))
        >>> shaft = mq.Revolute("shaft", "ground", "motor")
        >>> axle = mq.Revolute("axle", "ground", "drum", origin=mq.Placement((1, 0, 0)))
        >>> bodies = mq.Body("ground"), *wheels
        >>> drive = mq.Mechanism("drive", bodies, (shaft, axle), elements=(belt,))
        >>> list(drive.coordinates)
        ['shaft']
    """

    name: str
    over: tuple[Pulley, ...]
    preload: Scalar | None = field(default=None, metadata=state("N"))
    normal: tuple[float, float, float] = (0.0, -1.0, 0.0)
    axes: str = "world"

    def __post_init__(self) -> None:
        object.__setattr__(self, "over", tuple(self.over))
        super().__post_init__()
        if len(self.over) < 2 or not all(wheel.grips for wheel in self.over):
            raise InputError(
                f"belt {self.name!r}: expected two pulleys or more that it turns without slip, got "
                f"{len(self.over)}; leave out those that it slides over, or give grips=True"
            )
        object.__setattr__(self, "normal", _unit(self.normal, f"belt {self.name!r}"))

    @property
    def stops(self) -> tuple[CordStop, ...]:
        """Where it runs, the first pulley once more at the end."""
        return tuple(map(_stop_at, (*self.over, self.over[0])))

    @property
    def parts(self) -> tuple[int, ...]:
        """Which of its tensions each run has: its own."""
        return tuple(range(len(self.over)))

    @property
    def forces(self) -> tuple[str, ...]:
        """Names of its tensions."""
        return tuple(f"{self.name}_{k + 1}" for k in self.parts)


def _stop_at(wheel: Pulley) -> CordStop:
    return CordStop(wheel.body, wheel.center, wheel.radius, wheel.sense)


def _unit(normal: tuple[float, float, float], where: str) -> tuple[float, float, float]:
    x, y, z = map(float, normal)
    if abs(x * x + y * y + z * z - 1) > 1e-9:
        raise InputError(f"{where}: expected a normal of unit length, got {normal}")
    return x, y, z
