"""Gears and racks: wheels in mesh, and a pinion on its rack, without play or friction."""

from __future__ import annotations

from dataclasses import dataclass, field
from math import pi, radians
from typing import final

from mecanique.errors import InputError
from mecanique.model.constraint_base import GuidingElement
from mecanique.model.expression import Scalar, Vector
from mecanique.model.statements import POINT, state


@dataclass(frozen=True)
class Meshing(GuidingElement):
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
    radius: Scalar = field(metadata=state("m"))
    pressure_angle: Scalar = field(default=radians(20), kw_only=True, metadata=state("rad"))

    def __post_init__(self) -> None:
        super().__post_init__()
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
class Gear(Meshing):
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

    other_radius: Scalar = field(kw_only=True, metadata=state("m"))
    internal: bool = field(default=False, kw_only=True)

    @property
    def distance(self) -> Scalar:
        """Of the axes [m]."""
        return self.radius + (-1 if self.internal else 1) * self.other_radius


@final
@dataclass(frozen=True)
class Rack(Meshing):
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

    point: Vector = field(default=(0.0, 0.0, 0.0), kw_only=True, metadata=POINT)
