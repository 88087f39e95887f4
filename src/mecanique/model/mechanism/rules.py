"""What the numbers of a sound mechanism keep to, stated once for Python and for pages."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping

from mecanique.model.constraint_base import Rule
from mecanique.model.expression import Scalar, plain, symbols_in
from mecanique.model.joint_base import Single
from mecanique.model.mechanism.description import Description

MASS = "its mass is negative ({} kg)"
MOMENT = "its inertia has a negative principal moment ({} kg·m²)"
TRIANGLE = (
    "its principal moments break the triangle inequality ({} + {} < {} kg·m²): "
    "no mass is spread like that"
)


def rules_of(m: Description) -> Iterator[Rule]:
    """Yield what the parameters of a mechanism keep to, but for masses and inertias.

    Springs and dampers that would feed energy in are refused: write a Force for those.
    """
    for joint in m.joints:
        where = f"joint {joint.name!r}"
        yield from _finite(f"{where}: its origin", *joint.origin.xyz, *joint.origin.rpy)
        if isinstance(joint, Single):
            yield Rule(where, ": its armature is negative", gap=joint.armature, endless=True)
    yield from _finite("gravity", *m.gravity)
    for name, (lower, upper) in m.coordinates.intervals.items():
        where, words = f"coordinate {name!r}", ": its lower limit {} is not below its upper {}"
        width = plain(upper) - plain(lower)
        yield Rule(where, words, (lower, upper), width, strict=True, endless=True)
    for loop in m.loops:
        if loop.kind == "distance":
            words = ": expected a length above 0, got {}"
            yield Rule(f"loop {loop.name!r}", words, (loop.length,), loop.length, strict=True)
    for contact in m.contacts:
        yield from contact.rules()
    for element in m.switching:
        yield from element.rules()
    for force in m.forces:
        for stated in force.stated:
            words = f": expected a {stated.name} of at least 0, got {{}}"
            for scalar in stated.scalars if stated.positive else ():
                yield Rule(f"force {force.name!r}", words, (scalar,), scalar)
    yield from _list_finite(m)


def _list_finite(m: Description) -> Iterator[Rule]:
    """What is known before any motion must be finite: it would only come back as NaN."""
    for name, scalar in m.coordinates.driven.items():
        yield from _finite(f"the map of {name!r}", scalar)
    for loop in m.loops:
        for frame in (loop.frame_a, loop.frame_b):
            yield from _finite(f"loop {loop.name!r}: its frame", *frame.xyz, *frame.rpy)
    for contact in m.contacts:
        yield from _finite(f"contact {contact.name!r}: its geometry", *contact.scalars)
    for element in m.switching:
        yield from _finite(f"{element.name!r}: what it states", *element.constants)
    for force in m.forces:
        for stated in force.stated:
            if not stated.positive:
                yield from _finite(f"force {force.name!r}: its {stated.name}", *stated.scalars)


def _finite(where: str, *scalars: Scalar) -> Iterator[Rule]:
    yield from (Rule(where, " is not finite", (scalar,)) for scalar in scalars)


def find_broken(rules: Iterable[Rule], values: Mapping[str, float]) -> list[str]:
    """Return the faults of rules, each once; what varies in a motion is not judged."""
    faults: list[str] = []
    fault = None
    for rule in rules:
        varies = any(not symbols_in(scalar) <= values.keys() for scalar in rule.scalars)
        if varies or (rule.follows and fault):
            continue
        fault = rule.fault(values)
        if fault and fault not in faults:
            faults.append(fault)
    return faults
