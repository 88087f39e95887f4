"""Show mechanisms and motions in a notebook, by the functions registered for drawing them.

Pictures lie above what they show and are never imported from here; their room names a function for
each once, when it is imported.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, Literal, TypeAlias

_Shown: TypeAlias = Literal["mechanism", "motion"]

_makers: dict[_Shown, Callable[[Any], str | None]] = {}


def drawn_by(what: _Shown, maker: Callable[[Any], str | None]) -> None:
    """Name the function that shows such an object in HTML; the last one named counts."""
    _makers[what] = maker


def draw(what: _Shown, shown: Any) -> str | None:
    """Return an object in HTML, or None if no maker is named or it cannot."""
    return _makers[what](shown) if what in _makers else None
