"""Collect inertia terms over powers of one sum: a/s + b/s² = (a + b/s)/s."""

from __future__ import annotations

from collections.abc import Sequence
from fractions import Fraction

from mecanique.derivation.printing.expressions import size
from mecanique.derivation.printing.formulas import MOVING, Product, Sum, multiply, number


def draw_divisor(terms: Sequence[Product]) -> list[Product]:
    """Merge the first two terms into one product, if both are divided by the same sum.

    m q''/s + m q q'²/s² = m (q'' + q q'²/s)/s, where that takes fewer symbols.

    Args:
        terms: the terms of an equation's left side, that of the acceleration first.
    """
    if len(terms) < 2:
        return [*terms]
    first, second, *others = terms
    held = [factor for factor in first.factors if factor[0].place[0] < MOVING]
    moving = [factor for factor in first.factors if factor[0].place[0] >= MOVING]
    divisors = {base for base, e in held if isinstance(base, Sum) and e == -1}
    if not any(base in divisors and e == -2 for base, e in second.factors):
        return [*terms]
    inverse = [(base, -e) for base, e in held]
    rest = multiply(number(1 / Fraction(first.number)), second, *inverse)
    inner = Sum((multiply(*moving), rest))
    joined = multiply(number(first.number), *held, inner)
    if abs(rest.number) != 1 or size(joined) >= size(first) + 1 + size(second):
        return [*terms]
    return [joined, *others]
