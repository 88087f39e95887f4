"""Poisson series: canonical sums of rational × monomial × cos or sin of integer sums of angles.

Products of sines and cosines are written as sums at once, so that cos² + sin² = 1 and every
angle-sum identity hold by construction and nothing ever needs to be simplified (a representation
from celestial mechanics: A. Deprit, J. Henrard, A. Rom, "Lunar ephemeris: Delaunay's theory
revisited", Science 168 (1970), 1569).
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from enum import Enum
from fractions import Fraction
from typing import Any, Generic, TypeVar, final

from mecanique.derivation.scalars.polynomials import (
    REACH,
    Parts,
    check_size,
    differentiate_angles,
    differentiate_powers,
    exponent,
    exponents,
    generators_in,
    largest,
    lower_powers,
    lowest_terms,
    negative,
    power,
    product,
    shift,
    size,
    split_powers,
)
from mecanique.errors import DerivationError

E = TypeVar("E")
"""The elements of the ring, its series."""


class Kind(Enum):
    """What a generator of a ring stands for."""

    PARAMETER = "parameter"
    COORDINATE = "coordinate"
    VELOCITY = "velocity"
    ACCELERATION = "acceleration"
    INPUT = "input"
    TIME = "time"
    CONSTANT = "constant"
    ATOM = "atom"
    REACTION = "reaction"
    VARIATION = "virtual displacement"


@final
@dataclass(frozen=True)
class Generator:
    """A named indeterminate of a ring."""

    name: str  # its name, e.g. "q", "q'" for a velocity, "q''" for an acceleration
    kind: Kind  # the kind of quantity that it denotes
    index: int  # its position in monomials


@final
@dataclass(frozen=True)
class Angle(Generic[E]):
    """An argument of sines and cosines: a rational multiple of a monomial, e.g. q, Ω t or x/R."""

    argument: E  # the angle as a series [rad]
    unit: Fraction  # the rational multiple


FOLLOWER = "follower"
"""The function, the identity, of an atom that stands for a joint's angle under its name."""


@final
@dataclass(frozen=True)
class Atom(Generic[E]):
    """A function of a series, adjoined to the ring as a generator with its own chain rule."""

    # its name, e.g. "sqrt", "exp"; "1" if the generator is the argument itself, adjoined to allow
    # division by it
    function: str
    argument: E
    slope: E  # its derivative with respect to the argument
    value: Callable[[Any], Any]  # the function of numbers and arrays
    named: bool  # whether it is printed under a name of its own


class Basis(ABC):
    """The interface that the arithmetic of series needs of its ring; `Ring` implements it."""

    def __init__(self, most_terms: int) -> None:
        self.most_terms = most_terms
        self.generators: list[Generator] = []
        self.angles: list[Angle[Series]] = []
        self.atoms: dict[int, Atom[Series]] = {}
        self.rates: dict[int, Series] = {}
        self.roots: list[tuple[int, int, Series]] = []
        """Generators of which a power, 1 or 2, is a series of others: index, power and series."""
        self.places: dict[str, int] = {}
        """Position of each parameter within a printed product, by name; the first is 0."""
        self.written: dict[Any, Any] = {}
        """A cache of printed monomials and angles."""

    @abstractmethod
    def number(self, value: object) -> Series:
        """Return a number as a series."""

    @abstractmethod
    def __getitem__(self, name: str) -> Series:
        """Return a generator as a series."""

    @abstractmethod
    def index(self, generator: str | Series) -> int:
        """Return the index of a generator."""

    @abstractmethod
    def angle(self, monomial: int, multiple: Fraction) -> int:
        """Return a multiple of an angle, packed."""

    @abstractmethod
    def adjoin(
        self,
        function: str,
        argument: Series,
        slope: Callable[[Series], Series],
        value: Callable[[Any], Any],
        name: str | None = None,
    ) -> Series:
        """Return a function of a series as an atom."""

    @abstractmethod
    def inverse(self, series: Series) -> Series:
        """Return 1/series as an atom, for a series that is not a unit."""

    @abstractmethod
    def sum(self, series: Iterable[Series]) -> Series:
        """Return the sum of many series."""


@final
class Series:
    """An element of a ring of Poisson series: immutable, canonical, hashable."""

    # Two series are equal exactly when they are the same function, unless an adjoined root is in a
    # denominator; see `vanishes` for that case. Series are made by a ring and by arithmetic, not
    # directly.

    __slots__ = ("_hash", "denominator", "parts", "reach", "ring")

    def __init__(self, ring: Basis, parts: Parts, denominator: int, reach: int) -> None:
        self.ring = ring
        self.parts = parts
        self.denominator = denominator
        self.reach = reach
        self._hash: int | None = None

    def terms(self) -> Iterator[tuple[int, int, Fraction]]:
        """Yield (trigonometric key, monomial, coefficient) of every term."""
        for trig, polynomial in self.parts.items():
            for monomial, c in polynomial.items():
                yield trig, monomial, Fraction(c, self.denominator)

    def __len__(self) -> int:
        return size(self.parts)

    def __bool__(self) -> bool:
        return bool(self.parts)

    def __hash__(self) -> int:
        if self._hash is None:
            parts = frozenset((trig, frozenset(p.items())) for trig, p in self.parts.items())
            self._hash = hash((id(self.ring), parts, self.denominator))
        return self._hash

    def __eq__(self, other: object) -> bool:
        if not isinstance(other, Series):
            if not isinstance(other, (int, float, Fraction)):
                return NotImplemented
            other = self.ring.number(other)
        return (
            self.ring is other.ring
            and self.denominator == other.denominator
            and self.parts == other.parts
        )

    @property
    def is_number(self) -> bool:
        """Whether it is a rational number."""
        return not self.parts or (self.parts.keys() == {0} and self.parts[0].keys() == {0})

    @property
    def is_unit(self) -> bool:
        """Whether it is one monomial without sine or cosine, which has an inverse."""
        return self.parts.keys() == {0} and len(self.parts[0]) == 1

    def vanishes(self) -> bool:
        """Return whether it is zero, after clearing roots from denominators if necessary."""
        series = self
        # the latest atoms are cleared first, as arguments contain only earlier ones
        for index, degree, _ in reversed(self.ring.roots):
            lowest = min((exponent(m, index) for p in series.parts.values() for m in p), default=0)
            if lowest < 0:
                cleared = shift(series.parts, power(index, degree * -(lowest // degree)))
                reach = series.reach - lowest + 1
                series = _reduce(Series(self.ring, cleared, series.denominator, reach))
        return not series.parts

    def generators(self) -> list[Generator]:
        """Return the generators it depends on in order, including those in angles and atoms."""
        found: set[int] = set()
        todo: list[Series] = [self]
        while todo:
            series = todo.pop()
            direct = set(series._powers()) - found
            found |= direct
            todo += [self.ring.angles[j].argument for j in series._turns()]
            todo += [self.ring.atoms[i].argument for i in direct if i in self.ring.atoms]
        return [self.ring.generators[i] for i in sorted(found)]

    def __repr__(self) -> str:
        return (
            " + ".join(self._term_text(*term) for term in self.terms()).replace("+ -", "- ") or "0"
        )

    def __add__(self, other: object) -> Series:
        return self.ring.sum([self, self._lift(other)])

    __radd__ = __add__

    def __neg__(self) -> Series:
        return Series(self.ring, negative(self.parts), self.denominator, self.reach)

    def __pos__(self) -> Series:
        return self

    def __sub__(self, other: object) -> Series:
        return self + -self._lift(other)

    def __rsub__(self, other: object) -> Series:
        return self._lift(other) + -self

    def __mul__(self, other: object) -> Series:
        other = self._lift(other)
        if not self.parts or not other.parts:
            return Series(self.ring, {}, 1, 0)
        reach = self.reach + other.reach
        if reach > REACH:
            reach = largest(self.parts) + largest(other.parts)
            if reach > REACH:
                raise DerivationError(
                    f"a product would have an exponent or a multiple of an angle beyond ±{REACH}; "
                    "use the numeric derivation"
                )
        parts, halves = product(self.parts, other.parts, self.ring.most_terms)
        result = canonical(self.ring, parts, self.denominator * other.denominator * halves, reach)
        return _reduce(result) if self.ring.roots and _share_roots(self, other) else result

    __rmul__ = __mul__

    def __truediv__(self, other: object) -> Series:
        return self * self._lift(other) ** -1

    def __rtruediv__(self, other: object) -> Series:
        return self._lift(other) * self**-1

    def __pow__(self, exponent: int) -> Series:
        if not isinstance(exponent, int):
            raise DerivationError(f"expected an integer exponent, got {exponent!r}")
        if exponent < 0:
            return self._inverse() ** -exponent if exponent != -1 else self._inverse()
        result, square = self.ring.number(1), self
        while exponent:
            if exponent & 1:
                result = result * square
            exponent >>= 1
            if exponent:
                square = square * square
        return result

    def _inverse(self) -> Series:
        if self.is_unit:
            ((monomial, c),) = self.parts[0].items()
            sign = 1 if c > 0 else -1
            return _reduce(
                Series(self.ring, {0: {-monomial: sign * self.denominator}}, abs(c), self.reach)
            )
        if self.vanishes():
            raise DerivationError("division by zero in a series")
        return self.ring.inverse(self)

    def _lift(self, other: object) -> Series:
        if not isinstance(other, Series):
            return self.ring.number(other)
        if other.ring is not self.ring:
            raise DerivationError("expected two series of one ring, got series of two rings")
        return other

    def diff(self, generator: str | Series) -> Series:
        """Return the partial derivative by a generator, including through angles and atoms."""
        return self._along({self.ring.index(generator): self.ring.number(1)})

    def ddt(self) -> Series:
        """Return the total time derivative."""
        for generator in self.generators():
            if (
                generator.kind in (Kind.ACCELERATION, Kind.INPUT)
                and generator.index not in self.ring.rates
            ):
                raise DerivationError(
                    f"the rate of the {generator.kind.value} {generator.name!r} is not known"
                )
        return self._along(self.ring.rates)

    def _along(self, rates: Mapping[int, Series]) -> Series:
        """Chain rule: the sum of partial derivatives, each times the rate of its generator."""
        parts: list[Series] = []
        for i in self._powers():
            rate = rates.get(i)
            if rate is None and i in self.ring.atoms:
                rate = self.ring.atoms[i].slope * self.ring.atoms[i].argument._along(rates)
            if rate:
                parts.append(self._by_power(i) * rate)
        for j in self._turns():
            rate = self.ring.angles[j].argument._along(rates)
            if rate:
                parts.append(self._by_angle(j) * rate)
        return parts[0] if len(parts) == 1 else self.ring.sum(parts)

    def _powers(self) -> list[int]:
        return generators_in((m for p in self.parts.values() for m in p), len(self.ring.generators))

    def _turns(self) -> list[int]:
        return generators_in((trig >> 1 for trig in self.parts), len(self.ring.angles))

    def _by_power(self, index: int) -> Series:
        parts = differentiate_powers(self.parts, index)
        return canonical(self.ring, parts, self.denominator, self.reach + 1)

    def _by_angle(self, index: int) -> Series:
        parts = differentiate_angles(self.parts, index)
        return canonical(self.ring, parts, self.denominator, self.reach)

    def coefficients(self, generators: Sequence[str]) -> dict[tuple[int, ...], Series]:
        """Return the coefficients of a polynomial in some generators, by their exponents."""
        places = {self.ring.index(name): k for k, name in enumerate(generators)}
        found = split_powers(self.parts, places)
        return {
            key: canonical(self.ring, parts, self.denominator, self.reach)
            for key, parts in found.items()
        }

    def linear(self, generators: Sequence[str]) -> tuple[list[Series], Series]:
        """Return coefficients Cᵢ and remainder R of Σ Cᵢ xᵢ + R, e.g. a row of M."""
        zero = self.ring.number(0)
        coefficients, rest = [zero] * len(generators), zero
        for powers, series in self.coefficients(generators).items():
            if not any(powers):
                rest = series
            elif sum(map(abs, powers)) == 1 and 1 in powers:
                coefficients[powers.index(1)] = series
            else:
                raise DerivationError(
                    f"expected a series linear in {', '.join(generators)}, got {self}"
                )
        return coefficients, rest

    def _term_text(self, trig: int, monomial: int, c: Fraction) -> str:
        names = self.ring.generators
        factors = [names[i].name + (f"^{e}" if e != 1 else "") for i, e in exponents(monomial)]
        if trig:
            angles = " + ".join(
                f"{k}*({self.ring.angles[j].argument})" for j, k in exponents(trig >> 1)
            )
            factors.append(f"{'sin' if trig & 1 else 'cos'}({angles})")
        if abs(c) == 1 and factors:
            return ("-" if c < 0 else "") + "*".join(factors)
        return "*".join([str(c), *factors])


def canonical(ring: Basis, parts: Parts, denominator: int, reach: int) -> Series:
    """Return the series of some parts, with zeros removed and the fraction reduced."""
    parts, denominator = lowest_terms(parts, denominator)
    check_size(parts, ring.most_terms)
    return Series(ring, parts, denominator, reach)


def _reduce(series: Series) -> Series:
    """Replace ρ² by s wherever ρ = √s was adjoined, and adjoined divisors by their sums."""
    ring = series.ring
    for index, degree, argument in reversed(ring.roots):
        # negative powers of a unit can be taken out, too
        lowered = lower_powers(series.parts, index, degree, below_zero=argument.is_unit)
        if lowered.keys() - {0}:
            pieces = {
                k: canonical(ring, parts, series.denominator, series.reach)
                for k, parts in lowered.items()
            }
            series = ring.sum([piece * argument**k for k, piece in pieces.items()])
    return series


def _share_roots(first: Series, second: Series) -> bool:
    ours, theirs = set(first._powers()), set(second._powers())
    return any(index in ours and index in theirs for index, *_ in first.ring.roots)
