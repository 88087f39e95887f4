"""Find where contacts and cords cease to hold: a pull, a push, or too much friction.

What rolls presses on its plane, and a cord pulls; equations of motion know neither. Where the
normal force or a tension passes zero, or friction the coefficient that a contact has, the motion
from there on is that of no real mechanism.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, final

import numpy as np

from mecanique.arrays import Array
from mecanique.model.constraint_base import PressingContact
from mecanique.model.mechanism import Mechanism
from mecanique.motion.record.curve import Curve
from mecanique.motion.record.events import Event, Occurrence, break_names

if TYPE_CHECKING:
    from mecanique.reference import Reference


_IDLE = 1e-12
"""A row of constraints, in natural units, that no motion of the mechanism changes by more."""


@final
@dataclass(frozen=True)
class Pressing:
    """Normal force and friction of what rolls, along a motion."""

    contact: PressingContact
    normal: Array  # shape (n,); NaN where it is undetermined [N]
    friction: Array  # shape (n,), its magnitude, likewise [N]


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
    names = break_names(mechanism)
    return tuple(Event(name, Margin(mechanism, k), -1, stop) for k, name in enumerate(names))


def find_breaks(mechanism: Mechanism, reference: Reference, curve: Curve) -> tuple[Occurrence, ...]:
    """Return where along a motion contacts and cords cease to hold, amiss at its start or later."""
    margins = _Margins(mechanism, reference)
    from scipy.optimize import brentq

    times = np.unique(np.concatenate([curve.t, (curve.t[1:] + curve.t[:-1]) / 2]))
    states = curve(times)
    along = zip(states.q, states.v, times.tolist(), strict=True)
    rows = np.array([margins.at(*state) for state in along])
    breaks = []
    for k, name in enumerate(margins.names):
        falls = np.flatnonzero((rows[:-1, k] > 0) & (rows[1:, k] <= 0))
        moments = [float(times[0])] if rows[0, k] < 0 else []
        for i in falls.tolist():

            def margin(t: float, k: int = k) -> float:
                state = curve(t)
                return float(margins.at(state.q, state.v, t)[k])

            moments.append(float(brentq(margin, times[i], times[i + 1], xtol=1e-13, rtol=1e-13)))
        for t in moments:
            state = curve(t)
            breaks.append(Occurrence(name, t, state.q, state.v, state.v))
    return tuple(breaks)


def margins_along(reference: Reference, q: Array, v: Array, t: Array) -> Array:
    """Return what contacts and cords have left, shape (n, names) [N]; NaN if undetermined."""
    margins = _Margins(reference.mechanism, reference)
    return np.array([margins.at(*state) for state in zip(q, v, t.tolist(), strict=True)])


def pressings(reference: Reference, q: Array, v: Array, t: Array) -> tuple[Pressing, ...]:
    """Return normal force and friction of all that rolls, in n states."""
    rolling = [c for c in reference.mechanism.contacts if isinstance(c, PressingContact)]
    if not rolling:
        return ()
    states = zip(q, v, t.tolist(), strict=True)
    forces = np.array([_contact_forces(reference, *state) for state in states])
    names = _row_names(reference)
    result: list[Pressing] = []
    for contact in rolling:
        N, x, y = (forces[:, names.index(f"{contact.name}: {row}")] for row in contact.rows)
        result.append(Pressing(contact, N, np.hypot(x, y)))
    return tuple(result)


@final
@dataclass(frozen=True)
class Margin:
    """The margin to one of the limits, as the quantity of an event."""

    mechanism: Mechanism
    which: int

    def __call__(self, t: float, q: Array, v: Array) -> float:
        """Return the margin [N]."""
        from mecanique.reference import Reference

        return float(_Margins(self.mechanism, Reference.of(self.mechanism)).at(q, v, t)[self.which])


@final
class _Margins:
    """The margins to all limits [N]: normal forces, reserves of friction, tensions."""

    def __init__(self, mechanism: Mechanism, reference: Reference) -> None:
        self._reference = reference
        self._rolling = [
            contact for contact in mechanism.contacts if isinstance(contact, PressingContact)
        ]
        self._coefficients = [
            None if contact.friction is None else mechanism.evaluate(contact.friction)
            for contact in self._rolling
        ]
        self._tensions = [name for contact in mechanism.elements for name in contact.tensions]
        self.names = break_names(mechanism)

    def at(self, q: Array, v: Array, t: float) -> Array:
        """Return the margins in a state, shape (n,); NaN where forces are undetermined."""
        margins: list[float] = []
        if self._rolling:
            forces, names = _contact_forces(self._reference, q, v, t), _row_names(self._reference)
            for contact, coefficient in zip(self._rolling, self._coefficients, strict=True):
                N, x, y = (forces[names.index(f"{contact.name}: {row}")] for row in contact.rows)
                margins.append(N)
                if coefficient is not None:
                    margins.append(coefficient * N - np.hypot(x, y))
        if self._tensions:
            tensions = self._reference.guide_forces(q, v, t)
            margins += [float(tensions[name]) for name in self._tensions]
        return np.array(margins)


def _contact_forces(reference: Reference, q: Array, v: Array, t: float) -> Array:
    """The multipliers in a state that may be off the loops by the tolerance, NaN if not known.

    Where guides alone hold a body against a row, nothing presses it there.
    """
    closed = reference.closed
    assert closed is not None, "the mechanism has contacts"
    solved = closed.solve(q, v, t)
    if solved.determined.all():
        return solved.multipliers
    jacobian = closed.closures.at(q, v, t).jacobian
    units = closed.measure(jacobian).units
    idle = np.abs(units.rows[:, None] * jacobian * units.columns).max(axis=1) < _IDLE
    known: Array = np.where(solved.determined | idle, solved.multipliers, np.nan)
    return known


def _row_names(reference: Reference) -> tuple[str, ...]:
    closed = reference.closed
    assert closed is not None, "the mechanism has contacts"
    return tuple(closed.closures.names)
