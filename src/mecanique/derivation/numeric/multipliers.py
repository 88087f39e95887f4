"""Lagrange's equations of the first kind: M a + bias − Q = Jᵀ λ together with J a + γ = 0.

Both are solved at once, in the least-squares sense where constraints are redundant: a is unique as
long as every motion that the loops leave free has inertia, λ is the least one (Lagrange, Mécanique
analytique, 1788, part II, sect. IV; F. E. Udwadia & R. E. Kalaba, Analytical Dynamics, 1996, ch.
3).
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import final

import numpy as np

from mecanique.derivation.numeric.dynamics import BatchDynamics
from mecanique.derivation.numeric.lagrange import Definition
from mecanique.derivation.numeric.loops import Closure, Constraints, constraints_of
from mecanique.errors import DerivationError
from mecanique.model.mechanism import Mechanism
from mecanique.model.states import States
from mecanique.model.units import velocity_scales

__all__ = ["Constrained", "ConstrainedMotion", "constraints"]

_RANK = 1e-9
"""Singular values below this part of the largest count as zero."""


@final
@dataclass(frozen=True)
class ConstrainedMotion:
    """What loops make of a tree's motion at n states.

    Args:
        acceleration: shape (n, nv).
        multipliers: λ of each row, shape (n, m); the generalized force of the loops is Jᵀ λ.
        determined: shape (n, m), False where redundant constraints leave a multiplier undetermined.
    """

    acceleration: np.ndarray
    multipliers: np.ndarray
    determined: np.ndarray


def constraints(mechanism: Mechanism, states: States) -> Constraints:
    """Return Φ, J and γ of a mechanism's loops.

    Args:
        mechanism: whose loops they are.
        states: where, how fast and when.
    """
    _, poses = Definition(mechanism).motion(states, np.zeros_like(states.v))
    return constraints_of(Closure(mechanism).rows(poses))


@final
class Constrained:
    """The motion of a tree that loops hold together.

    Args:
        mechanism: a mechanism with loops.
        tree: gives M, bias and forces of its tree.
    """

    def __init__(self, mechanism: Mechanism, tree: BatchDynamics) -> None:
        self._mechanism = mechanism
        self._tree = tree
        self._closure = Closure(mechanism)
        self._definition = Definition(mechanism)
        self._units = velocity_scales(mechanism)

    @property
    def names(self) -> tuple[str, ...]:
        """Name of each row of the constraints."""
        return self._closure.names

    def motion(self, states: States) -> ConstrainedMotion:
        """Return accelerations and multipliers.

        Args:
            states: where, how fast and when; the loops closed.

        Raises:
            DerivationError: if a motion that the loops leave free meets no inertia.
        """
        _, poses = self._definition.motion(states, np.zeros_like(states.v))
        closed = constraints_of(self._closure.rows(poses))
        M, rest = (
            self._tree.mass_matrix(states),
            self._tree.forces(states) - self._tree.bias(states),
        )
        nv, m = M.shape[-1], closed.gamma.shape[-1]
        units, rows = self._units, 1 / self._closure.units
        a, multipliers = np.zeros((len(states), nv)), np.zeros((len(states), m))
        determined = np.ones((len(states), m), dtype=bool)
        for k in range(len(states)):
            inertia = units[:, None] * M[k] * units
            size = float(np.abs(inertia).max(initial=0.0)) or 1.0
            J = rows[:, None] * closed.jacobian[k] * units
            both = np.block([[inertia / size, -J.T], [J, np.zeros((m, m))]])
            right = np.concatenate([units * rest[k] / size, -rows * closed.gamma[k]])
            left, values, turned = np.linalg.svd(both)
            rank = int((values > _RANK * values[0]).sum())
            loose = turned[rank:]
            if np.abs(loose[:, :nv]).max(initial=0.0) > 1e-6:
                raise self._massless(loose[int(np.abs(loose[:, :nv]).max(axis=1).argmax()), :nv])
            solution = turned[:rank].T @ ((left[:, :rank].T @ right) / values[:rank])
            a[k], multipliers[k] = units * solution[:nv], size * rows * solution[nv:]
            determined[k] = np.abs(loose[:, nv:]).max(axis=0, initial=0.0) < 1e-8
        return ConstrainedMotion(a, multipliers, determined)

    def _massless(self, mode: np.ndarray) -> DerivationError:
        names = [
            name
            for name, part in zip(self._mechanism.velocities, mode, strict=True)
            if abs(part) > 0.1
        ]
        return DerivationError(
            f"mechanism {self._mechanism.name!r}: its loops leave a motion of "
            f"{', '.join(names) or 'several joints'} free that meets no "
            "inertia; give a body in it mass"
        )
