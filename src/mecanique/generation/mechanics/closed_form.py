"""Write the equations of motion on a tape in closed form, from the series that are printed."""

from __future__ import annotations

from collections.abc import Mapping
from fractions import Fraction
from functools import cached_property
from typing import Any, final

from mecanique.derivation.equations import Equations
from mecanique.derivation.mechanics.letters import Letters
from mecanique.derivation.mechanics.vectors import Rows
from mecanique.derivation.scalars.polynomials import exponents
from mecanique.derivation.scalars.series import CONSTANTS, FOLLOWER, Kind, Ring, Series
from mecanique.derivation.symbolic.lagrange import Lagrange
from mecanique.errors import DerivationError
from mecanique.program.tape import Tape, Value
from mecanique.program.traced import trace, value_of


@final
class Lowering:
    """Writes series of a ring on a tape."""

    def __init__(self, ring: Ring, tape: Tape, values: Mapping[str, Value]) -> None:
        self._ring = ring
        self._tape = tape
        self._values = values
        self._generators: dict[int, Value] = {}
        self._circular: dict[int, Value] = {0: 1.0}
        self._angles: dict[int, Value] = {}
        self._velocities = {g.index for g in ring.generators if g.kind is Kind.VELOCITY}

    def __call__(self, series: Series) -> Value:
        """Write a series."""
        tape, terms = self._tape, []
        for trig, polynomial in sorted(series.parts.items()):
            groups: dict[tuple[bool, Value], dict[tuple[int, ...], Value]] = {}
            for monomial, c in polynomial.items():
                rest, coefficient, speeds = self._factors(monomial, Fraction(c, series.denominator))
                group = groups.setdefault(
                    (isinstance(rest, int), rest), {}
                )  # an int is an index, a float a number
                group[speeds] = tape.add(group.get(speeds, 0.0), coefficient)
            inner = tape.sum(
                tape.multiply(rest, self._in_velocities(group))
                for (_, rest), group in groups.items()
            )
            terms.append(tape.multiply(inner, self._sine_or_cosine(trig)))
        return tape.sum(terms)

    def _factors(self, monomial: int, c: Fraction) -> tuple[Value, Value, tuple[int, ...]]:
        """Split a term: powers of coordinates, number and parameters, and velocities (repeated)."""
        tape = self._tape
        rest: Value = 1.0
        coefficient: Value = c.numerator / c.denominator
        speeds: list[int] = []
        for index, e in exponents(monomial):
            if index in self._velocities and e > 0:
                speeds += [index] * e
                continue
            power = tape.power(self._generator(index), e)
            if isinstance(power, float) or self._ring.generators[index].kind is Kind.PARAMETER:
                coefficient = tape.multiply(coefficient, power)
            else:
                rest = tape.multiply(rest, power)
        return rest, coefficient, tuple(speeds)

    def _in_velocities(self, terms: dict[tuple[int, ...], Value]) -> Value:
        """Write a polynomial in the velocities."""
        products = []
        for speeds, product in terms.items():
            for index in speeds:
                product = self._tape.multiply(product, self._generator(index))
            products.append(product)
        return self._tape.sum(products)

    def _generator(self, index: int) -> Value:
        if index not in self._generators:
            generator = self._ring.generators[index]
            if generator.name in self._values:
                self._generators[index] = self._values[generator.name]
            elif index in self._ring.atoms:
                atom = self._ring.atoms[index]
                inner = self(atom.argument)
                itself = atom.function in ("1", FOLLOWER)
                self._generators[index] = inner if itself else self._tape.call(atom.function, inner)
            elif generator.kind is Kind.CONSTANT:
                self._generators[index] = CONSTANTS[generator.name]
            else:
                raise DerivationError(f"no value is known for {generator.name!r}")
        return self._generators[index]

    def _sine_or_cosine(self, trig: int) -> Value:
        if trig not in self._circular:
            tape = self._tape
            parts = []
            for j, k in exponents(trig >> 1):
                if j not in self._angles:
                    self._angles[j] = self(self._ring.angles[j].argument)
                parts.append(tape.multiply(float(k), self._angles[j]))
            self._circular[trig] = tape.call("sin" if trig & 1 else "cos", tape.sum(parts))
        return self._circular[trig]


MOST_VELOCITIES = 8
"""With more velocities, closed forms are too long to be faster than a recursion."""


@final
class ClosedFormProgram:
    """Mass matrix, bias, forces and energies from the series of a derivation."""

    def __init__(self, letters: Letters, equations: Equations) -> None:
        mechanism = letters.mechanism
        if mechanism.nv > MOST_VELOCITIES:
            raise DerivationError(
                f"expected at most {MOST_VELOCITIES} velocities for a closed form, "
                f"got {mechanism.nv}"
            )
        self._derivation = derivation = equations.derivation
        if derivation.assumptions:
            subjects = ", ".join(assumption.subject for assumption in derivation.assumptions)
            raise DerivationError(
                f"the closed form of {mechanism.name!r} holds for one sign of {subjects} only"
            )
        self._letters = letters
        values = {name: value_of(scalar) for name, scalar in letters.values.items()}
        self._lower = Lowering(derivation.algebra.ring, letters.tape, values)

    def mass_matrix(self) -> Rows:
        """Return M."""
        return [list(map(self._write, row)) for row in self._derivation.M]

    def bias(self) -> list[Any]:
        """Return Coriolis, centrifugal and rheonomic inertia terms and gravity."""
        return [self._write(entry) for entry in self._derivation.h]

    def forces(self) -> list[Any]:
        """Return the generalized forces of springs, dampers, drives and loads."""
        return [self._write(entry) for entry in self._derivation.Q]

    def energy(self) -> tuple[Any, Any]:
        """Return the kinetic and the potential energy."""
        return self._write(self._lagrange.T), self._write(self._lagrange.stored)

    @cached_property
    def _lagrange(self) -> Lagrange:
        return Lagrange(self._letters.mechanism, self._derivation.algebra)

    def _write(self, series: Series) -> Any:
        return trace(self._letters.tape, self._lower(series))
