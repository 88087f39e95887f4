"""Recursions over the tree (Featherstone, Rigid Body Dynamics Algorithms, 2008, ch. 5 and 6)."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from mecanique.arrays import Array
from mecanique.reference.standin.model import Data, Joint, Model
from mecanique.reference.standin.spatial import Force, Inertia
from mecanique.reference.vectors import cross


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
    _place_in_parents(model, data, q)
    _move(model, data, v, a)
    gravity = np.zeros(6)
    gravity[:3] = -model.gravity.linear
    data.a_gf[0].vector[:] = gravity  # read for the weight of bodies welded to the ground
    fields = [gravity]
    for i in range(1, model.njoints):
        fields.append(data.liMi[i].twist_inside() @ fields[model.parents[i]])
        data.a_gf[i].vector[:] = data.a[i].vector + fields[i]
        inertia, twist = model.inertias[i].matrix(), data.v[i]
        momentum = Force(inertia @ twist.vector)
        data.f[i].vector[:] = inertia @ data.a_gf[i].vector + twist.cross(momentum).vector
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
    _place_in_parents(model, data, q)
    data.Ycrb[:] = [
        Inertia(inertia.mass, inertia.lever, inertia.inertia) for inertia in model.inertias
    ]
    M = np.diag(model.armature)
    for i in range(model.njoints - 1, 0, -1):
        span = _span(model.joints[i])
        carried = data.Ycrb[i].matrix() @ model.joints[i].S
        M[span, span] += model.joints[i].S.T @ carried
        k = i
        while model.parents[k]:
            carried = data.liMi[k].twist_inside().T @ carried
            k = model.parents[k]
            block = model.joints[k].S.T @ carried
            M[_span(model.joints[k]), span] = block
            M[span, _span(model.joints[k])] = block.T
        if model.parents[i]:
            data.Ycrb[model.parents[i]] += data.liMi[i].act(data.Ycrb[i])
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
        return np.asarray(np.linalg.solve(crba(model, data, q), forces - bias))
    except np.linalg.LinAlgError:
        return np.full(model.nv, np.nan)


def computeJointJacobians(model: Model, data: Data, q: Array) -> None:
    """Set the Jacobians of the joints in world axes at the world's origin."""
    _place(model, data, q)
    for i in range(1, model.njoints):
        joint, span = model.joints[i], _span(model.joints[i])
        R, p = data.oMi[i].rotation, data.oMi[i].translation
        angular = R @ joint.S[3:]
        data.J[:3, span] = R @ joint.S[:3] + np.cross(p, angular, axis=0)
        data.J[3:, span] = angular


def computeJointJacobiansTimeVariation(model: Model, data: Data, q: Array, v: Array) -> None:
    """Set the Jacobians of the joints in world axes at the world's origin, and their rates."""
    computeJointJacobians(model, data, q)
    twists = [np.zeros(6)]
    for i in range(1, model.njoints):
        span = _span(model.joints[i])
        linear, angular = data.J[:3, span], data.J[3:, span]
        twists.append(twists[model.parents[i]] + data.J[:, span] @ v[span])
        # columns are fixed in the moving body: their rate is the cross product with its twist
        velocity, omega = twists[i][:3], twists[i][3:]
        data.dJ[:3, span] = np.cross(omega, linear, axis=0) + np.cross(velocity, angular, axis=0)
        data.dJ[3:, span] = np.cross(omega, angular, axis=0)
    _move(model, data, v, np.zeros(model.nv))


def computeFrameJacobian(model: Model, data: Data, q: Array, frame: int, axes: str) -> Array:
    """Return the Jacobian of a frame in world axes at its origin, shape (6, nv)."""
    computeJointJacobians(model, data, q)
    at = model.frames[frame]
    place = data.oMi[at.parentJoint].act(at.placement.translation)
    jacobian = np.zeros((6, model.nv))
    i = at.parentJoint
    while i:
        span = _span(model.joints[i])
        columns = data.J[:, span]
        jacobian[:3, span] = columns[:3] + np.cross(columns[3:], place, axis=0)
        jacobian[3:, span] = columns[3:]
        i = model.parents[i]
    return jacobian


def computePotentialEnergy(model: Model, data: Data, q: Array) -> float:
    """Return the potential energy of the weights, zero at the height of the origin [J]."""
    _place(model, data, q)
    pairs = zip(model.inertias[1:], data.oMi[1:], strict=True)
    moment = sum((inertia.mass * pose.act(inertia.lever) for inertia, pose in pairs), np.zeros(3))
    return -float(model.gravity.linear @ moment)


def _span(joint: Joint) -> slice:
    return slice(joint.idx_v, joint.idx_v + joint.nv)


def _place_in_parents(model: Model, data: Data, q: Array) -> None:
    for i in range(1, model.njoints):
        rotation, translation = model.joints[i].place(q)
        fixed, pose = model.jointPlacements[i], data.liMi[i]
        pose.rotation[:] = fixed.rotation @ rotation
        pose.translation[:] = fixed.act(translation)


def _place(model: Model, data: Data, q: Array) -> None:
    _place_in_parents(model, data, q)
    for i in range(1, model.njoints):
        pose = data.oMi[model.parents[i]] * data.liMi[i]
        data.oMi[i].rotation[:], data.oMi[i].translation[:] = pose.rotation, pose.translation


def _move(model: Model, data: Data, v: Array, a: Array) -> None:
    """Set twists and accelerations, given the poses in the parents."""
    for i in range(1, model.njoints):
        joint, span = model.joints[i], _span(model.joints[i])
        inside, parent = data.liMi[i].twist_inside(), model.parents[i]
        relative = joint.S @ v[span]
        twist = inside @ data.v[parent].vector + relative
        data.v[i].vector[:] = twist
        change = np.concatenate(
            [
                cross(twist[3:], relative[:3]) + cross(twist[:3], relative[3:]),
                cross(twist[3:], relative[3:]),
            ]
        )
        data.a[i].vector[:] = inside @ data.a[parent].vector + joint.S @ a[span] + change
