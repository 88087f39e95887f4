"""Blanks that make urdfdom, the parser of Pinocchio and ROS, stumble over a number.

It reads a number up to the end of the attribute, so that no blank may follow; a vector it splits at
blanks only, not at tabs or line breaks. XML readers that follow the standard turn both into blanks
before anybody sees them, and read the same number as without: hence the raw text is examined.
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import dataclass
from html import unescape
from typing import final

from mecanique.urdf.dialect import DRAKE_JOINT
from mecanique.urdf.findings import Report, Spot
from mecanique.urdf.markup import Element
from mecanique.urdf.reading.document import UrdfDocument

_VECTORS = {("origin", "xyz"), ("origin", "rpy"), ("axis", "xyz")}
_NUMBERS = {
    "mass": ("value",),
    "inertia": ("ixx", "iyy", "izz", "ixy", "ixz", "iyz"),
    "origin": ("xyz", "rpy"),
    "axis": ("xyz",),
    "limit": ("lower", "upper", "effort", "velocity"),
    "dynamics": ("damping", "friction"),
    "mimic": ("multiplier", "offset"),
}
_START_TAG = re.compile(rb"<[^\s/>]+(?:[^>\"']|\"[^\"]*\"|'[^']*')*>")


@final
@dataclass(frozen=True)
class Blank:
    """An attribute that urdfdom cannot read."""

    element: Element
    attribute: str
    value: str  # as written, with its blanks
    drops: bool  # whether an inertia is silently dropped; else the file is refused


def check(document: UrdfDocument, report: Report) -> None:
    """Note the numbers over which urdfdom stumbles."""
    for holder in document.element.children:
        where = f"{holder.tag} {holder.attributes.get('name', '')!r}"
        for blank in _within(holder, document.text):
            what = f"{blank.attribute} of <{blank.element.tag}> is {blank.value!r}"
            result = "refuse the file"
            if blank.drops:
                lost = "inertia" if blank.element.tag == "inertia" else "whole <inertial>"
                result = f"silently drop the {lost}"
            report.add("M116", Spot(blank.element, where), f"{what}: Pinocchio and ROS {result}")


def blanks(robot: Element, raw: bytes) -> Iterator[Blank]:
    """Yield the attributes of a robot that urdfdom cannot read because of blanks."""
    for holder in robot.children:
        yield from _within(holder, raw)


def _within(holder: Element, raw: bytes) -> Iterator[Blank]:
    inertial = holder.child("inertial") if holder.tag == "link" else None
    if inertial is not None:
        holder = inertial
    elif holder.tag not in ("joint", DRAKE_JOINT):
        return
    for element in holder.children:
        for attribute in _NUMBERS.get(element.tag, ()):
            span = find_attribute(element, raw, attribute)
            if span is None:
                continue
            # as written, its blanks untouched
            value = unescape(raw[span[0] + 1 : span[1] - 1].decode("utf-8", "replace"))
            vector = (element.tag, attribute) in _VECTORS
            words = value.split(" ") if vector else [value]
            # leading blanks are skipped, also by urdfdom
            if any(re.search(r"\S\s", word) for word in words):
                yield Blank(element, attribute, value, inertial is not None)


def find_attribute(element: Element, raw: bytes, name: str) -> tuple[int, int] | None:
    """Return where an attribute's value stands with its quotes; None if it is not there."""
    tag = start_tag(element, raw)
    pattern = re.compile(rb"\s%s\s*=\s*(\"[^\"]*\"|'[^']*')" % name.encode())
    match = tag and pattern.search(raw, *tag.span())
    return match.span(1) if match else None


def start_tag(element: Element, raw: bytes) -> re.Match[bytes] | None:
    """Return the start tag of an element in the text; None if that is in another encoding."""
    return _START_TAG.match(raw, element.offset)
