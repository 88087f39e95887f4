"""The quantities that every numeric derivation computes: M, bias, forces, energies, momenta."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable
from dataclasses import replace
from typing import ClassVar, Generic, TypeVar, final

import numpy as np

from mecanique.errors import DerivationError
from mecanique.model.mechanism import Mechanism
from mecanique.model.states import States

T = TypeVar("T")


@final
class Latest(Generic[T]):
    """What was computed last, for the next question about the same states."""

    def __init__(self, compute: Callable[[States], T]) -> None:
        self._compute = compute
        self._kept: tuple[States, T] | None = None

    def __reduce__(self) -> tuple[type[Latest[T]], tuple[Callable[[States], T]]]:
        return Latest, (self._compute,)  # what is kept would make pickles twenty times larger

    def at(self, states: States) -> T:
        """Return what belongs to n states."""
        if any(callable(signal.signal) for signal in states.mechanism.inputs):
            return self._compute(states)  # a function may answer otherwise the next time
        kept = self._kept  # once, as another thread may replace it
        if kept is None or not _same(kept[0], states):
            # a caller may change arrays in place, which must not change what is kept
            copied = replace(states, q=states.q.copy(), v=states.v.copy(), t=states.t.copy())
            self._kept = kept = copied, self._compute(copied)
        return kept[1]


def _same(first: States, second: States) -> bool:
    if first.mechanism is not second.mechanism or first.efforts is not second.efforts:
        return False
    pairs = ((first.q, second.q), (first.v, second.v), (first.t, second.t))
    return all(np.array_equal(a, b) for a, b in pairs)


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

    def inverse_dynamics(self, states: States, a: np.ndarray) -> np.ndarray:
        """Return M a + bias for accelerations a, shape (n, nv)."""
        return np.asarray((self.mass_matrix(states) @ a[..., None])[..., 0] + self.bias(states))

    def acceleration(self, states: States) -> np.ndarray:
        """Return a from M a + bias = forces, shape (n, nv)."""
        rest = self.forces(states) - self.bias(states)
        return solve(states.mechanism, self.mass_matrix(states), rest)

    @abstractmethod
    def energy(self, states: States) -> tuple[np.ndarray, np.ndarray]:
        """Return the kinetic energy T and the potential energy V, each shape (n,) [J]."""

    @abstractmethod
    def momentum(self, states: States) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Return the linear momentum, and the angular ones about origin and center of mass."""
        # Each has shape (n, 3); bodies fixed to the ground do not count


def solve(mechanism: Mechanism, M: np.ndarray, rest: np.ndarray) -> np.ndarray:
    """Solve M a = rest for a, shape (n, nv); M (n, nv, nv), rest (n, nv)."""
    try:
        return np.linalg.solve(M, rest[..., None])[..., 0]
    except np.linalg.LinAlgError:
        raise DerivationError(
            f"mechanism {mechanism.name!r}: its mass matrix is singular, as some motion has no "
            "inertia; give what it moves mass or inertia, or leave that coordinate out"
        ) from None
