"""The parts of a closed mechanism: sets of constraints that share no motion, each with its scale.

Each is closed by itself, so that it ends where it would alone, however large another is beside it.
"""

from __future__ import annotations

from typing import final

import numpy as np
import numpy.typing as npt

from mecanique.arrays import Array
from mecanique.model.mechanism import Mechanism
from mecanique.model.units import characteristic_length

__all__ = ["Parts"]


@final
class Parts:
    """Which part each constraint and each velocity belongs to.

    Args:
        mechanism: the mechanism.
        meets: whether a constraint may depend on a velocity, shape (m, nv) of bool.
        owner: which loop, contact or velocity constraint each row belongs to, shape (m,).
    """

    def __init__(self, mechanism: Mechanism, meets: npt.NDArray[np.bool_], owner: Array) -> None:
        rows, none = np.array(owner), len(meets)
        while True:
            # the least number among the rows that share a velocity, until nothing changes
            columns = np.where(meets, rows[:, None], none).min(axis=0, initial=none)
            least = np.where(meets, columns, none).min(axis=1, initial=none)
            joined = np.minimum(rows, least)
            joined = np.array([joined[owner == own].min() for own in owner], dtype=int)
            if np.array_equal(joined, rows):
                break
            rows = joined
        numbers = np.unique(rows)
        self.rows: npt.NDArray[np.int_] = np.searchsorted(numbers, rows)
        """Number of the part of each row, shape (m,)."""
        self.columns: npt.NDArray[np.int_] = np.where(
            columns < none, np.searchsorted(numbers, columns), -1
        )
        """The same of each velocity, −1 if it moves no loop, shape (nv,)."""
        self.count = len(numbers)
        self.length = characteristic_length(mechanism)
        """That of the whole [m]."""
        self.lengths: Array = np.full(self.count, self.length)
        """What lengths are compared with in each part [m]."""
        for part in range(self.count if self.count > 1 else 0):
            names = _carriers(mechanism, set(owner[self.rows == part].tolist()))
            self.lengths[part] = characteristic_length(mechanism, names)

    def open(self, rows: npt.NDArray[np.bool_]) -> npt.NDArray[np.bool_]:
        """Return which velocities belong to the parts of some rows, shape (nv,)."""
        return np.isin(self.columns, self.rows[rows])


def _carriers(mechanism: Mechanism, owners: set[int]) -> set[str]:
    """Return the names of some loops and contacts, and of the joints that carry them."""
    above = {joint.child: joint for joint in mechanism.joints}
    ends = {
        **{k: (loop.name, loop.body_a, loop.body_b) for k, loop in enumerate(mechanism.loops)},
        **{
            k: (contact.name, contact.body, contact.on)
            for k, contact in enumerate(mechanism.contacts, len(mechanism.loops))
        },
    }
    found = set[str]()
    for name, *bodies in (ends[k] for k in owners & ends.keys()):
        found.add(name)
        for body in bodies:
            while body in above:
                found.add(above[body].name)
                body = above[body].parent
    return found
