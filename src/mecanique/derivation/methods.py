"""The three methods of derivation, each with its symbolic and its numeric form."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import final

from mecanique.derivation.equations import Equations
from mecanique.derivation.numeric.dynamics import BatchDynamics
from mecanique.derivation.numeric.newton_euler import Balances, refuse_misfits
from mecanique.derivation.numeric.recursion import Recursion
from mecanique.derivation.numeric.virtual_work import Works
from mecanique.derivation.symbolic.derivation import SymbolicMethod
from mecanique.derivation.symbolic.lagrange import Lagrange
from mecanique.derivation.symbolic.newton_euler import NewtonEuler
from mecanique.derivation.symbolic.symbols import Algebra
from mecanique.derivation.symbolic.virtual_work import VirtualWork
from mecanique.errors import UnknownNameError
from mecanique.model.mechanism import Mechanism


@final
@dataclass(frozen=True)
class Method:
    """A way to derive equations of motion.

    Args:
        title: its printed name.
        symbolic: derives closed forms in a mechanism's symbols.
        numeric: computes the same quantities in numbers, for any mechanism.
    """

    title: str
    symbolic: Callable[[Mechanism, Algebra | None], SymbolicMethod]
    numeric: Callable[[Mechanism], BatchDynamics]


METHODS = {
    "newton_euler": Method(
        "Newton and Euler's equations of every body cut free", NewtonEuler, Balances
    ),
    "virtual_work": Method("d'Alembert's principle and virtual work", VirtualWork, Works),
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
    chosen = METHODS[method]
    refuse_misfits(mechanism)
    return Equations(
        mechanism=mechanism,
        method=method,
        title=chosen.title,
        numeric=chosen.numeric(mechanism),
        derive_symbols=lambda: chosen.symbolic(mechanism, None).derivation(),
    )


def readable(mechanism: Mechanism) -> tuple[str, ...]:
    """Return the methods whose derivations can be written out, in textbook order."""
    return tuple(METHODS)
