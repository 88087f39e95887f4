"""Formulas from books and papers: the verdict on each, and the page that lists them."""

from __future__ import annotations

import sys
from pathlib import Path

import pytest

sys.path.insert(0, str(Path(__file__).parent))

from papers import PAPERS, Paper, page, verdict

PAGE = Path(__file__).parents[2] / "docs" / "papers.md"


def test_there_are_enough_with_sources_and_not_all_are_right() -> None:
    assert len(PAPERS) >= 30
    assert all(paper.source for paper in PAPERS)
    assert len({paper.outcome for paper in PAPERS}) >= 3


@pytest.mark.parametrize("paper", PAPERS, ids=lambda paper: f"{paper.source}: {paper.what}")
def test_a_printed_formula_has_its_verdict(paper: Paper) -> None:
    found = verdict(paper)
    assert found.outcome == paper.outcome, str(found)
    assert any(paper.cause in cause.text for cause in found.causes[:3]) or not paper.cause


def test_the_page_is_true() -> None:
    """After a change: print(papers.page(), end='') into docs/papers.md."""
    assert PAGE.read_text(encoding="utf-8") == page()
