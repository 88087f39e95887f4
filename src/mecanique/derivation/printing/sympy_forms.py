"""Convert series to expressions and matrices of SymPy."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

from mecanique.derivation.printing.expressions import to_formula
from mecanique.derivation.scalars.series import Series


def to_sympy(series: Series) -> Any:
    """Return a series as a sympy expression, factored and with the fewest symbols.

    Args:
        series: the series; velocities and accelerations become symbols q', q''.
    """
    return to_formula(series).sympy()


def to_matrix(rows: Iterable[Iterable[Series]]) -> Any:
    """Return rows of series as a sympy Matrix."""
    from sympy import Matrix

    return Matrix([list(map(to_sympy, row)) for row in rows])
