"""Format the register of the chapter's equations for `mecanique book`."""

from __future__ import annotations

import json
from collections.abc import Sequence
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from mecanique.verification.chapter.row import Row


_KINDS = ("equation", "sentence")


def as_text(rows: tuple[Row, ...]) -> str:
    """Return the register as text, a summary first."""
    checked = [row for row in rows if row.holds is not None]
    parts = [_count(kind, checked) for kind in _KINDS]
    left = len(rows) - len(checked)
    head = f"Fundamentals of Dynamics, chapter 1: {'; '.join(parts)}; {left} points not checked"
    return "\n".join([head, "", *map(str, rows)])


def as_json(rows: tuple[Row, ...]) -> str:
    """Return the register as JSON text."""
    return json.dumps(
        [row.to_dict() for row in rows], ensure_ascii=False, indent=2, allow_nan=False
    )


def _count(kind: str, checked: Sequence[Row]) -> str:
    """How many equations or sentences there are, and which are in error."""
    rows = [row for row in checked if row.about == kind]
    wrong = [row.number for row in rows if not row.holds]
    errors = "none in error as printed"
    if wrong:
        sound = "NOT ALL PROVEN"
        if all(row.sound for row in rows):
            sound = "each with its right form" + (" proven" if kind == "equation" else "")
        errors = f"{len(wrong)} in error as printed ({', '.join(wrong)}), {sound}"
    return f"{len(rows)} {kind}s, {len(rows) - len(wrong)} hold, {errors}"
