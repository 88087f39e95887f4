"""The three methods of derivation, each with its symbolic and its numeric form."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from typing import final

from mecanique.derivation.equations import Equations
from mecanique.derivation.numeric.dynamics import BatchDynamics
from mecanique.derivation.numeric.newton_euler import Balances, refuse_misfits
from mecanique.derivation.numeric.recursion import Recursion
from mecanique.derivation.numeric.virtual_work import NumericVirtualWork
from mecanique.derivation.symbolic.derivation import Derivation, SymbolicMethod, along_displacement
from mecanique.derivation.symbolic.lagrange import Lagrange
from mecanique.derivation.symbolic.newton_euler import NewtonEuler
from mecanique.derivation.symbolic.symbols import Algebra
from mecanique.derivation.symbolic.virtual_work import VirtualWork
from mecanique.errors import UnknownNameError
from mecanique.model.mechanism import Mechanism


@final
@dataclass(frozen=True)
class Method:
    """A way to derive equations of motion."""

    title: str  # its printed name
    # derives closed forms in a mechanism's symbols
    symbolic: Callable[[Mechanism, Algebra | None], SymbolicMethod]
    # computes the same quantities in numbers, for any mechanism
    numeric: Callable[[Mechanism], BatchDynamics]


METHODS = {
    "newton_euler": Method(
        "Newton and Euler's equations of every body cut free", NewtonEuler, Balances
    ),
    "virtual_work": Method(
        "d'Alembert's principle and virtual work", VirtualWork, NumericVirtualWork
    ),
    "lagrange": Method("Lagrange's equations of the second kind", Lagrange, Recursion),
}
"""Each method by its name, in textbook order."""


def derive(mechanism: Mechanism, method: str = "lagrange") -> Equations:
    """Derive the equations of motion of a mechanism.

    Args:
        mechanism: any mechanism.
        method: "lagrange" (Lagrange's equations, with multipliers where there are loops),
            "newton_euler" (every body cut free, with its reactions) or "virtual_work" (d'Alembert's
            inertia forces and a ledger of virtual work).

    Returns:
        The equations, to read and to compute with.

    Raises:
        UnknownNameError: if there is no such method.
        DerivationError: if an element, a cord or a gear, does not fit the coordinate map.

    Example:
        >>> print(mq.derive(mq.textbook.load('rigid_bar_pendulum')))
        q'' + 3 g sin(q)/(2 l) = 0
    """
    if method not in METHODS:
        raise UnknownNameError("method", method, METHODS)
    mechanism.refuse_switching(
        "its equations differ from mode to mode, as mq.derive_modes writes them"
    )
    chosen = METHODS[method]
    refuse_misfits(mechanism)
    return Equations(
        mechanism=mechanism,
        method=method,
        title=chosen.title,
        numeric=chosen.numeric(mechanism),
        derive_symbols=partial(_derive_symbols, mechanism, method),
    )


def _derive_symbols(mechanism: Mechanism, method: str) -> Derivation:
    return METHODS[method].symbolic(mechanism, None).derivation()


def derivations(mechanism: Mechanism) -> dict[str, Derivation]:
    """Derive a mechanism by every method in the same symbols, by name in textbook order."""
    algebra = Algebra(mechanism)
    return {name: way.symbolic(mechanism, algebra).derivation() for name, way in METHODS.items()}


def agreement(mechanism: Mechanism) -> str:
    """Say in a sentence whether all methods give the same left sides."""
    # With quaternions the differences need not vanish identically: their unit length is not used
    methods = derivations(mechanism)
    *others, lagrange = methods.values()
    for derivation in others:
        projected = [along_displacement(column, lagrange.rows) for column in derivation.quasi]
        for left, right in zip(derivation.rows, projected or lagrange.rows, strict=True):
            if not (left - right).vanishes():
                return "The closed forms of the equations differ; compare them by numbers."
    said = (
        "All three methods give the same equations of motion: the differences of their left sides "
        "vanish identically."
    )
    if any(derivation.quasi for derivation in others):
        said = (
            "All three methods give the same equations of motion. Those of Newton and Euler equal "
            "Lagrange's, with the same multipliers λ; projected on the independent virtual "
            "displacements, where λ cancels, they are those of virtual work. All differences of "
            "left sides vanish identically."
        )
    reactions = methods["newton_euler"].reactions
    if reactions:
        said += (
            f" The reactions {', '.join(reactions)} appear in the balances of the bodies and in "
            "their equilibrium with the inertia forces, but not in the sum of virtual work or in "
            "Lagrange's equations. They follow from the motion, as listed under Reactions."
        )
    return said
