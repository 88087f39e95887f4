"""The register of the chapter: every equation, what it states and whether it holds as printed.

The chapter is "Fundamentals of Dynamics", ch. 1 of a text on structural dynamics. Its sentences are
paraphrased, checked where they can be computed, and listed as not checked where they are not. Rows
are computed on demand, once.
"""

from __future__ import annotations

from functools import cache
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from mecanique.verification.chapter.row import ChapterRow

__all__ = ["register"]


@cache
def register() -> tuple[ChapterRow, ...]:
    """Check the numbered equations, displayed results of Examples 1.1 and 1.2, and sentences."""
    from dataclasses import replace

    from mecanique.verification.chapter import examples, sections

    in_order = sorted(sections.rows(), key=lambda row: row.place)
    said = (*sections.sentences(), *examples.sentences(), *sections.wording())
    sentences = [replace(row, about="sentence") for row in said]
    return (*in_order, *examples.list_blocks(), *examples.list_bars(), *sentences)
