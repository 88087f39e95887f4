"""Map generalized to joint coordinates: r = φ(q, t), u = G v + φ_t, u̇ = G a + γ."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, final

import numpy as np

from mecanique.derivation.tree.links import Link
from mecanique.errors import InputError
from mecanique.model.mechanism import Mechanism
from mecanique.model.states import States


@final
@dataclass(frozen=True)
class Motions:
    """Joint coordinates and joint velocities in n states."""

    r: dict[str, Any]  # values of each joint coordinate by name, shape (n,)
    u: np.ndarray  # shape (n, nu), joint velocities in the order of the tree
    gamma: np.ndarray  # shape (n, nu), their rates at constant generalized velocities
    # shape (nu,), the index of the generalized velocity that equals each joint velocity; −1 for a
    # driven joint
    order: np.ndarray
    G: np.ndarray | None  # shape (n, nu, nv), ∂u/∂v; None without driven joints

    def spread(self, a: np.ndarray) -> np.ndarray:
        """Return G a, shape (n, nu); a (n, nv)."""
        return np.asarray(a[:, self.order] if self.G is None else (self.G @ a[..., None])[..., 0])

    def project(self, tau: np.ndarray) -> np.ndarray:
        """Return Gᵀ τ, shape (n, nv); tau (n, nu)."""
        if self.G is not None:
            return np.asarray((tau[:, None, :] @ self.G)[:, 0])
        out = np.empty_like(tau)
        out[:, self.order] = tau
        return out

    def projected_matrix(self, M: np.ndarray) -> np.ndarray:
        """Return Gᵀ M G, shape (n, nv, nv); M (n, nu, nu)."""
        if self.G is not None:
            return np.asarray(np.swapaxes(self.G, -1, -2) @ M @ self.G)
        out = np.empty_like(M)
        out[:, self.order[:, None], self.order[None, :]] = M
        return out


def efforts_in_joints(
    states: States, move: Motions, columns: Mapping[str, int]
) -> np.ndarray | None:
    """Return the torques given with the states as forces in the joints; None without any.

    Shape (n, nu); generalized forces become the least torques that do the same virtual work.
    """
    efforts = states.efforts
    if efforts is None:
        return None
    tau = np.zeros_like(move.u)
    for name, column in efforts.in_joints.items():
        tau[:, columns[name]] = column
    if efforts.generalized is not None and move.G is not None:
        inverse = np.linalg.pinv(np.swapaxes(move.G, 1, 2))
        tau += (inverse @ efforts.generalized[..., None])[..., 0]
    return tau


@final
class CoordinateMap:
    """The coordinate map of a mechanism."""

    def __init__(self, mechanism: Mechanism, tree: tuple[Link, ...]) -> None:
        self._mechanism = mechanism
        self._coordinates = [name for link in tree for name in link.coordinates]
        self._velocities = [name for link in tree for name in link.velocities]
        place = {name: k for k, name in enumerate(mechanism.velocities)}
        driven = {f"{name}'": name for name in mechanism.coordinates.driven}
        self._order = np.array(
            [-1 if u in driven else place[u] for u in self._velocities], dtype=int
        )
        self._driven = {k: driven[u] for k, u in enumerate(self._velocities) if u in driven}

    def motions(self, states: States) -> Motions:
        """Evaluate joint coordinates, joint velocities and their rates at constant v."""
        n = len(states)
        values = states.values
        if not self._driven and len(self._order) == self._mechanism.nv:
            r = {name: values[name] for name in self._coordinates}
            u = states.v[:, self._order]
            return Motions(r, u, np.zeros_like(u), self._order, None)
        from mecanique.derivation.numeric.paths import driven_paths

        r = {name: values[name] for name in self._coordinates if name in values}
        u, gamma = np.zeros((n, len(self._order))), np.zeros((n, len(self._order)))
        G = np.zeros((n, len(self._order), self._mechanism.nv))
        free = np.flatnonzero(self._order >= 0)
        u[:, free] = states.v[:, self._order[free]]
        G[:, free, self._order[free]] = 1.0
        with np.errstate(invalid="ignore", divide="ignore"):
            paths = driven_paths(states)
        for k, name in self._driven.items():
            c = paths[name]
            bad = ~np.isfinite(c).all(axis=(0, 1))
            if bad.any():
                at = ", ".join(
                    f"{q} = {x:g}"
                    for q, x in zip(self._mechanism.coordinates, states.q[bad][0], strict=True)
                )
                raise InputError(
                    f"the coordinate map of mechanism {self._mechanism.name!r} gives no smooth "
                    f"{name!r} at {at}; expected coordinates inside its range"
                )
            r[name] = c[0, 0]
            u[:, k] = c[1, 0]
            gamma[:, k] = 2 * c[2, 0]
            G[:, k] = c[0, 1:].T
        return Motions(r, u, gamma, self._order, G)
