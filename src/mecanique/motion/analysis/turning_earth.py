"""Put a mechanism on ground that turns with the earth.

The base turns about the earth's axis by rheonomic joints, exactly, at any angle and speed: Coriolis
and centrifugal effects follow from the equations of motion, not from formulas for small angles. The
axis is led through the world's origin. That leaves out the uniform part of the centrifugal
acceleration, the one that comes from the distance to the earth's axis, and rightly so: g as a plumb
line shows it, and as a mechanism's gravity states it, contains it already. Weights turn with the
ground. The earth's way around the sun and the tides are left out.
"""

from __future__ import annotations

from dataclasses import replace
from typing import Literal

import numpy as np

from mecanique.errors import InputError
from mecanique.model.bodies import Body
from mecanique.model.constraints.cords import Belt, Cord
from mecanique.model.coordinates import Coordinates
from mecanique.model.expression import finite, time
from mecanique.model.force_base import AnyForce, BodyLoad
from mecanique.model.forces import Force
from mecanique.model.joints import Fixed, Revolute
from mecanique.model.mechanism import Mechanism

EARTH_RATE = 7.292115e-5
"""Rate of the earth's rotation [rad/s] (WGS 84, NIMA TR8350.2, 2000, table 3.1)."""

_AXES = {"south": (-1.0, 0.0), "east": (0.0, 1.0), "north": (1.0, 0.0), "west": (0.0, -1.0)}
"""Components of north along x and y, by where x points: y is then east, north, west, south."""


def on_turning_earth(
    mechanism: Mechanism,
    latitude: float,
    *,
    facing: Literal["south", "east", "north", "west"] = "south",
    rate: float = EARTH_RATE,
) -> Mechanism:
    """Return the mechanism on ground that turns with the earth, in the same coordinates.

    The axis goes through the world's origin, and each body's weight is a force in the ground's
    axes: g contains the centrifugal acceleration that comes from the distance to the earth's axis.

    Args:
        mechanism: on ground at rest; world axes: z up, x where `facing` says.
        latitude: [rad], positive in the north.
        facing: where the world's x axis points: "south", "east", "north" or "west".
        rate: of the earth's rotation [rad/s].

    Raises:
        InputError: if the latitude is not within ±π/2, or `facing` is none of the four.
    """
    latitude = finite(latitude, "the latitude")
    if not abs(latitude) <= np.pi / 2:
        raise InputError(
            f"expected a latitude within ±π/2 rad, got {latitude:g}; of degrees take numpy.radians"
        )
    if facing not in _AXES:
        raise InputError(f"expected facing among {', '.join(_AXES)}, got {facing!r}")
    along_x, along_y = (north * float(np.cos(latitude)) for north in _AXES[facing])
    names = _names_in(mechanism)
    stars, earth, place = (_free(name, names) for name in ("stars", "earth_turn", "place"))
    axis = (along_x, along_y, float(np.sin(latitude)))
    weights = []
    for body in mechanism.bodies:
        if body.name != mechanism.ground and mechanism.evaluate(body.mass) > 0:
            name = _free(f"weight of {body.name}", names)
            pull = tuple(body.mass * g for g in mechanism.gravity)
            weights.append(Force(name, body.name, body.center, pull, axes=place))
    forces = tuple(_turn(force, place) for force in mechanism.forces)
    elements = tuple(
        replace(each, axes=place)
        if isinstance(each, (Cord, Belt)) and each.axes == "world"
        else each
        for each in mechanism.elements
    )
    old = mechanism.coordinates
    return replace(
        mechanism,
        bodies=(Body(stars), *mechanism.bodies, Body(place)),
        joints=(
            Revolute(earth, stars, mechanism.ground, axis=axis, coordinate=earth),
            Fixed(place, mechanism.ground, place),
            *mechanism.joints,
        ),
        forces=(*forces, *weights),
        elements=elements,
        coordinates=Coordinates(old.names, {**old.driven, earth: rate * time()}, old.limits),
        gravity=(0.0, 0.0, 0.0),
        ground=stars,
    )


def _names_in(mechanism: Mechanism) -> set[str]:
    """The names that are taken."""
    things = (*mechanism.bodies, *mechanism.joints, *mechanism.forces)
    letters = (*mechanism.coordinates, *mechanism.coordinates.driven, *mechanism.values)
    signals = (signal.symbol for signal in mechanism.inputs)
    return {*(thing.name for thing in things), *letters, *signals, "world"}


def _free(name: str, taken: set[str]) -> str:
    while name in taken:
        name += "_"
    return name


def _turn(force: AnyForce, place: str) -> AnyForce:
    """A force in world axes is one in the ground's axes now."""
    if isinstance(force, BodyLoad) and force.wrench.axes == "world":
        fixed = {"axes": place}
        return replace(force, **fixed)
    return force
