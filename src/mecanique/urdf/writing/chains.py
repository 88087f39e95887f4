"""Joints of a mechanism as the simpler joints that URDF has.

A planar joint is two slides and a hinge, a universal joint two hinges, with massless links between
them: the `planar` type of URDF is read differently by different programs, and there is no type for
the other.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from typing import Literal, TypeAlias, final

from mecanique.errors import InputError
from mecanique.model.joints import (
    Fixed,
    Floating,
    Joint,
    Limits,
    Planar,
    Prismatic,
    Revolute,
    Spherical,
    Universal,
)
from mecanique.model.mechanism import Mechanism

__all__ = ["Kind", "SimpleJoint", "chains", "unused"]

Kind: TypeAlias = Literal["fixed", "continuous", "revolute", "prismatic", "floating", "ball"]

_INF = float("inf")
_X, _Y = (1.0, 0.0, 0.0), (0.0, 1.0, 0.0)


@final
@dataclass(frozen=True)
class SimpleJoint:
    """A joint as URDF has it.

    Args:
        name: its name.
        kind: its type; "ball" for the type that only Drake has.
        parent: name of the parent link.
        child: name of the child link.
        xyz: shape (3,), where its frame stands in the parent [m].
        rpy: shape (3,), how its frame is turned in the parent [rad].
        axis: shape (3,), None for a joint without.
        limits: bounds, if any.
    """

    name: str
    kind: Kind
    parent: str
    child: str
    xyz: tuple[float, float, float] = (0.0, 0.0, 0.0)
    rpy: tuple[float, float, float] = (0.0, 0.0, 0.0)
    axis: tuple[float, float, float] | None = None
    limits: Limits | None = None


def chains(
    mechanism: Mechanism, spherical: Literal["ball", "floating"] = "ball"
) -> dict[str, tuple[SimpleJoint, ...]]:
    """Return the simple joints of each joint, by its name; the last bears its name and child.

    Args:
        mechanism: the mechanism.
        spherical: the type a `Spherical` joint becomes.
    """
    if spherical not in ("ball", "floating"):
        raise InputError(f"expected 'ball' or 'floating' for a spherical joint, got {spherical!r}")
    joints = {joint.name for joint in mechanism.joints}
    links = {body.name for body in mechanism.bodies}
    return {
        joint.name: tuple(_chain(mechanism, joint, spherical, joints, links))
        for joint in mechanism.joints
    }


def unused(name: str, taken: Iterable[str]) -> str:
    """Return the name, with underscores behind it until it is none of those taken."""
    taken = set(taken)
    while name in taken:
        name += "_"
    return name


def _chain(
    mechanism: Mechanism,
    joint: Joint,
    spherical: Literal["ball", "floating"],
    joints: set[str],
    links: set[str],
) -> list[SimpleJoint]:
    steps: list[tuple[Kind, str, tuple[float, float, float] | None]]
    limits: Limits | None = None
    match joint:
        case Fixed():
            steps = [("fixed", "", None)]
        case Revolute():
            limits = joint.limits
            bounded = limits is not None and (limits.lower > -_INF or limits.upper < _INF)
            steps = [("revolute" if bounded else "continuous", "", joint.axis)]
        case Prismatic():
            limits = joint.limits
            steps = [("prismatic", "", joint.axis)]
        case Planar():
            along, across = joint.directions
            steps = [
                ("prismatic", "x", along),
                ("prismatic", "y", across),
                ("continuous", "", joint.axis),
            ]
        case Universal():
            steps = [("continuous", "x", _X), ("continuous", "", _Y)]
        case Floating():
            steps = [("floating", "", None)]
        case Spherical():
            steps = [(spherical, "", None)]
    chain: list[SimpleJoint] = []
    parent = joint.parent
    for kind, suffix, axis in steps:
        name, child = joint.name, joint.child
        if suffix:
            name, child = unused(f"{name}_{suffix}", joints), unused(f"{child}_{suffix}", links)
            joints.add(name)
            links.add(child)
        chain.append(SimpleJoint(name, kind, parent, child, axis=axis, limits=limits))
        parent = child
    place = joint.origin
    x, y, z, roll, pitch, yaw = (mechanism.evaluate(scalar) for scalar in (*place.xyz, *place.rpy))
    first = chain[0]
    chain[0] = SimpleJoint(
        first.name,
        first.kind,
        first.parent,
        first.child,
        (x, y, z),
        (roll, pitch, yaw),
        first.axis,
        first.limits,
    )
    return chain
