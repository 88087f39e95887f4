"""Write the constraints Φ = 0 of loops in closed form, with one multiplier λ for each.

The ends of a loop lie at A and B. B − A is taken in the world's axes if the loop constrains all of
it, or its part in a plane whose normal is one of these axes, else in the axes of frame a. With
the generalized force λ ∂Φ/∂q (Lagrange, Mécanique analytique, 1788, part 2, sect. 4; Goldstein,
Classical Mechanics, 1980, sect. 2-4) each λ is a component of the force, or moment, of body a on
body b.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import final

from mecanique.derivation.scalars.cancel import tidy, without_rounding
from mecanique.derivation.scalars.generators import Kind
from mecanique.derivation.scalars.series import Series
from mecanique.derivation.symbolic.kinematics import Kinematics
from mecanique.derivation.symbolic.ties.tie import Tie
from mecanique.derivation.symbolic.vectors import Vector, Wrench, cross, dot, lift, total, zero
from mecanique.derivation.tree.poses import Matrix, origin, product, transpose
from mecanique.model.constraints.loops import Loop
from mecanique.model.placement import Placement

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


@final
@dataclass(frozen=True)
class Closing:
    """A loop cut open, in the world's axes.

    Args:
        loop: the loop.
        on_a: point of action of its force on body a [m].
        on_b: point of action of its force on body b [m].
        ties: its equations, except those that hold identically.
        directions: force on body b for λ = 1 of each equation; zero for a moment.
        turns: moment on body b for λ = 1 of each equation; zero for a force.
    """

    loop: Loop
    on_a: Vector
    on_b: Vector
    ties: tuple[Tie, ...]
    directions: tuple[Vector, ...]
    turns: tuple[Vector, ...]

    @property
    def wrench(self) -> Wrench:
        """The force and the couple on body b, in terms of its multipliers."""
        ring = self.on_b.x.ring
        sizes = [tie.multiplier for tie in self.ties]
        parts = []
        for vectors in (self.directions, self.turns):
            products = [vector * size for vector, size in zip(vectors, sizes, strict=True)]
            parts.append(total([zero(ring), *products]))
        return Wrench(*parts)


@final
@dataclass(frozen=True)
class _Row:
    """One equation of a loop: its name, Φ, the meaning of λ, and its unit force and moment."""

    name: str
    demand: Series
    meaning: str
    direction: Vector
    turn: Vector

    @property
    def shifts(self) -> bool:
        """Whether it keeps points together, not axes parallel."""
        return not self.name.startswith("r")


def loop_ties(kinematics: Kinematics) -> tuple[Tie, ...]:
    """Return the equations of all loops of a mechanism, except those that hold identically."""
    return tuple(tie for closing in closings(kinematics) for tie in closing.ties)


def closings(kinematics: Kinematics) -> tuple[Closing, ...]:
    """Return all loops of a mechanism, cut open."""
    return tuple(_cut(kinematics, loop) for loop in kinematics.algebra.mechanism.loops)


def _cut(kinematics: Kinematics, loop: Loop) -> Closing:
    ring = kinematics.algebra.ring
    A = _frame(kinematics, loop.body_a, loop.frame_a)
    B = _frame(kinematics, loop.body_b, loop.frame_b)
    *a, on_a = (lift(ring, column) for column in transpose(A))
    *b, on_b = (lift(ring, column) for column in transpose(B))
    within = _plane(a[2]) if loop.kind in ("pin", "plate") else None
    own = loop.kind in ("pin", "plate") and within is None
    rows = [*_along(kinematics, loop, a, on_b - on_a, within), *_about(loop, a, b)]
    ties, directions, turns = [], list[Vector](), list[Vector]()
    one = ring.number(1)
    for row in rows:
        demand = without_rounding(tidy(row.demand), [*on_a, *on_b] if row.shifts else [one])
        if demand.vanishes():
            continue
        name = f"{loop.name}_{row.name}"
        multiplier = ring.unknown(f"lambda_{name}", Kind.REACTION)
        ties.append(Tie(name, demand, multiplier, row.meaning))
        directions.append(row.direction)
        turns.append(row.turn)
    # axes that turn with body a carry the force's point of action along
    return Closing(
        loop=loop,
        on_a=on_b if own else on_a,
        on_b=on_b,
        ties=tuple(ties),
        directions=tuple(directions),
        turns=tuple(turns),
    )


def _along(
    kinematics: Kinematics, loop: Loop, a: Sequence[Vector], p: Vector, within: int | None
) -> Iterator[_Row]:
    """Yield the equations that keep the ends together, or at a distance."""
    algebra = kinematics.algebra
    ring, nothing = algebra.ring, zero(algebra.ring)
    if loop.kind == "distance":
        length = algebra.series(loop.length)
        demand = (dot(p, p) - length * length) / 2
        yield _Row("l", demand, f"push of the rod {loop.name} over its length [N/m]", p, nothing)
        return
    world = [lift(ring, axis) for axis in ((1, 0, 0), (0, 1, 0), (0, 0, 1))]
    flat = loop.kind in ("pin", "plate")
    own = flat and within is None
    axes, whose = (a, f"the frame in {loop.body_a}") if own else (world, "the world")
    for k in (0, 1) if own else [k for k in range(3) if k != within]:
        meaning = f"force {_on(loop)}, {'xyz'[k]} component in the axes of {whose} [N]"
        yield _Row("xyz"[k], dot(axes[k], p), meaning, axes[k], nothing)


def _about(loop: Loop, a: Sequence[Vector], b: Sequence[Vector]) -> Iterator[_Row]:
    """Yield the equations that keep axes parallel.

    In the rotation δφ of b relative to a, a·b changes by (b × a)·δφ.
    """
    nothing = zero(a[0].x.ring)
    for row, terms in _TURNS.get(loop.kind, {}).items():
        whole = a[0].x.ring.sum([dot(a[i], b[k]) * sign for sign, i, k in terms])
        turn = total([cross(b[k], a[i]) * sign for sign, i, k in terms])
        meaning = f"moment {_on(loop)}, about {row[1]} of its frame in {loop.body_a} [N m]"
        mean = Vector(*(part / len(terms) for part in turn))
        yield _Row(row, whole / len(terms), meaning, nothing, mean)


def _on(loop: Loop) -> str:
    return f"of {loop.body_a} on {loop.body_b} in the loop {loop.name}"


def _frame(kinematics: Kinematics, body: str, frame: Placement) -> Matrix:
    algebra = kinematics.algebra
    return product(kinematics.pose(body), origin(frame, algebra.values, algebra.arithmetic))


def _plane(normal: Vector) -> int | None:
    """Return the world's axis that is the constant normal of a plane, None without one."""
    one = normal.x.ring.number(1)
    still = [k for k, c in enumerate(normal) if (tidy(c) ** 2 - one).vanishes()]
    return still[0] if still else None
