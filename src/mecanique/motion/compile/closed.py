"""Closed mechanisms by their program, or by the reference near a singular position."""

from __future__ import annotations

from collections.abc import Callable
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


def land(
    change: Callable[[np.ndarray, np.ndarray, np.ndarray], np.ndarray], q: np.ndarray, v: np.ndarray
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return the states on the loops near some, (n, nq) and (n, nv), and which landed there.

    `change` gives the first-order changes, shape (k, nq + nv), of states by their indices, q and v.
    """
    q, v = q.copy(), v.copy()
    last, landed, open_ = np.full(len(q), ASTRAY), np.zeros(len(q), dtype=bool), np.arange(len(q))
    for _ in range(SWEEPS):
        of_q, of_v = np.hsplit(change(open_, q[open_], v[open_]), [q.shape[1]])
        size = np.abs(of_q).max(axis=1)
        most = np.maximum(1.0, np.abs(q[open_]).max(axis=1))
        goes_on = (size > ROUNDING * most) & (size <= HALVED * last[open_])
        # where rounding is left, the velocities suit the positions as they are
        ended = open_[~goes_on]
        v[ended] += of_v[~goes_on]
        landed[ended] = (size <= CLOSED * most)[~goes_on]
        last[open_], open_ = size, open_[goes_on]
        if not len(open_):
            break
        q[open_] += of_q[goes_on]
    return q, v, landed


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
        q, v = self._rates.normalize(y[None, : self._nq]), y[None, self._nq :]

        def change(at: np.ndarray, q: np.ndarray, v: np.ndarray) -> np.ndarray:
            return np.array([self._changes(t, np.concatenate([q[0], v[0]]))])

        q, v, closed = land(change, q, v)
        return np.concatenate([q[0], v[0]]) if closed[0] else None

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
