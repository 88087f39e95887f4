"""Divide vectors by their lengths, exactly where a length is a cosine."""

from __future__ import annotations

from collections.abc import Sequence
from fractions import Fraction

from mecanique.derivation.scalars.cancel import tidy
from mecanique.derivation.scalars.monomials import exponent, exponents
from mecanique.derivation.scalars.series import Series, canonical

_STEPS = 200


def over_length(vector: Sequence[Series], length: Series) -> list[Series]:
    """Divide a vector by its length, exactly if that is a cosine that divides all components.

    Args:
        vector: its components.
        length: its length.
    """
    parts = [_divide(component, length) for component in vector]
    exact = [part for part in parts if part is not None]
    if len(exact) == len(parts):
        return exact
    return [tidy(component / length) for component in vector]


def root_of_square(square: Series) -> Series | None:
    """Return cos A for (1 + cos 2A)/2 and 1 for 1; None for any other series.

    Args:
        square: the radicand.
    """
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


def _divide(series: Series, cosine: Series) -> Series | None:
    """Return series / cos A by long division in multiples of A; None with a remainder."""
    ring = series.ring
    key, *others = cosine.parts
    if others or (not key and not cosine.is_number):
        return None
    if not key:
        return series / cosine
    angle = key >> 1
    index, step = next(iter(exponents(angle)))
    size, sign = abs(step), 1 if step > 0 else -1
    rest = series
    terms: list[Series] = []
    for _ in range(_STEPS):
        if not rest:
            return ring.sum(terms)
        trig = max(rest.parts, key=lambda trig: (abs(exponent(trig >> 1, index)), trig))
        multiple = exponent(trig >> 1, index) * sign
        if abs(multiple) < size:
            return None
        # cos(−B) = cos B, sin(−B) = −sin B
        turned = -1 if trig & 1 else 1
        other, flip = (trig >> 1, 1) if multiple > 0 else (-(trig >> 1), turned)
        left, double = other - angle, 2
        if not left:
            if trig & 1:
                return None
            double = 1
        if left < 0:
            left, flip = -left, flip * turned
        polynomial = {m: double * flip * c for m, c in rest.parts[trig].items()}
        term = canonical(
            ring, {2 * left + (trig & 1): polynomial}, rest.denominator, rest.reach + cosine.reach
        )
        terms.append(term)
        rest = rest - term * cosine
    return None
