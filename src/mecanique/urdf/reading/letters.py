"""Letters for numbers in a URDF, and other rotor inertias."""

from __future__ import annotations

from collections.abc import Collection, Iterator, Mapping
from dataclasses import dataclass, replace
from typing import final

from mecanique.errors import InputError, UnknownNameError
from mecanique.model.bodies import Body
from mecanique.model.expression import Scalar, Vector
from mecanique.model.joint_base import Single
from mecanique.model.mechanism import Mechanism
from mecanique.model.parameters import Parameter
from mecanique.urdf.names import Names

KINDS = ("masses", "lengths", "inertias")
"""Kinds of numbers that get letters together."""

_INERTIA = ("Ixx", "Iyy", "Izz", "Ixy", "Ixz", "Iyz")


@final
@dataclass(frozen=True)
class _Letter:
    """A number that may become a parameter.

    Args:
        kind: of `KINDS`.
        key: "body" or "joint", its name, and the quantity, e.g. "m".
        parameter: its replacement.
    """

    kind: str
    key: tuple[str, str, str]
    parameter: Parameter


def with_armature(mechanism: Mechanism, armature: float | Mapping[str, float] | None) -> Mechanism:
    """Return a mechanism with other rotors.

    Args:
        mechanism: as read.
        armature: of all joints with one coordinate, or by name of the joint [kg·m² or kg].
    """
    if armature is None:
        return mechanism
    if isinstance(armature, Mapping):
        for name, value in armature.items():
            mechanism = mechanism.with_joint(name, armature=value)
        return mechanism
    joints = tuple(
        replace(joint, armature=armature) if isinstance(joint, Single) else joint
        for joint in mechanism.joints
    )
    return replace(mechanism, joints=joints)


def with_letters(
    mechanism: Mechanism, wanted: str | Collection[str], others: Collection[str] = ()
) -> Mechanism:
    """Return a mechanism with letters for some of its numbers.

    Args:
        mechanism: as read, in numbers.
        wanted: one of `KINDS`, or a collection of them and of letters.
        others: names that could have been letters as well, in a message.
    """
    if not isinstance(wanted, Collection):
        raise InputError(f"expected names of parameters, e.g. 'masses', got {wanted!r}")
    names = {wanted} if isinstance(wanted, str) else set(wanted)
    if not names:
        return mechanism
    letters = {letter.parameter.symbol: letter for letter in _letters(mechanism)}
    for name in names:
        if name not in (*KINDS, *letters):
            raise UnknownNameError("parameter", name, (*others, *KINDS, *letters))
    chosen = {
        letter.key: letter.parameter
        for symbol, letter in letters.items()
        if symbol in names or (letter.kind in names and letter.parameter.value)
    }

    def put_letters(values: Vector, *keys: tuple[str, str, str]) -> list[Scalar]:
        return [chosen.get(key, x) for key, x in zip(keys, values, strict=True)]

    bodies: list[Body] = []
    for body in mechanism.bodies:
        of = [("body", body.name, what) for what in ("m", "cx", "cy", "cz", *_INERTIA)]
        if chosen.keys() & set(of):
            mass, *rest = put_letters((body.mass, *body.center, *body.inertia), *of)
            body = body.replace(mass=mass, center=rest[:3], inertia=rest[3:])
        bodies.append(body)
    joints = []
    for joint in mechanism.joints:
        of = [("joint", joint.name, axis) for axis in "xyz"]
        if chosen.keys() & set(of):
            x, y, z = put_letters(joint.origin.xyz, *of)
            joint = replace(joint, origin=replace(joint.origin, xyz=(x, y, z)))
        joints.append(joint)
    return replace(
        mechanism,
        bodies=tuple(bodies),
        joints=tuple(joints),
        parameters=(*mechanism.parameters, *chosen.values()),
    )


def _letters(mechanism: Mechanism) -> Iterator[_Letter]:
    """Yield every number that may get a letter, with a symbol of its own."""
    joints = mechanism.joints
    names = Names(
        (
            "t",
            *(name for joint in joints for name in (*joint.coordinates, *joint.velocities)),
            *mechanism.coordinates,
        )
    )

    def letter(
        kind: str, key: tuple[str, str, str], value: Scalar, unit: str, meaning: str
    ) -> _Letter:
        _, owner, what = key
        # a symbol must be an identifier, a link's name need not
        word = "".join(c if f"_{c}".isidentifier() else "_" for c in owner)
        symbol = names.free(f"{what}_{word}")
        parameter = Parameter(symbol, mechanism.evaluate(value), unit, f"{meaning} {owner!r}")
        return _Letter(kind, key, parameter)

    for body in mechanism.bodies:
        if body.name == mechanism.ground:
            continue
        name = body.name
        yield letter("masses", ("body", name, "m"), body.mass, "kg", "mass of")
        for axis, value in zip("xyz", body.center, strict=True):
            meaning = f"{axis} of the center of mass of"
            yield letter("lengths", ("body", name, f"c{axis}"), value, "m", meaning)
        for entry, value in zip(_INERTIA, body.inertia, strict=True):
            meaning = f"{entry} about the center of mass of"
            yield letter("inertias", ("body", name, entry), value, "kg·m²", meaning)
    for joint in joints:
        for axis, value in zip("xyz", joint.origin.xyz, strict=True):
            yield letter("lengths", ("joint", joint.name, axis), value, "m", f"{axis} of joint")
