"""Cancel common factors in series that are divided by sums or roots."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from fractions import Fraction
from math import gcd

from mecanique.derivation.scalars.polynomials import (
    Polynomial,
    accumulate,
    exponent,
    exponents,
    largest_exponent,
    lowest_terms,
    power,
    product_to_sum,
)
from mecanique.derivation.scalars.series import GIVEN, Kind, Series, canonical
from mecanique.derivation.tolerances import ROUNDING


def tidy(series: Series) -> Series:
    """Cancel roots ρ = √s and sums in the denominators of a series, if that adds no terms."""
    # All terms are brought over one power of the root, ρ² is replaced by s, and s is divided out as
    # often as possible: q²/ρ² + 1 = (q² + ρ²)/ρ², and (m₁² + m₁ m₂)/(m₁ + m₂)² = m₁/(m₁ + m₂)
    ring = series.ring
    for index, degree, argument in reversed(ring.roots):
        lowest = min((exponent(m, index) for p in series.parts.values() for m in p), default=0)
        if lowest >= 0:
            continue
        steps = -(lowest // degree)
        root = ring.monomial(power(index))
        cleared = series
        for _ in range(steps * degree):  # as ρ² alone would turn into s before it multiplies
            cleared = cleared * root
        while steps and (quotient := divide_exactly(cleared, argument)) is not None:
            cleared, steps = quotient, steps - 1
        other = cleared * root ** (-steps * degree)
        series = other if len(other) <= len(series) else series
    return series


def without_rounding(series: Series, summed: Iterable[Series]) -> Series:
    """Drop terms of a sum whose coefficients are rounding of what was summed."""
    # Numbers given as floats are exact here, but a tilt's matrix is orthogonal up to rounding only

    def has_root(monomial: int) -> bool:
        return any(exponent(monomial, index) for index, *_ in series.ring.roots)

    # the root of a sum of floats is that of an integer as large as their denominators, so that
    # coefficients beside it are no measure of others, nor others of them
    sizes = (abs(c) for term in summed for _, m, c in term.terms() if not has_root(m))
    least = max(sizes, default=Fraction(0)) * Fraction(ROUNDING) * series.denominator
    parts: dict[int, Polynomial] = {}
    for trig, polynomial in series.parts.items():
        kept = {m: c for m, c in polynomial.items() if abs(c) > least or has_root(m)}
        if kept:
            parts[trig] = kept
    return canonical(series.ring, parts, series.denominator, series.reach)


def by_velocity(series: Series, velocities: Sequence[str]) -> Series:
    """Tidy a series velocity by velocity, so that roots within one coefficient cancel."""
    if not series.ring.roots:
        return series
    v = [series.ring[name] for name in velocities]
    terms = []
    for powers, coefficient in series.coefficients(velocities).items():
        term = tidy(coefficient)
        for x, k in zip(v, powers, strict=True):
            term = term * x**k
        terms.append(term)
    return series.ring.sum(terms)


def without_common_divisor(series: Series) -> Series:
    """Multiply a series by the sums that all its terms are divided by."""
    # Such a sum is not zero where the series is defined: x''/(R² − x²) + x x'²/(R² − x²)² = 0
    # becomes x'' + x x'²/(R² − x²) = 0
    ring = series.ring
    for index, atom in ring.atoms.items():
        powers = {exponent(monomial, index) for _, monomial, _ in series.terms()}
        known = atom.argument.kinds <= {*GIVEN, Kind.ATOM, Kind.COORDINATE}
        if not atom.named and known and powers and max(powers) < 0:
            for _ in range(-max(powers)):  # one by one: ρ² alone would turn into its radicand
                series = ring.monomial(power(index)) * series
    return series


def divide_exactly(series: Series, divisor: Series) -> Series | None:
    """Return series / divisor, None with a remainder, or for sums with sines or cosines."""
    if not series:
        return None
    if divisor.parts.keys() != {0}:
        (key, *others) = divisor.parts
        wave = None if others or len(divisor.parts[key]) > 1 else divide_by_wave(series, key)
        unit = Series(series.ring, {0: divisor.parts[key]}, divisor.denominator, divisor.reach)
        return None if wave is None else wave / unit
    content = gcd(*divisor.parts[0].values())
    primitive = {m: c // content for m, c in divisor.parts[0].items()}
    parts: dict[int, Polynomial] = {}
    longest = max(map(len, series.parts.values()))
    for trig, polynomial in series.parts.items():
        divided = _divide_long(polynomial, primitive, longest)
        if divided is None:
            return None
        parts[trig] = divided
    reach = series.reach + divisor.reach
    quotient = canonical(series.ring, parts, series.denominator, reach)
    return quotient * divisor.denominator / content


def divide_by_wave(series: Series, key: int) -> Series | None:
    """Return series / cos A, or / sin A, by the key of that function; None with a remainder."""
    # With sines and cosines of sums, the term P cos(k φ + ψ) of the largest k, where A contains φ,
    # is 2 P cos(k φ + ψ − A) cos A less a term of smaller k, and so on; likewise for sines
    angle = key >> 1
    index, step = exponents(angle)[0]
    quotient, seen = dict[int, Polynomial](), set[int]()
    rest = {trig: dict(polynomial) for trig, polynomial in series.parts.items()}
    while rest:
        top = max(rest, key=lambda trig: abs(exponent(trig >> 1, index)))
        turns = exponent(top >> 1, index)
        packed = (top >> 1) - (angle if (turns > 0) == (step > 0) else -angle)
        # cos(-x) = cos x, sin(-x) = -sin x, whose sign the product below takes along
        trig = 2 * abs(packed) + ((top ^ key) & 1)
        if not turns or trig == 1 or top in seen:
            return None
        seen.add(top)
        waves = dict(product_to_sum(trig, key)) if trig else {key: 1}
        sign, polynomial = waves.pop(top), rest.pop(top)
        accumulate(quotient, trig, polynomial, 2 * sign if trig else sign)
        for wave, other in waves.items():
            accumulate(rest, wave, polynomial, -sign * other)
        rest, _ = lowest_terms(rest, 1)
    reach = series.reach + largest_exponent([angle])
    return canonical(series.ring, quotient, series.denominator, reach)


def integrate(series: Series, name: str) -> Series | None:
    """Return an integral by a coordinate; None if a term is beyond powers and waves."""
    # The series contains no roots or adjoined functions
    ring = series.ring
    q = ring[name]
    index = ring.index(q)
    terms = []
    for trig, monomial, c in series.terms():
        term = canonical(ring, {trig: {monomial: 1}}, 1, series.reach) * c
        e = exponent(monomial, index)
        turns = [ring.angles[j].argument.diff(name) * k for j, k in exponents(trig >> 1)]
        slope = ring.sum(turns)
        if not slope and e != -1:
            terms.append(term * q / (e + 1))
        elif slope.is_unit and not e and not slope.diff(name):
            # (sin φ)' = φ' cos φ, so that an integral of sin φ is −(sin φ)'/φ'²
            terms.append(-term.diff(name) / (slope * slope))
        else:
            return None
    return ring.sum(terms)


def _divide_long(numerator: Polynomial, primitive: Polynomial, steps: int) -> Polynomial | None:
    """Return numerator / divisor, or None if there is a remainder."""
    # By Gauss's lemma an exact quotient by a divisor whose coefficients share no factor is integral
    rest, lead = dict(numerator), max(primitive)
    quotient: Polynomial = {}
    for _ in range(steps):
        if not rest:
            break
        top = max(rest)
        factor, remainder = divmod(rest[top], primitive[lead])
        if remainder:
            return None
        shift = top - lead
        quotient[shift] = factor
        for m, c in primitive.items():
            left = rest.get(m + shift, 0) - factor * c
            if left:
                rest[m + shift] = left
            else:
                rest.pop(m + shift, None)
    return None if rest else quotient
