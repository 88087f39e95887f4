"""A mechanism: bodies, joints, forces and coordinates, frozen and sound."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, fields, replace
from functools import cached_property
from typing import Any, TypeVar, cast, final

import numpy as np

from mecanique.errors import InputError, MechanismError, UnknownNameError
from mecanique.model.bodies import Body
from mecanique.model.coordinates import Coordinates
from mecanique.model.expression import Scalar, Vector, coordinate, evaluate, symbols_in
from mecanique.model.forces import AnyForce, JointDamper
from mecanique.model.joints import Joint, Limits, Planar, Single
from mecanique.model.parameters import Parameter
from mecanique.model.placement import Placement, vector
from mecanique.model.validation import Description, faults
from mecanique.model.values import Given, numbers_of

__all__ = ["Mechanism"]

_SHORTEST, _LONGEST = 1e-9, 1e9
"""Lengths between which four numbers count as a quaternion to be normalized."""


@final
@dataclass(frozen=True)
class Mechanism(Description):
    """A mechanism described once; what can be built is sound.

    Args:
        name: its name, as robot name in URDF.
        bodies: all bodies, the ground included.
        joints: a tree from the ground to every other body.
        forces: springs, dampers and loads.
        loops: closures between bodies of the tree.
        parameters: every parameter the expressions use.
        inputs: every named signal the expressions use.
        coordinates: generalized coordinates and their map; the joints' own by default.
        gravity: shape (3,), acceleration of free fall in world axes [m/s²].
        ground: name of the body that is fixed in the inertial frame; its frame is the world's.
        velocity_constraints: rolling, skates and the like; a mechanism that has some is refused,
            with the reason.

    Raises:
        MechanismError: with every fault found.
    """

    def __post_init__(self) -> None:
        for name in (
            "bodies",
            "joints",
            "forces",
            "loops",
            "parameters",
            "inputs",
            "velocity_constraints",
        ):
            object.__setattr__(self, name, tuple(getattr(self, name)))
        object.__setattr__(self, "gravity", vector(self.gravity, "gravity"))
        driven = self._collect_driven()
        free = [name for joint in self.joints for name in joint.coordinates if name not in driven]
        names = (
            *self.coordinates.names,
            *(name for name in free if name not in self.coordinates.names),
        )
        object.__setattr__(
            self, "coordinates", Coordinates(names, tuple(driven.items()), self.coordinates.limits)
        )
        found = faults(self)
        if found:
            raise MechanismError(self.name, found)

    def _collect_driven(self) -> dict[str, Scalar]:
        """The coordinate map, and what follows within joints: of what is driven there, too."""
        driven = dict(self.coordinates.driven)
        for joint in self.joints:
            for name, law in joint.followers.items():
                leaders = symbols_in(law) & driven.keys()
                driven[name] = law.subs({coordinate(k): driven[k] for k in leaders})
        return driven

    @property
    def nq(self) -> int:
        """Number of generalized coordinates."""
        return len(self.coordinates)

    @property
    def nv(self) -> int:
        """Number of generalized velocities."""
        return len(self.velocities)

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

    @cached_property
    def limits(self) -> dict[str, tuple[float, float]]:
        """The open interval of each coordinate that is limited, by name."""
        return {
            name: (self.evaluate(lower), self.evaluate(upper))
            for name, (lower, upper) in self.coordinates.intervals.items()
        }

    def refuse_outside(self, q: np.ndarray) -> None:
        """Raise if a coordinate is not within its limits.

        Args:
            q: shape (nq,) or (n, nq).

        Raises:
            InputError: naming the coordinate, its limits and what it was.
        """
        for name, (lower, upper) in self.limits.items():
            values = np.atleast_2d(q)[:, self.coordinates.index(name)]
            outside = values[~((values > lower) & (values < upper))]
            if len(outside):
                raise InputError(self.explain_limit(name, f", got {outside[0]:.9g}"))

    def explain_limit(self, name: str, what: str = "") -> str:
        """Return in a sentence where a coordinate must stay, and what to use instead.

        Args:
            name: of a limited coordinate.
            what: what happened to it, after a comma.
        """
        stated = ", ".join(map(str, self.coordinates.intervals[name]))
        numbers = ", ".join(f"{bound:g}" for bound in self.limits[name])
        interval = f"({stated})" if stated == numbers else f"({stated}) = ({numbers})"
        others = [
            other for other, map_ in self.coordinates.driven.items() if name in symbols_in(map_)
        ]
        instead = f", e.g. {' or '.join(others)}" if others else ""
        return (
            f"{name} must stay within {interval}{what}: the chart {name} of {self.name!r} ends "
            f"there; use another coordinate{instead}"
        )

    def neutral(self) -> np.ndarray:
        """Return the position with every coordinate zero and every quaternion one, shape (nq,).

        A coordinate whose limits leave out zero is in the middle of them, or 1 away from the finite
        one.
        """
        ones = {joint.quaternion[-1] for joint in self.joints if joint.quaternion}
        middle = {name: _middle(*bounds) for name, bounds in self.limits.items()}
        return np.array(
            [1.0 if name in ones else middle.get(name, 0.0) for name in self.coordinates]
        )

    @cached_property
    def _rates(self) -> dict[str, str]:
        """The velocity that each coordinate's name stands for."""
        return {name.removesuffix("'"): name for name in self.velocities}

    @cached_property
    def _changes(self) -> dict[str, str]:
        """The velocity whose change is meant by the name of a coordinate or of an acceleration."""
        return {**self._rates, **{f"{name}'": name for name in self.velocities}}

    @cached_property
    def quaternions(self) -> tuple[tuple[str, list[int]], ...]:
        """Name of each joint with a unit quaternion, and where the quaternion stands in q."""
        return tuple(
            (joint.name, [self.coordinates.index(name) for name in joint.quaternion])
            for joint in self.joints
            if joint.quaternion
        )

    def normalize(self, q: np.ndarray) -> np.ndarray:
        """Give every quaternion of some positions unit length, in place, and return them.

        Args:
            q: shape (nq,) or (n, nq).

        Raises:
            InputError: if a quaternion has no length.
        """
        for name, at in self.quaternions:
            length = np.linalg.norm(q[..., at], axis=-1, keepdims=True)
            sound = (length > _SHORTEST) & (length < _LONGEST)
            if not sound.all():
                wrong = q[..., at][~sound[..., 0]][0]
                raise InputError(
                    f"expected a unit quaternion for joint {name!r}, got {wrong.tolist()}"
                )
            q[..., at] /= length
        return q

    def position(self, q: Given, *, many: bool = False) -> np.ndarray:
        """Return positions as an array, shape (nq,).

        Args:
            q: shape (nq,), or values by coordinate name (those left out are zero, a quaternion's w
                one), or None. A joint coordinate that follows one of them in proportion, with an
                offset or none, may stand for it.
            many: whether several positions may be given, shape (n, nq), or by name shape (n,); the
                answer then has that shape.

        Raises:
            InputError: if the shape is wrong, a number is not finite or beyond its coordinate's
                limits, or a quaternion has no length.
            UnknownNameError: if a name is no coordinate.
        """
        by_name = q is None or isinstance(q, Mapping)
        default = self.neutral() if by_name else np.zeros(self.nq)
        if isinstance(q, Mapping) and q.keys() & self.coordinates.driven.keys():
            q = self._by_leaders(q)
        names = self.coordinates.names
        found = self.normalize(numbers_of(q, names, "coordinate", default, many=many))
        self.refuse_outside(found)
        return found

    def _by_leaders(self, q: Mapping[str, Any]) -> dict[str, Any]:
        """Replace the joint coordinates that follow the map by what they follow."""
        found = {name: value for name, value in q.items() if name not in self.coordinates.driven}
        for name in q.keys() - found.keys():
            law = self.coordinates.driven[name]
            leaders = symbols_in(law) - self.values.keys()
            leader = min(leaders, default="")
            slope = law.diff(coordinate(leader)) if leader in self.coordinates else 0
            if len(leaders) != 1 or not slope or symbols_in(slope) - self.values.keys():
                raise InputError(
                    f"{name} follows the coordinate map, {name} = {law}, and does not determine "
                    f"the coordinates in it by itself; give {', '.join(self.coordinates)}"
                )
            if leader in found:
                raise InputError(f"{name} = {law} follows {leader}, which is given, too")
            rest = self.evaluate(law.subs({coordinate(leader): 0}))
            found[leader] = (np.asarray(q[name], dtype=float) - rest) / self.evaluate(slope)
        return found

    def velocity(self, v: Given, *, many: bool = False) -> np.ndarray:
        """Return velocities as an array, shape (nv,).

        Args:
            v: shape (nv,), or values by velocity name, q or q' (those left out are zero), or None.
            many: whether several velocities may be given, shape (n, nv), or by name shape (n,); the
                answer then has that shape.

        Raises:
            InputError: if the shape is wrong or a number is not finite.
            UnknownNameError: if a name is no velocity.
        """
        zero = np.zeros(self.nv)
        return numbers_of(v, self.velocities, "velocity", zero, self._rates, many=many)

    def acceleration(self, a: Given, *, many: bool = False) -> np.ndarray:
        """Return accelerations as an array, shape (nv,).

        Args:
            a: shape (nv,), or values by name of the coordinate, of the velocity or of its rate
                (those left out are zero), or None.
            many: whether several accelerations may be given, shape (n, nv), or by name shape (n,);
                the answer then has that shape.

        Raises:
            InputError: if the shape is wrong or a number is not finite.
            UnknownNameError: if a name is no acceleration.
        """
        zero = np.zeros(self.nv)
        return numbers_of(a, self.velocities, "acceleration", zero, self._changes, many=many)

    def replace(
        self,
        name: str | None = None,
        /,
        *,
        gravity: Vector | float | None = None,
        **values: float,
    ) -> Mechanism:
        """Return a copy with other parameter values or another gravity.

        Args:
            name: another name for the copy, if any.
            gravity: shape (3,), acceleration of free fall in world axes [m/s²]; the value of the
                parameter where the mechanism has one of this name.
            values: new value of each parameter to change, by symbol.

        Raises:
            UnknownNameError: if a symbol is no parameter.
            InputError: if a value is not finite, or gravity has not three components.
            MechanismError: if the copy is not sound.
        """
        if gravity is not None and "gravity" in self.values:
            values["gravity"], gravity = cast("float", gravity), None
        for symbol in values:
            if symbol not in self.values:
                raise UnknownNameError("parameter", symbol, self.values)
        parameters = tuple(p.with_value(values.get(p.symbol, p.value)) for p in self.parameters)
        changed = replace(self, name=self.name if name is None else name, parameters=parameters)
        if gravity is None:
            return changed
        fall = vector(cast("Vector", gravity), "gravity")
        return replace(changed, gravity=fall, parameters=_with(parameters, cast("Vector", gravity)))

    def with_body(
        self,
        name: str,
        /,
        *,
        mass: Scalar | None = None,
        center: Vector | np.ndarray | None = None,
        inertia: Sequence[Scalar] | np.ndarray | None = None,
    ) -> Mechanism:
        """Return a copy in which one body has another mass, center of mass or inertia.

        What is not given stays as it is: a new mass does not change the inertia. A `Parameter`
        that is given becomes one of the copy's.

        Args:
            name: of the body.
            mass: above 0 [kg].
            center: shape (3,), center of mass in the body's frame [m].
            inertia: ixx, iyy, izz, ixy, ixz, iyz about the center of mass, body axes [kg·m²].

        Raises:
            UnknownNameError: if there is no such body.
            InputError: if the mass is zero, or the number of components is wrong.
            MechanismError: if the copy is not sound, e.g. its mass negative.
        """
        changed = self.body(name).replace(mass=mass, center=center, inertia=inertia)
        copy = replace(
            self,
            bodies=tuple(changed if body.name == name else body for body in self.bodies),
            parameters=_with(self.parameters, [mass], center, inertia),
        )
        if mass is not None and copy.evaluate(changed.mass) == 0:
            raise InputError(f"expected a mass above 0 for body {name!r}, got 0")
        return copy

    def with_joint(
        self,
        name: str,
        /,
        *,
        origin: Placement | Vector | None = None,
        axis: tuple[float, float, float] | None = None,
        limits: Limits | tuple[float, float] | None = None,
        armature: Scalar | None = None,
        damping: Scalar | None = None,
    ) -> Mechanism:
        """Return a copy in which one joint stands elsewhere or has another axis, drive or damping.

        What is not given stays as it is. A `Parameter` that is given becomes one of the copy's.

        Args:
            name: of the joint.
            origin: where its frame stands in the parent; of three numbers, the position alone [m].
            axis: shape (3,), in the joint's frame; numbers, any length but zero.
            limits: its bounds; of two numbers, those of the position alone [rad or m].
            armature: inertia of the drive's rotor seen at the joint [kg·m² or kg].
            damping: of the linear damper in the joint, instead of any others there; 0 for none
                [N·m·s/rad or N·s/m].

        Raises:
            UnknownNameError: if there is no such joint.
            InputError: if the joint has not the one coordinate that armature, damping and limits
                belong to, or no axis, or an argument is not what is expected.
            MechanismError: if the copy is not sound, e.g. its damping negative.
        """
        joint = self.joint(name)
        fields: dict[str, Any] = {}
        position: Vector = ()
        if isinstance(origin, Placement):
            fields["origin"] = origin
        elif origin is not None:
            position = origin
            fields["origin"] = replace(
                joint.origin, xyz=vector(position, f"origin of joint {name!r}")
            )
        single = {"limits": limits, "armature": armature, "damping": damping}
        asked = [what for what, given in single.items() if given is not None]
        if asked and not isinstance(joint, Single):
            kind = type(joint).__name__
            raise InputError(
                f"expected a joint with one coordinate for {asked[0]}, but {name!r} is {kind}"
            )
        if axis is not None:
            if not isinstance(joint, (Single, Planar)):
                kind = type(joint).__name__
                raise InputError(f"expected a joint with an axis, but {name!r} is {kind}")
            fields["axis"] = axis
        if limits is not None:
            fields["limits"] = _bounds(limits, joint)
        if armature is not None:
            fields["armature"] = armature
        changed: Joint = replace(joint, **fields)
        return replace(
            self,
            joints=tuple(changed if each is joint else each for each in self.joints),
            forces=self.forces if damping is None else self._damp(name, damping),
            parameters=_with(self.parameters, position, [armature, damping]),
        )

    def _damp(self, joint: str, damping: Scalar) -> tuple[AnyForce, ...]:
        """The forces with one linear damper in a joint, where its first one stands."""
        old = [f for f in self.forces if isinstance(f, JointDamper) and f.joint == joint]
        rest = [force for force in self.forces if force not in old]
        if isinstance(damping, (int, float)) and damping == 0:
            return tuple(rest)
        name = old[0].name if old else f"{joint}_damper"
        while any(force.name == name for force in rest):
            name += "_"
        at = self.forces.index(old[0]) if old else len(rest)
        return (*rest[:at], JointDamper(name, joint, damping), *rest[at:])

    def without_mimic(self) -> Mechanism:
        """Return a copy in which the joints that follow others, as a URDF's mimic, move freely.

        They are those that the coordinate map ties to other joints' coordinates, or to a constant;
        joints that time or an input drives stay driven.

        Raises:
            MechanismError: if the copy is not sound.
        """
        own = [name for joint in self.joints for name in joint.coordinates]
        within = {name for joint in self.joints for name in joint.followers}
        tied = {*own, *self.values}
        kept = {
            name: law
            for name, law in self.coordinates.driven.items()
            if name in within or not symbols_in(law) <= tied
        }
        names = self.coordinates.names
        if list(names) == [name for name in own if name in names]:
            names = ()  # in the order of the joints, as before
        return replace(self, coordinates=Coordinates(names, kept, self.coordinates.limits))

    def __repr__(self) -> str:
        names = [*self.coordinates[:12], *(["…"] if self.nq > 12 else [])]
        return (
            f"<Mechanism {self.name!r}: {len(self.bodies)} bodies, {len(self.joints)} joints, "
            f"{len(self.forces)} forces, q = ({', '.join(names)})>"
        )

    def __getstate__(self) -> dict[str, Any]:
        return {f.name: getattr(self, f.name) for f in fields(self)}


_T = TypeVar("_T")


def _lookup(kind: str, name: str, known: dict[str, _T]) -> _T:
    if name not in known:
        raise UnknownNameError(kind, name, known)
    return known[name]


def _with(
    parameters: tuple[Parameter, ...], *given: Iterable[object] | None
) -> tuple[Parameter, ...]:
    """The parameters, and those among what is given."""
    scalars = [scalar for each in given if each is not None for scalar in each]
    found = (scalar for scalar in scalars if isinstance(scalar, Parameter))
    return tuple(dict.fromkeys([*parameters, *found]))


def _bounds(limits: Limits | tuple[float, float], joint: Joint) -> Limits:
    """The limits; of two numbers, with the effort and the velocity that the joint has."""
    if isinstance(limits, Limits):
        return limits
    try:
        lower, upper = map(float, limits)
    except (TypeError, ValueError):
        raise InputError(
            f"expected Limits or (lower, upper) for joint {joint.name!r}, got {limits!r}"
        ) from None
    before = getattr(joint, "limits", None) or Limits()
    return replace(before, lower=lower, upper=upper)


def _middle(lower: float, upper: float) -> float:
    if lower < 0 < upper:
        return 0.0
    if np.isfinite(lower) and np.isfinite(upper):
        return (lower + upper) / 2
    return lower + 1 if np.isfinite(lower) else upper - 1
