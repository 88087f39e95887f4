"""A tree of joints and bodies, read from URDF text, and the data of its recursions."""

from __future__ import annotations

import math
from collections import defaultdict
from collections.abc import Sequence
from copy import deepcopy
from typing import Literal, TypeAlias, cast, final
from xml.etree import ElementTree

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
        """Return rotation and translation of the child in the joint's frame."""
        values = q[self.idx_q : self.idx_q + self.nq]
        if self.kind == "prismatic":
            return np.eye(3), self.axis * values[0]
        if self.kind == "floating":
            return _turn_of(values[3:]), values[:3]
        c, s = values if self.nq == 2 else (math.cos(values[0]), math.sin(values[0]))
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
    """A frame fixed to a joint's child."""

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
        added = Joint(joint.kind, joint.axis)
        added.idx_q, added.idx_v = self.nq, self.nv
        self.nq, self.nv = self.nq + added.nq, self.nv + added.nv
        self.names.append(name)
        self.joints.append(added)
        self.parents.append(parent)
        self.jointPlacements.append(placement)
        self.inertias.append(Inertia.Zero())
        self.armature = np.concatenate([self.armature, np.zeros(added.nv)])
        return self.njoints - 1

    def copy(self) -> Model:
        """Return a copy."""
        return deepcopy(self)

    def createData(self) -> Data:
        """Return data for the recursions."""
        return Data(self)


@final
class Data:
    """The results of the recursions, joint by joint; arrays are changed in place."""

    # Poses are in the world (`oMi`, `oMf`) and in the parent (`liMi`); twists, accelerations and
    # wrenches in the joint's own frame; Jacobians in world axes at the world's origin

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


def buildModelFromXML(text: str) -> Model:
    """Return the tree of a URDF text."""
    # safe: only text written by mecanique is parsed here
    return tree_of_robot(ElementTree.fromstring(text))


def tree_of_robot(robot: ElementTree.Element) -> Model:
    """Return the tree of a URDF."""
    behind = defaultdict(list)
    children = set()
    for joint in robot.findall("joint"):
        parent, child = _ends(joint)
        behind[parent].append((joint, child))
        children.add(child)
    links = {link.get("name", ""): link for link in robot.findall("link")}
    roots = links.keys() - children
    if len(roots) != 1:
        raise ValueError(f"expected a tree with one root, got {len(roots)}")
    (root,) = roots
    model = Model()
    waiting = [(root, 0, SE3(np.eye(3), np.zeros(3)))]
    while waiting:
        name, holder, placement = waiting.pop()
        model.frames.append(Frame(name, holder, placement))
        if holder:
            model.inertias[holder] += placement.act(_inertia(links[name]))
        for joint, child in reversed(behind[name]):
            at = placement * _origin(joint)
            kind = joint.get("type", "")
            if kind == "fixed":
                waiting.append((child, holder, at))
                continue
            moving = Joint(cast(Kind, kind), _axis(joint))
            index = model.addJoint(holder, moving, at, joint.get("name", ""))
            waiting.append((child, index, SE3(np.eye(3), np.zeros(3))))
    return model


def _ends(joint: ElementTree.Element) -> tuple[str, str]:
    parent, child = (joint.find(tag) for tag in ("parent", "child"))
    if parent is None or child is None:
        raise ValueError(f"joint {joint.get('name')!r} has no parent or no child")
    return parent.get("link", ""), child.get("link", "")


def _numbers(element: ElementTree.Element | None, name: str, default: Sequence[float]) -> Array:
    text = None if element is None else element.get(name)
    try:
        values = np.array([float(word) for word in text.split()] if text else default)
    except ValueError:
        values = np.zeros(0)
    if len(values) != len(default) or not np.isfinite(values).all():
        raise ValueError(f"expected {len(default)} numbers for {name}, got {text!r}")
    return values


def _axis(joint: ElementTree.Element) -> Array:
    axis = _numbers(joint.find("axis"), "xyz", (1.0, 0.0, 0.0))
    return np.asarray(axis / np.linalg.norm(axis))


def _origin(element: ElementTree.Element) -> SE3:
    place = element.find("origin")
    xyz, (roll, pitch, yaw) = (_numbers(place, name, (0.0, 0.0, 0.0)) for name in ("xyz", "rpy"))
    cx, cy, cz = np.cos([roll, pitch, yaw])
    sx, sy, sz = np.sin([roll, pitch, yaw])
    about_x = np.array([[1, 0, 0], [0, cx, -sx], [0, sx, cx]])
    about_y = np.array([[cy, 0, sy], [0, 1, 0], [-sy, 0, cy]])
    about_z = np.array([[cz, -sz, 0], [sz, cz, 0], [0, 0, 1]])
    return SE3(about_z @ about_y @ about_x, xyz)


def _inertia(link: ElementTree.Element) -> Inertia:
    inertial = link.find("inertial")
    if inertial is None:
        return Inertia.Zero()
    (mass,) = _numbers(inertial.find("mass"), "value", (0.0,)).tolist()
    tags = ("ixx", "ixy", "ixz", "iyy", "iyz", "izz")
    stated = inertial.find("inertia")
    xx, xy, xz, yy, yz, zz = (float(_numbers(stated, tag, (0.0,))[0]) for tag in tags)
    tensor = np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])
    about: Inertia = _origin(inertial).act(Inertia(mass, np.zeros(3), tensor))
    return about
