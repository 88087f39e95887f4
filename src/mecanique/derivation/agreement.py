"""Check that all methods lead to the same equations of motion, as closed forms."""

from __future__ import annotations

from mecanique.derivation.methods import METHODS
from mecanique.derivation.scalars.series import Series
from mecanique.derivation.symbolic.derivation import Derivation, along_displacement
from mecanique.derivation.symbolic.symbols import Algebra
from mecanique.model.mechanism import Mechanism

__all__ = ["agreement", "derivations"]


def derivations(mechanism: Mechanism) -> dict[str, Derivation]:
    """Return the derivations by all methods in the same symbols, by method, in textbook order.

    Raises:
        DerivationError: if it has loops, or no closed form of reasonable length.
    """
    algebra = Algebra(mechanism)
    return {name: way.symbolic(mechanism, algebra).derivation() for name, way in METHODS.items()}


def _along(lagrange: Derivation, other: Derivation) -> tuple[Series, ...]:
    """Lagrange's left sides, along the independent displacements of the other method, if any."""
    if not other.quasi:
        return lagrange.rows
    return tuple(along_displacement(one, lagrange.rows) for one in other.quasi)


def agreement(mechanism: Mechanism) -> str:
    """Say in a sentence whether the left sides by all methods are equal.

    Quaternions have unit length only along a motion, so with one the difference need not vanish
    identically.

    Raises:
        DerivationError: if it has loops, or no closed form of reasonable length.
    """
    found = derivations(mechanism)
    *others, lagrange = found.values()
    for other in others:
        for left, right in zip(other.rows, _along(lagrange, other), strict=True):
            if not (left - right).vanishes():
                return "The closed forms of the equations differ; compare them by numbers."
    said = (
        "All three methods give the same equations of motion: the differences of their left sides "
        "vanish identically."
    )
    if any(other.quasi for other in others):
        said = (
            "All three methods give the same equations of motion. Newton and Euler's are those of "
            "Lagrange with the same forces λ; put together as the independent displacements move "
            "the coordinates, which rids them of λ, they are those of the virtual work: all "
            "differences of left sides vanish identically."
        )
    reactions = found["newton_euler"].reactions
    if reactions:
        said += (
            f" The reactions {', '.join(reactions)} stand in the balances of the single bodies and "
            "in their equilibrium with the inertia forces; in the sum of the virtual work and in "
            "Lagrange's equations they do not appear. Once the motion is known they follow from "
            "it, as listed under Reactions."
        )
    return said
