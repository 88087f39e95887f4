"""Find joint limits that a motion exceeds; nothing stops a joint there."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, final

import numpy as np

from mecanique.model.joint_base import Single

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
        since: when a sample is beyond for the first time [s].
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
    """Return the joints that go beyond their limits at a sample, in order of time.

    Args:
        motion: any motion.
    """
    found = []
    coordinates = set(motion.mechanism.coordinates)
    for joint in motion.mechanism.joints:
        if not isinstance(joint, Single) or joint.limits is None:
            continue
        if joint.coordinate not in coordinates:
            continue
        lower, upper = float(joint.limits.lower), float(joint.limits.upper)
        values = np.asarray(motion[joint.coordinate])
        beyond = np.maximum(lower - values, values - upper)
        past = np.flatnonzero(beyond > _ROUNDING)
        if len(past):
            worst, first = int(np.argmax(beyond)), int(past[0])
            value, time, since = (
                float(values[worst]),
                float(motion.t[worst]),
                float(motion.t[first]),
            )
            found.append(
                Exceeded(
                    joint=joint.name,
                    coordinate=joint.coordinate,
                    lower=lower,
                    upper=upper,
                    value=value,
                    time=time,
                    since=since,
                )
            )
    return tuple(sorted(found, key=lambda each: each.since))
