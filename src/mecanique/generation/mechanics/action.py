"""A force and a moment on a body, in scalars of a tape."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import final

from mecanique.generation.mechanics.vectors import Triple, scale

NOTHING: Triple = [0.0, 0.0, 0.0]


@final
@dataclass(frozen=True)
class Action:
    """A force and a moment on a body, world axes.

    Args:
        name: name of the force, the joint or loop, or of the body for weight and inertia.
        kind: "weight", "reaction", "inertia", or the kind of the force.
        body: the body on which it acts.
        origin: point of action.
        force: the force.
        moment: moment about that point.
    """

    name: str
    kind: str
    body: str
    origin: Triple
    force: Triple
    moment: Triple

    def opposite(self, body: str) -> Action:
        """Return the opposite action, on the other body.

        Args:
            body: name of the other body.
        """
        force, moment = scale(-1.0, self.force), scale(-1.0, self.moment)
        return replace(self, body=body, force=force, moment=moment)
