"""The scale in which constraints are judged: that of the kinetic energy.

A direction of motion is measured by its kinetic energy, the rows of a loop by how much of the
motions of unit energy they close. Singular values of the Jacobian are then plain numbers of order
one or less. They do not depend on units, nor on the size of one part of a mechanism beside another,
and little on which of the joints are taken for loops. In these directions the mass matrix is the
unit matrix, so that nothing of it has to be inverted later.
"""

from __future__ import annotations

from collections.abc import Callable
from contextlib import suppress
from typing import NamedTuple

import numpy as np

from mecanique.arrays import Array
from mecanique.reference.loops.tolerances import LEAST, TINY

__all__ = ["Metric", "Units", "measure"]

_MASSLESS = 1e-13
"""Principal inertias below this, of a mass matrix with unit diagonal, are rounding."""

_EVEN = 0.03
"""Least pivot, by Cholesky's method, of a mass matrix with unit diagonal that loses few digits."""


class Units(NamedTuple):
    """Plain units: a characteristic length for what is a length, one radian for what is an angle.

    Args:
        rows: shape (m,), factors of the rows.
        columns: shape (n,), units of the velocities.
        blocks: shape (m,), number of the block that each row is measured in: a loop's lengths, or
            its angles.
    """

    rows: Array
    columns: Array
    blocks: Array


class Metric(NamedTuple):
    """The scale of a state.

    Args:
        rows: shape (m,), factors of the rows; zero where a loop closes nothing.
        columns: shape (n, n), directions of motion, orthogonal, each of unit energy ½ vᵀ M v = ½.
        inverse: shape (n, n), the inverse of `columns`.
        mass: shape (n,), one for each direction, or zero if it has no mass.
        units: the plain units.
    """

    rows: Array
    columns: Array
    inverse: Array
    mass: Array
    units: Units

    def scale(self, jacobian: Array) -> Array:
        """Return a Jacobian of shape (m, n) by scaled rows and directions."""
        scaled: Array = self.rows[:, None] * (jacobian @ self.columns)
        return scaled


def measure(
    mass: Array, jacobian: Array, units: Units, root: Callable[[], Array] | None = None
) -> Metric:
    """Return the metric of a state.

    Args:
        mass: M, shape (n, n); a massless velocity is measured by the lightest one it meets in a
            loop.
        jacobian: J, shape (m, n).
        units: of J.
        root: returns A with Aᵀ A = M, shape (k, n), for a mass matrix whose entries cancel.
    """
    weight = _weigh(np.diag(mass), jacobian, units.columns)
    columns, inverse, massive = _directions(mass, weight, root)
    closing = ((jacobian @ columns) ** 2).sum(axis=1)
    reach = np.abs(units.rows[:, None] * jacobian * units.columns).max(axis=1, initial=0.0)
    # rows of nothing but rounding must not be scaled up
    total = np.bincount(units.blocks, closing * (reach > LEAST))[units.blocks]
    rows = np.where(total > 0, 1 / np.sqrt(np.maximum(total, TINY)), 0.0)
    return Metric(rows, columns, inverse, massive, units)


def _directions(
    mass: Array, weight: Array, root: Callable[[], Array] | None
) -> tuple[Array, Array, Array]:
    """Return orthogonal directions of unit energy, their inverse, and which have mass."""
    even = mass / np.outer(weight, weight)
    lower = np.zeros_like(even)
    if even.diagonal().min(initial=1.0) > _EVEN**2:  # no entry of the factor is above its root
        with suppress(np.linalg.LinAlgError):
            lower[:] = np.linalg.cholesky(even)
    if lower.diagonal().min(initial=1.0) > _EVEN:
        return np.linalg.inv(lower).T / weight[:, None], lower.T * weight, np.ones(len(mass))
    if root is None:
        squares, axes = np.linalg.eigh(even)
        size = np.sqrt(np.maximum(squares, 0.0))
    else:
        reduced = np.linalg.qr(root() / weight, mode="r")
        _, found, rows = np.linalg.svd(reduced)
        size, axes = np.zeros(len(mass)), rows.T
        size[: len(found)] = found
    massive = size**2 > _MASSLESS
    scale = np.where(massive, size, 1.0)
    return axes / scale / weight[:, None], (axes * scale).T * weight, massive.astype(float)


def _weigh(diagonal: Array, jacobian: Array, columns: Array) -> Array:
    """Return the roots of the inertias that the velocities meet, shape (n,)."""
    inertia = diagonal * columns**2
    massive = inertia > TINY
    if massive.all():
        return np.sqrt(diagonal)
    lightest = float(inertia[massive].min()) if massive.any() else 1.0
    closed = np.abs(jacobian) > 0
    for j in np.flatnonzero(~massive):
        beside = massive & closed[closed[:, j]].any(axis=0)
        inertia[j] = inertia[beside].min() if beside.any() else lightest
    roots: Array = np.sqrt(inertia) / columns
    return roots
