"""Describe the motion that loops allow near a position, by independent coordinates and velocities.

As many velocities w as there are degrees of freedom are independent; the loops determine the
others: v = T(q) w + b, with b from prescribed motions.
"""

from __future__ import annotations

from typing import final

import numpy as np

from mecanique.arrays import Array
from mecanique.reference.loops.assembly.closing import close_position
from mecanique.reference.loops.assembly.newton import displace
from mecanique.reference.loops.closed import Closed
from mecanique.reference.loops.nullspace import split
from mecanique.reference.loops.tolerances import DEPENDENT

_PREFERENCE = 1e3
"""Factor by which a preferred velocity counts more in the choice of independent ones."""


@final
class Independent:
    """Independent coordinates of a mechanism with loops near a position.

    Args:
        closed: the mechanism.
        q: shape (nq,), a position with closed loops.
        t: time [s].
        rows: shape (m,), the constraints to use; all by default. With rolling, fewer rows restrict
            positions than velocities, so there are more independent coordinates.
        prefer: shape (nv,), the velocities that are to be independent if possible.
    """

    def __init__(
        self,
        closed: Closed,
        q: Array,
        t: float,
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
        """Return the closed position after a step of the independent coordinates, shape (nq,).

        Args:
            step: shape (n,).

        Raises:
            ClosureError: if the loops cannot be closed there.
        """
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
