"""Letters of a figure keep clear of one another and of lines."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import pytest

from mecanique.figure.mechanism import figure
from mecanique.figure.paper.lettering import FARTHEST, clear_letters, frame, overlap
from mecanique.figure.paper.marks import Circle, Mark, Stroke, Words
from mecanique.figure.setting import posture, setting
from mecanique.model.mechanism import Mechanism
from mecanique.reference import Reference
from mecanique.textbook import entry, load, names


def word(x: float, y: float, text: str = "m") -> Words:
    return Words(np.array([x, y]), ((text, "italic"),))


def line(*points: tuple[float, float], style: str = "ground") -> Stroke:
    return Stroke(np.array(points, dtype=float), style)


def places(marks: Sequence[Mark]) -> list[tuple[float, float]]:
    words = [mark for mark in marks if isinstance(mark, Words)]
    return [(float(each.at[0]), float(each.at[1])) for each in words]


def overlaps(marks: Sequence[Mark]) -> float:
    frames = np.array([frame(mark) for mark in marks if isinstance(mark, Words)]).reshape(-1, 4)
    own = np.prod(frames[:, 2:] - frames[:, :2], axis=1)
    return float((overlap(frames, frames) - own).max(initial=0.0))


def test_what_is_clear_stays() -> None:
    marks = (
        word(0, 0),
        word(40, 0),
        line((0, 20), (40, 20)),
        Circle(np.array([80.0, 0.0]), 5.0, "pin"),
    )
    assert places(clear_letters(marks)) == places(marks) == [(0, 0), (40, 0)]
    assert clear_letters(()) == ()


def test_words_are_moved_off_each_other() -> None:
    marks = (word(0, 0, "mass"), word(6, 3, "length"), word(2, -2, "k"))
    assert overlaps(marks) > 50
    moved = clear_letters(marks)
    assert overlaps(moved) == 0
    assert max(np.hypot(*np.subtract(places(moved), places(marks)).T)) <= FARTHEST


@pytest.mark.parametrize(
    "under",
    [
        line((-50, 0), (50, 0)),
        line((0, -50), (0, 50)),
        line((-30, -30), (30, 30)),
        Circle(np.zeros(2), 3.0, "pin"),
    ],
)
def test_a_word_is_moved_off_a_line_but_not_far(under: Stroke | Circle) -> None:
    moved = clear_letters((under, word(0, 0)))[1]
    assert isinstance(moved, Words)
    assert 5 <= np.hypot(*moved.at) <= 20
    left, top, right, bottom = frame(moved)
    grid = np.stack(
        np.meshgrid(np.linspace(left, right, 9), np.linspace(top, bottom, 9)), axis=-1
    ).reshape(-1, 2)
    if isinstance(under, Circle):
        assert np.abs(np.hypot(*grid.T) - 3.0).min() > 0.5
    else:
        direction = under.points[1] - under.points[0]
        sides = np.sign(np.round(grid @ np.array([-direction[1], direction[0]]), 6))
        assert len(set(sides) - {0.0}) == 1


def test_a_faint_line_matters_less() -> None:
    strong = [line((-60, y), (60, y)) for y in range(0, 60, 3)]
    faint = [line((-60, -y), (60, -y), style="axis") for y in range(3, 60, 3)]
    moved = clear_letters((*strong, *faint, word(0, 0)))[-1]
    assert isinstance(moved, Words)
    assert moved.at[1] < -5


@pytest.mark.parametrize("name", names())
def test_no_words_of_the_catalogue_overlap(name: str) -> None:
    mechanism: Mechanism = load(name)
    seen = setting(
        mechanism,
        Reference(mechanism),
        posture(mechanism, entry(name).start),
        np.zeros(mechanism.nv),
        0.0,
    )
    assert overlaps(figure(seen)) < 8
