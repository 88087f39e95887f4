"""Split a mechanism's tree into elementary links: a placement, then one elementary motion.

The motion is a turn, slide, ball or free motion. A planar joint becomes two slides and a turn, a
universal joint two turns; links in between have no mass.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal, TypeAlias, final

import numpy as np

from mecanique.model import Mechanism, Placement
from mecanique.model.expression import Scalar
from mecanique.model.joint_base import Single

Kind: TypeAlias = Literal["fixed", "turn", "slide", "ball", "free"]


@final
@dataclass(frozen=True)
class Link:
    """One elementary motion of the tree."""

    joint: str  # name of the joint it belongs to
    parent: int  # index of its parent link in the tree, −1 for the ground
    body: str | None  # name of the body it carries; None within a joint
    kind: Kind
    origin: Placement  # placement of its frame in its parent's
    axis: tuple[float, float, float] = (0.0, 0.0, 1.0)  # shape (3,), unit axis of a turn or a slide
    coordinates: tuple[str, ...] = ()  # names of its joint coordinates
    velocities: tuple[str, ...] = ()  # names of its joint velocities
    armature: Scalar = 0.0  # inertia of the drive's rotor, referred to the joint [kg·m² or kg]


def links(mechanism: Mechanism) -> tuple[Link, ...]:
    """Return the elementary links of a mechanism, each after its parent."""
    tree: list[Link] = []
    place = {mechanism.ground: -1}

    for joint in mechanism.tree:
        parent = place[joint.parent]
        for number, motion in enumerate(joint.chain):
            last = number + 1 == len(joint.chain)
            tree.append(
                Link(
                    joint=joint.name,
                    parent=parent,
                    body=joint.child if last else None,
                    kind=motion.kind,
                    origin=joint.origin if number == 0 else Placement(),
                    axis=motion.axis,
                    coordinates=motion.coordinates,
                    velocities=motion.velocities,
                    armature=joint.armature if last and isinstance(joint, Single) else 0.0,
                )
            )
            parent = len(tree) - 1
        place[joint.child] = parent
    return tuple(tree)


def place_of(tree: tuple[Link, ...], mechanism: Mechanism) -> dict[str, int]:
    """Return the index of each body's link in the tree, −1 for the ground, by the body's name."""
    return {
        mechanism.ground: -1,
        **{link.body: place for place, link in enumerate(tree) if link.body is not None},
    }


def moving(tree: tuple[Link, ...]) -> tuple[bool, ...]:
    """Return for each link whether it can move relative to the ground."""
    moves: list[bool] = []
    for link in tree:
        moves.append(link.kind != "fixed" or (link.parent >= 0 and moves[link.parent]))
    return tuple(moves)


Axis: TypeAlias = "tuple[float, float, float]"

_STILL: Axis = (0.0, 0.0, 0.0)
_AXES: tuple[Axis, ...] = ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0))


def unit_motions(link: Link) -> tuple[tuple[Axis, Axis], ...]:
    """Return the direction of each velocity of a link, linear and angular, in its own axes."""
    slides, turns = [(axis, _STILL) for axis in _AXES], [(_STILL, axis) for axis in _AXES]
    of_kind: dict[Kind, Sequence[tuple[Axis, Axis]]] = {
        "turn": [(_STILL, link.axis)],
        "slide": [(link.axis, _STILL)],
        "ball": turns,
        "free": [*slides, *turns],
    }
    return tuple(of_kind.get(link.kind, ()))


def motions(link: Link) -> np.ndarray:
    """Return the matrix S of each velocity of a link, (k, 4, 4): the pose A changes by A S."""
    S = np.zeros((len(link.velocities), 4, 4))
    for matrix, (linear, (x, y, z)) in zip(S, unit_motions(link), strict=True):
        matrix[:3, :3] = [[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]]
        matrix[:3, 3] = linear
    return S
