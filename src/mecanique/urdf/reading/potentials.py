"""Potentials in URDF: elements of our own, which other programs ignore.

    <mecanique:potential name="well" joint="slide" potential="-q**2 + 2*q**4"/>
    <mecanique:central_force name="sun" link_a="ground" point_a="0 0 0" link_b="planet"
        point_b="0 0 0" potential="-10/distance"/>

In the first q is the joint's coordinate, in the second distance that of the two points.
"""

from __future__ import annotations

from collections.abc import Collection, Iterable, Mapping
from dataclasses import replace

from mecanique.model.expression import DISTANCE, Scalar, coordinate, plain
from mecanique.model.force_base import AnyForce
from mecanique.model.forces import CentralForce, Potential
from mecanique.model.joints import Joint
from mecanique.model.mechanism import Mechanism
from mecanique.model.placement import vector
from mecanique.urdf.dialect import CENTRAL_FORCE, POTENTIAL
from mecanique.urdf.findings import Report
from mecanique.urdf.markup import Element, Tag, numbers
from mecanique.urdf.names import Names
from mecanique.urdf.reading.fields import name_of
from mecanique.urdf.reading.fields import numbers as read_numbers
from mecanique.urdf.reading.velocities import read_expression, write_expression

_JOINT_LETTER = "q"
"""What a potential calls the coordinate of its joint in the text."""


def potential_tag(
    mechanism: Mechanism, force: Potential | CentralForce, anchors: Mapping[str, str]
) -> Tag:
    """Return the element of a potential."""
    if isinstance(force, Potential):
        coordinate = mechanism.joint(force.joint).coordinates[-1]
        V = _rename(_put(force.potential, mechanism), coordinate, _JOINT_LETTER)
        return Tag(POTENTIAL, name=force.name, joint=force.joint, potential=write_expression(V))
    where = f"force {force.name!r}"
    ends = {}
    for side, end in zip("ab", force.ends, strict=True):
        ends[f"link_{side}"] = anchors.get(end.body, end.body)
        ends[f"point_{side}"] = numbers(mechanism.evaluate_all(end.point), where)
    V = write_expression(_put(force.potential, mechanism))
    return Tag(CENTRAL_FORCE, name=force.name, **ends, potential=V)


def read_potential(
    element: Element,
    links: Collection[str],
    joints: Collection[str],
    names: Names,
    report: Report,
) -> Potential | CentralForce | None:
    """Return the potential that an element describes; None if faults were reported."""
    name = name_of(element, report)
    where = f"force {name!r}"
    of_joint = element.tag == POTENTIAL
    letter = _JOINT_LETTER if of_joint else DISTANCE
    V = read_expression(element, "potential", report, where, f"the letter {letter}")
    roles, kind = (("joint",), "joint") if of_joint else (("link_a", "link_b"), "link")
    ends = [name_of(element, report, role, where) for role in roles]
    known = joints if of_joint else links
    for end in ends:
        if end is not None and end not in known:
            report.add("M603", element, where, f"{end!r} is no {kind}")
            return None
    if not of_joint and ends[0] == ends[1]:
        report.add("M603", element, where, f"both of its ends are on link {ends[0]!r}")
        return None
    if name is None or V is None or None in ends:
        return None
    if of_joint:
        return Potential(names.free(name), ends[0] or "", V)
    at_a, at_b = (read_numbers(element, f"point_{side}", 3, report, where) for side in "ab")
    if at_a is None or at_b is None:
        return None
    points = vector(at_a, "point_a"), vector(at_b, "point_b")
    a, b = (end or "" for end in ends)
    return CentralForce(names.free(name), a, points[0], b, points[1], V)


def with_own_letters(
    forces: Iterable[AnyForce], joints: Mapping[str, Joint]
) -> tuple[AnyForce, ...]:
    """Return forces that were read, with potentials in the coordinates of their joints."""
    return tuple(
        replace(
            force,
            potential=_rename(force.potential, _JOINT_LETTER, joints[force.joint].coordinates[-1]),
        )
        if isinstance(force, Potential) and joints[force.joint].coordinates
        else force
        for force in forces
    )


def _put(scalar: Scalar, mechanism: Mechanism) -> Scalar:
    """Return an expression with the numbers of parameters."""
    scalar = plain(scalar)
    values = {coordinate(symbol): value for symbol, value in mechanism.values.items()}
    return scalar if isinstance(scalar, float) else scalar.subs(values)


def _rename(scalar: Scalar, old: str, new: str) -> Scalar:
    scalar = plain(scalar)
    return scalar if isinstance(scalar, float) else scalar.subs(coordinate(old), coordinate(new))
