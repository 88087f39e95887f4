"""Compute the equations of motion from the definition of Lagrange's operator, on jets.

Poses H(ε) follow a motion through the state; their dual parts are the variations δH. For
quasi-velocities a variation η(ε) turns a pose by δA = A S η. Then δT = A η + B η', and Lagrange's
operator E = B' − A follows from the coefficients [εᵏ] of δT,

    E = [ε¹] δT(η = ε) − 2 [ε⁰] δT(η = 1),

since η = ε gives A + B' and η = 1 gives A. No Hamel coefficients are needed (for variations on a
group see H. Poincaré, "Sur une forme nouvelle des équations de la mécanique", C. R. Acad. Sci. 132
(1901) 369). Springs enter by their energy, all other forces by their virtual work: the dual part of
the path along which they act.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from typing import Any, final

import numpy as np

from mecanique.derivation.laws import Law, Travel, laws_of
from mecanique.derivation.mechanics.forces import Span, as_place
from mecanique.derivation.numeric.dynamics import BatchDynamics
from mecanique.derivation.numeric.paths import JETS, constant_jet, delay, joint_paths, stack_jets
from mecanique.derivation.scalars.functions import function
from mecanique.derivation.scalars.jets import Jet
from mecanique.derivation.tree.links import Link, links, motions, moving, place_of
from mecanique.derivation.tree.poses import Arithmetic, local, moments, placement_matrix, stack
from mecanique.model.expression import Scalar, evaluate
from mecanique.model.force_base import BodyLoad, FieldLoad, JointLoad, LineLoad, WrenchOnBody
from mecanique.model.mechanism import Mechanism
from mecanique.model.states import States

_LARGE = 2.0**40
"""Size of the accelerations that give M; large, so that prescribed motions are lost in rounding."""


@final
class LagrangeOnJets(BatchDynamics):
    """Mass matrix, bias, forces, accelerations and energies by Lagrange's operator."""

    def __init__(self, mechanism: Mechanism) -> None:
        self._mechanism = mechanism
        self._tree = links(mechanism)
        self._place = place_of(self._tree, mechanism)
        self._link = {link.joint: link for link in self._tree}
        self._bodies = [
            (
                self._place[body.name],
                np.array(moments(body, mechanism.values, Arithmetic()), dtype=float),
            )
            for body in mechanism.bodies
            if body.shapes and self._place[body.name] >= 0
        ]
        self._gravity = np.array(mechanism.evaluate_all(mechanism.gravity))

    def mass_matrix(self, states: States) -> np.ndarray:
        """Return M: the change of Lagrange's operator for unit accelerations."""
        n, nv = len(states), self._mechanism.nv
        # M depends on neither v nor gravity; omitting them avoids rounding errors
        q, t = np.tile(states.q, (nv + 1, 1)), np.tile(states.t, nv + 1)
        rest = np.zeros((len(q), nv))
        many = States(self._mechanism, q, rest, t, rest)
        a = np.concatenate([np.zeros((1, nv)), _LARGE * np.eye(nv)]).repeat(n, axis=0)
        E = self._inertia(many, a).reshape(nv + 1, n, nv)
        return np.asarray(np.moveaxis(E[1:] - E[0], 0, -1)) / _LARGE

    def bias(self, states: States) -> np.ndarray:
        """Return Coriolis, centrifugal and rheonomic inertia terms and gravity, shape (n, nv)."""
        return self._operator(states, np.zeros_like(states.v))

    def forces(self, states: States) -> np.ndarray:
        """Return the generalized forces of springs, dampers, drives and loads, shape (n, nv)."""
        r, H = self.motion(states, np.zeros_like(states.v))
        Q = np.zeros((self._mechanism.nv, len(states)))
        for force in self._mechanism.forces:
            if isinstance(force, BodyLoad):
                Q = Q + self._work(force.wrench, H, states)
        for law, along in self._laws(r, H, states):
            if law.kind == "potential":
                Q = Q - law.scalar(along).c[0, 1:]
            else:
                x = along.x.c
                pull = law.pull(Travel(x[0, 0], x[1, 0], along.name, along.values))
                Q = Q - pull * x[0, 1:]
        return np.asarray(Q.T)

    def inverse_dynamics(self, states: States, a: np.ndarray) -> np.ndarray:
        """Return M a + bias: Lagrange's operator along a motion with these accelerations."""
        return self._operator(states, a)

    def gravity(self, states: States) -> np.ndarray:
        """Return ∂V/∂q of gravity, shape (n, nv)."""
        _, H = self.motion(states, np.zeros_like(states.v))
        return self.weigh(H, states.v.shape)

    def weigh(self, H: list[Jet], shape: tuple[int, ...]) -> np.ndarray:
        """Return ∂V/∂q of gravity at poses on jets, shape (n, directions)."""
        E = np.zeros(shape[::-1])
        for place, J in self._bodies:
            E = E - H[place].c[0, 1:, :, :3, :] @ J[:, 3] @ self._gravity
        return np.asarray(E.T)

    def momentum(self, states: States) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Return the momenta, linear, angular about the origin and about the center of mass."""
        # Ḣ J Hᵀ contains ∫ ẋ dm and ∫ ẋ xᵀ dm, whose skew part is the angular momentum ∫ x × ẋ dm
        # (Goldstein, Classical Mechanics, 1980, sect. 1-2)
        _, H = self.motion(states, np.zeros_like(states.v))
        free, mass = moving(self._tree), 0.0
        K, first = np.zeros((len(states), 4, 4)), np.zeros((len(states), 3))
        for place, J in self._bodies:
            if free[place]:
                pose, rate = H[place].c[0, 0], H[place].c[1, 0]
                K = K + (rate @ J) @ np.swapaxes(pose, -1, -2)
                first, mass = first + (pose @ J)[:, :3, 3], mass + J[3, 3]
        linear, skew = K[:, :3, 3], K - np.swapaxes(K, -1, -2)
        angular = np.stack([skew[:, 2, 1], skew[:, 0, 2], skew[:, 1, 0]], axis=-1)
        center = first / mass if mass else first
        return linear, angular, angular - np.cross(center, linear)

    def energy(self, states: States) -> tuple[np.ndarray, np.ndarray]:
        """Return the kinetic energy T and the potential energy V, each shape (n,) [J]."""
        r, H = self.motion(states, np.zeros_like(states.v))
        T, V = np.zeros(len(states)), np.zeros(len(states))
        for term in self._kinetic(r, H):
            T = T + term.c[0, 0]
        for law, along in self._laws(r, H, states):
            if law.kind == "potential":
                V = V + law.scalar(along).c[0, 0]
        for place, J in self._bodies:
            V = V - H[place].c[0, 0][:, :3, :] @ J[:, 3] @ self._gravity
        return T, V

    def _operator(self, states: States, a: np.ndarray) -> np.ndarray:
        """Lagrange's operator on T plus ∂V/∂q of gravity, shape (n, nv)."""
        both: np.ndarray = self._inertia(states, a) + self.gravity(states)
        return both

    def _inertia(self, states: States, a: np.ndarray) -> np.ndarray:
        """Lagrange's operator on T, shape (n, nv)."""
        r, H = self.motion(states, a)
        return self.operate(r, H, a.shape)

    def operate(self, r: dict[str, Any], H: list[Jet], shape: tuple[int, ...]) -> np.ndarray:
        """Return Lagrange's operator on T along a motion on jets, shape (n, directions)."""
        E = np.zeros(shape[::-1])
        for now, later in zip(self._kinetic(r, H), self._kinetic(r, H, delay), strict=True):
            E = E + later.c[1, 1:] - 2 * now.c[0, 1:]
        return np.asarray(E.T)

    def motion(self, states: States, a: np.ndarray) -> tuple[dict[str, Jet], list[Jet]]:
        """Return the jets of the joint coordinates by name, and of the poses along the tree."""
        # Shapes: a (n, nv)
        r = joint_paths(states, self._tree, a)
        shape = (3, 1 + self._mechanism.nv, len(states))
        H: list[Jet] = []
        for link in self._tree:
            X = placement_matrix(link.origin, self._mechanism.values)
            A = (
                self._free(link, states, a)
                if link.kind in ("ball", "free")
                else stack_jets(local(link, r, JETS), shape)
            )
            here = Jet(X @ A.c)
            H.append(H[link.parent] @ here if link.parent >= 0 else here)
        return r, H

    def _free(self, link: Link, states: States, a: np.ndarray) -> Jet:
        """The jet A (1 + V ε + ½ (V² + V') ε²) of a free joint's pose, with the variation A S η."""
        A = stack(local(link, states.values, Arithmetic()), len(states))
        at = [self._mechanism.velocities.index(name) for name in link.velocities]
        S = motions(link)
        V, Vd = (np.einsum("nk,kij->nij", rates[:, at], S) for rates in (states.v, a))
        c = np.zeros((3, 1 + self._mechanism.nv, len(states), 4, 4))
        c[0, 0], c[1, 0], c[2, 0] = A, A @ V, A @ (V @ V + Vd) / 2
        for k, matrix in zip(at, S, strict=True):
            c[:, 1 + k] = c[:, 0] @ matrix
        return Jet(c)

    def _kinetic(
        self, r: dict[str, Any], H: list[Jet], vary: Callable[[Jet], Jet] = lambda x: x
    ) -> Iterator[Jet]:
        """Yield ½ tr(Ḣ J Ḣᵀ) of each body and ½ I ṙ² of each rotor."""
        for place, J in self._bodies:
            rate = vary(H[place]).ddt()
            yield Jet(rate.c @ (0.5 * J)).trace_with(rate)
        for link in self._tree:
            inertia = self._mechanism.evaluate(link.armature)
            if inertia:
                spin = vary(r[link.coordinates[0]]).ddt()
                yield spin * spin * (0.5 * inertia)

    def _laws(
        self, r: dict[str, Jet], H: list[Jet], states: States
    ) -> Iterator[tuple[Law, Span | Travel]]:
        """Yield the laws of forces, each with the line, the coordinate or the place it acts by."""

        def number(scalar: Scalar, given: Mapping[str, Any] | None = None, /) -> Any:
            values = {**states.values, **given} if given else states.values
            return evaluate(scalar, values, function=function)

        for force in self._mechanism.forces:
            along: Span | Travel
            if isinstance(force, LineLoad):
                a, b = (self._locate(end.body, end.point, H) for end in force.ends)
                reach = b - a
                along = Span([reach[..., k, 0] for k in range(3)], Jet.sqrt)
            elif isinstance(force, JointLoad):
                name = self._link[force.joints[0]].coordinates[0]
                along = Travel(r[name], r[name].ddt(), name, r)
            elif isinstance(force, FieldLoad):
                at = self._locate(force.body, force.point, H)
                along = as_place([at[..., k, 0] for k in range(3)])
            else:
                continue
            for law in laws_of(force, number):
                yield law, along

    def _work(self, wrench: WrenchOnBody, H: list[Jet], states: States) -> np.ndarray:
        """The virtual work F·δr + C·δφ in each variation, shape (nv, n)."""
        Q = np.zeros((self._mechanism.nv, len(states)))
        place = self._place[wrench.body]
        if place < 0:
            return Q
        if wrench.force is not None:
            F = self._vector(wrench.force, wrench.axes, H, states)
            shift = self._locate(wrench.body, wrench.point, H).c[0, 1:, :, :3, 0]
            Q = Q + np.einsum("ni,kni->kn", F, shift)
        if wrench.torque is not None:
            C = self._vector(wrench.torque, wrench.axes, H, states)
            turn = H[place].c[0, :, :, :3, :3]
            spin = turn[1:] @ np.swapaxes(turn[0], -1, -2)
            about = np.stack([spin[..., 2, 1], spin[..., 0, 2], spin[..., 1, 0]], axis=-1)
            Q = Q + np.einsum("ni,kni->kn", C, about)
        return Q

    def _locate(self, body: str, point: tuple[Scalar, Scalar, Scalar], H: list[Jet]) -> Any:
        """The jet of a body's point in the world, coefficients of shape (…, n, 3, 1)."""
        column = np.array([[self._mechanism.evaluate(c)] for c in (*point, 1.0)])
        place = self._place[body]
        if place >= 0:
            return Jet((H[place].c @ column)[..., :3, :])
        return constant_jet(column[:3], (*H[0].c.shape[:3], 3, 1))

    def _vector(
        self, components: tuple[Scalar, Scalar, Scalar], axes: str, H: list[Jet], states: States
    ) -> np.ndarray:
        """Turn a vector's components into world axes, shape (n, 3)."""
        columns = [np.broadcast_to(evaluate(c, states.values), (len(states),)) for c in components]
        vectors = np.stack(columns, axis=-1)
        place = -1 if axes == "world" else self._place[axes]
        return (
            vectors if place < 0 else np.einsum("nij,nj->ni", H[place].c[0, 0][:, :3, :3], vectors)
        )
