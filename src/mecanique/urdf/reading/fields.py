"""Passages of a URDF text: their numbers, names and placements, and the faults in them."""

from __future__ import annotations

import math
import re
from dataclasses import dataclass, replace
from typing import final

from mecanique.model.placement import Placement
from mecanique.urdf.findings import Report
from mecanique.urdf.markup import Element

LARGEST = 1e50
"""Largest length, mass or inertia that is read: products of a few still are finite."""

_NUMBER = re.compile(r"[+-]?(?:[0-9]+\.?[0-9]*|\.[0-9]+)(?:[eE][+-]?[0-9]+)?")
_INFINITE = re.compile(r"[+-]?inf(?:inity)?", re.IGNORECASE)
_LONGEST = 400


@final
@dataclass(frozen=True)
class Passage:
    """An element that is read, what reports call it, and the report of what cannot be read."""

    element: Element
    report: Report
    where: str = ""

    @property
    def aside(self) -> Passage:
        """The same for what no equation of motion uses: its errors stop no reader."""
        return replace(self, report=self.report.aside)

    def at(self, element: Element) -> Passage:
        """Return the same at another element."""
        return replace(self, element=element)

    def fault(self, code: str, message: str, remedy: str | None = None) -> None:
        """Report a fault of it."""
        self.report.add(code, self, message, remedy)

    def only(self, tag: str, *, aside: bool = False) -> Passage | None:
        """Return the only child with a tag; more than one are a fault, which may be set aside."""
        children = [self.at(child) for child in self.element.all(tag)]
        if len(children) > 1:
            second = children[1].aside if aside else children[1]
            second.fault("M112", f"<{self.element.tag}> has {len(children)} <{tag}>")
        return children[0] if children else None

    def name(self, attribute: str = "name") -> str | None:
        """Return a name that an attribute holds; None if it is missing or unfit."""
        name = self.element.attributes.get(attribute)
        if name is None:
            self.fault("M103", f"<{self.element.tag}> has no {attribute}=…")
            return None
        if not name.strip() or not name.isprintable():
            wanted = f"expected a printable {attribute} of <{self.element.tag}>"
            self.fault("M105", f"{wanted}, got {_short(name)}")
            return None
        return name

    def numbers(
        self,
        attribute: str,
        count: int,
        *,
        default: tuple[float, ...] | None = None,
        most: float = LARGEST,
    ) -> tuple[float, ...] | None:
        """Return an attribute's numbers, `default` without it; None if they cannot be read."""
        text = self.element.attributes.get(attribute)
        what = f"{attribute} of <{self.element.tag}>"
        if text is None:
            if default is None:
                self.fault("M103", f"<{self.element.tag}> has no {attribute}=…")
            return default
        words = text.split() if len(text) <= _LONGEST * count else [text]
        if len(words) != count:
            expected = "a number" if count == 1 else f"{count} numbers"
            self.fault(_fault(text), f"expected {expected} for {what}, got {_short(text)}")
            return None
        values = []
        for word in words:
            if len(word) > _LONGEST or not _NUMBER.fullmatch(word):
                value = float(word) if most == math.inf and _INFINITE.fullmatch(word) else math.nan
            else:
                value = float(word)
                value = math.nan if math.isinf(value) else value
            if math.isnan(value):
                expected = f"expected a finite number for {what}"
                self.fault(_fault(word), f"{expected}, got {_short(word)}")
                return None
            if abs(value) > most:
                self.fault("M104", f"expected at most {most:g} for {what}, got {_short(word)}")
                return None
            values.append(value)
        return tuple(values)

    def number(
        self, attribute: str, *, default: float | None = None, most: float = LARGEST
    ) -> float | None:
        """Return an attribute's number, `default` without it; None if it cannot be read."""
        standard = None if default is None else (default,)
        values = self.numbers(attribute, 1, default=standard, most=most)
        return None if values is None else values[0]

    def origin(self) -> Placement:
        """Return the placement by the <origin> inside; the parent's frame without one."""
        origin = self.only("origin")
        return Placement() if origin is None else origin.placement()

    def placement(self) -> Placement:
        """Return the placement that its own xyz and rpy give."""
        zero = (0.0, 0.0, 0.0)
        xyz, rpy = (self.numbers(name, 3, default=zero) or zero for name in ("xyz", "rpy"))
        return Placement((xyz[0], xyz[1], xyz[2]), (rpy[0], rpy[1], rpy[2]))


def _fault(text: str) -> str:
    return "M006" if "${" in text or "$(" in text else "M104"


def _short(text: str) -> str:
    return repr(text if len(text) <= 60 else text[:57] + "…")
