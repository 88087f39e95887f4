"""One constraint equation of a mechanism, with its multiplier."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import final

from mecanique.derivation.scalars.ring import Ring
from mecanique.derivation.scalars.series import Series


@final
@dataclass(frozen=True)
class Tie:
    """One equation of a loop, a contact or a velocity constraint.

    Args:
        name: name of the equation, e.g. "C_x".
        demand: its left side, Φ(q, t) or ψ = A v − b, which the constraint keeps zero.
        multiplier: λ.
        meaning: the meaning of λ, with its unit.
        of_velocities: whether it is ψ, linear in the velocities and in general not integrable.
        of_contact: whether it belongs to a contact.
    """

    name: str
    demand: Series
    multiplier: Series
    meaning: str
    of_velocities: bool = False
    of_contact: bool = False

    @property
    def letter(self) -> str:
        """The letter of its left side, "Phi" or "psi"."""
        return "psi" if self.of_velocities else "Phi"

    def slopes(self, ring: Ring) -> list[Series]:
        """Return the derivatives of Φ', or of ψ, by each velocity: ∂Φ/∂q or ∂ψ/∂v."""
        return ring.partials(self.demand) if self.of_velocities else ring.along(self.demand)

    @cached_property
    def second(self) -> Series:
        """The constraint on the accelerations: Φ'' or ψ'."""
        rate = self.demand.ddt()
        return rate if self.of_velocities else rate.ddt()
