"""Solve equations of motion for what a book's last line says: accelerations and constraint forces.

Constraints A v = b are linear in the velocities. With displacements S that they allow, A S = 0, and
any p with A p = −γ, the accelerations are a = S c + p; the constraint forces do no work along S, so
Sᵀ (M a + h − Q) = 0 gives c, and Aᵀ λ = M a + h − Q the multipliers (Maggi 1896; Neimark & Fufaev,
Dynamics of Nonholonomic Systems, 1972, ch. III).
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from fractions import Fraction
from functools import cached_property, partial
from itertools import combinations, product
from math import inf, prod
from typing import final

from mecanique.derivation.printing.equations import equations, expression
from mecanique.derivation.printing.writers import Equation
from mecanique.derivation.scalars.cancel import (
    divide_exactly,
    tidy,
    without_common_divisor,
)
from mecanique.derivation.scalars.elementary import sqrt
from mecanique.derivation.scalars.evaluation import Substitution
from mecanique.derivation.scalars.functions import function
from mecanique.derivation.scalars.polynomials import exponent, exponents, power
from mecanique.derivation.scalars.series import GIVEN, Kind, Ring, Series, canonical
from mecanique.derivation.symbolic.derivation import (
    Derivation,
    along_displacement,
    project,
)
from mecanique.derivation.symbolic.multipliers import (
    LONGEST_ABOVE,
    Column,
    Quotient,
    cramer,
    determinant,
    divide_common,
    divide_waves,
    identity,
    is_constant,
    list_alone,
    make_positive,
    name_of,
    select,
    sweep,
)
from mecanique.derivation.symbolic.symbols import coordinate_of
from mecanique.errors import DerivationError
from mecanique.wording import enumerate_words

_MOST_COUPLED = 3
"""Accelerations that depend on each other are solved for up to this number, by Cramer's rule."""

_MOST_DIVIDED = 2
"""Equations of loops are solved with divisors up to this number; more grow beyond reading."""

_MOST_PRODUCTS = 20_000
"""Determinants that multiply out to more terms are not expanded."""


@final
@dataclass(frozen=True)
class EliminatedSolution:
    """What equations of motion come to once constraints are eliminated."""

    # velocities that stay independent; empty if independent displacements turn with the bodies, so
    # that no velocities by themselves are
    kept: tuple[str, ...]
    # equations of motion without multipliers and other accelerations, each zero
    rows: tuple[Series, ...]
    # each acceleration in closed form, by name; empty if they would be long
    accelerations: Mapping[str, Quotient]
    # each other velocity as the constraints give it, by name; empty if none are kept
    followers: Mapping[str, Series]
    # each constraint force by name, in terms of accelerations if those have no closed form; and
    # what redundancy leaves determined of the others, as sums
    find_forces: Callable[[], tuple[dict[str, Quotient], tuple[Equation, ...]]]

    @cached_property
    def _balance(self) -> tuple[dict[str, Quotient], tuple[Equation, ...]]:
        return self.find_forces()

    @property
    def forces(self) -> Mapping[str, Quotient]:
        """Each constraint force by name; of accelerations, if those have no closed form."""
        return self._balance[0]

    @property
    def sums(self) -> tuple[Equation, ...]:
        """What is determined of friction that contacts share: along the rest, and its sum."""
        return self._balance[1]

    def insert(self, force: Series) -> Quotient:
        """Return a force with the accelerations inserted."""
        factors, rest = force.linear([*self.accelerations])
        return _combine(rest, factors, [*self.accelerations.values()])

    @cached_property
    def equations(self) -> tuple[Equation, ...]:
        """The rows as they are printed, empty if one of them says nothing."""
        rows = [without_common_divisor(row) for row in self.rows]
        return equations(rows) if all(rows) else ()

    @cached_property
    def turned(self) -> Mapping[str, Equation]:
        """Forces along x and y of a plane put together along and across what turns, if shorter."""
        return {
            axis: line
            for name, force in self.forces.items()
            if name.endswith("_x") and (other := f"{name[:-1]}y") in self.forces
            for axis, line in zip(
                (name, other), _turn(name, force, self.forces[other]), strict=False
            )
        }


def solve(
    derivation: Derivation, kept: Sequence[str] = (), longest: float = inf
) -> EliminatedSolution:
    """Solve equations of motion; keep some velocities, or as many of the first as possible."""
    # Accelerations that multiply out to more than `longest` terms are left out. Raises a
    # DerivationError if the constraints do not leave them independent, or a divisor might vanish
    return _Solving(derivation, kept).solution(longest)


class _Solving:
    """Equations of motion, with the motions that their constraints allow."""

    def __init__(self, derivation: Derivation, kept: Sequence[str]) -> None:
        self.ties = derivation.ties
        self.algebra = derivation.algebra
        self.ring = ring = self.algebra.ring
        still = find_still(derivation)
        at = Substitution(still, {}) if still else tidy
        v = self.algebra.velocities
        self.M = [list(map(at, row)) for row in derivation.M]
        given = [list(map(at, tie.slopes(ring))) for tie in self.ties]
        wanted = [v.index(name) for name in kept]
        # what is kept gives way last; else the later coordinates follow the first
        ranks = [len(v) + k if k in wanted else len(v) - k for k in range(len(v))]
        self.turn = identity(ring, len(given))
        """Turns the constraints of ties into rows that can be met, A."""
        for _ in range(len(given) + 1):
            self.A = [project(row, [*zip(*given, strict=True)]) for row in self.turn]
            self.allowed, left = sweep(ring, self.A, len(v), ranks)
            if not left or not self._turn_rows(left):
                break
        few = len(given) <= _MOST_DIVIDED or all(tie.of_contact for tie in self.ties)
        if left and few:
            self.allowed, left = sweep(ring, self.A, len(v), ranks, divide=True)
        if left:
            raise DerivationError(self._explain(left))
        self.kept = self._find_kept()
        if kept and sorted(wanted) != sorted(self.kept):
            raise DerivationError(self._explain_choice(kept))
        rates = [tie.demand if tie.of_velocities else tie.demand.ddt() for tie in self.ties]
        self.rates = [at(rate) for rate in rates]
        """What the constraints keep zero, linear in the velocities."""
        self.still = self._reach([rate.linear(v)[1] for rate in self.rates])
        self.rates += [*_level(given, self.rates)]
        gamma = [at(tie.second.linear(self.algebra.accelerations)[1]) for tie in self.ties]
        rest = [at(h - Q) for h, Q in zip(derivation.h, derivation.Q, strict=True)]
        self.sides = [(gamma, rest)]
        """γ and h − Q, in all velocities and, where that differs, in those that are kept."""
        if self.kept and self.A:
            self.sides.append(([*map(self._put, gamma)], [*map(self._put, rest)]))

    def _turn_rows(self, left: Sequence[int]) -> bool:
        """Turn two rows cos φ w and sin φ w, as of a plane's fixed axes, into w and 0, if any."""
        for i, k in combinations(left, 2):
            for column in self.allowed.basis:
                c, s = (along_displacement(column, self.A[row]) for row in (i, k))
                size = tidy(c * c + s * s)
                if not is_constant(size):
                    continue
                rows = self.turn[i], self.turn[k]
                self.turn[i] = [tidy(c * a + s * b) for a, b in zip(*rows, strict=True)]
                self.turn[k] = [tidy(c * b - s * a) for a, b in zip(*rows, strict=True)]
                return True
        return False

    def _explain(self, left: Sequence[int]) -> str:
        rows = ", ".join(self.ties[k].name for k in left)
        loops = any(not (self.ties[k].of_velocities or self.ties[k].of_contact) for k in left)
        remedy = "; reduce_loops keeps one coordinate of loops" if loops else ""
        return (
            f"mechanism {self.algebra.mechanism.name!r}: {rows} can be solved for no velocity "
            f"without a divisor that may vanish{remedy}"
        )

    def _explain_choice(self, kept: Sequence[str]) -> str:
        v, count = self.algebra.velocities, len(self.allowed.basis)
        got = ", ".join(map(coordinate_of, kept))
        free = [coordinate_of(v[k]) for k in self.kept]
        can = f"; {enumerate_words(free)} can be kept" if free else ""
        where = f"mechanism {self.algebra.mechanism.name!r}"
        if len(kept) == count:
            return f"{where}: without a divisor that may vanish, not all follows from {got}{can}"
        leave = "its constraints leave" if self.ties else "without constraints it has"
        return f"{where}: {leave} {count} of {len(v)} velocities free, got {got} to keep{can}"

    def _find_kept(self) -> tuple[int, ...]:
        """Return the velocity that each independent displacement is, none unless all are."""
        kept = list[int]()
        # with x' = z' the velocity that gives way has an entry of 1 as well
        gone = {k for _, u in self.allowed.pulls for k, entry in enumerate(u) if entry}
        for alone in list_alone(self.allowed.basis):
            kept += [i for i in alone if i not in gone][:1]
        return tuple(kept) if len(kept) == len(self.allowed.basis) else ()

    def _reach(self, rest: Sequence[Series]) -> Column:
        """Return p with A p + rest = 0."""
        if not self.A:
            return [self.ring.number(0)] * len(self.algebra.velocities)
        values = [-along_displacement(row, rest) for row in self.turn]
        return self.allowed.reach(self.ring, self.A, values)

    def _put(self, series: Series) -> Series:
        """Replace the velocities that follow from those that are kept."""
        values = self.followers
        terms = []
        for powers, coefficient in series.coefficients([*values]).items():
            factors = [x**e for x, e in zip(values.values(), powers, strict=True) if e]
            terms.append(prod(factors, start=coefficient))
        return tidy(self.ring.sum(terms))

    @cached_property
    def followers(self) -> dict[str, Series]:
        """The velocities that follow from those that are kept, by name."""
        v = self.algebra.velocities
        free = [self.ring[v[k]] for k in self.kept]
        columns = enumerate(zip(v, self.still, *self.allowed.basis, strict=True))
        return {
            name: tidy(along_displacement(parts, free) + p)
            for k, (name, p, *parts) in columns
            if self.kept and k not in self.kept
        }

    def solution(self, longest: float) -> EliminatedSolution:
        """Return the solution: that with fewer terms, as constraints allow several forms."""
        ways = [self._solve(gamma, rest, longest) for gamma, rest in self.sides]
        solved = [way for way in ways if way.accelerations]
        return min(solved, key=_count, default=ways[-1])

    def _solve(self, gamma: Sequence[Series], rest: Column, longest: float) -> EliminatedSolution:
        S, p = self.allowed.basis, self._reach(gamma)
        moved = [project(column, self.M) for column in S]
        fixed = [a + b for a, b in zip(project(p, self.M), rest, strict=True)]
        mass = [project(column, moved) for column in S]
        loads = project(fixed, S)
        names = self.algebra.accelerations
        shares = [*zip(*S, strict=True)] or [()] * len(p)
        wide = max((len(row[k]) for k, row in enumerate(mass)), default=1)
        terms = []
        for x, row in zip(p, shares, strict=True):
            products = sum(len(a) * len(b) for a, b in zip(row, loads, strict=True))
            terms.append(len(x) * wide + products)
        long = max(terms, default=0) > longest
        c = None if long else _solve_blocks(mass, [-load for load in loads])
        accelerations: dict[str, Quotient] = {}
        if c is not None:
            parts = zip(names, p, shares, strict=True)
            accelerations = self._shorten((name, _combine(x, row, c)) for name, x, row in parts)
        a = [self.ring[names[k]] for k in self.kept]
        pairs = zip(mass, loads, strict=True) if self.kept else ()
        rows = tuple(along_displacement(row, a) + load for row, load in pairs)
        return EliminatedSolution(
            tuple(self.algebra.velocities[k] for k in self.kept),
            rows,
            accelerations,
            self.followers,
            partial(self._forces, moved, fixed, c if accelerations else None, rows),
        )

    def _forces(
        self,
        moved: Sequence[Column],
        fixed: Column,
        c: Sequence[Quotient] | None,
        rows: Sequence[Series],
    ) -> tuple[dict[str, Quotient], tuple[Equation, ...]]:
        """Return the multipliers, those of M (S c + p) + h − Q, and sums of what is shared.

        Without a closed form of the accelerations, the rows of their equations may shorten them.
        """
        if not self.A:
            return {}, ()
        ring, names = self.ring, self.algebra.accelerations
        one = ring.number(1)
        if c is None:
            if len(self.kept) < len(moved):
                return {}, ()
            c = [Quotient(ring[names[k]], one) for k in self.kept]
        else:
            rows = ()
        weighed = [self._weigh(column) for column in (*moved, fixed)]
        # redundancy leaves the forces of these undetermined, up to multiples of these columns
        met = {row for row, _ in self.allowed.pulls}
        idle = list[Column]()
        for row in set(range(len(self.A))) - met:
            pairs = zip(self._weigh(self.A[row]), self.turn[row], strict=True)
            idle.append([tidy(other - own) for own, other in pairs])
        shared = {k for column in idle for k, share in enumerate(column) if not share.vanishes()}
        weights = zip(*weighed, strict=True)
        forces = self._shorten(
            (name_of(tie.multiplier), _combine(rest, factors, c))
            for k, (tie, (*factors, rest)) in enumerate(zip(self.ties, weights, strict=True))
            if k not in shared
        )
        sums = list[Equation]()
        for share in self._share(*idle) if forces and len(idle) == 1 else ():
            left = ring.sum([w * tie.multiplier for w, tie in zip(share, self.ties, strict=True)])
            *factors, rest = project(share, weighed)
            sums += [
                Equation(expression(tidy(left)), quotient.expression(), one)
                for quotient in self._shorten([("", _combine(rest, factors, c))], rows).values()
            ]
        return forces, tuple(sums)

    def _share(self, idle: Column) -> Iterator[Column]:
        """Yield weights: of friction across what balances itself, and of the sum along it."""
        names, nothing = [tie.name for tie in self.ties], self.ring.number(0)
        along, first = [nothing] * len(names), self.ring.number(1)
        for k, name in enumerate(names):
            if not (name.endswith("_x") and (other := f"{name[:-1]}y") in names):
                continue
            i = names.index(other)
            size = tidy(idle[k] ** 2 + idle[i] ** 2)
            if size.vanishes() or not is_constant(size):
                return
            x, y = tidy(-idle[i] / sqrt(size)), tidy(idle[k] / sqrt(size))
            if not any(along):
                first = x if x else y
            elif (first + (x if x else y)).vanishes():  # all have one sense
                x, y = -x, -y
            across = [nothing] * len(names)
            across[k], across[i], along[k], along[i] = x, y, -y, x
            yield across
        if along_displacement(along, idle).vanishes():
            yield along

    def _shorten(
        self, quotients: Iterable[tuple[str, Quotient]], rows: Sequence[Series] = ()
    ) -> dict[str, Quotient]:
        """Return quotients as short as the constraints and rows allow, none if one is long."""
        short, zeros = {}, (*self.rates, *rows)
        for name, quotient in quotients:
            if not quotient.bearable:
                return {}
            short[name] = Quotient(_shorten(quotient.above, zeros), quotient.below)
        return short

    def _weigh(self, forces: Column) -> Column:
        """Return the multipliers of the ties that balance forces."""
        weights = self.allowed.weigh(self.ring, self.A, forces)
        return project(weights, [*zip(*self.turn, strict=True)])


def _turn(name: str, x: Quotient, y: Quotient) -> Sequence[Equation]:
    """Return the components of a force in axes turned by an angle that halve its terms, if any."""
    ring = x.above.ring
    angles = {*x.above.turns(), *y.above.turns()}
    if not x.below == y.below == 1:
        return ()
    for angle, sense in product(sorted(angles), (1, -1)):
        turn = sense * ring.angles[angle].argument
        c, s = (function(wave)(turn) for wave in ("cos", "sin"))
        ahead, aside = tidy(c * x.above + s * y.above), tidy(c * y.above - s * x.above)
        if 2 * (len(ahead) + len(aside)) <= len(x.above) + len(y.above):
            along, across = ring[name], ring[f"{name[:-1]}y"]
            pairs = ((c * along + s * across, ahead), (c * across - s * along, aside))
            one = ring.number(1)
            return [Equation(expression(a), expression(b), one) for a, b in pairs]
    return ()


def find_still(derivation: Derivation) -> dict[str, Series]:
    """Return the coordinates that the constraints hold at zero, such as the roll of a cart."""
    algebra = derivation.algebra
    ring, names = algebra.ring, algebra.mechanism.coordinates
    gaps = [tie.demand for tie in derivation.ties if not tie.of_velocities]
    for name in names:  # a coordinate with a constant slope follows from the others
        slopes = [gap.diff(name) for gap in gaps]
        k = next((k for k, slope in enumerate(slopes) if is_constant(slope)), None)
        if k is not None:
            pivot = gaps.pop(k)
            others = [slope / slopes[k] for i, slope in enumerate(slopes) if i != k]
            gaps = [tidy(gap - share * pivot) for gap, share in zip(gaps, others, strict=True)]
    zeros = dict[str, Series]()
    for gap in gaps:
        held = {g.name for g in gap.generators() if g.kind in (Kind.COORDINATE, Kind.TIME)}
        if len(held) == 1 and (name := held.pop()) in names:
            here = Substitution({name: ring.number(0)}, {})
            if here(gap).vanishes() and not here(gap.diff(name)).vanishes():
                zeros |= {name: ring.number(0), f"{name}'": ring.number(0)}
    return zeros


def _shorten(series: Series, rates: Sequence[Series]) -> Series:
    """Subtract multiples of what constraints keep zero, as long as half of the terms fall away."""
    for rate in rates:
        for share in _list_shares(series, rate):
            rest = tidy(series - share * rate)
            if 2 * len(rest) <= len(series):
                return _shorten(rest, rates)
    return series


def _level(rows: Sequence[Column], rates: Sequence[Series]) -> Iterator[Series]:
    """Yield pairs of rates in axes that turn, put together along the velocities they turn from."""
    for i, k in combinations(range(len(rows)), 2):
        for c, s in zip(rows[i], rows[k], strict=True):
            if not (is_constant(c) or is_constant(s)) and is_constant(tidy(c * c + s * s)):
                yield tidy(c * rates[i] + s * rates[k])


def _list_shares(series: Series, rate: Series) -> Iterator[Series]:
    """Yield monomials by which a term of the rate is a term of the series."""
    ring, seen = series.ring, set[tuple[int, Fraction]]()
    for trig, monomial, c in rate.terms():
        for other, whole, size in series.terms():
            share = whole - monomial, size / c
            if other != trig or share in seen:
                continue
            # what may vanish is not divided by
            if all(e > 0 or ring.generators[i].kind in GIVEN for i, e in exponents(share[0])):
                seen.add(share)
                yield canonical(ring, {0: {share[0]: 1}}, 1, series.reach) * share[1]


def _count(solution: EliminatedSolution) -> int:
    """Return the number of terms of a solution."""
    quotients = (*solution.accelerations.values(), *solution.forces.values())
    return sum(len(quotient.above) + len(quotient.below) for quotient in quotients)


def _solve_blocks(M: Sequence[Sequence[Series]], loads: Sequence[Series]) -> list[Quotient] | None:
    """Solve M c = loads for accelerations that depend on each other, block by block."""
    quotients: dict[int, Quotient] = {}
    waiting = list(range(len(M)))
    while waiting:
        block, edge = set[int](), {waiting[0]}
        while edge:
            block |= edge
            edge = {j for k in edge for j, entry in enumerate(M[k]) if entry} - block
        rows = sorted(block)
        waiting = [k for k in waiting if k not in block]
        part = select([M[i] for i in rows], rows)
        sides = [loads[i] for i in rows]
        # the product of three rows may have the product of their lengths
        if len(rows) > _MOST_COUPLED or prod(max(map(len, row)) for row in part) > _MOST_PRODUCTS:
            return None
        below = determinant(M[0][0].ring, part)
        if below.vanishes() or len(below) > LONGEST_ABOVE or max(map(len, sides)) > LONGEST_ABOVE:
            return None
        for k, above in zip(rows, cramer(below.ring, part, sides), strict=True):
            quotients[k] = reduce_quotient(above, below)
    return [quotients[k] for k in range(len(M))]


def _combine(first: Series, factors: Sequence[Series], c: Sequence[Quotient]) -> Quotient:
    """Return first + Σ factor × c over one denominator."""
    below = first.ring.number(1)
    above = first
    for factor, quotient in zip(factors, c, strict=True):
        if not factor or not quotient.above:
            continue
        if quotient.below == below:
            above = above + factor * quotient.above
        else:
            above = above * quotient.below + factor * quotient.above * below
            below = below * quotient.below
        reduced = reduce_quotient(above, below)
        above, below = reduced.above, reduced.below
    return Quotient(tidy(above), below)


def reduce_quotient(above: Series, below: Series) -> Quotient:
    """Cancel what numerator and denominator share, as far as it is found."""
    above, below = tidy(above), tidy(below)
    one = above.ring.number(1)
    if not above or above.vanishes():
        return Quotient(one.ring.number(0), one)
    if is_constant(below):
        return Quotient(tidy(above / below), one)
    whole = divide_exactly(above, below)
    if whole is not None:
        return Quotient(whole, one)
    above, below = divide_common(divide_waves(_clear_divisors(one.ring, [above, below])))
    if is_constant(below):
        return Quotient(tidy(above / below), one)
    below, above = make_positive([below, above])
    return Quotient(above, below)


def _clear_divisors(ring: Ring, fraction: Column) -> Column:
    """Multiply numerator and denominator by what their terms are divided by, if that removes it."""
    for index, atom in ring.atoms.items():
        least = find_least_power(fraction, index)
        if least < 0 and atom.function == "1":
            divisor = ring.monomial(power(index, -least))
            cleared = [tidy(divisor * series) for series in fraction]
            if find_least_power(cleared, index) == 0:
                fraction = cleared
    return fraction


def find_least_power(column: Column, index: int) -> int:
    """Return the lowest power of a generator in series, 0 at most."""
    powers = (exponent(monomial, index) for series in column for _, monomial, _ in series.terms())
    return min(powers, default=0)
