"""Apply elementary functions to Poisson series: exactly where possible, otherwise as atoms."""

from __future__ import annotations

import math
from collections.abc import Callable
from fractions import Fraction
from functools import partial
from typing import Any

import numpy as np

from mecanique.derivation.scalars.polynomials import exponent, exponents, power
from mecanique.derivation.scalars.series import GIVEN, Kind, Ring, Series, canonical
from mecanique.derivation.tolerances import MEASURED
from mecanique.errors import DerivationError
from mecanique.model.expression import numpy_function
from mecanique.program.sweeps import SLOPES


def of_series(name: str, *arguments: Any) -> Series:
    """Apply a function, given by name, to series."""
    (series,) = arguments if len(arguments) == 1 else (None,)
    if not isinstance(series, Series) or name not in SLOPES:
        raise DerivationError(f"{name} has no closed form in a series; use the numeric derivation")
    if name in _EXACT:
        return _EXACT[name](series)
    if not series and name in _AT_ZERO:
        return series.ring.number(_AT_ZERO[name])

    def slope(f: Series) -> Series:
        derivative: Series = SLOPES[name](f, series, lambda other: partial(of_series, other))
        return derivative

    return series.ring.adjoin(name, series, slope, numpy_function(name))


def sin(series: Series) -> Series:
    """Return the sine of a sum of integer multiples of angles and a rational multiple of π."""
    return _circular(series, 1)


def cos(series: Series) -> Series:
    """Return the cosine of a sum of integer multiples of angles and a rational multiple of π."""
    return _circular(series, 0)


def _circular(series: Series, parity: int) -> Series:
    """Return cos (parity 0) or sin (1) of Σ k φ + n π/12, with monomials as angles φ."""
    ring = series.ring
    if series.parts.keys() - {0}:
        raise DerivationError(
            "expected an integer combination of angles in sin or cos, got sines or cosines in it; "
            "use the numeric derivation"
        )
    angle, twelfths = 0, 0
    for _, monomial, c in series.terms():
        of_pi = _count_twelfths(series, monomial, c)
        if of_pi is None:
            angle += ring.angle(monomial, c)
        else:
            twelfths += of_pi
    quarters, rest = divmod(twelfths, 6)
    if rest:
        along, across = _exact_cosine(ring, rest), _exact_cosine(ring, 6 - rest)
        shifted = [_pure(series, angle, quarters + k, parity) for k in (0, 1)]
        return along * shifted[0] + across * shifted[1]  # f(A + α) = f(A) cos α + f(A + π/2) sin α
    return _pure(series, angle, quarters, parity)


def _pure(series: Series, angle: int, quarters: int, parity: int) -> Series:
    """Return cos or sin of angle + quarters × π/2."""
    sign = 1
    for _ in range(quarters % 4):  # cos(x + π/2) = −sin x, sin(x + π/2) = cos x
        sign, parity = (sign, 0) if parity else (-sign, 1)
    if angle < 0:
        angle, sign = -angle, -sign if parity else sign
    if not angle and parity:
        return series.ring.number(0)
    largest = max((abs(k) for _, k in exponents(angle)), default=0)
    return canonical(series.ring, {2 * angle + parity: {0: sign}}, 1, largest)


def _count_twelfths(series: Series, monomial: int, c: Fraction) -> int | None:
    """Return n if a term is n π/12, with π as a generator or as the nearest float, else None."""
    generators = [series.ring.generators[i] for i, _ in exponents(monomial)]
    if [g.name for g in generators] == ["pi"] and generators[0].kind is Kind.CONSTANT:
        twelfths = c * 12 if monomial == power(generators[0].index) else Fraction(1, 2)
        return int(twelfths) if twelfths.denominator == 1 else None
    if not monomial:
        n = round(float(c) / (math.pi / 12))
        return n if abs(float(c) - n * math.pi / 12) <= 4 * math.ulp(float(c)) else None
    return None


def _exact_cosine(ring: Ring, twelfths: int) -> Series:
    """Return cos(n π/12) for n = 1 … 5."""
    two, three = (sqrt(ring.number(k)) for k in (2, 3))
    table: dict[int, Series] = {
        1: two * (three + 1) / 4,
        2: three / 2,
        3: two / 2,
        4: ring.number(Fraction(1, 2)),
        5: two * (three - 1) / 4,
    }
    return table[twelfths]


_MODERATE = Fraction(10) ** 60
"""Bound of numbers beneath a root, and of their inverses, so that products remain floats."""


def sqrt(series: Series, name: str | None = None) -> Series:
    """Return the square root: exact for squares of monomials and polynomials, otherwise an atom.

    Parameters are taken as positive. Of the two roots of a square polynomial, the one whose terms
    in parameters alone are positive is returned: √((l + x)²) = l + x. Without such a term, the
    first coordinate is taken as positive.
    """
    ring = series.ring
    if not series:
        return series
    content, monomial = _find_square_content(series)
    primitive = series / content * ring.monomial(-2 * monomial)
    outside = _take_root(ring, content) * ring.monomial(monomial)
    exact = _find_polynomial_root(primitive)
    if exact is not None:
        return outside * exact
    if primitive.is_unit:
        ((packed, c),) = primitive.parts[0].items()
        if c < 0:
            raise DerivationError(
                f"expected a square root of a positive series, got sqrt({series})"
            )
        for index, e in exponents(packed):
            outside = outside * _adjoin_root(ring.monomial(power(index)), None) ** e
        return outside
    number = _take_root(ring, content)
    if name is not None and not number.is_number:
        # a distance with a letter is that root itself, not a multiple of it by a root
        return ring.monomial(monomial) * _adjoin_root(primitive * content, name)
    return outside * _adjoin_root(primitive, name)


def _adjoin_root(radicand: Series, name: str | None) -> Series:
    return radicand.ring.adjoin("sqrt", radicand, lambda root: root**-1 / 2, np.sqrt, name)


def _find_square_content(series: Series) -> tuple[Fraction, int]:
    """Return a rational, and a monomial of parameters whose square divides the series."""
    numbers = [c for _, _, c in series.terms()]
    content = Fraction(
        math.gcd(*(c.numerator for c in numbers)), math.lcm(*(c.denominator for c in numbers))
    )
    if max((c / content).numerator for c in numbers) > MEASURED:
        largest = _find_power_of_two(max(map(abs, numbers))) ** 2
        content = Fraction(1) if 1 / _MODERATE < largest < _MODERATE else largest
    monomials = [m for _, m, _ in series.terms()]
    packed = 0
    for g in series.ring.generators:
        # a coordinate stays inside, as √x² would be |x|
        if g.kind in GIVEN:
            packed += power(g.index, min(exponent(m, g.index) for m in monomials) // 2)
    return content, packed


def _take_root(ring: Ring, number: Fraction) -> Series:
    """Return √(n/d) = √(n d)/d, with one atom per prime, or one for a number of many digits."""
    n, outside, root = number.numerator * number.denominator, 1, ring.number(1)
    if n > MEASURED**2 and math.isqrt(n) ** 2 != n:
        scale = _find_power_of_two(number)  # so that √a and √(4a) are multiples of one atom
        return _adjoin_root(ring.number(number / scale**2), None) * scale
    prime = 2
    while n > 1 and prime < 10_000:
        if math.isqrt(n) ** 2 == n:
            outside, n = outside * math.isqrt(n), 1
        count = 0
        while n % prime == 0:
            n, count = n // prime, count + 1
        outside *= prime ** (count // 2)
        if count % 2:
            root = root * _adjoin_root(ring.number(prime), None)
        prime += 1
    if n > 1:
        root = root * _adjoin_root(ring.number(n), None)
    return root * outside / number.denominator


def _find_power_of_two(number: Fraction) -> Fraction:
    """Return 2^k near the root of a positive number."""
    bits = number.numerator.bit_length() - number.denominator.bit_length()
    return Fraction(2) ** (bits // 2)


def _find_polynomial_root(series: Series) -> Series | None:
    """Return p with p² = series by the schoolbook square root, None if there is none."""
    if series.parts.keys() != {0}:
        return None
    rest, root, lead = series, series.ring.number(0), None
    for _ in range(len(series)):
        top = max(rest.parts[0])
        c = Fraction(rest.parts[0][top], rest.denominator)
        if lead is None:
            halves = dict(exponents(top))
            n, d = math.isqrt(max(c.numerator, 0)), math.isqrt(c.denominator)
            if (
                n * n != c.numerator
                or d * d != c.denominator
                or any(e % 2 for e in halves.values())
            ):
                return None
            term = lead = series.ring.monomial(top // 2) * Fraction(n, d)
        else:
            term = series.ring.monomial(top) * c / (2 * lead)
        rest = rest - (2 * root + term) * term
        root = root + term
        if not rest:
            return _make_positive(root)
    return None


def _make_positive(root: Series) -> Series:
    """Return the root or its negative, whichever is positive for positive parameters."""
    kinds = {g.index: g.kind for g in root.ring.generators}

    def rank(monomial: int) -> tuple[int, int]:
        fixed = all(kinds[i] in GIVEN for i, _ in exponents(monomial))
        return (0 if fixed else 1, monomial)

    *_, c = min(root.terms(), key=lambda term: rank(term[1]))
    return root if c > 0 else -root


_EXACT: dict[str, Callable[[Series], Series]] = {
    "sin": sin,
    "cos": cos,
    "tan": lambda u: sin(u) / cos(u),
    "sqrt": sqrt,
}

_AT_ZERO = {"exp": 1, "asin": 0, "atan": 0, "tanh": 0, "Abs": 0, "sign": 0}


def root_of_square(square: Series) -> Series | None:
    """Return cos A for (1 + cos 2A)/2 and 1 for 1; None for any other series."""
    ring = square.ring
    if (square - ring.number(1)).vanishes():
        return ring.number(1)
    keys = square.parts.keys() - {0}
    if len(keys) != 1 or 0 not in square.parts:
        return None
    (key,) = keys
    angle = key >> 1
    if key & 1 or any(e % 2 for _, e in exponents(angle)):
        return None
    half = {0: Fraction(1, 2)}
    for trig in (0, key):
        polynomial = square.parts[trig]
        if {m: Fraction(c, square.denominator) for m, c in polynomial.items()} != half:
            return None
    return canonical(ring, {2 * (angle // 2): {0: 1}}, 1, square.reach)
