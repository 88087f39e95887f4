"""Compute the momenta of a set of bodies from their poses, rates and mass moments."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np


def momenta(
    H: Sequence[np.ndarray], Hd: Sequence[np.ndarray], J: Sequence[np.ndarray], n: int
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return the linear momentum, and the angular ones about origin and center of mass."""
    # Each has shape (n, 3). Ḣ J Hᵀ contains ∫ ẋ dm and ∫ ẋ xᵀ dm, whose skew part is the angular
    # momentum ∫ x × ẋ dm (Goldstein, Classical Mechanics, 1980, sect. 1-2).
    # Shapes: H (n, 4, 4), Hd [1/s], J (4, 4)
    if not H:
        zero = np.zeros((n, 3))
        return zero, zero, zero
    K = sum(
        (rate @ moments) @ np.swapaxes(pose, -1, -2)
        for pose, rate, moments in zip(H, Hd, J, strict=True)
    )
    first = sum((pose @ moments)[:, :3, 3] for pose, moments in zip(H, J, strict=True))
    mass = sum(moments[3, 3] for moments in J)
    linear = K[:, :3, 3]
    skew = K - np.swapaxes(K, -1, -2)
    angular = np.stack([skew[:, 2, 1], skew[:, 0, 2], skew[:, 1, 0]], axis=-1)
    center = first / mass if mass else first
    return linear, angular, angular - np.cross(center, linear)
