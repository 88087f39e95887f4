"""Joints of a URDF."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, replace
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
from mecanique.urdf.reading.fields import Passage

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
    where: str  # the joint that follows, as reports call it
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
        joint = _joint(Passage(element, report))
        if joint is None:
            continue
        if joint.name in joints:
            line = joints[joint.name].element.line
            report.add("M106", joint, f"it is there already at line {line}")
            continue
        joints[joint.name] = joint
    return list(joints.values())


def _joint(text: Passage) -> JointText | None:
    name = text.name()
    text = replace(text, where=f"joint {name!r}" if name else "a joint")
    kind = _kind(text)
    parent, child = (_end(text, role) for role in ("parent", "child"))
    origin = text.origin()
    axis = _axis(text, kind)
    limits = _limits(text, kind)
    damping, friction = _dynamics(text, kind)
    mimic = _mimic(text)
    if name is None or parent is None or child is None:
        return None
    return JointText(
        name=name,
        element=text.element,
        # the report has what could not be read; stand-ins let the tree be checked, too
        kind=kind or "continuous",
        parent=parent,
        child=child,
        origin=origin,
        axis=axis or _Z,
        limits=limits,
        damping=damping,
        friction=friction,
        mimic=mimic,
        screw=text.element.child(SCREW) is not None,
    )


def _kind(text: Passage) -> str | None:
    tag, kind = text.element.tag, text.element.attributes.get("type")
    custom = tag == DRAKE_JOINT
    if kind is None:
        text.fault("M103", f"<{tag}> has no type=…")
        return None
    if kind in (CUSTOM if custom else _STANDARD):
        return kind
    if custom and kind in _STANDARD:
        text.fault("M314", f"the type {kind!r} belongs into <joint>; Drake refuses it here")
        return kind
    if custom and kind in ("curvilinear", "screw"):
        text.fault("M604", f"<drake:joint> of type {kind!r} is not modeled")
        return None
    meant = "ball" if kind == "spherical" else kind
    remedy = f'Write <drake:joint type="{meant}">.' if meant in ("ball", "universal") else None
    known = ", ".join(CUSTOM if custom else _STANDARD)
    text.fault("M301", f"expected a type among {known}, got {kind[:60]!r}", remedy)
    return None


def _end(text: Passage, role: str) -> str | None:
    end = text.only(role)
    if end is None:
        text.fault("M103", f"<{text.element.tag}> has no <{role}>")
        return None
    return end.name("link")


def _axis(text: Passage, kind: str | None) -> tuple[float, float, float] | None:
    used = kind is None or kind in (*SINGLE, "planar")
    text = text if used else text.aside
    axis = text.only("axis")
    if axis is None:
        if used and text.element.tag == "joint":
            more = " (Pinocchio takes z)" if kind == "planar" else ""
            text.fault("M304", f"it has no <axis>, which means 1 0 0{more}")
        return _Z if text.element.tag == DRAKE_JOINT else _X
    values = axis.numbers("xyz", 3)
    if not used:
        return _X
    if values is None:
        return None
    length, written = math.hypot(*values), axis.element.attributes["xyz"]
    if length < 1e-8:
        axis.fault("M302", f"its axis {written!r} has no length")
        return None
    if abs(length - 1) > 1e-3:
        axis.fault("M303", f"its axis {written!r} has the length {length:g}")
    return values[0], values[1], values[2]


def _limits(text: Passage, kind: str | None) -> Limits | None:
    limit = text.only("limit", aside=True)
    bounded = kind in ("revolute", "prismatic")
    if limit is None:
        if bounded:
            text.fault("M307", f"a {kind} joint has no <limit>; it is read without bounds")
        return None
    left_out = {"lower": 0.0, "upper": 0.0, "effort": math.inf, "velocity": math.inf}
    values = [limit.number(name, default=x, most=math.inf) for name, x in left_out.items()]
    known = [value for value in values if value is not None]
    if len(known) < len(left_out):
        return None
    lower, upper, effort, velocity = known
    given = limit.element.attributes
    if bounded:
        missing = [name for name in ("effort", "velocity") if name not in given]
        if missing:
            absent = " and no ".join(missing)
            limit.fault("M307", f"<limit> has no {absent}; it is read as unbounded")
        if lower > upper:
            message = f"its lower limit {lower:g} is above its upper limit {upper:g}"
            limit.aside.fault("M306", message)
            lower, upper = -math.inf, math.inf
        if lower == upper == 0 and not {"lower", "upper"} <= given.keys():
            limit.fault("M308", "<limit> without lower and upper lets it move from 0 to 0")
        if any("inf" in given.get(name, "").lower() for name in left_out):
            limit.fault("M307", "Pinocchio and ROS cannot read an infinite limit")
    else:
        lower, upper = -math.inf, math.inf
    for name, value in (("effort", effort), ("velocity", velocity)):
        if value < 0:
            limit.aside.fault("M306", f"its limit of {name} is negative ({value:g})")
    effort, velocity = (value if value >= 0 else math.inf for value in (effort, velocity))
    bounds = lower, upper, effort, velocity
    return Limits(
        *(math.copysign(math.inf, bound) if abs(bound) >= UNBOUNDED else bound for bound in bounds)
    )


def _dynamics(text: Passage, kind: str | None) -> tuple[float, float]:
    dynamics = text.only("dynamics")
    if dynamics is None:
        return 0.0, 0.0
    words = dynamics.element.attributes.get("damping", "0").split()
    count = 3 if kind == "planar" and len(words) == 3 else 1
    dampings = dynamics.numbers("damping", count, default=(0.0,)) or (0.0,)
    friction = dynamics.number("friction", default=0.0) or 0.0
    if min(dampings) < 0:
        dynamics.fault("M311", f"its damping is {min(dampings):g}")
    elif any(dampings) and kind in MOVING and kind not in SINGLE:
        dynamics.fault("M312", f"the damping of a {kind} joint is not modeled")
    return dampings[0] if kind in SINGLE else 0.0, friction


def _mimic(text: Passage) -> Mimic | None:
    mimic = text.only("mimic")
    if mimic is None:
        return None
    name = mimic.name("joint")
    multiplier, offset = (
        mimic.number("multiplier", default=1.0),
        mimic.number("offset", default=0.0),
    )
    if name is None or multiplier is None or offset is None:
        return None
    return Mimic(mimic.element, mimic.where, name, multiplier, offset)


def followers(joints: list[JointText], report: Report) -> dict[str, Mimic]:
    """Return how each mimicking joint follows a free one, by its name; report what cannot."""
    by_name = {joint.name: joint for joint in joints}
    mimics = {
        joint.name: joint.mimic
        for joint in joints
        if joint.mimic is not None and _fit(joint, joint.mimic, by_name, report)
    }
    solved: dict[str, Mimic | None] = {}  # None for what follows itself
    for name, mimic in mimics.items():
        chain: dict[str, Mimic] = {}
        while name in mimics and name not in solved and name not in chain:
            chain[name] = mimic = mimics[name]
            name = mimic.joint
        if name in chain:
            members = [*chain][[*chain].index(name) :]
            shown = " → ".join([*members[:6], *(["…"] if len(members) > 6 else []), name])
            report.add("M402", mimics[name], f"cycle: {shown}")
            solved |= dict.fromkeys(chain)
            continue
        outer = solved.get(name, replace(mimic, multiplier=1.0, offset=0.0))
        for follower, mimic in reversed(chain.items()):
            outer = solved[follower] = outer and _compose(mimic, outer, report)
    return {name: mimic for name, mimic in solved.items() if mimic is not None}


def _fit(joint: JointText, mimic: Mimic, joints: Mapping[str, JointText], report: Report) -> bool:
    leader = joints.get(mimic.joint)
    if joint.kind == "fixed":
        report.add("M407", mimic, f"it is fixed and mimics {mimic.joint!r}")
    elif leader is None:
        report.add("M401", mimic, f"it mimics {mimic.joint!r}, which is no joint")
    elif joint.kind not in SINGLE:
        report.add("M403", mimic, f"a {joint.kind} joint cannot mimic another")
    elif leader.kind not in SINGLE:
        report.add("M403", mimic, f"it mimics {leader.name!r}, a {leader.kind} joint")
    else:
        return True
    return False


def _compose(mimic: Mimic, outer: Mimic, report: Report) -> Mimic:
    """Substitute the law of the joint that is followed: m (M x + O) + o."""
    multiplier = mimic.multiplier * outer.multiplier
    offset = mimic.multiplier * outer.offset + mimic.offset
    if not (math.isfinite(multiplier) and math.isfinite(offset)):
        report.add("M104", mimic, "its multipliers and offsets grow beyond all numbers")
        return outer
    return replace(mimic, joint=outer.joint, multiplier=multiplier, offset=offset)
