"""The units of the terms of equations of motion."""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Iterable
from fractions import Fraction

from mecanique.derivation.printing.formulas import Product
from mecanique.derivation.printing.printed import Equation
from mecanique.derivation.printing.sympy_forms import to_sympy
from mecanique.derivation.symbolic.derivation import Derivation
from mecanique.model.dimensions import (
    Dimension,
    Dimensions,
    HomogeneityError,
    divide,
    read_unit,
    say_unit,
)
from mecanique.model.mechanism.homogeneity import dimensions_of

__all__ = ["UNIT_AT_END", "find_units", "unit_of"]

UNIT_AT_END = re.compile(r"\[([^\]]*)\]$")
"""The unit at the end of what a symbol means."""


def find_units(derivation: Derivation, equation: Equation) -> tuple[Dimension | None, ...]:
    """Return the dimension of each term of an equation; None where a number leaves it open.

    Args:
        derivation: of the equation.
        equation: as printed.
    """
    dimensions = _dimensions(derivation)
    terms = (*equation.left.terms, *equation.right.terms)
    return tuple(_of(dimensions, term) for term in terms)


def unit_of(derivation: Derivation, equation: Equation) -> str:
    """Return the unit that the terms of an equation have.

    Where plain numbers stand for quantities with a unit, it is that of most terms.

    Args:
        derivation: of the equation.
        equation: as printed.
    """
    known = [its for its in find_units(derivation, equation) if its is not None]
    return say_unit(Counter(known).most_common(1)[0][0]) if known else ""


def _of(dimensions: Dimensions, term: Product) -> Dimension | None:
    try:
        return dimensions.of(term.sympy())
    except HomogeneityError:  # a plain number stands for a quantity with a unit
        return None


def _dimensions(derivation: Derivation) -> Dimensions:
    """Those of all letters in the equations: the mechanism's own, a, roots and multipliers."""
    algebra = derivation.algebra
    own = dimensions_of(algebra.mechanism)
    known = {**own.states, **own.declared}
    for velocity in algebra.velocities:
        if velocity in known:
            known[f"{velocity}'"] = divide(known[velocity], read_unit("s"))
    known |= dict(_collect_stated(derivation.unknowns.items()))
    for index, atom in algebra.ring.atoms.items():
        its = Dimensions(known, {}).of(to_sympy(atom.argument))
        if atom.named and atom.function == "sqrt" and its is not None:
            known[algebra.ring.generators[index].name] = tuple(Fraction(x) / 2 for x in its)
    return Dimensions(known, {})


def _collect_stated(meanings: Iterable[tuple[str, str]]) -> Iterable[tuple[str, Dimension]]:
    """The units at the end of sentences."""
    for name, sentence in meanings:
        found = UNIT_AT_END.search(sentence)
        if found:
            yield name, read_unit(found[1])
