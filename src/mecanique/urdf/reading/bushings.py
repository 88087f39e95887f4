"""Bushings that are a spring and damper in one joint.

A bushing resists the roll, pitch, yaw and displacement of a frame C in a frame A (Drake
documentation, `LinearBushingRollPitchYaw`). If the joint between them lets only one of these six
change, it is a spring and a damper in that joint.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import final

import numpy as np

from mecanique.model.placement import Placement, pose_of
from mecanique.urdf.reading.joints import JointText

_CLOSE = 1e-9


@final
class BushingFaultError(Exception):
    """The bushing is not a spring in a joint; the reader turns this into a finding."""


@final
@dataclass(frozen=True)
class Frame:
    """A frame on a link.

    Args:
        link: name of the link.
        place: where it is in the link.
    """

    link: str
    place: Placement = field(default_factory=Placement)


@final
@dataclass(frozen=True)
class InJoint:
    """A spring and damper in a joint.

    Args:
        joint: name of the joint.
        stiffness: [N·m/rad or N/m].
        damping: [N·m·s/rad or N·s/m].
        reference: the joint coordinate without force [rad or m].
        turns: whether the joint may turn beyond the range where the bushing's angle is continuous.
    """

    joint: str
    stiffness: float
    damping: float
    reference: float
    turns: bool


def in_joint(
    a: Frame, c: Frame, between: list[JointText], values: Mapping[str, tuple[float, ...]]
) -> InJoint:
    """Return the spring and damper in a joint that are equivalent to a bushing.

    Args:
        a: one frame.
        c: the other.
        between: the joints between their links.
        values: torque and force stiffness and damping, each shape (3,), along the frame's axes.

    Raises:
        BushingFaultError: if there are none.
    """
    if len(between) != 1 or between[0].kind not in ("revolute", "continuous", "prismatic"):
        raise BushingFaultError(
            f"no revolute or prismatic joint joins its links {a.link!r} and {c.link!r}"
        )
    joint = between[0]
    on_parent, on_child = (a, c) if a.link == joint.parent else (c, a)
    inverse = np.linalg.inv(pose_of(joint.origin))
    before = inverse @ pose_of(on_parent.place)
    after = pose_of(on_child.place)
    axis = np.asarray(joint.axis) / math.hypot(*joint.axis)
    along = before[:3, :3].T @ axis
    k = int(np.argmax(abs(along)))
    if abs(abs(along[k]) - 1) > _CLOSE:
        raise BushingFaultError(f"no axis of its frame lies along the axis of {joint.where}")
    relative = np.linalg.inv(before) @ after
    sign = 1.0 if along[k] > 0 else -1.0
    others = [i for i in range(3) if i != k]
    if joint.kind == "prismatic":
        if (
            abs(relative[:3, :3] - np.eye(3)).max() > _CLOSE
            or abs(relative[others, 3]).max() > _CLOSE
        ):
            raise BushingFaultError(
                f"its frames do not lie on one line along the axis of {joint.where}"
            )
        start, what, range_ = float(relative[k, 3]), "force", math.inf
    else:
        lever = after[:3, 3] - axis * (axis @ after[:3, 3])
        if abs(relative[:3, 3]).max() > _CLOSE or abs(lever).max() > _CLOSE:
            raise BushingFaultError(f"its frames do not coincide on the axis of {joint.where}")
        if abs(relative[k, k] - 1) > _CLOSE:
            raise BushingFaultError(
                f"its frames do not differ by a turn about the axis of {joint.where}"
            )
        i, j = others if k != 1 else (2, 0)
        start, what = math.atan2(relative[j, i], relative[i, i]), "torque"
        range_ = math.pi / 2 if k == 1 else math.pi
    reference = -sign * start + 0.0
    bounds = (
        (-math.inf, math.inf) if joint.limits is None else (joint.limits.lower, joint.limits.upper)
    )
    turns = max(abs(bound - reference) for bound in bounds) > range_
    return InJoint(
        joint.name, values[f"{what}_stiffness"][k], values[f"{what}_damping"][k], reference, turns
    )
