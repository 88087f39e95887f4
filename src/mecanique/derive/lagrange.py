"""Lagrange's equations of the second kind: d/dt ∂T/∂v − ∂T/∂q + ∂V/∂q = Q."""

from __future__ import annotations

from mecanique.derive.equations import Equations
from mecanique.derive.recursion import Recursion
from mecanique.model.mechanism import Mechanism

__all__ = ["derive_equations"]


def derive_equations(mechanism: Mechanism) -> Equations:
    """Derive the equations of motion by Lagrange's method.

    Args:
        mechanism: any mechanism.
    """
    return Equations(mechanism, "lagrange", Recursion(mechanism))
