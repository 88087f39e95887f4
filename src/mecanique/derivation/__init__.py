"""In-house mechanics: equations of motion derived from the description alone, symbolically and numerically."""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING

from mecanique.errors import UnknownNameError

if TYPE_CHECKING:
    from mecanique.derivation.equations import Equations
    from mecanique.model.mechanism import Mechanism

__all__ = ["METHODS", "derive", "readable"]

METHODS = {
    "newton_euler": "mecanique.derivation.symbolic.newton_euler",
    "virtual_work": "mecanique.derivation.symbolic.virtual_work",
    "lagrange": "mecanique.derivation.symbolic.lagrange",
}
"""Module of each method; it has a function `derive_equations(mechanism)`."""


def derive(mechanism: Mechanism, method: str = "lagrange") -> Equations:
    """Derive the equations of motion of a mechanism.

    Args:
        mechanism: any mechanism.
        method: "lagrange" (Lagrange's equations, with multipliers where there are loops),
            "newton_euler" (every body cut free, with its reactions) or "virtual_work" (d'Alembert's
            inertia forces and a ledger of virtual work).

    Raises:
        UnknownNameError: if there is no such method.
        DerivationError: if the method cannot treat the mechanism.
    """
    if method not in METHODS:
        raise UnknownNameError("method", method, METHODS)
    equations: Equations = import_module(METHODS[method]).derive_equations(mechanism)
    return equations


def readable(mechanism: Mechanism) -> tuple[str, ...]:
    """Return the methods whose derivations can be written out, in textbook order; some only if they are short enough.

    Args:
        mechanism: any mechanism.
    """
    return ("lagrange",) if mechanism.loops else tuple(METHODS)
