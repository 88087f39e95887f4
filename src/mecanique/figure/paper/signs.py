"""The signs of textbook figures: springs, dashpots, pins, hatching, arrows, arcs, dimensions."""

from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np

from mecanique.figure.paper.marks import Circle, Mark, Point, Stroke, Words, rich


def unit(vector: Point) -> Point:
    """Return a vector's direction; to the right if it has no length.

    Args:
        vector: shape (2,).
    """
    length = math.hypot(*vector)
    direction: Point = vector / length if length > 1e-9 else np.array([1.0, 0.0])
    return direction


def across(direction: Point) -> Point:
    """Return a direction turned left by a quarter turn, as seen on paper.

    Args:
        direction: shape (2,).
    """
    return np.array([direction[1], -direction[0]])


def label(at: Point, text: str, away: Point, gap: float = 11.0, style: str = "letter") -> Words:
    """Return a label beside a point, on the given side.

    Args:
        at: shape (2,).
        text: the name of a quantity, or a formula.
        away: shape (2,), the direction from the point to the label.
        gap: from the point to the label's near side [pt].
        style: of the words.
    """
    parts, side = rich(text), unit(away)
    words = Words(at, parts, style)
    # half the label's extent along this direction lies between its middle and its near side
    reach = gap + abs(side[0]) * words.width / 2 + abs(side[1]) * 0.36 * words.size
    return Words(at + reach * side, parts, style)


def arrow(tail: Point, tip: Point, style: str, double: bool = False) -> Iterator[Mark]:
    """Yield a straight arrow.

    Args:
        tail: shape (2,).
        tip: shape (2,).
        style: of the shaft; the head has this style's tip.
        double: whether it has a head at both ends.
    """
    along = unit(tip - tail)
    length = math.hypot(*(tip - tail))
    head = min(8.0 if style != "thin" else 6.5, 0.6 * length)
    yield Stroke(
        np.array([tail + (0.8 * head if double else 0.0) * along, tip - 0.8 * head * along]), style
    )
    yield _head(tip, along, head, style)
    if double:
        yield _head(tail, -along, head, style)


def _head(tip: Point, along: Point, size: float, style: str) -> Stroke:
    back, side = tip - size * along, 0.36 * size * across(along)
    name = {"thin": "tip", "axis": "tip"}.get(style, f"{style}-tip")
    return Stroke(np.array([tip, back + side, back - side]), name, closed=True)


def arc(points: Point, style: str, head: bool = True) -> Iterator[Mark]:
    """Yield a bent arrow through points.

    Args:
        points: shape (n, 2), dense.
        style: of the line.
        head: whether it ends in a head.
    """
    lengths = np.concatenate([[0.0], np.cumsum(np.hypot(*np.diff(points, axis=0).T))])
    size = min(7.5, 0.6 * float(lengths[-1]))
    if not head or size < 1.0:
        yield Stroke(points, style)
        return
    kept = int(np.searchsorted(lengths, lengths[-1] - size))
    back = points[max(kept - 1, 0)]
    yield Stroke(points[: max(kept, 2)], style)
    yield _head(points[-1], unit(points[-1] - back), size, style)


def dimension(a: Point, b: Point, text: str, offset: float) -> Iterator[Mark]:
    """Yield a dimension line beside two points, with its witness lines and a label.

    Args:
        a: shape (2,).
        b: shape (2,).
        text: what the distance is called.
        offset: distance to the left of the line from a to b [pt].
    """
    side = across(unit(b - a)) * math.copysign(1.0, offset)
    shift = abs(offset) * side
    for end in (a, b):
        yield Stroke(np.array([end + 4 * side, end + shift + 4 * side]), "thin")
    yield from arrow(a + shift, b + shift, "thin", double=True)
    yield label((a + b) / 2 + shift, text, side, 9.0)


def spring(a: Point, b: Point, half: float = 6.5) -> Iterator[Mark]:
    """Yield a zigzag between two points.

    Args:
        a: shape (2,).
        b: shape (2,).
        half: half its width [pt].
    """
    along, length = unit(b - a), math.hypot(*(b - a))
    side, coils = across(along), min(max(round(length / 15.0), 4), 10)
    lead = min(12.0, 0.15 * length)
    inner = length - 2 * lead
    points = [a, a + lead * along]
    for k in range(2 * coils):
        points.append(
            a
            + (lead + inner * (k + 0.5) / (2 * coils)) * along
            + (half if k % 2 == 0 else -half) * side
        )
    yield Stroke(np.array([*points, b - lead * along, b]), "spring")


def dashpot(a: Point, b: Point, half: float = 6.0) -> Iterator[Mark]:
    """Yield a damper between two points: a cup and a piston.

    Args:
        a: shape (2,), the cup's end.
        b: shape (2,), the piston's end.
        half: half the cup's width [pt].
    """
    along, length = unit(b - a), math.hypot(*(b - a))
    side = across(along)
    cup = min(18.0, 0.35 * length)
    base, rim = a + (0.5 * length - 0.5 * cup) * along, a + (0.5 * length + 0.5 * cup) * along
    yield Stroke(np.array([a, base]), "spring")
    yield Stroke(
        np.array([rim + half * side, base + half * side, base - half * side, rim - half * side]),
        "spring",
    )
    piston = (base + rim) / 2
    yield Stroke(np.array([piston + 0.75 * half * side, piston - 0.75 * half * side]), "spring")
    yield Stroke(np.array([piston, b]), "spring")


def spiral(at: Point, start: float) -> Iterator[Mark]:
    """Yield a rotational spring about a point.

    Args:
        at: shape (2,).
        start: angle on paper where it begins [rad].
    """
    turns = np.linspace(0.0, 3.6 * math.pi, 90)
    radius = 5.0 + 1.15 * turns
    points = at + radius[:, None] * np.stack([np.cos(start + turns), np.sin(start + turns)], axis=1)
    yield Stroke(points, "spring")


def hatch(a: Point, b: Point, depth: float = 8.0) -> Iterator[Mark]:
    """Yield a line of ground, hatched on the right going from a to b.

    Args:
        a: shape (2,).
        b: shape (2,).
        depth: of the hatching [pt].
    """
    along, length = unit(b - a), math.hypot(*(b - a))
    below = -across(along)
    count = max(2, round(length / 7.0))
    yield Stroke(np.array([a, b]), "ground")
    for k in range(1, count + 1):
        top = a + (length * k / count) * along
        yield Stroke(np.array([top, top + depth * (below - 0.8 * along)]), "hatch")


def pin(at: Point, towards: Point | None = None) -> Iterator[Mark]:
    """Yield a hinge, and the support that holds it.

    Args:
        at: shape (2,).
        towards: shape (2,), the direction from the hinge to the ground; None for a hinge between
            two bodies.
    """
    if towards is not None:
        down = unit(towards)
        side = across(down)
        foot = at + 17 * down
        yield Stroke(np.array([at, foot + 10 * side, foot - 10 * side]), "pin", closed=True)
        # the ground lies beyond the foot: to the right, starting from its left end
        yield from (
            hatch(foot + 18 * side, foot - 18 * side)
            if _right(down, side)
            else hatch(foot - 18 * side, foot + 18 * side)
        )
    yield Circle(at, 4.2, "pin")


def _right(down: Point, side: Point) -> bool:
    """Whether the line from +side to −side has the ground on its right."""
    return float(-across(-side) @ down) > 0
