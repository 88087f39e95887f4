"""Solve for constrained motion in the null space of the Jacobian, with the least multipliers.

M a + h = Jᵀ λ with J a + γ = 0, where h is bias minus applied forces. The mass matrix need be
definite only on the null space of J, which allows massless links; if rows of J are dependent, the
least λ is returned (Udwadia & Kalaba, Analytical Dynamics, 1996, ch. 3; Shabana, Dynamics of
Multibody Systems, sect. 5.5).

Constraints are scaled by the metric of kinetic energy: directions of motion by their kinetic
energy, the rows of a loop by the part of the motions of unit energy that they prevent. Singular
values of the Jacobian are then dimensionless and of order one or less. They do not depend on units
or on the relative size of a mechanism's parts, and little on the choice of joints that are cut into
loops. In these directions the mass matrix is the identity, so it need not be inverted later.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from contextlib import suppress
from dataclasses import dataclass
from functools import partial
from typing import NamedTuple, final

import numpy as np
import numpy.typing as npt

from mecanique.arrays import Array
from mecanique.errors import ClosureError
from mecanique.reference.tolerances import (
    DETERMINED,
    EVEN,
    LEAST,
    MASSLESS,
    RANK,
    ROUNDING,
    SINGULAR_MASS,
    TINY,
    WEAK,
)


class NaturalUnits(NamedTuple):
    """Natural units: a characteristic length for lengths, one radian for angles."""

    rows: Array  # shape (m,), factors of the rows
    columns: Array  # shape (n,), units of the velocities
    # shape (m,), number of each row's block, a loop's lengths or its angles, whose rows are scaled
    # together
    blocks: Array
    # returns what rounding may make of an entry of each row, shape (m,) or ()
    rounding: Callable[[], Array | float] = lambda: ROUNDING


class Metric(NamedTuple):
    """The scale of velocities and constraints in a state."""

    rows: Array  # shape (m,), factors of the rows; zero where a loop prevents no motion
    # shape (n, n), directions of motion, orthogonal, each of unit energy ½ vᵀ M v = ½
    columns: Array
    inverse: Array  # shape (n, n), the inverse of `columns`
    mass: Array  # shape (n,), one for each direction, or zero if it has no mass
    units: NaturalUnits  # the natural units

    def scale(self, jacobian: Array) -> Array:
        """Scale the rows and columns of a Jacobian, shape (m, n)."""
        scaled: Array = self.rows[:, None] * (jacobian @ self.columns)
        return scaled

    def rounding(self, jacobian: Array) -> Array:
        """Bound what rounding may make of each row of a scaled Jacobian, shape (m,)."""
        # an entry that is zero because the row does not move with the velocity has no error
        spread = (jacobian != 0) / self.units.columns @ np.abs(self.columns)
        factors = self.units.rounding() * self.rows / self.units.rows
        rounding: Array = factors * np.sqrt(np.add.reduce(spread * spread, 1))
        return rounding


def measure(
    mass: Array, jacobian: Array, units: NaturalUnits, root: Callable[[], Array] | None = None
) -> Metric:
    """Return the metric of a state."""
    # A massless velocity takes the scale of the lightest one that a loop couples it to. `root` is
    # for a mass matrix with cancellation: it returns A with Aᵀ A = M, shape (k, n).
    weight = _weigh(np.diag(mass), jacobian, units.columns)
    columns, inverse, massive = _directions(mass, weight, root)
    moved = jacobian @ columns
    closing = np.add.reduce(moved * moved, 1)
    reach = np.abs(units.rows[:, None] * jacobian * units.columns)
    reach = np.maximum.reduce(reach, 1, initial=0.0)
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
    if even.diagonal().min(initial=1.0) > EVEN**2:  # no entry of the factor is above its root
        with suppress(np.linalg.LinAlgError):
            lower[:] = np.linalg.cholesky(even)
    if lower.diagonal().min(initial=1.0) > EVEN:
        return np.linalg.inv(lower).T / weight[:, None], lower.T * weight, np.ones(len(mass))
    if root is None:
        squares, axes = np.linalg.eigh(even)
        size = np.sqrt(np.maximum(squares, 0.0))
    else:
        reduced = np.linalg.qr(root() / weight, mode="r")
        _, roots, rows = np.linalg.svd(reduced)
        size, axes = np.zeros(len(mass)), rows.T
        size[: len(roots)] = roots
    massive = size**2 > SINGULAR_MASS
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


@final
@dataclass(frozen=True)
class Split:
    """The directions that a Jacobian prevents and those it allows, in scaled coordinates."""

    rank: int  # number of independent constraint equations
    range_left: np.ndarray  # shape (m, rank), orthonormal combinations of rows that constrain
    singular: np.ndarray  # shape (rank,), their singular values
    range_right: np.ndarray  # shape (n, rank), the directions they prevent
    null: np.ndarray  # shape (n, n − rank), the free directions
    determined: np.ndarray  # shape (m,), whether each row's multiplier is unique
    # shape (m, m − rank), orthonormal combinations of rows that constrain nothing
    loose: np.ndarray


@final
@dataclass(frozen=True)
class ConstrainedAccelerations:
    """The accelerations of constrained bodies, with the multipliers."""

    acceleration: np.ndarray  # shape (n,)
    multipliers: np.ndarray  # shape (m,), the least ones; the generalized constraint force is Jᵀ λ
    # shape (m,), False where a redundant constraint leaves the multiplier undetermined
    determined: np.ndarray
    rank: int  # number of independent constraint equations


def split(
    jacobian: np.ndarray,  # shape (m, n), scaled so that its entries are of one unit
    tolerance: float = RANK,  # singular values below this fraction of the largest count as zero
    least: float = 0.0,  # singular values below this count as zero
    most: int | None = None,
    fixed: int | None = None,  # the rank, if it is known
    rounding: Callable[[], np.ndarray] | None = None,
) -> Split:
    """Split the directions of motion by a Jacobian."""
    # `most` bounds the rank, as redundant rows may agree only up to rounding.
    left, singular, right = np.linalg.svd(jacobian)
    count = len(singular)
    top = float(singular[0]) if count else 0.0  # they come in descending order
    strong = singular > max(tolerance * top, least, TINY)
    # what holds well is no rounding, whose bound takes as long as all the rest
    if rounding is not None and count and singular[-1] < WEAK * top:
        strong &= are_certain(left[:, :count], singular, 0.0, rounding())
    if not strong[: strong.sum()].all():
        # a short but certain direction comes before a longer one of mere rounding
        order = np.argsort(~strong, kind="stable")
        left[:, :count], singular, right[:count] = left[:, order], singular[order], right[order]
    rank = int(strong.sum())
    rank = rank if most is None else min(rank, most)
    rank = rank if fixed is None else min(fixed, count)
    loose = np.abs(left[:, rank:]).max(axis=1, initial=0.0)
    return Split(
        rank,
        left[:, :rank],
        singular[:rank],
        right[:rank].T,
        right[rank:].T,
        loose < DETERMINED,
        left[:, rank:],
    )


def are_certain(
    left: np.ndarray, singular: np.ndarray, least: float, rounding: np.ndarray | float
) -> npt.NDArray[np.bool_]:
    """Return which singular values exceed a least one and their rows' rounding, shape (k,)."""
    # A combination of rows, shape (m, k), may be large only because the rows' terms are, far from
    # the origin: it must not count as a constraint
    # columns of `left` have unit length, so that one bound for all rows is that of each combination
    noise = rounding
    if not isinstance(rounding, float):
        noise = np.sqrt((rounding * rounding) @ (left * left))
    certain: npt.NDArray[np.bool_] = singular > np.maximum(noise, max(least, TINY))
    return certain


def solve(
    metric: Metric,  # the metric of the state, which contains M
    h: np.ndarray,  # shape (n,), bias minus applied generalized forces
    jacobian: np.ndarray,  # shape (m, n)
    gamma: np.ndarray,  # shape (m,), the part of the constraints' second derivative without a
    *,
    names: Sequence[str] | None = None,
    most: int | None = None,  # upper bound of the rank
    weak: float = 0.0,
) -> ConstrainedAccelerations:
    """Solve M a + h = Jᵀ λ together with J a + γ = 0."""
    # Directions with singular values below `weak` count as prevented, in agreement with the rank
    # `most`, but keep their velocities: rounding would bend the path next to a singular position.
    fixed = most if weak else None
    J = metric.scale(jacobian)
    noise = None if fixed is not None else partial(metric.rounding, jacobian)
    parts = split(J, most=most, fixed=fixed, rounding=noise)
    held = parts.singular > weak if fixed is not None else np.ones(parts.rank, dtype=bool)
    gain = np.divide(1.0, parts.singular, out=np.zeros(parts.rank), where=held)
    masses, directions = np.linalg.eigh((parts.null.T * metric.mass) @ parts.null)
    if masses.min(initial=1.0) <= MASSLESS:
        raise ClosureError(
            f"a free direction carries no mass "
            f"({_leading(metric, parts.null @ directions[:, 0], names)}); "
            "give a body in it mass or inertia"
        )
    free = parts.null @ directions
    h, gamma = metric.columns.T @ h, metric.rows * gamma
    a, multipliers = np.zeros(len(h)), np.zeros(len(gamma))
    for _ in range(2):  # refined once: rounding of a large part disturbs a small one
        push = metric.mass * a + h - J.T @ multipliers
        step = -parts.range_right @ ((parts.range_left.T @ (J @ a + gamma)) * gain)
        step = step - free @ ((free.T @ (push + metric.mass * step)) / masses)
        force = push + metric.mass * step
        a = a + step
        multipliers = multipliers + parts.range_left @ ((parts.range_right.T @ force) * gain)
    if parts.loose.size:
        # of all equivalent multipliers, the least in natural units
        units = (metric.rows / metric.units.rows)[:, None]
        idle = np.linalg.lstsq(units * parts.loose, units[:, 0] * multipliers, rcond=None)[0]
        multipliers = multipliers - parts.loose @ idle
    return ConstrainedAccelerations(
        metric.columns @ a, metric.rows * multipliers, parts.determined, parts.rank
    )


def _leading(metric: Metric, direction: np.ndarray, names: Sequence[str] | None) -> str:
    """Name the largest components of a direction."""
    mode = metric.columns @ direction / metric.units.columns
    mode /= np.linalg.norm(mode)
    called = [f"coordinate {k}" for k in range(len(mode))] if names is None else names
    leading = [k for k in np.argsort(-np.abs(mode))[:3] if abs(mode[k]) > 0.1]
    return ", ".join(f"{mode[k]:+.2f} at {called[k]}" for k in leading)
