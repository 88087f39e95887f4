"""Springs, dampers, drives and loads on batched floats: what they do to each body and joint.

What acts on a body is collected as the 4×4 matrix D with virtual work δW = tr(δH D): a force F at
the body's point p gives D = (p, 1) (F, 0)ᵀ, a couple C gives D = ½ Rᵀ Ĉᵀ.
"""

from __future__ import annotations

from typing import Any, final

import numpy as np

from mecanique.derivation.tree.links import Link, hat, place_of
from mecanique.model.expression import Scalar, evaluate
from mecanique.model.forces import (
    Damper,
    Force,
    JointDamper,
    JointForce,
    JointSpring,
    Spring,
    Torque,
)
from mecanique.model.mechanism import Mechanism

__all__ = ["Loads"]

_HATS = np.stack([hat((0.0, 0.0, 0.0), axis) for axis in np.eye(3).tolist()])


@final
class Loads:
    """The forces of a mechanism, ready for many evaluations.

    Args:
        mechanism: whose forces.
        tree: its links.
    """

    def __init__(self, mechanism: Mechanism, tree: tuple[Link, ...]) -> None:
        self._mechanism = mechanism
        self._place = place_of(tree, mechanism)
        self._column = {
            name: k for k, name in enumerate(name for link in tree for name in link.velocities)
        }
        self._joint = {link.joint: link for link in tree}
        self._numbers: dict[Scalar, float] = {}

    def on_bodies(
        self, H: list[np.ndarray], Hd: list[np.ndarray], values: dict[str, Any], n: int
    ) -> dict[int, np.ndarray]:
        """Return D of each loaded link, by its place in the tree, each shape (n, 4, 4).

        Args:
            H: pose of each link, each shape (n, 4, 4).
            Hd: its rate [1/s].
            values: value of every symbol.
            n: number of states.
        """
        D: dict[int, np.ndarray] = {}

        def add(body: str, matrix: np.ndarray) -> None:
            place = self._place[body]
            if place >= 0:
                D[place] = D[place] + matrix if place in D else matrix

        for force in self._mechanism.forces:
            match force:
                case Spring() | Damper():
                    a, b = self._point(force.point_a), self._point(force.point_b)
                    reach = self._moved(H, force.body_b, b) - self._moved(H, force.body_a, a)
                    length = np.linalg.norm(reach, axis=-1, keepdims=True)
                    along = np.divide(reach, length, out=np.zeros_like(reach), where=length > 0)
                    if isinstance(force, Spring):
                        k, free = (self._number(s) for s in (force.stiffness, force.free_length))
                        pull = k * (reach - free * along)
                    else:
                        rate = self._rate(Hd, force.body_b, b) - self._rate(Hd, force.body_a, a)
                        c = self._number(force.damping)
                        pull = c * along * np.sum(along * rate, axis=-1, keepdims=True)
                    add(force.body_a, a[:, None] * pull[:, None, :])
                    add(force.body_b, -b[:, None] * pull[:, None, :])
                case Force():
                    components = self._turned(H, force.axes, self._vector(force.force, values, n))
                    add(force.body, self._point(force.point)[:, None] * components[:, None, :])
                case Torque():
                    components = self._turned(H, force.axes, self._vector(force.torque, values, n))
                    place = self._place[force.body]
                    if place >= 0:
                        couple = np.einsum("nk,kij->nij", components[:, :3], _HATS)
                        turn = np.zeros_like(H[place])
                        turn[:, :3, :3] = H[place][:, :3, :3]
                        add(force.body, 0.5 * np.swapaxes(couple @ turn, -1, -2))
        return D

    def on_joints(self, u: np.ndarray, r: dict[str, Any], values: dict[str, Any]) -> np.ndarray:
        """Return the forces of what acts in the joints, shape (n, nu).

        Args:
            u: shape (n, nu), joint velocities.
            r: value of each joint coordinate.
            values: value of every symbol.
        """
        Q = np.zeros_like(u)
        for force in self._mechanism.forces:
            if isinstance(force, (JointSpring, JointDamper, JointForce)):
                link = self._joint[force.joint]
                k = self._column[link.velocities[0]]
                match force:
                    case JointSpring():
                        stretch = r[link.coordinates[0]] - self._number(force.reference)
                        Q[:, k] -= self._number(force.stiffness) * stretch
                    case JointDamper():
                        Q[:, k] -= self._number(force.damping) * u[:, k]
                    case JointForce():
                        Q[:, k] += evaluate(force.force, values)
        return Q

    def energy(self, H: list[np.ndarray], r: dict[str, Any], n: int) -> np.ndarray:
        """Return the springs' energy Σ ½ k (elongation)², shape (n,) [J].

        Args:
            H: pose of each link, each shape (n, 4, 4).
            r: value of each joint coordinate.
            n: number of states.
        """
        total = np.zeros(n)
        for force in self._mechanism.forces:
            if isinstance(force, Spring):
                ends = (force.body_a, force.point_a), (force.body_b, force.point_b)
                a, b = (self._moved(H, body, self._point(point)) for body, point in ends)
                stretch = np.linalg.norm(b - a, axis=-1) - self._number(force.free_length)
            elif isinstance(force, JointSpring):
                name = self._joint[force.joint].coordinates[0]
                stretch = r[name] - self._number(force.reference)
            else:
                continue
            total = total + 0.5 * self._number(force.stiffness) * stretch**2
        return total

    def _number(self, scalar: Scalar) -> float:
        if scalar not in self._numbers:
            self._numbers[scalar] = self._mechanism.evaluate(scalar)
        return self._numbers[scalar]

    def _point(self, point: tuple[Scalar, Scalar, Scalar]) -> np.ndarray:
        return np.array([*(self._number(c) for c in point), 1.0])

    def _vector(
        self, components: tuple[Scalar, Scalar, Scalar], values: dict[str, Any], n: int
    ) -> np.ndarray:
        columns = [np.broadcast_to(evaluate(c, values), (n,)) for c in components]
        return np.stack([*columns, np.zeros(n)], axis=-1)

    def _moved(self, H: list[np.ndarray], body: str, point: np.ndarray) -> np.ndarray:
        """A point (p, 1) in the world; one of the ground has no batch axis."""
        place = self._place[body]
        moved: np.ndarray = H[place] @ point if place >= 0 else point
        return moved

    def _rate(self, Hd: list[np.ndarray], body: str, point: np.ndarray) -> np.ndarray:
        place = self._place[body]
        rate: np.ndarray = Hd[place] @ point if place >= 0 else np.zeros(4)
        return rate

    def _turned(self, H: list[np.ndarray], axes: str, components: np.ndarray) -> np.ndarray:
        """Components (F, 0) in the world."""
        place = -1 if axes == "world" else self._place[axes]
        turned: np.ndarray = (
            (H[place] @ components[..., None])[..., 0] if place >= 0 else components
        )
        return turned
