"""Motion on constraints: null space of the Jacobian, least multipliers, what stays undetermined.

M a + h = Jᵀ λ with J a + γ = 0, where h holds bias minus applied forces. The mass matrix need only
be definite on the null space of J, so massless links are fine; rows of J may be dependent, then the
least λ is taken (Udwadia & Kalaba, Analytical Dynamics, 1996, ch. 3; Shabana, Dynamics of Multibody
Systems, sect. 5.5).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import final

import numpy as np

from mecanique.errors import ClosureError
from mecanique.reference.loops.tolerances import DETERMINED, MASSLESS, RANK, TINY

__all__ = ["ConstrainedMotion", "Split", "solve", "split"]


@final
@dataclass(frozen=True)
class Split:
    """The directions a Jacobian closes and those it leaves free, in scaled coordinates.

    Args:
        rank: number of independent constraint equations.
        range_left: shape (m, rank), orthonormal combinations of rows that constrain.
        singular: shape (rank,), their singular values.
        range_right: shape (n, rank), the directions they close.
        null: shape (n, n − rank), the directions that stay free.
        determined: shape (m,), whether each row's multiplier is unique.
        loose: shape (m, m − rank), orthonormal combinations of rows that constrain nothing.
    """

    rank: int
    range_left: np.ndarray
    singular: np.ndarray
    range_right: np.ndarray
    null: np.ndarray
    determined: np.ndarray
    loose: np.ndarray


@final
@dataclass(frozen=True)
class ConstrainedMotion:
    """What constrained bodies do, and the multipliers that make them.

    Args:
        acceleration: shape (n,).
        multipliers: shape (m,), the least ones; the generalized constraint force is Jᵀ λ.
        determined: shape (m,), False where a redundant constraint leaves the multiplier
            undetermined.
        rank: number of independent constraint equations.
    """

    acceleration: np.ndarray
    multipliers: np.ndarray
    determined: np.ndarray
    rank: int


def split(
    jacobian: np.ndarray,
    tolerance: float = RANK,
    least: float = 0.0,
    most: int | None = None,
    fixed: int | None = None,
) -> Split:
    """Split the directions of motion by a Jacobian.

    Args:
        jacobian: shape (m, n), scaled so that its entries are of one unit.
        tolerance: singular values below this fraction of the largest count as zero.
        least: singular values below this count as zero.
        most: the rank that is not exceeded, for redundant rows that agree only up to rounding.
        fixed: the rank, if it is not to be found.
    """
    left, singular, right = np.linalg.svd(jacobian)
    rank = int((singular > max(tolerance * singular[0], least, TINY)).sum()) if singular.size else 0
    rank = rank if most is None else min(rank, most)
    rank = rank if fixed is None else min(fixed, len(singular))
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


def solve(
    mass: np.ndarray,
    h: np.ndarray,
    jacobian: np.ndarray,
    gamma: np.ndarray,
    *,
    rows: np.ndarray | None = None,
    columns: np.ndarray | None = None,
    names: Sequence[str] | None = None,
    least: float = 0.0,
    most: int | None = None,
    weak: float = 0.0,
) -> ConstrainedMotion:
    """Return the acceleration that satisfies M a + h = Jᵀ λ and J a + γ = 0.

    Args:
        mass: shape (n, n).
        h: shape (n,), bias minus applied generalized forces.
        jacobian: shape (m, n).
        gamma: shape (m,), the part of the constraints' second derivative without a.
        rows: shape (m,), factors that bring the rows to one unit; ones by default.
        columns: shape (n,), factors that bring the coordinates to one unit; ones by default.
        names: of the velocities, for the message; their indices by default.
        least: scaled singular values of the Jacobian below this count as zero.
        most: the rank that is not exceeded.
        weak: directions with singular values below this fraction of the largest are taken for
            closed, as the rank `most` has it, but keep their velocities: next to a singular
            position rounding would bend the path.

    Raises:
        ClosureError: if a free direction carries no mass; its message names the largest components.
    """
    rows = np.ones(len(gamma)) if rows is None else rows
    columns = np.ones(len(h)) if columns is None else columns
    fixed = most if weak else None
    parts = split(rows[:, None] * jacobian * columns, least=least, most=most, fixed=fixed)
    gain = np.ones(parts.rank)
    if fixed is not None:
        gain = (parts.singular > weak * parts.singular.max(initial=0.0)).astype(float)
    gain = np.divide(gain, parts.singular, out=np.zeros_like(gain), where=gain > 0)
    scaled_mass = columns[:, None] * mass * columns
    scaled_h = columns * h
    particular = -parts.range_right @ ((parts.range_left.T @ (rows * gamma)) * gain)
    reduced = parts.null.T @ scaled_mass @ parts.null
    if reduced.size:
        free, directions = np.linalg.eigh(reduced)
        if free[0] <= MASSLESS * max(free[-1], np.abs(scaled_mass).max(), TINY):
            mode = parts.null @ directions[:, 0]
            leading = np.argsort(-np.abs(mode))[:3]
            called = [f"coordinate {k}" for k in range(len(mode))] if names is None else names
            moved = ", ".join(
                f"{mode[k]:+.2f} at {called[k]}" for k in leading if abs(mode[k]) > 0.1
            )
            raise ClosureError(
                f"a free direction carries no mass ({moved}); give a body in it mass or inertia"
            )
        push = parts.null.T @ (scaled_h + scaled_mass @ particular)
        particular = particular - parts.null @ (directions @ ((directions.T @ push) / free))
    force = scaled_mass @ particular + scaled_h
    multipliers = rows * (parts.range_left @ ((parts.range_right.T @ force) * gain))
    return ConstrainedMotion(columns * particular, multipliers, parts.determined, parts.rank)
