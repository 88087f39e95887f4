"""The closed form of a derivation, as numbers: what is printed is what is compared."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, final

import numpy as np

from mecanique.arrays import Array
from mecanique.derivation.numeric.constraints.loops import RowUnits
from mecanique.derivation.numeric.constraints.multipliers import solve_held
from mecanique.derivation.scalars.evaluation import Evaluation
from mecanique.derivation.scalars.series import Series
from mecanique.derivation.symbolic.derivation import Derivation, Left
from mecanique.model.mechanism import Mechanism
from mecanique.model.random_positions import angles
from mecanique.model.states import States
from mecanique.model.units import characteristic_length
from mecanique.model.values import Given


@final
class ClosedForm:
    """The series of a symbolic derivation, evaluated at n states at once."""

    def __init__(self, mechanism: Mechanism, derivation: Derivation) -> None:
        self._mechanism = mechanism
        self._derivation = derivation
        stated = [r for stage in derivation.stages for r in stage.results]
        rights = {r.left: r.right for r in reversed(stated)}
        self._energies = [rights.get(Left(letter)) for letter in "TV"]

    def mass_matrix(self, q: Given, t: Any = 0.0) -> Array:
        """Return M, shape (n, nv, nv).

        Args:
            q: shape (n, nq).
            t: shape () or (n,) [s].
        """
        size = self._mechanism.nv
        entries = self._evaluate([m for row in self._derivation.M for m in row], q, None, t)
        return entries.reshape(len(entries), size, size)

    def bias(self, q: Given, v: Given, t: Any = 0.0) -> Array:
        """Return h, shape (n, nv).

        Args:
            q: shape (n, nq).
            v: shape (n, nv).
            t: shape () or (n,) [s].
        """
        return self._evaluate(self._derivation.h, q, v, t)

    def forces(self, q: Given, v: Given, t: Any = 0.0) -> Array:
        """Return Q, shape (n, nv).

        Args:
            q: shape (n, nq).
            v: shape (n, nv).
            t: shape () or (n,) [s].
        """
        return self._evaluate(self._derivation.Q, q, v, t)

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
            return self._hold(mass, rest, q, v, t)
        try:
            return np.asarray(np.linalg.solve(mass, rest[..., None])[..., 0])
        except np.linalg.LinAlgError:
            return np.full(rest.shape, np.nan)

    def _hold(self, mass: Array, rest: Array, q: Given, v: Given, t: Any) -> Array:
        """Return the accelerations that the loops leave, by the least multipliers."""
        algebra, ties = self._derivation.algebra, self._derivation.ties
        # Φ'' = J a + γ
        second = [tie.second.linear(algebra.accelerations) for tie in ties]
        J = self._evaluate([entry for row, _ in second for entry in row], q, v, t)
        gamma = self._evaluate([gamma for _, gamma in second], q, v, t)
        J = J.reshape(*gamma.shape, mass.shape[-1])
        angular, length = angles(self._mechanism), characteristic_length(self._mechanism)
        units = np.array(
            [1.0 if name in angular else length for name in self._mechanism.velocities]
        )
        if self._derivation.quasi:
            return self._reduce(mass, rest, J, gamma, units, q, t)
        rows = RowUnits(np.ones(len(ties)), np.arange(len(ties)))
        found = np.full(rest.shape, np.nan)
        known = np.isfinite(J).all(axis=(1, 2)) & np.isfinite(gamma).all(axis=1)
        for k in np.flatnonzero(known):
            motion = solve_held(mass[k], rest[k], J[k], gamma[k], units, rows)
            found[k] = motion.acceleration
        return found

    def _reduce(
        self,
        mass: Array,
        rest: Array,
        J: Array,
        gamma: Array,
        units: Array,
        q: Given,
        t: Any,
    ) -> Array:
        """Return the accelerations by the equations along independent displacements."""
        quasi = self._derivation.quasi
        S = self._evaluate([entry for column in quasi for entry in column], q, None, t)
        S = S.reshape(len(S), len(quasi), mass.shape[-1])
        rows = np.concatenate([S @ mass, J], axis=1)
        sides = np.concatenate([(S @ rest[..., None])[..., 0], -gamma], axis=1)
        found = []
        for matrix, side in zip(rows, sides, strict=True):
            columns = matrix * units
            sizes = np.abs(columns).max(axis=1, keepdims=True)
            sizes[sizes == 0] = 1.0
            rows_alike, sides_alike = columns / sizes, side / sizes[:, 0]
            y = np.linalg.lstsq(rows_alike, sides_alike, rcond=None)[0]
            # once more, for what is left: terms of very different sizes lose digits
            y += np.linalg.lstsq(rows_alike, sides_alike - rows_alike @ y, rcond=None)[0]
            found.append(units * y)
        return np.array(found)

    def energy(self, q: Given, v: Given, t: Any = 0.0) -> tuple[Array, ...]:
        """Return the kinetic and the potential energy, each shape (n,) [J]; none if not stated.

        Args:
            q: shape (n, nq).
            v: shape (n, nv).
            t: shape () or (n,) [s].
        """
        if self._energies[0] is None:
            return ()
        zero = self._derivation.algebra.ring.number(0)
        T, V = self._evaluate(
            [zero if series is None else series for series in self._energies], q, v, t
        ).T
        return T, V

    def _evaluate(self, series: Sequence[Series], q: Given, v: Given, t: Any) -> Array:
        states = States.of(self._mechanism, q, v, t)
        with np.errstate(all="ignore"):
            value = Evaluation(self._derivation.algebra.ring, states.values)
            columns = [np.broadcast_to(value(one), (len(states),)) for one in series]
        return np.stack(columns, axis=-1).astype(float) if columns else np.zeros((len(states), 0))
