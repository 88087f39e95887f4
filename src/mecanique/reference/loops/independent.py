"""The motion that loops leave free near a position, by independent coordinates and velocities.

As many velocities w as there are degrees of freedom are independent; the loops determine the
others: v = T(q) w + b, with b from what moves by itself.
"""

from __future__ import annotations

from typing import final

import numpy as np

from mecanique.reference.engine.answers import Array
from mecanique.reference.loops.assembly import close_position
from mecanique.reference.loops.closed import Closed
from mecanique.reference.loops.newton import displace
from mecanique.reference.loops.nullspace import split
from mecanique.reference.loops.tolerances import DEPENDENT

__all__ = ["Independent"]


@final
class Independent:
    """Independent coordinates of a mechanism with loops near a position.

    Args:
        closed: the mechanism.
        q: shape (nq,), where the loops are closed.
        t: time [s].
    """

    def __init__(self, closed: Closed, q: Array, t: float) -> None:
        from scipy.linalg import qr

        self._closed, self._q, self._t = closed, q, t
        closures = closed.closures
        free = split(closures.scale(q, np.zeros(closed.mechanism.nv), t).jacobian).null
        # the velocities that move the others best are the independent ones; in their order
        _, _, order = qr(free.T, pivoting=True)
        free = closures.columns[:, None] * free
        self.chosen: Array = np.sort(order[: free.shape[1]])
        """Which velocities are independent, shape (n,)."""
        self.tangent: Array = free @ np.linalg.inv(free[self.chosen])
        """T at q, the deviations of all coordinates by the independent ones, shape (nv, n)."""
        self._held: Array = np.zeros(len(free), dtype=bool)
        self._held[self.chosen] = True

    def position(self, step: Array) -> Array:
        """Return the position on the loops a step of the independent coordinates away, shape (nq,).

        Args:
            step: shape (n,).

        Raises:
            ClosureError: if the loops cannot be closed there.
        """
        aside = displace(self._closed, self._q, self.tangent @ step)
        return close_position(self._closed, aside, self._t, self._held)

    def tangents(self, q: Array) -> Array:
        """Return T at a position on the loops, shape (nv, n)."""
        none = np.zeros((len(self._closed.closures.rows), 1))
        return self._complete(q, np.zeros(len(self._held)), np.eye(len(self.chosen)), none)

    def velocity(self, q: Array, w: Array) -> Array:
        """Return v, shape (nv,), by the independent velocities, at a position on the loops."""
        v = np.zeros(len(self._held))
        v[self.chosen] = w
        drift = self._closed.closures.at(q, v, self._t).drift
        return self._complete(q, v, w[:, None], drift[:, None])[:, 0]

    def acceleration(self, q: Array, v: Array, rate: Array) -> Array:
        """Return v', shape (nv,), by the independent velocities' rates, in a state on the loops."""
        gamma = self._closed.closures.at(q, v, self._t).gamma
        return self._complete(q, v, rate[:, None], gamma[:, None])[:, 0]

    def _complete(self, q: Array, v: Array, given: Array, rest: Array) -> Array:
        """Return the columns x with the given independent components and J x + rest = 0."""
        closures = self._closed.closures
        jacobian = closures.at(q, v, self._t).jacobian
        x = np.zeros((len(self._held), given.shape[1]))
        x[self.chosen] = given
        columns = np.where(self._held, 0.0, closures.columns)
        off = closures.rows[:, None] * (jacobian @ x + rest)
        J = closures.rows[:, None] * jacobian * columns
        dependent: Array = columns[:, None] * np.linalg.lstsq(J, off, rcond=DEPENDENT)[0]
        return x - dependent
