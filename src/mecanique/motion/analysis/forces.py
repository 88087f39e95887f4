"""All forces on all bodies, with reactions and d'Alembert's inertia forces.

On each body they are in equilibrium (d'Alembert's principle, Fundamentals of Dynamics, eqs. 1.21,
1.22).
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Literal, TypeAlias, final

import numpy as np

from mecanique.model.bodies.tensor import tensor_of
from mecanique.model.expression import Scalar, Vector
from mecanique.model.force_base import ForceKind
from mecanique.model.mechanism import Mechanism
from mecanique.model.mechanism.description import bodies_with_inertia, bodies_with_mass
from mecanique.motion.compile.along import StateLaw

if TYPE_CHECKING:
    from mecanique.reference import Reference
    from mecanique.reference.engine.answers import AppliedForce


TOGETHER = "reactions and guides"
"""What acts on a body in joints that something not described guides: only its sum is known."""

Kind: TypeAlias = ForceKind | Literal["weight", "reaction", "inertia"]


@final
@dataclass(frozen=True, eq=False)
class Action:
    """A force and a moment on a body over n states, world axes."""

    name: str  # of the force, the joint, or the body for weight and inertia
    kind: Kind
    body: str
    other: str | None  # the body that takes the opposite; None if nothing in the mechanism does
    origin: np.ndarray  # shape (n, 3), point of application [m]
    force: np.ndarray  # shape (n, 3) [N]
    moment: np.ndarray  # shape (n, 3), about that point [N·m]


@final
class Actions:
    """The forces on a mechanism's bodies, batched over states."""

    def __init__(self, mechanism: Mechanism, reference: Reference) -> None:
        self._mechanism = mechanism
        self._reference = reference
        self._at = {body.name: k for k, body in enumerate(mechanism.bodies)}
        self._gravity = np.array(mechanism.evaluate_all(mechanism.gravity))
        self._kinds: dict[str, Kind] = {force.name: force.kind for force in mechanism.forces}
        self._heavy = bodies_with_mass(mechanism)
        self._inert = bodies_with_inertia(mechanism)

    def applied(self, t: np.ndarray, q: np.ndarray, v: np.ndarray) -> Iterator[Action]:
        """Yield weights, springs, dampers, drives and loads."""
        poses = self._reference.poses(q, t)
        zero = np.zeros((len(t), 3))
        for body in self._heavy:
            weight = zero + self._mechanism.evaluate(body.mass) * self._gravity
            center = self._point(poses, body.name, body.center)
            yield Action(body.name, "weight", body.name, None, center, weight, zero)
        for load in self._reference.applied(q, v, t):
            yield _act(load, self._kinds[load.name])

    def all(self, t: np.ndarray, q: np.ndarray, v: np.ndarray, a: np.ndarray) -> Iterator[Action]:
        """Yield what is applied, then reactions, then d'Alembert's forces."""
        yield from self.applied(t, q, v)
        yield from self.reactions(t, q, v)
        yield from self.inertia(t, q, v, a)

    def reactions(self, t: np.ndarray, q: np.ndarray, v: np.ndarray) -> Iterator[Action]:
        """Yield the wrenches of joints on child and parent, of loops and elements on both bodies.

        Where something that is not described acts across joints of a body, their reactions are not
        determined: what all of them and the guides do to the body comes as one, `TOGETHER`. With a
        velocity constraint, which does not say by which force it acts, none is determined.
        """
        if self._mechanism.velocity_constraints:
            return
        poses = self._reference.poses(q, t)
        guided = self._reference.guided
        if guided or self._mechanism.elements:
            wrenches = self._reference.totals(q, v, t, elements=False)
        else:
            wrenches = StateLaw(self._mechanism, self._reference).reactions(t, q, v)
        seats = [
            (joint.child, joint.parent, self._origin(poses, joint.child))
            for joint in self._mechanism.joints
        ]
        seats += [
            (loop.body_b, loop.body_a, self._point(poses, loop.body_b, loop.frame_b.xyz))
            for loop in self._mechanism.loops
        ]
        places = self._reference.contact_points(q, t)
        for contact, place in zip(self._mechanism.contacts, places.values(), strict=True):
            seats.append((contact.body, contact.on, place))
        # a rod without mass acts along its line: on each body at its own end
        ends = {
            loop.name: self._point(poses, loop.body_a, loop.frame_a.xyz)
            for loop in self._mechanism.loops
            if loop.kind == "distance"
        }
        sums: dict[str, list[np.ndarray]] = {}
        for (name, wrench), (body, partner, at) in zip(wrenches.items(), seats, strict=True):
            if name in guided:
                for on, sign in ((body, 1.0), (partner, -1.0)):
                    arm = at - self._origin(poses, on)
                    force, moment = sums.setdefault(on, [np.zeros(at.shape), np.zeros(at.shape)])
                    force += sign * wrench.force
                    moment += sign * (wrench.moment + np.cross(arm, wrench.force))
                continue
            # that of `Reference` is about the hub of a body that rolls
            moment = np.zeros(at.shape) if name in places else wrench.moment
            yield Action(name, "reaction", body, partner, at, wrench.force, moment)
            there = ends.get(name, at)
            yield Action(name, "reaction", partner, body, there, -wrench.force, -moment)
        for guided_by in self._reference.guide_actions(q, v, t):
            yield _act(guided_by, "reaction")
        for body, (force, moment) in sums.items():
            if body != self._mechanism.ground:
                at = self._origin(poses, body)
                yield Action(TOGETHER, "reaction", body, None, at, force, moment)

    def inertia(
        self, t: np.ndarray, q: np.ndarray, v: np.ndarray, a: np.ndarray
    ) -> Iterator[Action]:
        """Yield d'Alembert's forces: −m a_C at the center of mass C, and −(I α + ω × I ω)."""
        moving = self._reference.motions(q, v, a, t)
        for body in self._inert:
            at = self._at[body.name]
            pose, omega = moving.poses[:, at], moving.angular_velocities[:, at]
            alpha, turn = moving.angular_accelerations[:, at], pose[:, :3, :3]
            rho = turn @ self._numbers(body.center)
            tensor = tensor_of(self._numbers(body.inertia))
            inertia = turn @ tensor @ turn.transpose(0, 2, 1)
            spin = np.einsum("nij,nj->ni", inertia, omega)
            rate = np.einsum("nij,nj->ni", inertia, alpha) + np.cross(omega, spin)
            acceleration = moving.accelerations[:, at] + np.cross(alpha, rho)
            acceleration += np.cross(omega, np.cross(omega, rho))
            force = -self._mechanism.evaluate(body.mass) * acceleration
            yield Action(body.name, "inertia", body.name, None, pose[:, :3, 3] + rho, force, -rate)

    def _numbers(self, components: Sequence[Scalar]) -> np.ndarray:
        return np.array(self._mechanism.evaluate_all(components))

    def _origin(self, poses: np.ndarray, body: str) -> np.ndarray:
        at: np.ndarray = poses[:, self._at[body], :3, 3]
        return at

    def _point(self, poses: np.ndarray, body: str, point: Vector) -> np.ndarray:
        at: np.ndarray = self._origin(poses, body) + poses[
            :, self._at[body], :3, :3
        ] @ self._numbers(point)
        return at


def _act(load: AppliedForce, kind: Kind) -> Action:
    points = (load.point, load.force, load.moment)
    return Action(load.name, kind, load.body, load.other, *points)
