"""Write contacts and velocity constraints in closed form: Φ = 0 along a normal, else ψ = 0.

Here ψ = A v − b. The point of contact has the velocity v_C + ω × ρ, where ρ leads to it from the
hub. On a plane with the normal n, ρ is opposite to n for a ball, and opposite to the part of n
normal to e for a wheel with the unit axis e. Each multiplier is a component of the force on the
body that rolls or has the blade.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from itertools import chain
from typing import NamedTuple, final

from mecanique.derivation.mechanics.contacts import touch
from mecanique.derivation.scalars.cancel import tidy, without_rounding
from mecanique.derivation.scalars.elementary import root_of_square
from mecanique.derivation.scalars.series import Kind, Ring, Series
from mecanique.derivation.symbolic.derivation import Assumption, Tie
from mecanique.derivation.symbolic.kinematics import ORIGIN, Kinematics
from mecanique.derivation.symbolic.vectors import (
    SymbolicWrench,
    Vector,
    cross,
    dot,
    lift,
    resultant,
    total,
    zero,
)
from mecanique.model.constraints.contacts import Contact, Rolling
from mecanique.model.constraints.loops import Loop
from mecanique.model.mechanism.letters import call


@final
@dataclass(frozen=True)
class Bond:
    """A contact or a loop cut open, in the world's axes."""

    name: str  # how its force is called among those on a body
    # where its force acts on the body that rolls or has the blade, or on body b of a loop [m], and
    # its opposite on the other
    ends: tuple[tuple[str, Vector], tuple[str, Vector]]
    ties: tuple[Tie, ...]  # its equations
    units: tuple[
        SymbolicWrench, ...
    ]  # force and couple on the first body for λ = 1 of each equation
    assumptions: tuple[Assumption, ...] = ()  # the assumptions of these equations
    distances: tuple[tuple[Series, str], ...] = ()  # roots that are distances, and their meanings

    @property
    def wrench(self) -> SymbolicWrench:
        """The force and the couple on the first body, in terms of its multipliers."""
        nothing = zero(self.ends[0][1].x.ring)
        pairs = zip(self.units, self.ties, strict=True)
        acting = [unit * tie.multiplier for unit, tie in pairs]
        return resultant([SymbolicWrench(nothing, nothing), *acting])


def distances_of(bonds: Sequence[Bond]) -> list[tuple[Series, str]]:
    """Return the roots that are distances at contacts, and their meanings."""
    return [distance for bond in bonds for distance in bond.distances]


def bonds_of(kinematics: Kinematics) -> tuple[Bond, ...]:
    """Return all contacts, then all loops of a mechanism."""
    mechanism = kinematics.algebra.mechanism
    contacts = [_write_contact(kinematics, contact) for contact in mechanism.contacts]
    return (*contacts, *(_cut_open(kinematics, loop) for loop in mechanism.loops))


def ties_of(kinematics: Kinematics, bonds: Sequence[Bond]) -> tuple[Tie, ...]:
    """Return the equations of all loops, then of contacts, then of velocity constraints."""
    met = sorted((tie for bond in bonds for tie in bond.ties), key=lambda tie: tie.of_contact)
    return (*met, *_velocity_constraints(kinematics))


def _write_contact(kinematics: Kinematics, contact: Contact) -> Bond:
    algebra, ring = kinematics.algebra, kinematics.algebra.ring
    assumptions, roots = list[Assumption](), list[Series]()

    def root(square: Series) -> Series:
        length = algebra.root(square)
        roots.append(length)
        return length

    def stretch(vector: Sequence[Series], length: Series) -> list[Series]:
        across = lift(ring, vector).tidy()
        square = tidy(dot(across, across))
        size = root_of_square(square) or algebra.root(square)
        if size.parts.keys() != {0}:
            subject = f"the cosine of the lean of {call(contact.body)} at {call(contact.name)}"
            assumptions.append(Assumption(subject, size))
        return [*(Vector(*(tidy(part / size) for part in across)) * length)]

    ground = replace(kinematics.ground, stretch=stretch, root=root)
    met = touch(algebra.mechanism, contact, ground)
    place, *directions = (lift(ring, vector).tidy() for vector in (met.place, *met.directions))
    hub = kinematics.point(contact.body, contact.seat)
    # of the point of contact, or of the hub where ω × ρ is added in each direction by itself
    rolls = _move(kinematics, contact.body, hub if met.arms else place)
    below = _move(kinematics, contact.on, place)
    relative = total(rolls).tidy() - total(below).tidy()
    arms = [lift(ring, arm) for arm in met.arms or ()] or [zero(ring)] * len(directions)
    spin = kinematics.between(kinematics.spin(contact.body), kinematics.carrier(contact.body), -1)
    ties, units = list[Tie](), list[SymbolicWrench]()
    for row, direction, arm in zip(contact.rows, directions, arms, strict=True):
        if isinstance(contact, Rolling) and row == "normal":
            start = kinematics.point(contact.on, contact.plane.xyz)
            summed = chain(hub, place - hub, start)
            demand = without_rounding(tidy(algebra.lift(met.gap)), summed)
            what = "normal force of"
        else:
            slip = dot(direction, relative) + dot(arm, spin)
            demand = without_rounding(tidy(slip), chain(*rolls, *below))
            what = f"friction along {row} of the plane of"
        meaning = f"{what} {call(contact.on)} on {call(contact.body)} at {call(contact.name)} [N]"
        if row == "side":
            bodies = f"{call(contact.on)} on {call(contact.body)}"
            meaning = f"force of {bodies} across the blade {contact.name} [N]"
        name = f"{contact.name}_{row}"
        if not demand.vanishes():  # what the joints keep already needs no force
            tie = _tie(kinematics, name, demand, meaning, of_velocities=row != "normal")
            ties.append(replace(tie, foot=tidy(algebra.lift(met.foot))))
            units.append(SymbolicWrench(direction, zero(ring)))
    sphere = isinstance(contact, Rolling) and contact.curved
    from_where = "that of the sphere" if sphere else "the plane"
    center = f"the center of {call(contact.body)}"
    distance = f"distance of {center} from {from_where} at {call(contact.name)} [m]"
    return Bond(
        name=contact.name,
        ends=((contact.body, place), (contact.on, place)),
        ties=tuple(ties),
        units=tuple(units),
        assumptions=tuple(assumptions),
        distances=tuple((length, distance) for length in roots),
    )


def _velocity_constraints(kinematics: Kinematics) -> Iterator[Tie]:
    algebra = kinematics.algebra
    velocities = algebra.velocities
    for constraint in algebra.mechanism.velocity_constraints:
        terms = [
            algebra.series(A) * algebra.ring[name]
            for name, A in zip(velocities, constraint.along(velocities), strict=True)
        ]
        demand = algebra.ring.sum([*terms, -algebra.series(constraint.rate)])
        meaning = f"multiplier of the velocity constraint {constraint.name}"
        yield _tie(kinematics, constraint.name, demand, meaning, True)


def _tie(
    kinematics: Kinematics, name: str, demand: Series, meaning: str, of_velocities: bool
) -> Tie:
    multiplier = kinematics.algebra.ring.unknown(f"lambda_{name}", Kind.REACTION)
    return Tie(name, demand, multiplier, meaning, of_velocities, of_contact=True)


def _move(kinematics: Kinematics, body: str, place: Vector) -> tuple[Vector, Vector]:
    """Return a body's velocity at its origin, and what turning adds at a place, world axes."""
    if kinematics.place[body] < 0:
        return (zero(kinematics.algebra.ring),) * 2
    carrier = kinematics.carrier(body)
    v, w = (
        kinematics.between(vector, carrier, -1)
        for vector in (kinematics.velocity(body), kinematics.spin(body))
    )
    return v, cross(w, place - kinematics.point(body, ORIGIN))


_TURNS: dict[str, dict[str, tuple[tuple[int, int, int], ...]]] = {
    "plate": {"rz": ((1, 1, 0),)},
    "hinge": {"rx": ((-1, 1, 2),), "ry": ((1, 0, 2),)},
    "weld": {
        "rx": ((1, 2, 1), (-1, 1, 2)),
        "ry": ((1, 0, 2), (-1, 2, 0)),
        "rz": ((1, 1, 0), (-1, 0, 1)),
    },
}
"""Φ by kind of loop and row about an axis: the mean of ± a_i · b_k, axes of the two frames."""


class _Row(NamedTuple):
    """One equation of a loop."""

    name: str
    demand: Series  # Φ
    meaning: str  # of λ
    unit: SymbolicWrench  # its force and moment at λ = 1


def _cut_open(kinematics: Kinematics, loop: Loop) -> Bond:
    ring = kinematics.algebra.ring
    ends = (loop.body_a, loop.frame_a), (loop.body_b, loop.frame_b)
    (A, start), (B, end) = (kinematics.ground.frame(*frame) for frame in ends)
    a, b = [lift(ring, axis) for axis in A], [lift(ring, axis) for axis in B]
    on_a, on_b = lift(ring, start), lift(ring, end)
    within = _plane(a[2]) if loop.kind in ("pin", "plate") else None
    turning = loop.kind in ("pin", "plate") and within is None
    ties, units, one = list[Tie](), list[SymbolicWrench](), ring.number(1)
    for row, demand, meaning, unit in (
        *_along(kinematics, loop, a, on_b - on_a, within),
        *_about(kinematics.algebra.ring, loop, a, b),
    ):
        summed = [one] if row.startswith("r") else [*on_a, *on_b]
        demand = without_rounding(tidy(demand), summed)
        if not demand.vanishes():
            name = f"{loop.name}_{row}"
            multiplier = ring.unknown(f"lambda_{name}", Kind.REACTION)
            ties.append(Tie(name, demand, multiplier, meaning))
            units.append(unit)
    # axes that turn with body a carry the force's point of action along
    return Bond(
        name=f"the loop {loop.name}",
        ends=((loop.body_b, on_b), (loop.body_a, on_b if turning else on_a)),
        ties=tuple(ties),
        units=tuple(units),
    )


def _along(
    kinematics: Kinematics, loop: Loop, a: Sequence[Vector], p: Vector, within: int | None
) -> Iterator[_Row]:
    """Yield the equations that keep the ends together, or at a distance."""
    algebra = kinematics.algebra
    ring, nothing = algebra.ring, zero(algebra.ring)
    if loop.kind == "distance":
        length = algebra.series(loop.length)
        meaning = f"push of the rod {loop.name} over its length [N/m]"
        yield _Row("l", (dot(p, p) - length * length) / 2, meaning, SymbolicWrench(p, nothing))
        return
    world = [lift(ring, axis) for axis in ((1, 0, 0), (0, 1, 0), (0, 0, 1))]
    flat = loop.kind in ("pin", "plate")
    turning = flat and within is None
    axes, whose = (a, f"the frame in {loop.body_a}") if turning else (world, "the world")
    for k in (0, 1) if turning else [k for k in range(3) if k != within]:
        meaning = f"force {_on(loop)}, {'xyz'[k]} component in the axes of {whose} [N]"
        yield _Row("xyz"[k], dot(axes[k], p), meaning, SymbolicWrench(axes[k], nothing))


def _about(ring: Ring, loop: Loop, a: Sequence[Vector], b: Sequence[Vector]) -> Iterator[_Row]:
    """Yield the equations that keep axes parallel."""
    # In the rotation δφ of b relative to a, a·b changes by (b × a)·δφ
    nothing = zero(ring)
    for row, terms in _TURNS.get(loop.kind, {}).items():
        whole = ring.sum([dot(a[i], b[k]) * sign for sign, i, k in terms])
        turn = total([cross(b[k], a[i]) * sign for sign, i, k in terms])
        meaning = f"moment {_on(loop)}, about {row[1]} of its frame in {loop.body_a} [N m]"
        mean = Vector(*(part / len(terms) for part in turn))
        yield _Row(row, whole / len(terms), meaning, SymbolicWrench(nothing, mean))


def _on(loop: Loop) -> str:
    return f"of {call(loop.body_a)} on {call(loop.body_b)} in the loop {loop.name}"


def _plane(normal: Vector) -> int | None:
    """Return the world's axis that is the constant normal of a plane, None without one."""
    one = normal.x.ring.number(1)
    still = [k for k, c in enumerate(normal) if (tidy(c) ** 2 - one).vanishes()]
    return still[0] if still else None
