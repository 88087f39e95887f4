"""Say what a book says after the equations of motion: of small motions about a position of rest."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from contextlib import suppress
from fractions import Fraction
from itertools import combinations
from math import factorial
from typing import Any, final

import numpy as np

from mecanique.derivation.linear import Linear, linear, linearize_at
from mecanique.derivation.printing.equations import expression
from mecanique.derivation.printing.expressions import to_formula, to_power
from mecanique.derivation.printing.formulas import Call, Sum, add, multiply
from mecanique.derivation.printing.writers import (
    Equation,
    Expression,
    OverRoot,
    Printed,
    Relation,
    Root,
)
from mecanique.derivation.scalars.cancel import tidy
from mecanique.derivation.scalars.elementary import cos, sqrt
from mecanique.derivation.scalars.evaluation import Substitution, evaluate
from mecanique.derivation.scalars.polynomials import exponents, power
from mecanique.derivation.scalars.series import TIMED, Kind, Series, canonical
from mecanique.derivation.symbolic.derivation import (
    NO_ENDING,
    Derivation,
    Ending,
    Matrix,
    Result,
)
from mecanique.derivation.symbolic.kinematics import Kinematics
from mecanique.derivation.symbolic.lagrange import ENERGY_INTEGRAL, Lagrange
from mecanique.derivation.symbolic.multipliers import (
    Quotient,
    cramer,
    determinant,
    divide_common,
    divide_waves,
    is_constant,
    make_positive,
    name_of,
)
from mecanique.derivation.symbolic.reduced import Routh, reduce_by_momenta
from mecanique.derivation.symbolic.solution import find_least_power, reduce_quotient
from mecanique.derivation.tolerances import INDEPENDENT
from mecanique.errors import DerivationError
from mecanique.model.mechanism import Mechanism
from mecanique.model.mechanism_units import units
from mecanique.wording import enumerate_words

# Say what a book says of motions with cyclic coordinates and one that is not: steady rotation.
#
# With constant momenta the one coordinate x moves as if alone, M x'' + F = 0 with F the slope of
# the effective potential. Where F = 0 it can stay, and oscillates nearby with ω² = F'/M (E. J.
# Routh, Advanced Rigid Dynamics, 1905; Goldstein, Classical Mechanics, 3rd ed., sects. 3.6-3.8 and
# 5.7).

_ROTATION = "Steady rotation"
_PRECESSION = "Steady precession"
_STAYS = (
    "With {0} constant, V_eff has a stationary value; about it {0} oscillates with the natural "
    "frequency omega."
)
_CLOSED = " It is the rate of {}, so that the path is closed."
_CONIC = (
    "The path is a conic with the eccentricity e, an ellipse if E < 0. Its radius sweeps equal "
    "areas in equal times; an ellipse of period tau has the semi-major axis a: Kepler's laws."
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


_MOST_COUPLED = 4
"""Equations of small motions that are listed."""

_LONGEST = 12
"""Most terms of a frequency equation."""

_TITLE = "Small motions"
_LAST = 100
"""Place of a frequency in a product of letters."""
_NEAR = "Deviations from the position of rest {} obey {} to first order."
_BOTH = "The squares of both natural frequencies are the roots of the last equation."
_VIBRATION = "Steady vibration"
_DRIVEN = "Driven harmonically, it vibrates at the rate {} once its free motion has died away."
_RESONANT = "{} has a greatest value where the inequality holds."
_SINGLE = "One motion meets no force, the other has the natural frequency of the last line."
_FREE = "Left to itself, it oscillates with the natural frequency of its linear equation."
_DAMPED = (
    "Without damping it would oscillate with the natural frequency omega. Left to itself, it does "
    "with omega sqrt(1 - zeta^2) where zeta < 1, and its amplitude falls as exp(-zeta omega t)."
)
_SHAPES = "In the first mode {}, in the second {}."
_OMEGA = {"omega": "natural angular frequency [rad/s]"}
_FIGURES = _OMEGA | {"zeta": "damping ratio"}


def special_motions_of(derivation: Derivation) -> tuple[Ending, ...]:
    """Return what the equations of motion come to in special motions, each with its title."""
    endings = list[Ending]()
    mechanism, velocities = derivation.algebra.mechanism, derivation.algebra.velocities
    simple = derivation.written is None and not derivation.ties
    if simple and tuple(velocities) == tuple(f"{name}'" for name in mechanism.coordinates):
        with suppress(DerivationError):
            endings.append(_find_small_motions(derivation))
        with suppress(DerivationError):
            endings.append(_find_steady_vibration(derivation))
        with suppress(DerivationError):
            endings += rotations_of(mechanism)
    # a letter that the mechanism has for something else would be read as that
    known = {*mechanism.values, *mechanism.coordinates}
    return tuple(x for x in endings if x.lines and known.isdisjoint(x.unknowns))


def _find_small_motions(derivation: Derivation) -> Ending:
    """Return linear equations about the position of rest with angles zero, and frequencies."""
    values = derivation.algebra.mechanism.values
    place = _find_rest(derivation)
    small = linearize_at(derivation, place, {})
    K = _evaluate(small.matrices.K, values)
    if not K.any() or np.linalg.eigvalsh(K)[0] < -INDEPENDENT * abs(K).max():
        return NO_ENDING
    said, lines = list[str](), list[Printed]()
    single = len(place) == 1
    if linear(derivation) is not None:
        said += [_FREE] if single and small.ratio is None else []
    elif len(place) <= _MOST_COUPLED:
        moved = [f"{name} = {expression(x).text()}" for name, x in place.items() if x]
        zero = [name for name, x in place.items() if not x]
        moved += [" = ".join([*zero, "0"])] if zero else []
        obeyed = "a linear equation" if single else "linear equations"
        said.append(_NEAR.format(enumerate_words(moved), obeyed))
        lines += small.equations
    if single and not {"omega", "zeta"} & {*values}:
        figures = small.figures
        said += [_DAMPED] if figures[1:] else []
        unknowns = _FIGURES if figures[1:] else _OMEGA
        return Ending(" ".join(said), (*lines, *figures), unknowns, _TITLE)
    undamped = not any(map(any, small.matrices.C))
    modes = _find_modes(small.matrices, values) if undamped else NO_ENDING
    said += [modes.sentence] if modes.sentence else []
    return Ending(" ".join(said), (*lines, *modes.lines), modes.unknowns, _TITLE)


def _find_modes(matrices: Linear, values: Mapping[str, float]) -> Ending:
    """Return the natural frequencies of uncoupled coordinates, or of two with their shapes."""
    names, M, K = matrices.names, matrices.M, matrices.K
    ring = M[0][0].ring
    zero, one = ring.number(0), ring.number(1)

    def letter(index: int | str) -> Series:
        return ring.unknown(f"omega_{index}", Kind.PARAMETER)

    def state(squares: dict[Any, Series], sentence: str) -> Ending:
        lines = [Result(letter(index) ** 2, square) for index, square in squares.items()]
        meaning = "natural angular frequency [rad/s]"
        return Ending(sentence, tuple(lines), {f"omega_{i}": meaning for i in squares})

    size = range(len(names))
    if not any(M[i][k] or K[i][k] for i, k in combinations(size, 2)):
        diagonal = {name: tidy(K[i][i] / M[i][i]) for i, name in enumerate(names)}
        return state(diagonal, "These motions are independent of each other.")
    if len(names) != 2:
        return NO_ENDING
    (a, b), (_, c) = M
    (d, e), (_, f) = K
    # det (K - s M) = A s^2 - B s + C
    A, B, C = divide_common([tidy(a * c - b * b), tidy(a * f + c * d - 2 * b * e), d * f - e * e])
    root = sqrt(tidy(B * B - 4 * A * C))
    if "omega" in values:
        return NO_ENDING
    s = ring.unknown("omega", Kind.PARAMETER) ** 2
    ring.places["omega"] = _LAST
    if not C:
        return Ending(_SINGLE, (Result(s, tidy(B / A)),), _OMEGA)
    if Kind.ATOM in root.kinds:
        if len(A) + len(B) + len(C) > _LONGEST:
            return NO_ENDING
        terms = [multiply(to_formula(x), to_formula(y)) for x, y in ((A, s * s), (-B, s), (C, one))]
        line = Equation(Expression(tuple(terms)), expression(zero), one)
        return Ending(_BOTH, (line,), _OMEGA)
    squares = [tidy((B + sign * root) / (2 * A)) for sign in (-1, 1)]
    squares.sort(key=lambda square: float(evaluate(square, values)))
    shapes = [tidy(-(d - s * a) / (e - s * b)) * ring[names[0]] for s in squares]
    said = _SHAPES.format(*(f"{names[1]} = {expression(shape).text()}" for shape in shapes))
    return state(dict(enumerate(squares, 1)), said)


def _find_steady_vibration(derivation: Derivation) -> Ending:
    """Return amplitude, resonance and transmissibility of a single driven oscillator.

    In complex amplitudes, (K - M W^2 + i C W) A = f (W. T. Thomson, Theory of Vibration, ch. 3).
    """
    matrices, mechanism = linear(derivation), derivation.algebra.mechanism
    if matrices is None or len(matrices.names) != 1 or len(matrices.f[0].parts) != 1:
        return NO_ENDING
    ((M,),), ((C,),), ((K,),), (f,) = matrices.M, matrices.C, matrices.K, matrices.f
    ring, (name,), (wave,) = M.ring, mechanism.coordinates, f.parts
    turns = [ring.angles[j].argument * count for j, count in exponents(wave >> 1)]
    force, rate = _take_wave(f, wave), ring.sum(turns).diff("t")
    if not turns or TIMED & {*force.kinds, *rate.kinds} or not K:
        return NO_ENDING
    elastic, damping = tidy(K - M * rate**2), tidy(C * rate)
    below = _square(elastic, damping)
    amplitude = f"A_{name}"
    size = OverRoot(amplitude, expression(_lead(force)), Expression(below.terms))
    lines: list[Printed] = [size if damping else _divide(amplitude, force, elastic)]
    meanings = {amplitude: f"amplitude of {name} [{units(mechanism)[name]}]"}
    if damping:
        phase = f"phi_{name}"
        tangent = Call("tan", add([to_formula(ring.unknown(phase, Kind.PARAMETER))]))
        ratio = Quotient(*divide_common([damping, elastic])).expression()
        lines.append(Relation(Expression((multiply((tangent, 1)),)), "=", ratio))
        meanings[phase] = f"angle by which {name} lags behind its force [rad]"
    kinematics = Kinematics(derivation.algebra)
    for body in (body for body in mechanism.bodies if derivation.algebra.series(body.mass)):
        for axis, place in zip("xyz", kinematics.point(body.name, body.center), strict=True):
            base, share = _take_wave(tidy(place), wave), place.diff(name)
            if base and is_constant(share):
                passed = tidy(share * force / base + elastic)
                transmissibility = f"H_{body.name}_{axis}"
                square = Expression((multiply((_square(passed, damping), 1), (below, -1)),))
                root = Root(transmissibility, square)
                lines.append(root if damping else _divide(transmissibility, passed, elastic))
                meanings[transmissibility] = (
                    f"amplitude of {body.name} along {axis} over that of what drives it"
                )
    said = _DRIVEN.format(expression(rate).text())
    resonance = _find_resonance((M, C, K), force, rate, mechanism.values)
    if resonance is not None:
        lines.append(resonance)
        grown = "is greatest" if damping else "grows without bound"
        meanings[resonance.name] = f"{expression(rate).text()} at which {amplitude} {grown}"
        if C and resonance.square != expression(tidy(K / M)):
            said += f" {_RESONANT.format(amplitude)}"
            lines.append(Relation(expression(C * C), "<", expression(tidy(2 * K * M))))
    return Ending(said, tuple(lines), meanings, _VIBRATION)


def _take_wave(series: Series, wave: int) -> Series:
    """Return the factor of a sine or cosine, given by its key."""
    parts = {0: series.parts[wave]} if wave in series.parts else {}
    return canonical(series.ring, parts, series.denominator, series.reach)


def _lead(series: Series) -> Series:
    return make_positive([series])[0]


def _divide(name: str, above: Series, below: Series) -> Relation:
    """Return the size of an undamped amplitude."""
    left = expression(above.ring.unknown(name, Kind.PARAMETER))
    size = Call("Abs", add(expression(_lead(below)).terms))
    return Relation(left, "=", Expression((multiply(to_formula(_lead(above)), (size, -1)),)))


def _square(real: Series, imaginary: Series) -> Sum:
    """Return the square of the size of a complex number."""
    terms = [multiply((add(expression(_lead(real)).terms), 2)), to_formula(imaginary**2)]
    return add(term for term in terms if term.number)


def _find_resonance(
    matrices: tuple[Series, Series, Series],
    force: Series,
    rate: Series,
    values: Mapping[str, float],
) -> Root | None:
    """Return the rate of a force proportional to 1, W or W^2 at which the amplitude is greatest."""
    # with s = W^2 the square of the amplitude is s^n/((K - M s)^2 + C^2 s)
    M, C, K = matrices
    if not rate.is_unit or len(rate.generators()) != 1:
        return None
    letter = rate.generators()[0].name
    powers = [n for (n,) in force.coefficients([letter])]
    twice = tidy(2 * K * M - C * C)
    squares = {0: (twice, 2 * M * M), 1: (K, M), 2: (2 * K * K, twice)}
    if len(powers) > 1 or powers[0] not in squares or rate != M.ring[letter]:
        return None
    above, below = squares[powers[0]]
    if not evaluate(tidy(above / below), values) > 0:
        return None
    return Root(f"{letter}_r", Quotient(*divide_common([above, below])).expression())


def _evaluate(rows: Matrix, values: Mapping[str, float]) -> np.ndarray:
    def read(entry: Series) -> float:
        return float(evaluate(entry, values))

    return np.array([list(map(read, row)) for row in rows])


def _find_rest(derivation: Derivation) -> dict[str, Series]:
    """Return the position of rest with as many coordinates zero as can be, for all parameters."""
    algebra = derivation.algebra
    ring, names = algebra.ring, list(algebra.mechanism.coordinates)
    values, zero = algebra.mechanism.values, ring.number(0)
    moving = (*algebra.velocities, *algebra.accelerations)
    still = dict.fromkeys(moving, zero)
    place = dict.fromkeys(names, zero)
    forces = [h - Q for h, Q in zip(derivation.h, derivation.Q, strict=True)]

    def balance(put: Substitution) -> list[Series]:
        return [tidy(_drop_time(put(force))) for force in forces]

    pushed = [k for k, rest in enumerate(balance(Substitution(place | still, values))) if rest]
    if pushed:
        free = [names[k] for k in pushed]
        others = {name: x for name, x in place.items() if name not in free}
        near = {**values, **dict.fromkeys(free, 0.0)}  # which of two roots a length is
        forces_near = balance(Substitution(others | still, near))
        rows = [forces_near[k] for k in pushed]
        slopes, rests = zip(*(row.linear(free) for row in rows), strict=True)
        below = determinant(ring, slopes)
        for name, above in zip(free, cramer(ring, slopes, [-x for x in rests]), strict=True):
            place[name] = tidy(above / below)
        # a coordinate that is within a function, too, is not solved for
        implicit = any(g.name in free for name in free for g in place[name].generators())
        if implicit or any(balance(Substitution(place | still, values))):
            raise DerivationError("its rest is not at zero, nor given by linear equations")
    return place


def _drop_time(force: Series) -> Series:
    """Return the terms of a force that do not change with time."""
    ring = force.ring
    terms = []
    for trig, monomial, c in force.terms():
        term = Series(ring, {trig: {monomial: c.numerator}}, c.denominator, force.reach)
        terms += [] if term.kinds & TIMED else [term]
    return ring.sum(terms)
