"""Reduce Lagrange's equations of loops to a single one by kinematic coefficients."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from functools import partial
from typing import NamedTuple, final

import numpy as np

from mecanique.derivation.printing.equations import expression, join
from mecanique.derivation.printing.writers import Equation, Expression
from mecanique.derivation.scalars.cancel import tidy
from mecanique.derivation.scalars.evaluation import Evaluation
from mecanique.derivation.scalars.polynomials import exponents
from mecanique.derivation.scalars.series import TIMED, Series
from mecanique.derivation.symbolic.derivation import (
    Derivation,
    Ending,
    Left,
    Result,
    Stage,
    Tie,
    along_displacement,
    lefts_of,
    mass_and_bias,
)
from mecanique.derivation.symbolic.lagrange import Lagrange
from mecanique.derivation.symbolic.multipliers import (
    Quotient,
    loop_stages,
    name_of,
    solve_multipliers,
)
from mecanique.derivation.symbolic.symbols import Algebra
from mecanique.derivation.tolerances import RANK
from mecanique.errors import DerivationError, UnknownNameError
from mecanique.model.mechanism_units import characteristic_length, units
from mecanique.model.random_positions import draw_positions

_FOLLOW = (
    "The loops make every other coordinate a function of {0}: its velocity is K {0}', with the "
    "kinematic coefficient K named after it. The loop equations, differentiated by {0}, are linear "
    "in these. In this order, each follows from the loops and the coefficients above it."
)
_CHANGE = (
    "The derivatives of the coefficients, L = dK/d{0}, follow from the loop equations "
    "differentiated once more: the acceleration of the coordinate is K {0}'' + L {0}'²."
)
_INERTIA = (
    "With these the kinetic energy is ½ J {0}'², where J is the inertia referred to {0}: each mass "
    "times the square of its coefficient. {1} = ½ dJ/d{0} accounts for the change of J."
)
_CLOSING = (
    "J {0}'' + {1} {0}'² equals the sum of all forces, each times the coefficient of the "
    "coordinate along which it acts: one equation without multipliers. It holds where no divisor "
    "above is zero; the loops give the other coordinates for each {0}."
)
_ENDING = (
    "The loops give every other coordinate for each {0}, with the velocity K {0}' and the "
    "acceleration K {0}'' + L {0}'²; the equations reduce to one without multipliers. J is the "
    "inertia referred to {0}, and {1} half its derivative dJ/d{0}."
)


class Coefficient(NamedTuple):
    """A kinematic coefficient, or the derivative of one, in terms of those before it."""

    coordinate: str  # the coordinate that it belongs to
    name: str  # its letter
    value: Quotient

    def result(self) -> Result:
        """Return the line that states it."""
        return Result(Left(self.name), self.value.above, self.value.fraction)


@final
@dataclass(frozen=True)
class ReducedEquation:
    """The single equation of a mechanism with one degree of freedom."""

    derivation: Derivation  # the equation with its steps
    coordinate: str  # the coordinate that is kept
    ratios: tuple[Coefficient, ...]  # K of each other coordinate, in the order of their definitions
    changes: tuple[Coefficient, ...]  # L of each, likewise
    # the terms of the equation, which sum to zero, in terms of all coordinates, the velocity and
    # acceleration of the kept one, and the coefficients
    parts: tuple[Series, ...]
    ties: tuple[Tie, ...]  # the independent equations of the loops

    @property
    def ending(self) -> Ending:
        """The equation with its coefficients, to end a derivation with."""
        lines = [line for stage in self.derivation.stages[-3:] for line in stage.results]
        *_, change = lefts_of(lines)
        equation, _ = self.derivation.written or ()
        sentence = _ENDING.format(self.coordinate, change.symbol)
        return Ending(sentence, (*lines, equation), self.derivation.unknowns)


def reduce_to_one(lagrange: Lagrange, coordinate: str = "") -> ReducedEquation:
    """Derive the single equation of a mechanism with loops and one degree of freedom."""
    algebra = lagrange.algebra
    mechanism = algebra.mechanism
    kept = coordinate or mechanism.coordinates[0]
    if kept not in mechanism.coordinates:
        raise UnknownNameError("coordinate", kept, tuple(mechanism.coordinates))
    still = all(not (tie.of_velocities or tie.of_contact) for tie in lagrange.ties)
    if still and any(not tie.demand.kinds.isdisjoint(TIMED) for tie in lagrange.ties):
        raise DerivationError(f"mechanism {mechanism.name!r}: its loops depend on time")
    ties = independent_ties(algebra, lagrange.ties) if still and lagrange.ties else ()
    if not ties or not still or len(ties) != len(algebra.velocities) - 1:
        raise DerivationError(
            f"mechanism {mechanism.name!r}: expected loops that leave one of its "
            f"{len(algebra.velocities)} velocities free, got {len(ties)} equations of loops"
        )
    return _Reducing(lagrange, kept, ties).single()


def independent_ties(algebra: Algebra, ties: Sequence[Tie]) -> tuple[Tie, ...]:
    """Return the ties that no others follow from in any position, open ones included."""
    # In a tilted plane a gap has three components, of which two are independent
    mechanism, ring = algebra.mechanism, algebra.ring
    names, random = mechanism.coordinates.names, np.random.default_rng(0)
    slopes = []
    for q in draw_positions(mechanism, _POSITIONS, random, characteristic_length(mechanism)):
        values = {**mechanism.values, **dict(zip(names, q.tolist(), strict=True))}
        evaluate = Evaluation(ring, values)
        entries = (entry for tie in ties for entry in tie.slopes(ring))
        slopes.append(np.array([*map(evaluate, entries)], dtype=float).reshape(len(ties), -1))
    rows = np.concatenate(slopes, axis=1)
    rest, chosen = rows, list[int]()
    for _ in ties:
        sizes = np.linalg.norm(rest, axis=1)
        longest = int(np.argmax(sizes))
        if sizes[longest] <= RANK * np.linalg.norm(rows[longest]):
            break
        chosen.append(longest)
        along = rest[longest] / sizes[longest]
        rest = rest - np.outer(rest @ along, along)
    return tuple(ties[k] for k in sorted(chosen))


class _Reducing:
    """The loops of a mechanism, differentiated by the coordinate that is kept."""

    def __init__(self, lagrange: Lagrange, kept: str, ties: tuple[Tie, ...]) -> None:
        self.lagrange, self.kept, self.ties = lagrange, kept, ties
        self.algebra = lagrange.algebra
        self.ring = self.algebra.ring
        self.others = [name for name in self.algebra.mechanism.coordinates if name != kept]
        self.K = {name: self._adjoin(f"K_{name}") for name in self.others}
        self.L = {name: self._adjoin(f"L_{name}") for name in self.others}
        # the steps name points and bodies as well
        mechanism = self.algebra.mechanism
        parts = (*mechanism.bodies, *mechanism.joints, *mechanism.loops)
        taken = {part.name for part in parts}
        change = next(letter for letter in ("C", "N", "U", "C_") if letter not in taken)
        self.J, self.C = (self._adjoin(letter, ahead=True) for letter in ("J", change))

    def _adjoin(self, name: str, *, ahead: bool = False) -> Series:
        """Adjoin a letter under an unused name, ordered after lengths or ahead of them."""
        free = self.ring.choose_name((name, f"{name}_", f"{name}__"))
        self.ring.places[free] = 0 if ahead else _AFTER_LENGTHS
        return self.ring.parameter(free)

    def along(self, series: Series) -> Series:
        """Return d/dθ of a function of the coordinates and the coefficients."""
        terms = [series.diff(self.kept)]
        for name in self.others:
            terms.append(series.diff(name) * self.K[name])
            terms.append(series.diff(self.K[name]) * self.L[name])
        return self.ring.sum(terms)

    def solve(
        self, demands: Sequence[Series], letters: dict[str, Series]
    ) -> tuple[Coefficient, ...]:
        """Solve constraint equations that are linear in the coefficients for these."""
        owners = {name_of(letter): name for name, letter in letters.items()}
        rows, rests = zip(*(demand.linear([*owners]) for demand in demands), strict=True)
        entries = [list(map(tidy, column)) for column in zip(*rows, strict=True)]
        solved = solve_multipliers([*letters.values()], entries, [-rest for rest in rests])
        if not solved:
            raise DerivationError(
                f"mechanism {self.algebra.mechanism.name!r}: the kinematic coefficients with "
                f"respect to {self.kept} have no short closed form"
            )
        return tuple(Coefficient(owners[name], name, value) for name, value in solved.items())

    def single(self) -> ReducedEquation:
        """Return the equation."""
        ring, algebra, kept = self.ring, self.algebra, self.kept
        first = [self.along(_angle_of(tie.demand)) for tie in self.ties]
        second = [self.along(demand) for demand in first]
        K, L = self.solve(first, self.K), self.solve(second, self.L)
        one = ring.number(1)
        ratios = [self.K.get(name, one) for name in algebra.mechanism.coordinates]
        changes = [self.L.get(name, ring.number(0)) for name in algebra.mechanism.coordinates]
        full = self.lagrange.derivation()
        meets = [along_displacement(ratios, row) for row in full.M]
        grows = [along_displacement(changes, row) for row in full.M]
        J = tidy(along_displacement(ratios, meets))
        v, a = ring[f"{kept}'"], ring[f"{kept}''"]
        bias = [self._put(h) for h in full.h]
        forces = self._put(along_displacement(ratios, full.Q))
        carried = tidy(along_displacement(ratios, bias))
        powers = carried.coefficients([f"{kept}'"])
        square = powers.pop((2,), ring.number(0))
        C = tidy(along_displacement(ratios, grows) + square)
        rest = ring.sum([part * v**p for (p,), part in powers.items()])
        parts = (J * a, C * v**2, rest, -forces)
        derivation = self._derivation(full, K, L, J, C, rest, forces)
        return ReducedEquation(derivation, kept, K, L, parts, self.ties)

    def _put(self, series: Series) -> Series:
        """Replace the velocities of the other coordinates by K θ'."""
        ring, v = self.ring, self.ring[f"{self.kept}'"]
        names = self.algebra.mechanism.coordinates
        ratios = [self.K.get(name, ring.number(1)) for name in names]
        terms = []
        for powers, coefficient in series.coefficients(self.algebra.velocities).items():
            term = coefficient
            for ratio, p in zip(ratios, powers, strict=True):
                term = term * (ratio * v) ** p
            terms.append(term)
        return ring.sum(terms)

    def _derivation(
        self,
        full: Derivation,
        K: Sequence[Coefficient],
        L: Sequence[Coefficient],
        J: Series,
        C: Series,
        rest: Series,
        forces: Series,
    ) -> Derivation:
        kept, ring = self.kept, self.ring
        inertia, change = self.J, self.C
        a, v = ring[f"{kept}''"], ring[f"{kept}'"]
        named = [expression(inertia * a)]
        if C:
            named.append(expression(change * v**2))
        left = join([*named, *([expression(rest)] if rest else [])])
        equation = Equation(left, expression(forces), ring.number(1))
        push = forces - rest - change * v**2 if C else forces - rest
        solved = Quotient(push, inertia).equate(f"{kept}''")
        M, h = mass_and_bias(self.algebra, [J * a + C * v**2 + rest - forces])
        closed = [stage for stage in loop_stages(full.ties, of_work=True) if stage.title == "Loops"]
        before = [stage for stage in full.stages if stage.title in _ENERGIES]

        def state(coefficients: Sequence[Coefficient]) -> tuple[Result, ...]:
            return tuple(coefficient.result() for coefficient in coefficients)

        pairs = ((inertia, J), (change, C))
        inertias = tuple(
            Result(Left(name_of(a)), b, partial(self._by_coefficients, b)) for a, b in pairs
        )
        letters = kept, name_of(change)
        return replace(
            full,
            M=M,
            h=h,
            Q=(ring.number(0),),
            stages=(
                *before,
                *closed,
                Stage("Kinematic coefficients", _FOLLOW.format(kept), state(K)),
                Stage("Derivatives of the coefficients", _CHANGE.format(kept), state(L)),
                Stage(f"Inertia referred to {kept}", _INERTIA.format(*letters), inertias),
            ),
            closing=_CLOSING.format(*letters),
            unknowns=dict(self._meanings(K, L)),
            quasi=(),
            written=(equation, solved),
        )

    def _by_coefficients(self, series: Series) -> Expression:
        """Collect a series by kinematic coefficients."""
        letters = [*self.K.values(), *self.L.values()]
        parts = []
        for powers, rest in series.coefficients([*map(name_of, letters)]).items():
            product = rest
            for letter, p in zip(letters, powers, strict=True):
                product = product * letter**p
            parts.append((sum(powers), expression(product)))
        ordered = sorted(parts, key=lambda part: part[0])
        return join(part for _, part in ordered) if ordered else expression(series)

    def _meanings(
        self, K: Sequence[Coefficient], L: Sequence[Coefficient]
    ) -> Iterator[tuple[str, str]]:
        """Yield each letter with its meaning and unit."""
        unit = units(self.algebra.mechanism)
        by = unit[self.kept]
        for term in K:
            size = f"{unit[term.coordinate]}/{by}"
            yield term.name, f"kinematic coefficient d{term.coordinate}/d{self.kept} [{size}]"
        for term in L:
            size = f"{unit[term.coordinate]}/{by}²"
            yield term.name, f"its derivative, d²{term.coordinate}/d{self.kept}² [{size}]"
        inertia, change = ("kg·m²", "kg·m²/rad") if by == "rad" else ("kg", "kg/m")
        yield name_of(self.J), f"inertia referred to {self.kept} [{inertia}]"
        yield (
            name_of(self.C),
            f"half its derivative, ½ dJ/d{self.kept} [{change}]",
        )


_POSITIONS = 3
"""Random positions at which equations of loops must depend on each other to be redundant."""

_AFTER_LENGTHS = 4
"""Position of the coefficients in a product: m l² K."""

_ENERGIES = ("Positions and velocities", "Kinetic energy", "Potential energy")


def _angle_of(demand: Series) -> Series:
    """Return the angle whose sine, times a number, is to vanish; any other demand as it is."""
    # Where the loop is closed the cosine is 1 or −1, so that the rates of both vanish together
    if len(demand) != 1:
        return demand
    ((trig, monomial, _),) = demand.terms()
    if not trig & 1 or monomial:
        return demand
    ring = demand.ring
    return ring.sum([k * ring.angles[j].argument for j, k in exponents(trig >> 1)])
