"""Scale constraints by the metric of kinetic energy.

Directions of motion are normalized by their kinetic energy, the rows of a loop by the part of the
motions of unit energy that they prevent. Singular values of the Jacobian are then dimensionless and
of order one or less. They do not depend on units or on the relative size of a mechanism's parts,
and little on the choice of joints that are cut into loops. In these directions the mass matrix is
the identity, so it need not be inverted later.
"""

from __future__ import annotations

from collections.abc import Callable
from contextlib import suppress
from typing import NamedTuple

import numpy as np

from mecanique.arrays import Array
from mecanique.reference.loops.tolerances import LEAST, ROUNDING, TINY, WEAK

_MASSLESS = 1e-13
"""Principal inertias below this are rounding, for a mass matrix with unit diagonal."""

_EVEN = 0.03
"""Least Cholesky pivot without loss of many digits, for a mass matrix with unit diagonal."""


class Units(NamedTuple):
    """Natural units: a characteristic length for lengths, one radian for angles.

    Args:
        rows: shape (m,), factors of the rows.
        columns: shape (n,), units of the velocities.
        blocks: shape (m,), number of each row's block, a loop's lengths or its angles, whose rows
            are scaled together.
        rounding: returns what rounding may make of an entry of each row, shape (m,) or ().
    """

    rows: Array
    columns: Array
    blocks: Array
    rounding: Callable[[], Array | float] = lambda: ROUNDING


class Metric(NamedTuple):
    """The scale of velocities and constraints in a state.

    Args:
        rows: shape (m,), factors of the rows; zero where a loop prevents no motion.
        columns: shape (n, n), directions of motion, orthogonal, each of unit energy ½ vᵀ M v = ½.
        inverse: shape (n, n), the inverse of `columns`.
        mass: shape (n,), one for each direction, or zero if it has no mass.
        units: the natural units.
    """

    rows: Array
    columns: Array
    inverse: Array
    mass: Array
    units: Units

    def scale(self, jacobian: Array) -> Array:
        """Scale the rows and columns of a Jacobian, shape (m, n)."""
        scaled: Array = self.rows[:, None] * (jacobian @ self.columns)
        return scaled

    def rounding(self, jacobian: Array) -> Array:
        """Bound what rounding may make of each row of a scaled Jacobian, shape (m,)."""
        # an entry that is zero because the row does not move with the velocity has no error
        spread = (jacobian != 0) / self.units.columns @ np.abs(self.columns)
        factors = self.units.rounding() * self.rows / self.units.rows
        rounding: Array = factors * np.sqrt((spread**2).sum(axis=1))
        return rounding


def measure(
    mass: Array, jacobian: Array, units: Units, root: Callable[[], Array] | None = None
) -> Metric:
    """Return the metric of a state.

    Args:
        mass: M, shape (n, n); a massless velocity takes the scale of the lightest one that a loop
            couples it to.
        jacobian: J, shape (m, n).
        units: natural units of J.
        root: returns A with Aᵀ A = M, shape (k, n), for a mass matrix with cancellation.
    """
    weight = _weigh(np.diag(mass), jacobian, units.columns)
    columns, inverse, massive = _directions(mass, weight, root)
    closing = ((jacobian @ columns) ** 2).sum(axis=1)
    reach = np.abs(units.rows[:, None] * jacobian * units.columns).max(axis=1, initial=0.0)
    if reach.min(initial=1.0) < WEAK:
        # a row of mere rounding must not be scaled up: it would count as independent of all others
        closing = closing * (reach > np.maximum(LEAST, units.rounding()))
    total = np.bincount(units.blocks, closing)[units.blocks]
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
    """Return the square roots of the velocities' inertias, shape (n,)."""
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
