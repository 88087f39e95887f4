"""The named indeterminates that series are written in."""

from __future__ import annotations

from dataclasses import dataclass
from enum import Enum
from typing import final

__all__ = ["Generator", "Kind"]


class Kind(Enum):
    """What a generator of a ring stands for."""

    PARAMETER = "parameter"
    COORDINATE = "coordinate"
    VELOCITY = "velocity"
    ACCELERATION = "acceleration"
    INPUT = "input"
    TIME = "time"
    CONSTANT = "constant"
    ATOM = "atom"
    REACTION = "reaction"
    VARIATION = "virtual displacement"


@final
@dataclass(frozen=True)
class Generator:
    """A named indeterminate of a ring.

    Args:
        name: its name, e.g. "q", "q'" for a velocity, "q''" for an acceleration.
        kind: what it stands for.
        index: its place in monomials.
    """

    name: str
    kind: Kind
    index: int
