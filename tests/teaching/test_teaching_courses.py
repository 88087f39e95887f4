"""The code that the documentation gives to courses, run as a course runs it."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

import pytest

PAGE = Path(__file__).parents[2] / "docs" / "tutorials" / "grade_a_sheet.md"
CART = "(M + m) x'' + m l cos q q'' - m l sin q q'^2 + c x' = F"
POLE = "cos q x'' + l q'' + g sin q = 0"


def code_after(heading: str) -> str:
    """Return the first block of Python below a heading."""
    below = PAGE.read_text(encoding="utf-8").partition(f"## {heading}\n")[2]
    found = re.search(r"```python\n(.*?)```", below, re.DOTALL)
    assert found is not None
    return found[1]


def submit(text: str) -> dict[str, Any]:
    """Return PrairieLearn's data of a submission."""
    return {
        "params": {"system": "cart_pole"},
        "correct_answers": {},
        "submitted_answers": {"equation": text},
        "format_errors": {},
        "partial_scores": {},
        "score": 0,
        "feedback": {},
    }


@pytest.mark.parametrize(
    ("text", "score", "words"),
    [
        (f"{POLE}\n{CART}", 1.0, ""),
        (POLE, 0.5, "1 of 2 equations missing"),
        (f"{CART}\n{POLE.replace('+ g', '- g')}", 0.5, "sign of the potential of gravity"),
    ],
)
def test_the_element_for_prairielearn_grades(text: str, score: float, words: str) -> None:
    element: dict[str, Any] = {}
    exec(code_after("In PrairieLearn"), element)
    data = submit(text)
    element["parse"]("<mq-equation>", data)
    assert not data["format_errors"]
    element["grade"]("<mq-equation>", data)
    given = data["partial_scores"]["equation"]
    assert given["score"] == score
    assert given["weight"] == 1
    assert words in given["feedback"]
    shown = element["render"]("<mq-equation>", data)
    assert '<textarea name="equation"' in shown
    assert words in shown


def test_the_element_says_what_cannot_be_read() -> None:
    element: dict[str, Any] = {}
    exec(code_after("In PrairieLearn"), element)
    data = submit("(M + m x'' = <b>F")
    element["parse"]("<mq-equation>", data)
    assert "'<' has no meaning here" in data["format_errors"]["equation"]
    assert "<b>" not in element["render"]("<mq-equation>", data)


def test_the_cell_for_nbgrader_passes_a_right_answer_only() -> None:
    cell = code_after("In nbgrader")
    assert "### BEGIN HIDDEN TESTS" in cell
    exec(cell, {"answer": f"{CART}\n{POLE}"})
    with pytest.raises(AssertionError, match="1 of 2 equations missing"):
        exec(cell, {"answer": POLE})
