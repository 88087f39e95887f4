"""Find joint limits that a motion exceeds; nothing stops a joint there."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, final

import numpy as np

from mecanique.arrays import Array
from mecanique.model.joint_base import Single
from mecanique.motion.record.extremes import find_maxima

if TYPE_CHECKING:
    from mecanique.motion.record.trajectory import Trajectory


_ROUNDING = 1e-9
"""A limit that is passed by less [rad or m] is only touched."""


@final
@dataclass(frozen=True)
class Exceeded:
    """A joint that goes beyond its limits.

    Args:
        joint: its name.
        coordinate: its coordinate.
        lower: lower limit [rad or m].
        upper: upper limit.
        value: the coordinate where it is farthest beyond.
        time: when that is [s].
        since: when it is beyond for the first time [s].
    """

    joint: str
    coordinate: str
    lower: float
    upper: float
    value: float
    time: float
    since: float

    def __str__(self) -> str:
        return (
            f"joint {self.joint!r} passes its limits {self.lower:.4g} … {self.upper:.4g} from "
            f"t = {self.since:.4g} s, farthest {self.value:.4g} at t = {self.time:.4g} s"
        )


def find_exceeded(motion: Trajectory) -> tuple[Exceeded, ...]:
    """Return the joints that go beyond their limits, in order of time."""
    exceeded = []
    coordinates, curve = motion.mechanism.coordinates.names, motion.curve
    for joint in motion.mechanism.joints:
        if not isinstance(joint, Single) or joint.limits is None:
            continue
        if joint.coordinate not in coordinates:
            continue
        lower, upper = float(joint.limits.lower), float(joint.limits.upper)
        at = coordinates.index(joint.coordinate)

        def beyond(t: float, k: int = at, lower: float = lower, upper: float = upper) -> float:
            x = float(curve(t).q[k])
            return max(lower - x, x - upper) - _ROUNDING

        def both(t: Array, q: Array, v: Array, k: int = at) -> Array:
            return np.column_stack([q[:, k], -q[:, k]])

        most = find_maxima(curve, both)
        highest, lowest = most.values[0], -most.values[1]
        from scipy.optimize import brentq

        worst = 0 if highest - upper >= lower - lowest else 1
        time = float(most.times[worst])
        if beyond(time) > 0:
            earlier = curve.t[curve.t < time]
            outside = [t for t in earlier.tolist() if beyond(t) > 0]
            end = outside[0] if outside else time
            inside = curve.t[curve.t < end]
            since = end
            if len(inside):
                since = float(brentq(beyond, inside[-1], end, xtol=1e-13))
            exceeded.append(
                Exceeded(
                    joint=joint.name,
                    coordinate=joint.coordinate,
                    lower=lower,
                    upper=upper,
                    value=float((highest, lowest)[worst]),
                    time=time,
                    since=since,
                )
            )
    return tuple(sorted(exceeded, key=lambda passed: passed.since))
