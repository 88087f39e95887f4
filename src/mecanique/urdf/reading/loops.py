"""Loops in URDF: Drake's tags for balls and rods, and for all other kinds an element of our own.

    <mecanique:loop name="C" type="pin">
      <mecanique:frame_a link="coupler" xyz="2.2 0 0" rpy="0 0 0"/>
      <mecanique:frame_b link="rocker" xyz="1.7 0 0" rpy="0 0 0"/>
    </mecanique:loop>

The types are those of `mecanique.model.constraints.loops.CLOSED`; other programs ignore the
element, and see the open tree.
"""

from __future__ import annotations

from collections.abc import Collection, Iterator, Mapping
from typing import cast

from mecanique.model.constraints.loops import CLOSED, Kind, Loop
from mecanique.model.mechanism import Mechanism
from mecanique.model.placement import Placement
from mecanique.urdf.dialect import (
    BALL_CONSTRAINT,
    DISTANCE_CONSTRAINT,
    LOOP,
    LOOP_FRAMES,
    UNBOUNDED,
    Extension,
)
from mecanique.urdf.findings import Report
from mecanique.urdf.markup import Comment, Element, Node, Tag, number, numbers
from mecanique.urdf.names import Names
from mecanique.urdf.reading.fields import name_of, placement_of, single
from mecanique.urdf.reading.fields import number as read_number

_IN_DRAKE = ("ball", "distance")
_OWN = ("hinge", "weld", "pin", "plate")


def has_own_loops(mechanism: Mechanism) -> bool:
    """Return whether a mechanism has loops or elements for which Drake has no tag."""
    return bool(mechanism.elements) or any(loop.kind not in _IN_DRAKE for loop in mechanism.loops)


def loop_nodes(
    mechanism: Mechanism, loop: Loop, anchors: Mapping[str, str], *, redundant: bool = False
) -> Iterator[Node]:
    """Yield the elements of a loop, after a comment with its name."""
    where = f"loop {loop.name!r}"
    ends = []
    for body, frame in ((loop.body_a, loop.frame_a), (loop.body_b, loop.frame_b)):
        xyz, rpy = mechanism.evaluate_all(frame.xyz), mechanism.evaluate_all(frame.rpy)
        ends.append((anchors.get(body, body), xyz, rpy))
    if loop.kind in _IN_DRAKE and not redundant:
        (body_a, point_a, _), (body_b, point_b, _) = ends
        contents = {
            "body_a": body_a,
            "point_a": numbers(point_a, where),
            "body_b": body_b,
            "point_b": numbers(point_b, where),
        }
        if loop.kind == "ball":
            yield Comment(f"ball loop {loop.name}")
            yield _extension(BALL_CONSTRAINT, contents)
            return
        length = number(mechanism.evaluate(loop.length), where)
        yield Comment(
            f"distance loop {loop.name}, length {length} m; Drake keeps it by a stiff spring"
        )
        stiff = {"distance": length, "stiffness": number(UNBOUNDED, where), "damping": "0"}
        yield _extension(DISTANCE_CONSTRAINT, {**contents, **stiff})
        return
    yield Comment(
        f"{loop.kind} loop {loop.name}, which mecanique reads; no tag of Drake is the same"
    )
    frames = (
        Tag(tag, link=body, xyz=numbers(xyz, where), rpy=numbers(rpy, where))
        for tag, (body, xyz, rpy) in zip(LOOP_FRAMES, ends, strict=True)
    )
    more = {"redundant": "true"} if redundant else {}
    if redundant and loop.kind == "distance":
        more["length"] = number(mechanism.evaluate(loop.length), where)
    yield Tag(LOOP, *frames, name=loop.name, type=loop.kind, **more)


def read_loop(
    element: Element, links: Collection[str], names: Names, report: Report
) -> Loop | None:
    """Return the loop that an element of our own describes; None if faults were reported."""
    name = name_of(element, report)
    where = f"loop {name!r}"
    kind = element.attributes.get("type", "")
    kinds = CLOSED if is_redundant(element) else _OWN
    if kind not in kinds:
        expected = f"expected a type among {', '.join(kinds)}, got {kind!r}"
        report.add("M602", element, where, expected)
        return None
    length = read_number(element, "length", report, where, default=0.0)
    ends: list[tuple[str, Placement]] = []
    for tag in LOOP_FRAMES:
        frame = single(element, tag, report, where)
        if frame is None:
            report.add("M602", element, where, f"it has no <{tag}>")
            continue
        link = name_of(frame, report, "link", where)
        if link is not None and link not in links:
            report.add("M603", frame, where, f"{link!r} is no link")
        elif link is not None:
            ends.append((link, placement_of(frame, report, where)))
    if name is None or length is None or len(ends) < len(LOOP_FRAMES):
        return None
    (a, frame_a), (b, frame_b) = ends
    if a == b:
        report.add("M603", element, where, f"both of its ends are on link {a!r}")
        return None
    return Loop(
        name=names.free(name),
        kind=cast("Kind", kind),
        body_a=a,
        frame_a=frame_a,
        body_b=b,
        frame_b=frame_b,
        length=length,
    )


def is_redundant(element: Element) -> bool:
    """Return whether mimic joints close a loop already, as its element says."""
    return element.attributes.get("redundant") == "true"


def _extension(extension: Extension, contents: dict[str, str]) -> Tag:
    children = (
        Tag(child.tag, **{child.attribute: contents[role]})
        for role, child in extension.children.items()
    )
    return Tag(extension.tag, *children)
