"""The steps an integrator has taken so far."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import TypeAlias, final

import numpy as np

from mecanique.motion.dense import Curve
from mecanique.motion.rates import Rates

__all__ = ["RightHandSide", "Steps"]

RightHandSide: TypeAlias = Callable[[float, np.ndarray], np.ndarray]
"""ẏ = f(t, y) for y = (q, v)."""


@final
@dataclass
class Steps:
    """Steps as they come, and where the motion breaks; a recorder, filled while integrating.

    Args:
        t: times [s].
        y: states (q, v).
        dy: their rates.
        breaks: index of the first step of each smooth stretch.
    """

    t: list[float] = field(default_factory=list)
    y: list[np.ndarray] = field(default_factory=list)
    dy: list[np.ndarray] = field(default_factory=list)
    breaks: list[int] = field(default_factory=lambda: [0])

    def add(self, t: float, y: np.ndarray, dy: np.ndarray) -> None:
        """Note a step.

        Args:
            t: its time [s].
            y: the state there; copied.
            dy: its rate.
        """
        self.t.append(t)
        self.y.append(y.copy())
        self.dy.append(dy)

    def replace_last(self, t: float, y: np.ndarray, dy: np.ndarray) -> None:
        """Put another step in the last one's place."""
        self.t[-1], self.y[-1], self.dy[-1] = t, y, dy

    def break_here(self, y: np.ndarray, dy: np.ndarray) -> None:
        """Start a new smooth stretch at the last step's time, from a state of its own."""
        self.breaks.append(len(self.t))
        self.add(self.t[-1], y, dy)

    def curve(self, nq: int, rates: Rates, smooth: bool) -> Curve:
        """Return the motion through the steps.

        Args:
            nq: number of positions in a state.
            rates: the maps between v and q̇.
            smooth: whether the rates are as accurate as the states.
        """
        y, dy = np.array(self.y), np.array(self.dy)
        q = rates.normalized(y[:, :nq])
        return Curve(np.array(self.t), q, y[:, nq:], dy[:, nq:], np.array(self.breaks), rates, smooth)
