"""Say what a book says of motions with cyclic coordinates and one that is not: steady rotation.

With constant momenta the one coordinate x moves as if alone, M x'' + F = 0 with F the slope of the
effective potential. Where F = 0 it can stay, and oscillates nearby with ω² = F'/M (E. J. Routh,
Advanced Rigid Dynamics, 1905; Goldstein, Classical Mechanics, 3rd ed., sects. 3.6-3.8 and 5.7).
"""

from __future__ import annotations

from collections.abc import Iterator
from fractions import Fraction
from math import factorial
from typing import final

from mecanique.derivation.printing.equations import expression
from mecanique.derivation.printing.expressions import to_formula, to_power
from mecanique.derivation.printing.formulas import multiply
from mecanique.derivation.printing.writers import (
    Equation,
    Expression,
    Printed,
    Relation,
    Root,
)
from mecanique.derivation.scalars.cancel import tidy
from mecanique.derivation.scalars.elementary import cos, sqrt
from mecanique.derivation.scalars.evaluation import Substitution
from mecanique.derivation.scalars.polynomials import power
from mecanique.derivation.scalars.series import Kind, Series
from mecanique.derivation.symbolic.derivation import NO_ENDING, Ending, Result
from mecanique.derivation.symbolic.lagrange import ENERGY_INTEGRAL, Lagrange
from mecanique.derivation.symbolic.multipliers import (
    Quotient,
    divide_common,
    divide_waves,
    is_constant,
    make_positive,
    name_of,
)
from mecanique.derivation.symbolic.reduced import Routh, reduce_by_momenta
from mecanique.derivation.symbolic.solution import find_least_power, reduce_quotient
from mecanique.model.mechanism import Mechanism
from mecanique.model.mechanism_units import units
from mecanique.wording import enumerate_words

_ROTATION = "Steady rotation"
_PRECESSION = "Steady precession"
_STAYS = (
    "With {0} constant, V_eff has a stationary value; about it {0} oscillates with the natural "
    "frequency omega."
)
_CLOSED = " It is the rate of {}, so that the path is closed."
_CONIC = (
    "The path is a conic with the eccentricity e, an ellipse if E < 0. Its radius sweeps equal "
    "areas in equal times; tau is the period of an ellipse with the semi-major axis a (Kepler)."
)
_CONIC_LETTERS = {
    "e": "eccentricity",
    "a": "semi-major axis [m]",
    "tau": "period [s]",
}
_PRECESSES = (
    "With {0} constant, {1} obeys a quadratic equation, whose roots are real where the inequality "
    "holds. For large {2} one precession is slow, the other fast{3}."
)
_NODS = "; about the slow one {} oscillates with nearly the frequency omega (nutation)"
_SLEEPS = "Upright, with {0} = {1}, it is stable where the last line holds: the top sleeps."
_OMEGA = {"omega": "natural angular frequency [rad/s]"}
_HIGHEST = 12
"""Order up to which a force is expanded about an upright axis."""


def rotations_of(mechanism: Mechanism) -> list[Ending]:
    """Return steady rotations, orbits and precessions of a mechanism with one other coordinate."""
    lagrange = Lagrange(mechanism, named=True)
    routh = reduce_by_momenta(lagrange)
    titles = [stage.title for stage in routh.derivation.stages]
    if len(routh.parts) != 1 or ENERGY_INTEGRAL not in titles:
        return []
    rotation = _Rotation(lagrange, routh)
    return [ending for ending in rotation.list_endings() if ending.lines]


@final
class _Rotation:
    """A mechanism whose coordinates are cyclic but for one, x."""

    def __init__(self, lagrange: Lagrange, routh: Routh) -> None:
        self._lagrange, self._ignored = lagrange, routh.ignored
        derivation, algebra = routh.derivation, lagrange.algebra
        self._ring = algebra.ring
        cyclic = {coordinate.name for coordinate in routh.ignored}
        (self._x,) = (name for name in algebra.mechanism.coordinates if name not in cyclic)
        self._unit = units(algebra.mechanism)[self._x]
        still = {f"{self._x}'": self._ring.number(0)}
        self._still = Substitution(still, algebra.mechanism.values)
        self._inertia = next(entry for entry in derivation.M[0] if entry)
        self._force = self._still(derivation.h[0])

    def list_endings(self) -> Iterator[Ending]:
        """Yield what a book says of them."""
        if len(self._ignored) == 2:
            yield self._precess()
        elif self._force.turns():
            yield self._turn()
        else:
            yield from self._orbit()

    def _turn(self) -> Ending:
        """Return the steady rotation at any x, and the oscillation about it, of one angle."""
        # V_eff = p^2/(2 I) + V has the slope 0 where w^2 = 2 V'/I', and there the slope of F is
        # 2 V' I'/I - V' I''/I' + V''
        (turning,), x = self._ignored, self._x
        if turning.rest:
            return NO_ENDING
        I, V = turning.inertia, self._lagrange.V
        first, second, fall = I.diff(x), I.diff(x).diff(x), V.diff(x)
        if not first:
            return NO_ENDING
        square = reduce_quotient(2 * fall, first)
        slope = 2 * fall * first * first - fall * second * I + fall.diff(x) * I * first
        omega = reduce_quotient(slope, I * first * self._inertia)
        lines = (Root(f"{turning.name}'", square.expression()), Root("omega", omega.expression()))
        return Ending(_STAYS.format(x), lines, _OMEGA, _ROTATION)

    def _orbit(self) -> Iterator[Ending]:
        """Yield the steady rotation where F is a sum of two powers of x, and conics."""
        ring, x = self._ring, self._x
        powers = {n: part for (n,), part in self._force.coefficients([x]).items()}
        low, high = min(powers), max(powers)
        several = len(powers) == 2 and (high - low == 1 or high == 1)
        if not several or not all(map(is_constant, (*powers.values(), self._inertia))):
            return
        # at A x^low + B x^high = 0 the slope of F is (high - low) B x^(high - 1)
        A, B, step = powers[low], powers[high], high - low
        place, start = tidy(-A / B), ring.unknown(f"{x}_0", Kind.PARAMETER)
        lines: list[Printed] = [Result(start**step, place)]
        square = tidy(step * B * place ** (0 if high == 1 else low) / self._inertia)
        put = Substitution({x: place if step == 1 else start}, {})
        rates = {v.name: put(v.rate) for v in self._ignored}
        lines += [Result(ring[f"{name}'"], rate) for name, rate in rates.items()]
        said = _STAYS.format(x)
        equal = [name for name, rate in rates.items() if tidy(rate * rate) == square]
        said += _CLOSED.format(enumerate_words(equal)) if equal else ""
        omega = sqrt(square)
        exact = Result(ring.unknown("omega", Kind.PARAMETER), omega)
        lines.append(Root("omega", expression(square)) if Kind.ATOM in omega.kinds else exact)
        meanings = {f"{x}_0": f"constant {x} [{self._unit}]"} | _OMEGA
        yield Ending(said, tuple(lines), meanings, _ROTATION)
        (turning, *_) = self._ignored
        stated = "E" in self._lagrange.algebra.mechanism.values
        if (
            (low, high) == (-3, -2)
            and not stated
            and tidy(turning.inertia / ring[x] ** 2) == self._inertia
        ):
            yield self._draw_conic(B, place)

    def _draw_conic(self, pull: Series, place: Series) -> Ending:
        """Return the path r = r_0/(1 + e cos(phi - phi_0)) in the potential -k/r, k = pull."""
        ring, (turning,) = self._ring, self._ignored
        e, a, E, tau, since = (
            ring.unknown(name, Kind.PARAMETER)
            for name in ("e", "a", "E", "tau", f"{turning.name}_0")
        )
        path = 1 + e * cos(ring[turning.name] - since)
        eccentricity = to_formula(ring.number(1)), to_formula(tidy(2 * E * place / pull))
        area = tidy(ring[self._x] ** 2 * ring[f"{turning.name}'"] / 2)
        pi = ring.constant("pi")
        lines = (
            Quotient(ring[f"{self._x}_0"], path).equate(self._x),
            Root("e", Expression(eccentricity)),
            Result(area, tidy(turning.momentum / self._inertia / 2)),
            Result(a, tidy(-pull / E / 2)),
            Result(tau**2, tidy(4 * pi**2 * a**3 * self._inertia / pull)),
        )
        closest = {f"{turning.name}_0": f"{turning.name} of the least {self._x} [rad]"}
        return Ending(_CONIC, lines, _CONIC_LETTERS | closest, "Orbit")

    def _precess(self) -> Ending:
        """Return the steady precession of what spins, and where it is stable upright."""
        ring, x, (spin, turning) = self._ring, self._x, self._ignored
        put = Substitution({f"{spin.name}'": ring.number(0)}, {})
        kinetic = self._still(put(self._lagrange.T))
        if not spin.folded or not spin.rest:
            return NO_ENDING
        balance = -(kinetic - self._still(spin.energy) - self._lagrange.V).diff(x)
        rate = f"{turning.name}'"
        powers = {n: part for (n,), part in tidy(balance).coefficients([rate]).items()}
        if sorted(powers) != [0, 1, 2]:
            return NO_ENDING
        C, B, A = divide_common(divide_waves(make_positive([powers[n] for n in (0, 1, 2)])))
        p, one = spin.momentum, ring.number(1)
        b = tidy(B / p)
        if not all(map(is_constant, (b, C))):
            return NO_ENDING
        v = ring[rate]
        terms = [multiply(to_formula(y), to_formula(z)) for y, z in ((A, v * v), (B, v), (C, one))]
        least = reduce_quotient(4 * A * C, b * b)
        lines: list[Printed] = [
            Equation(Expression(tuple(terms)), expression(ring.number(0)), one),
            Relation(expression(p**2), "≥", least.expression()),
            Relation(expression(v), "≈", reduce_quotient(-C, B).expression()),
            Relation(expression(v), "≈", reduce_quotient(-B, A).expression()),
        ]
        nods = "omega" not in self._lagrange.algebra.mechanism.values
        lines += [self._nod()] if nods else []
        said = _PRECESSES.format(x, rate, name_of(p), _NODS.format(x) if nods else "")
        upright = self._sleep()
        if upright is not None:
            said += " " + _SLEEPS.format(name_of(p), name_of(turning.momentum))
            lines.append(upright)
        return Ending(said, tuple(lines), _OMEGA if nods else {}, _PRECESSION)

    def _nod(self) -> Relation:
        """Return the frequency of nutation about a slow precession of what spins fast."""
        # V_eff = (p - B)^2/(2 D) + V with B proportional to the large momentum, so that there
        # p = B nearly, and the slope of F is B'^2/D
        omega, turning = self._ring.unknown("omega", Kind.PARAMETER), self._ignored[1]
        slope = make_positive([turning.left.diff(self._x)])[0]
        square = reduce_quotient(slope * slope, turning.inertia * self._inertia)
        above, below = sqrt(square.above), sqrt(square.below)
        if Kind.ATOM not in above.kinds | below.kinds:
            return Relation(expression(omega), "≈", Quotient(above, below).expression())
        under = (to_power(to_formula(x), Fraction(-1)) for x in (turning.inertia, self._inertia))
        size = Expression((multiply(to_formula(slope * slope), *under),))
        return Relation(expression(omega * omega), "≈", size)

    def _sleep(self) -> Relation | None:
        """Return the condition on p at which a spinning axis is stable at x = 0."""
        # with equal momenta F has a limit F'(0) x, found from its numerator and its divisors
        ring, x, (spin, turning) = self._ring, self._x, self._ignored
        equal = Substitution({name_of(turning.momentum): spin.momentum}, {})
        above, below = equal(self._force), ring.number(1)
        for index, atom in ring.atoms.items():
            least = find_least_power([above], index)
            if least < 0 and atom.function == "1" and atom.argument.diff(x):
                above = tidy(above * ring.monomial(power(index, -least)))
                below = below * atom.argument**-least
        m, second = self._expand(below)
        n, first = self._expand(above) if m else (0, second)
        if n - m != 1:
            return None
        slope = tidy(first / second * Fraction(factorial(m), factorial(n)))
        p = name_of(spin.momentum)
        powers = {k: part for (k,), part in slope.coefficients([p]).items()}
        if sorted(powers) != [0, 2]:
            return None
        square = reduce_quotient(-powers[0], powers[2])
        return Relation(expression(spin.momentum**2), ">", square.expression())

    def _expand(self, series: Series) -> tuple[int, Series]:
        """Return the first derivative by x that does not vanish at x = 0, with its order."""
        put = Substitution({self._x: self._ring.number(0)}, {})
        for order in range(_HIGHEST):
            if value := put(series):
                return order, value
            series = series.diff(self._x)
        return _HIGHEST, series
