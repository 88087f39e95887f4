"""A tree of joints and bodies, and the data of its recursions."""

from __future__ import annotations

import math
from copy import deepcopy
from typing import Literal, TypeAlias, final

import numpy as np

from mecanique.arrays import Array
from mecanique.reference.standin.spatial import SE3, Force, Inertia, Motion
from mecanique.reference.vectors import hat

BODY = "body"
"""The type of a body's frame."""

StdVec_Force = list
"""A list of wrenches."""

Kind: TypeAlias = Literal["world", "continuous", "revolute", "prismatic", "floating"]

_SIZES: dict[Kind, tuple[int, int]] = {
    "world": (0, 0),
    "continuous": (2, 1),
    "revolute": (1, 1),
    "prismatic": (1, 1),
    "floating": (7, 6),
}


class ReferenceFrame:
    """Names of the axes of a Jacobian."""

    LOCAL_WORLD_ALIGNED = "world axes at the frame's origin"


@final
class Joint:
    """A joint of the tree.

    Args:
        kind: its type; the positions of a continuous joint are cosine and sine.
        axis: unit vector, shape (3,); not used for a floating joint.
    """

    def __init__(self, kind: Kind, axis: Array) -> None:
        self.kind, self.axis = kind, axis
        self.nq, self.nv = _SIZES[kind]
        self.idx_q = self.idx_v = 0
        self.S = self._directions()

    def _directions(self) -> Array:
        if self.kind == "floating":
            return np.eye(6)
        directions = np.zeros((6, self.nv))
        if self.nv:
            directions[: 3 if self.kind == "prismatic" else 6, 0][-3:] = self.axis
        return directions

    def shortname(self) -> str:
        """Return a name like Pinocchio's; those of slides begin with JointModelP."""
        return "JointModel" + ("Prismatic" if self.kind == "prismatic" else self.kind.title())

    def place(self, q: Array) -> tuple[Array, Array]:
        """Return rotation and translation of the child in the joint's frame.

        Args:
            q: positions of the whole tree.
        """
        own = q[self.idx_q : self.idx_q + self.nq]
        if self.kind == "prismatic":
            return np.eye(3), self.axis * own[0]
        if self.kind == "floating":
            return _turn_of(own[3:]), own[:3]
        c, s = own if self.nq == 2 else (math.cos(own[0]), math.sin(own[0]))
        outer = np.outer(self.axis, self.axis)
        return c * np.eye(3) + s * hat(self.axis) + (1 - c) * outer, np.zeros(3)


def _turn_of(quaternion: Array) -> Array:
    """Return the rotation of a unit quaternion x, y, z, w."""
    x, y, z, w = quaternion
    return np.array(
        [
            [1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
            [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
            [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)],
        ]
    )


def JointModelRevoluteUnaligned(axis: Array) -> Joint:
    """Return a hinge placed by its angle."""
    return Joint("revolute", axis)


@final
class Frame:
    """A frame fixed to a joint's child.

    Args:
        name: name of the body.
        joint: index of the joint.
        placement: pose in the joint's frame.
    """

    type = BODY

    def __init__(self, name: str, joint: int, placement: SE3) -> None:
        self.name, self.parentJoint, self.placement = name, joint, placement


@final
class Model:
    """The tree; the world is joint 0."""

    def __init__(self) -> None:
        self.names = ["universe"]
        self.joints = [Joint("world", np.zeros(3))]
        self.parents = [0]
        self.jointPlacements = [SE3(np.eye(3), np.zeros(3))]
        self.inertias = [Inertia.Zero()]
        self.frames: list[Frame] = []
        self.gravity = Motion(np.array([0.0, 0.0, -9.81, 0.0, 0.0, 0.0]))
        self.armature = np.zeros(0)
        self.nq = self.nv = 0

    @property
    def njoints(self) -> int:
        """Number of joints, the world included."""
        return len(self.joints)

    def addJoint(self, parent: int, joint: Joint, placement: SE3, name: str) -> int:
        """Add a joint as the child of another; return its index."""
        own = Joint(joint.kind, joint.axis)
        own.idx_q, own.idx_v = self.nq, self.nv
        self.nq, self.nv = self.nq + own.nq, self.nv + own.nv
        self.names.append(name)
        self.joints.append(own)
        self.parents.append(parent)
        self.jointPlacements.append(placement)
        self.inertias.append(Inertia.Zero())
        self.armature = np.concatenate([self.armature, np.zeros(own.nv)])
        return self.njoints - 1

    def copy(self) -> Model:
        """Return a copy."""
        return deepcopy(self)

    def createData(self) -> Data:
        """Return data for the recursions."""
        return Data(self)


@final
class Data:
    """The results of the recursions, joint by joint; arrays are changed in place.

    Poses are in the world (`oMi`, `oMf`) and in the parent (`liMi`); twists, accelerations and
    wrenches in the joint's own frame; Jacobians in world axes at the world's origin.
    """

    def __init__(self, model: Model) -> None:
        count, nv = model.njoints, model.nv

        def poses(number: int) -> list[SE3]:
            return [SE3(np.eye(3), np.zeros(3)) for _ in range(number)]

        def twists() -> list[Motion]:
            return [Motion(np.zeros(6)) for _ in range(count)]

        self.oMi, self.liMi, self.oMf = poses(count), poses(count), poses(len(model.frames))
        self.v, self.a, self.a_gf = twists(), twists(), twists()
        self.f = [Force(np.zeros(6)) for _ in range(count)]
        self.Ycrb = [Inertia.Zero() for _ in range(count)]
        self.J, self.dJ = np.zeros((6, nv)), np.zeros((6, nv))
        self.joints = model.joints
