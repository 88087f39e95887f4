"""Substitute values into Poisson series, including their angles, roots and other functions."""

from __future__ import annotations

from collections.abc import Mapping
from typing import final

from mecanique.derivation.scalars.arcs import function_without_arcs
from mecanique.derivation.scalars.cancel import tidy
from mecanique.derivation.scalars.elementary import cos, sin
from mecanique.derivation.scalars.evaluation import evaluate
from mecanique.derivation.scalars.monomials import exponents, power
from mecanique.derivation.scalars.series import Series


@final
class Substitution:
    """Replaces generators by series, exactly: sin q at q = π/6 is 1/2, √(h² + x²) at x = 0 is h.

    Args:
        values: the replacements, by name of the generator.
        numbers: numeric values of all other generators, which decide which root of a square is
            positive.
    """

    def __init__(self, values: Mapping[str, Series], numbers: Mapping[str, float]) -> None:
        self._values = values
        self._numbers = numbers
        self._generators: dict[int, Series] = {}
        self._angles: dict[int, Series] = {}

    def __call__(self, series: Series) -> Series:
        """Return the series after substitution.

        Args:
            series: any series of the ring that the values belong to.

        Raises:
            DerivationError: if a divisor becomes zero, or a value has no form in the ring.
        """
        ring, terms = series.ring, []
        for trig, monomial, c in series.terms():
            term = ring.number(c)
            for index, e in exponents(monomial):
                term = term * self._generator(series, index) ** e
            if trig and term:
                angle = ring.sum([k * self._angle(series, j) for j, k in exponents(trig >> 1)])
                term = term * (sin if trig & 1 else cos)(angle)
            terms.append(term)
        return tidy(ring.sum(terms))

    def _angle(self, series: Series, index: int) -> Series:
        if index not in self._angles:
            self._angles[index] = self(series.ring.angles[index].argument)
        return self._angles[index]

    def _generator(self, series: Series, index: int) -> Series:
        if index not in self._generators:
            ring = series.ring
            generator = ring.generators[index]
            found = self._values.get(generator.name)
            if found is None:
                found = Series(ring, {0: {power(index): 1}}, 1, 1)
                atom = ring.atoms.get(index)
                if atom is not None and any(
                    g.name in self._values for g in atom.argument.generators()
                ):
                    argument = self(atom.argument)
                    value: Series = (
                        argument
                        if atom.function == "1"
                        else function_without_arcs(atom.function)(argument)
                    )
                    found = value
                    if atom.function == "sqrt" and evaluate(found, self._numbers) < 0:
                        found = -found
            self._generators[index] = found
        return self._generators[index]
