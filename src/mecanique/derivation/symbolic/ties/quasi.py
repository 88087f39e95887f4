"""Find independent virtual displacements δq = S δπ that satisfy constraints A δq = 0.

Row by row, the displacements allowed so far are combined so that they satisfy the next row (G. A.
Maggi, Principii della teoria matematica del movimento, 1896; Neimark & Fufaev, Dynamics of
Nonholonomic Systems, 1972, ch. III). No divisor may vanish: a row needs a constant entry, or two
whose squares add up to a constant, such as −sin θ and cos θ. Rows of loops without such entries are
solved by Cramer's rule, with all displacements multiplied by the determinant instead of divided.
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial
from itertools import combinations

from mecanique.derivation.scalars.cancel import tidy
from mecanique.derivation.scalars.series import Basis, Series
from mecanique.derivation.symbolic.ties.multipliers import divide_common, is_constant
from mecanique.errors import DerivationError

Column = list[Series]

_LONGEST, _MOST_ROWS = 60, 4
"""Largest numbers of terms and of rows whose displacements can still be read."""


def independent_displacements(
    ring: Basis, rows: Sequence[Sequence[Series]], count: int, *, cramer: bool = False
) -> list[Column]:
    """Return a basis S of the displacements with A δq = 0, each with a part for every velocity.

    Args:
        ring: the ring of the series.
        rows: rows of A.
        count: number of velocities.
        cramer: whether displacements may be multiplied by a determinant; with a single free
            displacement it vanishes only where the rows are dependent.

    Raises:
        DerivationError: if a divisor might vanish, or the result is long.
    """
    one, zero = ring.number(1), ring.number(0)
    basis = [[zero] * count for _ in range(count)]
    for k, column in enumerate(basis):
        column[k] = one
    waiting = list(rows)
    while waiting:
        for row in waiting:
            entries = [_dot(ring, row, column) for column in basis]
            met = [k for k, entry in enumerate(entries) if entry]
            shorter = _satisfy(ring, basis, entries, met) if met else basis
            if shorter is not None:
                waiting.remove(row)
                basis = shorter
                break
        else:
            if not cramer:
                raise DerivationError(
                    "the constraints on velocities have no independent displacements in closed "
                    "form that hold everywhere; such equations are computed, not written out"
                )
            return _solve_by_cramer(ring, basis, waiting)
    return basis


def _solve_by_cramer(
    ring: Basis, basis: list[Column], rows: Sequence[Sequence[Series]]
) -> list[Column]:
    """Return displacements that satisfy rows without constant entries, by Cramer's rule."""
    entries = [[*map(partial(_dot, ring, row), basis)] for row in rows]
    size = len(rows)
    if size > _MOST_ROWS or sum(len(entry) for row in entries for entry in row) > _LONGEST:
        raise DerivationError(
            "the independent displacements of the loops are too long to be read; such equations "
            "are computed, not written out"
        )
    choices = []
    for places in combinations(range(len(basis)), size):
        minor = _expand(ring, _select(entries, places))
        if minor:
            choices.append((len(minor), places[::-1], places, minor))
    if not choices:
        raise DerivationError("the loops' equations depend on each other")
    *_, held, minor = min(choices, key=lambda choice: choice[:2])
    found = []
    for free in range(len(basis)):
        if free in held:
            continue
        column = [minor * x for x in basis[free]]
        for place, k in enumerate(held):
            swapped = (*held[:place], free, *held[place + 1 :])
            share = _expand(ring, _select(entries, swapped))
            column = [a - share * b for a, b in zip(column, basis[k], strict=True)]
        found.append(_make_positive(divide_common([tidy(entry) for entry in column])))
    return found


def _expand(ring: Basis, rows: Sequence[Sequence[Series]]) -> Series:
    """Expand the determinant by the first row."""
    if not rows:
        return ring.number(1)
    first, *others = rows
    terms = []
    for k, entry in enumerate(first):
        if entry:
            rest = [i for i in range(len(first)) if i != k]
            terms.append(entry * _expand(ring, _select(others, rest)) * (-1) ** k)
    return tidy(ring.sum(terms))


def _select(rows: Sequence[Sequence[Series]], places: Sequence[int]) -> list[list[Series]]:
    """Select entries of every row, in the given order."""
    found: list[list[Series]] = []
    for row in rows:
        found.append([row[k] for k in places])
    return found


def _make_positive(column: Column) -> Column:
    """Return the displacement with the sign that makes its first part positive."""
    first = next(entry for entry in column if entry)
    signs = [1 if c > 0 else -1 for _, _, c in first.terms()]
    return [-entry for entry in column] if sum(signs) < 0 else column


def _satisfy(
    ring: Basis, basis: list[Column], entries: list[Series], met: list[int]
) -> list[Column] | None:
    """Return displacements that satisfy a row with these entries; None if a divisor may vanish."""
    single = next((k for k in met if is_constant(entries[k])), None)
    if single is not None:
        pivot = entries[single]
        return [
            _subtract(column, entries[k] / pivot, basis[single]) if k in met else column
            for k, column in enumerate(basis)
            if k != single
        ]
    for i, k in combinations(met, 2):
        size = tidy(entries[i] ** 2 + entries[k] ** 2)
        if not is_constant(size):
            continue
        # the row prevents the displacement (c, s) and allows (−s, c)
        c, s = entries[i], entries[k]
        pairs = list(zip(basis[i], basis[k], strict=True))
        held = [tidy(c * a + s * b) for a, b in pairs]
        rest = [
            _subtract(column, entries[j] / size, held) if j in met else column
            for j, column in enumerate(basis)
        ]
        rest[i] = [tidy(s * a - c * b) for a, b in pairs]
        return rest[:k] + rest[k + 1 :]
    return None


def _dot(ring: Basis, row: Sequence[Series], column: Column) -> Series:
    return tidy(ring.sum([a * b for a, b in zip(row, column, strict=True) if a and b]))


def _subtract(column: Column, factor: Series, other: Column) -> Column:
    if not factor:
        return column
    return [tidy(a - factor * b) for a, b in zip(column, other, strict=True)]
