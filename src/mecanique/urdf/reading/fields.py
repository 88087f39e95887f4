"""Attributes of URDF elements as numbers, names and placements; what cannot be read is reported."""

from __future__ import annotations

import math
import re

from mecanique.model.placement import Placement
from mecanique.urdf.findings import Report
from mecanique.urdf.markup import Element

LARGEST = 1e50
"""Largest length, mass or inertia that is read: products of a few still are finite."""

_NUMBER = re.compile(r"[+-]?(?:[0-9]+\.?[0-9]*|\.[0-9]+)(?:[eE][+-]?[0-9]+)?")
_INFINITE = re.compile(r"[+-]?inf(?:inity)?", re.IGNORECASE)
_LONGEST = 400


def numbers(
    element: Element,
    attribute: str,
    count: int,
    report: Report,
    where: str,
    *,
    default: tuple[float, ...] | None = None,
    most: float = LARGEST,
) -> tuple[float, ...] | None:
    """Return an attribute's numbers, `default` without it; None if unreadable, as reported."""
    text = element.attributes.get(attribute)
    what = f"{attribute} of <{element.tag}>"
    if text is None:
        if default is None:
            report.add("M103", element, where, f"<{element.tag}> has no {attribute}=…")
        return default
    words = text.split() if len(text) <= _LONGEST * count else [text]
    if len(words) != count:
        expected = "a number" if count == 1 else f"{count} numbers"
        report.add(
            _fault(text), element, where, f"expected {expected} for {what}, got {_short(text)}"
        )
        return None
    values = []
    for word in words:
        if len(word) > _LONGEST or not _NUMBER.fullmatch(word):
            value = float(word) if most == math.inf and _INFINITE.fullmatch(word) else math.nan
        else:
            value = float(word)
            value = math.nan if math.isinf(value) else value
        if math.isnan(value):
            report.add(
                _fault(word),
                element,
                where,
                f"expected a finite number for {what}, got {_short(word)}",
            )
            return None
        if abs(value) > most:
            report.add(
                "M104", element, where, f"expected at most {most:g} for {what}, got {_short(word)}"
            )
            return None
        values.append(value)
    return tuple(values)


def number(
    element: Element,
    attribute: str,
    report: Report,
    where: str,
    *,
    default: float | None = None,
    most: float = LARGEST,
) -> float | None:
    """Return an attribute's number, `default` without it; None if unreadable, as reported."""
    standard = None if default is None else (default,)
    values = numbers(element, attribute, 1, report, where, default=standard, most=most)
    return None if values is None else values[0]


def placement(parent: Element, report: Report, where: str) -> Placement:
    """Return the placement by the <origin> inside an element; the parent's frame without one."""
    element = single(parent, "origin", report, where)
    return Placement() if element is None else placement_of(element, report, where)


def placement_of(element: Element, report: Report, where: str) -> Placement:
    """Return the placement that an element's own xyz and rpy give."""
    zero = (0.0, 0.0, 0.0)
    xyz = numbers(element, "xyz", 3, report, where, default=zero) or zero
    rpy = numbers(element, "rpy", 3, report, where, default=zero) or zero
    return Placement((xyz[0], xyz[1], xyz[2]), (rpy[0], rpy[1], rpy[2]))


def single(parent: Element, tag: str, report: Report, where: str) -> Element | None:
    """Return the only child with a tag; duplicates are reported."""
    children = parent.all(tag)
    if len(children) > 1:
        report.add("M112", children[1], where, f"<{parent.tag}> has {len(children)} <{tag}>")
    return children[0] if children else None


def name_of(
    element: Element, report: Report, attribute: str = "name", where: str = ""
) -> str | None:
    """Return a name that an attribute holds; None if it is missing or unfit, which is reported."""
    name = element.attributes.get(attribute)
    if name is None:
        report.add("M103", element, where, f"<{element.tag}> has no {attribute}=…")
        return None
    if not name.strip() or not name.isprintable():
        report.add(
            "M105",
            element,
            where,
            f"expected a printable {attribute} of <{element.tag}>, got {_short(name)}",
        )
        return None
    return name


def _fault(text: str) -> str:
    return "M006" if "${" in text or "$(" in text else "M104"


def _short(text: str) -> str:
    return repr(text if len(text) <= 60 else text[:57] + "…")
