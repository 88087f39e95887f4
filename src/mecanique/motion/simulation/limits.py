"""End a motion at a coordinate's limit, and report that it is complete."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import final

import numpy as np

from mecanique.errors import IntegrationError
from mecanique.model.mechanism import Mechanism
from mecanique.motion.record.events import Event
from mecanique.motion.record.motion import Motion

__all__ = ["limit_events", "refuse_limit", "report_end"]

MARGIN = 1e-3
"""A coordinate this near to its limit has reached it, relative to the limits' distance or 1.

A motion may touch the limit and turn back, as the abscissa of a point on a circle does.
"""


@final
@dataclass(frozen=True)
class _Distance:
    """How far a coordinate is from coming too near to a limit, positive inside.

    Args:
        index: of the coordinate.
        bound: the limit.
        side: +1 for a lower limit, −1 for an upper one.
        margin: how near is too near.
    """

    index: int
    bound: float
    side: float
    margin: float

    def __call__(self, t: float, q: np.ndarray, v: np.ndarray) -> float:
        return self.side * (float(q[self.index]) - self.bound) - self.margin


def limit_events(mechanism: Mechanism, start: np.ndarray) -> tuple[Event, ...]:
    """Return the events at which coordinates reach their limits.

    Args:
        mechanism: what moves.
        start: shape (nq,), positions at the start; a motion that starts nearer to a limit may come
            half as near.
    """
    ends = []
    for name, (lower, upper) in mechanism.limits.items():
        at = mechanism.coordinates.index(name)
        margin = MARGIN * (upper - lower if np.isfinite([lower, upper]).all() else 1.0)
        for bound, side in ((lower, 1.0), (upper, -1.0)):
            if np.isfinite(bound):
                near = min(margin, abs(float(start[at]) - bound) / 2)
                ends.append(
                    Event(f"end of chart {name}", _Distance(at, bound, side, near), -1, stop=True)
                )
    return tuple(ends)


def refuse_limit(motion: Motion) -> None:
    """Raise if a motion stopped because a coordinate reached its limit.

    Raises:
        IntegrationError: with the motion until there.
    """
    mechanism = motion.mechanism
    last = motion.events[-1] if motion.events else None
    for name in mechanism.limits:
        if last is not None and last.name == f"end of chart {name}":
            value = float(last.q[mechanism.coordinates.index(name)])
            message = mechanism.explain_limit(
                name, f", but comes to {value:.6g} at t = {last.t:.6g} s"
            )
            raise IntegrationError(
                f"{message}; the motion until then is in the error's .motion",
                time=last.t,
                state=np.concatenate([last.q, last.v]),
                motion=motion,
            )


def report_end(progress: Callable[[float], object] | None, motion: Motion) -> None:
    """Report that a motion is complete; what `progress` raises then does not lose it.

    Raises:
        IntegrationError: with the motion, if `progress` raises an exception.
    """
    if progress is None:
        return
    try:
        progress(1.0)
    except Exception as error:
        t = float(motion.t[-1])
        message = (
            f"progress raised {error!r} at the end, t = {t:.6g} s; "
            "the whole motion is in the error's .motion"
        )
        raise IntegrationError(message, time=t, motion=motion) from error
