"""Compute with vectors and matrices of floats and traced scalars; zeros cost nothing."""

from __future__ import annotations

from collections.abc import Sequence
from functools import reduce
from typing import Any, TypeAlias

from mecanique.derivation.tree.poses import combination, plus, times

Triple: TypeAlias = "list[Any]"
"""Three scalars."""

Rows: TypeAlias = "list[list[Any]]"
"""Rows of scalars."""


def transpose(A: Sequence[Sequence[Any]]) -> Rows:
    """Return Aᵀ."""
    return [list(column) for column in zip(*A, strict=True)]


def products(A: Sequence[Sequence[Any]], B: Sequence[Sequence[Any]]) -> Rows:
    """Return A Bᵀ: the products of all rows of A with all rows of B."""
    return [apply(B, row) for row in A]


def dot(a: Sequence[Any], b: Sequence[Any]) -> Any:
    """Return a · b."""
    return _as_float(combination(a, b))


def cross(a: Sequence[Any], b: Sequence[Any]) -> Triple:
    """Return a × b."""
    return [
        a[1] * b[2] - a[2] * b[1],
        a[2] * b[0] - a[0] * b[2],
        a[0] * b[1] - a[1] * b[0],
    ]


def add(*vectors: Sequence[Any]) -> Triple:
    """Return the sum of vectors."""
    return [_as_float(reduce(plus, components)) for components in zip(*vectors, strict=True)]


def scale(factor: Any, vector: Sequence[Any]) -> Triple:
    """Return a multiple of a vector."""
    return [_as_float(times(factor, x)) for x in vector]


def apply(R: Sequence[Sequence[Any]], vector: Sequence[Any]) -> Triple:
    """Return R x."""
    return [dot(row[: len(vector)], vector) for row in R]


def apply_transpose(R: Sequence[Sequence[Any]], vector: Sequence[Any]) -> Triple:
    """Return Rᵀ x."""
    return apply(transpose(R)[:3], vector)


def _as_float(scalar: Any) -> Any:
    return float(scalar) if isinstance(scalar, int) else scalar
