"""Map generalized to joint coordinates: r = φ(q, t), u = G v + φ_t, u̇ = G a + γ."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, final

import numpy as np

from mecanique.derivation.mechanics.letters import LetterValues
from mecanique.derivation.mechanics.vectors import (
    Rows,
    Triple,
    add,
    apply,
    as_rows,
    products,
    take,
    transpose,
)
from mecanique.derivation.tree.links import Link
from mecanique.model.mechanism import Mechanism


@final
@dataclass(frozen=True)
class JointMotion:
    """The motion of a tree's joints, on a tape or, with the states last, on arrays."""

    r: dict[str, Any]  # value of each joint coordinate and of every input, by name
    u: Triple  # joint velocities, in the order of the tree
    gamma: list[Any]  # their rates at constant generalized velocities
    G: Rows  # rows of ∂u/∂v
    # the generalized velocity that each joint velocity is, and the reverse; None where some joints
    # are driven. All else is then G times this or that
    order: Any = None
    places: Any = None

    def spread(self, a: Triple) -> Triple:
        """Return G a + γ."""
        return take(a, self.order) if self.order is not None else add(apply(self.G, a), self.gamma)

    def project(self, tau: Triple) -> Triple:
        """Return Gᵀ τ."""
        if self.places is not None:
            return take(tau, self.places)
        if isinstance(self.G, np.ndarray):
            tau = as_rows(tau)
        return apply(transpose(self.G), tau)

    def project_matrix(self, M: Rows) -> Rows:
        """Return Gᵀ M G."""
        if self.places is not None:
            return transpose(take(transpose(take(M, self.places)), self.places))
        columns = transpose(self.G)
        return products(columns, products(columns, M))


@final
class CoordinateMap:
    """The coordinate map of a mechanism, on a tree of elementary links."""

    def __init__(self, mechanism: Mechanism, tree: Sequence[Link]) -> None:
        velocities, nv = mechanism.velocities, mechanism.nv
        driven = {f"{name}'": name for name in mechanism.coordinates.driven}
        self._names = [name for link in tree for name in link.velocities]
        self._driven = [driven.get(name) for name in self._names]
        self._plain: list[list[float]] = []
        """Rows of G of the joint velocities that are generalized ones; zeros of the others."""
        for name in self._names:
            self._plain.append([float(name == velocity) for velocity in velocities])
        self._order: Any = None
        self._places: Any = None
        if not any(self._driven) and len(self._names) == nv:
            self._order = np.array([velocities.index(name) for name in self._names], dtype=int)
            self._places = np.argsort(self._order)
            if (self._order == np.arange(nv)).all():
                self._order = self._places = slice(None)

    def at(self, letters: LetterValues) -> JointMotion:
        """Compute the motion of the joints."""
        if self._order is not None:
            u = letters.vector([letters.values[name] for name in self._names])
            still = [0.0] * len(u)
            return JointMotion(letters.values, u, still, self._plain, self._order, self._places)
        paths = letters.driven_paths()
        r = letters.values | {name: path.r for name, path in paths.items()}
        u, gamma, rows = [], [], []
        for name, driver, row in zip(self._names, self._driven, self._plain, strict=True):
            path = paths.get(driver) if driver else None
            u.append(path.rate if path else letters.values[name])
            gamma.append(path.second if path else 0.0)
            rows.append(letters.vector(path.slopes if path else row))
        return JointMotion(r, letters.vector(u), gamma, letters.vector(rows))
