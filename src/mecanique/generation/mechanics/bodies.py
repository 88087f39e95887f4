"""Bodies for the recursion: frames fixed in them, forces on them, and their inertia."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, final

from mecanique.derivation.tree.poses import Matrix
from mecanique.generation.mechanics.vectors import (
    Rows,
    Triple,
    add,
    apply,
    dot,
    scale,
)


@final
@dataclass(frozen=True)
class Seat:
    """A frame fixed in a link of the tree.

    Args:
        place: index of the moving link, −1 for the ground.
        pose: pose of the frame in that link.
    """

    place: int
    pose: Matrix


@final
@dataclass(frozen=True)
class Wrench:
    """A force and a moment on a moving link.

    Args:
        place: index of the link.
        force: in the link's axes.
        moment: about the link's origin, in its axes.
    """

    place: int
    force: Triple
    moment: Triple


@final
@dataclass(frozen=True)
class Inertia:
    """Mass m, first moments h and second moments E of a body about its origin."""

    m: Any
    h: Triple
    E: Rows

    def __add__(self, other: Inertia) -> Inertia:
        E = [add(*rows) for rows in zip(self.E, other.E, strict=True)]
        return Inertia(self.m + other.m, add(self.h, other.h), E)

    def __sub__(self, other: Inertia) -> Inertia:
        E = [add(x, scale(-1.0, y)) for x, y in zip(self.E, other.E, strict=True)]
        return Inertia(self.m - other.m, add(self.h, scale(-1.0, other.h)), E)

    @property
    def is_number(self) -> bool:
        """Whether it contains numbers only."""
        entries = [self.m, *self.h, *self.E[0], *self.E[1], *self.E[2]]
        return all(isinstance(entry, (int, float)) for entry in entries)

    def seen_from(self, pose: Matrix) -> Inertia:
        """Refer the inertia to the frame in which the body has a pose: its axes and its origin."""
        p = [row[3] for row in pose]
        turned = apply(pose, self.h)
        RE = [apply(self.E, row[:3]) for row in pose]  # E is symmetric
        E: Rows = [[0.0] * 3 for _ in range(3)]
        for i in range(3):
            for k in range(i + 1):
                turned_E = dot(RE[i], pose[k][:3])
                E[i][k] = E[k][i] = (
                    turned_E + turned[i] * p[k] + p[i] * turned[k] + self.m * p[i] * p[k]
                )
        return Inertia(self.m, add(turned, scale(self.m, p)), E)
