"""Compute with vectors and matrices of scalars of any kind, or with those of many states at once.

A vector is a list of three scalars (floats, scalars of a tape, jets), in which zeros cost nothing,
or an array of the shape (3, n) or (3, 1), whose rows are scalars of n states or of all states. So
laws that are written in vectors run on both; arrays take a few calls of numpy an operation.
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import reduce
from typing import Any, TypeAlias

import numpy as np

from mecanique.derivation.tree import poses
from mecanique.derivation.tree.poses import combination, plus, times

Triple: TypeAlias = "Any"
"""Three scalars: a list, or an array of the shape (3, n)."""

Rows: TypeAlias = "Any"
"""Rows of scalars: a list of lists, or an array of the shape (rows, columns, n)."""

Column: TypeAlias = "tuple[Any, Triple, Triple]"
"""The index of a velocity, or several, with two vectors that belong to it."""

STILL: Triple = (0.0, 0.0, 0.0)
"""The vector that is zero in every state; as this very object it costs nothing on arrays either."""

_UNTURNED: Rows = [STILL, STILL, STILL]

# rows 1, 2, 0 and 2, 0, 1, in which a cross product takes its factors
_AHEAD = np.array([1, 2, 0])
_BEHIND = np.array([2, 0, 1])

# places of the entries x, y, z of a skew matrix, and of their negatives, row by row
_SKEW = np.array([7, 2, 3])
_OPPOSITE = np.array([5, 6, 1])


def transpose(A: Rows) -> Rows:
    """Return Aᵀ."""
    if type(A) is np.ndarray:
        return A.swapaxes(0, 1)
    return [list(column) for column in zip(*A, strict=True)]


def take(rows: Rows, places: Any) -> Rows:
    """Return some rows, by their indices."""
    if type(rows) is np.ndarray or type(places) is slice:
        return rows[places]
    return [rows[k] for k in places]


def as_rows(scalars: Sequence[Any]) -> np.ndarray:
    """Return scalars, or vectors, of n states or of all as the rows of an array."""
    shapes = [scalar.shape for scalar in scalars if isinstance(scalar, np.ndarray)]
    shape = next((shape for shape in shapes if shape[-1] != 1), shapes[0] if shapes else (1,))
    rows = np.empty((len(scalars), *shape))
    for row, scalar in zip(rows, scalars, strict=True):
        row[:] = scalar
    return rows


def products(A: Rows, B: Rows) -> Rows:
    """Return A Bᵀ: the products of all rows of A with all rows of B."""
    if type(A) is np.ndarray:
        return np.einsum("ik...,jk...->ij...", A, B)
    return [apply(B, row) for row in A]


def symmetric_products(*pairs: tuple[Rows, Rows]) -> Rows:
    """Return Σ A Bᵀ of matrices or columns, if it is symmetric; lists take the lower triangle."""
    if type(pairs[0][0]) is np.ndarray:
        total: Any = 0.0
        for A, B in pairs:
            total = total + (A[:, None] * B if A.ndim == B.ndim == 2 else products(A, B))
        return total
    rows: Rows = [[], [], []]
    others: Rows = [[], [], []]
    for A, B in pairs:
        for i in range(3):
            rows[i] += _row(A, i)
            others[i] += _row(B, i)
    S: Rows = [[0.0] * 3 for _ in range(3)]
    for i, row in enumerate(rows):
        for k in range(i + 1):
            S[i][k] = S[k][i] = dot(row, others[k])
    return S


def _row(A: Rows, i: int) -> Sequence[Any]:
    """Return a row of a matrix, or of a vector as a column."""
    return A[i] if isinstance(A[i], (list, tuple)) else [A[i]]


def dot(a: Triple, b: Triple) -> Any:
    """Return a · b."""
    if type(a) is np.ndarray and type(b) is np.ndarray:
        return np.add.reduce(a * b, 0)
    return _as_float(combination(a, b))


def cross(a: Triple, b: Triple) -> Triple:
    """Return a × b."""
    if a is STILL or b is STILL:
        return STILL
    if type(a) is np.ndarray:
        ahead, behind = a.take(_AHEAD, 0), a.take(_BEHIND, 0)
        return ahead * b.take(_BEHIND, 0) - behind * b.take(_AHEAD, 0)
    return [
        a[1] * b[2] - a[2] * b[1],
        a[2] * b[0] - a[0] * b[2],
        a[0] * b[1] - a[1] * b[0],
    ]


def add(*vectors: Triple) -> Triple:
    """Return the sum of vectors."""
    total: Any = STILL
    for vector in vectors:
        if vector is STILL:
            continue
        if total is STILL:
            total = vector
        elif type(vector) is np.ndarray:
            total = total + vector
        else:
            break
    else:
        return total
    moving = [vector for vector in vectors if vector is not STILL]
    return [_as_float(reduce(plus, components)) for components in zip(*moving, strict=True)]


def add_rows(A: Rows, B: Rows) -> Rows:
    """Return A + B."""
    if type(A) is np.ndarray:
        return A + B
    return [add(a, b) for a, b in zip(A, B, strict=True)]


def scale(factor: Any, vector: Triple) -> Triple:
    """Return a multiple of a vector."""
    if vector is STILL or (type(factor) is float and factor == 0.0):
        return STILL
    if type(vector) is np.ndarray:
        return factor * vector
    return [_as_float(times(factor, x)) for x in vector]


def apply(R: Rows, vector: Triple) -> Triple:
    """Return R x, with as many columns of R as x has components."""
    if vector is STILL or R is _UNTURNED:
        return STILL
    if type(vector) is np.ndarray:
        # einsum takes twice as long for few states
        return np.add.reduce(R[:, : len(vector)] * vector, 1)
    return [dot(row[: len(vector)], vector) for row in R]


def apply_transpose(R: Rows, vector: Triple) -> Triple:
    """Return Rᵀ x."""
    if vector is STILL:
        return STILL
    if type(vector) is np.ndarray:
        return np.add.reduce(R[:, :3] * vector[:, None], 0)
    return apply(transpose(R)[:3], vector)


def acceleration_field(w: Triple, alpha: Triple) -> Rows:
    """Return U = α̂ + ω̂ ω̂: points r of a turning body accelerate by U r relative to its origin."""
    if w is STILL and alpha is STILL:
        return _UNTURNED
    if type(w) is np.ndarray or type(alpha) is np.ndarray:
        w = np.zeros_like(alpha) if w is STILL else w
        U = w[:, None] * w
        if alpha is not STILL and alpha.shape[1] > U.shape[2]:
            U = np.broadcast_to(U, (3, *alpha.shape)).copy()
        entries = U.reshape(9, -1)
        entries[::4] -= entries[0] + entries[4] + entries[8]
        if alpha is not STILL:
            entries[_SKEW] += alpha
            entries[_OPPOSITE] -= alpha
        return U
    xx, yy, zz = (c * c for c in w)
    xy, yz, xz = w[0] * w[1], w[1] * w[2], w[0] * w[2]
    return [
        [-(yy + zz), xy - alpha[2], xz + alpha[1]],
        [xy + alpha[2], -(xx + zz), yz - alpha[0]],
        [xz - alpha[1], yz + alpha[0], -(xx + yy)],
    ]


def axial(U: Rows, E: Rows) -> Triple:
    """Return the axial vector of U E, with E symmetric: ∫ r × U r dm for E = ∫ r rᵀ dm."""
    if U is _UNTURNED:
        return STILL
    UE = products(U, E)
    if type(UE) is np.ndarray:
        entries = UE.reshape(9, -1)
        return entries.take(_SKEW, 0) - entries.take(_OPPOSITE, 0)
    return [
        UE[2][1] - UE[1][2],
        UE[0][2] - UE[2][0],
        UE[1][0] - UE[0][1],
    ]


def turning_energy(w: Triple, E: Rows, mixed: Any) -> Any:
    """Return ∫ |v + ω × r|² dm − m v², of which the mixed part is ∫ v·(ω × r) dm."""
    if w is STILL:
        return 0.0
    if type(w) is np.ndarray:
        trace = E[0, 0] + E[1, 1] + E[2, 2]
        return trace * dot(w, w) - dot(w, apply(E, w)) + 2.0 * mixed
    squares: Any = 0.0
    for i in range(3):
        squares = squares + w[i] * w[i] * (E[i - 2][i - 2] + E[i - 1][i - 1])
    across = w[0] * w[1] * E[0][1] + w[1] * w[2] * E[1][2] + w[0] * w[2] * E[0][2]
    return squares + 2.0 * mixed - 2.0 * across


def turning_momentum(w: Triple, E: Rows) -> Triple:
    """Return ∫ r × (ω × r) dm = tr E ω − E ω."""
    if w is STILL or E[0] is STILL:
        return STILL
    trace = E[0][0] + E[1][1] + E[2][2]
    return add(scale(trace, w), scale(-1.0, apply(E, w)))


def position(pose: Rows) -> Triple:
    """Return the origin of a pose."""
    return pose[:, 3] if type(pose) is np.ndarray else [row[3] for row in pose]


def rotation(pose: Rows) -> Rows:
    """Return the rotation of a pose."""
    return pose[:, :3] if type(pose) is np.ndarray else [row[:3] for row in pose]


def product(a: Rows, b: Rows) -> Rows:
    """Multiply two poses."""
    if type(a) is np.ndarray:
        moved = np.einsum("ij...,jk...->ik...", a[:, :3], b)
        moved[:, 3] += a[:, 3]
        return moved
    return poses.product(a, b)


def times_point(pose: Rows, point: Triple) -> Triple:
    """Transform a body's point to the world."""
    if type(pose) is np.ndarray:
        return add(apply(pose, point), pose[:, 3])
    return poses.times_point(pose, point)


def as_array(pose: Rows, n: int) -> np.ndarray:
    """Return a pose of scalars as an array, shape (3, 4, n)."""
    stacked = np.zeros((3, 4, n))
    for row, entries in zip(stacked, pose, strict=True):
        for column, entry in enumerate(entries):
            row[column] = entry
    return stacked


def turned_pose(Q: np.ndarray, pose: np.ndarray) -> np.ndarray:
    """Return a motion about axes that are turned by Q, shape (3, 4, n)."""
    moved = apply_to_columns(Q, pose)
    return np.concatenate([products(moved[:, :3], Q), moved[:, 3:]], axis=1)


def zeros(rates: Any) -> Rows:
    """Return a square matrix of zeros as large as rates, an array in n states or scalars."""
    size = len(rates)
    if isinstance(rates, np.ndarray):
        return np.zeros((size, *rates.shape))
    return [[0.0] * size for _ in range(size)]


def mirror(M: Rows) -> None:
    """Copy the entries above the diagonal of a square matrix to those below."""
    for i in range(len(M)):
        for k in range(i):
            M[i][k] = M[k][i]


def apply_to_columns(Q: Rows, A: Rows) -> np.ndarray:
    """Return Q A on arrays."""
    return np.asarray(np.einsum("ij...,jk...->ik...", Q, A))


def bundle(columns: list[Column]) -> list[Column]:
    """Return pairs of vectors as one pair of arrays, shape (3, k, n); lists stay as they are."""
    if len(columns) < 2 or not any(type(part) is np.ndarray for part in columns[0][1:]):
        return columns
    sizes = [np.size(places) for places, _, _ in columns]
    n = max(part.shape[-1] for _, *pair in columns for part in pair if part is not STILL)
    joined = np.zeros((2, 3, sum(sizes), n))
    first = 0
    for size, (_, *pair) in zip(sizes, columns, strict=True):
        for out, part in zip(joined, pair, strict=True):
            if part is not STILL:
                out[:, first : first + size] = part if part.ndim == 3 else part[:, None]
        first += size
    return [(np.concatenate([np.atleast_1d(places) for places, _, _ in columns]), *joined)]


def _as_float(scalar: Any) -> Any:
    return float(scalar) if isinstance(scalar, int) else scalar
