"""Find how unit forces of guiding elements act on the bodies, in any arithmetic.

A cord that runs around a wheel of radius r in the sense s leaves it at ρ = s r e × n from the
center, where e is the direction of the straight run and n the normal. Between wheels P and Q, with
d from center to center, d + ρ_Q − ρ_P = l e; hence with h = s_Q r_Q − s_P r_P, l² = d² − h² and
d² e = l d + h d × n.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from fractions import Fraction
from typing import Any, TypeAlias, final

from mecanique.derivation.mechanics.vectors import Triple, add, apply, cross, dot, scale
from mecanique.derivation.tolerances import OPPOSITE
from mecanique.derivation.tree.poses import (
    Arithmetic,
    Matrix,
    combination,
    exact_direction,
    origin,
    times_point,
)
from mecanique.model import Belt, Cord, Gear, Loop, Mechanism, Placement, Rack
from mecanique.model.constraints.loops import CLOSED
from mecanique.model.expression import Scalar
from mecanique.model.joint_base import Single
from mecanique.model.mechanism.element_laws import Bevel, bevel_of

_HERE = (0.0, 0.0, 0.0)

Three: TypeAlias = "list[Any]"
"""Components along x, y, z of the world, in some arithmetic."""


@final
@dataclass(frozen=True, eq=False)
class UnitForce:
    """The action of an element's unit force on one body."""

    index: int  # index among the mechanism's unknown forces
    body: str
    point: Three  # its point of action in the world [m]
    force: Three  # components along the world's axes
    moment: Three  # moment about that point
    # whether it grows with the force's magnitude, as the separating force of gears
    pressed: bool = False


@final
@dataclass(frozen=True)
class Ground:
    """The poses of bodies in some arithmetic, with the functions that it needs."""

    point: Callable[[str, Sequence[Scalar]], Three]  # returns a point of a body in the world
    # returns the rotation of a body, three rows of three scalars
    turn: Callable[[str], Sequence[Sequence[Any]]]
    tilt: Callable[[Placement], Sequence[Sequence[Any]]]  # returns the rotation of a frame
    scalar: Callable[[Scalar | Fraction], Any]  # converts a scalar of the description
    root: Callable[[Any], Any]  # returns the square root of a squared distance
    # returns the cosine and the sine of an angle of the description
    wave: Callable[[Scalar], tuple[Any, Any]]
    ratio: Callable[[Any, Any], Any]  # returns a quotient
    # gives a vector another length, where that is written out otherwise than with `ratio`
    stretch: Callable[[Three, Any], Three] | None = None
    opposite: float = OPPOSITE  # keeps quotients of numbers finite where normals are opposite

    def lengthen(self, vector: Three, length: Any) -> Three:
        """Return the vector of a given length along another one."""
        if self.stretch is not None:
            return self.stretch(vector, length)
        factor = self.ratio(length, self.root(dot(vector, vector)))
        return [factor * component for component in vector]

    def frame(self, body: str, placement: Placement) -> tuple[list[Three], Three]:
        """Return the axes and the origin of a frame fixed in a body, in the world."""
        turn = self.turn(body)
        axes = [apply(turn, axis) for axis in zip(*self.tilt(placement), strict=True)]
        return axes, self.point(body, placement.xyz)


def ground_of(
    pose: Callable[[str], Matrix], values: Mapping[str, Any], arithmetic: Arithmetic
) -> Ground:
    """Return the poses of bodies in some arithmetic."""

    def number(scalar: Scalar | Fraction) -> Any:
        return arithmetic(scalar, values)

    def wave(angle: Scalar) -> tuple[Any, Any]:
        sine, cosine = arithmetic.sine_cosine(number(angle))
        return cosine, sine

    return Ground(
        point=lambda body, xyz: times_point(pose(body), [number(c) for c in xyz]),
        turn=lambda body: [row[:3] for row in pose(body)],
        tilt=lambda placement: [row[:3] for row in origin(placement, values, arithmetic)],
        scalar=number,
        root=arithmetic.function("sqrt"),
        wave=wave,
        ratio=lambda a, b: a / b,
    )


def unit_forces(mechanism: Mechanism, ground: Ground) -> list[UnitForce]:
    """Return the actions of all elements' unit forces on the bodies."""
    units: list[UnitForce] = []
    first = 0
    for element in mechanism.elements:
        match element:
            case Cord() | Belt():
                of_element = _act_cord(element, ground)
            case Gear() | Rack():
                of_element = _act_teeth(mechanism, element, ground)
            case _:
                of_element = act_loop(element, ground)
        units += [replace(unit, index=first + unit.index) for unit in of_element]
        first += len(element.forces)
    return units


def _act_cord(cord: Cord | Belt, ground: Ground) -> Iterator[UnitForce]:
    """Yield the forces of a cord's straight runs, each of which pulls both of its ends along e."""
    n: Three = [float(c) for c in cord.normal]
    if cord.axes != "world":
        n = _find_direction(ground, cord.axes, cord.normal)
    centers = [ground.point(stop.body, stop.center) for stop in cord.stops]
    reach = [ground.scalar(stop.radius) * stop.sense for stop in cord.stops]
    for k, part in enumerate(cord.parts):
        d = _subtract(centers[k + 1], centers[k])
        h = reach[k + 1] - reach[k]
        square = dot(d, d)
        length = ground.root(square - h * h)
        # between two free ends, or two equal wheels, the run is along d
        across = add(scale(length, d), scale(h, cross(d, n)))
        e = [ground.ratio(component, square) for component in across]
        rho = cross(e, n)
        for stop, sign in ((k, 1), (k + 1, -1)):
            yield UnitForce(
                index=part,
                body=cord.stops[stop].body,
                point=add(centers[stop], scale(reach[stop], rho)),
                force=scale(sign, e),
                moment=scale(0, e),
            )


def _act_teeth(mechanism: Mechanism, mesh: Gear | Rack, ground: Ground) -> Iterator[UnitForce]:
    """Yield the forces where pitch circles touch: along the tangent n × u, and apart along u."""
    a, b = (mechanism.joint(name) for name in mesh.joints)
    assert isinstance(a, Single)
    assert isinstance(b, Single)
    n, line = (_find_direction(ground, joint.child, joint.axis) for joint in (a, b))
    center = ground.point(a.child, _HERE)
    cosine, sine = ground.wave(mesh.pressure_angle)
    bevel = bevel_of(mechanism, mesh) if isinstance(mesh, Gear) else None
    if isinstance(mesh, Gear) and bevel is not None:
        yield from _act_bevel(mesh, bevel, ground, ((a.child, n), (b.child, line)))
        return
    if isinstance(mesh, Gear):
        d = _reject(_subtract(ground.point(b.child, _HERE), center), n)
        length = ground.scalar(mesh.distance)
        apart = -1 if mesh.internal else 1
    else:
        d = _reject(_reject(_subtract(ground.point(b.child, mesh.point), center), line), n)
        length, apart = ground.scalar(mesh.radius), 1
    u = [ground.ratio(c, length) for c in d]
    touch = add(center, scale(ground.scalar(mesh.radius), u))
    along, away = cross(n, u), u
    for body, sign in ((b.child, 1), (a.child, -1)):
        pushing = scale(sign * cosine, along)
        parting = scale(sign * apart * sine, away)
        yield UnitForce(0, body, touch, force=pushing, moment=scale(0, u))
        yield UnitForce(0, body, touch, force=parting, moment=scale(0, u), pressed=True)


def _act_bevel(
    gear: Gear, bevel: Bevel, ground: Ground, wheels: tuple[tuple[str, Three], tuple[str, Three]]
) -> Iterator[UnitForce]:
    """Yield the forces where pitch cones touch: along n × u, and apart, normal to the cones."""
    (a, n), (b, line) = wheels
    c, s, (i, k) = bevel.cosine, bevel.sine, bevel.sides
    r, R = ground.scalar(gear.radius), ground.scalar(gear.other_radius)
    # normal to the wheel's axis, toward the other's
    w = [(y - x * c) * (1 / s) for x, y in zip(n, line, strict=True)]
    touch = add(ground.point(a, _HERE), scale(r * i, w))
    height = (R * k + r * (i * c)) * (1 / s)
    ray = ground.root((r * r + R * R + r * R * (2 * i * k * c)) * (1 / s**2))
    # normal to the ray from the apex, in the plane of the axes, away from the wheel
    lean = [(height * y - r * i * x) * bevel.ahead for x, y in zip(n, w, strict=True)]
    away = [ground.ratio(x, ray) for x in lean]
    along = [x * i for x in cross(n, w)]
    cosine, sine = ground.wave(gear.pressure_angle)
    for body, sign in ((b, 1), (a, -1)):
        pushing, parting = scale(sign * cosine, along), scale(sign * sine, away)
        yield UnitForce(0, body, touch, force=pushing, moment=scale(0, along))
        yield UnitForce(0, body, touch, force=parting, moment=scale(0, along), pressed=True)


def _find_direction(ground: Ground, body: str, axis: Sequence[float]) -> Three:
    n = [ground.scalar(component) for component in exact_direction(axis)]
    return [ground.scalar(0.0) + combination(line[:3], n) for line in ground.turn(body)]


def _reject(d: Three, e: Three) -> Triple:
    """Return a vector less its projection on a unit vector."""
    return _subtract(d, scale(dot(d, e), e))


def act_loop(loop: Loop, ground: Ground) -> Iterator[UnitForce]:
    """Yield the force or moment of body a on body b for each row that the loop closes."""
    b = ground.point(loop.body_b, loop.frame_b.xyz)
    turn, frame = ground.turn(loop.body_a), ground.tilt(loop.frame_a)
    for index, row in enumerate(CLOSED[loop.kind]):
        if row == "length":
            d = _subtract(b, ground.point(loop.body_a, loop.frame_a.xyz))
            length = ground.root(dot(d, d))
            along = [ground.ratio(c, length) for c in d]
        else:
            column = [line["xyz".index(row[-1])] for line in frame]
            along = [ground.scalar(0.0) + combination(line[:3], column) for line in turn]
        nothing = scale(0, along)
        for body, action in ((loop.body_b, along), (loop.body_a, [-c for c in along])):
            force, moment = (nothing, action) if row.startswith("r") else (action, nothing)
            yield UnitForce(index, body, b, force, moment)


def _subtract(a: Three, b: Three) -> Triple:
    return add(a, scale(-1.0, b))
