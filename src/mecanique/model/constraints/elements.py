"""Elements that guide: cords over pulleys, belts, gears and racks, and pins that the map closes.

An element holds bodies on the coordinate map by forces of its own. Each of its forces is unknown in
size, and acts along a line that follows from where the bodies are; none does work in a virtual
displacement, for the map moves the bodies as the element lets them move.
"""

from __future__ import annotations

from typing import NamedTuple, TypeAlias

from mecanique.model.constraints.cords import Belt, Cord
from mecanique.model.constraints.gears import Gear, Rack
from mecanique.model.constraints.loops import Loop
from mecanique.model.expression import Scalar

Element: TypeAlias = Cord | Belt | Gear | Rack | Loop


class Preload(NamedTuple):
    """Sum of a belt's tensions."""

    forces: range  # which of the mechanism's unknown forces they are
    total: Scalar  # their sum [N]


def force_names(elements: tuple[Element, ...]) -> tuple[str, ...]:
    """Return the names of the unknown forces of some elements, in order.

    Those of a loop are its rows, "loop: motion it closes".
    """
    return tuple(name for element in elements for name in element.forces)


def preloads(elements: tuple[Element, ...]) -> list[Preload]:
    """Return what is stated about the tensions of belts."""
    stated, first = list[Preload](), 0
    for element in elements:
        count = len(element.forces)
        if isinstance(element, Belt) and element.preload is not None:
            stated.append(Preload(range(first, first + count), count * element.preload))
        first += count
    return stated
