"""The symbols of textbook figures: springs, dashpots, hinges, hatched ground."""

from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np

from mecanique.figure.paper.marks import Circle, Mark, Point, Stroke, across, unit


def spring(a: Point, b: Point, half: float = 6.5) -> Iterator[Mark]:
    """Yield a zigzag between two points."""
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
    """Yield a damper between two points: a cup at a, a piston at b, half as wide as given [pt]."""
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
    """Yield a rotational spring about a point."""
    turns = np.linspace(0.0, 3.6 * math.pi, 90)
    radius = 5.0 + 1.15 * turns
    points = at + radius[:, None] * np.stack([np.cos(start + turns), np.sin(start + turns)], axis=1)
    yield Stroke(points, "spring")


def hatch(a: Point, b: Point, depth: float = 8.0) -> Iterator[Mark]:
    """Yield a line of ground, hatched on the right going from a to b, to a depth [pt]."""
    along, length = unit(b - a), math.hypot(*(b - a))
    below = -across(along)
    count = max(2, round(length / 7.0))
    yield Stroke(np.array([a, b]), "ground")
    for k in range(1, count + 1):
        top = a + (length * k / count) * along
        yield Stroke(np.array([top, top + depth * (below - 0.8 * along)]), "hatch")


def pin(at: Point, towards: Point | None = None) -> Iterator[Mark]:
    """Yield a hinge, and the support that holds it."""
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
