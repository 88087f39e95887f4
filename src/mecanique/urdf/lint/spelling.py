"""Elements and attributes that nothing reads: misspelled, misplaced, or for other programs."""

from __future__ import annotations

import re
from collections import defaultdict
from collections.abc import Collection
from difflib import get_close_matches

from mecanique.urdf.dialect import ACTUATOR_GEAR, ACTUATOR_INERTIA, EXTENSIONS, SCREW, uses_drake
from mecanique.urdf.findings import Report, Spot
from mecanique.urdf.markup import Element
from mecanique.urdf.reading.document import UrdfDocument
from mecanique.urdf.reading.native_tags import CHILDREN, NATIVE_TAGS

_JOINT = (
    {"name", "type"},
    {
        *("origin", "parent", "child", "axis", "limit", "dynamics", "mimic", "calibration"),
        *("safety_controller", SCREW),
    },
)
_WORDS: dict[str, tuple[Collection[str], Collection[str]]] = {
    "robot": (
        {"name", "version"},
        {
            *("link", "joint", "drake:joint", "material", "frame"),
            *EXTENSIONS,
            *NATIVE_TAGS,
        },
    ),
    "link": ({"name"}, {"inertial", "visual", "collision"}),
    "joint": _JOINT,
    "drake:joint": _JOINT,
    "inertial": ((), {"origin", "mass", "inertia"}),
    "visual": ({"name"}, {"origin", "geometry", "material"}),
    "collision": ({"name"}, {"origin", "geometry"}),
    "geometry": ((), {"box", "cylinder", "sphere", "mesh"}),
    "material": ({"name"}, {"color", "texture"}),
    "origin": ({"xyz", "rpy"}, ()),
    "mass": ({"value"}, ()),
    "inertia": ({"ixx", "ixy", "ixz", "iyy", "iyz", "izz"}, ()),
    "box": ({"size"}, ()),
    "cylinder": ({"radius", "length"}, ()),
    "sphere": ({"radius"}, ()),
    "mesh": ({"filename", "scale"}, ()),
    "color": ({"rgba"}, ()),
    "axis": ({"xyz"}, ()),
    "parent": ({"link"}, ()),
    "child": ({"link"}, ()),
    "limit": ({"lower", "upper", "effort", "velocity"}, ()),
    "dynamics": ({"damping", "friction"}, ()),
    "mimic": ({"joint", "multiplier", "offset"}, ()),
    "frame": ({"name", "link", "xyz", "rpy"}, ()),
    SCREW: ((), ()),
    **{tag: ({"name", *kind.attributes}, {*kind.children}) for tag, kind in NATIVE_TAGS.items()},
    **{tag: ({*kind.attributes}, ()) for tag, kind in CHILDREN.items()},
}
"""Attributes and children of each element."""

_UNUSED = {"safety_controller", "calibration", "transmission", "texture"}
_OTHERS = {
    *("gazebo", "transmission", "ros2_control", "sensor", "mujoco", "loop_joint", "texture"),
    "contact",
}
_HOLDERS = ("robot", "joint", "drake:joint")
"""Elements in which a tag of Drake's that is not known is told as such."""


_COMMON = {("collision", "material")}


def check(document: UrdfDocument, report: Report) -> None:
    """Note elements and attributes that are not read, and the version and namespace."""
    robot = document.element
    version = robot.attributes.get("version", "1.0")
    if version != "1.0":
        report.add("M705", robot, f"the version is {version!r}")
    _namespace(robot, report)
    unused: dict[str, list[Spot]] = defaultdict(list)
    waiting = [Spot(robot, "")]
    while waiting:
        element, where = spot = waiting.pop()
        attributes, children = _WORDS[element.tag]
        strange: list[tuple[str, str, Collection[str], Spot]] = [
            (name, f"{name}=… of <{element.tag}>", attributes, spot)
            for name in element.attributes
            if name not in attributes and not name.startswith(("xmlns", "drake:"))
        ]
        for child in element.children:
            tag, inside = child.tag, Spot(child, where or _place(child))
            misplaced = tag in _WORDS and tag not in _OTHERS and (element.tag, tag) not in _COMMON
            if tag in children:
                if tag in _UNUSED:
                    unused[f"<{tag}>"].append(inside)
                elif tag in _WORDS:
                    waiting.append(inside)
            elif tag.startswith("drake:"):
                if element.tag in _HOLDERS:
                    report.add("M601", inside, f"<{tag}> in <{element.tag}> is not known")
            elif misplaced:
                message = f"<{tag}> has no meaning in <{element.tag}>; it is ignored"
                report.add("M113", inside, message)
            else:
                strange.append((tag, f"<{tag}> in <{element.tag}>", children, inside))
        for word, what, known, place in strange:
            if near := _guess(word, known):
                report.add("M113", place, f"{what} is ignored; did you mean {near!r}?")
            else:
                unused[what].append(place)
    for what, places in unused.items():
        report.together("M703", places, f"{what} is not used")
    _rotors(robot, report)
    _drives(robot, report)


def _place(element: Element) -> str:
    name = element.attributes.get("name")
    return f"{element.tag} {name!r}" if name else f"<{element.tag}>"


def _guess(word: str, known: Collection[str]) -> str:
    """Return the known word that was meant; "" if none is near."""
    if word in _OTHERS or len(word) > 30:
        return ""
    near = get_close_matches(word.lower(), known, n=1, cutoff=0.7)
    return near[0] if near and abs(len(near[0]) - len(word)) <= 2 else ""


def _namespace(robot: Element, report: Report) -> None:
    if "xmlns:drake" in robot.attributes:
        return
    first = next(filter(uses_drake, robot.walk()), None)
    if first is not None:
        place = Spot(first, f"<{first.tag}>")
        report.add("M607", place, "the prefix drake: is used but not declared")


_ROTOR = re.compile(r"(rotor|motor)_?inertia", re.IGNORECASE)
_REDUCTION = re.compile(r"mechanical_?reduction|gear_?ratio", re.IGNORECASE)


def _drives(robot: Element, report: Report) -> None:
    """Say what a rotor and a reduction make of which only Drake's tags are read."""
    for drive in robot.all("transmission"):
        inside = [element for element in drive.walk() if not element.tag.startswith("drake:")]
        rotors = [element for element in inside if _ROTOR.fullmatch(element.tag)]
        drakes = [element for element in drive.walk() if element.tag == ACTUATOR_INERTIA]
        ratios = [element for element in inside if _REDUCTION.fullmatch(element.tag)]
        geared = any(element.tag == ACTUATOR_GEAR for element in drive.walk())
        joint = drive.child("joint")
        if joint is None or not (rotors or (drakes and ratios and not geared)):
            continue
        inertia = _value(rotors[0] if rotors else drakes[0])
        ratio = _value(ratios[0]) if ratios else 1.0
        if inertia is None or ratio is None:
            continue
        name, armature = joint.attributes.get("name", ""), inertia * ratio**2
        at = rotors[0] if rotors else ratios[0]
        message = (
            f"<{at.tag}> is not read: with a rotor of {inertia:g} and a reduction of {ratio:g} "
            f"joint {name!r} has an armature of {armature:g}"
        )
        remedy = (
            f"Write <{ACTUATOR_INERTIA}> and <{ACTUATOR_GEAR}> in <actuator>, or read it with "
            f"armature={{{name!r}: {armature:g}}}."
        )
        report.add("M601", Spot(at, _place(drive)), message, remedy)


def _value(element: Element) -> float | None:
    try:
        return float(element.attributes.get("value", element.text))
    except ValueError:
        return None


def _rotors(robot: Element, report: Report) -> None:
    """Rotor inertias count below robot/transmission/actuator only."""
    for element in robot.walk():
        for child in () if element.tag in ("actuator", *_HOLDERS) else element.children:
            if child.tag in (ACTUATOR_INERTIA, ACTUATOR_GEAR):
                message = f"<{child.tag}> counts only in <actuator>; it is left out"
                report.add("M601", Spot(child, f"<{element.tag}>"), message)
