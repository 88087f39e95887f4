"""Compute how a mechanism moves: poses, velocities, points and Jacobians of its bodies."""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial

import numpy as np

from mecanique.arrays import Array
from mecanique.errors import EngineError
from mecanique.model.states import States
from mecanique.model.values import Given
from mecanique.reference.answering import Answering
from mecanique.reference.engine.answers import BodyMotions, PointMotion, Twist, local_point
from mecanique.reference.engine.many import center_speeds


class Kinematics(Answering):
    """The methods of a `Reference` about the motion of bodies and points."""

    def poses(self, q: Given, t: float | Array = 0.0) -> Array:
        """Return the poses of all bodies in the world, in their order, shape (nb, 4, 4).

        Args:
            q: shape (nq,).
            t: time [s].
        """
        return self._answer(States.of(self.mechanism, q, t=t), self._tree.poses)

    def pose(self, body: str, q: Given, t: float | Array = 0.0) -> Array:
        """Return the pose of one body in the world, shape (4, 4).

        Args:
            body: name of the body.
            q: shape (nq,).
            t: time [s].

        Raises:
            UnknownNameError: if there is no such body.
        """
        place = self.mechanism.bodies.index(self.mechanism.body(body))
        pose: Array = self.poses(q, t)[..., place, :, :]
        return pose

    def velocity(self, body: str, q: Given, v: Given, t: float | Array = 0.0) -> Twist:
        """Return the velocity of a body's origin and its angular velocity, world axes.

        Args:
            body: name of the body.
            q: shape (nq,).
            v: shape (nv,).
            t: time [s].

        Raises:
            UnknownNameError: if there is no such body.
        """
        name = self.mechanism.body(body).name
        states = States.of(self.mechanism, q, v, t)
        return Twist(*np.moveaxis(self._answer(states, partial(self._tree.twist, name)), -2, 0))

    def motions(
        self, q: Given, v: Given = None, a: Given = None, t: float | Array = 0.0
    ) -> BodyMotions:
        """Return the motions of all bodies, world axes, in one pass over the bodies.

        Args:
            q: shape (nq,).
            v: shape (nv,).
            a: shape (nv,).
            t: time [s].
        """
        holders = [self._tree.engine.holders[body.name] for body in self.mechanism.bodies]
        states = States.of(self.mechanism, q, v, t, a)
        joints = self._answer(states, self._tree.carry, accelerations=True)
        rows = joints[..., [holder.joint for holder in holders], :]
        poses, twists, rates = np.split(rows, (16, 22), axis=-1)
        poses = poses.reshape(*poses.shape[:-1], 4, 4)
        at = np.array([holder.placement.translation for holder in holders])
        omega, alpha = twists[..., 3:], rates[..., 3:]
        velocity = twists[..., :3] + np.cross(omega, at)
        # from the spatial to the classical acceleration
        change = rates[..., :3] + np.cross(alpha, at) + np.cross(omega, velocity)
        vectors = np.stack((velocity, omega, change, alpha), axis=-1)
        return BodyMotions(
            poses @ np.array([holder.placement.homogeneous for holder in holders]),
            *np.moveaxis(poses[..., :3, :3] @ vectors, -1, 0),
        )

    def center_speeds(self, q: Given, v: Given = None, t: float | Array = 0.0) -> Array:
        """Return the speeds of all bodies' centers of mass, in their order, shape (nb,) [m/s].

        Args:
            q: shape (nq,).
            v: shape (nv,).
            t: time [s].
        """
        states = States.of(self.mechanism, q, v, t)
        with np.errstate(all="ignore"):
            speeds = center_speeds(self._tree, states.q, states.v, states.t)
        self._refuse_infinite(states, speeds)
        return speeds[0] if states.single else speeds

    def point(
        self,
        body: str,
        xyz: Sequence[float] | Array = (0.0, 0.0, 0.0),
        q: Given = None,
        v: Given = None,
        a: Given = None,
        t: float | Array = 0.0,
    ) -> PointMotion:
        """Return position, velocity and acceleration of a body's point, world axes.

        Args:
            body: name of the body.
            xyz: shape (3,), the point in the body's frame [m].
            q: shape (nq,).
            v: shape (nv,).
            a: shape (nv,).
            t: time [s].

        Raises:
            UnknownNameError: if there is no such body.
        """
        name = self.mechanism.body(body).name
        local = local_point(xyz)
        parts = self._answer(
            States.of(self.mechanism, q, v, t, a),
            partial(self._tree.point, name, local),
            accelerations=True,
        )
        return PointMotion(*np.moveaxis(parts, -2, 0))

    def jacobian(self, body: str, q: Given, t: float | Array = 0.0) -> Array:
        """Return a body's Jacobian: velocity of its origin and angular velocity, world axes.

        Args:
            body: name of the body.
            q: shape (nq,).
            t: time [s].

        Returns:
            Shape (6, nv), the derivatives by v; a prescribed motion adds a velocity of its own.

        Raises:
            UnknownNameError: if there is no such body.
        """
        name = self.mechanism.body(body).name
        function = partial(self._tree.jacobian, name)
        return self._answer(States.of(self.mechanism, q, t=t), function)

    def followers(
        self, q: Given, v: Given = None, a: Given = None, t: float | Array = 0.0
    ) -> dict[str, Array]:
        """Return the joint coordinates that the coordinate map drives, including mimic joints.

        Args:
            q: shape (nq,).
            v: shape (nv,).
            a: shape (nv,).
            t: time [s].

        Returns:
            Each coordinate by its name r, its rate by r', its second derivative by r''; each shape
            () or (n,).
        """
        driven = self.mechanism.coordinates.driven
        states = States.of(self.mechanism, q, v, t, a)
        parts = self._answer(states, self._tree.followers, accelerations=True)
        return {
            f"{name}{marks}": parts[..., order, k]
            for order, marks in enumerate(("", "'", "''"))
            for k, name in enumerate(driven)
        }

    def rates(self, q: Given, v: Given) -> Array:
        """Return the rates q' of the coordinates, shape (nq,).

        Args:
            q: shape (nq,).
            v: shape (nv,).
        """

        def function(q: Array, v: Array, t: float) -> Array:
            out: Array = np.empty(self.mechanism.nq)
            self._tree.chart.rates(q, v, out)
            return out

        return self._answer(States.of(self.mechanism, q, v), function)

    @property
    def total_mass(self) -> float:
        """The mass of the bodies that can move, those not welded to the ground [kg]."""
        return self._tree.moving_mass

    def center_of_mass(
        self, q: Given, v: Given = None, a: Given = None, t: float | Array = 0.0
    ) -> PointMotion:
        """Return position, velocity and acceleration of the moving bodies' center of mass.

        Components are in world axes.

        Args:
            q: shape (nq,).
            v: shape (nv,).
            a: shape (nv,).
            t: time [s].

        Raises:
            EngineError: if they have no mass.
        """
        if not self._tree.moving_mass:
            raise EngineError(
                f"mechanism {self.mechanism.name!r} has no moving mass, so no center of mass"
            )
        states = States.of(self.mechanism, q, v, t, a)
        parts = self._answer(states, self._whole.center, accelerations=True)
        return PointMotion(*np.moveaxis(parts, -2, 0))
