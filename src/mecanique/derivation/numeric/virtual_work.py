"""Apply the principle of virtual work with d'Alembert's inertia forces, on batched floats.

Each center of mass has the virtual displacement δr_C = J δq, each body the virtual rotation
δφ = J_φ δq. The virtual work of all forces, inertia forces included, vanishes for every δq
(Fundamentals of Dynamics, eqs. 1.22, 1.27):

    Σ (F + m g − m a_C)·δr_C + (M_C − d/dt H_C)·δφ = 0.

Reactions of ideal joints do no virtual work in total and need not be computed. Nor need the forces
of contacts and velocity constraints A δq = 0: δq = S δπ with independent quasi-coordinates π, whose
rates u are the independent velocities, v = S u + …, and A S = 0 (G. A. Maggi, Principii della
teoria matematica del movimento, 1896; Kane & Levinson, Dynamics, 1985, sect. 4.11, 6.1):

    Sᵀ (M a + bias − forces) = 0.
"""

from __future__ import annotations

from typing import final

import numpy as np

from mecanique.arrays import rank_of
from mecanique.derivation.numeric.dynamics import solve
from mecanique.derivation.numeric.free_bodies import Snapshot
from mecanique.derivation.numeric.newton_euler import FreeBodyDynamics
from mecanique.derivation.tolerances import RANK
from mecanique.model.states import States


@final
class NumericVirtualWork(FreeBodyDynamics):
    """The equations of motion in numbers, by the virtual work of applied and inertia forces."""

    def project(self, at: Snapshot, wrenches: np.ndarray) -> np.ndarray:
        """Return the virtual work of wrenches on the bodies in each δq, shape (n, nv, k)."""
        return np.asarray((at.J.swapaxes(-1, -2) @ wrenches).sum(axis=1))

    def acceleration(self, states: States) -> np.ndarray:
        """Return the accelerations, shape (n, nv)."""
        M, rest = self.mass_matrix(states), self.forces(states) - self.bias(states)
        if not self._mechanism.rolls:
            return solve(self._mechanism, M, rest)
        held = self._held.at(states)
        return np.array(
            [
                self._accelerate(*state)
                for state in zip(M, rest, held.jacobian, held.gamma, strict=True)
            ]
        ).reshape(states.v.shape)

    def _accelerate(
        self, M: np.ndarray, rest: np.ndarray, J: np.ndarray, gamma: np.ndarray
    ) -> np.ndarray:
        """Return a = S u' + σ with J a + γ = 0 and Sᵀ (M a − rest) = 0, shape (nv,)."""
        length = np.linalg.norm(J, axis=1)
        # rows of nothing but rounding are zero by now
        size = np.where(length > 0, length, 1.0)
        left, values, right = np.linalg.svd(J / size[:, None])
        rank = rank_of(values, RANK)
        S = right[rank:].T
        sigma = -right[:rank].T @ ((left[:, :rank].T @ (gamma / size)) / values[:rank])
        inertia, force = S.T @ M @ S, S.T @ (rest - M @ sigma)
        u = solve(self._mechanism, inertia[None], force[None])[0]
        a: np.ndarray = S @ u + sigma
        return a
