"""Pack Laurent monomials into integers, and multiply polynomials as dictionaries of these.

A monomial x₀^e₀ x₁^e₁ … is one integer: the sum of eᵢ 2^(12 i). Exponents are signed, products of
monomials are sums of integers, and a ring may gain generators at any time. Each exponent must stay
within ±`REACH`, which the caller checks. A polynomial maps monomials to integer coefficients.
"""

from __future__ import annotations

import math
from collections.abc import Iterable
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
    found, rest, index = [], monomial, 0
    while rest:
        # skip to the first generator that occurs
        empty = ((rest & -rest).bit_length() - 1) // _BITS
        rest, index = rest >> (_BITS * empty), index + empty
        low = ((rest + _HALF) & _MASK) - _HALF
        found.append((index, low))
        rest, index = (rest - low) >> _BITS, index + 1
    return tuple(found)


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
    """Return a number as an exact rational; a float becomes the simple rational it represents.

    A float within one unit in the last place of a rational with denominator up to 10⁴ becomes that
    rational (0.1 → 1/10, 1/3 → 1/3); one of at most 15 significant decimal digits becomes that
    decimal; any other keeps its exact binary value.

    Args:
        number: an integer, a rational or a finite real number.

    Raises:
        DerivationError: if it is none of these.
    """
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
