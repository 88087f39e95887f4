"""A guide: something not described that holds joints on the coordinate map."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import final

from mecanique.model.joints import Joint


@final
@dataclass(frozen=True)
class Guide:
    """Something not described that ties joints of a mechanism."""

    coordinates: tuple[str, ...]  # the joint coordinates it ties
    laws: tuple[str, ...]  # how they follow the generalized coordinates, e.g. "x2 = -x"
    joints: tuple[str, ...]  # the joints they belong to
    # the joints across which it may act; none if it ties the coordinates of one joint
    crossed: tuple[str, ...]

    @property
    def reason(self) -> str:
        """Why the reactions in the joints it crosses are undetermined, in a sentence."""
        return (
            f"the coordinate map guides {_enumerate(self.joints)} together "
            f"({', '.join(self.laws)}) and does not say by what: cords, gears or contacts may act "
            f"across {_enumerate(self.crossed)}"
        )


def explain_joint(guides: Sequence[Guide], joint: str) -> str:
    """Return why the reaction in a joint is undetermined; empty if no guide crosses it."""
    return "; ".join(guide.reason for guide in guides if joint in guide.crossed)


def idle_coordinates(guides: Sequence[Guide], joint: Joint) -> frozenset[str]:
    """Return the coordinates of a joint along or about which the joint itself transmits nothing.

    Left out are those that a guide of this joint alone holds, and those that turn a rotor.
    """
    if joint.followers or getattr(joint, "armature", 0.0) != 0:
        return frozenset()
    held = {name for guide in guides if not guide.crossed for name in guide.coordinates}
    return frozenset(joint.coordinates) - held


def _enumerate(words: tuple[str, ...]) -> str:
    return words[0] if len(words) == 1 else f"{', '.join(words[:-1])} and {words[-1]}"
