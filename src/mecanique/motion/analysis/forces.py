"""Every force on every body: weights, springs, dampers, drives, loads, reactions and d'Alembert's inertia forces.

On each body they are in equilibrium (d'Alembert's principle, Fundamentals of Dynamics, eqs. 1.21,
1.22).
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Any, Literal, TypeAlias, final

import numpy as np

from mecanique.model.bodies import Body
from mecanique.model.expression import Scalar, Vector, evaluate
from mecanique.model.forces import (
    Damper,
    Force,
    JointDamper,
    JointForce,
    JointSpring,
    Spring,
    Torque,
)
from mecanique.model.joints import Single
from mecanique.model.mechanism import Mechanism

__all__ = ["Action", "Actions", "Kind"]

Kind: TypeAlias = Literal["weight", "spring", "damper", "load", "reaction", "inertia"]


@final
@dataclass(frozen=True, eq=False)
class Action:
    """A force and a moment on a body over n states, world axes.

    Args:
        name: of the force, the joint, or the body for weight and inertia.
        kind: what makes it.
        body: the body it acts on.
        other: the body that takes the opposite; None if nothing in the mechanism does.
        origin: shape (n, 3), point of application [m].
        force: shape (n, 3) [N].
        moment: shape (n, 3), about that point [N·m].
    """

    name: str
    kind: Kind
    body: str
    other: str | None
    origin: np.ndarray
    force: np.ndarray
    moment: np.ndarray


@final
class Actions:
    """The forces on a mechanism's bodies, batched over states.

    Args:
        mechanism: whose bodies.
        reference: its `Reference`, for poses, velocities, accelerations and reactions.
    """

    def __init__(self, mechanism: Mechanism, reference: Any) -> None:
        self._mechanism = mechanism
        self._reference = reference
        self._at = {body.name: k for k, body in enumerate(mechanism.bodies)}
        self._gravity = np.array([mechanism.evaluate(g) for g in mechanism.gravity])
        self._signals = [(i.symbol, i.function(mechanism.values)) for i in mechanism.inputs]
        self._heavy = [
            body
            for body in mechanism.bodies
            if body.name != mechanism.ground and mechanism.evaluate(body.mass)
        ]

    def applied(self, t: np.ndarray, q: np.ndarray, v: np.ndarray) -> Iterator[Action]:
        """Yield weights, springs, dampers, drives and loads.

        Args:
            t: shape (n,) [s].
            q: shape (n, nq).
            v: shape (n, nv).
        """
        poses = self._reference.poses(q, t)
        zero = np.zeros((len(t), 3))
        for body in self._heavy:
            weight = np.broadcast_to(
                self._mechanism.evaluate(body.mass) * self._gravity, zero.shape
            )
            yield Action(
                body.name,
                "weight",
                body.name,
                None,
                self._point(poses, body.name, body.center),
                weight,
                zero,
            )
        values = self._values(t, q, v)
        for force in self._mechanism.forces:
            match force:
                case Spring() | Damper():
                    yield from self._pair(force, poses, q, v, t)
                case JointSpring() | JointDamper() | JointForce():
                    yield from self._in_joint(force, poses, values, q, v, t)
                case Force():
                    parts = self._components(force.force, force.axes, poses, values)
                    point = self._point(poses, force.body, force.point)
                    yield Action(force.name, "load", force.body, None, point, parts, zero)
                case Torque():
                    parts = self._components(force.torque, force.axes, poses, values)
                    yield Action(
                        force.name,
                        "load",
                        force.body,
                        None,
                        self._origin(poses, force.body),
                        zero,
                        parts,
                    )

    def reactions(self, t: np.ndarray, q: np.ndarray, v: np.ndarray) -> Iterator[Action]:
        """Yield what each joint does to its child and to its parent, and each loop to its two bodies.

        Args:
            t: shape (n,) [s].
            q: shape (n, nq).
            v: shape (n, nv).
        """
        poses = self._reference.poses(q, t)
        found = self._reference.reactions(q, v, t)
        seats = [
            (joint.child, joint.parent, self._origin(poses, joint.child))
            for joint in self._mechanism.joints
        ]
        seats += [
            (loop.body_b, loop.body_a, self._point(poses, loop.body_b, loop.frame_b.xyz))
            for loop in self._mechanism.loops
        ]
        for (name, wrench), (body, other, at) in zip(found.items(), seats, strict=True):
            yield Action(name, "reaction", body, other, at, wrench.force, wrench.moment)
            yield Action(name, "reaction", other, body, at, -wrench.force, -wrench.moment)

    def inertia(
        self, t: np.ndarray, q: np.ndarray, v: np.ndarray, a: np.ndarray
    ) -> Iterator[Action]:
        """Yield d'Alembert's forces, −m a at the center of mass and minus the rate of the angular momentum about it.

        The rate is the moment of the relative accelerations, ∫ ρ × ρ'' dm, written with the second
        moments ∫ ρ ρᵀ dm and the second derivative of the rotation matrix, whose columns are
        accelerations of points.

        Args:
            t: shape (n,) [s].
            q: shape (n, nq).
            v: shape (n, nv).
            a: shape (n, nv).
        """
        for body in self._heavy:
            center = self._numbers(body.center)
            middle = self._reference.point(body.name, center, q, v, a, t)
            tips = [
                self._reference.point(body.name, center + axis, q, v, a, t) for axis in np.eye(3)
            ]
            turn = np.stack([tip.position - middle.position for tip in tips], axis=-1)
            change = np.stack([tip.acceleration - middle.acceleration for tip in tips], axis=-1)
            moments = change @ self._second_moments(body) @ turn.transpose(0, 2, 1)
            skew = moments - moments.transpose(0, 2, 1)
            rate = np.stack([skew[:, 2, 1], skew[:, 0, 2], skew[:, 1, 0]], axis=-1)
            force = -self._mechanism.evaluate(body.mass) * middle.acceleration
            yield Action(body.name, "inertia", body.name, None, middle.position, force, -rate)

    def _second_moments(self, body: Body) -> np.ndarray:
        ixx, iyy, izz, ixy, ixz, iyz = self._numbers(body.inertia)
        tensor = np.array([[ixx, ixy, ixz], [ixy, iyy, iyz], [ixz, iyz, izz]])
        second: np.ndarray = 0.5 * np.trace(tensor) * np.eye(3) - tensor
        return second

    def _values(self, t: np.ndarray, q: np.ndarray, v: np.ndarray) -> dict[str, Any]:
        m = self._mechanism
        values: dict[str, Any] = {**m.values, "t": t}
        values |= dict(zip(m.coordinates.names, q.T, strict=True))
        values |= dict(zip(m.velocities, v.T, strict=True))
        values |= {
            symbol: np.array([float(signal(s)) for s in t.tolist()])
            for symbol, signal in self._signals
        }
        return values

    def _numbers(self, components: Sequence[Scalar]) -> np.ndarray:
        return np.array([self._mechanism.evaluate(component) for component in components])

    def _origin(self, poses: np.ndarray, body: str) -> np.ndarray:
        at: np.ndarray = poses[:, self._at[body], :3, 3]
        return at

    def _point(self, poses: np.ndarray, body: str, point: Vector) -> np.ndarray:
        at: np.ndarray = self._origin(poses, body) + poses[
            :, self._at[body], :3, :3
        ] @ self._numbers(point)
        return at

    def _components(
        self, vector: Vector, axes: str, poses: np.ndarray, values: dict[str, Any]
    ) -> np.ndarray:
        parts: np.ndarray = np.stack(
            [_column(component, values, len(poses)) for component in vector], axis=1
        )
        if axes == "world":
            return parts
        turned: np.ndarray = np.einsum("nij,nj->ni", poses[:, self._at[axes], :3, :3], parts)
        return turned

    def _pair(
        self, link: Spring | Damper, poses: np.ndarray, q: np.ndarray, v: np.ndarray, t: np.ndarray
    ) -> Iterator[Action]:
        """A spring or a damper on both of its ends."""
        m = self._mechanism
        a, b = (
            self._point(poses, link.body_a, link.point_a),
            self._point(poses, link.body_b, link.point_b),
        )
        length = np.linalg.norm(b - a, axis=1)
        direction = (b - a) / np.where(length > 0, length, 1.0)[:, None]
        kind: Kind
        if isinstance(link, Spring):
            kind, pull = (
                "spring",
                m.evaluate(link.stiffness) * (length - m.evaluate(link.free_length)),
            )
        else:
            ends = ((link.body_a, link.point_a), (link.body_b, link.point_b))
            va, vb = (
                self._reference.point(body, self._numbers(p), q, v, None, t).velocity
                for body, p in ends
            )
            kind, pull = "damper", m.evaluate(link.damping) * ((vb - va) * direction).sum(axis=1)
        force = pull[:, None] * direction
        zero = np.zeros_like(force)
        yield Action(link.name, kind, link.body_a, link.body_b, a, force, zero)
        yield Action(link.name, kind, link.body_b, link.body_a, b, -force, zero)

    def _in_joint(
        self,
        load: JointSpring | JointDamper | JointForce,
        poses: np.ndarray,
        values: dict[str, Any],
        q: np.ndarray,
        v: np.ndarray,
        t: np.ndarray,
    ) -> Iterator[Action]:
        """A spring, a damper or a drive in a joint, on child and parent."""
        m, joint = self._mechanism, self._mechanism.joint(load.joint)
        if not isinstance(joint, Single):
            return
        kind: Kind
        if isinstance(load, JointForce):
            kind, size = "load", _column(load.force, values, len(t))
        elif isinstance(load, JointSpring):
            driven = m.coordinates.driven.get(joint.coordinate)
            at = values[joint.coordinate] if driven is None else _column(driven, values, len(t))
            kind, size = "spring", -m.evaluate(load.stiffness) * (at - m.evaluate(load.reference))
        else:
            free = f"{joint.coordinate}'" in values
            rate = (
                values[f"{joint.coordinate}'"]
                if free
                else self._relative_rate(joint, poses, q, v, t)
            )
            kind, size = "damper", -m.evaluate(load.damping) * rate
        along = size[:, None] * self._axis(joint, poses)
        zero, at_child = np.zeros_like(along), self._origin(poses, joint.child)
        force, moment = (zero, along) if joint.turns else (along, zero)
        yield Action(load.name, kind, joint.child, joint.parent, at_child, force, moment)
        yield Action(load.name, kind, joint.parent, joint.child, at_child, -force, -moment)

    def _axis(self, joint: Single, poses: np.ndarray) -> np.ndarray:
        # the axis is the same in parent and child, but for the joint's origin; the child has no
        # other turn about it
        axis: np.ndarray = poses[:, self._at[joint.child], :3, :3] @ np.array(joint.axis)
        return axis

    def _relative_rate(
        self,
        joint: Single,
        poses: np.ndarray,
        q: np.ndarray,
        v: np.ndarray,
        t: np.ndarray,
    ) -> np.ndarray:
        """Rate of a joint that follows the map, from how its two bodies move."""
        axis = self._axis(joint, poses)
        if not joint.turns:
            here = poses[:, self._at[joint.child], :3, 3]
            child = self._velocity(joint.child, here, poses, q, v, t)
            parent = self._velocity(joint.parent, here, poses, q, v, t)
            sliding: np.ndarray = ((child - parent) * axis).sum(axis=1)
            return sliding
        spins = [self._spin(body, axis, poses, q, v, t) for body in (joint.child, joint.parent)]
        turning: np.ndarray = spins[0] - spins[1]
        return turning

    def _spin(
        self,
        body: str,
        axis: np.ndarray,
        poses: np.ndarray,
        q: np.ndarray,
        v: np.ndarray,
        t: np.ndarray,
    ) -> np.ndarray:
        """Component of a body's angular velocity along world axes, ω·n, from ½ Σ e × ė over its own axes."""
        origin = self._reference.point(body, np.zeros(3), q, v, None, t).velocity
        omega = np.zeros((len(t), 3))
        for k, unit in enumerate(np.eye(3)):
            rate = self._reference.point(body, unit, q, v, None, t).velocity - origin
            omega += 0.5 * np.cross(poses[:, self._at[body], :3, k], rate)
        along: np.ndarray = (omega * axis).sum(axis=1)
        return along

    def _velocity(
        self,
        body: str,
        at: np.ndarray,
        poses: np.ndarray,
        q: np.ndarray,
        v: np.ndarray,
        t: np.ndarray,
    ) -> np.ndarray:
        """Velocity of the points of a body that are at these places now, state by state."""
        pose = poses[:, self._at[body]]
        local = np.einsum("nji,nj->ni", pose[:, :3, :3], at - pose[:, :3, 3])
        origin = self._reference.point(body, np.zeros(3), q, v, None, t).velocity
        columns = [
            self._reference.point(body, unit, q, v, None, t).velocity - origin for unit in np.eye(3)
        ]
        velocity: np.ndarray = origin + sum(local[:, k, None] * columns[k] for k in range(3))
        return velocity


def _column(scalar: Scalar, values: dict[str, Any], count: int) -> np.ndarray:
    return np.broadcast_to(np.asarray(evaluate(scalar, values), dtype=float), (count,))
