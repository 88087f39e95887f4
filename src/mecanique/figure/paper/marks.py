"""What a figure is made of, in points, y downwards: strokes, letters, arrows, textbook symbols."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from typing import Literal, TypeAlias, final

import numpy as np
from numpy.typing import NDArray

Point: TypeAlias = NDArray[np.float64]
"""Shape (2,), to the right and downwards [pt]."""

Anchor: TypeAlias = Literal["start", "middle", "end"]


@final
@dataclass(frozen=True)
class Style:
    """The style of a kind of mark."""

    ink: str = "#1d232b"
    night: str = "#e6e8ea"
    fill: str = ""  # color inside, empty for none
    night_fill: str = ""
    width: float = 1.2  # of the line [pt]
    dash: str = ""  # lengths of dashes and gaps [pt]


STYLES: dict[str, Style] = {
    "body": Style(fill="#dbe7f1", night_fill="#33475a", width=1.4),
    "face": Style(fill="#c3d6e6", night_fill="#3d556b", width=1.2),
    "shade": Style(fill="#aac3d8", night_fill="#48637c", width=1.2),
    "clear": Style(fill="#dbe7f180", night_fill="#33475a80", width=1.4),
    "mass": Style(fill="#f0d9a8", night_fill="#6d5a2c", width=1.4),
    "bar": Style(fill="#ffffff", night_fill="#20252c", width=1.3),
    "cable": Style(width=1.1),
    "pin": Style(fill="#ffffff", night_fill="#20252c", width=1.4),
    "ground": Style(width=1.6),
    "hatch": Style(width=0.8),
    "spring": Style(width=1.3),
    "thin": Style(ink="#6b7580", night="#9aa4b0", width=0.7),
    "dashed": Style(ink="#6b7580", night="#9aa4b0", width=0.8, dash="5 3.5"),
    "axis": Style(ink="#6b7580", night="#9aa4b0", width=0.8, dash="9 3 2 3"),
    "tip": Style(ink="", night="", fill="#6b7580", night_fill="#9aa4b0"),
    "coordinate": Style(ink="#0060a0", night="#6db9f2", width=1.1),
    "coordinate-tip": Style(ink="", night="", fill="#0060a0", night_fill="#6db9f2"),
    "force": Style(ink="#b84600", night="#ff9a5c", width=1.8),
    "force-tip": Style(ink="", night="", fill="#b84600", night_fill="#ff9a5c"),
    "inertia": Style(ink="#00704f", night="#4cc79d", width=1.8, dash="6 3.5"),
    "inertia-tip": Style(ink="", night="", fill="#00704f", night_fill="#4cc79d"),
    "letter": Style(ink="", night="", fill="#1d232b", night_fill="#e6e8ea"),
    "coordinate-letter": Style(ink="", night="", fill="#0060a0", night_fill="#6db9f2"),
    "force-letter": Style(ink="", night="", fill="#b84600", night_fill="#ff9a5c"),
    "inertia-letter": Style(ink="", night="", fill="#00704f", night_fill="#4cc79d"),
    "name": Style(ink="", night="", fill="#6b7580", night_fill="#9aa4b0"),
}
"""The kinds of marks; colors differ enough in lightness to be told apart without seeing hue."""


@final
@dataclass(frozen=True, eq=False)
class Stroke:
    """A line through points."""

    points: Point  # shape (n, 2)
    style: str
    closed: bool = False


@final
@dataclass(frozen=True, eq=False)
class Circle:
    """A circle."""

    center: Point  # shape (2,)
    radius: float  # [pt]
    style: str


@final
@dataclass(frozen=True, eq=False)
class Words:
    """A letter or a few words; their middle height is at the point."""

    at: Point  # shape (2,)
    parts: tuple[tuple[str, str], ...]
    style: str = "letter"
    anchor: Anchor = "middle"
    size: float = 15.0  # [pt]

    @property
    def width(self) -> float:
        """Approximate width [pt]."""
        return sum(
            len(text) * (0.40 if how == "below" else 0.54) * self.size for text, how in self.parts
        )


Mark: TypeAlias = Stroke | Circle | Words


def rich(text: str) -> tuple[tuple[str, str], ...]:
    """Return the name of a quantity, or a short formula in such names, in pieces."""
    import re

    from mecanique.model.mechanism.letters import GREEK, SplitName

    pieces: list[tuple[str, str]] = []
    text = text.replace("**2", "²").replace("**3", "³").replace("**", "^")
    for word, symbol in re.findall(r"([^\W\d²³][^\W²³]*'*)|([^\w]+|[\d²³][\d.]*)", text):
        if word:
            letter = SplitName.of(word)
            base = GREEK.get(letter.base, letter.base)
            pieces.append((base, "italic" if len(base) == 1 else "upright"))
            if letter.dots:
                pieces.append(("\u0307" if letter.dots == 1 else "\u0308", "italic"))
            if letter.subscript:
                pieces.append((GREEK.get(letter.subscript, letter.subscript), "below"))
        else:
            plain = symbol.replace("*", "\u2009").replace("-", "−")
            pieces.append((plain, "upright"))
    return tuple(pieces)


def bounds(marks: Iterable[Mark]) -> tuple[float, float, float, float]:
    """Return the box around marks: left, top, right, bottom [pt]."""
    corners: list[Sequence[float] | Point] = []
    for mark in marks:
        match mark:
            case Stroke(points):
                corners += [points.min(axis=0), points.max(axis=0)]
            case Circle(center, radius):
                corners += [center - radius, center + radius]
            case Words(at, _, _, anchor, size):
                left = at[0] - {"start": 0.0, "middle": 0.5, "end": 1.0}[anchor] * mark.width
                corners += [(left, at[1] - 0.6 * size), (left + mark.width, at[1] + 0.6 * size)]
    points = np.array(corners)
    (left, top), (right, bottom) = points.min(axis=0), points.max(axis=0)
    return math.floor(left), math.floor(top), math.ceil(right), math.ceil(bottom)


def unit(vector: Point) -> Point:
    """Return a vector's direction; to the right if it has no length."""
    length = math.hypot(*vector)
    direction: Point = vector / length if length > 1e-9 else np.array([1.0, 0.0])
    return direction


def across(direction: Point) -> Point:
    """Return a direction turned left by a quarter turn, as seen on paper."""
    return np.array([direction[1], -direction[0]])


def downward(direction: Point) -> Point:
    """Return a direction or its opposite, whichever points down on paper."""
    return direction if direction[1] > 0 else -direction


def directions(angles: NDArray[np.float64]) -> Point:
    """Return the directions at some angles on paper, y downwards, shape (n, 2)."""
    return np.stack([np.cos(angles), np.sin(angles)], axis=1)


def label(at: Point, text: str, away: Point, gap: float = 11.0, style: str = "letter") -> Words:
    """Return a label beside a point, on the given side."""
    parts, side = rich(text), unit(away)
    words = Words(at, parts, style)
    # half the label's extent along this direction lies between its middle and its near side
    reach = gap + abs(side[0]) * words.width / 2 + abs(side[1]) * 0.36 * words.size
    return Words(at + reach * side, parts, style)


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


def arc(points: Point, style: str) -> Iterator[Mark]:
    """Yield a bent arrow through points."""
    lengths = np.concatenate([[0.0], np.cumsum(np.hypot(*np.diff(points, axis=0).T))])
    size = min(7.5, 0.6 * float(lengths[-1]))
    if size < 1.0:
        yield Stroke(points, style)
        return
    kept = int(np.searchsorted(lengths, lengths[-1] - size))
    back = points[max(kept - 1, 0)]
    yield Stroke(points[: max(kept, 2)], style)
    yield arrow_head(points[-1], unit(points[-1] - back), size, style)


def named_arrow(
    tail: Point, tip: Point, name: str, style: str, side: Point | None = None, gap: float = 5.0
) -> Iterator[Mark]:
    """Yield a straight arrow with its name: beyond its tip, or on a side of its middle."""
    yield from arrow(tail, tip, style)
    letter = "name" if style == "thin" else f"{style}-letter"
    if side is None:
        yield label(tip, name, tip - tail, gap, letter)
    else:
        yield label((tail + tip) / 2, name, side, gap, letter)


def dimension(a: Point, b: Point, text: str, offset: float) -> Iterator[Mark]:
    """Yield a dimension line beside two points, with its witness lines and a label."""
    side = across(unit(b - a)) * math.copysign(1.0, offset)
    shift = abs(offset) * side
    for end in (a, b):
        yield Stroke(np.array([end + 4 * side, end + shift + 4 * side]), "thin")
    yield from arrow(a + shift, b + shift, "thin", double=True)
    yield label((a + b) / 2 + shift, text, side, 9.0)


def center_of_mass(at: Point, radius: float = 5.0) -> Iterator[Mark]:
    """Yield the sign of a center of mass: a disk with two black quarters."""
    yield Circle(at, radius, "pin")
    for start in (0.0, math.pi):
        rim = at + radius * directions(start + np.linspace(0.0, math.pi / 2, 9))
        yield Stroke(np.concatenate([at[None], rim]), "letter", closed=True)


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


def spiral(at: Point) -> Iterator[Mark]:
    """Yield a rotational spring about a point."""
    turns = np.linspace(0.0, 3.6 * math.pi, 90)
    radius = 5.0 + 1.15 * turns
    yield Stroke(at + radius[:, None] * directions(turns), "spring")


def hatch(a: Point, b: Point, into: Point | None = None, depth: float = 8.0) -> Iterator[Mark]:
    """Yield a line of ground, hatched into a direction, or on the right going from a to b."""
    if into is not None and float(across(unit(b - a)) @ into) > 0:
        a, b = b, a
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
        yield from hatch(foot + 18 * side, foot - 18 * side, down)
    yield Circle(at, 4.2, "pin")
