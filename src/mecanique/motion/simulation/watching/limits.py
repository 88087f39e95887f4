"""End a motion at a coordinate's limit, and report that it is complete."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import cast, final

import numpy as np

from mecanique.errors import InputError, IntegrationError
from mecanique.model.joint_base import Single
from mecanique.model.mechanism import Mechanism
from mecanique.motion.record.events import Event
from mecanique.motion.record.trajectory import Trajectory

MARGIN = 1e-3
"""A coordinate this near to its limit has reached it, relative to the limits' distance or 1.

A motion may touch the limit and turn back, as the abscissa of a point on a circle does.
"""


@final
@dataclass(frozen=True)
class _Distance:
    """Distance of a coordinate from where it is too near a limit, positive inside."""

    index: int
    bound: float
    side: float  # +1 for a lower limit, −1 for an upper one
    margin: float  # how near is too near

    def __call__(self, t: float, q: np.ndarray, v: np.ndarray) -> float:
        """Return the distance, of many positions at once as well, shape (n, nq)."""
        return cast("float", self.side * (q[..., self.index] - self.bound) - self.margin)


def limit_events(mechanism: Mechanism, start: np.ndarray) -> tuple[Event, ...]:
    """Return the events at which coordinates reach their limits."""
    ends = []
    for name, (lower, upper) in mechanism.limits.items():
        at = mechanism.coordinates.index(name)
        margin = MARGIN * (upper - lower if np.isfinite([lower, upper]).all() else 1.0)
        for bound, side in ((lower, 1.0), (upper, -1.0)):
            if np.isfinite(bound):
                # a motion that starts nearer to a limit may come half as near
                near = min(margin, abs(float(start[at]) - bound) / 2)
                ends.append(
                    Event(f"end of chart {name}", _Distance(at, bound, side, near), -1, stop=True)
                )
    return tuple(ends)


def joint_events(
    mechanism: Mechanism, start: np.ndarray, limits: str | float | None
) -> tuple[Event, ...]:
    """Return the events at which joints reach their limits: stops, or impacts."""
    if limits is None:
        return ()
    from sympy import Symbol

    wrong = isinstance(limits, bool) or (isinstance(limits, str) and limits != "stop")
    if wrong or (not isinstance(limits, str) and not 0 <= limits <= 1):
        raise InputError(
            f'expected "stop" or a coefficient of restitution in 0…1 for limits, got {limits!r}'
        )
    restitution = None if isinstance(limits, str) else float(limits)
    places = {name: at for at, name in enumerate(mechanism.coordinates)}
    events = []
    for joint in mechanism.joints:
        if not isinstance(joint, Single) or joint.limits is None:
            continue
        if joint.coordinate not in places:
            continue
        value = float(start[places[joint.coordinate]])
        for bound, side, words in (
            (float(joint.limits.lower), 1, "lower"),
            (float(joint.limits.upper), -1, "upper"),
        ):
            if not np.isfinite(bound):
                continue
            if side * (value - bound) < 0:
                raise InputError(
                    f"joint {joint.name!r} starts at {value:.6g}, beyond its {words} limit "
                    f"{bound:.6g}; start within the limits, or leave them out"
                )
            when = side * (Symbol(joint.coordinate) - bound)
            events.append(
                Event(
                    f"{words} limit of {joint.name}",
                    when,
                    -1,
                    stop=restitution is None,
                    restitution=restitution,
                )
            )
    return tuple(events)


def refuse_limit(motion: Trajectory) -> None:
    """Raise if a motion stopped because a coordinate reached its limit."""
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


def report_end(progress: Callable[[float], object] | None, motion: Trajectory) -> None:
    """Report that a motion is complete; what `progress` raises then does not lose it."""
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
