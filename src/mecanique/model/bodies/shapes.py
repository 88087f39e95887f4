"""Homogeneous bodies: mass, center of mass, inertia and a drawing, from one table.

Moments of inertia are those of the standard table (e.g. Goldstein, Classical Mechanics, 1950; Beer
& Johnston, Vector Mechanics for Engineers, inside cover); tests check each one by quadrature.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

from mecanique.errors import InputError
from mecanique.model.bodies.body import Shape, as_tuple, combine
from mecanique.model.bodies.visuals import (
    Box,
    Cylinder,
    Geometry,
    Rgba,
    Sphere,
    Visual,
    extent,
    extents,
)
from mecanique.model.expression import Scalar, Vector, plain
from mecanique.model.placement import Placement, rpy_along, unit_vector, vector

_BLUE: Rgba = (0.0, 0.447, 0.698, 1.0)
_ORANGE: Rgba = (0.902, 0.624, 0.0, 1.0)
_CLEAR_BLUE: Rgba = (*_BLUE[:3], 0.5)
_CLEAR_ORANGE: Rgba = (*_ORANGE[:3], 0.5)

HOMOGENEOUS = {
    "slender rod": "m l²/12 about a transverse axis",
    "solid box": "m (b² + c²)/12 about the edge a",
    "thin plate": "m b²/12 about the edge a, m (a² + b²)/12 about the normal",
    "thin disk": "m r²/4 about a diameter, m r²/2 about the axis",
    "thin ring": "m r²/2 about a diameter, m r² about the axis",
    "solid cylinder": "m (3 r² + l²)/12 across the axis, m r²/2 about it",
    "solid ball": "2 m r²/5",
    "thin shell": "2 m r²/3",
    "solid cone": "3 m (4 r² + h²)/80 across the axis, 3 m r²/10 about it",
}
"""Moments of inertia about the center of mass by form; the table of docs/conventions.md, H1 on."""


def massless(*visuals: Visual) -> Shape:
    """Return a shape without mass, only drawn.

    Args:
        visuals: what is drawn.

    Returns:
        The shape, to be given to a `Body`.

    Example:
        >>> mq.massless().mass
        0.0
    """
    return Shape(0.0, visuals=visuals)


def particle(mass: Scalar, at: Vector = (0.0, 0.0, 0.0), radius: Scalar = 0.05) -> Shape:
    """Return a particle: mass at a point.

    Args:
        mass: [kg].
        at: shape (3,), where it is [m].
        radius: of the ball drawn [m].

    Returns:
        The shape, to be given to a `Body`.

    Example:
        >>> mq.particle(2.0, at=(0, 0, -1)).center
        (0.0, 0.0, -1.0)
    """
    drawing = Visual(Sphere(radius), rgba=_ORANGE)
    return Shape(extent(mass, "mass", "kg"), visuals=(drawing,), form="particle").at(at)


def cloud(masses: Sequence[Scalar], points: Sequence[Vector], radius: Scalar = 0.03) -> Shape:
    """Return a rigid cloud of particles.

    Args:
        masses: shape (n,) [kg].
        points: shape (n, 3) [m].
        radius: of the balls drawn [m].

    Returns:
        The shape, to be given to a `Body`.

    Raises:
        InputError: if there is not one mass for each point.

    Example:
        >>> mq.cloud([1.0, 1.0], [(0, 0, 0), (1, 0, 0)]).center
        (0.5, 0.0, 0.0)
    """
    masses, points = as_tuple(masses, "masses"), as_tuple(points, "points")
    if len(masses) != len(points) or not masses:
        raise InputError(
            f"expected one mass for each point, got {len(masses)} masses and {len(points)} points"
        )
    return combine([particle(m, p, radius) for m, p in zip(masses, points, strict=True)])


def rod(
    mass: Scalar,
    length: Scalar,
    direction: Vector = (0.0, 0.0, -1.0),
    start: Vector = (0.0, 0.0, 0.0),
    radius: Scalar = 0.02,
) -> Shape:
    """Return a slender rod along a direction: m l²/12 about its center, m l²/3 about an end.

    Args:
        mass: [kg].
        length: [m].
        direction: shape (3,), where it points; numbers, any length but zero.
        start: shape (3,), one end [m].
        radius: of the cylinder drawn [m].

    Returns:
        The shape, to be given to a `Body`.

    Raises:
        InputError: if the direction is not three numbers with a length.

    Example:
        >>> mq.rod(mq.Parameter('m', 1.0), mq.Parameter('l', 1.0)).inertia[0]
        l**2*m/12
    """
    d = unit_vector(direction, "the direction of a rod")
    mass, length = extent(mass, "mass", "kg"), extent(length, "length")
    across = mass * length**2 / 12
    inertia = (
        across * _number(1 - d[0] * d[0]),
        across * _number(1 - d[1] * d[1]),
        across * _number(1 - d[2] * d[2]),
        across * _number(-d[0] * d[1]),
        across * _number(-d[0] * d[2]),
        across * _number(-d[1] * d[2]),
    )
    middle = tuple(
        plain(s) + length * _number(c) / 2 for s, c in zip(vector(start, "start"), d, strict=True)
    )
    drawing = Visual(Cylinder(radius, length), Placement(middle, rpy_along(d)), _BLUE)
    return Shape(mass, middle, inertia, (drawing,), "slender rod")


def bar(
    length: Scalar,
    direction: Vector = (0.0, 0.0, -1.0),
    start: Vector = (0.0, 0.0, 0.0),
    radius: Scalar = 0.02,
) -> Shape:
    """Return a rigid bar without mass.

    Args:
        length: [m].
        direction: shape (3,), where it points; numbers, any length but zero.
        start: shape (3,), one end [m].
        radius: of the cylinder drawn [m].

    Returns:
        The shape, to be given to a `Body`.

    Example:
        >>> mq.bar(2.0).mass
        0.0
    """
    return replace(
        rod(0.0, length, direction, start, radius),
        mass=0.0,
        center=(0.0, 0.0, 0.0),
        inertia=(0.0,) * 6,
        form="",
    )


def box(mass: Scalar, size: Vector) -> Shape:
    """Return a solid box about its center: ixx = m (b² + c²)/12, and so on.

    Args:
        mass: [kg].
        size: shape (3,), edges a, b, c along x, y, z [m].

    Returns:
        The shape, to be given to a `Body`.

    Example:
        >>> mq.box(12.0, (1, 2, 3)).inertia[:3]
        (13.0, 10.0, 5.0)
    """
    a, b, c = extents(size, "box")
    mass = extent(mass, "mass", "kg")
    squares = (b**2 + c**2, a**2 + c**2, a**2 + b**2)
    moments = tuple(mass * square / 12 for square in squares)
    return _symmetric("solid box", mass, moments, Box((a, b, c)))


def plate(mass: Scalar, size: Sequence[Scalar], thickness: Scalar = 0.02) -> Shape:
    """Return a thin rectangular plate in its x-y plane: izz = m (a² + b²)/12.

    Args:
        mass: [kg].
        size: shape (2,), edges a, b along x, y [m].
        thickness: of the box drawn [m]; it adds no inertia.

    Returns:
        The shape, to be given to a `Body`.

    Example:
        >>> mq.plate(12.0, (1, 2)).inertia[2]
        5.0
    """
    try:
        a, b = size
    except (TypeError, ValueError):
        raise InputError(f"expected two edges of a plate, got {size!r}") from None
    a, b, thickness = extents((a, b, thickness), "plate")
    mass = extent(mass, "mass", "kg")
    moments = (mass * b**2 / 12, mass * a**2 / 12, mass * (a**2 + b**2) / 12)
    return _symmetric("thin plate", mass, moments, Box((a, b, thickness)))


def disk(mass: Scalar, radius: Scalar, thickness: Scalar = 0.02) -> Shape:
    """Return a thin disk in its x-y plane: izz = m r²/2.

    Args:
        mass: [kg].
        radius: [m].
        thickness: of the cylinder drawn [m]; it adds no inertia.

    Returns:
        The shape, to be given to a `Body`.

    Example:
        >>> mq.disk(2.0, 1.0).inertia[2]
        1.0
    """
    mass, radius = extent(mass, "mass", "kg"), extent(radius, "radius")
    across = mass * radius**2 / 4
    moments = (across, across, mass * radius**2 / 2)
    return _symmetric("thin disk", mass, moments, Cylinder(radius, thickness))


def ring(mass: Scalar, radius: Scalar, thickness: Scalar = 0.02) -> Shape:
    """Return a thin ring in its x-y plane: izz = m r².

    Args:
        mass: [kg].
        radius: [m].
        thickness: of the disk drawn [m]; it adds no inertia.

    Returns:
        The shape, to be given to a `Body`.

    Example:
        >>> mq.ring(2.0, 1.0).inertia[2]
        2.0
    """
    mass, radius = extent(mass, "mass", "kg"), extent(radius, "radius")
    across = mass * radius**2 / 2
    moments = (across, across, mass * radius**2)
    return _symmetric("thin ring", mass, moments, Cylinder(radius, thickness), _CLEAR_BLUE)


def cylinder(mass: Scalar, radius: Scalar, length: Scalar) -> Shape:
    """Return a solid cylinder along its z axis: izz = m r²/2, ixx = m (3 r² + l²)/12.

    Args:
        mass: [kg].
        radius: [m].
        length: [m].

    Returns:
        The shape, to be given to a `Body`.

    Example:
        >>> mq.cylinder(2.0, 1.0, 3.0).inertia[2]
        1.0
    """
    mass = extent(mass, "mass", "kg")
    radius, length = extent(radius, "radius"), extent(length, "length")
    across = mass * (3 * radius**2 + length**2) / 12
    moments = (across, across, mass * radius**2 / 2)
    return _symmetric("solid cylinder", mass, moments, Cylinder(radius, length))


def ball(mass: Scalar, radius: Scalar) -> Shape:
    """Return a solid ball: 2 m r²/5 about any diameter.

    Args:
        mass: [kg].
        radius: [m].

    Returns:
        The shape, to be given to a `Body`.

    Example:
        >>> mq.ball(5.0, 1.0).inertia[0]
        2.0
    """
    mass, radius = extent(mass, "mass", "kg"), extent(radius, "radius")
    moments = (2 * mass * radius**2 / 5,) * 3
    return _symmetric("solid ball", mass, moments, Sphere(radius), _ORANGE)


def shell(mass: Scalar, radius: Scalar) -> Shape:
    """Return a thin spherical shell: 2 m r²/3 about any diameter.

    Args:
        mass: [kg].
        radius: [m].

    Returns:
        The shape, to be given to a `Body`.

    Example:
        >>> mq.shell(3.0, 1.0).inertia[0]
        2.0
    """
    mass, radius = extent(mass, "mass", "kg"), extent(radius, "radius")
    moments = (2 * mass * radius**2 / 3,) * 3
    return _symmetric("thin shell", mass, moments, Sphere(radius), _CLEAR_ORANGE)


def cone(mass: Scalar, radius: Scalar, height: Scalar) -> Shape:
    """Return a solid cone, apex at its origin, axis along +z: center at 3 h/4, izz = 3 m r²/10.

    Args:
        mass: [kg].
        radius: of the base [m].
        height: [m].

    Returns:
        The shape, to be given to a `Body`.

    Example:
        >>> mq.cone(1.0, 0.5, 4.0).center
        (0.0, 0.0, 3.0)
    """
    mass = extent(mass, "mass", "kg")
    radius, height = extent(radius, "radius"), extent(height, "height")
    across = 3 * mass * (4 * radius**2 + height**2) / 80
    inertia = (across, across, 3 * mass * radius**2 / 10, 0.0, 0.0, 0.0)
    base = Visual(Cylinder(radius, height / 8), Placement((0.0, 0.0, 15 * height / 16)), _BLUE)
    axis = Visual(Cylinder(radius / 8, height), Placement((0.0, 0.0, height / 2)), _BLUE)
    return Shape(mass, (0.0, 0.0, 3 * height / 4), inertia, (base, axis), "solid cone")


def _symmetric(
    form: str,
    mass: Scalar,
    moments: tuple[Scalar, ...],
    geometry: Geometry,
    rgba: Rgba = _BLUE,
) -> Shape:
    """A homogeneous body about its center, in its principal axes."""
    drawing = Visual(geometry, rgba=rgba)
    return Shape(mass, inertia=(*moments, 0.0, 0.0, 0.0), visuals=(drawing,), form=form)


def _number(value: float) -> float | int:
    """Whole numbers stay whole, so that symbolic inertias stay exact."""
    return int(value) if value == int(value) else value
