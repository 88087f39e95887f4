"""Compute with Poisson series as dictionaries: a polynomial for each sine and cosine."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from fractions import Fraction
from functools import lru_cache
from numbers import Rational, Real
from typing import TypeAlias

from mecanique.errors import DerivationError

Polynomial: TypeAlias = "dict[int, int]"

_BITS = 12
_HALF = 1 << (_BITS - 1)
_MASK = (1 << _BITS) - 1
REACH = _HALF - 1
"""The largest exponent, and the largest multiple of an angle, that a series may contain."""


def power(index: int, exponent: int = 1) -> int:
    """Return the monomial of one generator raised to an exponent."""
    return exponent << (_BITS * index)


@lru_cache(maxsize=1024)
def _bias(fields: int) -> int:
    """Return half a field's range in every field; added to a monomial it makes all non-negative."""
    return sum(_HALF << (_BITS * i) for i in range(fields))


def exponent(monomial: int, index: int) -> int:
    """Return the exponent of one generator in a monomial."""
    return (((monomial + _bias(index + 1)) >> (_BITS * index)) & _MASK) - _HALF


@lru_cache(maxsize=1 << 16)
def exponents(monomial: int) -> tuple[tuple[int, int], ...]:
    """Return (generator, exponent) for every generator in a monomial, in order."""
    powers, rest, index = [], monomial, 0
    while rest:
        # skip to the first generator that occurs
        empty = ((rest & -rest).bit_length() - 1) // _BITS
        rest, index = rest >> (_BITS * empty), index + empty
        low = ((rest + _HALF) & _MASK) - _HALF
        powers.append((index, low))
        rest, index = (rest - low) >> _BITS, index + 1
    return tuple(powers)


def generators_in(monomials: Iterable[int], count: int) -> list[int]:
    """Return the generators, of the first `count`, that occur in any of the monomials."""
    bias, differing = _bias(count), 0
    for monomial in monomials:
        differing |= (monomial + bias) ^ bias
    return [i for i in range(count) if (differing >> (_BITS * i)) & _MASK]


def largest_exponent(monomials: Iterable[int]) -> int:
    """Return the largest |exponent| in the monomials."""
    return max((abs(e) for monomial in monomials for _, e in exponents(monomial)), default=0)


def multiply(p: Polynomial, q: Polynomial) -> Polynomial:
    """Return the product of two polynomials; coefficients that cancel remain as zeros."""
    if len(p) == 1:
        ((m, c),) = p.items()
        return {m + n: c * d for n, d in q.items()}
    if len(q) == 1:
        ((m, c),) = q.items()
        return {m + n: c * d for n, d in p.items()}
    product: Polynomial = {}
    for m, c in p.items():
        for n, d in q.items():
            product[m + n] = product.get(m + n, 0) + c * d
    return product


def exact(number: object) -> Fraction:
    """Return a number as an exact rational; a float becomes the simple rational it represents."""
    # A float within one unit in the last place of a rational with denominator up to 10⁴ becomes
    # that rational (0.1 → 1/10, 1/3 → 1/3); one of at most 15 significant decimal digits becomes
    # that decimal; any other keeps its exact binary value
    if isinstance(number, Fraction):
        return number
    if isinstance(number, Rational):
        return Fraction(int(number.numerator), int(number.denominator))
    if isinstance(number, Real):
        value = float(number)
        if math.isfinite(value):
            binary = Fraction(value)
            simple = binary.limit_denominator(10_000)
            if simple and abs(simple - binary) <= Fraction(math.ulp(value)):
                return simple
            digits = f"{value:.15g}"
            return Fraction(digits) if float(digits) == value else binary
    raise DerivationError(f"expected a finite real number, got {number!r}")


Parts: TypeAlias = "dict[int, Polynomial]"
"""Polynomials by trigonometric function: key 2 K for cos(K·φ), 2 K + 1 for sin(K·φ), 0 for 1.

K > 0 packs the integer multiples of the angles as a monomial packs exponents.
"""


def size(parts: Parts) -> int:
    """Return the number of terms."""
    return sum(map(len, parts.values()))


def check_size(parts: Parts, most: int, *, canceling: bool = False) -> None:
    """Refuse more than `most` terms, or twice as many while some may still cancel."""
    if size(parts) > (2 * most if canceling else most):
        raise DerivationError(
            f"the closed form has more than {most} terms, too many to be read; "
            "use the numeric derivation"
        )


def largest(parts: Parts) -> int:
    """Return the largest |exponent| or |multiple of an angle|."""
    packed = (x for trig, polynomial in parts.items() for x in (trig >> 1, *polynomial))
    return max((abs(e) for x in packed for _, e in exponents(x)), default=0)


def accumulate(parts: Parts, trig: int, polynomial: Polynomial, factor: int) -> None:
    """Add factor × polynomial × trig to parts, in place."""
    into = parts.get(trig)
    if into is None:
        parts[trig] = {m: factor * c for m, c in polynomial.items()}
        return
    for m, c in polynomial.items():
        into[m] = into.get(m, 0) + factor * c


def product(first: Parts, second: Parts, most: int) -> tuple[Parts, int]:
    """Return (parts, denominator) of a product."""
    # sums of angles have a factor ½; products with the key 0 get a factor 2 instead
    halved = any(first) and any(second)
    parts: Parts = {}
    for f, p in first.items():
        for g, r in second.items():
            both = multiply(p, r)
            if f and g:
                for trig, sign in product_to_sum(f, g):
                    accumulate(parts, trig, both, sign)
            else:
                accumulate(parts, f or g, both, 2 if halved else 1)
        check_size(parts, most, canceling=True)
    return parts, 2 if halved else 1


def lowest_terms(parts: Parts, denominator: int) -> tuple[Parts, int]:
    """Remove zeros and reduce the fraction; return parts and denominator."""
    sound = {}
    for t, p in parts.items():
        if q := p if all(p.values()) else {m: c for m, c in p.items() if c}:
            sound[t] = q
    parts = sound
    divisor = denominator
    for p in parts.values():
        if divisor == 1:
            return parts, denominator
        divisor = math.gcd(divisor, *p.values())
    if divisor > 1:
        for t, p in parts.items():
            parts[t] = {m: c // divisor for m, c in p.items()}
    return parts, denominator // divisor


def shift(parts: Parts, monomial: int) -> Parts:
    """Multiply every monomial by another; a negated monomial divides."""
    moved = {}
    for t, p in parts.items():
        moved[t] = {m + monomial: c for m, c in p.items()}
    return moved


def negative(parts: Parts) -> Parts:
    """Return parts with every sign changed."""
    turned = {}
    for t, p in parts.items():
        turned[t] = {m: -c for m, c in p.items()}
    return turned


def differentiate_powers(parts: Parts, index: int) -> Parts:
    """Return ∂/∂x for a generator x in the monomials alone, not within angles and atoms."""
    x = power(index)
    slopes: Parts = {}
    for trig, polynomial in parts.items():
        lowered = {m - x: c * e for m, c in polynomial.items() if (e := exponent(m, index))}
        if lowered:
            slopes[trig] = lowered
    return slopes


def differentiate_angles(parts: Parts, index: int) -> Parts:
    """Return ∂/∂φ for an angle φ: sin' = cos, cos' = −sin."""
    slopes: Parts = {}
    for trig, polynomial in parts.items():
        k = exponent(trig >> 1, index)
        if k:
            factor = k if trig & 1 else -k
            slopes[trig ^ 1] = {m: factor * c for m, c in polynomial.items()}
    return slopes


def split_powers(parts: Parts, places: Mapping[int, int]) -> dict[tuple[int, ...], Parts]:
    """Return the coefficients of a polynomial in some generators, by their exponents."""
    split = {m: _split_monomial(m, places) for m in set().union(*parts.values())}
    by_powers: dict[tuple[int, ...], Parts] = {}
    for trig, polynomial in parts.items():
        for monomial, c in polynomial.items():
            powers, rest = split[monomial]
            by_powers.setdefault(powers, {}).setdefault(trig, {})[rest] = c
    return by_powers


def _split_monomial(monomial: int, places: Mapping[int, int]) -> tuple[tuple[int, ...], int]:
    """Split a monomial into the exponents of generators that have a place, and the rest."""
    powers, rest = [0] * len(places), monomial
    for i, e in exponents(monomial):
        if i in places:
            powers[places[i]] = e
            rest -= power(i, e)
    return tuple(powers), rest


def lower_powers(
    parts: Parts, index: int, degree: int, *, below_zero: bool = False
) -> dict[int, Parts]:
    """Return the coefficients of (x^degree)^k by k; lower powers of x remain in them."""
    by_power: dict[int, Parts] = {}
    for trig, polynomial in parts.items():
        for monomial, c in polynomial.items():
            k = exponent(monomial, index) // degree
            if k < 0 and not below_zero:
                k = 0
            rest = monomial - power(index, k * degree)
            by_power.setdefault(k, {}).setdefault(trig, {})[rest] = c
    return by_power


@lru_cache(maxsize=1 << 16)
def product_to_sum(f: int, g: int) -> tuple[tuple[int, int], ...]:
    """Return 2 f g as (function, sign) pairs, e.g. 2 cos K cos L = cos(K − L) + cos(K + L)."""
    K, L = f >> 1, g >> 1
    plus, minus = 2 * (K + L), 2 * abs(K - L)
    if (f & 1) == (g & 1):
        return (minus, 1), (plus, -1 if f & 1 else 1)
    # sin K cos L contains + sin(K − L), cos K sin L contains − sin(K − L)
    sign = (1 if f & 1 else -1) * (1 if K > L else -1)
    return ((plus | 1, 1),) if K == L else ((plus | 1, 1), (minus | 1, sign))
