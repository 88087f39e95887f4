"""Keep letters clear of one another and of lines: each moves a little to the best place."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from mecanique.figure.paper.marks import Circle, Mark, Point, Stroke, Words, directions

FARTHEST = 36.0
"""The farthest that a letter may move [pt]."""

AIR = 2.0
"""Margin on both sides of a word [pt]."""

_RINGS = (5.0, 10.0, 15.0, 20.0, 28.0, FARTHEST)
_WIDE_RINGS = (*_RINGS, 46.0, 58.0, 72.0, 90.0, 110.0)
_WAYS = 16
_PASSES = 2
_MOVE, _WORD = 0.6, 12.0
"""Costs of a point of moving and of a square point of another word; a point of a line costs 1."""

_FAINT = {"thin": 0.5, "dashed": 0.7, "axis": 0.6, "hatch": 0.7}
"""Cost of a point of a faint line."""

_BEFORE = {"start": 0.0, "middle": 0.5, "end": 1.0}
"""Fraction of a word to the left of its anchor."""

_HALF_HEIGHT, _FULL_HEIGHT = 0.42, 0.58
"""Of a word, in its size: of its letters, and with what hangs below and stands above them."""

_CROWDED = 6.0
"""How much more a point of a line costs among the many arrows of a free body."""

_TINY = 1e-12
"""Instead of zero, where a line is level or upright."""

_TALL = frozenset("ψ")
"""Letters that reach far below the line and above small ones."""

Boxes = NDArray[np.float64]


def clear_letters(marks: Sequence[Mark], *, crowded: bool = False) -> tuple[Mark, ...]:
    """Move the words of a figure off one another and off lines."""
    lines, weights = lines_of(marks)
    rings: Sequence[float] = _RINGS
    if crowded:
        weights, rings = np.maximum(_CROWDED * weights, _CROWDED), _WIDE_RINGS
    words = {k: mark for k, mark in enumerate(marks) if isinstance(mark, Words)}
    moved = dict(words)
    for _ in range(_PASSES):
        for k, word in words.items():
            others = [frame(rival, full=crowded) for j, rival in moved.items() if j != k]
            box = frame(word, full=crowded)
            move = _best(box, np.array(others), lines, weights, rings)
            moved[k] = replace(word, at=word.at + move)
    return tuple(moved.get(k, mark) for k, mark in enumerate(marks))


def frame(word: Words, *, full: bool = False) -> Point:
    """Return the box that a word needs, shape (4,): left, top, right, bottom [pt]."""
    x, y = word.at
    left = x - _BEFORE[word.anchor] * word.width
    right = left + word.width
    tall = full or any(not _TALL.isdisjoint(text) for text, _ in word.parts)
    half = (_FULL_HEIGHT if tall else _HALF_HEIGHT) * word.size
    return np.array([left - AIR, y - half, right + AIR, y + half])


def overlap(boxes: Boxes, others: Boxes) -> NDArray[np.float64]:
    """Return the area of each box that others cover, shape (n,) [pt²]."""
    low = np.maximum(boxes[:, None, :2], others[None, :, :2])
    high = np.minimum(boxes[:, None, 2:], others[None, :, 2:])
    areas: NDArray[np.float64] = np.maximum(high - low, 0.0).prod(axis=2).sum(axis=1)
    return areas


def _best(
    box: Point,
    others: Boxes,
    lines: NDArray[np.float64],
    weights: NDArray[np.float64],
    radii: Sequence[float],
) -> Point:
    """The cheapest move."""
    cost: float = _cost(box[None], others, lines, weights)[0]
    radii = [radius for radius in radii if _MOVE * radius < cost]  # any farther costs more
    if not radii:
        return np.zeros(2)
    ring = directions(np.arange(_WAYS) * 2 * np.pi / _WAYS)
    rings = [radius * ring for radius in radii]
    moves = np.concatenate([np.zeros((1, 2)), *rings])
    # lines that no box can reach cost nothing
    low, high = box[:2] - radii[-1], box[2:] + radii[-1]
    after = (lines.max(axis=1) >= low).all(axis=1)
    before = (lines.min(axis=1) <= high).all(axis=1)
    near = after & before
    costs = _MOVE * np.hypot(*moves.T)
    costs += _cost(box + np.tile(moves, 2), others, lines[near], weights[near])
    best: Point = moves[int(np.argmin(np.round(costs, 6)))]
    return best


def _cost(
    boxes: Boxes, others: Boxes, lines: NDArray[np.float64], weights: NDArray[np.float64]
) -> NDArray[np.float64]:
    """What it costs that boxes lie over others and over lines, shape (n,)."""
    crossed = measure_crossings(boxes, lines, weights)
    return crossed + _WORD * overlap(boxes, others) if len(others) else crossed


def measure_crossings(
    boxes: Boxes, lines: NDArray[np.float64], weights: NDArray[np.float64]
) -> NDArray[np.float64]:
    """Return the weighted length of the lines inside each box, shape (n,) [pt]."""
    step = lines[:, 1] - lines[:, 0]
    # a line start + s step is between a box's two sides for s from one to two, on either axis
    spans = []
    for axis in (0, 1):
        start, safe = lines[:, 0, axis], np.where(abs(step) > _TINY, step, _TINY)[:, axis]
        first = (boxes[:, axis, None] - start) / safe
        second = (boxes[:, axis + 2, None] - start) / safe
        spans.append((np.minimum(first, second), np.maximum(first, second)))
    (enter_x, leave_x), (enter_y, leave_y) = spans
    enter, leave = np.maximum(enter_x, enter_y), np.minimum(leave_x, leave_y)
    inside = np.minimum(leave, 1.0) - np.maximum(enter, 0.0)
    lengths = np.maximum(inside, 0.0) * np.hypot(*step.T)
    total: NDArray[np.float64] = (lengths * weights).sum(axis=1)
    return total


def lines_of(marks: Sequence[Mark]) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Return lines as segments, shape (n, 2, 2), and the cost of crossing them, shape (n,)."""
    pieces: list[NDArray[np.float64]] = [np.empty((0, 2, 2))]
    weights: list[NDArray[np.float64]] = [np.empty(0)]
    circle = directions(np.linspace(0.0, 2 * np.pi, 25))
    for mark in marks:
        if isinstance(mark, Words):
            continue
        points = mark.center + mark.radius * circle if isinstance(mark, Circle) else mark.points
        if isinstance(mark, Stroke) and mark.closed:
            points = np.concatenate([points, points[:1]])
        pieces.append(np.stack([points[:-1], points[1:]], axis=1))
        weights.append(np.full(len(points) - 1, _FAINT.get(mark.style, 1.0)))
    return np.concatenate(pieces), np.concatenate(weights)
