"""Mistakes about constraints: forgotten forces, or velocities eliminated from T."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from itertools import combinations, islice

import numpy as np

from mecanique.arrays import Array
from mecanique.checking.mistakes.slips.hypothesis import Hypothesis, RightEquations
from mecanique.derivation.scalars.series import Series

_MOST_CHOICES = 60
"""Largest number of choices of the eliminated velocities."""

_SINGULAR = 1e8
"""A choice is dropped if its constraints have a larger condition number than this in a state."""


def mistake_constraints(right: RightEquations) -> Iterator[Hypothesis]:
    """Yield equations without the forces of constraints, or with constraints used in T."""
    ties = right.derivation.ties
    for k, tie in enumerate(ties):
        what = f"the force of the constraint {tie.name} (its multiplier) is missing"
        yield Hypothesis("missing", what, 1.2, right.sample.M, right.rest, released=(k,))
    if len(ties) > 1:
        what = "the forces of all constraints (the multipliers) are missing"
        every = tuple(range(len(ties)))
        yield Hypothesis("missing", what, 1.1, right.sample.M, right.rest, released=every)
    if right.truth.mechanism.contacts or right.truth.mechanism.velocity_constraints:
        yield from _put_into_energy(right)


def _put_into_energy(right: RightEquations) -> Iterator[Hypothesis]:
    """Yield the equations from Lagrange's operator on a T from which velocities are eliminated.

    With v_d = B v_i for the eliminated velocities d, they have the extra terms
    Σ p_d (dB_di/dt − ∂(B v)_d/∂q_i), where p = ∂T/∂v. These vanish for integrable constraints
    (Hamel, Theoretische Mechanik, 1949; Neimark & Fufaev, Dynamics of Nonholonomic Systems,
    ch. 3).
    """
    names = right.derivation.algebra.velocities
    if any(not name.endswith("'") for name in names):
        return
    J, changes = _find_slopes(right, names)
    v = np.stack([right.sample.values[name] for name in names], axis=-1)
    p = np.einsum("nij,nj->ni", right.sample.M, v)
    for chosen in islice(combinations(range(len(names)), J.shape[1]), _MOST_CHOICES):
        kept = [k for k in range(len(names)) if k not in chosen]
        surplus = _find_surplus(J, changes, v, p, list(chosen), kept)
        if surplus is None:
            continue
        rest = right.rest.copy()
        rest[:, kept] += surplus
        what = (
            "a constraint on velocities is substituted into T "
            f"({', '.join(names[k] for k in chosen)} eliminated before Lagrange's operator), which "
            "gives extra terms; use multipliers or virtual displacements instead"
        )
        yield Hypothesis("constraint in T", what, 0.8, right.sample.M, rest)


def _find_slopes(right: RightEquations, names: Sequence[str]) -> tuple[Array, Array]:
    """Return J and ∂J/∂q_k, shape (n, m, nv) and (nv, n, m, nv)."""
    rows = [
        tie.second.linear(right.derivation.algebra.accelerations)[0]
        for tie in right.derivation.ties
    ]
    moving = {g.name for row in rows for entry in row for g in entry.generators()}
    J = right.sample.slopes
    changes = np.zeros((len(names), *J.shape))
    for k, name in enumerate(names):
        if name[:-1] in moving:
            changes[k] = right.stack([_differentiate(row, name[:-1]) for row in rows])
    return J, changes


def _differentiate(row: Sequence[Series], name: str) -> list[Series]:
    return [entry.diff(name) for entry in row]


def _find_surplus(
    J: Array, changes: Array, v: Array, p: Array, chosen: list[int], kept: list[int]
) -> Array | None:
    """Return the extra terms, shape (n, kept); None if the choice is not possible."""
    own = J[:, :, chosen]
    with np.errstate(all="ignore"):
        condition = np.linalg.cond(own)
    if not (condition < _SINGULAR).all():
        return None
    B = -np.linalg.solve(own, J[:, :, kept])
    # D_k B, along the motion of each kept coordinate that the constraint allows
    along = np.stack(
        [-np.linalg.solve(own, change[:, :, kept] + change[:, :, chosen] @ B) for change in changes]
    )
    ways = along[kept] + np.einsum("ndk,dnei->knei", B, along[chosen])
    rates = np.einsum("nk,kndi->ndi", v[:, kept], ways)
    slopes = np.einsum("nk,indk->ndi", v[:, kept], ways)
    return np.asarray(np.einsum("nd,ndi->ni", p[:, chosen], rates - slopes))
