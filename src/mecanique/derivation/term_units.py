"""Find the units of the terms of equations of motion."""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Iterable
from fractions import Fraction

from mecanique.derivation.printing.expressions import to_sympy
from mecanique.derivation.printing.formulas import Product
from mecanique.derivation.printing.writers import Equation
from mecanique.derivation.symbolic.derivation import Derivation
from mecanique.model.mechanism.homogeneity import dimensions_of
from mecanique.model.units import (
    Dimension,
    Dimensions,
    HomogeneityError,
    divide,
    read_unit,
    say_unit,
)

UNIT_AT_END = re.compile(r"\[([^\]]*)\]$")
"""The unit in brackets at the end of a symbol's meaning."""


def find_units(derivation: Derivation, equation: Equation) -> tuple[Dimension | None, ...]:
    """Return the dimension of each term; None where a plain number stands for a quantity."""
    dimensions = _collect_dimensions(derivation)
    terms = (*equation.left.terms, *equation.right.terms)
    return tuple(_find_dimension(dimensions, term) for term in terms)


def unit_of(derivation: Derivation, equation: Equation) -> str:
    """Return the unit of the terms of an equation, that of most terms if they differ."""
    # They differ where plain numbers stand for quantities with a unit
    known = [its for its in find_units(derivation, equation) if its is not None]
    return say_unit(Counter(known).most_common(1)[0][0]) if known else ""


def _find_dimension(dimensions: Dimensions, term: Product) -> Dimension | None:
    try:
        return dimensions.of(term.sympy())
    except HomogeneityError:  # a plain number stands for a quantity with a unit
        return None


def _collect_dimensions(derivation: Derivation) -> Dimensions:
    """Return the dimensions of all letters: the mechanism's own, a, roots and multipliers."""
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
    """Yield the dimension of each symbol whose meaning ends with a unit."""
    for name, sentence in meanings:
        found = UNIT_AT_END.search(sentence)
        if found:
            yield name, read_unit(found[1])
