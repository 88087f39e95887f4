"""Say what a book says after the equations of motion: of small motions about a position of rest."""

from __future__ import annotations

from collections.abc import Mapping
from contextlib import suppress
from itertools import combinations
from typing import Any

import numpy as np

from mecanique.derivation.linear import Linear, linear, linearize_at
from mecanique.derivation.printing.equations import expression
from mecanique.derivation.printing.expressions import to_formula
from mecanique.derivation.printing.formulas import Call, Sum, add, multiply
from mecanique.derivation.printing.writers import (
    Equation,
    Expression,
    OverRoot,
    Printed,
    Relation,
    Root,
)
from mecanique.derivation.rotations import rotations_of
from mecanique.derivation.scalars.cancel import tidy
from mecanique.derivation.scalars.elementary import sqrt
from mecanique.derivation.scalars.evaluation import Substitution, evaluate
from mecanique.derivation.scalars.polynomials import exponents
from mecanique.derivation.scalars.series import TIMED, Kind, Series, canonical
from mecanique.derivation.symbolic.derivation import (
    NO_ENDING,
    Derivation,
    Ending,
    Matrix,
    Result,
)
from mecanique.derivation.symbolic.kinematics import Kinematics
from mecanique.derivation.symbolic.multipliers import (
    Quotient,
    cramer,
    determinant,
    divide_common,
    is_constant,
    make_positive,
)
from mecanique.derivation.tolerances import INDEPENDENT
from mecanique.errors import DerivationError
from mecanique.model.mechanism_units import units
from mecanique.wording import enumerate_words

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
        said += [_FREE] if single else []
    elif len(place) <= _MOST_COUPLED:
        moved = [f"{name} = {expression(x).text()}" for name, x in place.items() if x]
        zero = [name for name, x in place.items() if not x]
        moved += [" = ".join([*zero, "0"])] if zero else []
        obeyed = "a linear equation" if single else "linear equations"
        said.append(_NEAR.format(enumerate_words(moved), obeyed))
        lines += small.equations
    if single and not {"omega", "zeta"} & {*values}:
        figures = small.figures
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
