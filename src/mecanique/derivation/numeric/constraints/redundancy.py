"""Find redundant constraints: equations that follow from the others wherever these hold.

The rank in a single state is decided where multipliers are solved for (`multipliers`).
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import NamedTuple, final

import numpy as np

from mecanique.derivation.numeric.constraints.rows import Held
from mecanique.derivation.tolerances import CLOSED, RANK_CLOSED
from mecanique.model.mechanism import Mechanism
from mecanique.model.mechanism_units import characteristic_length, velocity_scales
from mecanique.model.random_positions import draw_positions
from mecanique.model.states import States

_POSITIONS, _STEPS = 8, 50
"""Number of random positions to start from, and Newton iterations from each."""


@final
class Redundancy(NamedTuple):
    """The redundant equations among a mechanism's constraints."""

    rows: tuple[str, ...]  # names of those that follow from the ones before them
    shared: tuple[str, ...]  # names of those whose multipliers are not determined individually


def find_redundancy(mechanism: Mechanism) -> Redundancy:
    """Find the equations that are redundant in every sampled position that can be reached."""
    held = Held(mechanism)
    rows, shared = set(range(len(held.names))), set(range(len(held.names)))
    closed = False
    for q in _find_positions(mechanism, held):
        closed = True
        J = held.at(_rest_at(mechanism, q[None])).jacobian[0] * velocity_scales(mechanism)
        size = np.linalg.norm(J, axis=1, keepdims=True)
        J = J / np.where(size > 0, size, 1.0)
        ranks = (np.linalg.matrix_rank(J[:k], tol=RANK_CLOSED) for k in range(1, len(J) + 1))
        rank = [0, *map(int, ranks)]
        rows &= {k for k in range(len(J)) if rank[k + 1] == rank[k]}
        if not rows:
            break
        left = np.linalg.svd(J)[0][:, rank[-1] :]
        shared &= set(np.flatnonzero((np.abs(left) > RANK_CLOSED).any(axis=1)).tolist())
    if not closed or not rows:
        return Redundancy((), ())
    return Redundancy(*(tuple(map(held.names.__getitem__, sorted(k))) for k in (rows, shared)))


def _find_positions(mechanism: Mechanism, held: Held) -> Iterator[np.ndarray]:
    """Yield positions that satisfy the constraints, near random ones; quaternions are not moved."""
    # All are sought at once, and those found with the fewest iterations come first
    random = np.random.default_rng(0)
    velocities = mechanism.velocities
    plain = [k for k, name in enumerate(mechanism.coordinates) if f"{name}'" in velocities]
    columns = [velocities.index(f"{mechanism.coordinates[k]}'") for k in plain]
    units = velocity_scales(mechanism)[columns]
    q = draw_positions(mechanism, _POSITIONS, random, 3 * characteristic_length(mechanism))
    for _ in range(_STEPS):
        with np.errstate(all="ignore"):
            at = held.at(_rest_at(mechanism, q))
        gaps = at.residual / held.row_units.units
        J = at.jacobian[:, :, columns] * units / held.row_units.units[:, None]
        finite = np.isfinite(gaps).all(axis=1) & np.isfinite(J).all(axis=(1, 2))
        closed = finite & (np.abs(gaps).max(axis=1, initial=0.0) < CLOSED)
        yield from q[closed]
        left = finite & ~closed
        if not left.any():
            return
        q = q[left]
        for place, gap, slope in zip(q, gaps[left], J[left], strict=True):
            holonomic = gap != 0.0
            place[plain] -= units * np.linalg.lstsq(slope[holonomic], gap[holonomic], rcond=1e-6)[0]


def _rest_at(mechanism: Mechanism, q: np.ndarray) -> States:
    """Return the states of rest in positions, which may lie beyond limits during iterations."""
    rest = np.zeros((len(q), mechanism.nv))
    return States(mechanism, q, rest, np.zeros(len(q)), rest)
