"""What constraints leave free near a position, and the forces along it."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING, TypeAlias, final

import numpy as np

from mecanique.arrays import Array
from mecanique.model import Input, Mechanism
from mecanique.model.expression import symbols_in
from mecanique.motion.linear.held import HeldMode, ModeMotion
from mecanique.motion.record.rates import Rates

if TYPE_CHECKING:
    from mecanique.reference import Reference
    from mecanique.reference.loops.independent import Independent

FreeMotion: TypeAlias = "Independent | ModeMotion | TreeMotion"
"""What is free to move near a position."""


@final
class TreeMotion:
    """The motion of a tree near a position, described as `Independent` does: all of it is free."""

    def __init__(self, mechanism: Mechanism, q: Array) -> None:
        self._rates, self._q = Rates.of(mechanism), q
        self.chosen = np.arange(mechanism.nv)
        self.tangent: Array = np.eye(mechanism.nv)

    def position(self, step: Array) -> Array:
        """Return the position after a step along the velocities, shape (nq,)."""
        return self._rates.displace(self._q, step)

    def tangents(self, q: Array) -> Array:
        """Return unity, shape (nv, nv)."""
        return self.tangent

    def velocity(self, q: Array, w: Array) -> Array:
        """Return w itself, shape (nv,)."""
        return w

    def acceleration(self, q: Array, v: Array, rate: Array) -> Array:
        """Return the rate itself, shape (nv,)."""
        return rate


def free_near(
    reference: Reference | HeldMode,
    q: Array,
    t: float,
    *,
    positional: bool = False,
    prefer: Array | None = None,
) -> FreeMotion:
    """Return the motion that constraints leave free near a position, or those of positions do."""
    if isinstance(reference, HeldMode):
        return ModeMotion(reference, q, t)
    closed = reference.closed
    if closed is None:
        return TreeMotion(reference.mechanism, q)
    from mecanique.reference.loops.independent import Independent

    rows = closed.closures.positional if positional else None
    return Independent(closed, q, t, rows=rows, prefer=prefer)


def effort(
    reference: Reference | HeldMode,
    free: FreeMotion,
    q: np.ndarray,
    w: np.ndarray,
    rate: np.ndarray,
    t: float,
) -> np.ndarray:
    """Return Tᵀ (M a + bias − forces), shape (n,), for free velocities w and their rate."""
    v = free.velocity(q, w)
    a = free.acceleration(q, v, rate)
    along: np.ndarray = free.tangents(q).T @ reference.inverse_dynamics(q, v, a, t)
    return along


def _changes(signal: Input) -> bool:
    return callable(signal.signal) or "t" in symbols_in(signal.signal)


def drop_disturbances(mechanism: Mechanism) -> Mechanism:
    """Return a mechanism whose inputs that change with time are zero."""
    if not any(_changes(signal) for signal in mechanism.inputs):
        return mechanism
    inputs = tuple(
        replace(signal, signal=0.0) if _changes(signal) else signal for signal in mechanism.inputs
    )
    return replace(mechanism, inputs=inputs)
