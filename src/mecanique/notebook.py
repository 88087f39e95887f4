"""Show a mechanism in a notebook, by the function registered for drawing it.

Pictures lie above the model and are never imported from here; their room names a function once,
when it is imported.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

_makers: list[Callable[[Any], str | None]] = []


def drawn_by(maker: Callable[[Any], str | None]) -> None:
    """Name the function that gives a mechanism's figure in HTML; the last one named counts."""
    _makers[:] = [maker]


def draw(mechanism: Any) -> str | None:
    """Return the figure of a mechanism in HTML, or None if no maker is named or it cannot."""
    return _makers[0](mechanism) if _makers else None
