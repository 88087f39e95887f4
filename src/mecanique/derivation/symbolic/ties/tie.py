"""One equation that ties the bodies of a mechanism, with its multiplier."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import final

from mecanique.derivation.scalars.ring import Ring
from mecanique.derivation.scalars.series import Series

__all__ = ["Tie"]


@final
@dataclass(frozen=True)
class Tie:
    """One equation of a loop, a contact or a velocity constraint.

    Args:
        name: of the equation, e.g. "C_x".
        demand: Φ, which is zero while the loop is closed; or ψ = A v − b, which is zero.
        multiplier: λ.
        meaning: what λ is, with its unit.
        of_velocities: whether it is ψ, linear in the velocities and in general no rate of a Φ.
        of_contact: whether it is that of a contact.
    """

    name: str
    demand: Series
    multiplier: Series
    meaning: str
    of_velocities: bool = False
    of_contact: bool = False

    @property
    def letter(self) -> str:
        """The letter of its demand."""
        return "psi" if self.of_velocities else "Phi"

    def slopes(self, ring: Ring) -> list[Series]:
        """Return how the demand, or its rate, changes with each velocity: ∂Φ/∂q or ∂ψ/∂v."""
        return ring.partials(self.demand) if self.of_velocities else ring.along(self.demand)

    @cached_property
    def second(self) -> Series:
        """What it demands of the accelerations: Φ'' or ψ'."""
        rate = self.demand.ddt()
        return rate if self.of_velocities else rate.ddt()
