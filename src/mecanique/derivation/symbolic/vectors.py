"""Small vectors of series."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from mecanique.derivation.scalars.cancel import tidy
from mecanique.derivation.scalars.series import Series
from mecanique.derivation.symbolic.symbols import Algebra
from mecanique.derivation.tree.poses import combination

__all__ = ["Vector", "along", "cross", "total", "zero"]

Vector = list[Series]
"""Three components."""


def cross(a: Sequence[Series], b: Sequence[Series]) -> Vector:
    """Return a × b.

    Args:
        a: shape (3,).
        b: shape (3,).
    """
    (x, y, z), (u, v, w) = a, b
    return [y * w - z * v, z * u - x * w, x * v - y * u]


def total(algebra: Algebra, vectors: Sequence[Sequence[Series]]) -> Vector:
    """Return a sum of vectors.

    Args:
        algebra: of the mechanism.
        vectors: shape (n, 3).
    """
    return [algebra.ring.sum([vector[i] for vector in vectors]) for i in range(3)]


def zero(algebra: Algebra) -> Vector:
    """Return the vector 0.

    Args:
        algebra: of the mechanism.
    """
    return [algebra.ring.number(0)] * 3


def along(algebra: Algebra, rows: Sequence[Sequence[Any]], vector: Sequence[Series]) -> Vector:
    """Return the components of a vector along directions.

    Args:
        algebra: of the mechanism.
        rows: shape (k, 3), the directions.
        vector: shape (3,).
    """
    return [tidy(algebra.lifted(combination(row, vector))) for row in rows]
