"""Many motions at once by the eighth-order method of Dormand & Prince, all with one step.

The step is that of the run which needs the shortest; the error of every run is below the tolerance
(E. Hairer, S. P. Nørsett, G. Wanner, Solving Ordinary Differential Equations I, 1993, sect. II.5
and II.10).
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import final

import numpy as np

from mecanique.generation.dop853 import (
    BEFORE,
    BRIEF,
    DAMPING,
    EXPONENT,
    FIRST,
    GROWTH,
    NEARLY,
    SAFETY,
    SHORTEST,
    SHRINKAGE,
    UNKNOWN,
    tableau,
)
from mecanique.motion.compile.python import Batched

_PIECE = 10_000
"""Numbers added up at once: beyond some ten thousand, BLAS starts threads that compete."""


@final
@dataclass
class Block:
    """Runs that are integrated together."""

    # gives the equations of some of the runs, by their indices
    make: Callable[[np.ndarray], Batched]
    start: np.ndarray  # shape (size, n), states at the first time
    # gives states with unit quaternions, or None if there are none
    normalize: Callable[[np.ndarray], np.ndarray] | None
    rtol: float
    atol: float
    max_step: float  # longest step [s]
    max_steps: int


def integrate(
    block: Block, times: Sequence[float], stops: Sequence[float] = ()
) -> tuple[np.ndarray, np.ndarray]:
    """Return states (size, times, n), NaN after a failure, and steps (n,), negative if failed."""
    size, count = block.start.shape
    states = np.full((size, len(times), count), np.nan)
    states[:, 0] = block.start
    steps = np.zeros(count, dtype=int)
    alive = np.arange(count)
    marks = np.union1d(times[1:], [s for s in stops if times[0] < s < times[-1]])
    runner = _Runner(block, alive, block.start, float(times[0]))
    place = 1
    for mark in marks.tolist():
        while runner.t < mark:
            failed = runner.step(mark)
            if failed.any():
                steps[alive[failed]] = -runner.taken - 1
                alive = alive[~failed]
                if not len(alive):
                    return states, steps
                runner = _Runner(block, alive, runner.y[:, ~failed], runner.t, runner.taken)
        if mark == times[place]:
            states[:, place, alive] = runner.y
            place += 1
        else:
            runner.restart()
    steps[alive] = runner.taken
    return states, steps


@final
class _Runner:
    """Steps of the runs that have not failed."""

    def __init__(
        self, block: Block, alive: np.ndarray, y: np.ndarray, t: float, taken: int = 0
    ) -> None:
        coefficients = tableau()
        self._A, self._B, self._C = coefficients.A, coefficients.B, coefficients.C
        self._E = coefficients.errors
        self._block = block
        self._rhs = block.make(alive)
        self.t = t
        self.y = np.array(y, order="C")
        self.taken = taken
        self.h = 0.0
        self._before = BEFORE
        self._grows = True
        self._K = np.empty((len(self._B) + 1, *y.shape))
        self._flat = self._K.reshape(len(self._K), -1)
        self._trial = np.empty_like(self.y)
        self._errors = np.empty((2, *y.shape))
        with np.errstate(all="ignore"):
            self.restart()

    def restart(self) -> None:
        """Compute the rates again after a kink."""
        self._rhs(self.t, self.y, self._K[0])
        if not self.h:
            self.h = self._first()

    def step(self, mark: float) -> np.ndarray:
        """Take one step that does not pass a mark; return which runs failed, shape (n,)."""
        block, K, trial = self._block, self._K, self._trial
        h = min(self.h, block.max_step)
        left = mark - self.t
        last = left <= h * NEARLY
        if last:
            h = left
        elif left < 2 * h:
            h = left / 2
        line = trial.reshape(-1)
        with np.errstate(all="ignore"):
            for s in range(1, len(self._B)):
                self._combine(h * self._A[s, :s], line)
                trial += self.y
                self._rhs(self.t + self._C[s] * h, trial, K[s])
            self._combine(h * self._B, line)
            trial += self.y
            self._rhs(self.t + h, trial, K[-1])
            error = self._error(h)
        worst = float(np.max(error))
        none: np.ndarray = np.zeros(len(error), dtype=bool)
        if worst <= 1:
            self.t = mark if last else self.t + h
            self.y, self._trial = trial, self.y
            K[0] = K[-1]
            if block.normalize is not None:
                self.y = block.normalize(self.y)
            self.taken += 1
            most = GROWTH if self._grows else 1.0
            factor = min(most, SAFETY * self._before**DAMPING / worst**EXPONENT) if worst else most
            self._before, self._grows = max(worst, BEFORE), True
            proposed = h * max(SHRINKAGE, factor)
            self.h = max(proposed, self.h) if last else proposed
            if self.taken % block.max_steps == 0 and self.t < mark:
                # those that need steps as short as these are given up, and the others go on
                return np.asarray(error > 1e-3 * worst)
            return none
        factor = max(SHRINKAGE, SAFETY / worst**EXPONENT) if np.isfinite(worst) else SHRINKAGE
        self.h, self._grows = h * factor, False
        if self.h < SHORTEST * max(1.0, abs(self.t)):
            return np.asarray(~(error <= 1))
        return none

    def _combine(self, weights: np.ndarray, out: np.ndarray) -> None:
        """Add up the first rates with weights, in pieces too small for BLAS to start threads."""
        count = len(weights)
        for first in range(0, len(out), _PIECE):
            some = slice(first, first + _PIECE)
            np.dot(weights, self._flat[:count, some], out=out[some])

    def _error(self, h: float) -> np.ndarray:
        """Error of each run in tolerances, shape (n,)."""
        trial, errors = self._trial, self._errors
        scale = np.maximum(np.abs(self.y), np.abs(trial))
        scale *= self._block.rtol
        scale += self._block.atol
        for weights, line in zip(self._E, errors.reshape(2, -1), strict=True):
            self._combine(weights, line)
        errors /= scale
        errors *= errors
        fifth, third = errors.sum(axis=1)
        third *= 0.01
        third += fifth
        third *= len(trial)
        whole = np.sqrt(third, out=third)
        error: np.ndarray = np.divide(fifth, whole, out=np.zeros_like(fifth), where=whole != 0)
        error *= h
        # what is not finite in the state hides in the scale
        error[~np.isfinite(trial.sum(axis=0) + error)] = np.inf
        return error

    def _first(self) -> float:
        """A first step from the sizes of the state and its rate (Hairer et al., sect. II.4)."""
        scale = self._block.atol + self._block.rtol * np.abs(self.y)
        with np.errstate(all="ignore"):
            size = np.sqrt(np.mean((self.y / scale) ** 2, axis=0))
            rate = np.sqrt(np.mean((self._K[0] / scale) ** 2, axis=0))
            h = np.where(np.minimum(size, rate) ** 2 > UNKNOWN, FIRST * size / rate, BRIEF)
        h = h[np.isfinite(h)]
        return float(max(h.min(initial=1e-3), BRIEF))
