"""Contacts and velocity constraints: ψ = A(q, t) v − b = 0, ψ' = A a + γ.

The two bodies' points in contact have the same velocity. Along the normal, ψ is the rate of the gap
Φ; along the plane it is in general not integrable (Neimark & Fufaev, Dynamics of Nonholonomic
Systems, 1972, ch. I). At the place P of the contact, which is not a material point, the velocity
v + ω × (P − p) has the rate a + α × (P − p) + ω × (P' − v).

To add a contact: its class in `mecanique.model.constraints.contacts`, and where it touches here.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, NamedTuple, final

from mecanique.derivation.mechanics.elements import Ground
from mecanique.derivation.mechanics.letters import Letters
from mecanique.derivation.mechanics.recursion import TreeRecursion, World
from mecanique.derivation.mechanics.vectors import Triple, add, apply, dot, scale
from mecanique.derivation.tree.poses import exact_direction
from mecanique.model import Blade, Mechanism, Rolling, VelocityConstraint
from mecanique.model.constraints.contacts import Contact


class Touch(NamedTuple):
    """The place of a contact in the world, the directions in which it prevents motion, and Φ."""

    # All are scalars of some arithmetic, functions of the poses; Φ belongs to the first direction

    place: Triple
    directions: tuple[Triple, ...]
    gap: Any
    foot: Any = 0.0  # the place along x of the plane
    # ρ × each direction, where that is known to be shorter than the product
    arms: tuple[Triple, ...] | None = None


def touch(mechanism: Mechanism, contact: Contact, ground: Ground) -> Touch:
    """Return where two bodies touch, in the arithmetic of the poses."""
    turn = ground.turn(contact.body)
    if isinstance(contact, Blade):
        place = ground.point(contact.body, contact.point)
        return Touch(place, (apply(turn, [ground.scalar(c) for c in contact.side]),), 0.0)
    (x, y, n), start = ground.frame(contact.on, contact.plane)
    hub = ground.point(contact.body, contact.center)
    if contact.curved:
        side = 1.0 if mechanism.evaluate(contact.bowl) > 0 else -1.0
        return _touch_sphere(contact, side, ground, (hub, start), (x, y, n))
    crown, radius = ground.scalar(contact.crown), ground.scalar(contact.radius)
    if contact.axis is not None:
        # the rim's lowest point, opposite to the part of the normal across the wheel's axis
        e = apply(turn, [ground.scalar(c) for c in exact_direction(contact.axis)])
        up = add(n, scale(-1.0 * dot(n, e), e))
        reach = add(scale(-1.0 * crown, n), ground.lengthen(up, crown - radius))
    elif contact.stretched:
        # ρ = −R d² u/|d u| with u = Rᵀ n and the semi-axes d
        u = apply(list(zip(*turn, strict=True)), n)
        semi = [radius * ground.scalar(factor) for factor in contact.stretch]
        wide = [d * d * c for d, c in zip(semi, u, strict=True)]
        size = ground.root(dot(u, wide))
        reach = apply(turn, [ground.ratio(-1.0 * c, size) for c in wide])
    else:
        reach = scale(-1.0 * radius, n)
    place = add(hub, reach)
    offset = add(place, scale(-1.0, start))
    # n·ρ of an ellipsoid is −|d u|, which has no quotient
    gap = dot(n, add(hub, scale(-1.0, start))) - size if contact.stretched else dot(n, offset)
    return Touch(place, (n, x, y), gap, dot(x, offset))


def _touch_sphere(
    contact: Rolling,
    side: float,
    ground: Ground,
    places: tuple[Triple, Triple],
    axes: tuple[Triple, Triple, Triple],
) -> Touch:
    """Return the contact of a ball with a bowl or a dome, on the line to the sphere's center."""
    (hub, start), (x, y, z) = places, axes
    radius, bowl = ground.scalar(contact.radius), ground.scalar(contact.bowl)
    d = scale(side, add(start, scale(bowl, z), scale(-1.0, hub)))
    length = ground.root(dot(d, d))
    n = [ground.ratio(c, length) for c in d]
    # friction is along the plane's axes, turned with the normal the shortest way: as if reflected
    # along z + n; opposite to z, where there is no shortest way, they stay as they are
    s = add(z, n)
    between = [ground.ratio(c, dot(s, z) + ground.opposite) for c in s]
    turned = [add(e, scale(-1.0 * dot(s, e), between)) for e in (x, y)]
    arms = (scale(0.0, n), scale(-1.0 * radius, turned[1]), scale(radius, turned[0]))
    place, gap = add(hub, scale(-1.0 * radius, n)), bowl - side * length - radius
    return Touch(place, (n, *turned), gap, arms=arms)


@final
@dataclass(frozen=True)
class ConstraintRow:
    """One equation of a contact or a velocity constraint."""

    name: str  # "contact: motion it prevents", or the name of the velocity constraint
    gap: Any  # Φ; zero where there is none
    slip: Any  # ψ, which is Φ' where there is a Φ
    slopes: list[Any]  # A, shape (nv,)
    rate: Any  # γ
    place: Triple | None = None  # point of contact; None for a velocity constraint
    direction: Triple | None = None  # direction of its force there
    foot: Any = 0.0  # the place along x of the plane


def velocity_rows(letters: Letters, recursion: TreeRecursion) -> list[ConstraintRow]:
    """Return the equations of a mechanism's contacts, then of its velocity constraints."""
    mechanism, rows, world = letters.mechanism, list[ConstraintRow](), World(recursion)
    ground = recursion.ground
    for contact in mechanism.contacts:
        place, directions, gap, foot, _ = touch(mechanism, contact, ground)
        place_rate = letters.along(place, world.pose_rates)
        sides = [(contact.body, 1.0), (contact.on, -1.0)]
        slip = add(*(scale(s, world.velocity(body, place)) for body, s in sides))
        change = add(*(scale(s, world.change(body, place, place_rate)) for body, s in sides))
        columns = [world.columns(body, place) for body, _ in sides]
        for row, direction in zip(contact.rows, directions, strict=True):
            slopes: list[Any] = [0.0] * len(recursion.chart.u)
            for moved, (_, sign) in zip(columns, sides, strict=True):
                for u, column in moved.items():
                    slopes[u] = slopes[u] + sign * dot(direction, column)
            rows.append(
                ConstraintRow(
                    name=f"{contact.name}: {row}",
                    gap=gap if row == "normal" else 0.0,
                    slip=dot(direction, slip),
                    slopes=recursion.chart.project(slopes),
                    rate=dot(direction, change)
                    + dot(letters.along(direction, world.pose_rates), slip),
                    place=place,
                    direction=direction,
                    foot=foot,
                )
            )
    return [*rows, *(_constrain(letters, law) for law in mechanism.velocity_constraints)]


def _constrain(letters: Letters, constraint: VelocityConstraint) -> ConstraintRow:
    entries = constraint.along(letters.mechanism.velocities)
    slopes = [letters.arithmetic(entry, letters.values) for entry in entries]
    b = letters.arithmetic(constraint.rate, letters.values)
    *turning, b_rate = letters.along([*slopes, b])
    slip, rate = dot(slopes, letters.v) - b, dot(turning, letters.v) - b_rate
    return ConstraintRow(constraint.name, gap=0.0, slip=slip, slopes=slopes, rate=rate)
