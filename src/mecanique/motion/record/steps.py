"""The steps an integrator has taken so far."""

from __future__ import annotations

from bisect import bisect_right
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import TypeAlias, final

import numpy as np

from mecanique.motion.record.curve import Curve
from mecanique.motion.record.rates import Rates

RightHandSide: TypeAlias = Callable[[float, np.ndarray], np.ndarray]
"""ẏ = f(t, y) for y = (q, v)."""


@final
@dataclass
class Steps:
    """Steps as they come, and where the motion breaks; a recorder, filled while integrating."""

    t: list[float] = field(default_factory=list)  # times [s]
    y: list[np.ndarray] = field(default_factory=list)
    dy: list[np.ndarray] = field(default_factory=list)
    # index of the first step of each smooth stretch
    breaks: list[int] = field(default_factory=lambda: [0])
    spread: bool = False  # whether each step is a stretch of several points
    evaluations: int = 0

    @property
    def first(self) -> int:
        """Index of the point at which the last step starts."""
        return self.breaks[-1] if self.spread else len(self.t) - 2

    @property
    def taken(self) -> int:
        """Number of steps taken."""
        return len(self.breaks) if self.spread else len(self.t) - len(self.breaks)

    def add(self, t: float, y: np.ndarray, dy: np.ndarray) -> None:
        """Note a step."""
        self.t.append(t)
        self.y.append(y.copy())
        self.dy.append(dy)

    def extend(self, t: np.ndarray, y: np.ndarray, dy: np.ndarray) -> None:
        """Note steps: times (n,) [s], states and their rates (n, nq + nv)."""
        self.t += t.tolist()
        self.y += list(y)
        self.dy += list(dy)

    def add_spread(self, t: np.ndarray, y: np.ndarray, dy: np.ndarray) -> None:
        """Note a step by several points (n,), its start left out, as a stretch of its own."""
        if self.breaks[-1] < len(self.t) - 1:
            self.break_here(self.y[-1], self.dy[-1])
        self.extend(t, y, dy)

    def end_at(self, t: float, y: np.ndarray, rhs: RightHandSide) -> None:
        """Let the last step end earlier, at a time within it [s]."""
        if self.spread:
            self._squeeze(t, rhs)
        self.t[-1], self.y[-1], self.dy[-1] = t, y, rhs(t, y)

    def _squeeze(self, end: float, rhs: RightHandSide) -> None:
        """Move the last step's points in proportion to its new end."""
        from scipy.interpolate import BarycentricInterpolator

        first = self.breaks[-1]
        times = np.array(self.t[first:])
        if len(times) < 2:
            return
        moved = times[0] + (times - times[0]) * ((end - times[0]) / (times[-1] - times[0]))
        states = np.asarray(BarycentricInterpolator(times, np.array(self.y[first:]))(moved))
        for k, (t, y) in enumerate(zip(moved.tolist(), states, strict=True)):
            if k:
                self.t[first + k], self.y[first + k], self.dy[first + k] = t, y, rhs(t, y)

    def break_here(self, y: np.ndarray, dy: np.ndarray) -> None:
        """Start a new smooth stretch at the last step's time, from a state of its own."""
        self.breaks.append(len(self.t))
        self.add(self.t[-1], y, dy)

    def cut(self, t: float) -> None:
        """Forget the steps after a time."""
        keep = bisect_right(self.t, t)
        del self.t[keep:], self.y[keep:], self.dy[keep:]
        self.breaks = [first for first in self.breaks if first < keep]

    def curve(self, nq: int, rates: Rates, smooth: bool, close: bool = True) -> Curve:
        """Return the motion through the steps; `smooth` if rates are as accurate as states."""
        y, dy = np.array(self.y), np.array(self.dy)
        q = rates.normalize(y[:, :nq])
        return Curve(
            t=np.array(self.t),
            q=q,
            v=y[:, nq:],
            a=dy[:, nq:],
            breaks=np.array(self.breaks),
            rates=rates,
            smooth=smooth,
            close=close,
        )
