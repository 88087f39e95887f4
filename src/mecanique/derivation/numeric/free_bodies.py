"""Cut every body free, on batched floats: its motion, its loads and the seat of its joint."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, final

import numpy as np

from mecanique.derivation.numeric.chart import CoordinateMap, Motions
from mecanique.derivation.numeric.frames import Frame, cross, frames
from mecanique.derivation.numeric.loads import Loads
from mecanique.derivation.tree.links import links, moving, place_of
from mecanique.derivation.tree.poses import placement_matrix
from mecanique.model.bodies.tensor import tensor_of
from mecanique.model.expression import Scalar
from mecanique.model.joints import Joint
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
        turning = cross(self.spin, self.angular_momentum)
        return np.asarray(times(self.inertia, self.gamma_spin) + turning)


@final
@dataclass(frozen=True, eq=False)
class Snapshot:
    """All free bodies of a mechanism at n states."""

    bodies: tuple[FreeBody, ...]  # each after its parent
    motions: Motions  # joint coordinates and velocities
    # shape (n, 6, nu), wrench at the seat of the body that does unit power with each joint velocity
    axes: np.ndarray
    # shape (nu,), index of the free body that each joint velocity moves relative to its parent
    holders: np.ndarray
    armature: np.ndarray  # shape (nu,), inertia of each joint's rotor [kg·m² or kg]
    springs: np.ndarray  # shape (n,), energy of the springs [J]

    @property
    def rates(self) -> np.ndarray:
        """Derivatives of the joint velocities, ∂u/∂v, shape (n, nu, nv)."""
        nu = len(self.armature)
        return spread(np.broadcast_to(np.eye(nu), (len(self.springs), nu, nu)), self.motions)


@final
class FreeBodies:
    """The free bodies of a mechanism, ready to be evaluated in many states."""

    def __init__(self, mechanism: Mechanism) -> None:
        self.mechanism = mechanism
        self._tree = links(mechanism)
        self._chart = CoordinateMap(mechanism, self._tree)
        self._loads = Loads(mechanism, self._tree)
        self._place = place_of(self._tree, mechanism)
        self.gravity = self._numbers(mechanism.gravity)
        self._origins = [placement_matrix(link.origin, mechanism.values) for link in self._tree]
        self._joints = mechanism.tree
        order = {joint.child: k for k, joint in enumerate(self._joints)}
        self._parents = [order.get(joint.parent, -1) for joint in self._joints]
        holder = {joint.name: k for k, joint in enumerate(self._joints)}
        self._holders = np.array(
            [holder[link.joint] for link in self._tree for _ in link.velocities], dtype=int
        )
        self._armature = np.array(
            [mechanism.evaluate(link.armature) for link in self._tree for _ in link.velocities],
            dtype=float,
        )
        self.columns = [
            (int(holder[link.joint]), link.coordinates)
            for link in self._tree
            for _ in link.velocities
        ]
        """For each joint velocity: index of the body it moves, and the coordinates it changes."""
        self._free = moving(self._tree)
        self._masses = [self._mass(joint.child) for joint in self._joints]

    def at(self, states: States) -> Snapshot:
        """Return the free bodies at n states."""
        move = self._chart.motions(states)
        links = frames(self._tree, self._origins, move)
        axes = np.concatenate(
            [np.zeros((len(states), 6, 0)), *(frame.axes for frame in links)], axis=2
        )
        poses = [frame.pose for frame in links]
        loaded = self._loads.on_bodies(
            poses, [frame.pose_rate for frame in links], states.values, len(states)
        )
        drives = self._loads.on_joints(move, states)
        wrenches = self._wrenches(links, loaded, drives[:, None, :] * axes)
        bodies = []
        for k, joint in enumerate(self._joints):
            chain = self._chain(joint)
            bodies.append(self._body(k, [links[place] for place in chain], move, *wrenches[k]))
        springs = self._loads.energy(poses, move.r, len(states))
        return Snapshot(
            bodies=tuple(bodies),
            motions=move,
            axes=axes,
            holders=self._holders,
            armature=self._armature,
            springs=springs,
        )

    def moving(self, states: States) -> list[FreeBody]:
        """Return the free bodies that can move relative to the ground."""
        return [body for body in self.at(states).bodies if self._free[self._place[body.name]]]

    def _chain(self, joint: Joint) -> list[int]:
        """Return the indices of a joint's links, from the child toward the parent."""
        place, chain = self._place[joint.child], list[int]()
        while place != self._place[joint.parent]:
            chain.append(place)
            place = self._tree[place].parent
        return chain

    def _body(
        self, k: int, chain: list[Frame], move: Motions, force: np.ndarray, moment: np.ndarray
    ) -> FreeBody:
        frame, (mass, center, inertia) = chain[0], self._masses[k]
        arm = frame.turn @ center
        at = frame.seat + arm
        inward = cross(frame.spin, arm)
        return FreeBody(
            name=self._joints[k].child,
            joint=self._joints[k].name,
            parent=self._parents[k],
            mass=mass,
            seat=frame.seat,
            turn=frame.turn,
            center=at,
            # summed, since differences of positions far from the world's origin lose digits
            step=sum((link.step for link in chain[1:]), frame.step),
            arm=arm,
            velocity=frame.velocity + inward,
            spin=frame.spin,
            inertia=frame.turn @ inertia @ np.swapaxes(frame.turn, 1, 2),
            J=spread(frame.J + cross(frame.J_spin, arm[:, :, None]), move),
            gamma=frame.gamma + cross(frame.gamma_spin, arm) + cross(frame.spin, inward),
            J_spin=spread(frame.J_spin, move),
            gamma_spin=frame.gamma_spin,
            force=force,
            moment=moment - cross(at, force),
        )

    def _wrenches(
        self, found: list[Frame], loaded: dict[int, np.ndarray], drives: np.ndarray
    ) -> list[tuple[np.ndarray, np.ndarray]]:
        """Return the applied force on each free body, with its moment about the world's origin."""
        n = len(drives)
        force, moment = np.zeros((len(self._joints), n, 3)), np.zeros((len(self._joints), n, 3))
        place = {self._place[joint.child]: k for k, joint in enumerate(self._joints)}
        for link, D in loaded.items():
            # (p, 1) F in world coordinates: the skew part is p × F
            outer = found[link].pose @ D
            skew = outer - np.swapaxes(outer, 1, 2)
            force[place[link]] += D[:, 3, :3]
            moment[place[link]] += np.stack([skew[:, 1, 2], skew[:, 2, 0], skew[:, 0, 1]], axis=-1)
        for u, k in enumerate(self._holders):
            F, seat = drives[:, :3, u], found[self._place[self._joints[k].child]].seat
            M = drives[:, 3:, u] + cross(seat, F)
            force[k] += F
            moment[k] += M
            if self._parents[k] >= 0:
                force[self._parents[k]] -= F
                moment[self._parents[k]] -= M
        return list(zip(force, moment, strict=True))

    def _mass(self, name: str) -> tuple[float, np.ndarray, np.ndarray]:
        body = self.mechanism.body(name)
        tensor = tensor_of(self._numbers(body.inertia))
        return self.mechanism.evaluate(body.mass), self._numbers(body.center), tensor

    def _numbers(self, components: Any) -> np.ndarray:
        scalars: tuple[Scalar, ...] = tuple(components)
        return np.array(self.mechanism.evaluate_all(scalars))


def total_momentum(
    bodies: Sequence[FreeBody], count: int
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return the linear momentum, and the angular ones about origin and center of mass.

    They are the sums of m v_C and of H_C + r_C × m v_C, each shape (n, 3) (Fundamentals of
    Dynamics, eqs. 1.7, 1.9, 1.11).
    """
    linear, angular, first = (np.zeros((count, 3)) for _ in range(3))
    mass = 0.0
    for body in bodies:
        push = body.mass * body.velocity
        linear = linear + push
        angular = angular + body.angular_momentum + cross(body.center, push)
        first, mass = first + body.mass * body.center, mass + body.mass
    center = first / mass if mass else first
    return linear, angular, angular - cross(center, linear)


def spread(columns: np.ndarray, move: Motions) -> np.ndarray:
    """Turn a Jacobian in the joint velocities into one in the generalized velocities.

    Shape (n, k, nv).
    Shapes: columns (n, k, nu).
    """
    if move.G is not None:
        return np.asarray(columns @ move.G)
    out = np.empty_like(columns)
    out[:, :, move.order] = columns
    return out


def times(matrix: np.ndarray, vector: np.ndarray) -> np.ndarray:
    """Multiply matrices by vectors, state by state; matrix (n, 3, 3), vector (n, 3)."""
    product: np.ndarray = (matrix @ vector[..., None])[..., 0]
    return product
