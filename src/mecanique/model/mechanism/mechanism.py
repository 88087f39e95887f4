"""A mechanism: bodies, joints, forces and coordinates, frozen and sound."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, fields, replace
from typing import Any, NamedTuple, TypeVar, cast, final

import numpy as np

from mecanique.errors import InputError, MecaniqueError, MechanismError, UnknownNameError
from mecanique.model.coordinates import Coordinates
from mecanique.model.expression import Scalar, Vector, coordinate, plain, symbols_in
from mecanique.model.force_base import AnyForce
from mecanique.model.forces import JointDamper
from mecanique.model.joint_base import Limits, Single
from mecanique.model.joints import Joint, Planar, Revolute
from mecanique.model.mechanism.description import Description
from mecanique.model.mechanism.element_laws import laws_of_elements
from mecanique.model.mechanism.letters import to_name
from mecanique.model.mechanism.state_space import StateSpace
from mecanique.model.mechanism.validation import faults
from mecanique.model.parameters import Parameter
from mecanique.model.placement import Placement, vector
from mecanique.notebook import draw
from mecanique.wording import say_count

_Variant = TypeVar("_Variant", bound="Variants")


@dataclass(frozen=True)
class Variants(Description):
    """The copies that can be made of a mechanism."""

    def replace(
        self: _Variant,
        name: str | None = None,
        /,
        *,
        gravity: Vector | float | None = None,
        **values: float,
    ) -> _Variant:
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
        self: _Variant,
        name: str,
        /,
        *,
        mass: Scalar | None = None,
        center: Vector | np.ndarray | None = None,
        inertia: Sequence[Scalar] | np.ndarray | None = None,
    ) -> _Variant:
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
        self: _Variant,
        name: str,
        /,
        *,
        origin: Placement | Vector | None = None,
        axis: tuple[float, float, float] | None = None,
        limits: Limits | tuple[float, float] | None = None,
        armature: Scalar | None = None,
        damping: Scalar | None = None,
    ) -> _Variant:
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
            joints=tuple(changed if old is joint else old for old in self.joints),
            forces=self.forces if damping is None else self._damp(name, damping),
            parameters=_with(self.parameters, position, [armature, damping]),
        )

    def with_absolute_angles(self: _Variant, letters: Mapping[str, str]) -> _Variant:
        """Return a copy in which angles of hinges are measured from a direction that stays.

        An absolute angle is the sum of those of the parallel hinges from the ground on, as books
        have the angles of linkages (R. L. Norton, Design of Machinery, ch. 4).

        Args:
            letters: the name of the absolute angle, by the coordinate that it replaces.

        Raises:
            InputError: if a name is no generalized coordinate of a hinge, or a hinge before it has
                another direction.
            MechanismError: if the copy is not sound, as where a force depends on such a coordinate.

        Example:
            >>> linkage = mq.textbook.load("four_bar_linkage")
            >>> dict(linkage.with_absolute_angles({"theta": "chi"}).coordinates.driven)
            {'theta': chi - phi}
        """
        hinges = {j.coordinate for j in self.joints if isinstance(j, Revolute)}
        turning = [name for name in self.coordinates if name in hinges]
        letters = {to_name(self, name): letter for name, letter in letters.items()}
        for name in letters:
            if name not in turning:
                known = ", ".join(turning) or "none"
                raise InputError(f"expected a coordinate of a hinge ({known}), got {name!r}")
        driven: dict[str, Scalar] = {}
        turned = {self.ground: _Turned(np.eye(3))}
        for joint in self.tree:
            before = turned[joint.parent]
            rows = [self.evaluate_all(row) for row in joint.origin.rotation]
            attitude = before.attitude @ np.array(rows)
            if not isinstance(joint, Revolute):
                planar = before.planar and "angular" not in joint.kinds
                turned[joint.child] = before._replace(attitude=attitude, planar=planar)
                continue
            axis, name = attitude @ joint.axis, joint.coordinate
            along = 1.0 if before.axis is None else round(float(axis @ before.axis), _DIGITS)
            planar, sense = before.planar and abs(along) == 1, int(along)
            whole = self.coordinates.driven.get(name, coordinate(name)) + sense * before.angle
            if name in letters:
                if not planar:
                    raise InputError(
                        f"{name!r} has no absolute angle: a hinge between its body and the ground "
                        "is not parallel to it"
                    )
                whole = coordinate(letters[name])
                driven[name] = whole - sense * before.angle
            turned[joint.child] = _Turned(attitude, axis, whole, planar)
        laws = {coordinate(name): law for name, law in driven.items()}
        driven |= {k: plain(x).subs(laws) for k, x in self.coordinates.driven.items()}
        names = tuple(letters.get(name, name) for name in self.coordinates)
        return replace(self, coordinates=Coordinates(names, driven, self.coordinates.limits))

    def without_mimic(self: _Variant) -> _Variant:
        """Return a copy in which the joints that follow others, as a URDF's mimic, move freely.

        They are those that the coordinate map ties to other joints' coordinates, or to a constant;
        joints that time or an input drives stay driven. Elements that tie joints are left out.

        Raises:
            MechanismError: if the copy is not sound.
        """
        of_joints = [name for joint in self.joints for name in joint.coordinates]
        within = {name for joint in self.joints for name in joint.followers}
        tied = {*of_joints, *self.values}
        kept = {
            name: law
            for name, law in self.coordinates.driven.items()
            if name in within or not symbols_in(law) <= tied
        }
        names = self.coordinates.names
        if list(names) == [name for name in of_joints if name in names]:
            names = ()  # in the order of the joints, as before
        freed = Coordinates(names, kept, self.coordinates.limits)
        # what ties joints is released with them
        elements = self.elements if kept == self.coordinates.driven else ()
        return replace(self, coordinates=freed, elements=elements)

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


_DIGITS = 12
"""To so many digits the cosine of the angle between two hinges is told from 1."""


class _Turned(NamedTuple):
    """How a body stands: its attitude at zero, the axis it turns about, and by which angle."""

    attitude: np.ndarray
    axis: np.ndarray | None = None
    angle: Scalar = 0
    planar: bool = True  # whether all hinges from the ground on are parallel


def _with(
    parameters: tuple[Parameter, ...], *given: Iterable[object] | None
) -> tuple[Parameter, ...]:
    """The parameters, and those among what is given."""
    scalars = [scalar for group in given if group is not None for scalar in group]
    added = (scalar for scalar in scalars if isinstance(scalar, Parameter))
    return tuple(dict.fromkeys([*parameters, *added]))


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


@final
@dataclass(frozen=True)
class Mechanism(StateSpace, Variants):
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
        velocity_constraints: linear constraints on velocities in general.
        contacts: wheels, disks and balls that roll, and blades.
        elements: cords and other elements that hold bodies on the coordinate map, with their
            forces; a `Loop` among them is one that the map closes. Where the map leaves open what
            gears, racks and cords along slides tie, they add it.
        switching: dry friction, stops, and contacts that open and close.
        origin: the text it was read from, if it was; equality does not depend on it.
        about: what it is and where it comes from, in lines of text; stands above its equations.

    Raises:
        MechanismError: with every fault found.

    Example:
        >>> m, l = mq.Parameter("m", 2.0, "kg"), mq.Parameter("l", 1.2, "m")
        >>> g = mq.Parameter("g", 9.81, "m/s²")
        >>> bodies = mq.Body("ground"), mq.Body("rod", mq.rod(m, l))
        >>> hinge = mq.Revolute("hinge", "ground", "rod", axis=(0, -1, 0), coordinate="q")
        >>> pendulum = mq.Mechanism(
        ...     "pendulum", bodies, (hinge,), parameters=(m, l, g), gravity=(0, 0, -g)
        ... )
        >>> print(mq.derive(pendulum))
        q'' + 3 g sin(q)/(2 l) = 0
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
            "contacts",
            "elements",
            "switching",
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
        broken = faults(self)
        if broken:
            raise MechanismError(self.name, broken)

    def _collect_driven(self) -> dict[str, Scalar]:
        """The coordinate map, and what follows within joints: of what is driven there, too."""
        driven = dict(self.coordinates.driven)
        for joint in self.joints:
            for name, law in joint.followers.items():
                leaders = symbols_in(law) & driven.keys()
                law = plain(law.subs({coordinate(k): driven[k] for k in leaders}))
                if plain(driven.get(name, law)) != law:
                    raise MechanismError(
                        self.name,
                        [
                            f"the coordinate map sets {name!r}, but within joint {joint.name!r} it "
                            f"follows as {name} = {law}; leave {name!r} out of the map"
                        ],
                    )
                driven[name] = law
        # an unsound mechanism has no map; its faults are reported
        with suppress(MecaniqueError, ArithmeticError, LookupError, TypeError):
            driven |= laws_of_elements(self, driven) if self.elements else {}
        return driven

    def __repr__(self) -> str:
        names = [*self.coordinates[:12], *(["…"] if self.nq > 12 else [])]
        return (
            f"<Mechanism {self.name!r}: {say_count(len(self.bodies), 'body', 'bodies')}, "
            f"{say_count(len(self.joints), 'joint')}, {say_count(len(self.forces), 'force')}, "
            f"q = ({', '.join(names)})>"
        )

    def _repr_html_(self) -> str | None:
        """The figure of the mechanism in a notebook, if pictures can be drawn."""
        return draw("mechanism", self)

    def __getstate__(self) -> dict[str, Any]:
        return {f.name: getattr(self, f.name) for f in fields(self)}
