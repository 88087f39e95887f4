"""Poisson series: canonical sums of rational × monomial × cos or sin of integer sums of angles.

Products of sines and cosines are written as sums at once, so that cos² + sin² = 1 and every
angle-sum identity hold by construction and nothing ever needs to be simplified (a representation
from celestial mechanics: A. Deprit, J. Henrard, A. Rom, "Lunar ephemeris: Delaunay's theory
revisited", Science 168 (1970), 1569).
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from enum import Enum
from fractions import Fraction
from itertools import pairwise
from typing import Any, final

from mecanique.derivation.scalars.polynomials import (
    REACH,
    Parts,
    accumulate,
    check_size,
    differentiate_angles,
    differentiate_powers,
    exact,
    exponent,
    exponents,
    generators_in,
    largest,
    largest_exponent,
    lower_powers,
    lowest_terms,
    negative,
    power,
    product,
    shift,
    size,
    split_powers,
)
from mecanique.errors import DerivationError, UnknownNameError


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


GIVEN = frozenset({Kind.PARAMETER, Kind.CONSTANT})
"""Kinds of what is constant, and taken as positive."""

TIMED = frozenset({Kind.TIME, Kind.INPUT})
"""Kinds of what changes by itself."""

CONSTANTS = {"pi": math.pi, "E": math.e}
"""Irrational constants that keep their names."""


@final
@dataclass(frozen=True)
class Generator:
    """A named indeterminate of a ring."""

    name: str  # its name, e.g. "q", "q'" for a velocity, "q''" for an acceleration
    kind: Kind  # the kind of quantity that it denotes
    index: int  # its position in monomials


@final
@dataclass(frozen=True)
class Angle:
    """An argument of sines and cosines: a rational multiple of a monomial, e.g. q, Ω t or x/R."""

    argument: Series  # the angle as a series [rad]
    unit: Fraction  # the rational multiple


FOLLOWER = "follower"
"""The function, the identity, of an atom that stands for a joint's angle under its name."""


@final
@dataclass(frozen=True)
class Atom:
    """A function of a series, adjoined to the ring as a generator with its own chain rule."""

    # its name, e.g. "sqrt", "exp"; "1" if the generator is the argument itself, adjoined to allow
    # division by it
    function: str
    argument: Series
    slope: Series  # its derivative with respect to the argument
    value: Callable[[Any], Any]  # the function of numbers and arrays
    named: bool  # whether it is printed under a name of its own


@final
class Series:
    """An element of a ring of Poisson series: immutable, canonical, hashable."""

    # Two series are equal exactly when they are the same function, unless an adjoined root is in a
    # denominator; see `vanishes` for that case. Series are made by a ring and by arithmetic, not
    # directly.

    __slots__ = ("_hash", "denominator", "parts", "reach", "ring")

    def __init__(self, ring: Ring, parts: Parts, denominator: int, reach: int) -> None:
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

    def split(self) -> list[Series]:
        """Return the terms, each as a series."""
        return [
            Series(self.ring, {trig: {monomial: c.numerator}}, c.denominator, self.reach)
            for trig, monomial, c in self.terms()
        ]

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
        indices: set[int] = set()
        todo: list[Series] = [self]
        while todo:
            series = todo.pop()
            direct = set(series._powers()) - indices
            indices |= direct
            todo += [self.ring.angles[j].argument for j in series.turns()]
            todo += [self.ring.atoms[i].argument for i in direct if i in self.ring.atoms]
        return [self.ring.generators[i] for i in sorted(indices)]

    @property
    def kinds(self) -> set[Kind]:
        """The kinds of quantities that it depends on."""
        return {generator.kind for generator in self.generators()}

    def __repr__(self) -> str:
        return (
            " + ".join(self._term_text(*term) for term in self.terms()).replace("+ -", "- ") or "0"
        )

    def __add__(self, other: object) -> Series:
        return self.ring.sum([self, self._lift(other)])

    __radd__ = __add__

    def __neg__(self) -> Series:
        return Series(self.ring, negative(self.parts), self.denominator, self.reach)

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
                slopes = differentiate_powers(self.parts, i)
                slope = canonical(self.ring, slopes, self.denominator, self.reach + 1)
                parts.append(slope * rate)
        for j in self.turns():
            rate = self.ring.angles[j].argument._along(rates)
            if rate:
                slopes = differentiate_angles(self.parts, j)
                slope = canonical(self.ring, slopes, self.denominator, self.reach)
                parts.append(slope * rate)
        return parts[0] if len(parts) == 1 else self.ring.sum(parts)

    def _powers(self) -> list[int]:
        return generators_in((m for p in self.parts.values() for m in p), len(self.ring.generators))

    def turns(self) -> list[int]:
        """Return the indices of the angles in its sines and cosines, in order."""
        return generators_in((trig >> 1 for trig in self.parts), len(self.ring.angles))

    def coefficients(self, generators: Sequence[str]) -> dict[tuple[int, ...], Series]:
        """Return the coefficients of a polynomial in some generators, by their exponents."""
        places = {self.ring.index(name): k for k, name in enumerate(generators)}
        by_powers = split_powers(self.parts, places)
        return {
            key: canonical(self.ring, parts, self.denominator, self.reach)
            for key, parts in by_powers.items()
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


def canonical(ring: Ring, parts: Parts, denominator: int, reach: int) -> Series:
    """Return the series of some parts, with zeros removed and the fraction reduced."""
    parts, denominator = lowest_terms(parts, denominator)
    check_size(parts, ring.most_terms)
    return Series(ring, parts, denominator, reach)


def _reduce(series: Series) -> Series:
    """Replace ρ² by s wherever ρ = √s was adjoined, and adjoined divisors by their sums."""
    ring = series.ring
    for index, degree, argument in reversed(ring.roots):
        if index not in series._powers():
            continue
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
class Ring:
    """The generators of a ring of Poisson series, with their chain rules."""

    def __init__(self, most_terms: int = 20_000) -> None:
        self.most_terms = most_terms
        self.generators: list[Generator] = []
        self.angles: list[Angle] = []
        self.atoms: dict[int, Atom] = {}
        self.rates: dict[int, Series] = {}
        self.roots: list[tuple[int, int, Series]] = []
        """Generators of which a power, 1 or 2, is a series of others: index, power and series."""
        self.places: dict[str, int] = {}
        """Position of each parameter within a printed product, by name; the first is 0."""
        self.letters: Mapping[str, str] = {}
        """Letters for names that are words, in print."""
        self.written: dict[Any, Any] = {}
        """A cache of printed monomials and angles."""
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
        """Adjoin (once) one of `CONSTANTS` and return it."""
        return self[name] if name in self._indices else self._adjoin(name, Kind.CONSTANT)

    def unknown(self, name: str, kind: Kind) -> Series:
        """Adjoin (once) a quantity without a rate, such as a reaction, and return it."""
        return (
            self[name]
            if name in self._indices and self._kind(name) is kind
            else self._adjoin(name, kind)
        )

    def choose_name(self, candidates: Iterable[str]) -> str:
        """Return the first of some names that no generator has."""
        return next(name for name in candidates if name not in self._indices)

    def number(self, value: object) -> Series:
        """Return a number as a series; a float becomes a simple rational (see `exact`)."""
        rational = exact(value)
        return Series(
            self, {0: {0: rational.numerator}} if rational else {}, rational.denominator, 0
        )

    def __getitem__(self, name: str) -> Series:
        if name not in self._indices:
            raise UnknownNameError("generator", name, self._indices)
        return self.monomial(power(self._indices[name]))

    def monomial(self, packed: int) -> Series:
        """Return a packed monomial as a series."""
        return Series(self, {0: {packed: 1}}, 1, largest_exponent([packed]))

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
        slopes = []
        for v in self.names(Kind.VELOCITY):
            rates = [(g.name, self.rates[g.index].diff(v)) for g in moving]
            slopes.append(self.sum([series.diff(name) * rate for name, rate in rates if rate]))
        return slopes

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
            argument = self.monomial(monomial) * unit
            self._angle_indices[key] = len(self.angles)
            self.angles.append(Angle(argument, unit))
        index = self._angle_indices[key]
        count = multiple / self.angles[index].unit
        if count.denominator != 1 or abs(count) > REACH:
            raise DerivationError(
                f"sine or cosine of {float(multiple):.6g} × {self.monomial(monomial)}, of which "
                f"{float(self.angles[index].unit):.6g} × occurs: expected integer multiples of "
                f"at most {REACH}; round the ratios of the angles, or use the numeric derivation"
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
        return self.monomial(-power(self.index(atom)))

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
