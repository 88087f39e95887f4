"""Show a motion: as a scene of pure data, one offline page, or a live view.

Importing this package lets motions and mechanisms show themselves in notebooks.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from mecanique.notebook import drawn_by

if TYPE_CHECKING:
    from mecanique.model.mechanism import Mechanism
    from mecanique.motion.motion import Motion

__all__: list[str] = []


def _frame(motion: Motion) -> str:
    from mecanique.viewing.show import frame

    return frame(motion)


def _draw(mechanism: Mechanism) -> str | None:
    from mecanique.errors import MecaniqueError
    from mecanique.figure.draw import figure_text

    try:
        return figure_text(mechanism)
    except (MecaniqueError, ImportError):
        return None


drawn_by("motion", _frame)
drawn_by("mechanism", _draw)
