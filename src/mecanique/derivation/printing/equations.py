"""Bring equations of motion and expressions into the form in which a textbook prints them."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from fractions import Fraction
from typing import Any, NamedTuple, cast, final

from mecanique.derivation.printing.expressions import (
    collect_terms,
    factor_out,
    letters,
    size,
    to_formula,
    to_power,
)
from mecanique.derivation.printing.formulas import (
    MOVING,
    SUMS,
    Letter,
    Product,
    Sum,
    add,
    multiply,
    number,
    open_sum,
)
from mecanique.derivation.printing.trigforms import (
    Form,
    common_measure,
    content,
    cost,
    has_double_angles,
    scale,
    shortest,
)
from mecanique.derivation.printing.writers import Equation, Expression
from mecanique.derivation.scalars.cancel import tidy
from mecanique.derivation.scalars.polynomials import Parts, exponent, exponents, power
from mecanique.derivation.scalars.series import GIVEN, Kind, Ring, Series, canonical
from mecanique.derivation.tolerances import MEASURED
from mecanique.errors import DerivationError
from mecanique.wording import OF_SHAPES


def draw_divisor(terms: Sequence[Product]) -> list[Product]:
    """Merge the first two terms into one product, if both are divided by the same sum."""
    # m q''/s + m q q'²/s² = m (q'' + q q'²/s)/s, where that takes fewer symbols
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


def _draw_factors(terms: Sequence[Product]) -> Sequence[Product]:
    """Return terms as one product, with the factors that all share in front, if these are many."""
    shared = terms[0].factors if terms else ()
    for term in terms:
        shared = tuple(factor for factor in shared if factor in term.factors)
    if len(shared) < _MANY:
        return terms
    above = math.gcd(*(term.number.numerator for term in terms))
    measure = Fraction(above, math.lcm(*(term.number.denominator for term in terms)))
    inverse = Product(1 / measure, tuple((base, -power) for base, power in shared))
    inner = Sum(tuple(multiply(term, inverse) for term in terms))
    return [multiply(number(measure), *shared, inner)]


_MANY = 3
"""So many factors at least are put before a sum of terms that share them."""


_RANKED = (
    Kind.ACCELERATION,
    Kind.VELOCITY,
    Kind.COORDINATE,
    Kind.INPUT,
    Kind.REACTION,
    Kind.VARIATION,
)

_MOVING = (Kind.ACCELERATION, Kind.VELOCITY, Kind.INPUT, Kind.REACTION, Kind.VARIATION)

_STATE = (Kind.ACCELERATION, Kind.VELOCITY)

Group = tuple[tuple[bool, int], Series]


def group(series: Series, *, by_side: bool) -> list[Group]:
    """Group by monomials of motions and lengths: ((on the right, monomial), coefficient)."""
    ring = series.ring
    kinds = [g.kind for g in ring.generators]
    depends = {i: atom.argument.kinds for i, atom in ring.atoms.items()}
    turns = [angle.argument.kinds for angle in ring.angles]
    held = {}
    for monomial in set().union(*series.parts.values()):
        powers = exponents(monomial)
        own = {kinds[i] for i, _ in powers}.union(*(depends.get(i, set()) for i, _ in powers))
        moving = sum(power(i, e) for i, e in powers if kinds[i] in _MOVING)
        lengths = sum(power(i, e) for i, e in powers if kinds[i] is Kind.COORDINATE and e > 0)
        held[monomial] = own, moving, lengths
    parts: dict[tuple[bool, int], Parts] = {}
    for trig, polynomial in series.parts.items():
        turning = set().union(*(turns[j] for j, _ in exponents(trig >> 1)))
        for monomial, c in polynomial.items():
            own, moving, lengths = held[monomial]
            involved = turning | own
            key = moving if moving or Kind.COORDINATE in turning else lengths
            moves = not involved.isdisjoint(_STATE)
            alone = not moves and Kind.COORDINATE not in involved
            forcing = by_side and not moves and Kind.INPUT in involved
            forcing = forcing or (by_side and alone and Kind.TIME in involved)
            parts.setdefault((forcing, key), {}).setdefault(trig, {})[monomial - key] = c
    groups = [(k, canonical(ring, p, series.denominator, series.reach)) for k, p in parts.items()]
    return sorted(groups, key=lambda group: (group[0][0], _rank(ring, group[0][1])))


def _rank(ring: Ring, key: int) -> tuple[object, ...]:
    """Return a sort key: accelerations, then velocities, then lengths, then the rest."""
    # Higher powers of motions come first, but lower powers of lengths
    powers = dict(exponents(key))
    degrees: dict[Kind, list[int]] = {kind: [] for kind in _RANKED}
    for generator in ring.generators:
        if generator.kind in degrees:
            degrees[generator.kind].append(-powers.get(generator.index, 0))
    motion = [sum(degrees[kind]) for kind in _RANKED[:2]]
    lengths = -sum(degrees[Kind.COORDINATE])
    return (*motion, lengths or math.inf, *(tuple(degrees[kind]) for kind in _RANKED))


def accelerates(ring: Ring, key: int) -> bool:
    """Return whether a monomial contains an acceleration."""
    return any(ring.generators[i].kind is Kind.ACCELERATION for i, _ in exponents(key))


_SIGNS = 5
"""Number of symbols in (1 − a/ρ), with brackets."""


@final
@dataclass(frozen=True)
class Stretch:
    """The force of a spring of free length a and length ρ: share × (1 − a/ρ)."""

    share: Series  # the force for zero free length
    ratio: int  # the monomial a/ρ

    def motion(self) -> Product:
        """Return 1 − a/ρ as a formula."""
        ratio = letters(self.share.ring, self.ratio)
        return multiply(add([number(1), multiply(number(-1), ratio)]))


def draw_stretches(series: Series) -> tuple[Series, list[Stretch]]:
    """Separate the forces of springs from a series, if that is shorter."""
    ring, stretches, rest = series.ring, list[Stretch](), series
    lengths = [i for i, atom in ring.atoms.items() if atom.named and atom.function == "sqrt"]
    for index in lengths:
        pull = _pull(rest, index)
        if pull is None:
            continue
        free = next(_free_lengths(pull), None)
        if free is None:
            continue
        share = -pull / ring.monomial(power(free))
        stretches.append(Stretch(share, power(free) - power(index)))
        rest = rest - share - pull / ring.monomial(power(index))
    if len(stretches) < 2:
        return series, []
    after = _count_signs(rest) + sum(_count_signs(stretch.share) + _SIGNS for stretch in stretches)
    return (rest, stretches) if after < _count_signs(series) else (series, [])


def _pull(series: Series, index: int) -> Series | None:
    """Return the coefficient of 1/ρ, if ρ appears in no other way and without motions."""
    ring = series.ring
    parts: Parts = {}
    for trig, polynomial in series.parts.items():
        for monomial, c in polynomial.items():
            e = exponent(monomial, index)
            if e not in (0, -1):
                return None
            if e:
                parts.setdefault(trig, {})[monomial + power(index)] = c
    if not parts:
        return None
    pull = canonical(ring, parts, series.denominator, series.reach)
    moving = {Kind.VELOCITY, Kind.ACCELERATION, Kind.INPUT, Kind.TIME}
    return None if moving & pull.kinds else pull


def _free_lengths(pull: Series) -> Iterator[int]:
    """Yield parameters common to all terms of a pull, the author's last one first."""
    ring = pull.ring
    held = [dict(exponents(monomial)) for _, monomial, _ in pull.terms()]
    for index in sorted(held[0], reverse=True):
        fixed = ring.generators[index].kind is Kind.PARAMETER
        if fixed and all(each.get(index, 0) > 0 for each in held):
            yield index


def _count_signs(series: Series) -> int:
    return cost(shortest(series, products=True)) if series else 0


_LONG = 150
"""Equations with more terms are tried in one style only, that of sums of angles."""

_GAIN = 2
"""Single angles are preferred to double angles if they take at most this many symbols more."""


def equations(
    elements: Sequence[Series], *, monic: bool | None = None, own: Sequence[str] = ()
) -> tuple[Equation, ...]:
    """Return equations of motion element = 0 in textbook form."""
    # The terms of each are collected by accelerations, velocities, inputs and lengths, and divided
    # by their common factors: a rational number, a monomial of parameters, and a sum of parameters
    # and time. No equation is ever divided by a coordinate.
    divide = len(elements) == 1 if monic is None else monic
    names = [*own, *[""] * (len(elements) - len(own))]
    return tuple(_form_equation(*pair, divide) for pair in zip(elements, names, strict=True))


def root(series: Series) -> Expression:
    """Return the square root of a series as a printed expression."""
    return Expression((to_power(to_formula(series), Fraction(1, 2)),), _in_decimals(series))


def half_square(factor: Series, base: Series) -> Expression:
    """Return half a factor times a square that is not expanded, e.g. ½ k (q2 − q1)²."""
    inner = add(expression(base).terms)
    whole = multiply(number(Fraction(1, 2)), to_formula(factor), (inner, 2))
    return Expression((whole,), _in_decimals(factor))


def half_squares(squares: Sequence[tuple[Series, Series]]) -> Expression:
    """Return Σ ½ I w², the squares with the same factor I together, none expanded."""
    alike: dict[Series, list[Series]] = {}
    for factor, base in squares:
        alike.setdefault(factor, []).append(base)
    terms = []
    for factor, bases in alike.items():
        inner = add([multiply((add(expression(base).terms), 2)) for base in bases])
        terms.append(multiply(number(Fraction(1, 2)), to_formula(factor), (inner, 1)))
    return Expression(tuple(terms), any(map(_in_decimals, alike)))


def energy(series: Series) -> Expression:
    """Return a kinetic or potential energy, like squares or functions together: m (x'² + y'²)/2."""
    return gather_alike(expression(series))


def gather_alike(whole: Expression) -> Expression:
    """Put together what the same parameters multiply: squares of velocities, or positions."""
    alike: dict[tuple[Any, ...], list[Product]] = {}
    for k, term in enumerate(whole.terms):
        moving = tuple(factor for factor in term.factors if factor[0].place[0] >= SUMS)
        held = tuple(factor for factor in term.factors if factor not in moving)
        rates = [power for base, power in moving if base.place[0] == MOVING]
        lone = not moving or rates not in ([], [2]) or not (held or abs(term.number) != 1)
        lone |= any(isinstance(base, Sum) and power == 1 for base, power in moving)
        key = (term.number, held, k if lone else -1)
        alike.setdefault(key, []).append(Product(1, moving))
    terms = []
    for (factor, held, _), parts in alike.items():
        ordered = sorted(parts, key=lambda part: len(part.factors))
        inner = parts[0].factors if len(parts) == 1 else ((Sum(tuple(ordered)), 1),)
        terms.append(multiply(Product(factor, held), *inner))
    return replace(whole, terms=tuple(terms))


def add_weighted(parts: Sequence[tuple[Series, Series]]) -> Expression:
    """Return Σ c w with each sum w in brackets."""
    terms = list[Product]()
    for factor, base in parts:
        if len(base) == 1:
            terms += expression(tidy(factor * base)).terms
        else:
            terms.append(multiply(to_formula(factor), (add(expression(base).terms), 1)))
    return Expression(tuple(terms), any(_in_decimals(factor) for factor, _ in parts))


def bracket(series: Series, factor: Series) -> Expression:
    """Return a product as one term, or as a factor after a sum in the order of an equation."""
    whole, inner, sign = expression(series * factor), expression(series), 1
    if len(whole.terms) == 1:
        return whole
    if 2 * sum(term.number < 0 for term in inner.terms) > len(inner.terms):
        inner, sign = expression(-series), -1
    return replace(inner, terms=(multiply(number(sign), Sum(inner.terms), to_formula(factor)),))


def join(parts: Iterable[Expression]) -> Expression:
    """Return the sum of expressions, each left as it is."""
    expressions = list(parts)
    terms = tuple(term for part in expressions for term in part.terms)
    return Expression(terms, any(part.decimals for part in expressions))


def shorter(one: Expression, other: Expression) -> Expression:
    """Return the expression that takes fewer symbols."""
    sizes = [sum(map(size, each.terms)) + len(each.terms) for each in (one, other)]
    return one if sizes[0] <= sizes[1] else other


def expression(series: Series) -> Expression:
    """Return a series, e.g. a kinetic energy, in textbook order, with the fewest symbols."""
    parts = []
    bare, stretches = draw_stretches(series)
    for (_, key), part in group(bare, by_side=False):
        parts += _split_group(series.ring, key, shortest(tidy(part), products=True))
    shares = [factor_out(shortest(tidy(one.share), products=True)) for one in stretches]
    pulls = [multiply(share, one.motion()) for share, one in zip(shares, stretches, strict=True)]
    pulled = [_Part(0, pull, number(1)) for pull in _draw_factors(pulls)]
    whole = _expression(series, [*parts, *pulled])
    ahead = next((k for k, term in enumerate(whole.terms) if term.number > 0), 0)
    order = (*whole.terms[ahead : ahead + 1], *whole.terms[:ahead], *whole.terms[ahead + 1 :])
    return replace(whole, terms=order)


@final
class _Part(NamedTuple):
    """A term of an equation: a coefficient times a monomial of motions and lengths."""

    key: int
    factor: Product
    motion: Product  # the monomial as a formula

    def divide(self, by: Sum) -> _Part:
        """Return the term divided by one of its factors, a sum that may have the opposite sign."""
        held = any(base == by for base, _ in self.factor.factors)
        sign = number(1 if held else -1)
        quotient = multiply(sign, self.factor, (by if held else by.negative(), -1))
        return self._replace(factor=quotient)

    def negate(self) -> _Part:
        """Return the term with the opposite sign."""
        return self._replace(factor=multiply(number(-1), self.factor))

    def term(self) -> Product:
        """Return the term as one product."""
        return multiply(self.factor, self.motion)


def _form_equation(element: Series, own: str, divide: bool) -> Equation:
    if not element:
        raise DerivationError(
            f"{own or 'a coordinate'} moves nothing that has mass, against no force, so that it "
            f"has no equation of motion; give what it moves mass and inertia ({OF_SHAPES})"
        )
    ring = element.ring
    bare, stretches = draw_stretches(element)
    groups = group(bare, by_side=True)
    ordinary = len(groups)
    groups += [((False, 0), one.share) for one in stretches]
    candidates = []
    # only one style is tried for long equations: with many angles sums are shorter
    styles = (True, False) if has_double_angles(element) else (True,)
    for products in styles if len(element) <= _LONG else (False,):
        forms = [shortest(part, products=products) for _, part in groups]
        divisor = _find_divisor(ring, groups, forms, divide)
        forms = [scale(form, 1 / divisor) for form in forms]
        candidates.append((products, forms, divisor))
    _, forms, divisor = candidates[0] if len(candidates) == 1 else min(candidates, key=_cost)
    sides: dict[bool, list[_Part]] = {False: [], True: []}
    whole = zip(groups[:ordinary], forms[:ordinary], strict=True)
    for ((is_right, key), _), form in whole:
        sides[is_right] += _split_group(ring, key, form)
    for one, form in zip(stretches, forms[ordinary:], strict=True):
        sides[False].append(_Part(0, factor_out(form), one.motion()))
    left, right = sides[False], [part.negate() for part in sides[True]]
    shared = _find_shared_sum([part.factor for part in (*left, *right)])
    if shared is not None:
        left, right = [p.divide(shared) for p in left], [p.divide(shared) for p in right]
        divisor = divisor * _to_series(ring, shared)
    mine = power(ring.index(own)) if own else -1
    inertia = next((part for part in left if part.key == mine), [*left, *right][0])
    if inertia.factor.number < 0:
        left, right = [p.negate() for p in left], [p.negate() for p in right]
        divisor = -divisor
    if left and left[0].factor.number < 0 and inertia in left:
        left.remove(inertia)  # first, as an equation does not begin with a minus
        left.insert(0, inertia)
    whole_left = _expression(element, left)
    whole_left = replace(whole_left, terms=tuple(draw_divisor(whole_left.terms)))
    return Equation(whole_left, _expression(element, right), divisor)


def _cost(candidate: tuple[bool, list[Form], Series]) -> int:
    products, forms, _ = candidate
    return sum(map(cost, forms)) - (_GAIN if products else 0)


def _split_group(ring: Ring, key: int, form: Form) -> list[_Part]:
    """Return a group's terms: one, or each by itself where the group multiplies no motion."""
    if key:
        return [_Part(key, factor_out(form), letters(ring, key))]
    return [_Part(0, part, number(1)) for term in collect_terms(form) for part in open_sum(term)]


def _find_shared_sum(factors: Sequence[Product]) -> Sum | None:
    """Find a sum of parameters and time that divides all factors; None without one."""
    for base, power_of in factors[0].factors:
        if isinstance(base, Sum) and power_of > 0 and _is_given(base):
            either = (base, base.negative())
            if all(_holds(factor, either) for factor in factors):
                return base
    return None


def _holds(factor: Product, sums: Sequence[Sum]) -> bool:
    return any(base in sums and power_of > 0 for base, power_of in factor.factors)


def _is_given(whole: Sum) -> bool:
    """Whether a sum contains only parameters and time."""
    inner = [base for term in whole.terms for base, _ in term.factors]
    return all(isinstance(b, Letter) and (b.place[0] < SUMS or b.name == "t") for b in inner)


def _to_series(ring: Ring, whole: Sum) -> Series:
    """Convert a sum of letters into a series."""
    terms = []
    for term in whole.terms:
        product = ring.number(term.number)
        for base, power_of in term.factors:
            if isinstance(base, Letter):
                product = product * ring[base.name] ** int(power_of)
        terms.append(product)
    return ring.sum(terms)


def _find_divisor(ring: Ring, groups: list[Group], forms: list[Form], divide: bool) -> Series:
    """Return the divisor of an equation: a number times a monomial of parameters."""
    first = forms[0]
    if divide and first.keys() == {()} and first[()].is_unit and accelerates(ring, groups[0][0][1]):
        unit = first[()]
        if unit.kinds <= {*GIVEN, Kind.ATOM}:
            return unit
    shared = content(forms)
    forces = list[Series]()
    for ((_, key), _), form in zip(groups, forms, strict=True):
        if any(ring.generators[i].kind is Kind.REACTION for i, _ in exponents(key)):
            forces += form.values()
    if forces:
        # an unknown force keeps its plain lever arm: its fractions are not cleared
        ((_, _, number_of),) = shared.terms()
        shared = shared * (common_measure(forces) / number_of)
    return shared


def _expression(series: Series, parts: Sequence[_Part]) -> Expression:
    terms = [part.term() for part in parts]
    # terms that differ in one letter are merged: k q2 − k q1 = k (q2 − q1)
    paired: list[Product] = []
    seats: dict[Any, int] = {}
    for term in terms:
        rest, letter = _split(term)
        seat = seats.get(rest) if letter is not None else None
        if seat is None or paired[seat].number * term.number > 0:
            seats[rest] = len(paired)
            paired.append(term)
            continue
        other = paired[seat]
        (*before, (first, _)), sign = other.factors, other.number
        own = cast("Letter", letter)
        both = add([Product(1, ((first, 1),)), Product(-1, ((own, 1),))])
        paired[seat] = multiply(number(sign), *before, both)
        del seats[rest]
    return Expression(tuple(paired), _in_decimals(series))


def _split(term: Product) -> tuple[Any, Letter | None]:
    """Split a force law's term into a coefficient and its last letter, a length or velocity."""
    *before, (last, e) = term.factors or [(Letter("", (0, 0)), 0)]
    plain = all(isinstance(base, Letter) for base, _ in term.factors) and e == 1 and before
    moving = any(base.place[0] > MOVING for base, _ in term.factors)
    if not plain or moving or not isinstance(last, Letter):
        return None, None
    kind = last.place[0] == MOVING
    return (abs(term.number), tuple(before), kind), last


def _in_decimals(series: Series) -> bool:
    """Whether a series has measured numbers, as from URDF, rather than fractions of a law."""
    if not any(g.kind is Kind.PARAMETER for g in series.ring.generators):
        return True
    return series.denominator > MEASURED
