"""What an engine makes of the file itself."""

from __future__ import annotations

import math
from dataclasses import asdict, dataclass
from typing import Any, final

from mecanique.wording import say_count

TOLERANCE = 1e-6
"""A larger relative difference is one of what was read, not of how it is computed."""

_MOST_LISTED = 6
"""As many sentences on one engine's reading stand in the text of a verdict."""


@final
@dataclass(frozen=True)
class EngineReading:
    """What an engine makes of the file itself.

    Args:
        engine: its name, e.g. "Pinocchio 4.1.0".
        worst: the largest relative difference in mass matrix and bias; None if it was not compared.
        refused: why the engine does not read the file, or empty.
        remarks: what differs, with lines and reasons.
        missing: what to install so that the engine can read the file, or empty.
    """

    engine: str
    worst: float | None
    refused: str = ""
    remarks: tuple[str, ...] = ()
    missing: str = ""

    @property
    def differs(self) -> bool:
        """Whether it reads something else than mecanique."""
        return self.worst is not None and not self.worst <= TOLERANCE

    @property
    def said(self) -> str:
        """What it does with the file in a few words; empty if it reads it as mecanique does."""
        if self.missing:
            return f"{self.engine} did not read the file: it is not installed"
        if self.refused:
            return f"{self.engine} refuses the file itself"
        return f"{self.engine} reads the file itself otherwise" if self.differs else ""

    def to_dict(self) -> dict[str, Any]:
        """Return everything as plain data, ready for JSON."""
        known = self.worst is not None and math.isfinite(self.worst)
        return {**asdict(self), "worst": self.worst if known else None, "differs": self.differs}

    def sentences(self) -> tuple[str, ...]:
        """Return the remarks on it; none if it reads the file as mecanique does."""
        head = self.said
        if self.missing:
            return (f"{head} ({self.missing})",)
        if self.refused:
            return (f"{head}: {self.refused}", *self.remarks)
        if not self.differs:
            return ()
        if self.worst is not None and math.isfinite(self.worst):
            head += f": its M and bias differ by up to {100 * self.worst:.2g} %"
        rest = len(self.remarks) - _MOST_LISTED
        more = (f"… and {say_count(rest, 'remark')} more in --json",) if rest > 0 else ()
        return (head, *self.remarks[:_MOST_LISTED], *more)
