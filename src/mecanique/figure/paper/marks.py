"""Strokes, circles and letters on paper, in points, y downwards: what a figure is made of."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
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

    from mecanique.derivation.printing.letters import GREEK, SplitName

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


def label(at: Point, text: str, away: Point, gap: float = 11.0, style: str = "letter") -> Words:
    """Return a label beside a point, on the given side."""
    parts, side = rich(text), unit(away)
    words = Words(at, parts, style)
    # half the label's extent along this direction lies between its middle and its near side
    reach = gap + abs(side[0]) * words.width / 2 + abs(side[1]) * 0.36 * words.size
    return Words(at + reach * side, parts, style)
