"""Match the bodies and joints of two descriptions: by name, else by their numbers."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from typing import final

import numpy as np

from mecanique.arrays import Array
from mecanique.model.bodies import Body
from mecanique.model.bodies.tensor import tensor_of
from mecanique.model.joints import Fixed, Joint
from mecanique.model.mechanism import Mechanism

_EQUAL = 1e-9
"""Relative difference of numbers that were written and read again."""


@final
@dataclass(frozen=True)
class Pairs:
    """The matching bodies and joints.

    Args:
        bodies: name in the second description, by name in the first.
        joints: the same of joints.
    """

    bodies: dict[str, str]
    joints: dict[str, str]


def pair(a: Mechanism, b: Mechanism) -> Pairs:
    """Return the matching bodies and joints of two mechanisms.

    Args:
        a: the first.
        b: the second.
    """
    bodies = _by_name((x.name for x in a.bodies), (x.name for x in b.bodies))
    joints = _by_name((x.name for x in a.joints), (x.name for x in b.joints))
    into_b = {joint.child: joint for joint in b.joints}
    grown = True
    while grown:
        grown = False
        for one in a.tree:
            # a joint that keeps its name, or whose child does, shows what the other is called
            other = b.joint(joints[one.name]) if one.name in joints else None
            if other is None and one.child in bodies:
                found = into_b.get(bodies[one.child])
                if found is not None and found.name not in joints.values():
                    joints[one.name] = found.name
                    grown = True
            elif other is not None and one.child not in bodies:
                if other.child not in bodies.values():
                    bodies[one.child] = other.child
                    grown = True
            elif other is None and bodies.get(one.parent) is not None:
                alike = [
                    joint
                    for joint in b.joints
                    if joint.name not in joints.values()
                    and joint.parent == bodies[one.parent]
                    and joint.child not in bodies.values()
                    and _alike(one, joint, a.body(one.child), b.body(joint.child))
                ]
                if len(alike) == 1:
                    joints[one.name], bodies[one.child] = alike[0].name, alike[0].child
                    grown = True
    if a.ground not in bodies and b.ground not in bodies.values():
        bodies[a.ground] = b.ground
    return Pairs(bodies, joints)


def numbers_of(body: Body) -> tuple[float, Array, Array]:
    """Return mass, center of mass and inertia tensor about it, as numbers."""
    center = np.array(body.center, dtype=float)
    return float(body.mass), center, tensor_of(map(float, body.inertia))


def _by_name(first: Iterable[str], second: Iterable[str]) -> dict[str, str]:
    known = set(second)
    return {name: name for name in first if name in known}


def _alike(one: Joint, other: Joint, body: Body, twin: Body) -> bool:
    """Whether two joints with other names and their children are the same in all numbers."""
    if type(one) is not type(other) or isinstance(one, Fixed) != isinstance(other, Fixed):
        return False
    origins = [
        np.array([*joint.origin.xyz, *np.ravel(joint.origin.rotation)], dtype=float)
        for joint in (one, other)
    ]
    (m, c, inertia), (n, d, moment) = numbers_of(body), numbers_of(twin)
    return (
        np.allclose(origins[0], origins[1], rtol=0, atol=_EQUAL)
        and abs(m - n) <= _EQUAL * max(m, n)
        and np.allclose(c, d, rtol=0, atol=_EQUAL)
        and np.allclose(inertia, moment, rtol=1e-6, atol=_EQUAL * max(np.abs(inertia).max(), 1e-12))
    )
