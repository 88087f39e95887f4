"""What holds in every mode along a motion: bodies that roll, and cords that pull.

They are elements of one state. Equations of motion know neither normal forces nor tensions: where
one passes zero, or friction the coefficient that a contact has, the motion from there on is that
of no real mechanism.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, final

import numpy as np

from mecanique.arrays import Array
from mecanique.model.constraint_base import PressingContact
from mecanique.model.mechanism import Mechanism
from mecanique.motion.compile.along import StateLaw
from mecanique.motion.record.events import Event, Margin, break_names

if TYPE_CHECKING:
    from mecanique.reference import Reference


def contact_events(mechanism: Mechanism, *, stop: bool = False) -> tuple[Event, ...]:
    """Return the events at which contacts and cords cease to hold.

    `simulate` finds them by itself in the motion it returns; given to it, they can stop it.

    Args:
        mechanism: a mechanism with contacts or cords.
        stop: whether a motion ends at the first of them.

    Returns:
        The events, to be given to `simulate`.

    Example:
        >>> machine = mq.textbook.load("atwood_machine")
        >>> [event.name for event in mq.contact_events(machine)]
        ['cord_1 would push', 'cord_2 would push']
    """
    holding, names = Holding(mechanism), break_names(mechanism)
    return tuple(Event(name, Margin(holding, (k,)), -1, stop) for k, name in enumerate(names))


@final
@dataclass(frozen=True, eq=False)
class Holding:
    """The normal forces, friction and tensions of a mechanism's rolling contacts and cords."""

    mechanism: Mechanism
    given: Reference | None = None

    @property
    def _law(self) -> StateLaw:
        from mecanique.reference import Reference

        return StateLaw(self.mechanism, self.given or Reference.of(self.mechanism))

    def forces(self, t: Array, q: Array, v: Array) -> dict[str, Array]:
        """Return them in n states by name, shape (n,) [N]; NaN where they are undetermined."""
        rolls = any(isinstance(contact, PressingContact) for contact in self.mechanism.contacts)
        pressed = self._law.multipliers(t, q, v) if rolls else {}
        return pressed | self._law.guide_forces(t, q, v)

    def margins(self, t: float | Array, q: Array, v: Array) -> Array:
        """Return what each has left, shape (names,) or, in n states, (n, names) [N]."""
        from mecanique.derivation.mechanics.switching import list_holding_margins

        times = np.atleast_1d(t)
        forces = self.forces(times, np.atleast_2d(q), np.atleast_2d(v))
        left = list_holding_margins(self.mechanism, forces, self.mechanism.evaluate, np.hypot)
        margins: Array = np.array(left).reshape(len(left), len(times)).T
        return margins[0] if np.ndim(t) == 0 else margins
