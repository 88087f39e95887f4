"""Faults of loops, contacts, velocity constraints and elements that guide, a sentence each."""

from __future__ import annotations

from collections.abc import Iterable, Iterator

from mecanique.model.constraints.gears import Gear, Rack
from mecanique.model.constraints.velocity_constraints import is_integrable
from mecanique.model.expression import symbols_in
from mecanique.model.joints import Prismatic, Revolute
from mecanique.model.mechanism.description import Description


def find_constraint_faults(m: Description) -> Iterator[str]:
    """Yield what is wrong with the constraints of a mechanism before any value is known.

    Args:
        m: the mechanism, not yet known to be sound.
    """
    yield from _loops(m)
    yield from _contacts(m)
    yield from _velocity_constraints(m)
    yield from _elements(m)


def _strangers(m: Description, where: str, names: Iterable[str]) -> Iterator[str]:
    """Names that no body has."""
    bodies = {body.name for body in m.bodies}
    return (f"{where}: {name!r} is no body" for name in names if name not in bodies)


def _loops(m: Description) -> Iterator[str]:
    for loop in m.loops:
        yield from _strangers(m, f"loop {loop.name!r}", (loop.body_a, loop.body_b))
        if loop.body_a == loop.body_b:
            yield f"loop {loop.name!r} joins body {loop.body_a!r} to itself"


def _contacts(m: Description) -> Iterator[str]:
    for contact in m.contacts:
        where = f"contact {contact.name!r}"
        yield from _strangers(m, where, (contact.body, contact.on))
        if contact.body == contact.on:
            yield f"{where}: body {contact.body!r} touches itself"


def _elements(m: Description) -> Iterator[str]:
    for element in m.elements:
        yield from _strangers(m, f"element {element.name!r}", element.bodies)
        if isinstance(element, (Gear, Rack)):
            yield from _meshes(m, element)


def _meshes(m: Description, element: Gear | Rack) -> Iterator[str]:
    kinds = Revolute, Revolute if isinstance(element, Gear) else Prismatic
    joints = {joint.name: joint for joint in m.joints}
    for name, kind in zip(element.joints, kinds, strict=True):
        if not isinstance(joints.get(name), kind):
            yield f"element {element.name!r}: expected the name of a {kind.noun}, got {name!r}"


def _velocity_constraints(m: Description) -> Iterator[str]:
    of_quaternions = {name for j in m.joints if j.quaternion for name in j.coordinates}
    plain_ones = [name for name in m.coordinates.names if name not in of_quaternions]
    known = {*plain_ones, *(p.symbol for p in m.parameters), "t"}
    sound = bool(m.velocity_constraints)
    for constraint in m.velocity_constraints:
        where = f"velocity constraint {constraint.name!r}"
        symbols = {symbol for scalar in constraint.scalars for symbol in symbols_in(scalar)}
        unknown = sorted(({*constraint.terms} - {*m.velocities, *plain_ones}) | (symbols - known))
        if unknown or not constraint.terms:
            sound = False
            fault = (
                f"depends on {', '.join(map(repr, unknown))}, no coordinate or parameter"
                if unknown
                else "is empty"
            )
            yield f"{where} {fault}"
    if not sound:
        return
    rates = {f"{name}'" for name in plain_ones}
    used = {name for c in m.velocity_constraints for name in c.terms}
    values = {p.symbol: p.value for p in m.parameters}
    # of quasi-velocities no position is the integral
    if used <= {*plain_ones, *rates} and is_integrable(m.velocity_constraints, plain_ones, values):
        names = ", ".join(repr(constraint.name) for constraint in m.velocity_constraints)
        yield (
            f"velocity constraint {names} is the rate of a constraint on positions; "
            "state that one instead, by the coordinate map or a loop, and the number of "
            "coordinates falls"
        )
