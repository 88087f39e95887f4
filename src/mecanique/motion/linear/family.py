"""Equilibria that belong to a family: coordinates that may have any value."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from mecanique.arrays import Array
from mecanique.errors import MecaniqueError

if TYPE_CHECKING:
    from mecanique.reference import Reference


STEPS = (-1.7, -0.4, 0.6, 2.1)
"""By how much a coordinate is changed [rad or m]."""

SMALL = 1e-9
"""Accelerations of this part of those that other changes cause are rounding."""

_NAMED = 4  # coordinates


def find_family(reference: Reference, q: Array, t: float) -> tuple[str, ...]:
    """Return the coordinates that may each have any value at rest; none where q is constrained."""
    mechanism = reference.mechanism
    if mechanism.constrained or len(q) != mechanism.nv:
        return ()
    still = np.zeros(mechanism.nv)
    disturbed = np.full(len(q), np.inf)
    for k in range(len(q)):
        try:
            moved = [np.array(q) + step * np.eye(len(q))[k] for step in STEPS]
            accelerations = [reference.acceleration(position, still, t=t) for position in moved]
        except MecaniqueError:
            continue  # beyond its limits, or in a singular position
        disturbed[k] = np.abs(accelerations).max()
    known = disturbed[np.isfinite(disturbed)]
    limit = SMALL * max(1.0, known.max(initial=0.0))
    pairs = zip(mechanism.coordinates, disturbed, strict=True)
    return tuple(name for name, size in pairs if size < limit)


def say_family(names: tuple[str, ...]) -> str:
    """Return what is added to a sentence about an equilibrium; nothing if it stands alone."""
    if not names:
        return ""
    listed = ", ".join(names[:_NAMED])
    if len(names) > _NAMED:
        listed += f" and {len(names) - _NAMED} more"
    return f"; it is one of a family, with any value of {listed}"
