"""Constraints on velocities in general, Σ A_i(q, t) v_i = b(q, t).

A constraint Σ A_i(q) q_i' = 0 that is the rate of some function of q is holonomic in disguise.
Whether there is such a function is decided by Frobenius' condition: on the velocities that all
constraints allow, the curl of each form Σ A_i dq_i must vanish (Goldstein, Classical Mechanics,
1980, sect. 1-3; Frobenius, J. Reine Angew. Math. 82 (1877) 230).
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, final

import numpy as np

from mecanique.arrays import rank_of
from mecanique.model.expression import Scalar, evaluate, plain

_POINTS = 4
"""Number of random positions at which the condition is checked."""


@final
@dataclass(frozen=True)
class VelocityConstraint:
    """A linear constraint on velocities, `Σ A_i v_i = b`, e.g. of a steered wheel or a drive.

    Contacts also say by which force they act, and where; this one does not.
    One that is the rate of a constraint on positions is refused: the coordinate map or a loop says
    that.

    Args:
        name: its name.
        coefficients: velocity, or the coordinate whose rate it is -> A_i, an expression in
            coordinates, parameters and t.
        rate: b, an expression in the same.

    Example:
        >>> theta = mq.coordinate("theta")
        >>> side = mq.VelocityConstraint("no side slip", {"x": mq.sin(theta), "y": -mq.cos(theta)})
        >>> side.terms
        {'x': sin(theta), 'y': -cos(theta)}
    """

    name: str
    coefficients: Mapping[str, Scalar] | tuple[tuple[str, Scalar], ...]
    rate: Scalar = 0.0

    def __post_init__(self) -> None:
        given = self.coefficients
        pairs = given.items() if isinstance(given, Mapping) else given
        object.__setattr__(
            self, "coefficients", tuple((name, plain(scalar)) for name, scalar in pairs)
        )
        object.__setattr__(self, "rate", plain(self.rate))

    @property
    def terms(self) -> dict[str, Scalar]:
        """Velocity, or its coordinate -> coefficient."""
        return dict(self.coefficients)

    @property
    def scalars(self) -> tuple[Scalar, ...]:
        """All expressions in it."""
        return (*self.terms.values(), self.rate)

    def along(self, velocities: Sequence[str]) -> list[Scalar]:
        """Return A_i for each velocity of a mechanism.

        Args:
            velocities: their names.
        """
        named = {name if name in velocities else f"{name}'": A for name, A in self.terms.items()}
        return [named.get(name, 0.0) for name in velocities]


def is_integrable(
    constraints: Sequence[VelocityConstraint],
    coordinates: Sequence[str],
    values: Mapping[str, float],
) -> bool:
    """Return whether constraints on velocities are, together, constraints on positions."""
    from sympy import Symbol, sympify

    names = (*coordinates, "t")
    symbols = [Symbol(name) for name in names]
    rates = [f"{name}'" for name in coordinates]
    # Σ A_i dq_i − b dt
    forms = [
        [*map(sympify, constraint.along(rates)), -sympify(constraint.rate)]
        for constraint in constraints
    ]
    curls = [_curl(form, symbols) for form in forms]
    random = np.random.default_rng(1877)
    for _ in range(_POINTS):
        point = random.uniform(0.2, 1.2, len(names)).tolist()
        at = {**values, **dict(zip(names, point, strict=True))}
        A = _numbers(forms, at)
        _, sizes, right = np.linalg.svd(A)
        free = right[rank_of(sizes, 1e-12) :]
        for curl in curls:
            # Frobenius: dA is to vanish on the motions that A admits
            inside = free @ _numbers(curl, at) @ free.T
            if np.abs(inside).max(initial=0.0) > 1e-9 * max(1.0, float(np.abs(A).max())):
                return False
    return True


def _numbers(rows: Sequence[Sequence[Any]], values: Mapping[str, float]) -> np.ndarray:
    """Evaluate a matrix of expressions."""
    flat = [float(evaluate(entry, values)) for row in rows for entry in row]
    return np.array(flat).reshape(len(rows), -1)


def _curl(form: Sequence[Any], symbols: Sequence[Any]) -> list[list[Any]]:
    """∂A_k/∂q_i − ∂A_i/∂q_k."""
    curl = []
    for a, x in zip(form, symbols, strict=True):
        curl.append([b.diff(x) - a.diff(y) for b, y in zip(form, symbols, strict=True)])
    return curl
