"""Joints of a URDF."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, final

from mecanique.model.joint_base import Limits
from mecanique.model.joints import (
    Fixed,
    Floating,
    Helical,
    Joint,
    Planar,
    Prismatic,
    Revolute,
    Spherical,
    Universal,
)
from mecanique.model.placement import Placement
from mecanique.urdf.dialect import DRAKE_JOINT, SCREW, UNBOUNDED
from mecanique.urdf.findings import Report
from mecanique.urdf.markup import Element
from mecanique.urdf.reading.fields import name_of, number, numbers, placement, single

SINGLE = ("revolute", "continuous", "prismatic")
"""Types with one coordinate."""

MOVING = (*SINGLE, "planar", "floating", "ball", "universal")
"""Types that move."""

CUSTOM = ("ball", "universal", "planar")
"""Types that a <drake:joint> may have."""

_CLASSES: Mapping[str, type[Joint]] = {
    **dict.fromkeys(("revolute", "continuous"), Revolute),
    "prismatic": Prismatic,
    "fixed": Fixed,
    "planar": Planar,
    "floating": Floating,
    "ball": Spherical,
    "universal": Universal,
}
_STANDARD = (*SINGLE, "fixed", "planar", "floating")
_X, _Z = (1.0, 0.0, 0.0), (0.0, 0.0, 1.0)


@final
@dataclass(frozen=True)
class Mimic:
    """How a joint follows another: coordinate = multiplier × other + offset."""

    element: Element
    joint: str  # name of the other joint
    multiplier: float
    offset: float  # rad or m


@final
@dataclass(frozen=True)
class JointText:
    """A joint as written."""

    name: str
    element: Element
    kind: str  # its type, e.g. "revolute"
    parent: str
    child: str
    origin: Placement  # where its frame stands in the parent
    axis: tuple[float, float, float]  # its axis as written, or the default
    limits: Limits | None
    damping: float  # N·m·s/rad or N·s/m
    friction: float  # N·m or N
    mimic: Mimic | None
    armature: float = 0.0  # inertia of the drive's rotor seen at the joint [kg·m² or kg]
    screw: bool = False  # whether it is the slide of a screw, one joint with the hinge behind it

    @property
    def where(self) -> str:
        """Its name in reports."""
        return f"joint {self.name!r}"

    @property
    def moving(self) -> bool:
        """Whether it moves."""
        return self.kind in MOVING

    def join_screw(self, slide: JointText) -> Helical | None:
        """Return the screw made of this hinge and the slide before it, or None."""
        mimic, unit = slide.mimic, Placement()
        fits = (
            self.kind in ("revolute", "continuous")
            and slide.kind == "prismatic"
            and self.parent == slide.child
            and (mimic is not None and mimic.joint == self.name and mimic.offset == 0)
            and (self.origin.xyz, self.origin.rpy) == (unit.xyz, unit.rpy)
            and self._unit == slide._unit
            and not (slide.damping or slide.armature)
        )
        if not fits or mimic is None or not mimic.multiplier:
            return None
        return Helical(
            self.name,
            slide.parent,
            self.child,
            origin=slide.origin,
            axis=self._unit,
            limits=self.limits,
            armature=self.armature,
            pitch=mimic.multiplier,
        )

    def joint(self) -> Joint:
        """Return the joint it describes, with its default coordinate names."""
        stated: dict[str, Any] = {"origin": self.origin}
        if self.kind in (*SINGLE, "planar"):
            stated["axis"] = self._unit
        if self.kind in SINGLE:
            stated |= {"limits": self.limits, "armature": self.armature}
        return _CLASSES[self.kind](self.name, self.parent, self.child, **stated)

    @property
    def _unit(self) -> tuple[float, float, float]:
        """The axis; unchanged if its length is one to rounding, so that round trips are exact."""
        length = math.hypot(*self.axis)
        x, y, z = self.axis
        return self.axis if abs(length - 1) < 1e-15 else (x / length, y / length, z / length)


def read_joints(robot: Element, report: Report) -> list[JointText]:
    """Return the joints of a robot; what cannot be read is reported."""
    joints: dict[str, JointText] = {}
    for element in robot.children:
        if element.tag not in ("joint", DRAKE_JOINT):
            continue
        joint = _joint(element, report)
        if joint is None:
            continue
        if joint.name in joints:
            line = joints[joint.name].element.line
            report.add("M106", element, joint.where, f"it is there already at line {line}")
            continue
        joints[joint.name] = joint
    return list(joints.values())


def _joint(element: Element, report: Report) -> JointText | None:
    name = name_of(element, report)
    where = f"joint {name!r}" if name else "a joint"
    kind = _kind(element, report, where)
    parent, child = (_end(element, role, report, where) for role in ("parent", "child"))
    origin = placement(element, report, where)
    axis = _axis(element, kind, report, where)
    limits = _limits(element, kind, report, where)
    damping, friction = _dynamics(element, kind, report, where)
    mimic = _mimic(element, report, where)
    if name is None or parent is None or child is None:
        return None
    # the report has what could not be read; stand-ins let the tree be checked, too
    kind, axis = kind or "continuous", axis or _Z
    return JointText(
        name=name,
        element=element,
        kind=kind,
        parent=parent,
        child=child,
        origin=origin,
        axis=axis,
        limits=limits,
        damping=damping,
        friction=friction,
        mimic=mimic,
        screw=any(child.tag == SCREW for child in element.children),
    )


def _kind(element: Element, report: Report, where: str) -> str | None:
    kind = element.attributes.get("type")
    custom = element.tag == DRAKE_JOINT
    if kind is None:
        report.add("M103", element, where, f"<{element.tag}> has no type=…")
        return None
    if kind in (CUSTOM if custom else _STANDARD):
        return kind
    if custom and kind in _STANDARD:
        report.add(
            "M314", element, where, f"the type {kind!r} belongs into <joint>; Drake refuses it here"
        )
        return kind
    if custom and kind in ("curvilinear", "screw"):
        report.add("M604", element, where, f"<drake:joint> of type {kind!r} is not modeled")
        return None
    remedy = 'Write <drake:joint type="ball">.' if kind in ("ball", "spherical") else None
    if kind == "universal":
        remedy = 'Write <drake:joint type="universal">.'
    known = ", ".join(CUSTOM if custom else _STANDARD)
    report.add("M301", element, where, f"expected a type among {known}, got {kind[:60]!r}", remedy)
    return None


def _end(element: Element, role: str, report: Report, where: str) -> str | None:
    end = single(element, role, report, where)
    if end is None:
        report.add("M103", element, where, f"<{element.tag}> has no <{role}>")
        return None
    return name_of(end, report, "link", where)


def _axis(
    element: Element, kind: str | None, report: Report, where: str
) -> tuple[float, float, float] | None:
    used = kind is None or kind in (*SINGLE, "planar")
    report = report if used else report.aside
    axis = single(element, "axis", report, where)
    if axis is None:
        if used and element.tag == "joint":
            message = "it has no <axis>, which means 1 0 0"
            report.add(
                "M304",
                element,
                where,
                message + (" (Pinocchio takes z)" if kind == "planar" else ""),
            )
        return _Z if element.tag == DRAKE_JOINT else _X
    values = numbers(axis, "xyz", 3, report, where)
    if not used:
        return _X
    if values is None:
        return None
    length = math.hypot(*values)
    if length < 1e-8:
        report.add("M302", axis, where, f"its axis {axis.attributes['xyz']!r} has no length")
        return None
    if abs(length - 1) > 1e-3:
        report.add(
            "M303", axis, where, f"its axis {axis.attributes['xyz']!r} has the length {length:g}"
        )
    return values[0], values[1], values[2]


def _limits(element: Element, kind: str | None, report: Report, where: str) -> Limits | None:
    limit = single(element, "limit", report.aside, where)
    bounded = kind in ("revolute", "prismatic")
    if limit is None:
        if bounded:
            report.add(
                "M307", element, where, f"a {kind} joint has no <limit>; it is read without bounds"
            )
        return None
    names = ("lower", "upper", "effort", "velocity")
    lower, upper, effort, velocity = (
        number(limit, name, report, where, default=_left_out(name), most=math.inf) for name in names
    )
    if lower is None or upper is None or effort is None or velocity is None:
        return None
    if bounded:
        missing = [name for name in ("effort", "velocity") if name not in limit.attributes]
        if missing:
            report.add(
                "M307",
                limit,
                where,
                f"<limit> has no {' and no '.join(missing)}; it is read as unbounded",
            )
        if lower > upper:
            message = f"its lower limit {lower:g} is above its upper limit {upper:g}"
            report.aside.add("M306", limit, where, message)
            lower, upper = -math.inf, math.inf
        if lower == upper == 0 and not {"lower", "upper"} <= set(limit.attributes):
            report.add(
                "M308", limit, where, "<limit> without lower and upper lets it move from 0 to 0"
            )
        if any("inf" in limit.attributes.get(name, "").lower() for name in names):
            report.add("M307", limit, where, "Pinocchio and ROS cannot read an infinite limit")
    else:
        lower, upper = -math.inf, math.inf
    for name, value in (("effort", effort), ("velocity", velocity)):
        if value < 0:
            message = f"its limit of {name} is negative ({value:g})"
            report.aside.add("M306", limit, where, message)
    effort, velocity = (value if value >= 0 else math.inf for value in (effort, velocity))
    bounds = lower, upper, effort, velocity
    return Limits(
        *(math.copysign(math.inf, bound) if abs(bound) >= UNBOUNDED else bound for bound in bounds)
    )


def _left_out(name: str) -> float:
    return 0.0 if name in ("lower", "upper") else math.inf


def _dynamics(
    element: Element, kind: str | None, report: Report, where: str
) -> tuple[float, float]:
    dynamics = single(element, "dynamics", report, where)
    if dynamics is None:
        return 0.0, 0.0
    text = dynamics.attributes.get("damping", "0")
    count = 3 if kind == "planar" and len(text.split()) == 3 else 1
    dampings = numbers(dynamics, "damping", count, report, where, default=(0.0,)) or (0.0,)
    friction = number(dynamics, "friction", report, where, default=0.0) or 0.0
    if min(dampings) < 0:
        report.add("M311", dynamics, where, f"its damping is {min(dampings):g}")
    elif any(dampings) and kind in MOVING and kind not in SINGLE:
        report.add("M312", dynamics, where, f"the damping of a {kind} joint is not modeled")
    return dampings[0] if kind in SINGLE else 0.0, friction


def _mimic(element: Element, report: Report, where: str) -> Mimic | None:
    mimic = single(element, "mimic", report, where)
    if mimic is None:
        return None
    name = name_of(mimic, report, "joint", where)
    multiplier = number(mimic, "multiplier", report, where, default=1.0)
    offset = number(mimic, "offset", report, where, default=0.0)
    if name is None or multiplier is None or offset is None:
        return None
    return Mimic(mimic, name, multiplier, offset)


@final
@dataclass(frozen=True)
class Follower:
    """How a joint follows one that moves freely: coordinate = multiplier × leader + offset."""

    leader: str  # name of the joint that moves freely
    multiplier: float
    offset: float  # rad or m


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
