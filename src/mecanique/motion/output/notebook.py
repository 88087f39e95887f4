"""Show a motion in a notebook, using the function registered to draw it.

Pictures lie above motions and are never imported from here; their room names a function once, when
it is imported.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from mecanique.motion.record.motion import Motion


_makers: list[Callable[[Motion], str]] = []


def shown_by(maker: Callable[[Motion], str]) -> None:
    """Name the function that gives a motion's HTML; the last one named counts."""
    _makers[:] = [maker]


def html(motion: Motion) -> str | None:
    """Return a motion as HTML, or None if no maker is named."""
    return _makers[0](motion) if _makers else None
