"""Call the constant inertias of a top by letters, as a book does, in what its equations come to."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from fractions import Fraction
from functools import partial
from typing import cast, final

from mecanique.derivation.printing.equations import expression, join, shorter
from mecanique.derivation.printing.writers import Expression
from mecanique.derivation.scalars.cancel import tidy
from mecanique.derivation.scalars.polynomials import exponents
from mecanique.derivation.scalars.series import GIVEN, Series, canonical
from mecanique.derivation.symbolic.derivation import Derivation, Left, Matrix, Result
from mecanique.derivation.symbolic.symbols import Algebra, coordinate_of
from mecanique.wording import enumerate_words


@final
@dataclass(frozen=True)
class NamedInertias:
    """Letters for constants in a mass matrix, which consists of them alone."""

    definitions: tuple[Result, ...] = ()
    sentence: str = ""
    unknowns: Mapping[str, str] = field(default_factory=dict)
    # products of parameters, packed, each with the sum that takes its place
    sums: tuple[tuple[int, Series], ...] = ()

    def __call__(self, series: Series) -> Series:
        """Return a series in the letters."""
        for product, whole in self.sums:
            series = _replace(series, product, whole)
        return tidy(series) if self.sums else series

    def rewrite(self, derivation: Derivation) -> Derivation:
        """Return equations of motion in the letters."""
        M = tuple(tuple(map(self, row)) for row in derivation.M)
        unknowns = {**derivation.unknowns, **self.unknowns}
        return replace(derivation, M=M, h=tuple(map(self, derivation.h)), unknowns=unknowns)


_PLAIN = NamedInertias()


def name_inertias(algebra: Algebra, M: Matrix) -> NamedInertias:
    """Return letters for the constants of M, if some on its diagonal are sums and all else is."""
    known, key = algebra.ring.written, ("inertias", M)
    if key not in known:  # asked for again they bear the same names
        known[key] = _name(algebra, M)
    return cast("NamedInertias", known[key])


def _name(algebra: Algebra, M: Matrix) -> NamedInertias:
    """Choose letters for the constants of M."""
    ring, names = algebra.ring, [*map(coordinate_of, algebra.velocities)]
    diagonal = {name: row[k] for k, (name, row) in enumerate(zip(names, M, strict=bool(M)))}
    upright = [_find_upright(inertia) for inertia in diagonal.values() if inertia.turns()]
    constant = [name for name, inertia in diagonal.items() if inertia.kinds <= GIVEN]
    # of motions with constant inertias alone, and of particles, those are short enough
    if len(constant) == len(diagonal) or all(len(diagonal[name]) < 2 for name in constant):
        return _PLAIN
    named, letters = _PLAIN, dict[str, str]()
    for name in sorted(diagonal, key=lambda name: (name not in constant, len(diagonal[name]))):
        inertia = named(diagonal[name])
        generators = [generator.name for generator in inertia.generators()]
        if name in constant and len(generators) == 1 and inertia == ring[generators[0]]:
            letters[generators[0]] = ""  # which is short enough
            continue
        loose = [part for part in inertia.split() if _is_loose(part, letters)]
        if loose:
            letter = ring.choose_name((f"J_{name}", f"I_{name}", f"inertia_{name}"))
            letters[letter] = name
            moment = inertia if name in constant else ring.sum(loose)
            terms = [(product, c) for part in loose for _, product, c in part.terms()]
            product, c = min(terms, key=lambda term: sum(term[0] in sums for sums in upright))
            rest = moment - ring.monomial(product) * c
            whole = (ring.parameter(letter) - rest) / c
            shown = diagonal[name] if name in constant else moment
            definition = Result(Left(letter), shown, partial(_write_parts, shown))
            named = replace(
                named,
                definitions=(*named.definitions, definition),
                sums=(*named.sums, (product, whole)),
            )
    left = [generator.name for row in M for entry in row for generator in named(entry).generators()]
    if not letters or not {*left} <= {*letters, *algebra.mechanism.coordinates}:
        return _PLAIN
    referred = {letter: name for letter, name in letters.items() if name in constant}
    be, meaning = "is" if len(referred) == 1 else "are", _write_meaning([*referred.values()])
    said = f"{enumerate_words([*referred])} {be} the {meaning}"
    linear = {q for joint in algebra.mechanism.joints for q in joint.linear_coordinates}
    unknowns = dict[str, str]()
    for letter, name in letters.items():
        if name:
            of = "" if name in constant else "constant rest of the "
            unit = "kg" if name in linear else "kg·m²"
            unknowns[letter] = f"{of}{_write_meaning([name])} [{unit}]"
        if name and name not in constant:
            said += f", {letter} the constant rest of that referred to {name}"
    return replace(named, sentence=f"{said}.", unknowns=unknowns)


def _write_meaning(names: Sequence[str]) -> str:
    return f"inerti{'a' if len(names) == 1 else 'as'} referred to {enumerate_words(names)}"


def _find_upright(series: Series) -> set[int]:
    """Return the products of parameters in a series where all its angles are zero."""
    sums = dict[int, Fraction]()
    for trig, product, c in series.terms():
        sums[product] = sums.get(product, Fraction(0)) + (0 if trig & 1 else c)
    return {product for product, total in sums.items() if total}


def _is_loose(part: Series, letters: Mapping[str, str]) -> bool:
    """Return whether a term is constant, without letters yet."""
    names = {generator.name for generator in part.generators()}
    return bool(names) and part.kinds <= GIVEN and letters.keys().isdisjoint(names)


def _write_parts(series: Series) -> Expression:
    """Return a sum as it is, or with its numbers in each of its terms, if shorter."""
    return shorter(join(map(expression, series.split())), expression(series))


def _replace(series: Series, product: int, whole: Series) -> Series:
    """Put a sum in place of a product of parameters."""
    kept, divided = dict[int, dict[int, int]](), dict[int, dict[int, int]]()
    for trig, polynomial in series.parts.items():
        for monomial, c in polynomial.items():
            powers = dict(exponents(monomial))
            contains = all(powers.get(i, 0) >= e for i, e in exponents(product))
            parts, left = (divided, monomial - product) if contains else (kept, monomial)
            parts.setdefault(trig, {})[left] = c
    given, taken = (
        canonical(series.ring, parts, series.denominator, series.reach) for parts in (kept, divided)
    )
    return given + taken * whole
