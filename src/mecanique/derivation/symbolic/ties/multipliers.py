"""Solve for the multipliers of loops in closed form, one after another, from the balances alone.

The balance of each velocity k is Σ λ ∂Φ/∂q_k = (M a + h − Q)_k. A balance with a single unknown
multiplier gives that multiplier. From two balances with the same one it is eliminated by cross
multiplication, which avoids division by an expression that may vanish.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import final

from mecanique.derivation.printing.trigforms import common_monomial, common_number, monomial_series
from mecanique.derivation.scalars.cancel import tidy
from mecanique.derivation.scalars.generators import Kind
from mecanique.derivation.scalars.series import Series
from mecanique.derivation.symbolic.ties.tie import Tie

_LONGEST = 60
"""Balances with more terms are too long to be read."""


@final
@dataclass(frozen=True)
class Solved:
    """A multiplier λ with factor × λ = value.

    Args:
        multiplier: λ.
        factor: its coefficient.
        value: the right side, which may contain multipliers solved for before.
    """

    multiplier: Series
    factor: Series
    value: Series


@final
@dataclass(frozen=True)
class _Balance:
    """One balance: Σ factor × λ = rest."""

    factors: tuple[Series, ...]
    rest: Series

    def unknown(self, found: Sequence[int]) -> list[int]:
        """Return the indices of its multipliers that are not known yet."""
        return [k for k, factor in enumerate(self.factors) if factor and k not in found]

    def cost(self) -> int:
        """Return its length; constant factors cost less."""
        loose = sum(1 for factor in self.factors if factor and not is_constant(factor))
        return 10 * loose + len(self.rest) + sum(map(len, self.factors))


def solve_multipliers(
    ties: Sequence[Tie], slopes: Sequence[Sequence[Series]], sides: Sequence[Series]
) -> list[Solved]:
    """Solve for the multipliers, one after another; return none if balances become long.

    Args:
        ties: the equations they belong to.
        slopes: ∂Φ/∂q of each tie, for each velocity.
        sides: M a + h − Q of each velocity.
    """
    columns = zip(*slopes, strict=True)
    balances = [_Balance(tuple(c), side) for c, side in zip(columns, sides, strict=True)]
    found: list[int] = []
    solved: list[Solved] = []
    held: list[tuple[int, _Balance]] = []
    while len(found) + len(held) < len(ties):
        known = [*found, *(k for k, _ in held)]
        usable = [each for each in balances if each.unknown(known)]
        if not usable:
            return []
        chosen = min(usable, key=lambda each: (len(each.unknown(known)), each.cost()))
        balances.remove(chosen)
        if chosen.cost() > _LONGEST:
            return []
        unknown = chosen.unknown(known)
        if len(unknown) == 1 and not held:
            solved.append(_solve(ties, chosen, unknown[0]))
            found.append(unknown[0])
            continue
        k = min(unknown, key=lambda k: (not is_constant(chosen.factors[k]), len(chosen.factors[k])))
        held.append((k, chosen))
        balances = [_eliminate(each, chosen, k) for each in balances]
    for k, balance in reversed(held):
        solved.append(_solve(ties, balance, k))
    return solved


def is_constant(entry: Series) -> bool:
    """Return whether a series is one product of parameters, which is never zero."""
    return entry.is_unit and all(
        g.kind in (Kind.PARAMETER, Kind.CONSTANT) for g in entry.generators()
    )


def divide_common(column: Sequence[Series]) -> list[Series]:
    """Divide series by the number and the parameters that all of them share."""
    whole = [polynomial for entry in column for polynomial in _list_polynomials(entry)]
    if not whole:
        return list(column)
    shared = monomial_series(whole[0].ring, common_monomial(whole, {Kind.PARAMETER}))
    divisor = shared * common_number(whole)
    return [entry / divisor for entry in column]


def _list_polynomials(entry: Series) -> list[Series]:
    """Return the coefficients of the products of sines and cosines."""
    return [
        Series(entry.ring, {0: part}, entry.denominator, entry.reach)
        for part in entry.parts.values()
    ]


def _solve(ties: Sequence[Tie], balance: _Balance, k: int) -> Solved:
    """Solve a balance for the multiplier of tie k."""
    others = [
        -factor * ties[i].multiplier
        for i, factor in enumerate(balance.factors)
        if factor and i != k
    ]
    value = tidy(balance.rest.ring.sum([balance.rest, *others]))
    factor = balance.factors[k]
    if is_constant(factor):
        return Solved(ties[k].multiplier, factor.ring.number(1), value / factor)
    factor, value = divide_common([factor, value])
    if sum(1 if c > 0 else -1 for _, _, c in factor.terms()) < 0:
        factor, value = -factor, -value
    return Solved(ties[k].multiplier, factor, value)


def _eliminate(balance: _Balance, other: _Balance, k: int) -> _Balance:
    """Eliminate multiplier k from a balance by another that contains it."""
    mine, its = balance.factors[k], other.factors[k]
    if not mine:
        return balance
    if is_constant(its):
        mine, its = mine / its, its.ring.number(1)
    pairs = zip((*balance.factors, balance.rest), (*other.factors, other.rest), strict=True)
    *factors, rest = divide_common([tidy(its * a - mine * b) for a, b in pairs])
    return _Balance(tuple(factors), rest)
