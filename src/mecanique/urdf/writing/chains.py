"""Joints of a mechanism as the simpler joints of URDF.

A planar joint is two slides and a hinge, a universal joint two hinges, with massless links between
them: the `planar` type of URDF is read differently by different programs, and there is no type for
the other.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, replace
from typing import Literal, TypeAlias, final

from mecanique.errors import InputError
from mecanique.model.joint_base import Limits, Single
from mecanique.model.joints import Joint
from mecanique.model.mechanism import Mechanism

Kind: TypeAlias = Literal["fixed", "continuous", "revolute", "prismatic", "floating", "ball"]


@final
@dataclass(frozen=True)
class SimpleJoint:
    """A joint of URDF.

    Args:
        name: its name.
        kind: its type; "ball" for the type that only Drake has.
        parent: name of the parent link.
        child: name of the child link.
        coordinate: name of its coordinate, if it has one alone.
        xyz: shape (3,), position of its frame in the parent [m].
        rpy: shape (3,), orientation of its frame in the parent [rad].
        axis: shape (3,), None for a joint without.
        limits: bounds, if any.
    """

    name: str
    kind: Kind
    parent: str
    child: str
    coordinate: str | None = None
    xyz: tuple[float, float, float] = (0.0, 0.0, 0.0)
    rpy: tuple[float, float, float] = (0.0, 0.0, 0.0)
    axis: tuple[float, float, float] | None = None
    limits: Limits | None = None


def chains(
    mechanism: Mechanism, spherical: Literal["ball", "floating"] = "ball"
) -> dict[str, tuple[SimpleJoint, ...]]:
    """Return the simple joints of each joint, by its name; the last has its name and child.

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


def free_name(name: str, taken: Iterable[str]) -> str:
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
    types: dict[str, Kind] = {
        "fixed": "fixed",
        "turn": "continuous",
        "slide": "prismatic",
        "ball": spherical,
        "free": "floating",
    }
    chain: list[SimpleJoint] = []
    parent = joint.parent
    for motion in joint.chain:
        name, child, kind = joint.name, joint.child, types[motion.kind]
        axis = motion.axis if kind in ("continuous", "prismatic") else None
        limits = None
        if motion.part:
            name = free_name(f"{name}_{motion.part}", joints)
            child = free_name(f"{child}_{motion.part}", links)
            joints.add(name)
            links.add(child)
        elif isinstance(joint, Single):
            limits = joint.limits
            if kind == "continuous" and limits is not None and limits.bounded:
                kind = "revolute"
        coordinate = motion.coordinates[0] if axis is not None else None
        chain.append(SimpleJoint(name, kind, parent, child, coordinate, axis=axis, limits=limits))
        parent = child
    place = joint.origin
    x, y, z = mechanism.evaluate_all(place.xyz)
    roll, pitch, yaw = mechanism.evaluate_all(place.rpy)
    chain[0] = replace(chain[0], xyz=(x, y, z), rpy=(roll, pitch, yaw))
    return chain
