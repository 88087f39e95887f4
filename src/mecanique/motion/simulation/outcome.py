"""How an integration ended."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal, TypeAlias, final

Kind: TypeAlias = Literal[
    "end",
    "event",
    "contact",
    "halt",
    "reconsider",
    "interrupted",
    "stiff",
    "too many steps",
    "step too small",
    "no headway",
    "not finite",
    "progress",
    "fault",
]


@final
@dataclass(frozen=True)
class Outcome:
    """How an integration ended, or a stretch of it.

    Args:
        kind: "end" if it came to its end, "event" if an event ended it, "contact" if impacts
            followed each other without end; "halt" if a stretch ended because its last step needs
            a correction; "reconsider" if another method may pay; "interrupted" by Ctrl-C; "stiff",
            "too many steps", "step too small" or "no headway" if the method gave up; "not finite"
            if the acceleration at the start is not; "progress" or "fault" if `progress`, or the
            equations, raised an exception.
        fault: what was raised.
    """

    kind: Kind
    fault: BaseException | None = None

    @property
    def complete(self) -> bool:
        """Whether the motion ends where it should."""
        return self.kind in ("end", "event")

    @property
    def accurate(self) -> bool:
        """Whether the equations are defined up to the last step, so that it can be refined."""
        return self.kind in ("end", "event", "contact")
