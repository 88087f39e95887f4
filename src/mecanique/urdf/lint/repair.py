"""Repair what has exactly one safe remedy; everything else in the text stays as it is."""

from __future__ import annotations

import math
import re
from collections.abc import Iterator
from dataclasses import dataclass
from typing import final
from xml.sax.saxutils import quoteattr

from mecanique.urdf.dialect import DRAKE_NAMESPACE
from mecanique.urdf.element import Element
from mecanique.urdf.findings import Report
from mecanique.urdf.reading.fields import numbers
from mecanique.urdf.reading.joints import SINGLE
from mecanique.urdf.xml.parse import parse

__all__ = ["mend"]

_START_TAG = re.compile(rb"<[^\s/>]+(?:[^>\"']|\"[^\"]*\"|'[^']*')*>")


@final
@dataclass(frozen=True)
class _Edit:
    """Bytes that replace others."""

    start: int
    end: int
    text: str


def mend(text: str, *, name: str = "robot") -> str:
    """Return a URDF text with every fault repaired that has exactly one safe remedy.

    A robot without a name gets one, axes get length one, a missing axis is written as URDF implies
    it (x), missing products of inertia are written as zero, and the prefix drake: is declared
    where it is used. Comments, order and everything else stay.

    Args:
        text: the URDF text.
        name: for a robot without one.

    Returns:
        The repaired text; the text itself if there is nothing to repair or it is not XML.
    """
    robot = parse(text, Report(None))
    if robot is None or robot.tag != "robot":
        return text
    raw = text.encode()
    for edit in sorted(_edits(robot, raw, name), key=lambda edit: edit.start, reverse=True):
        raw = raw[: edit.start] + edit.text.encode() + raw[edit.end :]
    return raw.decode()


def _edits(robot: Element, raw: bytes, name: str) -> Iterator[_Edit]:
    new = ""
    if "name" not in robot.attributes:
        new += f" name={quoteattr(name)}"
    used = (element.tag.startswith("drake:") or _has_drake(element) for element in robot.walk())
    if "xmlns:drake" not in robot.attributes and any(used):
        new += f' xmlns:drake="{DRAKE_NAMESPACE}"'
    if new:
        yield _insert(robot, new)
    for element in robot.walk():
        if element.tag == "inertia":
            missing = [entry for entry in ("ixy", "ixz", "iyz") if entry not in element.attributes]
            if missing and {"ixx", "iyy", "izz"} <= set(element.attributes):
                yield _insert(element, "".join(f' {entry}="0"' for entry in missing))
    for joint in robot.all("joint"):
        if joint.attributes.get("type") not in SINGLE:
            continue
        axes = joint.all("axis")
        if not axes and joint.children:
            end = _start_tag(joint, raw).end()
            yield _Edit(end, end, '\n    <axis xyz="1 0 0"/>')
        elif len(axes) == 1:
            yield from _unit(axes[0], raw)


def _unit(axis: Element, raw: bytes) -> Iterator[_Edit]:
    values = numbers(axis, "xyz", 3, Report(None), "")
    length = math.hypot(*values) if values else 0.0
    if values is None or length < 1e-8 or abs(length - 1) <= 1e-3:
        return
    tag = _start_tag(axis, raw)
    found = re.search(rb"\sxyz\s*=\s*(\"[^\"]*\"|'[^']*')", tag.group())
    if found:
        shown = " ".join(repr(value / length + 0.0).removesuffix(".0") for value in values)
        yield _Edit(tag.start() + found.start(1), tag.start() + found.end(1), f'"{shown}"')


def _insert(element: Element, text: str) -> _Edit:
    """Insert attributes right after the tag's name."""
    place = element.offset + 1 + len(element.tag.encode())
    return _Edit(place, place, text)


def _start_tag(element: Element, raw: bytes) -> re.Match[bytes]:
    match = _START_TAG.match(raw, element.offset)
    assert match is not None, "an element that was parsed has a start tag"
    return match


def _has_drake(element: Element) -> bool:
    return any(name.startswith("drake:") for name in element.attributes)
