"""Check symbolically that all methods derive the same equations of motion."""

from __future__ import annotations

from mecanique.derivation.methods import METHODS
from mecanique.derivation.scalars.series import Series
from mecanique.derivation.symbolic.derivation import Derivation, along_displacement
from mecanique.derivation.symbolic.symbols import Algebra
from mecanique.model.mechanism import Mechanism


def derivations(mechanism: Mechanism) -> dict[str, Derivation]:
    """Derive a mechanism by every method in the same symbols; return them by name, textbook order.

    Raises:
        DerivationError: if the mechanism has loops, or no closed form of reasonable length.
    """
    algebra = Algebra(mechanism)
    return {name: way.symbolic(mechanism, algebra).derivation() for name, way in METHODS.items()}


def _project(lagrange: Derivation, other: Derivation) -> tuple[Series, ...]:
    """Lagrange's left sides, projected on the other method's independent displacements, if any."""
    if not other.quasi:
        return lagrange.rows
    return tuple(along_displacement(one, lagrange.rows) for one in other.quasi)


def agreement(mechanism: Mechanism) -> str:
    """Say in a sentence whether all methods give the same left sides.

    With quaternions the differences need not vanish identically: their unit length is not used.

    Raises:
        DerivationError: if the mechanism has loops, or no closed form of reasonable length.
    """
    found = derivations(mechanism)
    *others, lagrange = found.values()
    for other in others:
        for left, right in zip(other.rows, _project(lagrange, other), strict=True):
            if not (left - right).vanishes():
                return "The closed forms of the equations differ; compare them by numbers."
    said = (
        "All three methods give the same equations of motion: the differences of their left sides "
        "vanish identically."
    )
    if any(other.quasi for other in others):
        said = (
            "All three methods give the same equations of motion. Those of Newton and Euler equal "
            "Lagrange's, with the same multipliers λ; projected on the independent virtual "
            "displacements, where λ cancels, they are those of virtual work. All differences of "
            "left sides vanish identically."
        )
    reactions = found["newton_euler"].reactions
    if reactions:
        said += (
            f" The reactions {', '.join(reactions)} appear in the balances of the bodies and in "
            "their equilibrium with the inertia forces, but not in the sum of virtual work or in "
            "Lagrange's equations. They follow from the motion, as listed under Reactions."
        )
    return said
