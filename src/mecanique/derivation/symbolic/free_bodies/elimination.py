"""Eliminate the reactions from the tips to the ground, by the wrench that each joint must transmit.

A body needs F = d/dt p − m g − F_applied + Σ F_child from its joint, and likewise moments about the
origin of its frame: equations are solved only by moving terms, which keeps closed forms short.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import final

from mecanique.derivation.scalars.cancel import tidy
from mecanique.derivation.scalars.series import Series
from mecanique.derivation.symbolic.free_bodies.bodies import Cut, Cuts
from mecanique.derivation.symbolic.symbols import Algebra
from mecanique.derivation.symbolic.vectors import Vector, Wrench, cross, dot, lift, total
from mecanique.derivation.tree.links import Link
from mecanique.derivation.tree.poses import combination


@final
@dataclass(frozen=True)
class JointRate:
    """A joint velocity with its direction and its derivatives by the generalized velocities.

    Args:
        body: the child that it moves.
        kind: "force" or "moment", the part of a reaction that does work with it.
        axis: its direction in the axes of the child's carrier.
        name: name of the joint coordinate or quasi-velocity.
        partials: its derivative by each generalized velocity.
        rotor: moment or force that accelerates the joint's rotor.
    """

    body: str
    kind: str
    axis: Vector
    name: str
    partials: tuple[Series, ...]
    rotor: Series


def demands(
    cuts: Cuts,
    part: Callable[[Cut], Wrench],
    free: Mapping[str, Sequence[JointRate]] | None = None,
) -> dict[str, Wrench]:
    """Return the wrench that every joint must transmit, by name of its child.

    Force and moment are in the axes of the child's carrier, the moment about the child's origin.

    Args:
        cuts: the bodies.
        part: returns the wrench that a body by itself needs from its joint.
        free: by name of the child, the joint velocities along which its joint transmits only the
            force of its rotor; by default these components are what the bodies beyond need.
    """
    found: dict[str, Wrench] = {}
    behind: dict[str, list[str]] = {}
    for cut in cuts.bodies:
        behind.setdefault(cut.joint.parent, []).append(cut.body)
    for cut in reversed(cuts.bodies):
        own = part(cut)
        forces, moments = [own.force], [own.moment]
        for child in behind.get(cut.body, ()):
            carried = cuts.carried_wrench(found[child], child, cut.body)
            arm = cuts.between_seats(cut.body, child)
            forces.append(carried.force)
            moments += [carried.moment, cross(arm, carried.force)]
        sums = {"force": total(forces), "moment": total(moments)}
        for rate in () if free is None else free[cut.body]:
            size = dot(rate.axis, sums[rate.kind]) + rate.rotor
            sums[rate.kind] = sums[rate.kind] - rate.axis * size
        found[cut.body] = Wrench(**sums).tidy()
    return found


def joint_rates(cuts: Cuts) -> tuple[JointRate, ...]:
    """Return the joint velocities in the order of the tree."""
    child = {joint.name: joint.child for joint in cuts.algebra.mechanism.joints}
    found: list[JointRate] = []
    for place, link in enumerate(cuts.kinematics.tree):
        if link.kind in ("turn", "slide"):
            found.append(_find_axial(cuts, place, child[link.joint]))
        elif link.kind in ("ball", "free"):
            found += _list_quasi(cuts.algebra, link, child[link.joint])
    return tuple(found)


def _find_axial(cuts: Cuts, place: int, body: str) -> JointRate:
    """Return the joint velocity of a hinge or a slide."""
    algebra, link = cuts.algebra, cuts.kinematics.tree[place]
    r = algebra.lift(algebra.values[link.coordinates[0]])
    axis = [algebra.arithmetic(component, {}) for component in link.axis]
    turn = cuts.kinematics.turn(place)
    inertia = algebra.series(link.armature)
    return JointRate(
        body=body,
        kind="moment" if link.kind == "turn" else "force",
        axis=lift(algebra.ring, [combination(row, axis) for row in turn]).tidy(),
        name=link.coordinates[0],
        partials=tuple(tidy(slope) for slope in algebra.ring.along(r)),
        rotor=tidy(inertia * r.ddt().ddt()) if inertia else algebra.ring.number(0),
    )


def _list_quasi(algebra: Algebra, link: Link, body: str) -> Iterator[JointRate]:
    """Yield the quasi-velocities of a quaternion joint, along and about the child's own axes."""
    number = algebra.ring.number
    kinds = ("force",) * (len(link.velocities) - 3) + ("moment",) * 3
    for k, (name, kind) in enumerate(zip(link.velocities, kinds, strict=True)):
        axis = Vector(*(number(int(i == k % 3)) for i in range(3)))
        partials = tuple(number(int(v == name)) for v in algebra.velocities)
        yield JointRate(
            body=body, kind=kind, axis=axis, name=name, partials=partials, rotor=number(0)
        )


def project(
    cuts: Cuts, rates: Iterable[JointRate], found: Mapping[str, Wrench], *, rotors: bool
) -> list[Series]:
    """Project reactions on the generalized velocities: Σ ∂u/∂v × (reaction · axis + rotor)."""
    ring = cuts.algebra.ring
    sums: list[list[Series]] = [[] for _ in cuts.algebra.velocities]
    for rate in rates:
        size = dot(rate.axis, found[rate.body].part(rate.kind))
        if rotors:
            size = size + rate.rotor
        for terms, slope in zip(sums, rate.partials, strict=True):
            if slope:
                terms.append(tidy(slope * size))
    return [tidy(ring.sum(terms)) for terms in sums]
