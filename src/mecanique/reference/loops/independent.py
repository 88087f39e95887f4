"""Describe the motion that loops allow near a position, by independent coordinates and velocities.

As many velocities w as there are degrees of freedom are independent; the loops determine the
others: v = T(q) w + b, with b from prescribed motions.

Inverse dynamics asks for the driving forces τ in chosen joints: M a + bias − forces = Jᵀ λ + B τ,
and as λ does no work in the motions T, Tᵀ B τ = Tᵀ (M a + bias − forces) (principle of virtual
work; Shabana, Dynamics of Multibody Systems, sect. 5.5).
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import final

import numpy as np

from mecanique.arrays import Array
from mecanique.errors import ClosureError
from mecanique.reference.engine.tree import EngineTree
from mecanique.reference.loops.assembly import close_position, displace
from mecanique.reference.loops.closed import Closed
from mecanique.reference.loops.nullspace import split
from mecanique.reference.tolerances import DEPENDENT, OPEN, UNBALANCED

_PREFERENCE = 1e3
"""Factor by which a preferred velocity counts more in the choice of independent ones."""


@final
class Independent:
    """Independent coordinates of a mechanism with loops near a position."""

    # With rolling, fewer `rows` restrict positions than velocities: more are independent.
    # Shapes: rows (m,), prefer (nv,)

    def __init__(
        self,
        closed: Closed,  # the mechanism
        q: Array,  # shape (nq,), a position with closed loops
        t: float,  # time [s]
        *,
        rows: Array | None = None,
        prefer: Array | None = None,
    ) -> None:
        from scipy.linalg import qr

        self._closed, self._q, self._t = closed, q, t
        closures = closed.closures
        self._rows: Array = np.ones(len(closures.rows), dtype=bool) if rows is None else rows
        here = closures.scale(q, np.zeros(closed.mechanism.nv), t)
        free = split(here.jacobian[self._rows], rounding=lambda: here.rounding[self._rows]).null
        weight = np.ones(len(free)) if prefer is None else np.where(prefer, _PREFERENCE, 1.0)
        # pivoting chooses the velocities that determine the others best; their order is kept
        _, _, order = qr((weight[:, None] * free).T, pivoting=True)
        free = closures.columns[:, None] * free
        self.chosen: Array = np.sort(order[: free.shape[1]])
        """The indices of the independent velocities, shape (n,)."""
        self.tangent: Array = free @ np.linalg.inv(free[self.chosen])
        """T at q, the derivatives of all coordinates by the independent ones, shape (nv, n)."""
        self._held: Array = np.zeros(len(free), dtype=bool)
        self._held[self.chosen] = True

    def position(self, step: Array) -> Array:
        """Return the closed position after a step of the independent coordinates, shape (nq,)."""
        aside = displace(self._closed, self._q, self.tangent @ step)
        return close_position(self._closed, aside, self._t, self._held)

    def tangents(self, q: Array) -> Array:
        """Return T at a position with closed loops, shape (nv, n)."""
        here = self._closed.closures.at(q, np.zeros(len(self._held)), self._t)
        return self._complete(here.jacobian, np.eye(len(self.chosen)), np.zeros_like(here.drift))

    def velocity(self, q: Array, w: Array) -> Array:
        """Return v, shape (nv,), from the independent velocities at a closed position."""
        v = np.zeros(len(self._held))
        v[self.chosen] = w
        here = self._closed.closures.at(q, v, self._t)
        return self._complete(here.jacobian, w[:, None], here.drift)[:, 0]

    def acceleration(self, q: Array, v: Array, rate: Array) -> Array:
        """Return v', shape (nv,), from the independent velocities' rates in a closed state."""
        here = self._closed.closures.at(q, v, self._t)
        return self._complete(here.jacobian, rate[:, None], here.gamma)[:, 0]

    def _complete(self, jacobian: Array, given: Array, rest: Array) -> Array:
        """Return the columns x with the given independent components and J x + rest = 0."""
        closures = self._closed.closures
        jacobian, rest = jacobian[self._rows], rest[self._rows, None]
        x = np.zeros((len(self._held), given.shape[1]))
        x[self.chosen] = given
        columns = np.where(self._held, 0.0, closures.columns)
        units = closures.rows[self._rows, None]
        off = units * (jacobian @ x + rest)
        J = units * jacobian * columns
        dependent: Array = columns[:, None] * np.linalg.lstsq(J, off, rcond=DEPENDENT)[0]
        return x - dependent


def free_motions(closed: Closed, q: Array, t: float) -> tuple[Array, Array]:
    """Return the independent velocities w, and T of v = T w + b, shape (nv, n)."""
    closed.refuse_open(q, t)
    free = Independent(closed, q, t)
    return free.chosen, free.tangent


def driving_forces(
    tree: EngineTree,
    closed: Closed | None,
    drives: Sequence[str],
    q: Array,
    v: Array,
    t: float,
    a: Array,
) -> Array:
    """Return the forces in some joints that give a mechanism its accelerations, shape (drives,)."""
    name = tree.mechanism.name
    T = np.eye(len(v))
    if closed is not None:
        _, T = free_motions(closed, q, t)
        here = closed.closures.at(q, v, t)
        for what, kind, rest in ((v, "velocities", here.drift), (a, "accelerations", here.gamma)):
            moved = here.jacobian * what
            off = np.abs(closed.closures.rows * (moved.sum(axis=1) + rest))
            size = closed.closures.rows * (np.abs(moved).sum(axis=1) + np.abs(rest))
            if (off > OPEN * max(float(size.max(initial=0.0)), 1.0)).any():
                worst = closed.closures.names[int(off.argmax())]
                raise ClosureError(
                    f"mechanism {name!r}: the loops do not allow these {kind} ({worst}); "
                    "expected J v + b = 0 and J a + γ = 0, see Reference.constraint_jacobian"
                )
    parts = tree.mass(q, v, t) @ a, tree.bias(q, v, t), -tree.forces(q, v, t)
    chart = tree.chart
    chart.place(q, t)
    chart.at(q, v, t)
    B = T.T @ chart.G[[chart.rows[drive] for drive in drives]].T
    needed = T.T @ sum(parts)
    tau: Array = np.linalg.lstsq(B, needed, rcond=DEPENDENT)[0]
    size = np.abs(T.T) @ sum(np.abs(part) for part in parts) + np.abs(B) @ np.abs(tau)
    if (np.abs(B @ tau - needed) > UNBALANCED * size).any():
        raise ClosureError(
            f"mechanism {name!r}: drives in {', '.join(drives)} alone cannot produce these "
            f"accelerations: {T.shape[1]} motions are free; name more joints to drive"
        )
    return tau
