"""Simplify sines and cosines of sums with arc sines, cosines and tangents to roots."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from mecanique.derivation.scalars.elementary import sqrt
from mecanique.derivation.scalars.functions import function
from mecanique.derivation.scalars.generators import Atom
from mecanique.derivation.scalars.monomials import power
from mecanique.derivation.scalars.series import Series


def function_without_arcs(name: str) -> Callable[..., Any]:
    """Return a function for series; its sine and cosine expand arcs, as in sin(asin u + q)."""
    if name not in ("sin", "cos"):
        return function(name)
    place = ("sin", "cos").index(name)
    return lambda argument: (
        _sine_cosine(argument)[place] if isinstance(argument, Series) else function(name)(argument)
    )


def _sine_cosine(angle: Series) -> tuple[Series, Series]:
    """Return sine and cosine of Σ kᵢ arcᵢ + rest, adding one arc after the other."""
    arcs, rest = [], angle
    for trig, monomial, factor in angle.terms():
        for index, atom in angle.ring.atoms.items():
            if (
                not trig
                and monomial == power(index)
                and factor.denominator == 1
                and atom.function in _OF_ARC
            ):
                arcs.append((atom, int(factor)))
                rest = rest - factor * Series(angle.ring, {0: {monomial: 1}}, 1, 1)
    sine, cosine = function("sin")(rest), function("cos")(rest)
    for atom, count in arcs:
        s, c = _OF_ARC[atom.function](atom)
        s = s if count > 0 else -s
        for _ in range(abs(count)):
            sine, cosine = sine * c + cosine * s, cosine * c - sine * s
    return sine, cosine


def _of_atan(atom: Atom[Series]) -> tuple[Series, Series]:
    across = sqrt(1 + atom.argument * atom.argument) ** -1
    return atom.argument * across, across


_OF_ARC: dict[str, Callable[[Atom[Series]], tuple[Series, Series]]] = {
    "asin": lambda atom: (atom.argument, sqrt(1 - atom.argument * atom.argument)),
    "acos": lambda atom: (sqrt(1 - atom.argument * atom.argument), atom.argument),
    "atan": _of_atan,
}
"""Functions that give sine and cosine of each arc."""
