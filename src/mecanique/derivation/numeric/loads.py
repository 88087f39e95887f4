"""Evaluate springs, dampers, drives and loads on batched floats, on each body and joint.

The wrench on a body is collected as the 4×4 matrix D with virtual work δW = tr(δH D): a force F at
the body's point p gives D = (p, 1) (F, 0)ᵀ, a couple C gives D = ½ Rᵀ Ĉᵀ.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, final

import numpy as np

from mecanique.derivation.laws import Law, Travel, laws_of
from mecanique.derivation.mechanics.forces import Span
from mecanique.derivation.numeric.chart import Motions, efforts_in_joints
from mecanique.derivation.tree.links import Link, hat, place_of
from mecanique.model.expression import Scalar, evaluate, symbols_in
from mecanique.model.force_base import AnyForce, BodyLoad, JointLoad, LineLoad
from mecanique.model.mechanism import Mechanism
from mecanique.model.states import States

_HATS = np.stack([hat((0.0, 0.0, 0.0), axis) for axis in np.eye(3).tolist()])


@final
class Loads:
    """The forces of a mechanism, ready for many evaluations."""

    def __init__(self, mechanism: Mechanism, tree: tuple[Link, ...]) -> None:
        self._mechanism = mechanism
        self._place = place_of(tree, mechanism)
        names = [name for link in tree for name in link.velocities]
        self._column = {name: k for k, name in enumerate(names)}
        self._joint = {link.joint: link for link in tree}
        self._constants: dict[Scalar, float | None] = {}

    def on_bodies(
        self, H: list[np.ndarray], Hd: list[np.ndarray], values: dict[str, Any], n: int
    ) -> dict[int, np.ndarray]:
        """Return D of each loaded link, by its place in the tree, each shape (n, 4, 4).

        Shapes: H (n, 4, 4), Hd [1/s].
        """
        D: dict[int, np.ndarray] = {}

        def add(body: str, matrix: np.ndarray) -> None:
            place = self._place[body]
            if place >= 0:
                D[place] = D[place] + matrix if place in D else matrix

        for force in self._mechanism.forces:
            match force:
                case LineLoad():
                    a, b = (self._point(end.point) for end in force.ends)
                    span = self._span(force, H, Hd, n)
                    for law in self._laws(force, values):
                        pull = np.stack([*law.pull(span), np.zeros(n)], axis=-1)
                        add(force.body_a, a[:, None] * pull[:, None, :])
                        add(force.body_b, -b[:, None] * pull[:, None, :])
                case BodyLoad():
                    wrench = force.wrench
                    place = self._place[wrench.body]
                    if wrench.force is not None:
                        F = self._rotate(H, wrench.axes, self._vector(wrench.force, values, n))
                        add(wrench.body, self._point(wrench.point)[:, None] * F[:, None, :])
                    if wrench.torque is not None and place >= 0:
                        C = self._rotate(H, wrench.axes, self._vector(wrench.torque, values, n))
                        couple = np.einsum("nk,kij->nij", C[:, :3], _HATS)
                        turn = np.zeros_like(H[place])
                        turn[:, :3, :3] = H[place][:, :3, :3]
                        add(wrench.body, 0.5 * np.swapaxes(couple @ turn, -1, -2))
        return D

    def on_joints(self, move: Motions, states: States) -> np.ndarray:
        """Return the forces in the joints, including given torques, shape (n, nu)."""
        Q = np.zeros_like(move.u)
        torques = efforts_in_joints(states, move, self._column)
        if torques is not None:
            Q += torques
        for force in self._mechanism.forces:
            if isinstance(force, JointLoad):
                link = self._joint[force.joint]
                k = self._column[link.velocities[0]]
                travel = Travel(move.r[link.coordinates[0]], move.u[:, k])
                for law in self._laws(force, states.values):
                    Q[:, k] -= law.pull(travel)
        return Q

    def energy(self, H: list[np.ndarray], r: dict[str, Any], n: int) -> np.ndarray:
        """Return the springs' energy Σ ½ k (elongation)², shape (n,) [J]; H (n, 4, 4)."""
        total = np.zeros(n)
        for force in self._mechanism.forces:
            if not force.conservative or isinstance(force, BodyLoad):
                continue
            along: Span | Travel
            if isinstance(force, LineLoad):
                along = self._span(force, H, None, n)
            else:
                along = Travel(r[self._joint[force.joint].coordinates[0]], None)
            for law in self._laws(force, self._mechanism.values):
                if law.kind == "potential":
                    total = total + law.scalar(along)
        return total

    def _laws(self, force: AnyForce, values: Mapping[str, Any]) -> tuple[Law, ...]:
        return laws_of(force, lambda scalar: self._number(scalar, values))

    def _number(self, scalar: Scalar, values: Mapping[str, Any]) -> Any:
        """Evaluate a scalar; one that depends on parameters alone is evaluated only once."""
        if scalar not in self._constants:
            is_constant = symbols_in(scalar) <= self._mechanism.values.keys()
            self._constants[scalar] = self._mechanism.evaluate(scalar) if is_constant else None
        constant = self._constants[scalar]
        return evaluate(scalar, values) if constant is None else constant

    def _point(self, point: tuple[Scalar, Scalar, Scalar]) -> np.ndarray:
        return np.array([*(self._number(c, self._mechanism.values) for c in point), 1.0])

    def _span(
        self, force: LineLoad, H: list[np.ndarray], Hd: list[np.ndarray] | None, n: int
    ) -> Span:
        (a, p), (b, q) = ((end.body, self._point(end.point)) for end in force.ends)
        ahead = np.broadcast_to(self._locate(H, b, q) - self._locate(H, a, p), (n, 4))

        def parting() -> list[np.ndarray]:
            assert Hd is not None
            return list((self._rate(Hd, b, q) - self._rate(Hd, a, p)).T[:3])

        return Span(list(ahead.T[:3]), np.sqrt, parting)

    def _vector(
        self, components: tuple[Scalar, Scalar, Scalar], values: dict[str, Any], n: int
    ) -> np.ndarray:
        columns = [np.broadcast_to(evaluate(c, values), (n,)) for c in components]
        return np.stack([*columns, np.zeros(n)], axis=-1)

    def _locate(self, H: list[np.ndarray], body: str, point: np.ndarray) -> np.ndarray:
        """Return a body's point (p, 1) in the world; a point of the ground has no batch axis."""
        place = self._place[body]
        moved: np.ndarray = H[place] @ point if place >= 0 else point
        return moved

    def _rate(self, Hd: list[np.ndarray], body: str, point: np.ndarray) -> np.ndarray:
        place = self._place[body]
        rate: np.ndarray = Hd[place] @ point if place >= 0 else np.zeros(4)
        return rate

    def _rotate(self, H: list[np.ndarray], axes: str, components: np.ndarray) -> np.ndarray:
        """Turn components (F, 0) into world axes."""
        place = -1 if axes == "world" else self._place[axes]
        turned: np.ndarray = (
            (H[place] @ components[..., None])[..., 0] if place >= 0 else components
        )
        return turned
