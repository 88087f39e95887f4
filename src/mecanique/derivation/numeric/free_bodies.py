"""Cut every body free, on batched floats: its motion, its loads and the seat of its joint."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, final

import numpy as np

from mecanique.derivation.mechanics.chart import JointMotion
from mecanique.derivation.mechanics.forces import Forces
from mecanique.derivation.mechanics.recursion import TreeRecursion, World
from mecanique.derivation.mechanics.vectors import (
    STILL,
    Triple,
    add,
    apply,
    as_rows,
    cross,
    position,
    rotation,
    scale,
    times_point,
)
from mecanique.derivation.numeric.dynamics import Latest
from mecanique.derivation.numeric.recursion import Recursion
from mecanique.model.bodies.tensor import tensor_of
from mecanique.model.expression import Scalar
from mecanique.model.mechanism import Mechanism
from mecanique.model.states import States


@final
@dataclass(frozen=True, eq=False)
class FreeBody:
    """A free body over n states, in world axes; its center of mass accelerates by J a + γ."""

    name: str
    joint: str  # name of the joint that connects it to its parent
    parent: int  # index of its parent among the free bodies, −1 for the ground
    mass: float  # [kg]
    seat: np.ndarray  # shape (n, 3), position of its joint, the origin of its frame [m]
    turn: np.ndarray  # shape (n, 3, 3), rotation of its frame
    center: np.ndarray  # shape (n, 3), position of its center of mass [m]
    step: np.ndarray  # shape (n, 3), vector from its parent's seat to its own [m]
    arm: np.ndarray  # shape (n, 3), vector from its seat to its center of mass [m]
    velocity: np.ndarray  # shape (n, 3), of the center of mass [m/s]
    spin: np.ndarray  # shape (n, 3), angular velocity [rad/s]
    inertia: np.ndarray  # shape (n, 3, 3), about the center of mass [kg·m²]
    # shape (n, 3, nv), Jacobian of the center of mass's velocity in the generalized ones
    J: np.ndarray
    gamma: np.ndarray  # shape (n, 3), acceleration of the center of mass for a = 0 [m/s²]
    J_spin: np.ndarray  # shape (n, 3, nv), Jacobian of the angular velocity
    gamma_spin: np.ndarray  # shape (n, 3), angular acceleration for a = 0 [rad/s²]
    force: np.ndarray  # shape (n, 3), resultant of springs, dampers, drives and loads [N]
    moment: np.ndarray  # shape (n, 3), their moment about the center of mass [N·m]

    @property
    def angular_momentum(self) -> np.ndarray:
        """Angular momentum about the center of mass, shape (n, 3) [kg·m²/s]."""
        return times(self.inertia, self.spin)

    @property
    def tumbling(self) -> np.ndarray:
        """Rate of the angular momentum for a = 0, I γ_spin + ω × I ω, shape (n, 3) [N·m]."""
        turning = cross_rows(self.spin, self.angular_momentum)
        return np.asarray(times(self.inertia, self.gamma_spin) + turning)


@final
@dataclass(frozen=True, eq=False)
class Snapshot:
    """All free bodies of a mechanism at n states."""

    bodies: tuple[FreeBody, ...]  # each after its parent
    u: np.ndarray  # shape (n, nu), joint velocities
    gamma: np.ndarray  # shape (n, nu), their rates at constant generalized velocities
    rates: np.ndarray  # shape (n, nu, nv), their derivatives ∂u/∂v
    # shape (n, 6, nu), wrench at the seat of the body that does unit power with each joint velocity
    axes: np.ndarray
    # shape (nu,), index of the free body that each joint velocity moves relative to its parent
    holders: np.ndarray
    armature: np.ndarray  # shape (nu,), inertia of each joint's rotor [kg·m² or kg]
    springs: np.ndarray  # shape (n,), energy of the springs [J]


@final
class BatchFreeBodies:
    """The free bodies of a mechanism, ready to be evaluated in many states."""

    def __init__(self, mechanism: Mechanism) -> None:
        self.mechanism = mechanism
        self._recursion = Recursion(mechanism)
        tree = self._recursion.tree
        self.gravity = self._numbers(mechanism.gravity)
        self._joints = mechanism.tree
        order = {joint.child: k for k, joint in enumerate(self._joints)}
        self._parents = [order.get(joint.parent, -1) for joint in self._joints]
        holder = {joint.name: k for k, joint in enumerate(self._joints)}
        self._holders = np.array(
            [holder[link.joint] for link in tree for _ in link.velocities], dtype=int
        )
        self._armature = np.array(
            [mechanism.evaluate(link.armature) for link in tree for _ in link.velocities],
            dtype=float,
        )
        self.columns = [
            (int(holder[link.joint]), link.coordinates) for link in tree for _ in link.velocities
        ]
        """For each joint velocity: index of the body it moves, and the coordinates it changes."""
        self._masses = [self._mass(joint.child) for joint in self._joints]
        self._latest = Latest(self._free)

    def at(self, states: States) -> Snapshot:
        """Return the free bodies at n states."""
        return self._latest.at(states)

    def _free(self, states: States) -> Snapshot:
        tree = self._recursion.at(states)
        chart, world, n = tree.chart, World(tree), len(states)
        slides, turns = np.zeros((2, 3, len(self._holders), n))
        for place in range(len(tree.links)):
            for k, (slide, turn) in world.motion(place).columns.items():
                slides[:, k], turns[:, k] = as_fill(slide), as_fill(turn)
        axes = np.concatenate([slides, turns]).transpose(2, 0, 1)
        bodies = [self._body(k, tree, world, n) for k in range(len(self._joints))]
        forces = Forces(tree.letters, tree)
        self._load(bodies, forces)
        drives = np.zeros((n, len(self._holders)))
        for u, push in forces.pushes_in_joints().items():
            drives[:, u] = push
        efforts = self._recursion.efforts_in_joints(states, chart)
        if efforts is not None:
            drives += efforts.T
        self._drive(bodies, drives[:, None] * axes)
        gamma = np.zeros((n, len(self._holders)))
        for column, rate in zip(gamma.T, chart.gamma, strict=True):
            column[:] = rate
        rates = np.zeros((n, len(self._holders), self.mechanism.nv))
        rates[:] = np.moveaxis(as_rows([as_rows(row) for row in chart.G]), -1, 0)
        return Snapshot(
            bodies=tuple(bodies),
            u=np.broadcast_to(chart.u.T, gamma.shape),
            gamma=gamma,
            rates=rates,
            axes=axes,
            holders=self._holders,
            armature=self._armature,
            springs=forces.energy() + np.zeros(n),
        )

    def moving(self, states: States) -> list[FreeBody]:
        """Return the free bodies that can move relative to the ground."""
        seats = self._recursion.at(states).seats
        return [body for body in self.at(states).bodies if seats[body.name].place >= 0]

    def _body(self, k: int, tree: TreeRecursion, world: World, n: int) -> FreeBody:
        """Return a body without its loads."""
        joint, (mass, center, inertia) = self._joints[k], self._masses[k]
        seat, before = tree.seats[joint.child], tree.seats[joint.parent]
        pose, motion = tree.pose(joint.child), world.motion(seat.place)
        # from the origin of the link to the center of mass, and along the links to each joint;
        # summed, since differences of positions far from the world's origin lose digits
        arm = apply(tree.link_pose(seat.place), times_point(seat.pose, center[:, None]))
        J, J_spin = np.zeros((2, 3, len(self._holders), n))
        at, lever = seat.place, arm
        while at >= 0:
            for u, (slide, axis) in world.motion(at).columns.items():
                moved = add(slide, cross(axis, lever))
                J[:, u], J_spin[:, u] = as_fill(moved), as_fill(axis)
            lever = add(lever, world.motion(at).step)
            at = tree.parent(at)
        step = apply(tree.link_pose(seat.place), position(seat.pose))
        at = seat.place
        while at != before.place:
            step = add(step, world.motion(at).step)
            at = tree.parent(at)
        step = add(step, scale(-1.0, apply(tree.link_pose(at), position(before.pose))))
        inward = cross(motion.w, arm)
        turn = np.zeros((n, 3, 3))
        turn[:] = rotation(pose).transpose(2, 0, 1)
        accelerated = add(motion.a, cross(motion.alpha, arm), cross(motion.w, inward))
        vectors = (
            position(pose),
            step,
            add(motion.v, inward),
            motion.w,
            accelerated,
            motion.alpha,
        )
        columns = np.zeros((len(vectors), 3, n))
        for column, vector in zip(columns, vectors, strict=True):
            if vector is not STILL:
                column[:] = vector
        start, step, velocity, spin, gamma, gamma_spin = columns.transpose(0, 2, 1)
        from_seat = turn @ center
        force, moment = np.zeros((2, n, 3))
        return FreeBody(
            name=joint.child,
            joint=joint.name,
            parent=self._parents[k],
            mass=mass,
            seat=start,
            turn=turn,
            center=start + from_seat,
            step=step,
            arm=from_seat,
            velocity=velocity,
            spin=spin,
            inertia=turn @ inertia @ turn.transpose(0, 2, 1),
            J=_project_jacobian(J, tree.chart),
            gamma=gamma,
            J_spin=_project_jacobian(J_spin, tree.chart),
            gamma_spin=gamma_spin,
            force=force,
            moment=moment,
        )

    def _load(self, bodies: Sequence[FreeBody], forces: Forces) -> None:
        """Add the forces that act at points of the bodies, and their moments about the centers."""
        index = {joint.child: k for k, joint in enumerate(self._joints)}
        for action in forces.at_points():
            if action.body not in index:
                continue
            k = index[action.body]
            body = bodies[k]
            force = np.broadcast_to(np.transpose(action.force), body.force.shape)
            arm = body.turn @ (np.ravel(action.point) - self._masses[k][1])
            body.force[:] += force
            body.moment[:] += np.transpose(action.moment) + cross_rows(arm, force)

    def _drive(self, bodies: Sequence[FreeBody], drives: np.ndarray) -> None:
        """Add the forces in the joints: on the child at its seat, and their opposite there."""
        for u, k in enumerate(self._holders):
            body, force, moment = bodies[k], drives[:, :3, u], drives[:, 3:, u]
            body.force[:] += force
            body.moment[:] += moment - cross_rows(body.arm, force)
            if body.parent >= 0:
                parent = bodies[body.parent]
                parent.force[:] -= force
                parent.moment[:] -= moment + cross_rows(body.step - parent.arm, force)

    def _mass(self, name: str) -> tuple[float, np.ndarray, np.ndarray]:
        body = self.mechanism.body(name)
        tensor = tensor_of(self._numbers(body.inertia))
        return self.mechanism.evaluate(body.mass), self._numbers(body.center), tensor

    def _numbers(self, components: Any) -> np.ndarray:
        scalars: tuple[Scalar, ...] = tuple(components)
        return np.array(self.mechanism.evaluate_all(scalars))


def as_fill(vector: Triple) -> Any:
    """Return a vector as what can be assigned to an array of the shape (3, n)."""
    return 0.0 if vector is STILL else vector


def cross_rows(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """Return a × b, as `np.cross` on axis 1 does in twice the time, shape (n, 3) or (n, 3, k)."""
    ax, ay, az = a[:, 0], a[:, 1], a[:, 2]
    bx, by, bz = b[:, 0], b[:, 1], b[:, 2]
    x = ay * bz - az * by
    turned = np.empty((len(x), 3, *x.shape[1:]))
    turned[:, 0] = x
    turned[:, 1] = az * bx - ax * bz
    turned[:, 2] = ax * by - ay * bx
    return turned


def _project_jacobian(J: np.ndarray, chart: JointMotion) -> np.ndarray:
    """Return a Jacobian in the generalized velocities, shape (n, 3, nv); J (3, nu, n)."""
    if chart.places is not None:
        return np.asarray(J[:, chart.places].transpose(2, 0, 1))
    return np.asarray(J.transpose(2, 0, 1) @ chart.G.transpose(2, 0, 1))


def times(matrix: np.ndarray, vector: np.ndarray) -> np.ndarray:
    """Multiply matrices by vectors, state by state; matrix (n, 3, 3), vector (n, 3)."""
    product: np.ndarray = (matrix @ vector[..., None])[..., 0]
    return product
