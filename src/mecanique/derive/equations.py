"""Equations of motion as a result: M(q, t) a + bias(q, v, t) = forces(q, v, t), to read and to compute with."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol, final

import numpy as np

from mecanique.derive.states import Given, States
from mecanique.model.mechanism import Mechanism

__all__ = ["Equations", "Numeric"]


class Numeric(Protocol):
    """What a method offers to compute with, for n states at once."""

    def mass_matrix(self, states: States) -> np.ndarray:
        """Return M, shape (n, nv, nv)."""

    def bias(self, states: States) -> np.ndarray:
        """Return the bias, shape (n, nv)."""

    def forces(self, states: States) -> np.ndarray:
        """Return the generalized forces, shape (n, nv)."""

    def acceleration(self, states: States) -> np.ndarray:
        """Return the accelerations, shape (n, nv)."""

    def energy(self, states: States) -> tuple[np.ndarray, np.ndarray]:
        """Return kinetic and potential energy, each shape (n,)."""


@final
@dataclass(frozen=True)
class Equations:
    """Derived equations of motion M(q, t) a + bias(q, v, t) = forces(q, v, t).

    Args:
        mechanism: what they describe.
        method: how they were derived.
        numeric: computes them.
    """

    mechanism: Mechanism
    method: str
    numeric: Numeric

    def mass_matrix(self, q: Given, t: float | np.ndarray = 0.0) -> np.ndarray:
        """Return the mass matrix M, shape (nv, nv) or (n, nv, nv).

        Args:
            q: shape (nq,) or (n, nq), or values by coordinate name.
            t: shape () or (n,) [s].

        Raises:
            InputError: if a shape is wrong or a number is not finite.
        """
        states = States.of(self.mechanism, q, None, t)
        return states.shaped(self.numeric.mass_matrix(states))

    def bias(self, q: Given, v: Given, t: float | np.ndarray = 0.0) -> np.ndarray:
        """Return Coriolis, centrifugal and rheonomic inertia terms and gravity, shape (nv,) or (n, nv).

        Args:
            q: shape (nq,) or (n, nq), or values by coordinate name.
            v: shape (nv,) or (n, nv), or values by velocity name.
            t: shape () or (n,) [s].

        Raises:
            InputError: if a shape is wrong or a number is not finite.
        """
        states = States.of(self.mechanism, q, v, t)
        return states.shaped(self.numeric.bias(states))

    def forces(self, q: Given, v: Given, t: float | np.ndarray = 0.0) -> np.ndarray:
        """Return the generalized forces of springs, dampers, drives and loads, shape (nv,) or (n, nv).

        Args:
            q: shape (nq,) or (n, nq), or values by coordinate name.
            v: shape (nv,) or (n, nv), or values by velocity name.
            t: shape () or (n,) [s].

        Raises:
            InputError: if a shape is wrong or a number is not finite.
        """
        states = States.of(self.mechanism, q, v, t)
        return states.shaped(self.numeric.forces(states))

    def acceleration(self, q: Given, v: Given, t: float | np.ndarray = 0.0) -> np.ndarray:
        """Return the accelerations a, shape (nv,) or (n, nv).

        Args:
            q: shape (nq,) or (n, nq), or values by coordinate name.
            v: shape (nv,) or (n, nv), or values by velocity name.
            t: shape () or (n,) [s].

        Raises:
            InputError: if a shape is wrong or a number is not finite.
            DerivationError: if a motion meets no inertia.
        """
        states = States.of(self.mechanism, q, v, t)
        return states.shaped(self.numeric.acceleration(states))

    def energy(self, q: Given, v: Given, t: float | np.ndarray = 0.0) -> tuple[np.ndarray, np.ndarray]:
        """Return the kinetic energy T and the potential energy V of gravity and springs, each shape () or (n,) [J].

        Args:
            q: shape (nq,) or (n, nq), or values by coordinate name.
            v: shape (nv,) or (n, nv), or values by velocity name.
            t: shape () or (n,) [s].

        Raises:
            InputError: if a shape is wrong or a number is not finite.
        """
        states = States.of(self.mechanism, q, v, t)
        T, V = self.numeric.energy(states)
        return states.shaped(T), states.shaped(V)
