"""Arrows of figures, with their heads: straight, bent, and between the ends of a dimension."""

from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np

from mecanique.figure.paper.marks import Mark, Point, Stroke, across, label, unit


def arrow(tail: Point, tip: Point, style: str, double: bool = False) -> Iterator[Mark]:
    """Yield a straight arrow."""
    along = unit(tip - tail)
    length = math.hypot(*(tip - tail))
    head = min(8.0 if style != "thin" else 6.5, 0.6 * length)
    yield Stroke(
        np.array([tail + (0.8 * head if double else 0.0) * along, tip - 0.8 * head * along]), style
    )
    yield arrow_head(tip, along, head, style)
    if double:
        yield arrow_head(tail, -along, head, style)


def arrow_head(tip: Point, along: Point, size: float, style: str) -> Stroke:
    """Return the head of an arrow: a filled triangle with its point at the tip."""
    back, side = tip - size * along, 0.36 * size * across(along)
    name = {"thin": "tip", "axis": "tip"}.get(style, f"{style}-tip")
    return Stroke(np.array([tip, back + side, back - side]), name, closed=True)


def arc(points: Point, style: str, head: bool = True) -> Iterator[Mark]:
    """Yield a bent arrow through points."""
    lengths = np.concatenate([[0.0], np.cumsum(np.hypot(*np.diff(points, axis=0).T))])
    size = min(7.5, 0.6 * float(lengths[-1]))
    if not head or size < 1.0:
        yield Stroke(points, style)
        return
    kept = int(np.searchsorted(lengths, lengths[-1] - size))
    back = points[max(kept - 1, 0)]
    yield Stroke(points[: max(kept, 2)], style)
    yield arrow_head(points[-1], unit(points[-1] - back), size, style)


def dimension(a: Point, b: Point, text: str, offset: float) -> Iterator[Mark]:
    """Yield a dimension line beside two points, with its witness lines and a label."""
    side = across(unit(b - a)) * math.copysign(1.0, offset)
    shift = abs(offset) * side
    for end in (a, b):
        yield Stroke(np.array([end + 4 * side, end + shift + 4 * side]), "thin")
    yield from arrow(a + shift, b + shift, "thin", double=True)
    yield label((a + b) / 2 + shift, text, side, 9.0)
