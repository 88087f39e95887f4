"""Shown time against wall time: an absolute clock, so that small delays do not add up."""

from __future__ import annotations

import time
from typing import TYPE_CHECKING, final

if TYPE_CHECKING:
    from mecanique.viewing.live.commands import Controls


FRAME = 1 / 60
"""The time between two pictures [s]."""


@final
class PacedClock:
    """The time shown now: it follows the wall clock at the chosen speed, and stops while paused.

    Args:
        controls: where pause and speed are read.
        start: the first time shown [s].
    """

    def __init__(self, controls: Controls, start: float) -> None:
        self._controls = controls
        self._shown = start
        self._wall = time.monotonic()
        self._rate = controls.rate
        self._due = self._wall

    def now(self) -> float:
        """Return the time to be shown now [s]."""
        rate = self._controls.rate
        if rate != self._rate:
            wall = time.monotonic()
            self._shown += (wall - self._wall) * self._rate
            self._wall, self._rate = wall, rate
        return self._shown + (time.monotonic() - self._wall) * self._rate

    def forgive(self, t: float, most: float = 0.1) -> None:
        """Set the clock back to a source that has fallen behind.

        Args:
            t: the time the source has reached [s].
            most: tolerated delay [s of wall time].
        """
        if self.now() - t > most * max(self._rate, 1e-9):
            self._shown, self._wall = t, time.monotonic()

    def until(self, t: float) -> float:
        """Return how long until a time is shown [s of wall time]; a frame's time while paused."""
        return max(0.0, (t - self.now()) / self._rate) if self._rate > 0 else FRAME

    def rest(self, period: float) -> None:
        """Sleep until the next picture is due, on a grid that does not drift.

        Args:
            period: from picture to picture [s].
        """
        wall = time.monotonic()
        self._due = max(self._due + period, wall)
        self._controls.rest(self._due - wall)
