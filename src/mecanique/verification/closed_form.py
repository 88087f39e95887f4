"""The closed form of a derivation, as numbers: what is printed is what is compared."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, final

import numpy as np
import numpy.typing as npt

from mecanique.derivation.scalars.evaluation import Evaluation
from mecanique.derivation.scalars.series import Series
from mecanique.derivation.symbolic.derivation import Derivation, Left
from mecanique.model.mechanism import Mechanism
from mecanique.model.states import Given, States
from mecanique.model.units import characteristic_length
from mecanique.verification.states.random import angles

__all__ = ["ClosedForm"]

Array = npt.NDArray[np.float64]

_RANK = 1e-12
"""Singular values below this part of the largest count as zero."""


@final
class ClosedForm:
    """The series of a symbolic derivation, evaluated at n states at once.

    Args:
        mechanism: what was derived.
        derivation: its closed form.
    """

    def __init__(self, mechanism: Mechanism, derivation: Derivation) -> None:
        self._mechanism = mechanism
        self._derivation = derivation
        stated = [r for stage in derivation.stages for r in stage.results]
        self._energies = [
            next((r.right for r in stated if r.left == Left(letter)), None) for letter in "TV"
        ]

    def mass_matrix(self, q: Given, t: Any = 0.0) -> Array:
        """Return M, shape (n, nv, nv).

        Args:
            q: shape (n, nq).
            t: shape () or (n,) [s].
        """
        size = self._mechanism.nv
        entries = self._evaluated([m for row in self._derivation.M for m in row], q, None, t)
        return entries.reshape(len(entries), size, size)

    def bias(self, q: Given, v: Given, t: Any = 0.0) -> Array:
        """Return h, shape (n, nv).

        Args:
            q: shape (n, nq).
            v: shape (n, nv).
            t: shape () or (n,) [s].
        """
        return self._evaluated(self._derivation.h, q, v, t)

    def forces(self, q: Given, v: Given, t: Any = 0.0) -> Array:
        """Return Q, shape (n, nv).

        Args:
            q: shape (n, nq).
            v: shape (n, nv).
            t: shape () or (n,) [s].
        """
        return self._evaluated(self._derivation.Q, q, v, t)

    def acceleration(self, q: Given, v: Given, t: Any = 0.0) -> Array:
        """Return the solution a of M a + h = Q + Σ λ ∂Φ/∂q and Φ'' = 0, shape (n, nv).

        It is not a number where there is none.

        Args:
            q: shape (n, nq).
            v: shape (n, nv).
            t: shape () or (n,) [s].
        """
        mass, rest = self.mass_matrix(q, t), self.forces(q, v, t) - self.bias(q, v, t)
        if self._derivation.ties:
            return self._held(mass, rest, q, v, t)
        try:
            return np.asarray(np.linalg.solve(mass, rest[..., None])[..., 0])
        except np.linalg.LinAlgError:
            return np.full(rest.shape, np.nan)

    def _held(self, mass: Array, rest: Array, q: Given, v: Given, t: Any) -> Array:
        """Return the accelerations that the loops leave, by the least multipliers."""
        algebra, ties = self._derivation.algebra, self._derivation.ties
        # Φ'' = J a + γ
        second = [tie.demand.ddt().ddt().linear(algebra.accelerations) for tie in ties]
        J = self._evaluated([entry for row, _ in second for entry in row], q, v, t)
        gamma = self._evaluated([gamma for _, gamma in second], q, v, t)
        # one unit for all, so that ranks are seen: accelerations per length, multipliers by what
        # their rows move
        angular, length = angles(self._mechanism), characteristic_length(self._mechanism)
        units = np.array(
            [1.0 if name in angular else length for name in self._mechanism.velocities]
        )
        J = J.reshape(*gamma.shape, mass.shape[-1]) * units
        rows = 1 / np.maximum(np.abs(J).max(axis=2), 1e-300)
        J, M = J * rows[..., None], mass * units[:, None] * units
        size = np.maximum(np.abs(M).max(axis=(1, 2)), 1e-300)[:, None, None]
        empty = np.zeros((*gamma.shape, len(ties)))
        both = np.concatenate(
            [
                np.concatenate([M / size, -np.swapaxes(J, 1, 2)], axis=2),
                np.concatenate([J, empty], axis=2),
            ],
            axis=1,
        )
        right = np.concatenate([rest * units / size[:, 0], -gamma * rows], axis=1)[..., None]
        solution = (np.linalg.pinv(both, rcond=_RANK) @ right)[:, : len(units), 0]
        return np.asarray(solution * units)

    def energy(self, q: Given, v: Given, t: Any = 0.0) -> tuple[Array, Array]:
        """Return the kinetic and the potential energy that the steps state, each shape (n,) [J].

        Args:
            q: shape (n, nq).
            v: shape (n, nv).
            t: shape () or (n,) [s].
        """
        zero = self._derivation.algebra.ring.number(0)
        T, V = self._evaluated(
            [zero if series is None else series for series in self._energies], q, v, t
        ).T
        return T, V

    def _evaluated(self, series: Sequence[Series], q: Given, v: Given, t: Any) -> Array:
        states = States.of(self._mechanism, q, v, t)
        with np.errstate(all="ignore"):
            value = Evaluation(self._derivation.algebra.ring, states.values)
            columns = [np.broadcast_to(value(one), (len(states),)) for one in series]
        return np.stack(columns, axis=-1).astype(float) if columns else np.zeros((len(states), 0))
