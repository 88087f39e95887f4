"""Find the shortest way to write a Poisson series: which angles to leave as sums, which to fold.

A book does not print the canonical series ½ A (1 − cos 2θ) + ½ C (1 + cos 2θ), but A sin²θ + C
cos²θ. Here every pair of terms may be folded back by the addition theorems, every double angle
written by single ones, and the form with the fewest symbols is chosen. All forms are exactly equal.
"""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Iterable, Iterator, Sequence
from fractions import Fraction
from functools import lru_cache
from itertools import chain, combinations
from itertools import product as cartesian
from typing import TypeAlias

from mecanique.derivation.scalars.polynomials import exponents, largest_exponent, power
from mecanique.derivation.scalars.series import GIVEN, Kind, Series, canonical
from mecanique.derivation.tolerances import MEASURED

Trig: TypeAlias = "tuple[tuple[int, int, int], ...]"
"""A product of sines and cosines, each as (packed angle, 1 for sin or 0 for cos, power)."""

Form: TypeAlias = "dict[Trig, Series]"
"""A sum of products of sines and cosines, each with its polynomial coefficient."""

_ANGLES, _EXPANDED, _MULTIPLE = 3, 12, 6
"""Largest numbers of angles, terms and multiples in a series written in single angles."""

_TIMED = {Kind.TIME, *GIVEN}

_MANY = 5  # with more sines and cosines than this, only the obvious foldings are tried


def shortest(series: Series, *, products: bool) -> Form:
    """Return the form of a series with the fewest symbols."""
    angles = series.ring.angles
    # a law of time keeps its frequency: sin 2t is no 2 sin t cos t
    kinds = frozenset[Kind]().union(*(angles[i].argument.kinds for i in series.turns()))
    products = products and bool(kinds - _TIMED or Kind.TIME not in kinds)
    forms = _list_forms(series, products)
    if products:
        forms = map(_fold_again, chain(forms, _list_single_angles(series)))
    first, *others = forms
    return min(first, *others, key=_rank) if others else first


def _rank(form: Form) -> tuple[int, int]:
    """Rank a form by its cost, then by its number of multiple angles, which books avoid."""
    multiples = [abs(k) > 1 for trig in form for angle, _, _ in trig for _, k in exponents(angle)]
    return cost(form), sum(multiples)


def has_double_angles(series: Series) -> bool:
    """Return whether a sine or cosine could be written in half its angle."""
    return any(_halvable(trig >> 1) for trig in series.parts)


def halve_angles(form: Form) -> Form:
    """Write P + P cos 2φ as 2 P cos²φ, and P − P cos 2φ as 2 P sin²φ."""
    constant = form.get(())
    for trig, part in form.items():
        if constant is None or len(trig) != 1:
            continue
        ((angle, sine, e),) = trig
        if sine or e > 1 or any(k % 2 for _, k in exponents(angle)):
            continue
        for wave, sign in ((0, 1), (1, -1)):
            rest = constant - sign * part
            if len(rest) + len(part) == len(constant):
                halved = {t: p for t, p in form.items() if t not in ((), trig)}
                if rest:
                    halved[()] = rest
                halved[((angle >> 1, wave, 2),)] = 2 * sign * part
                return halve_angles(halved)
    return form


def content(forms: Iterable[Form]) -> Series:
    """Return the greatest rational × monomial of parameters that divides all polynomials."""
    polynomials = [p for form in forms for p in form.values()]
    packed = common_monomial(polynomials, {Kind.PARAMETER})
    return polynomials[0].ring.monomial(packed) * common_measure(polynomials)


def common_scale(polynomials: Sequence[Series]) -> Fraction:
    """Return the greatest rational that divides all coefficients, the largest if measured."""
    # as multiples of a common measure, products of measured numbers would exceed every float
    measure, largest = _measure(polynomials)
    return measure if largest <= MEASURED else measure * largest


def _measure(polynomials: Sequence[Series]) -> tuple[Fraction, int]:
    """Return the greatest rational that divides all coefficients, and the largest quotient."""
    whole = math.lcm(*(p.denominator for p in polynomials))
    shared = largest = 0
    for p in polynomials:
        factor = whole // p.denominator
        for polynomial in p.parts.values():
            divisor = math.gcd(*polynomial.values())
            shared = math.gcd(shared, divisor * factor)
            largest = max(largest, factor * max(map(abs, polynomial.values())))
    return Fraction(shared, whole), largest // (shared or 1)


def common_measure(polynomials: Sequence[Series]) -> Fraction:
    """Return the greatest rational that divides all coefficients, 1 for measured numbers."""
    # Measured numbers have large denominators, or are large multiples of a common measure
    measure, largest = _measure(polynomials)
    if sum(map(len, polynomials)) > 1:
        if max(p.denominator for p in polynomials) > MEASURED:
            return Fraction(1)
        return measure if largest <= MEASURED else Fraction(1)
    return measure


def common_monomial(polynomials: Iterable[Series], kinds: set[Kind] | None = None) -> int:
    """Return the greatest monomial in some kinds of generators that divides all polynomials."""
    series = [*polynomials]
    first, *others = monomials_in(series) or [0]
    least = dict(exponents(first))
    for monomial in others:
        least = _find_least(least, exponents(monomial))
    if kinds is None or not least:
        return sum(power(i, e) for i, e in least.items())
    generators = series[0].ring.generators
    return sum(power(i, e) for i, e in least.items() if generators[i].kind in kinds)


def monomials_in(polynomials: Iterable[Series]) -> set[int]:
    """Return the different monomials of polynomials without sines and cosines."""
    return set().union(*(p.parts.get(0, ()) for p in polynomials))


def _find_least(one: dict[int, int], other: tuple[tuple[int, int], ...]) -> dict[int, int]:
    """Return the lower power of each generator; one that does not occur has the power 0."""
    powers = dict(other)
    least = {}
    for i, e in one.items():
        low = min(e, powers.get(i, 0))
        if low:
            least[i] = low
    for i, e in other:
        if e < 0 and i not in one:
            least[i] = e
    return least


def scale(form: Form, factor: Series) -> Form:
    """Return a form times a unit."""
    if factor == 1:
        return form
    if factor.ring.roots:
        return {trig: polynomial * factor for trig, polynomial in form.items()}
    ((monomial, c),) = factor.parts[0].items()
    number = Fraction(c, factor.denominator)
    return {trig: rescale(polynomial, number, monomial) for trig, polynomial in form.items()}


def rescale(series: Series, factor: Fraction, monomial: int) -> Series:
    """Return a series times a number and a monomial; powers of roots are not lowered."""
    n, d = factor.numerator, factor.denominator
    if n == d == 1 and not monomial:
        return series
    parts = {}
    for trig, polynomial in series.parts.items():
        parts[trig] = {m + monomial: n * c for m, c in polynomial.items()}
    reach = series.reach + (largest_exponent([monomial]) if monomial else 0)
    return canonical(series.ring, parts, series.denominator * d, reach)


def cost(form: Form) -> int:
    """Return how many symbols it takes to write a form: letters, numbers, functions and powers."""
    if not form:
        return 1
    common = common_monomial(form.values())
    shared = find_shared_powers(form)
    total = _letters(common)
    for (angle, _), e in shared.items():
        total += _angle_cost(angle) + (e > 1)
    seen: set[frozenset[tuple[int, int]]] = set()
    for trig, polynomial in form.items():
        for angle, sine, e in trig:
            left = e - shared.get((angle, sine), 0)
            total += _angle_cost(angle) + (left > 1) if left else 0
        own = common_monomial([polynomial])
        total += _letters(own - common) + 1
        primitive = frozenset((m - own, abs(c)) for m, c in polynomial.parts[0].items())
        if primitive not in seen:  # equal sums are written once, as a common factor
            seen.add(primitive)
            divisor = math.gcd(*(c for _, c in primitive))
            if len(primitive) > 1:
                total += sum(_letters(m) + (c != divisor) + 1 for m, c in primitive)
    return total + len({_measure([p])[0] for p in form.values()}) - 1


def find_shared_powers(form: Form) -> dict[tuple[int, int], int]:
    """Return the sines and cosines that all products share, each in its lowest power."""
    first, *others = form
    shared = {(angle, sine): e for angle, sine, e in first}
    for trig in others:
        powers = {(angle, sine): e for angle, sine, e in trig}
        shared = {key: min(e, powers[key]) for key, e in shared.items() if key in powers}
    return shared


def _letters(monomial: int) -> int:
    return sum(1 + (abs(e) > 1) for _, e in exponents(monomial))


def _angle_cost(angle: int) -> int:
    return 1 + sum(1 + (abs(k) > 1) for _, k in exponents(angle))


@lru_cache(maxsize=1 << 14)
def _halvable(packed: int) -> bool:
    return packed != 0 and all(k % 2 == 0 for _, k in exponents(packed))


def _list_forms(series: Series, products: bool) -> Iterator[Form]:
    """Yield all foldings of a series."""
    keys = sorted(series.parts)
    many = len(keys) > _MANY

    def unfold(rest: list[int], form: Form) -> Iterator[Form]:
        if not rest:
            yield form
            return
        key, *others = rest
        polynomial = _polynomial(series, key)
        half = key >> 2 if _halvable(key >> 1) else 0
        partners = [k for k in others if _foldable(key, k, products)]
        if many:
            partners = [k for k in partners if _polynomial(series, k) in (polynomial, -polynomial)][
                :1
            ]
        for partner in partners:
            left = [k for k in others if k != partner]
            yield from unfold(
                left, _with(form, _fold(key, partner, polynomial, _polynomial(series, partner)))
            )
        if many and partners:
            return
        if not (products and half):
            yield from unfold(others, _with(form, [(_trig((key >> 1, key & 1)), polynomial)]))
        elif key & 1:
            yield from unfold(others, _with(form, [(_trig((half, 1), (half, 0)), 2 * polynomial)]))
        else:
            for sine, sign in ((1, -1), (0, 1))[
                : 1 if many else 2
            ]:  # cos 2θ = 1 − 2 sin²θ = 2 cos²θ − 1
                terms = [
                    ((), -sign * polynomial),
                    (_trig((half, sine), (half, sine)), 2 * sign * polynomial),
                ]
                yield from unfold(others, _with(form, terms))

    yield from unfold(keys, {})


def _list_single_angles(series: Series) -> Iterator[Form]:
    """Yield the series in single angles, with either sin² or cos² of each angle eliminated."""
    angles = series.turns()
    multiple = max(map(_count_turns, series.parts), default=0)
    if len(angles) > _ANGLES or len(series.parts) > _EXPANDED or not 2 <= multiple <= _MULTIPLE:
        return
    for squares in cartesian((0, 1), repeat=len(angles)):
        kept = dict(zip(angles, squares, strict=True))
        form: Form = {}
        for key in series.parts:
            polynomial = _polynomial(series, key)
            expanded = _expand(key, kept)
            form = _with(form, [(trig, c * polynomial) for trig, c in expanded.items()])
        if form:
            yield form


def _count_turns(key: int) -> int:
    return sum(abs(k) for _, k in exponents(key >> 1))


def _expand(key: int, kept: dict[int, int]) -> dict[Trig, int]:
    """Expand cos or sin of a sum of angles, the real or imaginary part of ∏ (cos φ + i sin φ)^k."""
    # a product of sines (1) and cosines (0) by angle -> real and imaginary integer coefficient
    products: dict[Trig, tuple[int, int]] = {(): (1, 0)}
    for j, k in exponents(key >> 1):
        turn = 1 if k > 0 else -1
        for _ in range(abs(k)):
            longer: dict[Trig, tuple[int, int]] = {}
            for trig, (a, b) in products.items():
                for sine, (c, d) in ((0, (a, b)), (1, (-turn * b, turn * a))):
                    for part, count in _raise(trig, (power(j), sine), kept[j]):
                        real, imaginary = longer.get(part, (0, 0))
                        longer[part] = (real + count * c, imaginary + count * d)
            products = longer
    return {trig: pair[key & 1] for trig, pair in products.items() if pair[key & 1]}


def _raise(trig: Trig, factor: tuple[int, int], kept: int) -> list[tuple[Trig, int]]:
    """Multiply a product by a sine or cosine; replace a square of the kind that is not kept."""
    angle, sine = factor
    powers = {(a, s): e for a, s, e in trig}
    powers[factor] = powers.get(factor, 0) + 1
    if sine == kept or powers[factor] < 2:
        return [(sort_powers(powers), 1)]
    # sin² = 1 − cos², cos² = 1 − sin²
    del powers[factor]
    squared = dict(powers)
    squared[angle, kept] = squared.get((angle, kept), 0) + 2
    return [(sort_powers(powers), 1), (sort_powers(squared), -1)]


def sort_powers(powers: dict[tuple[int, int], int]) -> Trig:
    """Return a product of powers of sines and cosines."""
    return tuple(sorted((angle, sine, e) for (angle, sine), e in powers.items()))


def _polynomial(series: Series, key: int) -> Series:
    return Series(series.ring, {0: series.parts[key]}, series.denominator, series.reach)


def _foldable(key: int, other: int, products: bool) -> bool:
    """Whether two terms are the sum and difference of two angles; a constant is cos(θ − θ)."""
    if (key & 1) != (other & 1):
        return False
    if key >> 1 == 0 or other >> 1 == 0:
        return products and _halvable((key >> 1) + (other >> 1))
    return _halvable((key >> 1) + (other >> 1))


def _fold(key: int, other: int, P: Series, Q: Series) -> list[tuple[Trig, Series]]:
    """Write P cos k + Q cos l, or with sin, in half the sum and difference of the angles."""
    first, second = key >> 1, other >> 1
    u, w = (first + second) >> 1, (first - second) >> 1
    flip = -1 if w < 0 else 1  # sign of sin w
    w = abs(w)
    if key & 1:
        sine, cosine = _trig((u, 1), (w, 0)), _trig((u, 0), (w, 1))
        return [(sine, P + Q), (cosine, (P - Q) * flip)]
    cosines, sines = _trig((u, 0), (w, 0)), _trig((u, 1), (w, 1))
    return [(cosines, P + Q), (sines, (Q - P) * flip)]


def _fold_again(form: Form) -> Form:
    """Fold the sum of two products that differ in one sine or cosine, such as x cos a - x cos b."""
    for (trig, P), (second, Q) in combinations(form.items(), 2):
        mine, theirs = _count_powers(trig), _count_powers(second)
        shared = mine & theirs
        key, partner = _find_single(mine - shared), _find_single(theirs - shared)
        if P not in (Q, -Q) or not (shared and key and partner):
            continue
        if _foldable(key, partner, products=True):
            folded = {
                product: part for product, part in form.items() if product not in (trig, second)
            }
            for factors, part in _fold(key, partner, P, Q):
                folded = _with(folded, [(sort_powers(shared + _count_powers(factors)), part)])
            return _fold_again(folded)
    return form


def _count_powers(trig: Trig) -> Counter[tuple[int, int]]:
    return Counter({(angle, sine): e for angle, sine, e in trig})


def _find_single(powers: Counter[tuple[int, int]]) -> int:
    """Return the key of a product that is one sine or cosine, 0 of any other."""
    ((angle, sine), *rest) = (*powers.elements(), (0, 0))
    return 0 if len(rest) > 1 else angle << 1 | sine


def _trig(*factors: tuple[int, int]) -> Trig:
    powers: dict[tuple[int, int], int] = {}
    for angle, sine in factors:
        if angle:
            powers[angle, sine] = powers.get((angle, sine), 0) + 1
    return sort_powers(powers)


def _with(form: Form, terms: list[tuple[Trig, Series]]) -> Form:
    merged = dict(form)
    for trig, polynomial in terms:
        total = merged[trig] + polynomial if trig in merged else polynomial
        if total:
            merged[trig] = total
        else:
            merged.pop(trig, None)
    return merged
