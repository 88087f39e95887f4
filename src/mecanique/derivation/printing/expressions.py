"""Turn Poisson series into formulas: common factors first, sums factored where that is shorter.

SymPy is used to factor polynomials only; as it takes half a second to import, it is imported when
the first polynomial is factored.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from fractions import Fraction
from functools import lru_cache
from typing import Any, TypeAlias, cast

from mecanique.derivation.printing.formulas import (
    MOVING,
    SUMS,
    Base,
    Call,
    Letter,
    Product,
    Sum,
    add,
    draw_number,
    multiply,
    number,
)
from mecanique.derivation.printing.trigforms import (
    Form,
    Trig,
    common_measure,
    common_monomial,
    find_shared_powers,
    halve_angles,
    monomials_in,
    rescale,
    shortest,
    sort_powers,
)
from mecanique.derivation.scalars.polynomials import Polynomial, exponents, power
from mecanique.derivation.scalars.series import Kind, Ring, Series, canonical
from mecanique.derivation.tolerances import MEASURED

_LARGEST = 40  # polynomials with more terms are not factored

PLACES = {
    Kind.CONSTANT: -1,
    Kind.ATOM: 5,
    Kind.TIME: SUMS + 5,
    Kind.COORDINATE: SUMS + 5,
    Kind.VELOCITY: MOVING,
    Kind.ACCELERATION: MOVING + 1,
    Kind.INPUT: MOVING + 2,
    Kind.REACTION: MOVING + 2,
    Kind.VARIATION: MOVING + 3,
}
"""Order of letters within a product, by kind; parameters have that of their unit."""


def to_formula(series: Series) -> Product:
    """Return a series as the formula with the fewest symbols."""
    return factor_out(shortest(series, products=True))


def letters(ring: Ring, monomial: int) -> Product:
    """Return a monomial as a formula; atoms without a name are written out."""
    key = ("letters", monomial)
    if key not in ring.written:
        ring.written[key] = multiply(*(_power(ring, i, e) for i, e in exponents(monomial)))
    return cast("Product", ring.written[key])


def factor_out(form: Form) -> Product:
    """Return a form as one product, with all common factors in front."""
    if not form:
        return number(0)
    polynomials = list(form.values())
    ring = polynomials[0].ring
    shared = sort_powers(find_shared_powers(form))
    if shared:
        form = {_divide_trig(trig, shared): p for trig, p in form.items()}
    factor = common_measure(polynomials)
    writings, inverse = [], 1 / factor
    for kept in (False, True):
        common = _find_common(polynomials, kept=kept)
        inner = {t: rescale(p, inverse, -common) for t, p in form.items()}
        whole = draw_number(collect_terms(inner, kept=kept))
        writings.append(multiply(number(factor), letters(ring, common), whole))
        if common == _find_common(polynomials, kept=True):
            break
    return multiply(
        min(writings, key=size) if len(writings) > 1 else writings[0], _write_circular(ring, shared)
    )


def _find_common(polynomials: list[Series], *, kept: bool) -> int:
    """Return the greatest monomial that divides all; a denominator only if all terms share it."""
    common = common_monomial(polynomials)
    if kept:
        common -= sum(power(i, e) for i, e in exponents(common) if e < 0)
        common += _find_common_denominator(polynomials)
    return common


def _find_common_denominator(polynomials: list[Series]) -> int:
    """Return the negative powers that all terms share: k (1 − l/ρ) is shorter than k (ρ − l)/ρ."""
    first, *others = monomials_in(polynomials)
    least = {i: e for i, e in exponents(first) if e < 0}
    for monomial in others:
        if not least:
            return 0
        here = dict(exponents(monomial))
        lowest = ((i, max(e, here.get(i, 0))) for i, e in least.items())
        least = {i: e for i, e in lowest if e < 0}
    return sum(power(i, e) for i, e in least.items())


def collect_terms(form: Form, *, kept: bool = False) -> list[Product]:
    """Return the terms of a form, merging those that share a sine, cosine or sum of parameters."""
    terms: list[Product] = []
    form = halve_angles(form)
    while form:
        factor, members = _choose_shared(form)
        if factor is None:
            break
        inner = {_divide_trig(t, (factor,)): form[t] for t in members}
        ring = next(iter(form.values())).ring
        terms.append(multiply(factor_out(inner), _write_circular(ring, (factor,))))
        form = {t: p for t, p in form.items() if t not in members}
    sums: dict[Series | None, Form] = {}
    for trig, polynomial in form.items():
        if len(polynomial) == 1:
            sums.setdefault(None, {})[trig] = polynomial
            continue
        common, factor_of = _find_common([polynomial], kept=kept), common_measure([polynomial])
        primitive = rescale(polynomial, 1 / factor_of, -common)
        # negative are sums with more negative terms, or as many with the first among them
        signs = [1 if c > 0 else -1 for c in primitive.parts[0].values()]
        first = primitive.parts[0][min(primitive.parts[0])]
        if sum(signs) < 0 or (sum(signs) == 0 and first < 0):
            primitive, factor_of = -primitive, -factor_of
        unit = rescale(polynomial.ring.number(1), factor_of, common)
        sums.setdefault(primitive, {})[trig] = unit
    for whole, members_of in sums.items():
        if whole is None:
            terms += [_write_unit_term(unit, trig) for trig, unit in members_of.items()]
        else:
            terms.append(multiply(_factor_sum(whole), factor_out(members_of)))
    return terms


def _write_unit_term(unit: Series, trig: Trig) -> Product:
    ((monomial, c),) = unit.parts[0].items()
    ring, sign = unit.ring, 1 if c > 0 else -1
    key = ("unit", monomial, trig, sign)
    if key not in ring.written:
        ring.written[key] = multiply(
            number(sign), letters(ring, monomial), _write_circular(ring, trig)
        )
    plain = cast("Product", ring.written[key])
    whole = unit.denominator == 1
    return Product(
        plain.number * (abs(c) if whole else Fraction(abs(c), unit.denominator)), plain.factors
    )


def _choose_shared(form: Form) -> tuple[tuple[int, int, int] | None, list[Trig]]:
    """Choose the sine or cosine that most terms share in the same power; return these terms too."""
    holders: dict[tuple[int, int, int], list[Trig]] = {}
    for trig in form:
        for factor in trig:
            holders.setdefault(factor, []).append(trig)
    best: tuple[tuple[int, int, int] | None, list[Trig]] = (None, [])
    for factor in sorted(holders):
        if len(holders[factor]) > max(1, len(best[1])):
            best = (factor, holders[factor])
    return best


def _divide_trig(trig: Trig, shared: Trig) -> Trig:
    """Divide a product of sines and cosines by a shared one."""
    taken = {(angle, sine): e for angle, sine, e in shared}
    left = [(angle, sine, e - taken.get((angle, sine), 0)) for angle, sine, e in trig]
    return tuple(factor for factor in left if factor[2])


def _factor_sum(polynomial: Series) -> Product:
    """Factor a polynomial without monomial content over the rationals if that is shorter."""
    ring = polynomial.ring
    terms = polynomial.parts[0]
    degrees = [dict(exponents(m)) for m in terms]
    coefficients = (Fraction(c, polynomial.denominator) for c in terms.values())
    plain = multiply(add(_gather(ring, list(zip(degrees, coefficients, strict=True)))))
    by_inertia = _collect_by_inertia(polynomial)
    if by_inertia is not None and size(by_inertia) < size(plain):
        plain = by_inertia
    # a linear sum cannot be factored, nor can two terms without powers and common letters
    linear = all(sum(d.values()) <= 1 for d in degrees)
    without = linear or (len(terms) == 2 and all(e == 1 for d in degrees for e in d.values()))
    if without or len(terms) > _LARGEST or max(map(abs, terms.values())) > MEASURED:
        return plain
    indices = sorted({i for d in degrees for i in d})
    rows = []
    for d in degrees:
        rows.append(tuple(d.get(i, 0) for i in indices))
    # negative powers are shifted out, as a polynomial has none
    if min(min(row) for row in rows) < 0:
        return plain
    content, factors = _factor(tuple(zip(rows, terms.values(), strict=True)))
    if len(factors) == 1 and factors[0][1] == 1:
        return plain
    out = [number(Fraction(content, polynomial.denominator))]
    for factor, e in factors:
        inner = []
        for row, c in factor:
            inner.append(_term(ring, Fraction(c), dict(zip(indices, row, strict=True))))
        out.append(multiply((add(inner), e)))
    factored = multiply(*out)
    return factored if size(factored) < size(plain) else plain


def _collect_by_inertia(polynomial: Series) -> Product | None:
    """Collect a sum by masses, moments of inertia and the like, if each term contains one."""
    # Js rp² + Jp rs² + 2 Jp rs rp + Jp rp² = Js rp² + Jp (rs + rp)²
    ring, terms = polynomial.ring, polynomial.parts[0]
    if not 2 < len(terms) <= _LARGEST:
        return None
    by_letter: dict[int, Polynomial] = {}
    for monomial, c in terms.items():
        held = [i for i, e in exponents(monomial) if e == 1 and _is_inertial(ring, i)]
        if len(held) != 1:
            return None
        by_letter.setdefault(held[0], {})[monomial - power(held[0])] = c
    if not 1 < len(by_letter) < len(terms):
        return None
    parts = []
    for index, inner in by_letter.items():
        rest = canonical(ring, {0: inner}, polynomial.denominator, polynomial.reach)
        parts.append(multiply(_letter(ring, index), factor_out({(): rest})))
    return multiply(add(parts))


def _is_inertial(ring: Ring, index: int) -> bool:
    """Whether a generator is a parameter other than a length, rate or acceleration."""
    generator = ring.generators[index]
    return generator.kind is Kind.PARAMETER and ring.places.get(generator.name, 0) == 0


_Rows: TypeAlias = "tuple[tuple[tuple[int, ...], int], ...]"
"""A polynomial, term by term: the powers of its letters, and the coefficient."""


@lru_cache(maxsize=1 << 12)
def _factor(rows: _Rows) -> tuple[int, tuple[tuple[_Rows, int], ...]]:
    """Return the number before a polynomial's factors, and each factor with its power."""
    # It is cached, as the same sum occurs in many coefficients of a mechanism's equations
    from sympy import ZZ
    from sympy import ring as polynomials

    letters = polynomials([f"x{i}" for i in range(len(rows[0][0]))], ZZ)[0]
    content, factors = list_factors(letters.from_dict({row: ZZ(c) for row, c in rows}))
    parts = []
    for factor, e in factors:
        parts.append((tuple((row, int(c)) for row, c in factor.terms()), e))
    return int(content), tuple(parts)


def list_factors(polynomial: Any) -> tuple[Any, list[tuple[Any, int]]]:
    """Return the number and the irreducible factors of a polynomial, with their powers.

    What is left of a x + b without the common factors of a and b is irreducible: letters of the
    first degree, as masses and forces are, spare a search that takes nearly all of sympy's time.
    """
    from sympy import Integer

    degrees = enumerate(polynomial.degrees())
    slopes = {letter: polynomial.coeff_wrt(letter, 1) for letter, most in degrees if most == 1}
    if not slopes:
        number, factors = polynomial.factor_list()
        return Integer(number), factors
    letter = min(slopes, key=lambda letter: len(slopes[letter]))
    common = slopes[letter].gcd(polynomial.coeff_wrt(letter, 0))
    number, factors = list_factors(common)
    rest = polynomial.exquo(common)
    sign = 1 if rest.LC > 0 else -1
    return sign * number, [*factors, (sign * rest, 1)]


def _gather(ring: Ring, rows: list[tuple[dict[int, int], Fraction]]) -> list[Product]:
    """Collect the terms of a sum by shared squares: a² b + a² c = a² (b + c)."""
    shared: dict[tuple[int, int, Fraction], int] = {}
    for degrees, c in rows:
        for index, e in degrees.items():
            # 3 m1 M + 3 m2 M = 3 (m1 + m2) M, but m1 M + m2 M stays
            size = Fraction(0) if e > 1 else c
            shared[index, e, size] = shared.get((index, e, size), 0) + (e > 1 or abs(c) > 1)
    best = max(shared, key=lambda letter: shared[letter], default=(0, 0, Fraction(0)))
    if shared.get(best, 0) < 2:
        return [_term(ring, c, d) for d, c in rows]
    index, e, size = best
    held = [(d, c) for d, c in rows if d.get(index) == e and size in (0, c)]
    outside = [row for row in rows if row not in held]
    common = dict(set.intersection(*({*d.items()} for d, _ in held)))
    inside = [(dict(d.items() - common.items()), c) for d, c in held]
    above, below = [c.numerator for _, c in inside], [c.denominator for _, c in inside]
    shared_number = Fraction(math.gcd(*above), math.lcm(*below))
    if (
        max(abs(c) for _, c in inside) > MEASURED * shared_number
    ):  # measured numbers share no factor
        shared_number = Fraction(1)
    inner = add(_gather(ring, [(d, c / shared_number) for d, c in inside]))
    powers = [_power(ring, i, k) for i, k in sorted(common.items())]
    drawn = multiply(number(shared_number), *powers, inner)
    return [drawn, *_gather(ring, outside)]


def _term(ring: Ring, c: Fraction, degrees: dict[int, int]) -> Product:
    return multiply(number(c), *(_power(ring, i, e) for i, e in degrees.items()))


def _power(ring: Ring, index: int, e: int) -> Product:
    """Return a power of a generator: a letter, or the definition of an atom without a name."""
    atom = ring.atoms.get(index)
    if atom is None or atom.named:
        return Product(1, ((_letter(ring, index), e),))
    if atom.function == "sqrt":
        return to_power(to_formula(atom.argument), Fraction(e, 2))
    if atom.function == "1":
        return to_power(to_formula(atom.argument), Fraction(e))
    return multiply((Call(atom.function, add([to_formula(atom.argument)])), e))


def to_power(inner: Product, e: Fraction) -> Product:
    """Return a power of a formula; a root keeps everything under one radical sign."""
    if e.denominator == 1:
        factors = [(base, own * e) for base, own in inner.factors]
        return multiply(number(Fraction(inner.number) ** int(e)), *factors)
    if inner.number == 1 and len(inner.factors) == 1 and inner.factors[0][1] == 1:
        return multiply((inner.factors[0][0], e))
    return Product(1, ((add([inner]), e),))


def _letter(ring: Ring, index: int) -> Letter:
    generator = ring.generators[index]
    place = PLACES.get(generator.kind, ring.places.get(generator.name, 0))
    return Letter(generator.name, (place, index), generator.kind is Kind.INPUT)


def _write_circular(ring: Ring, trig: Trig) -> Product:
    """Return a product of powers of sines and cosines, with sin(−x) as −sin x."""
    return multiply(*(_write_function(ring, factor) for factor in trig))


def _write_function(ring: Ring, factor: tuple[int, int, int]) -> Product:
    if factor not in ring.written:
        angle, sine, e = factor
        multiples, sign = dict(exponents(angle)), 1
        # a packed angle's last coefficient is positive; in print its first should be
        if next(iter(multiples.values())) < 0:
            multiples = {j: -k for j, k in multiples.items()}
            sign = -1 if sine and e % 2 else 1
        terms = []
        for j, k in multiples.items():
            ((_, monomial, c),) = ring.angles[j].argument.terms()
            terms.append(multiply(number(k * c), letters(ring, monomial)))
        call = Call("sin" if sine else "cos", add(terms))
        ring.written[factor] = Product(sign, ((call, e),))
    return cast("Product", ring.written[factor])


@lru_cache(maxsize=1 << 14)
def size(part: Product | Base) -> int:
    """Return how many symbols it takes to write a formula."""
    if isinstance(part, Letter):
        return 1
    if isinstance(part, Call):
        return 1 + size(part.argument)
    if isinstance(part, Sum):
        return sum(map(size, part.terms)) + len(part.terms) - 1
    total = int(abs(part.number) != 1 or not part.factors)
    for base, e in part.factors:
        total += size(base) + (e != 1)
    return total


def to_sympy(series: Series) -> Any:
    """Return a series as a sympy expression, factored and with the fewest symbols."""
    return to_formula(series).sympy()


def from_sympy(value: Any, places: Mapping[str, tuple[float, float]]) -> Product:
    """Return a sympy expression as a formula, its letters with these sort keys in products."""
    if value.is_Number:
        return number(Fraction(str(value)))
    if value.is_Symbol or value.is_NumberSymbol:  # a letter, or pi
        return multiply(Letter(str(value), places.get(str(value), (0, 0))))
    parts = [from_sympy(part, places) for part in value.args]
    if value.is_Add:
        return multiply(add(parts))
    if value.is_Mul:
        return multiply(*parts)
    if value.is_Pow:
        return to_power(parts[0], Fraction(str(value.exp)))
    return multiply(Call(value.func.__name__.lower(), add(parts)))


def to_matrix(rows: Iterable[Iterable[Series]]) -> Any:
    """Return rows of series as a sympy Matrix."""
    from sympy import Matrix

    return Matrix([list(map(to_sympy, row)) for row in rows])
