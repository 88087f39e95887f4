"""Write forces of springs between two points with the common factor k (1 − a/ρ)."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import final

from mecanique.derivation.printing.expressions import letters
from mecanique.derivation.printing.formulas import Product, add, multiply, number
from mecanique.derivation.printing.trigforms import cost, shortest
from mecanique.derivation.scalars.generators import Kind
from mecanique.derivation.scalars.monomials import exponent, exponents, power
from mecanique.derivation.scalars.polynomials import Parts
from mecanique.derivation.scalars.series import Basis, Series, canonical

_SIGNS = 5
"""Number of symbols in (1 − a/ρ), with brackets."""


@final
@dataclass(frozen=True)
class Stretch:
    """The force of a spring of free length a and length ρ: share × (1 − a/ρ).

    Args:
        share: the force for zero free length.
        ratio: the monomial a/ρ.
    """

    share: Series
    ratio: int

    def motion(self) -> Product:
        """Return 1 − a/ρ as a formula."""
        ratio = letters(self.share.ring, self.ratio)
        return multiply(add([number(1), multiply(number(-1), ratio)]))


def draw_stretches(series: Series) -> tuple[Series, list[Stretch]]:
    """Separate the forces of springs from a series, if that is shorter.

    Args:
        series: the left side of an equation of motion.
    """
    ring, found, rest = series.ring, list[Stretch](), series
    lengths = [i for i, atom in ring.atoms.items() if atom.named and atom.function == "sqrt"]
    for index in lengths:
        pull = _pull(rest, index)
        if pull is None:
            continue
        free = next(_free_lengths(pull), None)
        if free is None:
            continue
        share = -pull / _letter(ring, free)
        found.append(Stretch(share, power(free) - power(index)))
        rest = rest - share - pull / _letter(ring, index)
    if len(found) < 2:
        return series, []
    after = _count_signs(rest) + sum(_count_signs(one.share) + _SIGNS for one in found)
    return (rest, found) if after < _count_signs(series) else (series, [])


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
    return None if moving & {g.kind for g in pull.generators()} else pull


def _free_lengths(pull: Series) -> Iterator[int]:
    """Yield parameters common to all terms of a pull, the author's last one first."""
    ring = pull.ring
    held = [dict(exponents(monomial)) for _, monomial, _ in pull.terms()]
    for index in sorted(held[0], reverse=True):
        fixed = ring.generators[index].kind is Kind.PARAMETER
        if fixed and all(each.get(index, 0) > 0 for each in held):
            yield index


def _letter(ring: Basis, index: int) -> Series:
    return Series(ring, {0: {power(index): 1}}, 1, 1)


def _count_signs(series: Series) -> int:
    return cost(shortest(series, products=True)) if series else 0
