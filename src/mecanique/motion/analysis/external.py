"""The external forces: weights, loads, springs to the ground, and the ground's support.

Only what crosses the boundary between the ground and everything else counts; forces between two
moving bodies cancel (Newton's third law).
"""

from __future__ import annotations

from typing import TYPE_CHECKING, final

import numpy as np

from mecanique.model.mechanism import Mechanism
from mecanique.motion.analysis.forces import Actions

if TYPE_CHECKING:
    from mecanique.reference import Reference

__all__ = ["External"]


@final
class External:
    """Resultant external force and moment, batched over states.

    Args:
        mechanism: what moves.
        reference: its `Reference`, for poses, velocities and reactions.
    """

    def __init__(self, mechanism: Mechanism, reference: Reference) -> None:
        self._ground = mechanism.ground
        self._actions = Actions(mechanism, reference)

    def __call__(
        self, t: np.ndarray, q: np.ndarray, v: np.ndarray
    ) -> tuple[np.ndarray, np.ndarray]:
        """Return the resultant force and its moment about the world's origin, shape (n, 3) each."""
        force, moment = np.zeros((len(t), 3)), np.zeros((len(t), 3))
        for action in (*self._actions.applied(t, q, v), *self._actions.reactions(t, q, v)):
            if action.body != self._ground and action.other in (None, self._ground):
                force += action.force
                moment += action.moment + np.cross(action.origin, action.force)
        return force, moment
