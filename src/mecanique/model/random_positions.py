"""Random positions of a mechanism, drawn alike wherever some are needed."""

from __future__ import annotations

import numpy as np

from mecanique.model.mechanism import Mechanism
from mecanique.model.mechanism.description import angles

_NEAR_LIMIT = 0.05
"""A coordinate limited on both sides is kept off its limits by this part of their distance."""


def draw_positions(
    mechanism: Mechanism, count: int, random: np.random.Generator, length: float
) -> np.ndarray:
    """Return positions, shape (n, nq): angles in (−π, π), unit quaternions, all within limits.

    Units: length [m].
    """
    angular = angles(mechanism)
    reach = np.array([np.pi if name in angular else length for name in mechanism.coordinates])
    low, high = -reach, reach.copy()
    for name, (lower, upper) in mechanism.limits.items():
        k = mechanism.coordinates.index(name)
        if np.isfinite([lower, upper]).all():
            low[k], high[k] = (
                lower + _NEAR_LIMIT * (upper - lower),
                upper - _NEAR_LIMIT * (upper - lower),
            )
        else:
            low[k], high[k] = max(lower, low[k]), min(upper, high[k])
            if not low[k] < high[k]:
                middle = mechanism.neutral()[k]
                low[k], high[k] = (
                    (lower, 2 * middle - lower)
                    if np.isfinite(lower)
                    else (2 * middle - upper, upper)
                )
    q = random.uniform(low, high, (count, mechanism.nq))
    for _, at in mechanism.quaternions:
        q[:, at] = random.normal(size=(count, 4))
    return mechanism.normalize(q)
