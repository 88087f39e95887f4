"""How a motion shows itself in a notebook: as told by whoever can draw it.

Pictures lie above motions and are never imported from here; their room names a function once, when
it is imported.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

__all__ = ["html", "shown_by"]

_makers: list[Callable[[Any], str]] = []


def shown_by(maker: Callable[[Any], str]) -> None:
    """Name the function that gives a motion's HTML; the last one named counts.

    Args:
        maker: called with the motion.
    """
    _makers[:] = [maker]


def html(motion: Any) -> str | None:
    """Return a motion as HTML, or None if nobody can draw it.

    Args:
        motion: the `Motion`.
    """
    return _makers[0](motion) if _makers else None
