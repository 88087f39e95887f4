"""Joints that follow others: resolve <mimic>, in any order and in chains, down to free joints."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import final

from mecanique.urdf.findings import Report
from mecanique.urdf.reading.joints import SINGLE, JointText


@final
@dataclass(frozen=True)
class Follower:
    """How a joint follows one that moves freely: coordinate = multiplier × leader + offset.

    Args:
        leader: name of the joint that moves freely.
        multiplier: factor.
        offset: [rad or m].
    """

    leader: str
    multiplier: float
    offset: float


def followers(joints: list[JointText], report: Report) -> dict[str, Follower]:
    """Return how each mimicking joint follows a free one, by its name; report what cannot."""
    by_name = {joint.name: joint for joint in joints}
    mimics = {
        joint.name: joint
        for joint in joints
        if joint.mimic is not None and _fit(joint, by_name, report)
    }
    solved: dict[str, Follower] = {}
    broken: set[str] = set()
    for name in mimics:
        chain: list[str] = []
        following: set[str] = set()
        while (
            name in mimics and name not in solved and name not in broken and name not in following
        ):
            chain.append(name)
            following.add(name)
            name = _leader(mimics[name])
        if name in following:
            joint = mimics[name]
            members = chain[chain.index(name) :]
            shown = " → ".join([*members[:6], *(["…"] if len(members) > 6 else []), name])
            report.add(
                "M402",
                joint.mimic.element if joint.mimic else joint.element,
                joint.where,
                f"cycle: {shown}",
            )
        if name in following or name in broken:
            broken.update(chain)
            continue
        for follower in reversed(chain):
            solved[follower] = _compose(mimics[follower], solved, report)
    return solved


def _fit(joint: JointText, joints: Mapping[str, JointText], report: Report) -> bool:
    mimic = joint.mimic
    if mimic is None:
        return False
    leader = joints.get(mimic.joint)
    if joint.kind == "fixed":
        report.add("M407", mimic.element, joint.where, f"it is fixed and mimics {mimic.joint!r}")
    elif leader is None:
        report.add(
            "M401", mimic.element, joint.where, f"it mimics {mimic.joint!r}, which is no joint"
        )
    elif joint.kind not in SINGLE:
        report.add("M403", mimic.element, joint.where, f"a {joint.kind} joint cannot mimic another")
    elif leader.kind not in SINGLE:
        report.add(
            "M403", mimic.element, joint.where, f"it mimics {leader.name!r}, a {leader.kind} joint"
        )
    else:
        return True
    return False


def _leader(joint: JointText) -> str:
    return joint.mimic.joint if joint.mimic else joint.name


def _compose(joint: JointText, solved: Mapping[str, Follower], report: Report) -> Follower:
    """Substitute the law of the joint that is followed: m (M x + O) + o."""
    mimic = joint.mimic
    if mimic is None:
        return Follower(joint.name, 1.0, 0.0)
    outer = solved.get(mimic.joint, Follower(mimic.joint, 1.0, 0.0))
    multiplier = mimic.multiplier * outer.multiplier
    offset = mimic.multiplier * outer.offset + mimic.offset
    if not (math.isfinite(multiplier) and math.isfinite(offset)):
        report.add(
            "M104",
            mimic.element,
            joint.where,
            "its multipliers and offsets grow beyond all numbers",
        )
        return outer
    return Follower(outer.leader, multiplier, offset)
