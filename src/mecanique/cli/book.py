"""Format the register of the chapter's equations for `mecanique book`."""

from __future__ import annotations

import json
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from mecanique.textbook.register.row import Row

__all__ = ["as_json", "as_text"]


def as_text(rows: tuple[Row, ...]) -> str:
    """Return the register as text, a summary first."""
    wrong = [row.number for row in rows if not row.holds]
    errors = "none in error as printed"
    if wrong:
        proven = all(row.sound for row in rows)
        sound = "each with its right form proven" if proven else "NOT ALL PROVEN"
        errors = f"{len(wrong)} in error as printed ({', '.join(wrong)}), {sound}"
    count = f"{len(rows)} rows, {len(rows) - len(wrong)} hold"
    head = f"Fundamentals of Dynamics, chapter 1: {count}, {errors}"
    return "\n".join([head, "", *map(str, rows)])


def as_json(rows: tuple[Row, ...]) -> str:
    """Return the register as JSON text."""
    return json.dumps(
        [row.to_dict() for row in rows], ensure_ascii=False, indent=2, allow_nan=False
    )
