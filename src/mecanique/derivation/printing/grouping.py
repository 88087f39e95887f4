"""Group the terms of an equation by the motions in them, in textbook order."""

from __future__ import annotations

import math

from mecanique.derivation.scalars.generators import Kind
from mecanique.derivation.scalars.monomials import exponents, power
from mecanique.derivation.scalars.polynomials import Parts
from mecanique.derivation.scalars.series import Basis, Series, canonical

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
    """Group a series by monomials of motions and lengths: ((on the right, monomial), coefficient).

    Args:
        series: the terms of an equation.
        by_side: whether terms that force the motion go to the right side.
    """
    ring = series.ring
    kinds = [g.kind for g in ring.generators]
    depends = {i: _find_kinds(atom.argument) for i, atom in ring.atoms.items()}
    turns = [_find_kinds(angle.argument) for angle in ring.angles]
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


def _find_kinds(series: Series) -> set[Kind]:
    """Return the kinds of quantities that a series depends on."""
    return {generator.kind for generator in series.generators()}


def _rank(ring: Basis, key: int) -> tuple[object, ...]:
    """Return a sort key: accelerations, then velocities, then lengths, then the rest.

    Higher powers of motions come first, but lower powers of lengths.
    """
    powers = dict(exponents(key))
    degrees: dict[Kind, list[int]] = {kind: [] for kind in _RANKED}
    for generator in ring.generators:
        if generator.kind in degrees:
            degrees[generator.kind].append(-powers.get(generator.index, 0))
    motion = [sum(degrees[kind]) for kind in _RANKED[:2]]
    lengths = -sum(degrees[Kind.COORDINATE])
    return (*motion, lengths or math.inf, *(tuple(degrees[kind]) for kind in _RANKED))


def accelerates(ring: Basis, key: int) -> bool:
    """Return whether a monomial contains an acceleration."""
    return any(ring.generators[i].kind is Kind.ACCELERATION for i, _ in exponents(key))
