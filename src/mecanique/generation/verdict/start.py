"""The state from which a model starts: the engine closes its loops."""

from __future__ import annotations

from mecanique.model.mechanism import Mechanism
from mecanique.model.values import Given
from mecanique.reference import assemble

__all__ = ["start_of"]


def start_of(mechanism: Mechanism, q: Given, v: Given) -> tuple[float, ...]:
    """Return coordinates and velocities, with closed loops.

    Args:
        mechanism: what starts.
        q: coordinates, in order or by name.
        v: velocities; the model itself brings them onto the loops.

    Raises:
        ClosureError: if the loops cannot be closed near the coordinates.
    """
    return (*assemble(mechanism, q).tolist(), *mechanism.velocity(v).tolist())
