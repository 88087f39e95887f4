"""Poisson series as factor_out sympy expressions; sympy factors polynomials, nothing else.

sympy takes half a second to import, so it is imported when the first expression is made.
"""

from __future__ import annotations

from collections.abc import Iterable
from fractions import Fraction
from functools import lru_cache
from typing import Any, TypeAlias

from mecanique.derivation.printing.trigforms import (
    Form,
    Trig,
    common_monomial,
    common_number,
    shortest,
)
from mecanique.derivation.scalars.monomials import exponents, largest_exponent
from mecanique.derivation.scalars.polynomials import shift
from mecanique.derivation.scalars.series import Atom, Basis, Kind, Series

__all__ = ["Expr", "collect_terms", "definition", "factor_out", "letters", "to_sympy"]

Expr: TypeAlias = Any
"""A sympy expression. Products of a number and a sum stay, where sympy would expand them."""

_LARGEST = 40  # polynomials with more terms are not worth factoring


def to_sympy(series: Series) -> Expr:
    """Return a series as a sympy expression, factor_out and with the fewest signs.

    Args:
        series: the series; velocities and accelerations become symbols q', q''.
    """
    return factor_out(shortest(series, products=True))


def letters(ring: Basis, monomial: int) -> Expr:
    """Return a monomial as a sympy expression; atoms without a name are written out."""
    return _product([_letter(ring, i) ** e for i, e in exponents(monomial)])


def factor_out(form: Form) -> Expr:
    """Return a form as one expression, with everything common to all terms before it.

    Args:
        form: polynomials before products of sines and cosines.
    """
    from sympy import Add, Integer

    if not form:
        return Integer(0)
    polynomials = list(form.values())
    ring = polynomials[0].ring
    common, number = common_monomial(polynomials), common_number(polynomials)
    inner = {t: _divide(p, number, common) for t, p in form.items()}
    terms = collect_terms(inner)
    if len(terms) == 1:
        return _product([_number(number), letters(ring, common), terms[0]])
    return _product([_number(number), letters(ring, common), Add(*terms)])


def collect_terms(form: Form) -> list[Expr]:
    """Return a form as terms, those that share a sine, cosine or sum of parameters as one.

    Args:
        form: polynomials before products of sines and cosines.
    """
    terms: list[Expr] = []
    while form:
        factor, members = _choose_shared(form)
        if factor is None:
            break
        inner = {_without(t, factor): form[t] for t in members}
        terms.append(
            _product([factor_out(inner), _circular(next(iter(form.values())).ring, (factor,))])
        )
        form = {t: p for t, p in form.items() if t not in members}
    sums: dict[Series, Form] = {}
    for trig, polynomial in form.items():
        common, number = common_monomial([polynomial]), common_number([polynomial])
        primitive = _divide(polynomial, number, common)
        if _is_negative(primitive):
            primitive, number = -primitive, -number
        unit = _divide(polynomial.ring.number(1), 1 / number, -common)
        sums.setdefault(primitive, {})[trig] = unit
    for primitive, members_of in sums.items():
        if primitive == 1:
            terms += [_unit_term(unit, trig) for trig, unit in members_of.items()]
        else:
            terms.append(_product([_factored_sum(primitive), factor_out(members_of)]))
    return terms


def _unit_term(unit: Series, trig: Trig) -> Expr:
    ((_, monomial, c),) = unit.terms()
    return _product([_number(c), letters(unit.ring, monomial), _circular(unit.ring, trig)])


def _choose_shared(form: Form) -> tuple[tuple[int, int, int] | None, list[Trig]]:
    """The sine or cosine that most terms share, in the same power, and these terms."""
    best: tuple[tuple[int, int, int] | None, list[Trig]] = (None, [])
    for factor in sorted({f for trig in form for f in trig}):
        members = [trig for trig in form if factor in trig]
        if len(members) > max(1, len(best[1])):
            best = (factor, members)
    return best


def _without(trig: Trig, factor: tuple[int, int, int]) -> Trig:
    return tuple(f for f in trig if f != factor)


def _divide(polynomial: Series, number: Fraction, monomial: int) -> Series:
    # shifted by hand: a product would lower powers of roots again
    parts = shift(polynomial.parts, -monomial)
    reach = polynomial.reach + largest_exponent([monomial])
    return Series(polynomial.ring, parts, polynomial.denominator, reach) * (1 / number)


def _is_negative(polynomial: Series) -> bool:
    """Whether most of its terms are negative, or half of them and the first."""
    signs = [1 if c > 0 else -1 for c in polynomial.parts[0].values()]
    first = polynomial.parts[0][min(polynomial.parts[0])]
    return sum(signs) < 0 or (sum(signs) == 0 and first < 0)


def _factored_sum(polynomial: Series) -> Expr:
    """A polynomial without monomial content, factored over the rationals."""
    from sympy import Add

    ring = polynomial.ring
    terms = polynomial.parts[0]
    degrees = [dict(exponents(m)) for m in terms]
    # a linear sum, or two terms without powers and common letters, cannot be factored
    linear = all(sum(d.values()) <= 1 for d in degrees)
    plain = linear or (len(terms) == 2 and all(e == 1 for d in degrees for e in d.values()))
    if not plain and len(terms) <= _LARGEST:
        indices = sorted({i for d in degrees for i in d})
        rows = []
        for d in degrees:
            rows.append(tuple(d.get(i, 0) for i in indices))
        number, factors = _factor(tuple(zip(rows, terms.values(), strict=True)))
        if len(factors) > 1 or factors[0][1] > 1:
            out = [_number(number / polynomial.denominator)]
            for factor, e in factors:
                inner = [_term(ring, c, dict(zip(indices, row, strict=True))) for row, c in factor]
                out.append(Add(*inner) ** e)
            return _product(out)
    coefficients = (Fraction(c, polynomial.denominator) for c in terms.values())
    return Add(*_gather(ring, list(zip(degrees, coefficients, strict=True))))


_Rows: TypeAlias = "tuple[tuple[tuple[int, ...], int], ...]"
"""A polynomial: the powers of its letters and the coefficient, term by term."""


@lru_cache(maxsize=1 << 12)
def _factor(rows: _Rows) -> tuple[Fraction, tuple[tuple[_Rows, int], ...]]:
    """Return the number before a polynomial's factors, and each factor with its power.

    The same sum stands in many coefficients of a mechanism's equations.
    """
    from sympy import Poly, Symbol

    symbols = [Symbol(f"x{i}") for i in range(len(rows[0][0]))]
    number, factors = Poly.from_dict(dict(rows), *symbols).factor_list()
    found = []
    for factor, power in factors:
        terms = tuple((row, int(c)) for row, c in factor.terms())
        found.append((terms, power))
    return Fraction(int(number.p), int(number.q)), tuple(found)


def _gather(ring: Basis, rows: list[tuple[dict[int, int], Fraction]]) -> list[Expr]:
    """Terms of a sum without factors; a shared square is drawn out, a² b + a² c = a² (b + c)."""
    from sympy import Add

    shared: dict[tuple[int, int], int] = {}
    for degrees, _ in rows:
        for letter in degrees.items():
            shared[letter] = shared.get(letter, 0) + (letter[1] > 1)
    best = max(shared, key=lambda letter: shared[letter], default=(0, 0))
    if shared.get(best, 0) < 2:
        return [_term(ring, c, d) for d, c in rows]
    index, e = best
    inside, outside = [], []
    for d, c in rows:
        if d.get(index) == e:
            inside.append(({i: k for i, k in d.items() if i != index}, c))
        else:
            outside.append((d, c))
    return [
        _product([_letter(ring, index) ** e, Add(*_gather(ring, inside))]),
        *_gather(ring, outside),
    ]


def _term(ring: Basis, c: int | Fraction, degrees: dict[int, int]) -> Expr:
    return _product(
        [_number(Fraction(c)), *(_letter(ring, i) ** e for i, e in degrees.items() if e)]
    )


def _letter(ring: Basis, index: int) -> Expr:
    from sympy import Symbol, pi

    generator = ring.generators[index]
    atom = ring.atoms.get(index)
    if atom is None or atom.named:
        return (
            pi
            if generator.kind is Kind.CONSTANT and generator.name == "pi"
            else Symbol(generator.name)
        )
    return definition(atom)


def definition(atom: Atom) -> Expr:
    """Return what an atom stands for, e.g. √(x² + h²), as a sympy expression.

    Args:
        atom: a function adjoined to a ring.
    """
    from sympy import Abs, acos, asin, atan, exp, log, sign, sqrt, tanh

    inner = to_sympy(atom.argument)
    functions = {
        "sqrt": sqrt,
        "exp": exp,
        "log": log,
        "asin": asin,
        "acos": acos,
        "atan": atan,
        "tanh": tanh,
    }
    functions |= {"Abs": Abs, "sign": sign, "1": lambda u: u}
    return functions[atom.function](inner)


def _circular(ring: Basis, trig: Trig) -> Expr:
    """A product of powers of sines and cosines; the sign of sin(−x) is drawn out."""
    from sympy import Integer, cos, sin

    sign, factors = 1, []
    for angle, sine, e in trig:
        multiples = dict(exponents(angle))
        # the packed angle is positive by its last part; in print the first should be
        if next(iter(multiples.values())) < 0:
            multiples = {j: -k for j, k in multiples.items()}
            sign *= -1 if sine and e % 2 else 1
        argument = _argument(ring, multiples)
        factors.append((sin if sine else cos)(argument, evaluate=False) ** e)
    return _product([Integer(sign), *factors])


def _argument(ring: Basis, multiples: dict[int, int]) -> Expr:
    from sympy import Add

    terms = []
    for j, k in multiples.items():
        ((_, monomial, c),) = ring.angles[j].argument.terms()
        terms.append(_product([_number(k * c), letters(ring, monomial)]))
    return Add(*terms)


def _number(number: Fraction) -> Expr:
    from sympy import Rational

    return Rational(number.numerator, number.denominator)


def _product(factors: Iterable[Expr]) -> Expr:
    """A product without factors 1, its numbers as one, its sums not expanded."""
    from sympy import Integer, Mul

    number, rest = Integer(1), []
    for factor in factors:
        for part in factor.args if factor.is_Mul else (factor,):
            if part.is_Rational:
                number = number * part
            else:
                rest.append(part)
    if not rest or number == 0:
        return number
    if number != 1:
        rest.insert(0, number)
    if len(rest) == 1:
        return rest[0]
    sums = any(part.is_Add for part in rest)
    return Mul(*rest, evaluate=not sums)
