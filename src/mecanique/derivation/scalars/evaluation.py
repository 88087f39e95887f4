"""Evaluate Poisson series in numbers or arrays, given the values of their generators."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any, final

import numpy as np

from mecanique.derivation.scalars.cancel import tidy
from mecanique.derivation.scalars.elementary import cos, sin
from mecanique.derivation.scalars.functions import function_without_arcs
from mecanique.derivation.scalars.polynomials import exponents, power
from mecanique.derivation.scalars.series import CONSTANTS, Kind, Ring, Series
from mecanique.errors import UnknownNameError


def evaluate(series: Series, values: Mapping[str, Any]) -> Any:
    """Return the value of a series."""
    return Evaluation(series.ring, values)(series)


def relative_rest(parts: Sequence[Any]) -> float:
    """Return the residual of a sum that should vanish, relative to its largest part."""
    together = np.broadcast_arrays(*parts)
    largest = np.max(np.abs(together), axis=0)
    rest = np.abs(np.sum(together, axis=0))
    return float(np.max(np.where(largest > 0, rest / np.where(largest > 0, largest, 1.0), 0.0)))


@final
class Evaluation:
    """Evaluates many series of a ring for one set of values; each function is computed once."""

    def __init__(self, ring: Ring, values: Mapping[str, Any]) -> None:
        self._ring = ring
        self._given = values
        self._generators: dict[int, Any] = {}
        self._angles: dict[int, Any] = {}
        self._circular: dict[int, Any] = {0: 1.0}

    def __call__(self, series: Series) -> Any:
        """Return the value of a series."""
        total: Any = 0.0
        for trig, polynomial in series.parts.items():
            factor: Any = 0.0
            for monomial, c in polynomial.items():
                term: Any = c / series.denominator
                for index, e in exponents(monomial):
                    # numpy refuses negative integer powers of integer arrays
                    term = term * self._generator(index) ** e
                factor = factor + term
            total = total + factor * self._sine_or_cosine(trig)
        return total

    def _generator(self, index: int) -> Any:
        if index not in self._generators:
            generator = self._ring.generators[index]
            if index in self._ring.atoms and generator.name not in self._given:
                atom = self._ring.atoms[index]
                value = atom.value(self(atom.argument))
            elif generator.kind is Kind.CONSTANT:
                value = CONSTANTS[generator.name]
            elif generator.name in self._given:
                value = self._given[generator.name]
                value = np.asarray(value, dtype=float) if np.ndim(value) else float(value)
            else:
                raise UnknownNameError("value", generator.name, self._given)
            self._generators[index] = value
        return self._generators[index]

    def _sine_or_cosine(self, trig: int) -> Any:
        if trig not in self._circular:
            argument: Any = 0.0
            for j, k in exponents(trig >> 1):
                if j not in self._angles:
                    self._angles[j] = self(self._ring.angles[j].argument)
                argument = argument + k * self._angles[j]
            self._circular[trig] = np.sin(argument) if trig & 1 else np.cos(argument)
        return self._circular[trig]


@final
class Substitution:
    """Replaces generators by series, exactly: sin q at q = π/6 is 1/2, √(h² + x²) at x = 0 is h."""

    def __init__(self, values: Mapping[str, Series], numbers: Mapping[str, float]) -> None:
        self._values = values
        self._numbers = numbers
        self._generators: dict[int, Series] = {}
        self._angles: dict[int, Series] = {}

    def __call__(self, series: Series) -> Series:
        """Return the series after substitution."""
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
            replacement = self._values.get(generator.name)
            if replacement is None:
                replacement = ring.monomial(power(index))
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
                    replacement = value
                    if atom.function == "sqrt" and evaluate(replacement, self._numbers) < 0:
                        replacement = -replacement
            self._generators[index] = replacement
        return self._generators[index]
