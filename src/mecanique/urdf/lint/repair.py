"""Repair what has exactly one safe remedy; everything else in the text stays as it is."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass
from typing import final

import numpy as np

from mecanique.model.bodies.tensor import entries_of, tensor_of
from mecanique.model.mechanism.validation import inertia_fault
from mecanique.urdf.dialect import DRAKE_NAMESPACE, uses_drake
from mecanique.urdf.findings import Report
from mecanique.urdf.lint.blanks import blanks, find_attribute, start_tag
from mecanique.urdf.markup import Element, quote
from mecanique.urdf.parse import parse
from mecanique.urdf.reading.fields import Passage
from mecanique.urdf.reading.joints import SINGLE
from mecanique.urdf.reading.links import ENTRIES

_FACES = np.array([[1.0, 1.0, -1.0], [1.0, -1.0, 1.0], [-1.0, 1.0, 1.0]])
"""Each product with the moments is at least zero."""


@final
@dataclass(frozen=True)
class BalancedInertia:
    """An inertia that no real body has, and the nearest one that a body can have.

    Args:
        link: name of the link.
        element: its <inertia>.
        before: ixx, iyy, izz, ixy, ixz, iyz as written [kg·m²].
        after: the same of the nearest real body.
    """

    link: str
    element: Element
    before: tuple[float, ...]
    after: tuple[float, ...]

    def __str__(self) -> str:
        changed = [
            f"{name} {old:.6g} → {new:.6g}"
            for name, old, new in zip(ENTRIES, self.before, self.after, strict=True)
            if f"{old:.6g}" != f"{new:.6g}"
        ]
        most = max(abs(new - old) for old, new in zip(self.before, self.after, strict=True))
        part = 100 * most / max(map(abs, self.before))
        what = ", ".join(changed) or "its last digits"
        return (
            f"line {self.element.line}: link {self.link!r}: {what} kg·m² "
            f"(at most {part:.2g} % of its largest entry)"
        )


def balances(robot: Element) -> Iterator[BalancedInertia]:
    """Yield every inertia of a robot that no real body has, with the nearest one."""
    for link in robot.all("link"):
        inertial = link.child("inertial")
        mass, inertia = (
            (None, None) if inertial is None else map(inertial.child, ("mass", "inertia"))
        )
        if mass is None or inertia is None:
            continue
        kilograms = Passage(mass, Report(None)).number("value")
        given = [Passage(inertia, Report(None)).number(name) for name in ENTRIES]
        before = tuple(entry for entry in given if entry is not None)
        if kilograms is None or kilograms < 0 or len(before) < len(ENTRIES):
            continue
        if inertia_fault(kilograms, before):
            yield BalancedInertia(
                link.attributes.get("name", ""), inertia, before, nearest_inertia(before)
            )


def nearest_inertia(inertia: Sequence[float]) -> tuple[float, ...]:
    """Return a real body's nearest inertia (ixx, iyy, izz, ixy, ixz, iyz), by Frobenius norm."""
    moments, axes = np.linalg.eigh(tensor_of(inertia))
    return entries_of(axes @ np.diag(_project(moments)) @ axes.T)


def _project(moments: np.ndarray) -> np.ndarray:
    """Return the nearest point of the cone: the nearest feasible foot on a face, edge or tip."""
    feet = [moments, np.zeros(3)]
    for faces in ([0], [1], [2], [0, 1], [0, 2], [1, 2]):
        normals = _FACES[faces]
        feet.append(moments - np.linalg.pinv(normals) @ (normals @ moments))
    slack = 1e-12 * np.abs(moments).max()
    feasible = [foot for foot in feet if (_FACES @ foot >= -slack).all()]
    return min(feasible, key=lambda foot: float(np.linalg.norm(foot - moments)))


@final
@dataclass(frozen=True)
class _Edit:
    """Bytes that replace others."""

    start: int
    end: int
    text: str


def mend(text: str, *, name: str = "robot", balance: bool = False) -> str:
    """Return a URDF text with every fault repaired that has exactly one safe remedy.

    A robot without a name gets one, axes get length one, a missing axis is written as URDF implies
    it (x), missing products of inertia are written as zero, numbers are separated by single blanks,
    with none around them, and the prefix drake: is declared where it is used. Comments, order and
    everything else stay.

    Args:
        text: the URDF text.
        name: for a robot without one.
        balance: whether an inertia that no real body has becomes the nearest one that a body can
            have (`mecanique.urdf.lint.repair`); `find_balances` lists what that changes.

    Returns:
        The repaired text; the text itself if there is nothing to repair or it is not XML.
    """
    text = _apply(text, lambda robot, raw: _edits(robot, raw, name))
    return _apply(text, _balance) if balance else text


def find_balances(text: str) -> tuple[BalancedInertia, ...]:
    """Return what `mend` with `balance` changes, inertia by inertia.

    Args:
        text: the URDF text before.
    """
    robot = parse(mend(text), Report(None))
    return () if robot is None or robot.tag != "robot" else tuple(balances(robot))


def _apply(text: str, edits: Callable[[Element, bytes], Iterable[_Edit]]) -> str:
    robot = parse(text, Report(None))
    if robot is None or robot.tag != "robot":
        return text
    raw = text.encode()
    for edit in sorted(edits(robot, raw), key=lambda edit: edit.start, reverse=True):
        raw = raw[: edit.start] + edit.text.encode() + raw[edit.end :]
    return raw.decode()


def _balance(robot: Element, raw: bytes) -> Iterator[_Edit]:
    for balance in balances(robot):
        for name, value in zip(ENTRIES, balance.after, strict=True):
            yield from _attribute(balance.element, raw, name, f"{value:.12g}")


def _edits(robot: Element, raw: bytes, name: str) -> Iterator[_Edit]:
    new = ""
    if "name" not in robot.attributes:
        new += f" name={quote(name)}"
    if "xmlns:drake" not in robot.attributes and any(map(uses_drake, robot.walk())):
        new += f' xmlns:drake="{DRAKE_NAMESPACE}"'
    if new:
        yield _insert(robot, new)
    for blank in blanks(robot, raw):
        tidy = " ".join(blank.value.split())
        yield from _attribute(blank.element, raw, blank.attribute, tidy)
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
            tag = start_tag(joint, raw)
            assert tag is not None, "an element that was parsed has a start tag"
            yield _Edit(tag.end(), tag.end(), '\n    <axis xyz="1 0 0"/>')
        elif len(axes) == 1:
            yield from _unit(axes[0], raw)


def _unit(axis: Element, raw: bytes) -> Iterator[_Edit]:
    values = Passage(axis, Report(None)).numbers("xyz", 3)
    length = math.hypot(*values) if values else 0.0
    if values is None or length < 1e-8 or abs(length - 1) <= 1e-3:
        return
    shown = " ".join(repr(value / length + 0.0).removesuffix(".0") for value in values)
    yield from _attribute(axis, raw, "xyz", shown)


def _attribute(element: Element, raw: bytes, name: str, value: str) -> Iterator[_Edit]:
    """Replace the value of an attribute."""
    if (span := find_attribute(element, raw, name)) is not None:
        yield _Edit(*span, f'"{value}"')


def _insert(element: Element, text: str) -> _Edit:
    """Insert attributes right after the tag's name."""
    place = element.offset + 1 + len(element.tag.encode())
    return _Edit(place, place, text)
