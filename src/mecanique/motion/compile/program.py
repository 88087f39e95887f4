"""The equations of motion as one straight-line program ẏ = f(t, y)."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, final

from mecanique.model.mechanism import Mechanism

if TYPE_CHECKING:
    from mecanique.generation.program import LoopProjection
    from mecanique.program.tape import Tape, Value


SAMPLES = 10
"""Number of random states at which a program is compared before it is used."""


LONG = 8
"""Velocities from which on a chain takes fewer operations by this elimination than by a matrix.

Counted for rows of parallelograms: by a matrix 1,312 operations with 5 velocities, 7,902 with 11
and 40,492 with 21; by elimination 1,342, 3,865 and 8,070, and 400 for each velocity more.
"""


def is_long_chain(mechanism: Mechanism) -> bool:
    """Return whether a mechanism is large, and closed by loops between its joints alone."""
    plain = not mechanism.contacts and not mechanism.velocity_constraints
    return plain and bool(mechanism.loops) and mechanism.nv >= LONG


@final
@dataclass(frozen=True)
class RatesProgram:
    """A straight-line program that gives the rates of a mechanism's state.

    Its inputs are named as the mechanism names them: coordinates, velocities, "t", parameters left
    open, and signals that are functions.
    """

    mechanism: Mechanism
    tape: Tape
    rates: tuple[Value, ...]  # value of each rate, first of q, then of v, shape (nq + nv,)
    open: tuple[str, ...]  # parameters that are inputs, by symbol
    signals: tuple[str, ...]  # inputs of the mechanism that are functions of time, by symbol
    landing: LoopProjection | None = None  # of closed mechanisms, how they stay on their loops
    more: tuple[str, ...] = ()  # inputs that are parts of the state, after the velocities

    @property
    def states(self) -> tuple[str, ...]:
        """Names of the state's parts: coordinates, then velocities, and more if there are any."""
        return (*self.mechanism.coordinates.names, *self.mechanism.velocities, *self.more)

    @property
    def length(self) -> int:
        """How many operations give the rates, and keep the loops closed."""
        landing = self.landing
        closing = () if landing is None else (*landing.changes, landing.firmness)
        return len(self.tape.find_needed([*self.rates, *closing]))
