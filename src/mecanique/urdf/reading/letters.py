"""Letters for numbers in a URDF, and other rotor inertias."""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterable, Iterator, Mapping, Sequence
from dataclasses import replace
from fractions import Fraction
from itertools import product
from typing import TYPE_CHECKING, Any, NamedTuple, TypeAlias

import numpy as np

from mecanique.arrays import Array
from mecanique.errors import InputError, MecaniqueError, UnknownNameError
from mecanique.model.expression import Scalar
from mecanique.model.joint_base import Single
from mecanique.model.mechanism import Mechanism
from mecanique.model.parameters import Parameter
from mecanique.urdf.names import Names

if TYPE_CHECKING:
    from sympy import Expr


MOST = 4
"""At most so many properties become letters at once."""

_DEGREES = {1: 6, 2: 6, 3: 5, 4: 4}
"""The highest total degree, by the number of letters: the inertia of a cylinder by density has 6 at
most in its three letters."""

_EXACT, _NONE = 1e-8, 1e-9
"""Relative errors of what a polynomial gives elsewhere, and terms that are rounding."""

Read = Callable[[Mapping[str, float]], Mechanism]


def with_properties(mechanism: Mechanism, values: Mapping[str, float], read: Read) -> Mechanism:
    """Return a mechanism whose numbers are polynomials in some properties of its file."""
    names, count = tuple(values), len(values)
    if count > MOST:
        raise InputError(f"expected at most {MOST} letters of a xacro file, got {count}")
    degree = _DEGREES[count]
    lattice = [n for n in product(range(degree + 1), repeat=count) if sum(n) <= degree]
    base = np.array([values[name] or 1.0 for name in names])
    random = np.random.default_rng(1788)
    exponents = np.array(lattice)
    points = np.vstack([1.0 + exponents, random.uniform(0.7, 1.9, (2, count))])
    rows = []
    for point in points:
        varied = _read(read, dict(zip(names, (base * point).tolist(), strict=True)))
        _refuse_others(mechanism, varied, names)
        rows.append(varied.evaluate_all(entry.value for entry in _entries(varied)))
    samples = np.array(rows)
    powers = np.prod(points[:, None, :] ** exponents, axis=2)
    fitted = len(lattice)
    terms = np.linalg.solve(powers[:fitted], samples[:fitted])
    size = np.abs(samples).max(axis=0)
    off = np.abs(powers[fitted:] @ terms - samples[fitted:]).max(axis=0)
    entries = list(_entries(mechanism))
    for entry, error, most in zip(entries, off, size, strict=True):
        if error > _EXACT * most:
            raise InputError(
                f"{entry.label} is no polynomial of degree {degree} in {', '.join(names)}; "
                "read the file in numbers"
            )
    moves = np.ptp(samples, axis=0) > _NONE * size
    written = {
        entry.key: _polynomial(column, lattice, names, base)
        for entry, column, moving in zip(entries, terms.T, moves, strict=True)
        if moving
    }
    return _write(mechanism, written, [Parameter(name, values[name]) for name in names])


def _read(read: Read, values: Mapping[str, float]) -> Mechanism:
    try:
        return read(values)
    except MecaniqueError as error:
        with_these = ", ".join(f"{name} = {value!r}" for name, value in values.items())
        raise InputError(
            f"the file cannot be read with {with_these}, so {' and '.join(values)} cannot be "
            f"{'a letter' if len(values) == 1 else 'letters'}: {error}"
        ) from error


def _refuse_others(mechanism: Mechanism, varied: Mechanism, names: Collection[str]) -> None:
    """Refuse what changes otherwise: links, joints, their directions, springs."""
    values = f"the value of {', '.join(names)}"
    if [body.name for body in mechanism.bodies] != [body.name for body in varied.bodies]:
        raise InputError(f"which links there are depends on {values}; read the file in numbers")
    for ours, theirs in zip(mechanism.joints, varied.joints, strict=True):
        if replace(theirs, origin=replace(theirs.origin, xyz=ours.origin.xyz)) != ours:
            raise InputError(
                f"joint {ours.name!r} depends on {values} otherwise than by its place; "
                "read the file in numbers"
            )
    if mechanism.forces != varied.forces or mechanism.loops != varied.loops:
        raise InputError(f"a force or loop depends on {values}; read the file in numbers")


def _polynomial(
    terms: Array, lattice: Sequence[tuple[int, ...]], names: Sequence[str], base: Array
) -> Expr:
    from sympy import Integer, Rational, Symbol

    total: Any = Integer(0)
    for term, exponents in zip(terms.tolist(), lattice, strict=True):
        if abs(term) <= _NONE * float(np.abs(terms).max()):
            continue
        factor = term / float(np.prod(base ** np.array(exponents)))
        near = Fraction(factor).limit_denominator(1000)
        exact = near if abs(float(near) - factor) < _EXACT * abs(factor) else f"{factor:.10g}"
        monomial = Rational(exact)
        for name, exponent in zip(names, exponents, strict=True):
            monomial *= Symbol(name) ** exponent
        total += monomial
    return total


KINDS = ("masses", "lengths", "inertias")
"""Kinds of numbers that get letters together."""

_INERTIA = ("Ixx", "Iyy", "Izz", "Ixy", "Ixz", "Iyz")

Key: TypeAlias = tuple[str, str, str]
"""Where a number stands: "body" or "joint", its name, and the quantity, e.g. "m"."""


class _Entry(NamedTuple):
    """A number that may become a parameter or depend on one."""

    kind: str  # of `KINDS`
    key: Key
    value: Scalar
    unit: str
    meaning: str  # before the name of the body or joint

    @property
    def label(self) -> str:
        """What refusals call it."""
        whose, owner, what = self.key
        called = {"m": "mass"}.get(what, what.removeprefix("c").lower())
        return f"{called} of {'link' if whose == 'body' else whose} {owner!r}"


def _entries(mechanism: Mechanism) -> Iterator[_Entry]:
    """Yield masses, centers and inertias of all bodies, and where the joints stand."""
    for body in mechanism.bodies:
        name = body.name
        yield _Entry("masses", ("body", name, "m"), body.mass, "kg", "mass of")
        for axis, value in zip("xyz", body.center, strict=True):
            meaning = f"{axis} of the center of mass of"
            yield _Entry("lengths", ("body", name, f"c{axis}"), value, "m", meaning)
        for entry, value in zip(_INERTIA, body.inertia, strict=True):
            meaning = f"{entry} about the center of mass of"
            yield _Entry("inertias", ("body", name, entry), value, "kg·m²", meaning)
    for joint in mechanism.joints:
        for axis, value in zip("xyz", joint.origin.xyz, strict=True):
            key = ("joint", joint.name, axis)
            yield _Entry("lengths", key, value, "m", f"{axis} of joint")


def _write(
    mechanism: Mechanism, chosen: Mapping[Key, Scalar], parameters: Iterable[Parameter]
) -> Mechanism:
    """Return a mechanism with other scalars at some places, and the parameters they depend on."""
    bodies, joints = [], []
    for body in mechanism.bodies:
        of = [("body", body.name, what) for what in ("m", "cx", "cy", "cz", *_INERTIA)]
        if chosen.keys() & set(of):
            given = (body.mass, *body.center, *body.inertia)
            mass, *rest = (chosen.get(key, x) for key, x in zip(of, given, strict=True))
            body = body.replace(mass=mass, center=rest[:3], inertia=rest[3:])
        bodies.append(body)
    for joint in mechanism.joints:
        of = [("joint", joint.name, axis) for axis in "xyz"]
        if chosen.keys() & set(of):
            x, y, z = (chosen.get(key, x) for key, x in zip(of, joint.origin.xyz, strict=True))
            joint = replace(joint, origin=replace(joint.origin, xyz=(x, y, z)))
        joints.append(joint)
    return replace(
        mechanism,
        bodies=tuple(bodies),
        joints=tuple(joints),
        parameters=(*mechanism.parameters, *parameters),
    )


def with_armature(mechanism: Mechanism, armature: float | Mapping[str, float] | None) -> Mechanism:
    """Return a mechanism with other rotors: one for all joints, or by name [kg·m² or kg]."""
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
    """Return a mechanism with letters for some of its numbers."""
    if not isinstance(wanted, Collection):
        raise InputError(f"expected names of parameters, e.g. 'masses', got {wanted!r}")
    names = {wanted} if isinstance(wanted, str) else set(wanted)
    if not names:
        return mechanism
    letters = {parameter.symbol: (entry, parameter) for entry, parameter in _letters(mechanism)}
    for name in names:
        if name not in (*KINDS, *letters):
            raise UnknownNameError("parameter", name, (*others, *KINDS, *letters))
    chosen: dict[Key, Parameter] = {
        entry.key: parameter
        for symbol, (entry, parameter) in letters.items()
        if symbol in names or (entry.kind in names and parameter.value)
    }
    return _write(mechanism, chosen, chosen.values())


def _letters(mechanism: Mechanism) -> Iterator[tuple[_Entry, Parameter]]:
    """Yield every number that may get a letter, with a symbol of its own."""
    joints = mechanism.joints
    names = Names(
        (
            "t",
            *(name for joint in joints for name in (*joint.coordinates, *joint.velocities)),
            *mechanism.coordinates,
        )
    )
    for entry in _entries(mechanism):
        whose, owner, what = entry.key
        if (whose, owner) == ("body", mechanism.ground):
            continue
        # a symbol must be an identifier, a link's name need not
        word = "".join(c if f"_{c}".isidentifier() else "_" for c in owner)
        symbol, value = names.free(f"{what}_{word}"), mechanism.evaluate(entry.value)
        yield entry, Parameter(symbol, value, entry.unit, f"{entry.meaning} {owner!r}")
