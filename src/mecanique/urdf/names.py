"""Give things names that are not taken yet."""

from __future__ import annotations

from collections.abc import Iterable
from typing import final


@final
class Names:
    """Give each thing a name of its own, none of those taken."""

    def __init__(self, taken: Iterable[str] = ()) -> None:
        self._taken = set(taken)
        self._count: dict[str, int] = {}

    def free(self, name: str) -> str:
        """Return the name, or the first free one of name_2, name_3 …, and mark it as taken."""
        chosen = name
        while chosen in self._taken:
            self._count[name] = self._count.get(name, 1) + 1
            chosen = f"{name}_{self._count[name]}"
        self._taken.add(chosen)
        return chosen
