"""Reactions eliminated from the tips of the tree to the ground, in series: what each joint must transmit.

For a body with all that hangs on it, F = d/dt p − m g − F_applied + Σ F_child, and the same for
moments about the origin of the body's frame: no equation is ever solved but by moving terms, so
that closed forms stay short.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import final

from mecanique.derivation.scalars.cancel import tidy
from mecanique.derivation.scalars.series import Series
from mecanique.derivation.symbolic.free_bodies import Cut, Cuts
from mecanique.derivation.symbolic.vectors import Vector, cross, total
from mecanique.derivation.tree.poses import combination

__all__ = ["Demand", "JointRate", "demands", "joint_rates", "project"]


@final
@dataclass(frozen=True)
class Demand:
    """What a joint must transmit to its child, in the axes of the child's carrier.

    Args:
        force: shape (3,) [N].
        moment: shape (3,), about the origin of the child's frame [N·m].
    """

    force: Vector
    moment: Vector


@final
@dataclass(frozen=True)
class JointRate:
    """One joint velocity: which reaction component does work in it, and how it follows the coordinates.

    Args:
        body: the child that it moves.
        kind: "force" or "moment".
        axis: shape (3,), its direction in the axes of the child's carrier.
        name: of the joint coordinate or quasi-velocity.
        partials: its derivative by each generalized velocity.
        rotor: moment or force that the joint's rotor takes.
    """

    body: str
    kind: str
    axis: Vector
    name: str
    partials: tuple[Series, ...]
    rotor: Series


def demands(
    cuts: Cuts,
    part: Callable[[Cut], tuple[Vector, Vector]],
    free: Mapping[str, Sequence[JointRate]] | None = None,
) -> dict[str, Demand]:
    """Return what every joint must transmit, by name of its child.

    Args:
        cuts: the bodies.
        part: gives the force and the moment about its origin that a body needs from its joint by
            itself.
        free: by name of the child, the motions in which its joint transmits nothing but what its
            rotor takes, which is then used; left out, the components there are kept as the bodies
            beyond need them.
    """
    algebra = cuts.algebra
    found: dict[str, Demand] = {}
    behind: dict[str, list[str]] = {}
    for cut in cuts.bodies:
        behind.setdefault(cut.joint.parent, []).append(cut.body)
    for cut in reversed(cuts.bodies):
        force, moment = part(cut)
        forces, moments = [force], [moment]
        for child in behind.get(cut.body, ()):
            push = cuts.carried(found[child].force, child, cut.body)
            forces.append(push)
            moments += [
                cuts.carried(found[child].moment, child, cut.body),
                cross(cuts.between_seats(cut.body, child), push),
            ]
        sums = {"force": total(algebra, forces), "moment": total(algebra, moments)}
        for rate in () if free is None else free[cut.body]:
            vector = sums[rate.kind]
            size = (
                algebra.ring.sum([a * c for a, c in zip(rate.axis, vector, strict=True)])
                + rate.rotor
            )
            sums[rate.kind] = [c - size * a for a, c in zip(rate.axis, vector, strict=True)]
        found[cut.body] = Demand(*([tidy(c) for c in sums[kind]] for kind in ("force", "moment")))
    return found


def joint_rates(cuts: Cuts) -> tuple[JointRate, ...]:
    """Return the joint velocities in the order of the tree.

    Args:
        cuts: the bodies.
    """
    algebra, kinematics = cuts.algebra, cuts.kinematics
    child = {joint.name: joint.child for joint in algebra.mechanism.joints}
    nothing = algebra.ring.number(0)
    found = []
    for place, link in enumerate(kinematics.tree):
        body = child[link.joint]
        turn = kinematics.turn(place)
        if link.kind in ("turn", "slide"):
            r = algebra.lifted(algebra.values[link.coordinates[0]])
            axis = [algebra.arithmetic(component, {}) for component in link.axis]
            direction = [tidy(algebra.lifted(combination(row, axis))) for row in turn]
            inertia = algebra.series(link.armature)
            rotor = tidy(inertia * r.ddt().ddt()) if inertia else nothing
            kind = "moment" if link.kind == "turn" else "force"
            partials = tuple(tidy(slope) for slope in algebra.along(r))
            found.append(JointRate(body, kind, direction, link.coordinates[0], partials, rotor))
        elif link.kind in ("ball", "free"):
            kinds = ("force",) * (len(link.velocities) - 3) + ("moment",) * 3
            for k, name in enumerate(link.velocities):
                axis = [algebra.ring.number(1 if i == k % 3 else 0) for i in range(3)]
                partials = tuple(
                    algebra.ring.number(1 if v == name else 0) for v in algebra.velocities
                )
                found.append(JointRate(body, kinds[k], axis, name, partials, nothing))
    return tuple(found)


def project(
    cuts: Cuts, rates: tuple[JointRate, ...], found: dict[str, Demand], *, rotors: bool
) -> list[Series]:
    """Return the work of reactions by each virtual displacement: Σ ∂u/∂v × (component along the joint + rotor).

    Args:
        cuts: the bodies.
        rates: the joint velocities.
        found: what the joints transmit.
        rotors: whether the rotors are counted.
    """
    ring = cuts.algebra.ring
    sums: list[list[Series]] = [[] for _ in cuts.algebra.velocities]
    for rate in rates:
        demand = found[rate.body]
        vector = demand.force if rate.kind == "force" else demand.moment
        size = ring.sum([a * c for a, c in zip(rate.axis, vector, strict=True)])
        if rotors:
            size = size + rate.rotor
        for terms, slope in zip(sums, rate.partials, strict=True):
            if slope:
                terms.append(tidy(slope * size))
    return [tidy(ring.sum(terms)) for terms in sums]
