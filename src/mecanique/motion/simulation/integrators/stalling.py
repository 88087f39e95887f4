"""Detect stalled and stiff integrations from the steps alone, without a clock."""

from __future__ import annotations

from typing import NamedTuple, final

import numpy as np

from mecanique.generation.dop853 import STIFF_AFTER, STIFF_FORGET, UNSTABLE
from mecanique.motion.record.steps import RightHandSide
from mecanique.motion.simulation.problem import Problem


class _Pace(NamedTuple):
    """How many points must cover which part of the duration, or the motion makes no headway."""

    points: int
    part: float


_TREES = _Pace(10_000, 1e-6)
"""To the end it would take more than 1e10 points.

A stiff transient, however short, takes some hundreds before the steps grow again.
"""

_LOOPS = _Pace(500, 5e-7)
"""Loops next to singular positions take milliseconds for an evaluation; 1e9 points to the end."""


@final
class StallDetector:
    """Watches the points of a run."""

    def __init__(self, problem: Problem, *, implicit: bool = False) -> None:
        self._pace = _TREES if problem.loops is None or implicit else _LOOPS
        self._least = self._pace.part * (problem.end - problem.t0)
        self._next, self._checked = self._pace.points, problem.t0

    def is_stalled(self, points: int, t: float) -> bool:
        """Return whether the last of so many points cover next to nothing."""
        if points < self._next:
            return False
        covered = t - self._checked
        self._next, self._checked = points + self._pace.points, t
        return covered < self._least


@final
class Stability:
    """Whether steps of dop853 are held short by stability rather than accuracy, across restarts.

    The last two evaluations of a step are at its end and estimate the greatest rate of decay there;
    as in Hairer, Nørsett & Wanner, Solving Ordinary Differential Equations I (1993), DOP853,
    fifteen steps at the limit make the equations stiff, unless six shorter ones in a row lie
    between.
    """

    def __init__(self) -> None:
        self._evaluations = [(np.zeros(0), np.zeros(0))] * 2
        self._at_limit = self._below = 0

    def noting(self, rhs: RightHandSide) -> RightHandSide:
        """Return the same equations, whose last two evaluations are kept."""

        def note(t: float, y: np.ndarray) -> np.ndarray:
            rate = rhs(t, y)
            self._evaluations = [self._evaluations[1], (y.copy(), rate.copy())]
            return rate

        return note

    def is_stiff(self, length: float) -> bool:
        """Return whether the equations are stiff, after a step of a length [s]."""
        (y, rate), (last, last_rate) = self._evaluations
        apart = float(np.linalg.norm(last - y)) if len(y) == len(last) else 0.0
        decay = length * float(np.linalg.norm(last_rate - rate)) if apart else 0.0
        if apart and decay > UNSTABLE * apart:
            self._at_limit, self._below = self._at_limit + 1, 0
        else:
            self._below += 1
            if self._below == STIFF_FORGET:
                self._at_limit = 0
        return self._at_limit >= STIFF_AFTER
