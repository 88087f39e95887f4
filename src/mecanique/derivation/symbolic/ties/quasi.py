"""Independent displacements: what contacts and velocity constraints A δq = 0 leave free, δq = S δπ.

Row by row the displacements that are free so far are combined so that the row vanishes (G. A.
Maggi, Principii della teoria matematica del movimento, 1896; Neimark & Fufaev, Dynamics of
Nonholonomic Systems, 1972, ch. III). Nothing is divided by what may vanish: a row needs an entry
that is constant, or two whose squares add up to a constant, as −sin θ and cos θ.
"""

from __future__ import annotations

from collections.abc import Sequence
from itertools import combinations

from mecanique.derivation.scalars.cancel import tidy
from mecanique.derivation.scalars.series import Basis, Kind, Series
from mecanique.errors import DerivationError

__all__ = ["independent_displacements"]

Column = list[Series]


def independent_displacements(
    ring: Basis, rows: Sequence[Sequence[Series]], count: int
) -> list[Column]:
    """Return a basis S of the displacements with A δq = 0, each by all velocities.

    Args:
        ring: of the series.
        rows: of A.
        count: number of velocities.

    Raises:
        DerivationError: if that would divide by what may vanish.
    """
    one, zero = ring.number(1), ring.number(0)
    basis = [[zero] * count for _ in range(count)]
    for k, column in enumerate(basis):
        column[k] = one
    for row in rows:
        entries = [_dot(ring, row, column) for column in basis]
        met = [k for k, entry in enumerate(entries) if entry]
        if met:
            basis = _without(ring, basis, entries, met)
    return basis


def _without(
    ring: Basis, basis: list[Column], entries: list[Series], met: list[int]
) -> list[Column]:
    """The displacements along which a row with these entries vanishes."""
    single = next((k for k in met if _is_constant(entries[k])), None)
    if single is not None:
        pivot = entries[single]
        return [
            _minus(column, entries[k] / pivot, basis[single]) if k in met else column
            for k, column in enumerate(basis)
            if k != single
        ]
    for i, k in combinations(met, 2):
        size = tidy(entries[i] ** 2 + entries[k] ** 2)
        if not _is_constant(size):
            continue
        # along (c, s) the row is held, along (−s, c) it is free
        c, s = entries[i], entries[k]
        pairs = list(zip(basis[i], basis[k], strict=True))
        held = [tidy(c * a + s * b) for a, b in pairs]
        rest = [
            _minus(column, entries[j] / size, held) if j in met else column
            for j, column in enumerate(basis)
        ]
        rest[i] = [tidy(s * a - c * b) for a, b in pairs]
        return rest[:k] + rest[k + 1 :]
    raise DerivationError(
        "the constraints on velocities have no independent displacements in closed form that hold "
        "everywhere; such equations are computed, not written out"
    )


def _is_constant(entry: Series) -> bool:
    """Whether a series is one product of parameters, which is never zero."""
    return entry.is_unit and all(
        g.kind in (Kind.PARAMETER, Kind.CONSTANT) for g in entry.generators()
    )


def _dot(ring: Basis, row: Sequence[Series], column: Column) -> Series:
    return tidy(ring.sum([a * b for a, b in zip(row, column, strict=True) if a and b]))


def _minus(column: Column, factor: Series, other: Column) -> Column:
    if not factor:
        return column
    return [tidy(a - factor * b) for a, b in zip(column, other, strict=True)]
