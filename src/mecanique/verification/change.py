"""One difference between two descriptions, and all of them."""

from __future__ import annotations

import json
from dataclasses import asdict, dataclass
from typing import Any, final

from mecanique.wording import Legible, say_count

_MOST_LISTED = 40
"""As many changes stand in the text; JSON has all of them."""


@final
@dataclass(frozen=True, repr=False)
class Change(Legible):
    """One difference between two descriptions.

    Args:
        where: the link or joint, e.g. "link 'arm'"; empty for the whole.
        what: what differs, e.g. "mass".
        before: in the first, as words.
        after: in the second, as words.
        slip: the mistake it looks like, or empty.
        weight: relative change of the mass matrix and the bias that it alone makes; NaN if it was
            not applied alone, as with what is added or removed.
    """

    where: str
    what: str
    before: str = ""
    after: str = ""
    slip: str = ""
    weight: float = float("nan")

    def __str__(self) -> str:
        said = f"{self.where}: {self.what}" if self.where else self.what
        if self.before or self.after:
            said += f" {self.before} → {self.after}"
        return f"{said}: {self.slip}" if self.slip else said

    def to_dict(self) -> dict[str, Any]:
        """Return everything as plain data; a weight that is not known is None."""
        known = self.weight == self.weight
        return {**asdict(self), "weight": self.weight if known else None}


@final
@dataclass(frozen=True, repr=False)
class Difference(Legible):
    """What differs between two descriptions, the structure first, then by weight.

    Args:
        first: name of the first.
        second: name of the second.
        changes: what differs.
        notes: what was not compared.

    Example:
        >>> light, heavy = (mq.textbook.load("double_pendulum", m2=m) for m in (1.0, 1.5))
        >>> difference = mq.diff(light, heavy)
        >>> difference.same
        False
        >>> print(difference.changes[0])
        link 'rod2': mass 1 → 1.5 kg (+50 %)
    """

    first: str
    second: str
    changes: tuple[Change, ...]
    notes: tuple[str, ...] = ()

    @property
    def same(self) -> bool:
        """Whether nothing differs."""
        return not self.changes

    @property
    def summary(self) -> str:
        """The outcome in one sentence."""
        names = f"{self.first} and {self.second}"
        if self.same:
            return f"{names} describe the same mechanism"
        slips = sum(bool(change.slip) for change in self.changes)
        likely = f", {say_count(slips, 'likely slip')}" if slips else ""
        return f"{names}: {say_count(len(self.changes), 'difference')}{likely}"

    def to_dict(self) -> dict[str, Any]:
        """Return everything as plain data, ready for JSON."""
        rows = [change.to_dict() for change in self.changes]
        head = {"first": self.first, "second": self.second, "same": self.same}
        return {**head, "changes": rows, "notes": list(self.notes)}

    def to_json(self) -> str:
        """Return everything as JSON text."""
        return json.dumps(self.to_dict(), ensure_ascii=False, allow_nan=False, indent=2)

    def __str__(self) -> str:
        lines = []
        for change in self.changes[:_MOST_LISTED]:
            known = change.weight == change.weight
            weight = f"{100 * change.weight:8.2g} %" if known else " " * 10
            lines.append(f"{weight}  {change}")
        rest = len(self.changes) - _MOST_LISTED
        if rest > 0:
            lines.append(f"… and {rest} more in to_json(), --json")
        head = [" of M, bias"] if any(c.weight == c.weight for c in self.changes) else []
        return "\n".join([self.summary, *head, *lines, *self.notes])
