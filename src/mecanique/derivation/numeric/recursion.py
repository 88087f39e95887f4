"""Compute the equations of motion on batched floats by an O(n) recursion along the tree.

The kinetic energy is ½ Σ tr(Ḣ J Ḣᵀ) with poses H and mass moments J. Lagrange's equations then
read τ_k = Σ tr(∂H/∂q_k J Ḧᵀ); the sums over all bodies beyond a joint are collected from the tips
to the ground (J. M. Hollerbach, IEEE Trans. Systems, Man, and Cybernetics 10 (1980) 730, here
extended to quasi-velocities).
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, NamedTuple, final

import numpy as np

from mecanique.derivation.numeric.chart import CoordinateMap, Motions
from mecanique.derivation.numeric.dynamics import BatchDynamics
from mecanique.derivation.numeric.loads import Loads
from mecanique.derivation.numeric.momenta import momenta
from mecanique.derivation.tree.links import Link, links, motions, moving, place_of
from mecanique.derivation.tree.poses import Arithmetic, local, moments, placement_matrix, stack
from mecanique.errors import DerivationError
from mecanique.model.mechanism import Mechanism
from mecanique.model.states import States


class _Form(NamedTuple):
    """The tree of a mechanism: its links, their motions S and their first velocity columns."""

    tree: tuple[Link, ...]
    chart: CoordinateMap
    loads: Loads
    S: list[tuple[np.ndarray, ...]]
    first: list[int]
    armature: np.ndarray

    @classmethod
    def of(cls, mechanism: Mechanism) -> _Form:
        """Return the tree of a mechanism."""
        tree = links(mechanism)
        S = [motions(link) for link in tree]
        columns = np.cumsum([0, *map(len, S)])
        first = columns[:-1].tolist()
        armature = np.zeros(columns[-1])
        for column, link in zip(first, tree, strict=True):
            last = column + len(link.velocities)
            armature[column:last] = mechanism.evaluate(link.armature)
        return cls(
            tree=tree,
            chart=CoordinateMap(mechanism, tree),
            loads=Loads(mechanism, tree),
            S=S,
            first=first,
            armature=armature,
        )


class _Numbers(NamedTuple):
    """The numbers of a tree: poses of the links' frames, mass moments J and gravity.

    Matrices have shape (4, 4) or (n, 4, 4). The axes of some joints, by index, are turned in the
    joint's frame.
    """

    origins: list[np.ndarray]
    J: list[np.ndarray]
    gravity: np.ndarray
    turns: Mapping[int, np.ndarray]

    @classmethod
    def of(cls, mechanism: Mechanism, tree: tuple[Link, ...]) -> _Numbers:
        """Return the numbers of a mechanism."""
        constants, places = mechanism.values, place_of(tree, mechanism)
        J: list[np.ndarray] = [np.zeros((4, 4)) for _ in tree]
        for body in mechanism.bodies:
            place = places[body.name]
            if place >= 0:
                J[place] = np.array(moments(body, constants, Arithmetic()), dtype=float)
        origins = [placement_matrix(link.origin, constants) for link in tree]
        return cls(origins, J, _fall(np.array(mechanism.evaluate_all(mechanism.gravity))), {})


def _fall(gravity: np.ndarray) -> np.ndarray:
    """The second derivative of a freely falling pose, shape (4, 4) or (n, 4, 4)."""
    rate = np.zeros((*gravity.shape[:-1], 4, 4))
    rate[..., :3, 3] = gravity
    return rate


@final
class Recursion(BatchDynamics):
    """Mass matrix, bias, forces, accelerations and energies, for many states at once."""

    def __init__(
        self, mechanism: Mechanism, form: _Form | None = None, numbers: _Numbers | None = None
    ) -> None:
        self._mechanism = mechanism
        self._form = form or _Form.of(mechanism)
        self._tree, self._chart, self._loads, self._S, self._first, self._armature = self._form
        numbers = numbers or _Numbers.of(mechanism, self._tree)
        self._origin, self._J, self._gravity, self._turns = numbers
        if self._turns:
            self._S = list(self._S)
        for k, Q in self._turns.items():
            self._S[k] = tuple(Q @ S @ np.swapaxes(Q, -1, -2) for S in self._S[k])

    def mass_matrix(self, states: States) -> np.ndarray:
        """Return M, shape (n, nv, nv)."""
        move = self._chart.motions(states)
        A = self._local(move, len(states))
        return move.projected_matrix(self._joint_mass_matrix(A, len(states)))

    def bias(self, states: States) -> np.ndarray:
        """Return Coriolis, centrifugal and rheonomic inertia terms and gravity, shape (n, nv)."""
        move = self._chart.motions(states)
        A = self._local(move, len(states))
        return move.project(self._inverse_dynamics(A, move.u, move.gamma))

    def forces(self, states: States) -> np.ndarray:
        """Return the generalized forces of springs, dampers, drives and loads, shape (n, nv)."""
        move = self._chart.motions(states)
        A = self._local(move, len(states))
        H, Hd = self._poses(A, move.u)
        D = self._loads.on_bodies(H, Hd, states.values, len(states))
        tau = self._collect(A, H, [D.get(place, 0.0) for place in range(len(H))], len(states))
        return move.project(tau + self._loads.on_joints(move, states))

    def inverse_dynamics(self, states: States, a: np.ndarray) -> np.ndarray:
        """Return M a + bias, shape (n, nv)."""
        move = self._chart.motions(states)
        A = self._local(move, len(states))
        return move.project(self._inverse_dynamics(A, move.u, move.gamma + move.spread(a)))

    def gravity(self, states: States) -> np.ndarray:
        """Return gravity's part of the bias, shape (n, nv)."""
        move = self._chart.motions(states)
        A = self._local(move, len(states))
        H, _ = self._poses(A, np.zeros_like(move.u))
        D = [np.broadcast_to(-J @ self._gravity.T, (len(states), 4, 4)) for J in self._J]
        return move.project(self._collect(A, H, D, len(states)))

    def momentum(self, states: States) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Return the momenta, linear, angular about the origin and about the center of mass."""
        move = self._chart.motions(states)
        free = np.flatnonzero(moving(self._tree))
        H, Hd = self._poses(self._local(move, len(states)), move.u)
        return momenta(
            [H[k] for k in free], [Hd[k] for k in free], [self._J[k] for k in free], len(states)
        )

    @property
    def tree(self) -> tuple[Link, ...]:
        """The elementary links, in the order in which `vary` and `regressor` count them."""
        return self._tree

    @property
    def origins(self) -> tuple[np.ndarray, ...]:
        """The pose of each link's frame in its parent's, each shape (4, 4)."""
        return tuple(self._origin)

    @property
    def moments(self) -> tuple[np.ndarray, ...]:
        """Mass moments of each link, ∫ (p, 1)(p, 1)ᵀ dm, each shape (4, 4)."""
        return tuple(self._J)

    @property
    def turns(self) -> tuple[np.ndarray, ...]:
        """The rotation of each joint's axis in the joint's frame, each shape (4, 4)."""
        return tuple(self._turns.get(k, np.eye(4)) for k in range(len(self._tree)))

    def vary(
        self,
        origins: Mapping[int, np.ndarray] | None = None,
        moments: Mapping[int, np.ndarray] | None = None,
        gravity: np.ndarray | None = None,
        turns: Mapping[int, np.ndarray] | None = None,
    ) -> Recursion:
        """Return a copy with other numbers, which may differ from state to state.

        The energies of a copy are not defined.

        Shapes: origins (4, 4) or (n, 4, 4), moments (4, 4) or (n, 4, 4), gravity (3,) or (n, 3),
        turns (4, 4) or (n, 4, 4).
        """
        numbers = _Numbers(
            [(origins or {}).get(k, X) for k, X in enumerate(self._origin)],
            [(moments or {}).get(k, J) for k, J in enumerate(self._J)],
            self._gravity if gravity is None else _fall(gravity),
            {**self._turns, **(turns or {})},
        )
        return Recursion(self._mechanism, self._form, numbers)

    def regressor(self, states: States, a: np.ndarray) -> np.ndarray:
        """Return the regressor Y with M a + bias = Σ Y J, J the mass moments of each link.

        The equations of motion are linear in J (C. G. Atkeson, C. H. An & J. M. Hollerbach, Int.
        J. Robotics Research 5 (1986) 101). The rotors' inertia is left out.

        Shape (n, nv, links, 4, 4).
        Shapes: a (n, nv).
        """
        move, n = self._chart.motions(states), len(states)
        A = self._local(move, n)
        H, Hdd = self._accelerate(A, move.u, move.gamma + move.spread(a))
        Y = np.zeros((n, len(self._armature), len(self._tree), 4, 4))
        for k in range(len(self._tree)):
            at, X = k, np.broadcast_to(np.eye(4), (n, 4, 4))
            while at >= 0:
                for j, S in enumerate(self._S[at]):
                    Y[:, self._first[at] + j, k] = np.swapaxes(H[at] @ S @ X, -1, -2) @ Hdd[k]
                X = A[at] @ X
                at = self._tree[at].parent
        if move.G is not None:
            return np.asarray(np.einsum("nukab,nuv->nvkab", Y, move.G))
        out = np.empty_like(Y)
        out[:, move.order] = Y
        return out

    def acceleration(self, states: States) -> np.ndarray:
        """Return a from M a + bias = forces, shape (n, nv)."""
        return solve(
            self._mechanism, self.mass_matrix(states), self.forces(states) - self.bias(states)
        )

    def energy(self, states: States) -> tuple[np.ndarray, np.ndarray]:
        """Return the kinetic energy T and the potential energy V, each shape (n,) [J]."""
        move = self._chart.motions(states)
        H, Hd = self._poses(self._local(move, len(states)), move.u)
        T = 0.5 * np.sum(self._armature * move.u**2, axis=-1)
        V = self._loads.energy(H, move.r, len(states))
        g = self._gravity[:3, 3]
        for pose, rate, J in zip(H, Hd, self._J, strict=True):
            T = T + 0.5 * np.sum((rate @ J) * rate, axis=(-2, -1))
            mass_moment = (pose @ J)[:, :3, 3]
            V = V - mass_moment @ g
        return T, V

    def poses(self, states: States) -> list[np.ndarray]:
        """Return the pose of every link, in the order of the tree, each shape (n, 4, 4)."""
        move = self._chart.motions(states)
        return self._poses(self._local(move, len(states)), move.u)[0]

    def _local(self, move: Motions, n: int) -> list[np.ndarray]:
        """Return the pose of each link in its parent link."""
        floats = Arithmetic()
        moved = [stack(local(link, move.r, floats), n) for link in self._tree]
        for k, Q in self._turns.items():
            moved[k] = Q @ moved[k] @ np.swapaxes(Q, -1, -2)
        return [X @ motion for X, motion in zip(self._origin, moved, strict=True)]

    def _twist(self, place: int, rates: np.ndarray) -> np.ndarray:
        """Return the twist Σ S u of one link, shape (n, 4, 4)."""
        first, total = self._first[place], np.zeros((len(rates), 4, 4))
        for k, S in enumerate(self._S[place]):
            total += rates[:, first + k, None, None] * S
        return total

    def _poses(
        self, A: list[np.ndarray], u: np.ndarray
    ) -> tuple[list[np.ndarray], list[np.ndarray]]:
        H: list[np.ndarray] = []
        Hd: list[np.ndarray] = []
        for place, link in enumerate(self._tree):
            twist = self._twist(place, u)
            if link.parent < 0:
                H.append(A[place])
                Hd.append(A[place] @ twist)
            else:
                H.append(H[link.parent] @ A[place])
                Hd.append(Hd[link.parent] @ A[place] + H[place] @ twist)
        return H, Hd

    def _inverse_dynamics(self, A: list[np.ndarray], u: np.ndarray, ud: np.ndarray) -> np.ndarray:
        """Return M u̇ + bias in the joint velocities, shape (n, nu)."""
        H, Hdd = self._accelerate(A, u, ud)
        D = [J @ np.swapaxes(rate, -1, -2) for J, rate in zip(self._J, Hdd, strict=True)]
        bodies = self._collect(A, H, D, len(u))
        return np.asarray(bodies + self._armature * ud)

    def _accelerate(
        self, A: list[np.ndarray], u: np.ndarray, ud: np.ndarray
    ) -> tuple[list[np.ndarray], list[np.ndarray]]:
        """Return the poses and their second time derivatives; gravity accelerates the ground."""
        H: list[np.ndarray] = []
        Hd: list[np.ndarray] = []
        Hdd: list[np.ndarray] = []
        ground = np.eye(4), np.zeros((4, 4)), -self._gravity
        for place, link in enumerate(self._tree):
            p = link.parent
            base = (H[p], Hd[p], Hdd[p]) if p >= 0 else ground
            V = self._twist(place, u)
            W = V @ V + self._twist(place, ud)
            B, Bd, Bdd = (pose @ A[place] for pose in base)
            H.append(B)
            Hd.append(Bd + B @ V)
            Hdd.append(Bdd + 2 * Bd @ V + B @ W)
        return H, Hdd

    def _collect(
        self, A: list[np.ndarray], H: list[np.ndarray], D: list[Any], n: int
    ) -> np.ndarray:
        """Return τ_k = Σ tr(H S_k D), summed over the bodies that u_k moves, shape (n, nu)."""
        D = list(D)
        tau = np.zeros((n, len(self._armature)))
        for place in range(len(self._tree) - 1, -1, -1):
            if not np.ndim(D[place]):  # 0.0: nothing acts on this link or beyond
                continue
            across = np.swapaxes(D[place] @ H[place], -1, -2)
            for k, S in enumerate(self._S[place]):
                tau[:, self._first[place] + k] = np.sum(S * across, axis=(-2, -1))
            parent = self._tree[place].parent
            if parent >= 0:
                D[parent] = D[parent] + A[place] @ D[place]
        return tau

    def _joint_mass_matrix(self, A: list[np.ndarray], n: int) -> np.ndarray:
        """Return M in the joint velocities from the moments beyond each joint, (n, nu, nu)."""
        M = np.zeros((n, len(self._armature), len(self._armature)))
        C: list[np.ndarray] = [np.broadcast_to(J, (n, 4, 4)) for J in self._J]
        # contributions of the velocities beyond each link, passed together from link to link
        beyond: list[list[tuple[np.ndarray, np.ndarray]]] = [[] for _ in self._tree]
        for place in range(len(self._tree) - 1, -1, -1):
            if self._S[place]:
                own = np.stack([S @ C[place] for S in self._S[place]], axis=1)
                beyond[place].append((own, self._first[place] + np.arange(own.shape[1])))
            parts, beyond[place] = beyond[place], []
            if not parts:
                F, rows = np.zeros((n, 0, 4, 4)), np.zeros(0, dtype=int)
            elif len(parts) == 1:
                F, rows = parts[0]
            else:
                several, places = zip(*parts, strict=True)
                F = np.concatenate(several, axis=1)
                rows = np.concatenate(places)
            for k, S in enumerate(self._S[place]):
                column = F.reshape(n, -1, 16) @ S.reshape(-1, 16, 1)
                M[:, rows, self._first[place] + k] = column[..., 0]
            parent = self._tree[place].parent
            if parent >= 0:
                X = A[place]
                back = np.swapaxes(X, -1, -2)
                C[parent] = C[parent] + X @ C[place] @ back
                beyond[parent].append((X[:, None] @ F @ back[:, None], rows))
        lower = np.tril(M)
        M = lower + np.swapaxes(np.tril(M, -1), -1, -2)
        M += np.diag(self._armature)
        return M


def solve(mechanism: Mechanism, M: np.ndarray, rest: np.ndarray) -> np.ndarray:
    """Solve M a = rest for a, shape (n, nv); M (n, nv, nv), rest (n, nv)."""
    try:
        return np.linalg.solve(M, rest[..., None])[..., 0]
    except np.linalg.LinAlgError:
        raise DerivationError(
            f"mechanism {mechanism.name!r}: its mass matrix is singular, as some motion has no "
            "inertia; give what it moves mass or inertia, or leave that coordinate out"
        ) from None
