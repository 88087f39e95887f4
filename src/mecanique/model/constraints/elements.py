"""Elements that guide: cords over pulleys, belts, gears and racks, and pins that the map closes.

An element holds bodies on the coordinate map by forces of its own. Each of its forces is unknown in
size, and acts along a line that follows from where the bodies are; none does work in a virtual
displacement, for the map moves the bodies as the element lets them move.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from math import pi, radians
from typing import NamedTuple, TypeAlias, final

from mecanique.errors import InputError
from mecanique.model.constraints.loops import Loop
from mecanique.model.expression import Scalar, Vector, plain
from mecanique.model.placement import vector

__all__ = [
    "Belt",
    "Cord",
    "Element",
    "Gear",
    "Preload",
    "Pulley",
    "Rack",
    "Stop",
    "force_names",
    "preloads",
]


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
    """A massless, inextensible cord from a point over pulleys to another point.

    Its stretches are straight and lie in planes at right angles to its normal. A stretch pulls at
    both its ends with its tension; one that would have to push is slack, and the map does not hold.

    Args:
        name: its name.
        start: name of the body where it begins, and the point there, shape (3,), in its frame [m].
        over: the pulleys it runs over, in order.
        end: where it ends, as for `start`.
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
    end: tuple[str, Vector]
    normal: tuple[float, float, float] = (0.0, -1.0, 0.0)
    axes: str = "world"

    def __post_init__(self) -> None:
        object.__setattr__(self, "over", tuple(self.over))
        for side in ("start", "end"):
            body, point = getattr(self, side)
            where = f"{side} of cord {self.name!r}"
            object.__setattr__(self, side, (body, vector(point, where)))
        object.__setattr__(self, "normal", _unit(self.normal, f"cord {self.name!r}"))

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
        """The bodies it touches, and the one in whose axes its normal is."""
        touched = [stop.body for stop in self.stops]
        return tuple(dict.fromkeys(touched + ([self.axes] if self.axes != "world" else [])))

    @property
    def scalars(self) -> tuple[Scalar, ...]:
        """All expressions in it."""
        return tuple(scalar for stop in self.stops for scalar in (*stop.center, stop.radius))


@final
@dataclass(frozen=True)
class Belt:
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
    preload: Scalar | None = None
    normal: tuple[float, float, float] = (0.0, -1.0, 0.0)
    axes: str = "world"

    def __post_init__(self) -> None:
        object.__setattr__(self, "over", tuple(self.over))
        if self.preload is not None:
            object.__setattr__(self, "preload", plain(self.preload))
        if len(self.over) < 2 or not all(wheel.grips for wheel in self.over):
            raise InputError(
                f"belt {self.name!r}: expected two pulleys or more that it turns without slip, got "
                f"{len(self.over)}; leave out those that it slides over, or give grips=True"
            )
        object.__setattr__(self, "normal", _unit(self.normal, f"belt {self.name!r}"))

    @property
    def stops(self) -> tuple[Stop, ...]:
        """Where it runs, the first pulley once more at the end."""
        wheels = [Stop(wheel.body, wheel.center, wheel.radius, wheel.sense) for wheel in self.over]
        return *wheels, wheels[0]

    @property
    def parts(self) -> tuple[int, ...]:
        """Which of its tensions each run has: its own."""
        return tuple(range(len(self.over)))

    @property
    def forces(self) -> tuple[str, ...]:
        """Names of its tensions."""
        return tuple(f"{self.name}_{k + 1}" for k in self.parts)

    @property
    def bodies(self) -> tuple[str, ...]:
        """The bodies it touches, and the one in whose axes its normal is."""
        touched = [wheel.body for wheel in self.over]
        return tuple(dict.fromkeys(touched + ([self.axes] if self.axes != "world" else [])))

    @property
    def scalars(self) -> tuple[Scalar, ...]:
        """All expressions in it."""
        own = [] if self.preload is None else [self.preload]
        return (*own, *(scalar for stop in self.stops for scalar in (*stop.center, stop.radius)))


@dataclass(frozen=True)
class _Teeth:
    """What gears and racks have.

    Args:
        name: its name.
        wheel: name of the hinge that carries one wheel.
        other: name of the joint that carries the other part.
        radius: pitch radius of the wheel [m].
        pressure_angle: between the line of action and the pitch line [rad]; 20° by default.
    """

    name: str
    wheel: str
    other: str
    radius: Scalar
    pressure_angle: Scalar = field(default=radians(20), kw_only=True)

    def __post_init__(self) -> None:
        for name in ("radius", "pressure_angle"):
            object.__setattr__(self, name, plain(getattr(self, name)))
        angle = self.pressure_angle
        if isinstance(angle, float) and not 0 <= angle < pi / 2:
            raise InputError(
                f"{type(self).__name__.lower()} {self.name!r}: expected a pressure angle from 0 to "
                f"less than π/2 [rad], got {angle:g}"
            )

    @property
    def forces(self) -> tuple[str, ...]:
        """Name of its force."""
        return (self.name,)

    @property
    def bodies(self) -> tuple[str, ...]:
        """The bodies it names: none, but `joints`."""
        return ()

    @property
    def joints(self) -> tuple[str, str]:
        """The joints that carry its parts."""
        return self.wheel, self.other


@final
@dataclass(frozen=True)
class Gear(_Teeth):
    """Two wheels in mesh, on hinges whose axes are parallel or meet, without play and friction.

    Where their pitch circles touch, the wheel pushes the other with the force F along the line of
    action, at the pressure angle from the common tangent n × u (n the wheel's axis, u from its
    center to where they touch); F counts positive along that tangent. Whichever flanks touch, the
    force also parts the wheels. Bevel wheels, whose axes meet, have their pitch circles about the
    origins of their hinges; the cones through these share their apex, where the axes meet, and part
    across the line on which they touch.

    Args:
        name: its name.
        wheel: name of the hinge that carries one wheel.
        other: name of the hinge that carries the other.
        radius: pitch radius of the wheel [m].
        other_radius: pitch radius of the other [m].
        internal: whether the wheel is a ring with teeth inside, in which the other runs; of spur
            wheels only.
        pressure_angle: between the line of action and the common tangent [rad]; 20° by default.

    Example:
        >>> train = mq.textbook.load("planetary_gear")
        >>> [(gear.wheel, gear.other, gear.internal) for gear in train.elements]
        [('sun_axle', 'planet_pin', False), ('ring_axle', 'planet_pin', True)]
        >>> forces = mq.Reference(train).guide_forces({"sun": 0.0})
        >>> {name: round(float(force), 3) for name, force in forces.items()}
        {'inner': 0.226, 'outer': 0.122}
    """

    other_radius: Scalar = field(kw_only=True)
    internal: bool = field(default=False, kw_only=True)

    def __post_init__(self) -> None:
        super().__post_init__()
        object.__setattr__(self, "other_radius", plain(self.other_radius))

    @property
    def distance(self) -> Scalar:
        """Of the axes [m]."""
        return self.radius + (-1 if self.internal else 1) * self.other_radius

    @property
    def scalars(self) -> tuple[Scalar, ...]:
        """All expressions in it."""
        return self.radius, self.other_radius, self.pressure_angle


@final
@dataclass(frozen=True)
class Rack(_Teeth):
    """A pinion on a hinge that meshes with a rack on a slide, without play and friction.

    The pinion pushes the rack with the force F along the line of action, positive along n × u, n
    the hinge's axis and u from the pinion's center to the rack's pitch line.

    Args:
        name: its name.
        wheel: name of the hinge that carries the pinion.
        other: name of the slide that carries the rack.
        radius: pitch radius of the pinion [m].
        point: shape (3,), of the rack's pitch line, in the rack's frame [m].
        pressure_angle: between the line of action and the pitch line [rad]; 20° by default.

    Example:
        >>> steering = mq.textbook.load("rack_and_pinion")
        >>> steering.elements[0].wheel, steering.elements[0].other
        ('axle', 'slide')
        >>> float(mq.Reference(steering).guide_forces({"x": 0.0})["teeth"].round(3))
        13.302
    """

    point: Vector = field(default=(0.0, 0.0, 0.0), kw_only=True)

    def __post_init__(self) -> None:
        super().__post_init__()
        object.__setattr__(self, "point", vector(self.point, f"point of rack {self.name!r}"))

    @property
    def scalars(self) -> tuple[Scalar, ...]:
        """All expressions in it."""
        return self.radius, self.pressure_angle, *self.point


Element: TypeAlias = Cord | Belt | Gear | Rack | Loop


class Preload(NamedTuple):
    """What a belt's tensions are together.

    Args:
        forces: which of the mechanism's unknown forces they are.
        total: their sum [N].
    """

    forces: range
    total: Scalar


def force_names(elements: tuple[Element, ...]) -> tuple[str, ...]:
    """Return the names of the unknown forces of some elements, in order.

    Those of a loop are its rows, "loop: motion it closes".

    Args:
        elements: of a mechanism.
    """
    return tuple(name for element in elements for name in element.forces)


def preloads(elements: tuple[Element, ...]) -> list[Preload]:
    """Return what is stated about the tensions of belts.

    Args:
        elements: of a mechanism.
    """
    found, first = list[Preload](), 0
    for element in elements:
        count = len(element.forces)
        if isinstance(element, Belt) and element.preload is not None:
            found.append(Preload(range(first, first + count), count * element.preload))
        first += count
    return found


def _unit(normal: tuple[float, float, float], where: str) -> tuple[float, float, float]:
    x, y, z = map(float, normal)
    if abs(x * x + y * y + z * z - 1) > 1e-9:
        raise InputError(f"{where}: expected a normal of unit length, got {normal}")
    return x, y, z
