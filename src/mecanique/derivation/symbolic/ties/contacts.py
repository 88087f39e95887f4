"""Write contacts and velocity constraints in closed form: Φ = 0 along a normal, else ψ = 0.

Here ψ = A v − b. The point of contact has the velocity v_C + ω × ρ, where ρ leads to it from the
hub. On a plane with the normal n, ρ is opposite to n for a ball, and opposite to the part of n
normal to e for a wheel with the unit axis e. Each multiplier is a component of the force on the
body that rolls or has the blade.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import final

from mecanique.derivation.scalars.cancel import tidy, without_rounding
from mecanique.derivation.scalars.cosines import over_length, root_of_square
from mecanique.derivation.scalars.generators import Kind
from mecanique.derivation.scalars.series import Series
from mecanique.derivation.symbolic.kinematics import ORIGIN, Kinematics
from mecanique.derivation.symbolic.lines_of_action import Assumption
from mecanique.derivation.symbolic.ties.tie import Tie
from mecanique.derivation.symbolic.vectors import Vector, cross, dot, lift, total, zero
from mecanique.derivation.tree.poses import combination, origin, product, transpose
from mecanique.errors import DerivationError
from mecanique.model.constraints.contacts import Blade, Contact, Rolling


@final
@dataclass(frozen=True)
class Touch:
    """A contact with its place and its equations, in the world's axes.

    Args:
        contact: the contact.
        place: point of contact [m].
        directions: direction of each row.
        ties: equation of each row.
        assumptions: the assumptions of these equations.
    """

    contact: Contact
    place: Vector
    directions: tuple[Vector, ...]
    ties: tuple[Tie, ...]
    assumptions: tuple[Assumption, ...] = ()

    @property
    def force(self) -> Vector:
        """The force on the body that rolls or has the blade, in terms of its multipliers [N]."""
        pairs = zip(self.directions, self.ties, strict=True)
        return total([direction * tie.multiplier for direction, tie in pairs])


def contact_ties(kinematics: Kinematics, met: Sequence[Touch]) -> tuple[Tie, ...]:
    """Return the equations of all contacts, then of all velocity constraints.

    Args:
        kinematics: the kinematics of the mechanism.
        met: its contacts.
    """
    found = [tie for touch in met for tie in touch.ties if not tie.demand.vanishes()]
    return (*found, *_velocity_constraints(kinematics))


def touches(kinematics: Kinematics) -> tuple[Touch, ...]:
    """Return all contacts of a mechanism.

    Args:
        kinematics: the kinematics of the mechanism.
    """
    return tuple(
        _roll(kinematics, contact) if isinstance(contact, Rolling) else _cut(kinematics, contact)
        for contact in kinematics.algebra.mechanism.contacts
    )


def _roll(kinematics: Kinematics, contact: Rolling) -> Touch:
    if contact.curved or contact.stretched:
        what = "a ball in a bowl or on a dome" if contact.curved else "an ellipsoid"
        raise DerivationError(
            f"contact {contact.name!r} is that of {what}; such equations are computed, not written "
            "out"
        )
    algebra = kinematics.algebra
    plane = origin(contact.plane, algebra.values, algebra.arithmetic)
    frame = product(kinematics.pose(contact.on), plane)
    x, y, n, start = (lift(algebra.ring, column).tidy() for column in transpose(frame))
    hub = kinematics.point(contact.body, contact.center).tidy()
    crown = algebra.series(contact.crown)
    rho, assumptions = -(n * crown), list[Assumption]()
    if contact.axis is not None:
        turn = [row[:3] for row in kinematics.pose(contact.body)]
        given = [algebra.arithmetic(c, {}) for c in contact.axis]
        e = lift(algebra.ring, [combination(row, given) for row in turn]).tidy()
        across = (n - e * tidy(dot(n, e))).tidy()
        square = algebra.ring.number(1) - tidy(dot(n, e)) ** 2
        length = root_of_square(square) or algebra.root(square)
        if length.parts.keys() != {0}:
            subject = f"the cosine of the lean of {contact.body} at {contact.name}"
            assumptions.append(Assumption(subject, length))
        up = Vector(*over_length([*across], length))
        rho = (rho - up * (algebra.series(contact.radius) - crown)).tidy()
    place = (hub + rho).tidy()
    gap = without_rounding(tidy(dot(n, place - start)), [*place, *start])
    moved = [_velocity(kinematics, body, place) for body in (contact.body, contact.on)]
    along_x, along_y = (
        without_rounding(tidy(dot(e, moved[0] - moved[1])), [*moved[0], *moved[1]]) for e in (x, y)
    )
    rows = (("normal", n, gap, False), ("x", x, along_x, True), ("y", y, along_y, True))
    of = f"of {contact.on} on {contact.body} at {contact.name}"
    ties = []
    for row, _, demand, of_velocities in rows:
        what = "normal force" if row == "normal" else f"friction along {row} of the plane"
        ties.append(
            _tie(kinematics, f"{contact.name}_{row}", demand, f"{what} {of} [N]", of_velocities)
        )
    directions = tuple(direction for _, direction, _, _ in rows)
    return Touch(contact, place, directions, tuple(ties), tuple(assumptions))


def _cut(kinematics: Kinematics, contact: Blade) -> Touch:
    place = kinematics.point(contact.body, contact.point).tidy()
    local = kinematics.vector(contact.side, contact.body, contact.body).tidy()
    side = kinematics.between(local, kinematics.carrier(contact.body), -1).tidy()
    own = kinematics.velocity(contact.body, contact.point)
    demand = dot(local, own)
    if kinematics.place[contact.on] >= 0:
        demand = demand - dot(side, _velocity(kinematics, contact.on, place))
    meaning = f"force of {contact.on} on {contact.body} across the blade {contact.name} [N]"
    tie = _tie(kinematics, f"{contact.name}_side", tidy(demand), meaning, True)
    return Touch(contact, place, (side,), (tie,))


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


def _velocity(kinematics: Kinematics, body: str, place: Vector) -> Vector:
    """Return the velocity of a body's point at a place in the world, world axes."""
    if kinematics.place[body] < 0:
        return zero(kinematics.algebra.ring)
    carrier = kinematics.carrier(body)
    v, w = (
        kinematics.between(one, carrier, -1)
        for one in (kinematics.velocity(body), kinematics.spin(body))
    )
    return (v + cross(w, place - kinematics.point(body, ORIGIN))).tidy()
