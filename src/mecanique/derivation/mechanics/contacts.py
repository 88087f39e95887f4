"""Write contacts and velocity constraints on a tape: ψ = A(q, t) v − b = 0, ψ' = A a + γ.

The two bodies' points in contact have the same velocity. Along the normal, ψ is the rate of the gap
Φ; along the plane it is in general not integrable (Neimark & Fufaev, Dynamics of Nonholonomic
Systems, 1972, ch. I). At the place P of the contact, which is not a material point, the velocity
v + ω × (P − p) has the rate a + α × (P − p) + ω × (P' − v).
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import Any, final

from mecanique.derivation.mechanics.chart import along
from mecanique.derivation.mechanics.letters import Letters
from mecanique.derivation.mechanics.recursion import Recursion, World
from mecanique.derivation.mechanics.vectors import (
    Triple,
    add,
    apply,
    apply_transpose,
    cross,
    dot,
    scale,
    transpose,
)
from mecanique.derivation.tree.poses import Matrix, origin, product
from mecanique.model.constraints.contacts import Blade, Contact, Rolling
from mecanique.model.constraints.velocity_constraints import VelocityConstraint


@final
@dataclass(frozen=True)
class Demand:
    """One equation of a contact or a velocity constraint.

    Args:
        name: "contact: motion it prevents", or the name of the velocity constraint.
        block: index of the contact or velocity constraint.
        gap: Φ; zero where there is none.
        slip: ψ, which is Φ' where there is a Φ.
        slopes: A, shape (nv,).
        rate: γ.
        place: point of contact; None for a velocity constraint.
        direction: direction of its force there.
    """

    name: str
    block: int
    gap: Any
    slip: Any
    slopes: list[Any]
    rate: Any
    place: Triple | None = None
    direction: Triple | None = None


@final
@dataclass(frozen=True)
class _Touch:
    """The place of a contact, in the world, and the directions in which it prevents motion.

    Args:
        place: P.
        rate: P'.
        gap: Φ of the first direction.
        directions: the directions.
        turning: their rates; None if they are constant.
    """

    place: Triple
    rate: Triple
    gap: Any
    directions: list[Triple]
    turning: list[Triple] | None


def demands_of(letters: Letters, recursion: Recursion) -> list[Demand]:
    """Return the equations of a mechanism's contacts, then of its velocity constraints.

    Args:
        letters: its inputs.
        recursion: the recursion over its bodies.
    """
    mechanism, found, world = letters.mechanism, list[Demand](), World(recursion)
    for k, contact in enumerate(mechanism.contacts):
        touch = _touch(letters, world, contact)
        sides = [(contact.body, 1.0), (contact.on, -1.0)]
        slip = add(*(scale(s, world.velocity(body, touch.place)) for body, s in sides))
        change = add(*(scale(s, world.change(body, touch.place, touch.rate)) for body, s in sides))
        columns = [world.columns(body, touch.place) for body, _ in sides]
        for i, (row, direction) in enumerate(zip(contact.rows, touch.directions, strict=True)):
            slopes: list[Any] = [0.0] * len(recursion.chart.u)
            for moved, (_, sign) in zip(columns, sides, strict=True):
                for place, column in moved.items():
                    slopes[place] = slopes[place] + sign * dot(direction, column)
            rate = dot(direction, change)
            if touch.turning is not None:
                rate = rate + dot(touch.turning[i], slip)
            gap = touch.gap if row == "normal" else 0.0
            name, by_v = f"{contact.name}: {row}", recursion.chart.project(slopes)
            slipped = dot(direction, slip)
            found.append(
                Demand(
                    name=name,
                    block=k,
                    gap=gap,
                    slip=slipped,
                    slopes=by_v,
                    rate=rate,
                    place=touch.place,
                    direction=direction,
                )
            )
    for k, constraint in enumerate(mechanism.velocity_constraints):
        found.append(_constrain(letters, constraint, len(mechanism.contacts) + k))
    return found


def _constrain(letters: Letters, constraint: VelocityConstraint, block: int) -> Demand:
    entries = constraint.along(letters.mechanism.velocities)
    slopes = [letters.arithmetic(entry, letters.values) for entry in entries]
    b = letters.arithmetic(constraint.rate, letters.values)
    *turning, b_rate = along(letters, [*slopes, b])
    slip, rate = dot(slopes, letters.v) - b, dot(turning, letters.v) - b_rate
    return Demand(name=constraint.name, block=block, gap=0.0, slip=slip, slopes=slopes, rate=rate)


def _touch(letters: Letters, world: World, contact: Contact) -> _Touch:
    A = world.pose(contact.body)
    if isinstance(contact, Blade):
        place, side = _point(A, _numbers(letters, contact.point)), _turn(A, contact.side)
        turning = [cross(world.spin(contact.body), side)]
        return _Touch(place, world.velocity(contact.body, place), 0.0, [side], turning)
    plane = origin(contact.plane, letters.values, letters.arithmetic)
    x, y, n, start = transpose(product(world.pose(contact.on), plane))
    hub = _point(A, _numbers(letters, contact.center))
    moved = world.velocity(contact.body, hub)
    if contact.curved:
        return _touch_sphere(letters, contact, hub, moved, (x, y, n, start))
    rests = not world.moves(contact.on)
    turning = [cross(world.spin(contact.on), e) for e in (n, x, y)]
    n_rate = turning[0]
    if contact.axis is None:
        reach = _reach_ellipsoid(letters, contact, A, n)
        reach_rate = along(letters, reach)
    else:
        e = _turn(A, contact.axis)
        e_rate = cross(world.carrier_spin(contact.body, contact.axis), e)
        reach, reach_rate = _reach_wheel(letters, contact, (e, e_rate), (n, n_rate))
    place = add(hub, reach)
    gap = dot(n, add(place, scale(-1.0, start)))
    return _Touch(place, add(moved, reach_rate), gap, [n, x, y], None if rests else turning)


def _reach_wheel(
    letters: Letters, contact: Rolling, axis: tuple[Triple, Triple], normal: tuple[Triple, Triple]
) -> tuple[Triple, Triple]:
    """Return ρ = −crown n − (r − crown) (n − λ e)/σ and ρ', with λ = n·e, σ = |n − λ e|."""
    (e, e_rate), (n, n_rate) = axis, normal
    radius, crown = _numbers(letters, (contact.radius, contact.crown))
    lean = dot(n, e)
    lean_rate = dot(n_rate, e) + dot(n, e_rate)
    across = add(n, scale(-1.0 * lean, e))
    size = letters.call("sqrt", dot(across, across))
    up = scale(1.0 / size, across)
    # σ' = −λ λ'/σ
    shrink = lean * lean_rate / (size * size)
    turned = add(n_rate, scale(-1.0 * lean_rate, e), scale(-1.0 * lean, e_rate))
    up_rate = add(scale(1.0 / size, turned), scale(shrink, up))
    ring = radius - crown
    reach = add(scale(-1.0 * crown, n), scale(-1.0 * ring, up))
    return reach, add(scale(-1.0 * crown, n_rate), scale(-1.0 * ring, up_rate))


def _reach_ellipsoid(letters: Letters, contact: Rolling, A: Matrix, n: Triple) -> Triple:
    """Return ρ = −R d² u/|d u| with u = Rᵀ n and the semi-axes d."""
    (radius,) = _numbers(letters, (contact.radius,))
    if not contact.stretched:
        return scale(-1.0 * radius, n)
    u = apply_transpose([row[:3] for row in A], n)
    semi = [radius * factor for factor in _numbers(letters, contact.stretch)]
    wide = [s * s * c for s, c in zip(semi, u, strict=True)]
    size = letters.call("sqrt", dot(u, wide))
    return _turn(A, [-1.0 * c / size for c in wide])


def _touch_sphere(
    letters: Letters, contact: Rolling, hub: Triple, moved: Triple, frame: Sequence[Triple]
) -> _Touch:
    """Return the contact of a ball with a bowl or a dome, on the line to the sphere's center."""
    x, y, z, start = frame
    radius, bowl = _numbers(letters, (contact.radius, contact.bowl))
    side = 1.0 if letters.mechanism.evaluate(contact.bowl) > 0 else -1.0
    d = scale(side, add(start, scale(bowl, z), scale(-1.0, hub)))
    length = letters.call("sqrt", dot(d, d))
    n = scale(1.0 / length, d)
    between = scale(1.0 / (1.0 + dot(n, z)), add(z, n))
    directions = [n, *(add(e, scale(-1.0 * dot(n, e), between)) for e in (x, y))]
    turning = [along(letters, direction) for direction in directions]
    reach = scale(-1.0 * radius, n)
    rate = add(moved, scale(-1.0 * radius, turning[0]))
    return _Touch(add(hub, reach), rate, bowl - side * length - radius, directions, turning)


def _numbers(letters: Letters, scalars: Iterable[Any]) -> list[Any]:
    return [letters.arithmetic(scalar, letters.values) for scalar in scalars]


def _point(pose: Matrix, point: Sequence[Any]) -> Triple:
    return add(_turn(pose, point), [row[3] for row in pose])


def _turn(pose: Matrix, vector: Sequence[Any]) -> Triple:
    return apply([row[:3] for row in pose], list(vector))
