"""Find the initial state of a model; the engine closes its loops."""

from __future__ import annotations

from mecanique.model.mechanism import Mechanism
from mecanique.model.values import Given
from mecanique.reference import assemble


def start_of(mechanism: Mechanism, q: Given, v: Given) -> tuple[float, ...]:
    """Return initial coordinates with closed loops, and velocities.

    Args:
        mechanism: the mechanism.
        q: coordinates, in order or by name.
        v: velocities; the model itself makes them consistent with the loops.

    Raises:
        ClosureError: if the loops cannot be closed near the coordinates.
    """
    return (*assemble(mechanism, q).tolist(), *mechanism.velocity(v).tolist())
