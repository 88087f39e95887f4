"""A likely cause of a difference between two sources."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, final

REMOVED = 1e-8
"""A relative difference below this counts as removed."""


@final
@dataclass(frozen=True)
class Cause:
    """A likely cause of a difference.

    Args:
        kind: of the mistake, e.g. "armature".
        where: link, joint or coordinate; empty for the whole mechanism.
        text: what the other source seems to do, in words.
        before: relative difference without the change.
        after: relative difference with it.
        alike: what explains the difference as well and cannot be told apart from it.
        parts: the two mistakes that explain it together, if no single one does.
    """

    kind: str
    where: str
    text: str
    before: float
    after: float
    alike: tuple[Cause, ...] = ()
    parts: tuple[Cause, ...] = ()

    @property
    def removes(self) -> bool:
        """Whether the change removes the difference."""
        return self.after <= REMOVED

    def to_dict(self) -> dict[str, Any]:
        """Return everything as plain data."""
        return {
            "kind": self.kind,
            "where": self.where,
            "text": self.text,
            "before": self.before,
            "after": self.after,
            "alike": [cause.to_dict() for cause in self.alike],
            "parts": [cause.to_dict() for cause in self.parts],
        }

    def __str__(self) -> str:
        left = f"the difference falls from {self.before:.1e} to {self.after:.1e}"
        others = (
            f"; cannot be told apart from: {'; '.join(cause.text for cause in self.alike)}"
            if self.alike
            else ""
        )
        return f"{self.text} ({left}){others}"
