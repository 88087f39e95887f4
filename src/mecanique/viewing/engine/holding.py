"""Where contacts and cords cease to hold, on a page as in `simulate`."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

from mecanique.generation.mechanics.dynamics import Dynamics
from mecanique.generation.mechanics.free_body_forces import Actions
from mecanique.model.constraints.contacts import Rolling
from mecanique.model.constraints.cords import Belt, Cord
from mecanique.motion.record.events import break_names


def margins_of(dynamics: Dynamics, actions: Actions) -> Iterator[tuple[str, tuple[Any, Any, Any]]]:
    """Yield what holds until a margin a − √(b² + c²) passes zero: its name, and a, b, c [N].

    Args:
        dynamics: of the mechanism.
        actions: the forces in it.
    """
    mechanism, letters = dynamics.letters.mechanism, dynamics.letters
    margins: list[tuple[Any, Any, Any]] = []
    rolling = [each for each in mechanism.contacts if isinstance(each, Rolling)]
    if rolling:
        multipliers = dict(zip(dynamics.loops.names, dynamics.multipliers, strict=True))
        for contact in rolling:
            N, x, y = (multipliers[f"{contact.name}: {row}"] for row in contact.rows)
            margins.append((N, 0.0, 0.0))
            if contact.friction is not None:
                most = letters.arithmetic(contact.friction, letters.values) * N
                margins.append((most, x, y))
    cords = [each for each in mechanism.elements if isinstance(each, (Cord, Belt))]
    tensions = [actions.guide_sizes[name] for cord in cords for name in cord.forces]
    margins += [(tension, 0.0, 0.0) for tension in tensions]
    yield from zip(break_names(mechanism), margins, strict=True)
