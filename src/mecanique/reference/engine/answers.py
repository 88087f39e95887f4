"""What the reference answers with."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, NamedTuple, TypeAlias, final

import numpy as np
import numpy.typing as npt

__all__ = ["AppliedForce", "Array", "Energy", "Momentum", "Number", "PointMotion", "Wrench"]

Array: TypeAlias = npt.NDArray[np.float64]
Number: TypeAlias = Any
"""A float, or an array of shape (n,) for n states: whoever asks knows which."""


class Energy(NamedTuple):
    """The parts of the mechanical energy [J].

    Args:
        kinetic: T, the rotors' (armature) included.
        gravity: V of gravity, −Σ m g·c over all bodies but the ground; zero if every center is at
            the world's origin.
        springs: V of the springs, ½ k (elongation)² each.
    """

    kinetic: Number
    gravity: Number
    springs: Number

    @property
    def potential(self) -> Number:
        """V = V of gravity + V of the springs [J]."""
        return self.gravity + self.springs

    @property
    def total(self) -> Number:
        """E = T + V [J]."""
        return self.kinetic + self.gravity + self.springs


class Momentum(NamedTuple):
    """Momenta of all bodies, world axes.

    Args:
        linear: shape (3,) or (n, 3) [kg·m/s].
        angular: about the world's origin, shape (3,) or (n, 3) [kg·m²/s].
        angular_about_center: about the common center of mass, shape (3,) or (n, 3) [kg·m²/s].
    """

    linear: Array
    angular: Array
    angular_about_center: Array


class PointMotion(NamedTuple):
    """How a point of a body moves, world axes.

    Args:
        position: shape (3,) or (n, 3) [m].
        velocity: shape (3,) or (n, 3) [m/s].
        acceleration: shape (3,) or (n, 3) [m/s²].
    """

    position: Array
    velocity: Array
    acceleration: Array


@final
@dataclass(frozen=True, eq=False)
class Wrench:
    """A force and a moment of a parent on its child, at the joint (the child's origin), world axes.

    Of a loop: of body a on body b, at the origin of the loop's frame on body b.

    Args:
        force: shape (3,) or (n, 3) [N].
        moment: shape (3,) or (n, 3) [N·m].
        undetermined: names of components, e.g. "force y", that redundant constraints leave
            undetermined; their values are those of the least multipliers, one possibility among
            many.
    """

    force: Array
    moment: Array
    undetermined: tuple[str, ...] = ()


@final
@dataclass(frozen=True, eq=False)
class AppliedForce:
    """What a spring, a damper, a drive or a load does to one body, world axes.

    Args:
        name: of the force.
        body: name of the body it acts on.
        other: name of the body that takes the opposite; None if nothing in the mechanism does.
        point: shape (3,) or (n, 3), where it acts [m].
        force: shape (3,) or (n, 3) [N].
        moment: shape (3,) or (n, 3), about that point [N·m].
    """

    name: str
    body: str
    other: str | None
    point: Array
    force: Array
    moment: Array
