"""Pictures of a motion: the scene as pure data, one offline page, a live view.

Importing this package lets motions show themselves in notebooks.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from mecanique.motion.output.notebook import shown_by

if TYPE_CHECKING:
    from mecanique.motion.record.motion import Motion

__all__: list[str] = []


def _frame(motion: Motion) -> str:
    from mecanique.viewing.show import frame

    return frame(motion)


shown_by(_frame)
