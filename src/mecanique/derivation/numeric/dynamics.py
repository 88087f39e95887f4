"""The quantities that every numeric derivation computes: M, bias, forces, energies, momenta."""

from __future__ import annotations

from abc import ABC, abstractmethod
from typing import ClassVar

import numpy as np

from mecanique.model.states import States


class BatchDynamics(ABC):
    """The terms of M a + bias = forces in numbers; with loops, those of the tree."""

    # All methods take n states and return arrays whose first axis has length n

    rolls: ClassVar[bool] = False
    """Whether `acceleration` satisfies contacts and velocity constraints."""

    @abstractmethod
    def mass_matrix(self, states: States) -> np.ndarray:
        """Return M, shape (n, nv, nv); velocities do not matter."""

    @abstractmethod
    def bias(self, states: States) -> np.ndarray:
        """Return Coriolis, centrifugal and rheonomic inertia terms and gravity, shape (n, nv)."""

    @abstractmethod
    def forces(self, states: States) -> np.ndarray:
        """Return the generalized forces of springs, dampers, drives and loads, shape (n, nv)."""

    @abstractmethod
    def gravity(self, states: States) -> np.ndarray:
        """Return gravity's part of the bias, ∂V/∂q, shape (n, nv)."""

    @abstractmethod
    def inverse_dynamics(self, states: States, a: np.ndarray) -> np.ndarray:
        """Return M a + bias for accelerations a, shape (n, nv)."""

    @abstractmethod
    def acceleration(self, states: States) -> np.ndarray:
        """Return a from M a + bias = forces, shape (n, nv)."""

    @abstractmethod
    def energy(self, states: States) -> tuple[np.ndarray, np.ndarray]:
        """Return the kinetic energy T and the potential energy V, each shape (n,) [J]."""

    @abstractmethod
    def momentum(self, states: States) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Return the linear momentum, and the angular ones about origin and center of mass."""
        # Each has shape (n, 3); bodies fixed to the ground do not count
