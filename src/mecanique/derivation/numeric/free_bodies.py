"""Cut every body free, on batched floats: its motion, its loads and the seat of its joint.

Twists and wrenches have six components in world axes, three linear and three angular. The matrix
S(r) = [1 0; r× 1] refers a wrench at the end of an arm r to its beginning, and its transpose a
twist at the beginning to the end, so that their power is the same at both.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, final

import numpy as np

from mecanique.derivation.mechanics.forces import Forces
from mecanique.derivation.mechanics.recursion import TreeRecursion, World
from mecanique.derivation.mechanics.vectors import (
    Triple,
    add,
    apply,
    cross,
    position,
    rotation,
    scale,
    times_point,
)
from mecanique.derivation.numeric.dynamics import Latest
from mecanique.derivation.numeric.recursion import Recursion
from mecanique.model.bodies.tensor import tensor_of
from mecanique.model.mechanism import Mechanism
from mecanique.model.states import States


@final
@dataclass(frozen=True, eq=False)
class Snapshot:
    """All b free bodies of a mechanism at n states, each after its parent."""

    tree: TreeRecursion
    places: Mapping[str, int]  # index of each one, by name
    parents: tuple[int, ...]  # index of each one's parent, −1 for the ground
    moves: np.ndarray  # shape (b,), whether it can move relative to the ground
    masses: np.ndarray  # shape (b,) [kg]
    centers: np.ndarray  # shape (n, b, 3), positions of the centers of mass [m]
    arms: np.ndarray  # shape (n, b, 3), from the seat of each one's joint to its center of mass [m]
    steps: np.ndarray  # shape (n, b, 3), from its parent's seat to its own [m]
    # shape (n, b, 6, 6), masses and moments of inertia about the centers of mass [kg, kg·m²]
    inertia: np.ndarray
    # shape (n, b, 6), velocities of the centers of mass and of rotation [m/s, rad/s]
    twists: np.ndarray
    J: np.ndarray  # shape (n, b, 6, nv), their derivatives by the generalized velocities
    gamma: np.ndarray  # shape (n, b, 6), their rates for a = 0 [m/s², rad/s²]
    fall: np.ndarray  # shape (6,), acceleration of gravity [m/s²]
    # shape (n, b, 6), springs, dampers, drives and loads about the centers of mass [N, N·m]
    loads: np.ndarray
    u: np.ndarray  # shape (n, nu), joint velocities
    joint_gamma: np.ndarray  # shape (n, nu), their rates at constant generalized velocities
    rates: np.ndarray  # shape (n, nu, nv), their derivatives ∂u/∂v
    # shape (n, 6, nu), wrench at the seat of the body that does unit power with each joint velocity
    axes: np.ndarray
    # shape (nu,), index of the free body that each joint velocity moves relative to its parent
    holders: np.ndarray
    armature: np.ndarray  # shape (nu,), inertia of each joint's rotor [kg·m² or kg]
    springs: np.ndarray  # shape (n,), energy of the springs [J]

    @property
    def momenta(self) -> np.ndarray:
        """Momenta m v and H about the centers of mass, shape (n, b, 6) [kg·m/s, kg·m²/s]."""
        return times(self.inertia, self.twists)

    @property
    def weights(self) -> np.ndarray:
        """Weights, shape (n, b, 6) [N]."""
        return times(self.inertia, self.fall)

    @property
    def drift(self) -> np.ndarray:
        """Rates of the momenta for a = 0 less the weights, shape (n, b, 6) [N, N·m]."""
        rates = times(self.inertia, self.gamma - self.fall)
        rates[..., 3:] += cross_rows(self.twists[..., 3:], self.momenta[..., 3:])
        return rates


@final
class BatchFreeBodies:
    """The free bodies of a mechanism, ready to be evaluated in many states."""

    def __init__(self, mechanism: Mechanism) -> None:
        self._mechanism = mechanism
        # the tree only places bodies: what they weigh stands here, so it is given no mass
        self._recursion = Recursion(mechanism, moments=[np.zeros((4, 4))])
        links = [link for link in self._recursion.tree for _ in link.velocities]
        self._joints = mechanism.tree
        self._order = {joint.child: k for k, joint in enumerate(self._joints)}
        self._parents = tuple(self._order.get(joint.parent, -1) for joint in self._joints)
        holder = {joint.name: k for k, joint in enumerate(self._joints)}
        self._holders = np.array([holder[link.joint] for link in links], dtype=int)
        self._armature = np.array([mechanism.evaluate(link.armature) for link in links], float)
        self.columns = [(holder[link.joint], link.coordinates) for link in links]
        """For each joint velocity: index of the body it moves, and the coordinates it changes."""
        bodies = [mechanism.body(joint.child) for joint in self._joints]
        self._masses = np.array([mechanism.evaluate(body.mass) for body in bodies])
        centers = [self._numbers(body.center) for body in bodies]
        tensors = [tensor_of(self._numbers(body.inertia)) for body in bodies]
        self._centers, self._tensors = np.reshape(centers, (-1, 3)), np.reshape(tensors, (-1, 3, 3))
        self._fall = np.append(self._numbers(mechanism.gravity), np.zeros(3))
        self._latest = Latest(self._free)

    def at(self, states: States) -> Snapshot:
        """Return the free bodies at n states."""
        return self._latest.at(states)

    def _free(self, states: States) -> Snapshot:
        tree, n, count = self._recursion.place(states), len(states), len(self._joints)
        chart, world, seats = tree.chart, World(tree), tree.seats
        nu, nv = len(self._holders), self._mechanism.nv
        rates, joint_gamma = np.zeros((n, nu, nv)), np.zeros((n, nu))
        rates[:] = np.moveaxis(chart.G, -1, 0) if chart.order is None else chart.G
        for column, rate in zip(joint_gamma.T, chart.gamma, strict=True):
            column[:] = rate
        axes = np.zeros((n, 6, nu))
        for place in range(len(tree.links)):
            for u, unit in world.motion(place).columns.items():
                axes[:, :, u] = _columns(n, *unit)
        turns, vectors = np.empty((n, count, 3, 3)), np.empty((n, count, 21))
        for k, joint in enumerate(self._joints):
            seat, pose = seats[joint.child], tree.pose(joint.child)
            motion, center = world.motion(seat.place), self._centers[k][:, None]
            turns[:, k] = rotation(pose).transpose(2, 0, 1)
            # from the link's origin; differences of positions far from the world's lose digits
            reach = apply(tree.link_pose(seat.place), times_point(seat.pose, center))
            step = _step(tree, world, joint.child, joint.parent)
            of_link = (motion.v, motion.w, motion.a, motion.alpha)
            vectors[:, k] = _columns(n, position(pose), step, reach, *of_link)
        arms, inertia = times(turns, self._centers), np.zeros((n, count, 6, 6))
        inertia[..., range(3), range(3)] = self._masses[:, None]
        inertia[..., 3:, 3:] = turns @ self._tensors @ turns.swapaxes(-1, -2)
        seated, steps, reaches, twists, gamma = np.split(vectors, (3, 6, 9, 15), axis=-1)
        inward = cross_rows(twists[..., 3:], reaches)
        twists[..., :3] += inward
        gamma[..., :3] += cross_rows(gamma[..., 3:], reaches) + cross_rows(twists[..., 3:], inward)
        forces = Forces(tree.letters, tree)
        efforts = self._recursion.efforts_in_joints(states, chart)
        return Snapshot(
            tree=tree,
            places=self._order,
            parents=self._parents,
            moves=np.array([seats[joint.child].place >= 0 for joint in self._joints], dtype=bool),
            masses=self._masses,
            centers=seated + arms,
            arms=arms,
            steps=steps,
            inertia=inertia,
            twists=twists,
            J=self._jacobians(arms, steps, axes) @ rates[:, None],
            gamma=gamma,
            fall=self._fall,
            loads=self._load(forces, turns) + self._drive(forces, efforts, arms, steps, axes),
            u=np.broadcast_to(chart.u.T, joint_gamma.shape),
            joint_gamma=joint_gamma,
            rates=rates,
            axes=axes,
            holders=self._holders,
            armature=self._armature,
            springs=forces.energy() + np.zeros(n),
        )

    def _jacobians(self, arms: np.ndarray, steps: np.ndarray, axes: np.ndarray) -> np.ndarray:
        """Return the derivatives of the twists by the joint velocities, shape (n, b, 6, nu)."""
        at_seats = np.zeros((*arms.shape[:2], *axes.shape[1:]))
        to_seat = shift(steps).swapaxes(-1, -2)
        for k, parent in enumerate(self._parents):
            at_seats[:, k] = axes * (self._holders == k)
            if parent >= 0:
                at_seats[:, k] += to_seat[:, k] @ at_seats[:, parent]
        return np.asarray(shift(arms).swapaxes(-1, -2) @ at_seats)

    def _load(self, forces: Forces, turns: np.ndarray) -> np.ndarray:
        """Return the sums of the forces that act at points of the bodies, shape (n, b, 6)."""
        loads = np.zeros((*turns.shape[:2], 6))
        for action in forces.at_points():
            if action.body in self._order:
                k = self._order[action.body]
                arm = turns[:, k] @ (np.ravel(action.point) - self._centers[k])
                wrench = _columns(len(loads), action.force, action.moment)
                loads[:, k] += times(shift(arm), wrench)
        return loads

    def _drive(
        self,
        forces: Forces,
        efforts: np.ndarray | None,
        arms: np.ndarray,
        steps: np.ndarray,
        axes: np.ndarray,
    ) -> np.ndarray:
        """Return the forces in the joints: on the child at its seat, and their opposite there."""
        drives = np.zeros((len(axes), axes.shape[-1]))
        for u, push in forces.pushes_in_joints().items():
            drives[:, u] = push
        if efforts is not None:
            drives += efforts.T
        loads = np.zeros((*arms.shape[:2], 6))
        for u in np.flatnonzero(drives.any(axis=0)).tolist():
            k, wrench = self.columns[u][0], drives[:, u, None] * axes[:, :, u]
            loads[:, k] += times(shift(-arms[:, k]), wrench)
            if self._parents[k] >= 0:
                arm = steps[:, k] - arms[:, self._parents[k]]
                loads[:, self._parents[k]] -= times(shift(arm), wrench)
        return loads

    def _numbers(self, components: Sequence[Any]) -> np.ndarray:
        return np.array(self._mechanism.evaluate_all(tuple(components)))


_LEVERS = np.zeros((3, 6, 6))
"""The parts of S(r) that are proportional to x, y and z."""
_LEVERS[0, 5, 1] = _LEVERS[1, 3, 2] = _LEVERS[2, 4, 0] = 1.0
_LEVERS[0, 4, 2] = _LEVERS[1, 5, 0] = _LEVERS[2, 3, 1] = -1.0


def shift(arm: np.ndarray) -> np.ndarray:
    """Return S(r) of arms, shape (…, 6, 6); arm (…, 3)."""
    return np.asarray((arm @ _LEVERS.reshape(3, 36)).reshape(*arm.shape[:-1], 6, 6) + np.eye(6))


def cross_rows(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """Return a × b, shape (…, 3)."""
    return np.asarray(cross(a.T, b.T).T)


def times(matrix: np.ndarray, vector: np.ndarray) -> np.ndarray:
    """Multiply matrices by vectors, state by state; matrix (…, m, k), vector (…, k)."""
    product: np.ndarray = (matrix @ vector[..., None])[..., 0]
    return product


def _step(tree: TreeRecursion, world: World, child: str, parent: str) -> Triple:
    """Return the vector from a parent's seat to its child's, summed along the links."""
    seat, before = tree.seats[child], tree.seats[parent]
    step = apply(tree.link_pose(seat.place), position(seat.pose))
    at = seat.place
    while at != before.place:
        step = add(step, world.motion(at).step)
        at = tree.parent(at)
    return add(step, scale(-1.0, apply(tree.link_pose(at), position(before.pose))))


def _columns(n: int, *vectors: Triple) -> np.ndarray:
    """Return vectors of n states, or of all, one after another, shape (n, 3 × vectors)."""
    joined = np.empty((n, len(vectors), 3))
    for k, vector in enumerate(vectors):
        joined[:, k] = np.transpose(vector)
    return joined.reshape(n, -1)
