"""Divide a closed mechanism into parts: sets of constraints that share no motion.

Each part has its own scale and is closed by itself, with the same result as if it were alone.
"""

from __future__ import annotations

from typing import final

import numpy as np
import numpy.typing as npt

from mecanique.arrays import Array
from mecanique.model.mechanism import Mechanism
from mecanique.model.units import characteristic_length


@final
class Parts:
    """The part of each constraint and each velocity.

    Args:
        mechanism: the mechanism.
        meets: whether a constraint may depend on a velocity, shape (m, nv) of bool.
        owner: index of the loop, contact or velocity constraint of each row, shape (m,).
    """

    def __init__(self, mechanism: Mechanism, meets: npt.NDArray[np.bool_], owner: Array) -> None:
        rows, none = np.array(owner), len(meets)
        while True:
            # give rows that share a velocity their least number, until nothing changes
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
        """Number of the part of each velocity, −1 if it moves no loop, shape (nv,)."""
        self.count = len(numbers)
        self.length = characteristic_length(mechanism)
        """The characteristic length of the whole mechanism [m]."""
        self.lengths: Array = np.full(self.count, self.length)
        """The characteristic length of each part [m]."""
        for part in range(self.count if self.count > 1 else 0):
            names = _carriers(mechanism, set(owner[self.rows == part].tolist()))
            self.lengths[part] = characteristic_length(mechanism, names)

    def open(self, rows: npt.NDArray[np.bool_]) -> npt.NDArray[np.bool_]:
        """Return whether each velocity belongs to the part of one of some rows, shape (nv,)."""
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
