"""SI units of coordinates and velocities, and the length that is compared with one radian."""

from __future__ import annotations

import math
from collections.abc import Collection

import numpy as np

from mecanique.arrays import Array, median
from mecanique.model.expression import Scalar
from mecanique.model.force_base import LineLoad
from mecanique.model.joint_base import UNITS
from mecanique.model.mechanism import Mechanism
from mecanique.model.mechanism.homogeneity import dimensions_of
from mecanique.model.units import PURE, say_unit

_NONE = 1e-6
"""Lengths up to this count as none [m]."""


def units(mechanism: Mechanism) -> dict[str, str]:
    """Return the unit of each coordinate and velocity, by name; "" where it is unknown.

    A generalized coordinate that is no joint's own has the unit that the coordinate map asks for.
    """
    by_coordinate: dict[str, str] = {}
    quasi: dict[str, str] = {}
    for joint in mechanism.joints:
        by_coordinate |= zip(joint.coordinates, (UNITS[kind] for kind in joint.kinds), strict=True)
        if joint.quaternion:
            quasi |= dict.fromkeys(joint.linear_velocities, "m/s")
            quasi |= dict.fromkeys(joint.angular_velocities, "rad/s")
    inferred = dimensions_of(mechanism).states
    for name in mechanism.coordinates:
        if name not in by_coordinate:
            unit = say_unit(inferred[name]) if name in inferred else ""
            by_coordinate[name] = "rad" if inferred.get(name) == PURE else unit
    by_name = {name: by_coordinate[name] for name in mechanism.coordinates}
    for name in mechanism.velocities:
        by_name[name] = quasi[name] if name in quasi else per_second(by_coordinate[name[:-1]])
    return by_name


def characteristic_length(mechanism: Mechanism, among: Collection[str] | None = None) -> float:
    """Return the median of the lengths that a description states, or 1 if it states none [m].

    Of a closed mechanism they are those from joint to joint, of joints and loops; of a tree, whose
    joints may state none, also the centers of mass and the ends and free lengths of forces.
    """

    def counts(name: str) -> bool:
        return among is None or name in among

    vectors: list[tuple[Scalar, ...]] = [j.origin.xyz for j in mechanism.joints if counts(j.name)]
    for loop in mechanism.loops:
        if counts(loop.name):
            vectors += [loop.frame_a.xyz, loop.frame_b.xyz, (loop.length,)]
    for contact in mechanism.contacts:
        if counts(contact.name):
            vectors += [(size,) for size in contact.sizes]
    if not mechanism.loops:
        vectors += [body.center for body in mechanism.bodies]
        for force in mechanism.forces:
            if isinstance(force, LineLoad):
                vectors += [stated.scalars for stated in force.stated if stated.length]
    lengths = [math.hypot(*mechanism.evaluate_all(vector)) for vector in vectors]
    known = [length for length in lengths if length > _NONE]
    return median(known) if known else 1.0


def velocity_scales(mechanism: Mechanism, lengths: np.ndarray | None = None) -> np.ndarray:
    """Return the unit of each velocity, shape (nv,): a length, or one radian; lengths (nv,)."""
    length = characteristic_length(mechanism) if lengths is None else lengths
    return np.where(turns(mechanism), 1, length)


def turns(mechanism: Mechanism) -> np.ndarray:
    """Return which velocities are angular, shape (nv,)."""
    linear = [name for joint in mechanism.joints for name in joint.linear_velocities]
    return ~np.isin(mechanism.velocities, linear)


def per_second(unit: str) -> str:
    """Return the unit of a rate."""
    if not unit:
        return ""
    if unit == "1":
        return "1/s"
    return f"{unit[:-2]}/s²" if unit.endswith("/s") else f"{unit}/s"


def add_unit(name: str, unit: str) -> str:
    """Return a name with its unit in brackets, if there is one."""
    return f"{name} [{unit}]" if unit else name


def coordinate_scales(mechanism: Mechanism, velocities: Array, length: float) -> Array:
    """Return the natural unit of each coordinate, by those of the velocities and a length."""
    # where coordinates are no integrals of velocities, all have the lesser of both kinds of units
    return (
        velocities if len(velocities) == mechanism.nq else np.full(mechanism.nq, min(1.0, length))
    )
