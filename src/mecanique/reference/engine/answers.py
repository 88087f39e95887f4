"""The results that a reference returns: energies, momenta, motions, wrenches."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Any, NamedTuple, TypeAlias, final

import numpy as np

from mecanique.arrays import Array, Flags
from mecanique.errors import InputError, UnknownNameError
from mecanique.model.placement import vector
from mecanique.reference.tolerances import PARALLEL
from mecanique.wording import Legible, name_fields

Number: TypeAlias = Any
"""A float, or an array of shape (n,) for n states."""


class Energy(NamedTuple):
    """The parts of the mechanical energy [J].

    Args:
        kinetic: T, including the rotors' (armature).
        gravity: V of gravity, −Σ m g·c over all bodies except the ground, with centers of mass c.
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

    def __repr__(self) -> str:
        return name_fields(self)


class BodyMotions(NamedTuple):
    """The motions of all nb bodies in their order, world axes, in one state or in n.

    Args:
        poses: shape (nb, 4, 4) or (n, nb, 4, 4).
        velocities: of the bodies' origins, shape (nb, 3) or (n, nb, 3) [m/s].
        angular_velocities: shape (nb, 3) or (n, nb, 3) [rad/s].
        accelerations: of the bodies' origins, shape (nb, 3) or (n, nb, 3) [m/s²].
        angular_accelerations: shape (nb, 3) or (n, nb, 3) [rad/s²].
    """

    poses: Array
    velocities: Array
    angular_velocities: Array
    accelerations: Array
    angular_accelerations: Array

    def __repr__(self) -> str:
        return name_fields(self)


class Resultant(NamedTuple):
    """The resultant of all external forces on the moving bodies, world axes.

    Args:
        force: shape (3,) or (n, 3) [N].
        moment: about the world's origin, shape (3,) or (n, 3) [N·m].
        center: the common center of mass, shape (3,) or (n, 3) [m]; the origin without mass.
    """

    force: Array
    moment: Array
    center: Array

    def __repr__(self) -> str:
        return name_fields(self)


class PointMotion(NamedTuple):
    """The motion of a body's point, world axes.

    Args:
        position: shape (3,) or (n, 3) [m].
        velocity: shape (3,) or (n, 3) [m/s].
        acceleration: shape (3,) or (n, 3) [m/s²].
    """

    position: Array
    velocity: Array
    acceleration: Array

    def __repr__(self) -> str:
        return name_fields(self)


class Twist(NamedTuple):
    """The velocity of a body, world axes.

    Args:
        linear: velocity of the body's origin, shape (3,) or (n, 3) [m/s].
        angular: angular velocity, shape (3,) or (n, 3) [rad/s].
    """

    linear: Array
    angular: Array

    def __repr__(self) -> str:
        return name_fields(self)


@final
class BodyPoses:
    """The poses of the bodies in the states of some wrenches, computed when first needed."""

    def __init__(self, find: Callable[[], dict[str, Array]]) -> None:
        self._find = find

    @cached_property
    def poses(self) -> dict[str, Array]:
        """The pose of each body in the world, by name, shape (4, 4) or (n, 4, 4)."""
        return self._find()

    def __getstate__(self) -> dict[str, Any]:
        return {"poses": self.poses}

    def __setstate__(self, state: dict[str, Any]) -> None:
        self.__dict__.update(state)


def name_components(flags: Flags) -> tuple[str, ...]:
    """Return the names of components of a wrench that are flagged, shape (6,)."""
    names = (f"{kind} {axis}" for kind in ("force", "moment") for axis in "xyz")
    return tuple(name for name, flagged in zip(names, flags, strict=True) if flagged)


@final
@dataclass(frozen=True, eq=False, repr=False)
class Wrench(Legible):
    """The force and moment of a parent on its child, at the joint (the child's origin), world axes.

    For a loop it is the wrench of body a (here called parent) on body b (called child), at the
    origin of the loop's frame on body b. `in_axes` converts it to other axes, `about` its moment to
    another point.

    Args:
        force: shape (3,) or (n, 3) [N].
        moment: shape (3,) or (n, 3) [N·m].
        undetermined: names of components, e.g. "force y", that are not determined. With redundant
            constraints their values belong to the least multipliers, one possibility among many;
            at a joint with a guide that no element describes, they are NaN.
        axes: the axes of the components: "world" or a body's name.
        parent: name of the acting body; empty if not known.
        child: name of the body on which it acts.
        point: shape (3,), reference point of the moment in the frame of `body` [m].
        body: name of the body that carries the point, or "world".
        places: the poses of the bodies.
        reason: why a guide leaves components undetermined.

    Example:
        >>> reference = mq.Reference(mq.textbook.load("rigid_bar_pendulum"))
        >>> pin = reference.reactions({"q": 0.0}, {"q": 2.0})["pin"]
        >>> pin.parent, pin.child
        ('ground', 'rod')
        >>> pin.force.round(3)
        array([ 0.  ,  0.  , 11.81])
    """

    force: Array
    moment: Array
    undetermined: tuple[str, ...] = ()
    axes: str = "world"
    parent: str = ""
    child: str = ""
    point: tuple[float, float, float] = (0.0, 0.0, 0.0)
    body: str = ""
    places: BodyPoses | None = field(default=None, repr=False)
    reason: str = ""

    def in_axes(self, axes: str) -> Wrench:
        """Return the same wrench with its components in other axes.

        Args:
            axes: "world", "parent", "child" or the name of a body.

        Raises:
            UnknownNameError: if there is no such body.
        """
        name = {"parent": self.parent, "child": self.child}.get(axes, axes)
        here, there = self._turn(self.axes), self._turn(name)
        turn = np.swapaxes(there, -1, -2) @ here
        # components in rotated axes to which undetermined ones contribute
        share = np.abs(turn).reshape(-1, 3, 3).max(axis=0) > PARALLEL
        directions = []
        for kind in ("force", "moment"):
            loose = np.array([f"{kind} {axis}" in self.undetermined for axis in "xyz"])
            directions += [
                f"{kind} {axis}" for axis, row in zip("xyz", share, strict=True) if row @ loose
            ]
        return replace(
            self,
            force=_rotate(turn, self.force),
            moment=_rotate(turn, self.moment),
            axes=name,
            undetermined=tuple(directions),
        )

    def about(self, point: Sequence[float] | Array, body: str = "world") -> Wrench:
        """Return the same wrench with the moment about another point, in the same axes.

        Args:
            point: shape (3,) [m].
            body: the body in whose frame the point is given and with which it moves: "world",
                "parent", "child" or a name.

        Raises:
            UnknownNameError: if there is no such body.
            InputError: if the point is not three finite numbers.
        """
        name = {"parent": self.parent, "child": self.child}.get(body, body)
        x, y, z = local_point(point).tolist()
        moved = replace(self, point=(x, y, z), body=name)
        turn = self._turn(self.axes)
        arm = self._place() - moved._place()
        force = (turn @ self.force[..., None])[..., 0]
        added = np.swapaxes(turn, -1, -2) @ np.cross(arm, force)[..., None]
        loose = self.undetermined
        if any(part.startswith("force") for part in loose):
            forces = tuple(part for part in loose if part.startswith("force"))
            loose = (*forces, "moment x", "moment y", "moment z")
        return replace(moved, moment=self.moment + added[..., 0], undetermined=loose)

    def _turn(self, axes: str) -> Array:
        """Return the rotation from some axes to the world's, shape (3, 3) or (n, 3, 3)."""
        return self._pose(axes)[..., :3, :3]

    def _place(self) -> Array:
        """Return the reference point in the world, shape (3,) or (n, 3)."""
        pose = self._pose(self.body)
        place: Array = pose[..., :3, :3] @ np.array(self.point) + pose[..., :3, 3]
        return place

    def _pose(self, name: str) -> Array:
        if name == "world":
            return np.eye(4)
        poses = {} if self.places is None else self.places.poses
        if name not in poses:
            raise UnknownNameError("body or axes", name, ("world", "parent", "child", *poses))
        return poses[name]


@final
@dataclass(frozen=True, eq=False, repr=False)
class AppliedForce(Legible):
    """The action of a spring, a damper, a drive or a load on one body, world axes.

    Args:
        name: name of the force.
        body: name of the body on which it acts.
        other: name of the body on which the opposite acts; None for an external load.
        point: shape (3,) or (n, 3), its point of action [m].
        force: shape (3,) or (n, 3) [N].
        moment: shape (3,) or (n, 3), about that point [N·m].
    """

    name: str
    body: str
    other: str | None
    point: Array
    force: Array
    moment: Array


def local_point(xyz: Sequence[float] | Array) -> Array:
    """Check a point of a body and return it as an array, shape (3,)."""
    # Shapes: xyz (3,)
    try:
        local: Array = np.array([float(c) for c in vector(tuple(xyz), "a point")])
    except TypeError:
        raise InputError(f"expected three numbers for a point, got {xyz!r}") from None
    if not np.isfinite(local).all():
        raise InputError(f"expected a finite point, got {xyz!r}")
    return local


def _rotate(turn: Array, vector: Array) -> Array:
    """Rotate a vector; components to which NaN ones contribute become NaN."""
    known = np.isfinite(vector)
    turned: Array = (turn @ np.where(known, vector, 0.0)[..., None])[..., 0]
    lost = ((np.abs(turn) > PARALLEL) & ~known[..., None, :]).any(axis=-1)
    return np.where(lost, np.nan, turned)
