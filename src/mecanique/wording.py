"""Words that depend on numbers, and tables of them."""

from __future__ import annotations

from collections.abc import Sequence


def say_count(count: int, noun: str, plural: str = "") -> str:
    """Return a count with its noun: "1 state", "2 states", "3 bodies".

    Args:
        count: how many.
        noun: what is counted, one of it.
        plural: several of it; with an s by default.
    """
    return f"{count} {noun if count == 1 else plural or f'{noun}s'}"


def enumerate_words(words: Sequence[str]) -> str:
    """Join words into an enumeration, the last after "and"."""
    return words[0] if len(words) == 1 else f"{', '.join(words[:-1])} and {words[-1]}"


def write_table(caption: str, rows: Sequence[Sequence[str]]) -> str:
    """Return a table in HTML, for notebooks.

    Args:
        caption: what it shows.
        rows: cells of plain text; the first row is the head.
    """
    from html import escape

    lines = []
    for tag, cells in zip(["th", *["td"] * (len(rows) - 1)], rows, strict=True):
        inner = "".join(f"<{tag}>{escape(cell)}</{tag}>" for cell in cells)
        lines.append(f"<tr>{inner}</tr>")
    return f"<table><caption>{escape(caption)}</caption>{''.join(lines)}</table>"
