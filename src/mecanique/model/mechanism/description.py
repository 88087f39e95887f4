"""The parts of a mechanism, as they were given."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any, TypeVar

import numpy as np

from mecanique.errors import InputError, UnknownNameError
from mecanique.model.bodies import Body
from mecanique.model.constraints.contacts import Contact
from mecanique.model.constraints.elements import Element
from mecanique.model.constraints.friction import Switching
from mecanique.model.constraints.loops import Loop
from mecanique.model.constraints.velocity_constraints import VelocityConstraint
from mecanique.model.coordinates import Coordinates
from mecanique.model.expression import Scalar, evaluate, plain, symbols_in
from mecanique.model.force_base import AnyForce
from mecanique.model.joints import Joint
from mecanique.model.mechanism.origin import Origin
from mecanique.model.parameters import Input, Parameter
from mecanique.model.placement import Placement, pose_of
from mecanique.model.statements import MechanismPart


@dataclass(frozen=True)
class Description:
    """The parts of a `Mechanism`, whose documentation says what they are, found by name."""

    name: str
    bodies: tuple[Body, ...]
    joints: tuple[Joint, ...]
    forces: tuple[AnyForce, ...] = ()
    loops: tuple[Loop, ...] = ()
    parameters: tuple[Parameter, ...] = ()
    inputs: tuple[Input, ...] = ()
    coordinates: Coordinates = field(default=Coordinates(()))
    gravity: tuple[Scalar, Scalar, Scalar] = (0.0, 0.0, -9.81)
    ground: str = "ground"
    velocity_constraints: tuple[VelocityConstraint, ...] = ()
    contacts: tuple[Contact, ...] = ()
    elements: tuple[Element, ...] = ()
    switching: tuple[Switching, ...] = ()
    origin: Origin | None = field(default=None, compare=False, repr=False)
    about: str = field(default="", compare=False)

    def refuse_switching(self, why: str) -> None:
        """Raise if it has elements that switch, which something does not treat.

        Args:
            why: in words, what is treated instead, or with what else to ask.

        Raises:
            InputError: naming the elements.
        """
        if self.switching:
            names = ", ".join(repr(element.name) for element in self.switching)
            raise InputError(
                f"mechanism {self.name!r} has elements that switch, {names}: {why}; leave them out "
                "by dataclasses.replace(mechanism, switching=())"
            )

    @cached_property
    def values(self) -> dict[str, float]:
        """Value of each parameter, by symbol."""
        return {parameter.symbol: parameter.value for parameter in self.parameters}

    @cached_property
    def velocities(self) -> tuple[str, ...]:
        """Names of the velocities v: q' for a coordinate q, components for a quaternion."""
        quasi = {
            name: joint for joint in self.joints if joint.quaternion for name in joint.coordinates
        }
        names: dict[str, None] = {}
        for coordinate in self.coordinates:
            joint = quasi.get(coordinate)
            names |= dict.fromkeys([f"{coordinate}'"] if joint is None else joint.velocities)
        return tuple(names)

    @property
    def parts(self) -> tuple[MechanismPart, ...]:
        """What acts or constrains and says by itself what it states."""
        return (*self.contacts, *self.loops, *self.elements, *self.switching, *self.forces)

    @property
    def nq(self) -> int:
        """Number of generalized coordinates."""
        return len(self.coordinates)

    @property
    def nv(self) -> int:
        """Number of generalized velocities."""
        return len(self.velocities)

    @property
    def constrained(self) -> bool:
        """Whether loops, contacts or velocity constraints restrict the motion of the tree."""
        return bool(self.loops or self.rolls)

    @property
    def rolls(self) -> bool:
        """Whether contacts or velocity constraints do, which in general are not holonomic."""
        return bool(self.contacts or self.velocity_constraints)

    @cached_property
    def tree(self) -> tuple[Joint, ...]:
        """The joints, each after the one that carries its parent."""
        children: dict[str, list[Joint]] = {}
        for joint in self.joints:
            children.setdefault(joint.parent, []).append(joint)
        depth = {self.ground: 0}
        waiting = [self.ground]
        while waiting:
            parent = waiting.pop()
            for joint in children.get(parent, ()):
                depth[joint.child] = depth[parent] + 1
                waiting.append(joint.child)
        return tuple(sorted(self.joints, key=lambda joint: depth[joint.child]))

    def body(self, name: str) -> Body:
        """Return a body by name.

        Raises:
            UnknownNameError: if there is none.
        """
        return _lookup("body", name, {body.name: body for body in self.bodies})

    def joint(self, name: str) -> Joint:
        """Return a joint by name.

        Raises:
            UnknownNameError: if there is none.
        """
        return _lookup("joint", name, {joint.name: joint for joint in self.joints})

    def evaluate(self, scalar: Scalar) -> float:
        """Return the number of a scalar in the parameters alone.

        Args:
            scalar: a number or an expression in the parameters.
        """
        return float(evaluate(scalar, self.values))

    def evaluate_all(self, scalars: Iterable[Scalar]) -> list[float]:
        """Return the numbers of several scalars in the parameters alone.

        Args:
            scalars: e.g. the components of a vector, or a row of a matrix.
        """
        return [self.evaluate(scalar) for scalar in scalars]

    def matrix(self, placement: Placement) -> np.ndarray:
        """Return a placement as a homogeneous matrix of numbers, shape (4, 4)."""
        (x, y, z), rpy = map(self.evaluate_all, (placement.xyz, placement.rpy))
        return pose_of(Placement((x, y, z), (rpy[0], rpy[1], rpy[2])))

    @cached_property
    def home_poses(self) -> dict[str, np.ndarray]:
        """Pose of each body where all joint coordinates are zero, shape (4, 4), by name."""
        poses = {self.ground: np.eye(4)}
        for joint in self.tree:
            poses[joint.child] = poses[joint.parent] @ self.matrix(joint.origin)
        return poses


def bodies_with_mass(mechanism: Description) -> list[Body]:
    """Return the bodies that weigh something, the ground apart."""
    return [body for body in bodies_with_inertia(mechanism) if mechanism.evaluate(body.mass)]


def bodies_with_inertia(mechanism: Description) -> list[Body]:
    """Return the bodies that resist being moved or turned, the ground apart."""
    others = (body for body in mechanism.bodies if body.name != mechanism.ground)
    return [body for body in others if any(mechanism.evaluate_all((body.mass, *body.inertia)))]


def angles(mechanism: Description) -> set[str]:
    """Return the coordinates that are angles and the velocities that are angular."""
    driven = {name: plain(scalar) for name, scalar in mechanism.coordinates.driven.items()}
    turning: set[str] = set()
    lengths: set[str] = set()
    rates: set[str] = set()
    for joint in mechanism.joints:
        turning.update(joint.angular_coordinates)
        lengths.update(() if joint.quaternion else joint.linear_coordinates)
        rates.update(joint.angular_velocities if joint.quaternion else ())
    for name, scalar in driven.items():
        # an angle turns a joint, or moves a slide as l cos(q); a length turns a joint as asin(x /
        # l)
        turning |= (
            _inside(scalar, {"sin", "cos", "tan"}) if name in lengths else symbols_in(scalar)
        ) - _inside(scalar, {"asin", "acos", "atan", "atan2"})
    turning = (turning - lengths) & set(mechanism.coordinates)
    return turning | rates | {f"{name}'" for name in turning}


def _inside(expression: Any, functions: set[str]) -> set[str]:
    """Symbols within some functions of an expression."""
    if isinstance(expression, float):
        return set()
    if type(expression).__name__ in functions:
        return set(symbols_in(expression))
    return set().union(*(_inside(part, functions) for part in expression.args))


_T = TypeVar("_T")


def _lookup(kind: str, name: str, known: dict[str, _T]) -> _T:
    if not isinstance(name, str) or name not in known:
        raise UnknownNameError(kind, name, known)
    return known[name]
