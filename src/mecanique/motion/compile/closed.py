"""Closed mechanisms by their program, or by the reference near a singular position."""

from __future__ import annotations

from typing import TYPE_CHECKING, final

import numpy as np

from mecanique.generation.dop853 import ASTRAY, CLOSED, FIRM, HALVED, PROBE, ROUNDING, SWEEPS
from mecanique.model.mechanism_units import coordinate_scales, velocity_scales
from mecanique.motion.compile.program import RatesProgram
from mecanique.motion.compile.python import list_values
from mecanique.motion.record.curve import RightHandSide
from mecanique.motion.record.rates import Rates

if TYPE_CHECKING:
    from mecanique.generation.program import LoopProjection
    from mecanique.reference import Reference


_NEAR = 0.6
"""Distance from a singular position, in characteristic lengths or radians, that counts as near.

Beyond it the reference takes its accelerations from the state itself, as the program does.
"""


@final
class ClosedProgram:
    """f(t, y) = y' and the way back onto the loops, for one integration."""

    def __init__(
        self,
        program: RatesProgram,
        landing: LoopProjection,
        reference: Reference,
        quick: RightHandSide,
    ) -> None:
        assert reference.closed is not None, "the mechanism has loops"
        from mecanique.reference.loops.singular import ClosedRhs

        self._quick = quick
        self._slow = slow = reference.rhs()
        self._turns_at = slow.turns_at if isinstance(slow, ClosedRhs) else _nowhere
        self._changes = list_values(program, landing.changes)
        self._firmness = list_values(program, (landing.firmness,))
        self._plain = velocity_scales(program.mechanism)
        self._rates = Rates.of(program.mechanism)
        self._nq = program.mechanism.nq
        length = reference.closed.closures.length
        self._per_unit = 1 / coordinate_scales(program.mechanism, self._plain, length)
        self._regular: np.ndarray = np.full(self._nq, np.inf)
        self._radius = 0.0

    def __call__(self, t: float, y: np.ndarray) -> np.ndarray:
        """Return the rates of a state, which the next call may overwrite."""
        return self._quick(t, y) if self._is_regular(t, y) else self._slow(t, y)

    def close(self, t: float, y: np.ndarray) -> np.ndarray | None:
        """Return the state (nq + nv,) on the loops near y; None near a singular position."""
        if not self._is_regular(t, y):
            return None
        # as `land` does with many states, whose arrays would take as long as the step here
        nq, last = self._nq, ASTRAY
        there = np.concatenate([self._rates.normalize(y[:nq]), y[nq:]])
        for _ in range(SWEEPS):
            change = np.array(self._changes(t, there))
            size = float(np.abs(change[:nq]).max())
            most = max(1.0, float(np.abs(there[:nq]).max()))
            if size <= ROUNDING * most or size > HALVED * last:
                # rounding is left; the velocities suit the positions as they are
                there[nq:] += change[nq:]
                return there if size <= CLOSED * most else None
            there[:nq] += change[:nq]
            last = size
        return None

    def crosses_at(self, t: float, y: np.ndarray) -> bool:
        """Return whether branches cross near a state, so that the motion passes smoothly."""
        crosses_at = getattr(self._slow, "crosses_at", _nowhere)
        if len(y) != 2 * self._nq or crosses_at is _nowhere:
            return False
        self._slow(t, y)  # which judges what lies ahead
        return bool(crosses_at(y[: self._nq]))

    def _is_regular(self, t: float, y: np.ndarray) -> bool:
        """Whether no singular position is to be passed; it is remembered where none is near."""
        if self._turns_at(y[: self._nq]):
            return True
        off = (y[: self._nq] - self._regular) * self._per_unit
        if max(off.max(), -off.min()) < self._radius:
            return True
        try:
            distance = self._distance(t, y)
        except (ArithmeticError, ValueError):
            return False
        self._regular = y[: self._nq].copy()
        self._radius = min(distance - _NEAR, _NEAR) / 2
        return bool(self._radius > 0)

    def _distance(self, t: float, y: np.ndarray) -> float:
        """Distance along the motion to a singular position, to first order."""
        speed = float(np.abs(y[self._nq :] / self._plain).max())
        (firmness,) = self._firmness(t, y)
        if not firmness > FIRM:
            return 0.0
        if speed == 0.0:
            return float("inf")
        ahead = y.copy()
        ahead[: self._nq] += PROBE / speed * self._quick(t, y)[: self._nq]
        change = abs(self._firmness(t, ahead)[0] - firmness)
        return firmness * PROBE / change if change else float("inf")


def _nowhere(q: np.ndarray) -> bool:
    return False
