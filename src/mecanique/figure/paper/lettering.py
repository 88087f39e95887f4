"""Keep letters clear of one another and of lines: each moves a little to the best place."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from mecanique.figure.paper.marks import Circle, Mark, Point, Stroke, Words

__all__ = ["clear_letters", "frame", "overlap"]

FARTHEST = 36.0
"""The farthest that a letter may move [pt]."""

AIR = 2.0
"""Margin on both sides of a word [pt]."""

_RINGS = (5.0, 10.0, 15.0, 20.0, 28.0, FARTHEST)
_WAYS = 16
_PASSES = 2
_MOVE, _WORD = 0.6, 12.0
"""Costs of a point of moving and of a square point of another word; a point of a line costs 1."""

_FAINT = {"thin": 0.5, "dashed": 0.5, "axis": 0.4, "hatch": 0.7}

Boxes = NDArray[np.float64]


def clear_letters(marks: Sequence[Mark]) -> tuple[Mark, ...]:
    """Move the words of a figure off one another and off lines."""
    placed = list(marks)
    lines, weights = _lines(marks)
    numbers = [k for k, mark in enumerate(marks) if isinstance(mark, Words)]
    for _ in range(_PASSES):
        for k in numbers:
            word, first = placed[k], marks[k]
            if not (isinstance(word, Words) and isinstance(first, Words)):
                continue
            others = [
                frame(other) for j in numbers if j != k and isinstance(other := placed[j], Words)
            ]
            placed[k] = replace(
                first, at=first.at + _best(frame(first), np.array(others), lines, weights)
            )
    return tuple(placed)


def frame(word: Words) -> Point:
    """Return the box that a word needs, shape (4,): left, top, right, bottom [pt]."""
    left = word.at[0] - {"start": 0.0, "middle": 0.5, "end": 1.0}[word.anchor] * word.width
    top, bottom = word.at[1] - 0.42 * word.size, word.at[1] + 0.42 * word.size
    return np.array([left - AIR, top, left + word.width + AIR, bottom])


def overlap(boxes: Boxes, others: Boxes) -> NDArray[np.float64]:
    """Return the area of each box that others cover, shape (n,) [pt²].

    Args:
        boxes: shape (n, 4).
        others: shape (m, 4).
    """
    low = np.maximum(boxes[:, None, :2], others[None, :, :2])
    high = np.minimum(boxes[:, None, 2:], others[None, :, 2:])
    areas: NDArray[np.float64] = np.maximum(high - low, 0.0).prod(axis=2).sum(axis=1)
    return areas


def _best(
    box: Point, others: Boxes, lines: NDArray[np.float64], weights: NDArray[np.float64]
) -> Point:
    """The cheapest move."""
    angles = np.arange(_WAYS) * 2 * np.pi / _WAYS
    ring = np.stack([np.cos(angles), np.sin(angles)], axis=1)
    moves = np.concatenate([np.zeros((1, 2)), *(radius * ring for radius in _RINGS)])
    boxes = box + np.tile(moves, 2)
    room = np.array([-FARTHEST, -FARTHEST, FARTHEST, FARTHEST]) + box
    near = (lines.max(axis=1) >= room[:2]).all(axis=1) & (lines.min(axis=1) <= room[2:]).all(axis=1)
    cost = _MOVE * np.hypot(*moves.T) + _measure_crossings(boxes, lines[near], weights[near])
    if len(others):
        cost += _WORD * overlap(boxes, others)
    best: Point = moves[int(np.argmin(np.round(cost, 6)))]
    return best


def _measure_crossings(
    boxes: Boxes, lines: NDArray[np.float64], weights: NDArray[np.float64]
) -> NDArray[np.float64]:
    """The weighted length of the lines inside each box, shape (n,)."""
    start, step = lines[None, :, 0], (lines[:, 1] - lines[:, 0])[None]
    safe = np.where(np.abs(step) > 1e-12, step, 1e-12)
    one, two = (boxes[:, None, :2] - start) / safe, (boxes[:, None, 2:] - start) / safe
    enter = np.maximum(np.minimum(one, two).max(axis=2), 0.0)
    leave = np.minimum(np.maximum(one, two).min(axis=2), 1.0)
    lengths = np.maximum(leave - enter, 0.0) * np.hypot(*np.moveaxis(step, 2, 0))
    total: NDArray[np.float64] = (lengths * weights).sum(axis=1)
    return total


def _lines(marks: Sequence[Mark]) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """A figure's lines as segments, shape (n, 2, 2), and the cost of crossing them, shape (n,)."""
    pieces: list[NDArray[np.float64]] = [np.empty((0, 2, 2))]
    weights: list[NDArray[np.float64]] = [np.empty(0)]
    turn = np.linspace(0.0, 2 * np.pi, 25)
    circle = np.stack([np.cos(turn), np.sin(turn)], axis=1)
    for mark in marks:
        if isinstance(mark, Words):
            continue
        points = mark.center + mark.radius * circle if isinstance(mark, Circle) else mark.points
        if isinstance(mark, Stroke) and mark.closed:
            points = np.concatenate([points, points[:1]])
        pieces.append(np.stack([points[:-1], points[1:]], axis=1))
        weights.append(np.full(len(points) - 1, _FAINT.get(mark.style, 1.0)))
    return np.concatenate(pieces), np.concatenate(weights)
