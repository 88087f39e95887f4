"""The ring of Poisson series: named generators, angles and atoms, each with its rate."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable
from dataclasses import dataclass
from fractions import Fraction
from itertools import pairwise
from typing import Any, final

from mecanique.derivation.scalars.polynomials import (
    REACH,
    Parts,
    accumulate,
    exact,
    exponents,
    largest_exponent,
    power,
)
from mecanique.derivation.scalars.series import (
    Angle,
    Atom,
    Basis,
    Generator,
    Kind,
    Series,
    canonical,
)
from mecanique.errors import DerivationError, UnknownNameError


@final
@dataclass(frozen=True)
class Euler:
    """The parts of Lagrange's operator applied to a function L, for one velocity q'."""

    momentum: Series  # ∂L/∂q'
    rate: Series  # d/dt ∂L/∂q'
    slope: Series  # ∂L/∂q

    @property
    def value(self) -> Series:
        """d/dt ∂L/∂q' − ∂L/∂q."""
        return self.rate - self.slope


@final
class Ring(Basis):
    """The generators of a ring of Poisson series, with their chain rules."""

    def __init__(self, most_terms: int = 20_000) -> None:
        super().__init__(most_terms)
        self._indices: dict[str, int] = {}
        self._angle_indices: dict[tuple[int, Fraction], int] = {}
        self._atom_indices: dict[tuple[str, Series], int] = {}

    def coordinate(self, name: str) -> Series:
        """Adjoin and return a coordinate, with its velocity name' and acceleration name''."""
        q, v = self._adjoin(name, Kind.COORDINATE), self._adjoin(name + "'", Kind.VELOCITY)
        self.rates[self.index(q)] = v
        self.rates[self.index(v)] = self._adjoin(name + "''", Kind.ACCELERATION)
        return q

    def quasi_coordinates(
        self, names: Iterable[str], velocities: Iterable[str]
    ) -> tuple[list[Series], list[Series]]:
        """Adjoin coordinates whose rates the caller sets in `rates`, and their velocities."""
        moved = [self._adjoin(name, Kind.COORDINATE) for name in names]
        rates = [self._adjoin(name, Kind.VELOCITY) for name in velocities]
        for v in rates:
            self.rates[self.index(v)] = self._adjoin(
                self.generators[self.index(v)].name + "'", Kind.ACCELERATION
            )
        return moved, rates

    def bind(self, *names: str) -> None:
        """Keep the squares of coordinates at the sum 1, by that of the last."""
        *rest, last = (self[name] for name in names)
        square = self.sum([self.number(1), *(-(x * x) for x in rest)])
        self.roots.append((self.index(last), 2, square))

    def velocity(self, name: str) -> Series:
        """Return the velocity of a coordinate."""
        return self.rates[self._index_of(name, Kind.COORDINATE)]

    def acceleration(self, name: str) -> Series:
        """Return the acceleration of a coordinate."""
        return self.rates[self._index_of(name + "'", Kind.VELOCITY)]

    def parameter(self, name: str) -> Series:
        """Adjoin and return a parameter; square roots take it as positive."""
        return self._adjoin(name, Kind.PARAMETER)

    def input(self, name: str, derivatives: int = 0) -> Series:
        """Adjoin and return an input, a function of time, with derivatives name', name''."""
        chain = [self._adjoin(name + "'" * order, Kind.INPUT) for order in range(derivatives + 1)]
        for function, derivative in pairwise(chain):
            self.rates[self.index(function)] = derivative
        return chain[0]

    @property
    def time(self) -> Series:
        """Time, the generator t with rate 1."""
        if "t" not in self._indices:
            self.rates[self.index(self._adjoin("t", Kind.TIME))] = self.number(1)
        return self["t"]

    def constant(self, name: str) -> Series:
        """Adjoin (once) a named irrational constant, e.g. "pi", and return it."""
        return self[name] if name in self._indices else self._adjoin(name, Kind.CONSTANT)

    def unknown(self, name: str, kind: Kind) -> Series:
        """Adjoin (once) a quantity without a rate, such as a reaction, and return it."""
        return (
            self[name]
            if name in self._indices and self._kind(name) is kind
            else self._adjoin(name, kind)
        )

    def number(self, value: object) -> Series:
        """Return a number as a series; a float becomes a simple rational (see `exact`)."""
        rational = exact(value)
        return Series(
            self, {0: {0: rational.numerator}} if rational else {}, rational.denominator, 0
        )

    def __getitem__(self, name: str) -> Series:
        if name not in self._indices:
            raise UnknownNameError("generator", name, self._indices)
        return Series(self, {0: {power(self._indices[name]): 1}}, 1, 1)

    def names(self, kind: Kind) -> tuple[str, ...]:
        """Return the names of the generators of a kind, in the order they were adjoined."""
        return tuple(g.name for g in self.generators if g.kind is kind)

    def index(self, generator: str | Series) -> int:
        """Return the index of a generator, given by name or as a series."""
        if isinstance(generator, str):
            return self.index(self[generator])
        if (
            generator.parts.keys() == {0}
            and generator.denominator == 1
            and len(generator.parts[0]) == 1
        ):
            ((monomial, coefficient),) = generator.parts[0].items()
            if coefficient == 1 and monomial:
                (index, degree), *others = exponents(monomial)
                if degree == 1 and not others:
                    return index
        raise DerivationError(f"expected a generator of the ring, got {generator}")

    def sum(self, series: Iterable[Series]) -> Series:
        """Return the sum of many series of this ring, in one pass."""
        terms = list(series)
        denominator = math.lcm(*(s.denominator for s in terms))
        parts: Parts = {}
        for s in terms:
            for trig, polynomial in s.parts.items():
                accumulate(parts, trig, polynomial, denominator // s.denominator)
        return canonical(self, parts, denominator, max((s.reach for s in terms), default=0))

    def partials(self, series: Series) -> list[Series]:
        """Return the partial derivatives with respect to each velocity."""
        return [series.diff(v) for v in self.names(Kind.VELOCITY)]

    def along(self, series: Series) -> list[Series]:
        """Return the derivatives of a function of the coordinates along each velocity."""
        moving = [g for g in series.generators() if g.kind is Kind.COORDINATE]
        found = []
        for v in self.names(Kind.VELOCITY):
            rates = [(g.name, self.rates[g.index].diff(v)) for g in moving]
            found.append(self.sum([series.diff(name) * rate for name, rate in rates if rate]))
        return found

    def euler(self, L: Series) -> list[Euler]:
        """Apply Lagrange's operator for every velocity (Mécanique analytique, 1788)."""
        pairs = zip(self.partials(L), self.along(L), strict=True)
        return [Euler(momentum, momentum.ddt(), slope) for momentum, slope in pairs]

    def angle(self, monomial: int, multiple: Fraction) -> int:
        """Return a multiple of an angle, packed; the angle is adjoined where needed."""
        # a monomial has one unit; different constant angles are independent
        key = (monomial, abs(multiple) if not monomial else Fraction(0))
        if key not in self._angle_indices:
            unit = abs(multiple) if not monomial else Fraction(1, multiple.denominator)
            argument = canonical(
                self,
                {0: {monomial: unit.numerator}},
                unit.denominator,
                largest_exponent([monomial]),
            )
            self._angle_indices[key] = len(self.angles)
            self.angles.append(Angle(argument, unit))
        index = self._angle_indices[key]
        count = multiple / self.angles[index].unit
        if count.denominator != 1 or abs(count) > REACH:
            raise DerivationError(
                f"sine or cosine of {multiple} × an angle that already occurs as "
                f"{self.angles[index].argument}: expected integer multiples; take the smallest "
                "angle as the coordinate, or use the numeric derivation"
            )
        return power(index, int(count))

    def adjoin(
        self,
        function: str,
        argument: Series,
        slope: Callable[[Series], Series],
        value: Callable[[Any], Any],
        name: str | None = None,
    ) -> Series:
        """Adjoin (once) a function of a series with its chain rule, and return it."""
        key = (function, argument)
        if key not in self._atom_indices:
            index = len(self.generators)
            # names of generators must be unique; an atom without one is printed as its definition
            atom = self._adjoin(name or f"{function}#{index}", Kind.ATOM)
            self._atom_indices[key] = index
            self.atoms[index] = Atom(function, argument, slope(atom), value, name is not None)
            if function in ("sqrt", "1"):
                self.roots.append((index, 2 if function == "sqrt" else 1, argument))
        return self[self.generators[self._atom_indices[key]].name]

    def inverse(self, series: Series) -> Series:
        """Return 1/u as an atom, for a series u that is not a unit; u × u⁻¹ is not cancelled."""
        atom = self.adjoin("1", series, lambda _: self.number(1), lambda u: u)
        return Series(self, {0: {-power(self.index(atom)): 1}}, 1, 1)

    def _adjoin(self, name: str, kind: Kind) -> Series:
        if name in self._indices:
            raise DerivationError(
                f"the name {name!r} already stands for a {self._kind(name).value}"
            )
        self._indices[name] = len(self.generators)
        self.generators.append(Generator(name, kind, len(self.generators)))
        return self[name]

    def _kind(self, name: str) -> Kind:
        return self.generators[self._indices[name]].kind

    def _index_of(self, name: str, kind: Kind) -> int:
        if name not in self._indices or self._kind(name) is not kind:
            raise UnknownNameError(kind.value, name, self.names(kind))
        return self._indices[name]
