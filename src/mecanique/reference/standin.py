"""A small engine that replaces Pinocchio where it is not installed: the same names, in NumPy.

It reads the same URDF text and provides the functions of Pinocchio that this package uses, by
recursions over the tree (Featherstone, Rigid Body Dynamics Algorithms, 2008, ch. 5 and 6), some
hundred times more slowly. Vectors of six have their linear part first, as in Pinocchio. It is
independent of the derivation; but as it is our own code, a verdict with it says that the engine is
missing.
"""

from __future__ import annotations

import math
from collections import defaultdict
from collections.abc import Sequence
from copy import deepcopy
from typing import Any, Literal, TypeAlias, cast, final
from xml.etree import ElementTree

import numpy as np

from mecanique.arrays import Array, cross
from mecanique.reference.vectors import hat, turn_about, turn_of

__version__ = "stand-in"

_ALONG = np.zeros((6, 6, 6))
"""The matrix [[ω ×, v ×], [0, ω ×]] of each component of a twist (v, ω)."""
_ALONG[:3, :3, 3:] = _ALONG[3:, :3, :3] = _ALONG[3:, 3:, 3:] = hat(np.eye(3))


class _Pair:
    """Two vectors in one array, shape (6,)."""

    def __init__(self, vector: Array) -> None:
        self.vector = vector

    @property
    def linear(self) -> Array:
        """The first three components, as a view."""
        return self.vector[:3]

    @linear.setter
    def linear(self, value: Array) -> None:
        self.vector[:3] = value

    @property
    def angular(self) -> Array:
        """The last three components, as a view."""
        return self.vector[3:]

    @angular.setter
    def angular(self, value: Array) -> None:
        self.vector[3:] = value


@final
class Force(_Pair):
    """A wrench: force and moment about the origin."""

    def __init__(self, vector: Array, moment: Array | None = None) -> None:
        super().__init__(vector if moment is None else np.concatenate([vector, moment]))

    @staticmethod
    def Zero() -> Force:
        """Return the zero wrench."""
        return Force(np.zeros(6))

    def __add__(self, wrench: Force) -> Force:
        return Force(self.vector + wrench.vector)

    def __sub__(self, wrench: Force) -> Force:
        return Force(self.vector - wrench.vector)


@final
class Motion(_Pair):
    """A twist: velocity of the point at the origin, and angular velocity."""

    def cross(self, force: Force) -> Force:
        """Return the rate of a wrench that moves with this twist."""
        return Force(-_rate_along(self.vector).T @ force.vector)


@final
class Inertia:
    """Mass, center of mass, and moments of inertia about the center of mass."""

    # Mass [kg], lever to the center (3,) [m], moments about the center (3, 3) [kg·m²].
    # Shapes: inertia (3, 3)

    def __init__(self, mass: float, lever: Array, inertia: Array) -> None:
        self.mass, self.lever, self.inertia = mass, lever, inertia

    @staticmethod
    def Zero() -> Inertia:
        """Return zero inertia."""
        return Inertia(0.0, np.zeros(3), np.zeros((3, 3)))

    def __add__(self, added: Inertia) -> Inertia:
        mass = self.mass + added.mass
        if not mass:
            return Inertia(0.0, np.zeros(3), self.inertia + added.inertia)
        between = self.lever - added.lever
        steiner = (between @ between) * np.eye(3) - np.outer(between, between)
        return Inertia(
            mass,
            (self.mass * self.lever + added.mass * added.lever) / mass,
            self.inertia + added.inertia + self.mass * added.mass / mass * steiner,
        )

    def __mul__(self, motion: Motion) -> Force:
        """Return the momentum of a twist."""
        return Force(self.matrix() @ motion.vector)

    def matrix(self) -> Array:
        """Return the spatial inertia, shape (6, 6)."""
        m, lever = self.mass, hat(self.lever)
        M = np.zeros((6, 6))
        M[:3, :3] = m * np.eye(3)
        M[:3, 3:] = -m * lever
        M[3:, :3] = m * lever
        M[3:, 3:] = self.inertia - m * lever @ lever
        return M


@final
class SE3:
    """A pose, which maps coordinates of the inner frame to those of the outer one."""

    # Shapes: rotation (3, 3), translation (3,)

    def __init__(self, rotation: Array, translation: Array | None = None) -> None:
        if translation is None:
            rotation, translation = rotation[:3, :3].copy(), rotation[:3, 3].copy()
        self.rotation, self.translation = rotation, translation

    @property
    def homogeneous(self) -> Array:
        """The matrix, shape (4, 4)."""
        H = np.eye(4)
        H[:3, :3], H[:3, 3] = self.rotation, self.translation
        return H

    def copy(self) -> SE3:
        """Return a copy."""
        return SE3(self.rotation.copy(), self.translation.copy())

    def __mul__(self, inner: SE3) -> SE3:
        return SE3(self.rotation @ inner.rotation, self.act(inner.translation))

    def act(self, thing: Any) -> Any:
        """Transform a point, wrench or inertia from the inner frame to the outer one."""
        R, p = self.rotation, self.translation
        if isinstance(thing, Force):
            force = R @ thing.linear
            return Force(force, R @ thing.angular + cross(p, force))
        if isinstance(thing, Inertia):
            return Inertia(thing.mass, self.act(thing.lever), R @ thing.inertia @ R.T)
        return R @ thing + p

    def actInv(self, force: Force) -> Force:
        """Transform a wrench from the outer frame to the inner one."""
        R, p = self.rotation, self.translation
        return Force(R.T @ force.linear, R.T @ (force.angular - cross(p, force.linear)))


def log3(turn: Array) -> Array:
    """Return the rotation vector of a rotation, shape (3,)."""
    twice = np.array([turn[2, 1] - turn[1, 2], turn[0, 2] - turn[2, 0], turn[1, 0] - turn[0, 1]])
    sine, cosine = np.linalg.norm(twice) / 2, (np.trace(turn) - 1) / 2
    angle = math.atan2(sine, cosine)
    if sine > 1e-6:
        return np.asarray(twice * (angle / (2 * sine)))
    if cosine > 0:
        return np.asarray(twice / 2)
    # near half a turn R + 1 is 2 n nᵀ, whose columns are along the axis n
    symmetric = turn + np.eye(3)
    axis = symmetric[:, int(np.argmax(np.diag(symmetric)))]
    axis = axis / np.linalg.norm(axis)
    return np.asarray(angle * (axis if axis @ twice >= 0 else -axis))


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


_ONE, _ORIGIN = np.eye(3), np.zeros(3)


@final
class Joint:
    """A joint of the tree.

    Args:
        kind: its type; the positions of a continuous joint are cosine and sine.
        axis: unit vector, shape (3,); not used for a floating joint.
    """

    def __init__(self, kind: Kind, axis: Array) -> None:
        self.kind, self.axis, self.across = kind, axis, hat(axis)
        self.twice_across = self.across @ self.across
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
            return _ONE, self.axis * values[0]
        if self.kind == "floating":
            return turn_of(values[3:]), values[:3]
        c, s = values if self.nq == 2 else (math.cos(values[0]), math.sin(values[0]))
        # Rodrigues' formula, with its products of the axis computed once
        return _ONE + s * self.across + (1 - c) * self.twice_across, _ORIGIN


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

    # Poses are in the world (`oMi`, `oMf`) and in the parent (`liMi`); twists, accelerations,
    # wrenches and Jacobians in the joint's own frame; J in world axes at the world's origin

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
        self.masses = [inertia.matrix() for inertia in model.inertias]
        self.body_jacobians, self.inside = np.zeros((count, 6, nv)), np.zeros((count, 6, 6))
        self.along = np.zeros((count, 6, 6))
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
            axis = _numbers(joint.find("axis"), "xyz", (1.0, 0.0, 0.0))
            moving = Joint(cast(Kind, kind), np.asarray(axis / np.linalg.norm(axis)))
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


def _origin(element: ElementTree.Element) -> SE3:
    place = element.find("origin")
    xyz, (roll, pitch, yaw) = (_numbers(place, name, (0.0, 0.0, 0.0)) for name in ("xyz", "rpy"))
    about_x, about_y, about_z = (
        turn_about(axis, math.cos(angle), math.sin(angle))
        for axis, angle in zip(np.eye(3), (roll, pitch, yaw), strict=True)
    )
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


def forwardKinematics(
    model: Model, data: Data, q: Array, v: Array | None = None, a: Array | None = None
) -> None:
    """Move the bodies to a state: set poses and, where given, twists and accelerations."""
    _place(model, data, q)
    if v is not None:
        _move(model, data, v, np.zeros(model.nv) if a is None else a)


def framesForwardKinematics(model: Model, data: Data, q: Array) -> None:
    """Set the poses of all frames."""
    _place(model, data, q)
    for frame, pose in zip(model.frames, data.oMf, strict=True):
        placement = data.oMi[frame.parentJoint] * frame.placement
        pose.rotation[:], pose.translation[:] = placement.rotation, placement.translation


def rnea(
    model: Model,
    data: Data,
    q: Array,
    v: Array,
    a: Array,
    external: Sequence[Force] | None = None,
) -> Array:
    """Return the joint forces for given accelerations, shape (nv,)."""
    _place(model, data, q)
    _move(model, data, v, a)
    data.a_gf[0].linear = -model.gravity.linear  # for the weight of bodies welded to the ground
    for i in range(1, model.njoints):
        data.a_gf[i].vector[:] = data.a[i].vector
        data.a_gf[i].linear -= data.oMi[i].rotation.T @ model.gravity.linear
        inertia = data.masses[i]
        momentum = inertia @ data.v[i].vector
        data.f[i].vector[:] = inertia @ data.a_gf[i].vector - data.along[i].T @ momentum
        if external is not None:
            data.f[i].vector[:] -= external[i].vector
    forces: Array = model.armature * a
    for i in range(model.njoints - 1, 0, -1):
        forces[_span(model.joints[i])] += model.joints[i].S.T @ data.f[i].vector
        if model.parents[i]:
            data.f[model.parents[i]].vector[:] += data.liMi[i].act(data.f[i]).vector
    return forces


def nonLinearEffects(model: Model, data: Data, q: Array, v: Array) -> Array:
    """Return the joint forces for zero acceleration, including gravity."""
    return rnea(model, data, q, v, np.zeros(model.nv))


def computeGeneralizedGravity(model: Model, data: Data, q: Array) -> Array:
    """Return the joint forces at rest."""
    rest = np.zeros(model.nv)
    return rnea(model, data, q, rest, rest)


def crba(model: Model, data: Data, q: Array) -> Array:
    """Return the mass matrix, shape (nv, nv)."""
    _place(model, data, q)
    _set_body_jacobians(model, data)
    data.Ycrb[:] = [
        Inertia(inertia.mass, inertia.lever, inertia.inertia) for inertia in model.inertias
    ]
    for i in range(model.njoints - 1, 0, -1):
        if model.parents[i]:
            data.Ycrb[model.parents[i]] += data.liMi[i].act(data.Ycrb[i])
    return _sum_masses(model, data)


def _sum_masses(model: Model, data: Data) -> Array:
    """Return the mass matrix, shape (nv, nv), given the Jacobians of the joints."""
    M = np.diag(model.armature)
    for J, inertia in zip(data.body_jacobians[1:], data.masses[1:], strict=True):
        M += J.T @ inertia @ J
    return M


def aba(
    model: Model,
    data: Data,
    q: Array,
    v: Array,
    forces: Array,
    external: Sequence[Force] | None = None,
) -> Array:
    """Return the accelerations under joint forces; NaN where they are undetermined."""
    bias = rnea(model, data, q, v, np.zeros(model.nv), external)
    try:
        return np.asarray(np.linalg.solve(_sum_masses(model, data), forces - bias))
    except np.linalg.LinAlgError:
        return np.full(model.nv, np.nan)


def computeJointJacobians(model: Model, data: Data, q: Array) -> None:
    """Set the Jacobians of the joints in world axes at the world's origin."""
    _place(model, data, q)
    for i in range(1, model.njoints):
        joint, span = model.joints[i], _span(model.joints[i])
        R, p = data.oMi[i].rotation, data.oMi[i].translation
        angular = R @ joint.S[3:]
        data.J[:3, span] = R @ joint.S[:3] + hat(p) @ angular
        data.J[3:, span] = angular


def computeJointJacobiansTimeVariation(model: Model, data: Data, q: Array, v: Array) -> None:
    """Set the Jacobians of the joints in world axes at the world's origin, and their rates."""
    computeJointJacobians(model, data, q)
    twists = [np.zeros(6)]
    for i in range(1, model.njoints):
        span = _span(model.joints[i])
        twists.append(twists[model.parents[i]] + data.J[:, span] @ v[span])
        # columns are fixed in the moving body: their rate is the cross product with its twist
        data.dJ[:, span] = _rate_along(twists[i]) @ data.J[:, span]
    _move(model, data, v, np.zeros(model.nv))


def computeFrameJacobian(model: Model, data: Data, q: Array, frame: int, axes: str) -> Array:
    """Return the Jacobian of a frame in world axes at its origin, shape (6, nv)."""
    _place(model, data, q)
    _set_body_jacobians(model, data)
    at = model.frames[frame]
    J, turn = data.body_jacobians[at.parentJoint], data.oMi[at.parentJoint].rotation
    linear = J[:3] - hat(at.placement.translation) @ J[3:]
    return np.concatenate([turn @ linear, turn @ J[3:]])


def computePotentialEnergy(model: Model, data: Data, q: Array) -> float:
    """Return the potential energy of the weights, zero at the height of the origin [J]."""
    _place(model, data, q)
    pairs = zip(model.inertias[1:], data.oMi[1:], strict=True)
    moment = sum((inertia.mass * pose.act(inertia.lever) for inertia, pose in pairs), np.zeros(3))
    return -float(model.gravity.linear @ moment)


def _span(joint: Joint) -> slice:
    return slice(joint.idx_v, joint.idx_v + joint.nv)


def _place(model: Model, data: Data, q: Array) -> None:
    """Set the poses of the joints."""
    for i in range(1, model.njoints):
        rotation, translation = model.joints[i].place(q)
        fixed, inside, outside = model.jointPlacements[i], data.liMi[i], data.oMi[model.parents[i]]
        inside.rotation[:] = fixed.rotation @ rotation
        inside.translation[:] = fixed.rotation @ translation + fixed.translation
        data.oMi[i].rotation[:] = outside.rotation @ inside.rotation
        data.oMi[i].translation[:] = outside.rotation @ inside.translation + outside.translation


def _set_body_jacobians(model: Model, data: Data) -> None:
    """Set the Jacobians of the joints in their frames, and how twists are transformed there."""
    for i in range(1, model.njoints):
        inside, back = data.inside[i], data.liMi[i].rotation.T
        inside[:3, :3] = inside[3:, 3:] = back
        inside[:3, 3:] = -back @ hat(data.liMi[i].translation)
        np.matmul(inside, data.body_jacobians[model.parents[i]], out=data.body_jacobians[i])
        data.body_jacobians[i][:, _span(model.joints[i])] = model.joints[i].S


def _move(model: Model, data: Data, v: Array, a: Array) -> None:
    """Set twists and accelerations, given the poses in the parents."""
    _set_body_jacobians(model, data)
    for i in range(1, model.njoints):
        joint, span = model.joints[i], _span(model.joints[i])
        inside, parent = data.inside[i], model.parents[i]
        relative, twist = joint.S @ v[span], data.body_jacobians[i] @ v
        data.v[i].vector[:] = twist
        data.along[i] = _rate_along(twist)
        change = joint.S @ a[span] + data.along[i] @ relative
        data.a[i].vector[:] = inside @ data.a[parent].vector + change


def _rate_along(twist: Array) -> Array:
    """Return the matrix that maps a twist to its rate where it moves with another, (6, 6)."""
    matrix: Array = (twist @ _ALONG.reshape(6, 36)).reshape(6, 6)  # one product, not six
    return matrix
