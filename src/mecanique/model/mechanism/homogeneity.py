"""Units: every expression of a mechanism is in the unit that its place asks for."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from fractions import Fraction
from typing import final

from mecanique.model.bodies.body import Shape
from mecanique.model.bodies.visuals import measure
from mecanique.model.expression import DISTANCE, POSITION, Scalar, symbols_in
from mecanique.model.forces import CentralForce, PotentialField
from mecanique.model.joint_base import UNITS, Single
from mecanique.model.mechanism.description import Description
from mecanique.model.placement import Placement
from mecanique.model.units import (
    PURE,
    Dimension,
    Dimensions,
    HomogeneityError,
    divide,
    read_unit,
    say_unit,
)


@final
@dataclass(frozen=True)
class _Place:
    """Expressions of one kind, where they stand and the unit they are to have."""

    where: str
    scalars: tuple[Scalar, ...]
    unit: str


def find_mismatches(m: Description) -> list[str]:
    """Return where a mechanism's expressions are not in the unit that their place asks for."""
    dimensions = dimensions_of(m)
    if not dimensions.declared:
        return []
    mismatches = []
    for place in _places(m, dimensions):
        try:
            for scalar in place.scalars:
                if not isinstance(scalar, float):
                    dimensions.refuse(scalar, place.unit)
        except HomogeneityError as error:
            mismatches.append(f"{place.where}: {error}")
    return [*mismatches, *_sums(m, dimensions)]


def hides_units(m: Description) -> bool:
    """Return whether numbers stand for quantities with units: all of them, or 2 in cos(2 t)."""
    from sympy import preorder_traversal

    dimensions = dimensions_of(m)
    laws = [x for force in m.forces for x in force.scalars]
    laws += [*m.coordinates.driven.values(), *(signal.signal for signal in m.inputs)]
    timed = (law for law in laws if not callable(law) and "t" in symbols_in(law))
    parts = (part for law in timed for part in preorder_traversal(law) if "t" in symbols_in(part))
    return not dimensions.declared or any(dimensions.of(part) is None for part in parts)


def dimensions_of(m: Description) -> Dimensions:
    """Return the dimensions of a mechanism's letters: parameters, inputs, q, v and t.

    A generalized coordinate that is no joint's own has that which the coordinate map asks for.
    """
    declared = {letter.symbol: read_unit(letter.unit) for letter in m.parameters if letter.unit}
    declared |= {letter.symbol: read_unit(letter.unit) for letter in m.inputs if letter.unit}
    states: dict[str, Dimension] = {"t": read_unit("s")}
    if any(isinstance(force, CentralForce) for force in m.forces):
        states[DISTANCE] = read_unit("m")
    if any(isinstance(force, PotentialField) for force in m.forces):
        states |= dict.fromkeys(POSITION, read_unit("m"))
    for joint in m.joints:
        for name, kind in zip(joint.coordinates, joint.kinds, strict=True):
            states[name] = read_unit(UNITS[kind])
        states |= dict.fromkeys(joint.linear_velocities, read_unit("m/s"))
        states |= dict.fromkeys(joint.angular_velocities, read_unit("rad/s"))
    driving: dict[str, list[str]] = {}
    for follower, expression in m.coordinates.driven.items():
        for symbol in symbols_in(expression):
            driving.setdefault(symbol, []).append(follower)
    for name in m.coordinates.names:
        if name not in states:
            its = _infer(m, name, driving.get(name, ()), Dimensions(declared, dict(states)))
            if its is not None:
                states[name] = its
                states[f"{name}'"] = divide(its, read_unit("s"))
    return Dimensions(declared, states)


def _infer(
    m: Description, name: str, followers: Iterable[str], known: Dimensions
) -> Dimension | None:
    for follower in followers:
        place = known.states.get(follower)
        expression = m.coordinates.driven[follower]
        dimension = None if place is None else _solve(expression, place, name, known)
        if dimension is not None:
            return dimension
    return None


def _solve(scalar: Scalar, its: Dimension, name: str, known: Dimensions) -> Dimension | None:
    """The dimension of a symbol by that of an expression it stands in, where this settles it."""
    if scalar.is_Symbol:
        return its
    parts = [part for part in scalar.args if name in symbols_in(part)]
    if scalar.is_Mul:
        if len(parts) != 1:
            return None
        try:
            rest = known.of(scalar / parts[0])
        except HomogeneityError:
            return None
        return None if rest is None else _solve(parts[0], divide(its, rest), name, known)
    if scalar.is_Pow and scalar.exp.is_Rational:
        its = tuple(x / Fraction(int(scalar.exp.p), int(scalar.exp.q)) for x in its)
    elif scalar.is_Function:
        its = PURE
    elif not scalar.is_Add:
        return None
    for part in parts:
        dimension = _solve(part, its, name, known)
        if dimension is not None:
            return dimension
    return None


def _places(m: Description, dimensions: Dimensions) -> Iterator[_Place]:
    yield _Place("gravity", m.gravity, "m/s²")
    for body in m.bodies:
        for shape in body.shapes:
            yield from _of_shape(f"body {body.name!r}", shape)
    for joint in m.joints:
        where = f"joint {joint.name!r}"
        yield from _of_frame(f"{where}: its origin", joint.origin)
        if isinstance(joint, Single):
            unit = "kg·m²" if joint.turns else "kg"
            yield _Place(f"{where}: its armature", (joint.armature,), unit)
    yield from _of_coordinates(m, dimensions)
    turns = {joint.name for joint in m.joints if isinstance(joint, Single) and joint.turns}
    for part in m.parts:
        about = getattr(part, "joint", "") in turns
        for stated in part.stated:
            unit = stated.units[-1 if about else 0]
            yield _Place(f"{part.title}: its {stated.name}", stated.scalars, unit)


def _of_shape(where: str, shape: Shape) -> Iterator[_Place]:
    yield _Place(f"{where}: its mass", (shape.mass,), "kg")
    yield _Place(f"{where}: its center of mass", shape.center, "m")
    yield _Place(f"{where}: its inertia", shape.inertia, "kg·m²")
    for visual in shape.visuals:
        kind, sizes = measure(visual.geometry)
        yield _Place(f"{where}: what is drawn of it", () if kind == "mesh" else sizes, "m")
        yield from _of_frame(f"{where}: the place of what is drawn of it", visual.placement)


def _of_frame(where: str, frame: Placement) -> Iterator[_Place]:
    yield _Place(where, frame.xyz, "m")
    yield _Place(f"{where}, its angles", frame.rpy, "rad")


def _of_coordinates(m: Description, dimensions: Dimensions) -> Iterator[_Place]:
    units = {
        name: UNITS[kind]
        for joint in m.joints
        for name, kind in zip(joint.coordinates, joint.kinds, strict=True)
    }
    for name, expression in m.coordinates.driven.items():
        yield _Place(f"the map of coordinate {name!r}", (expression,), units[name])
    for name, limits in m.coordinates.intervals.items():
        its = dimensions.states.get(name)
        if its is not None:
            yield _Place(f"the limits of coordinate {name!r}", limits, say_unit(its))
    for signal in m.inputs:
        if signal.unit and not callable(signal.signal):
            yield _Place(f"input {signal.symbol!r}", (signal.signal,), signal.unit)


def _sums(m: Description, dimensions: Dimensions) -> Iterator[str]:
    """Σ A_i v_i = b of the velocity constraints: all terms in one unit."""
    from sympy import Symbol

    for constraint in m.velocity_constraints:
        pairs = zip(m.velocities, constraint.along(m.velocities), strict=True)
        total = sum(A * Symbol(name) for name, A in pairs) - constraint.rate
        try:
            dimensions.of(total)
        except HomogeneityError as error:
            yield f"velocity constraint {constraint.name!r}: {error}"
