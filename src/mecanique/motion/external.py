"""What acts on a mechanism from outside: weights, loads, springs to the ground, and the ground's support.

Only what crosses the boundary between the ground and everything else counts; forces between two moving bodies cancel
(Newton's third law).
"""

from __future__ import annotations

from typing import Any, final

import numpy as np

from mecanique.model.bodies import Body
from mecanique.model.expression import Scalar, Vector, evaluate
from mecanique.model.forces import Damper, Force, JointDamper, JointForce, JointSpring, Spring, Torque
from mecanique.model.joints import Prismatic, Revolute
from mecanique.model.mechanism import Mechanism

__all__ = ["External"]


@final
class External:
    """Resultant external force and moment, batched over states.

    Args:
        mechanism: what moves.
        reference: its `Reference`, for poses, velocities and reactions.
    """

    def __init__(self, mechanism: Mechanism, reference: Any) -> None:
        self._mechanism = mechanism
        self._reference = reference
        self._moving = [body for body in mechanism.bodies if body.name != mechanism.ground]
        self._at = {body.name: k for k, body in enumerate(mechanism.bodies)}
        self._gravity = np.array([mechanism.evaluate(g) for g in mechanism.gravity])
        self._signals = [(i.symbol, i.function(mechanism.values)) for i in mechanism.inputs]

    def __call__(self, t: np.ndarray, q: np.ndarray, v: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Return the resultant force and its moment about the world's origin, each of shape (n, 3) [N, N·m].

        Args:
            t: shape (n,) [s].
            q: shape (n, nq).
            v: shape (n, nv).
        """
        m, reference = self._mechanism, self._reference
        poses = reference.poses(q, t)
        values = self._values(t, q, v)
        force, moment = np.zeros((len(t), 3)), np.zeros((len(t), 3))

        def add(f: np.ndarray, at: np.ndarray, couple: np.ndarray | float = 0.0) -> None:
            nonlocal force, moment
            force = force + f
            moment = moment + np.cross(at, f) + couple

        for body in self._moving:
            add(np.broadcast_to(m.evaluate(body.mass) * self._gravity, force.shape), self._center(poses, body))
        reactions = reference.reactions(q, v, t)
        for joint in m.joints:
            if joint.parent == m.ground:
                wrench = reactions[joint.name]
                add(wrench.force, poses[:, self._at[joint.child], :3, 3], wrench.moment)
        for load in m.forces:
            match load:
                case Spring() | Damper():
                    if (load.body_a == m.ground) != (load.body_b == m.ground):
                        add(*self._link(load, poses, q, v, t))
                case JointSpring() | JointDamper() | JointForce():
                    joint = m.joint(load.joint)
                    if joint.parent == m.ground and isinstance(joint, (Revolute, Prismatic)):
                        size = self._in_joint(load, joint, values, q, v, t)
                        pull = size[:, None] * self._axis(joint, poses)
                        at = poses[:, self._at[joint.child], :3, 3]
                        add(pull, at) if isinstance(joint, Prismatic) else add(np.zeros_like(pull), at, pull)
                case Force() if load.body != m.ground:
                    add(
                        self._components(load.force, load.axes, poses, values),
                        self._point(poses, load.body, load.point),
                    )
                case Torque() if load.body != m.ground:
                    couple = self._components(load.torque, load.axes, poses, values)
                    add(np.zeros_like(couple), np.zeros_like(couple), couple)
                case _:
                    pass
        return force, moment

    def _values(self, t: np.ndarray, q: np.ndarray, v: np.ndarray) -> dict[str, Any]:
        m = self._mechanism
        values: dict[str, Any] = {**m.values, "t": t}
        values |= dict(zip(m.coordinates.names, q.T, strict=True))
        values |= dict(zip(m.velocities, v.T, strict=True))
        values |= {symbol: np.array([float(signal(s)) for s in t.tolist()]) for symbol, signal in self._signals}
        return values

    def _numbers(self, components: Vector) -> list[float]:
        return [self._mechanism.evaluate(component) for component in components]

    def _center(self, poses: np.ndarray, body: Body) -> np.ndarray:
        return self._point(poses, body.name, body.center)

    def _point(self, poses: np.ndarray, body: str, point: Vector) -> np.ndarray:
        pose = poses[:, self._at[body]]
        at: np.ndarray = pose[:, :3, 3] + pose[:, :3, :3] @ np.array(self._numbers(point))
        return at

    def _components(self, vector: Vector, axes: str, poses: np.ndarray, values: dict[str, Any]) -> np.ndarray:
        parts: np.ndarray = np.stack([self._column(c, values, len(poses)) for c in vector], axis=1)
        if axes == "world":
            return parts
        turned: np.ndarray = np.einsum("nij,nj->ni", poses[:, self._at[axes], :3, :3], parts)
        return turned

    def _column(self, scalar: Scalar, values: dict[str, Any], count: int) -> np.ndarray:
        return np.broadcast_to(np.asarray(evaluate(scalar, values), dtype=float), (count,))

    def _link(
        self, link: Spring | Damper, poses: np.ndarray, q: np.ndarray, v: np.ndarray, t: np.ndarray
    ) -> tuple[np.ndarray, np.ndarray]:
        """Force of a spring or damper on its end that moves, and where that is."""
        a_moves = link.body_a != self._mechanism.ground
        body, point = (link.body_a, link.point_a) if a_moves else (link.body_b, link.point_b)
        other = (
            self._point(poses, link.body_b, link.point_b) if a_moves else self._point(poses, link.body_a, link.point_a)
        )
        at = self._point(poses, body, point)
        along = other - at
        length = np.linalg.norm(along, axis=1)
        direction = along / np.where(length > 0, length, 1.0)[:, None]
        if isinstance(link, Spring):
            k, free = self._mechanism.evaluate(link.stiffness), self._mechanism.evaluate(link.free_length)
            # with no free length the force is k times the vector, also where the length vanishes
            size = k * (length - free)
        else:
            velocity = self._reference.point(body, self._numbers(point), q, v, None, t).velocity
            size = -self._mechanism.evaluate(link.damping) * (velocity * direction).sum(axis=1)
        return size[:, None] * direction, at

    def _axis(self, joint: Revolute | Prismatic, poses: np.ndarray) -> np.ndarray:
        local = np.array([self._numbers(row) for row in joint.origin.rotation]) @ np.array(joint.axis)
        axis: np.ndarray = poses[:, self._at[joint.parent], :3, :3] @ local
        return axis

    def _in_joint(
        self,
        load: JointSpring | JointDamper | JointForce,
        joint: Revolute | Prismatic,
        values: dict[str, Any],
        q: np.ndarray,
        v: np.ndarray,
        t: np.ndarray,
    ) -> np.ndarray:
        """Force or torque of a spring, damper or drive in a joint, on the child."""
        m, count = self._mechanism, len(t)
        if isinstance(load, JointForce):
            return self._column(load.force, values, count)
        driven = m.coordinates.driven.get(joint.coordinate)
        if isinstance(load, JointSpring):
            at = values[joint.coordinate] if driven is None else self._column(driven, values, count)
            spring: np.ndarray = -m.evaluate(load.stiffness) * (at - m.evaluate(load.reference))
            return spring
        rate = values[f"{joint.coordinate}'"] if driven is None else self._relative_rate(joint, q, v, t)
        damper: np.ndarray = -m.evaluate(load.damping) * rate
        return damper

    def _relative_rate(self, joint: Revolute | Prismatic, q: np.ndarray, v: np.ndarray, t: np.ndarray) -> np.ndarray:
        """Rate of a ground joint that follows the map, from how its child moves."""
        axis = self._axis(joint, self._reference.poses(q, t))
        here = self._reference.point(joint.child, (0.0, 0.0, 0.0), q, v, None, t).velocity
        if isinstance(joint, Prismatic):
            rate: np.ndarray = (here * axis).sum(axis=1)
            return rate
        # two points off the axis: ω·n from v = ω × r, r ⟂ n in the child's axes
        n = np.array(joint.axis)
        side = np.cross(n, np.eye(3)[np.abs(n).argmin()])
        side /= np.linalg.norm(side)
        there = self._reference.point(joint.child, side, q, v, None, t).velocity
        pose = self._reference.poses(q, t)[:, self._at[joint.child], :3, :3]
        turning: np.ndarray = ((there - here) * np.cross(axis, pose @ side)).sum(axis=1)
        return turning
