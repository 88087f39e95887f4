"""What loops demand in closed form: Φ = 0, with one multiplier λ for each equation.

The ends of a loop lie at A and B; B − A is taken in the world's axes wherever the loop ties all of
it, or ties it within a plane whose normal is one of these axes, else in the axes of frame a. With
the generalized force λ ∂Φ/∂q (Lagrange, Mécanique analytique, 1788, part 2, sect. 4; Goldstein,
Classical Mechanics, 1980, sect. 2-4) each λ is a component of the force, or moment, of body a on
body b.
"""

from __future__ import annotations

from collections.abc import Iterator

from mecanique.derivation.scalars.cancel import tidy
from mecanique.derivation.scalars.series import Kind, Series
from mecanique.derivation.symbolic.kinematics import Kinematics
from mecanique.derivation.symbolic.ties.tie import Tie
from mecanique.derivation.tree.poses import Matrix, combination, origin, product
from mecanique.model.loops import Loop
from mecanique.model.placement import Placement

__all__ = ["loop_ties"]


def loop_ties(kinematics: Kinematics) -> tuple[Tie, ...]:
    """Return the equations of all loops of a mechanism, except those that hold identically."""
    algebra = kinematics.algebra
    found: list[Tie] = []
    for loop in algebra.mechanism.loops:
        for row, demand, meaning in _demands(kinematics, loop):
            demand = tidy(demand)
            if not demand.vanishes():
                name = f"{loop.name}_{row}"
                found.append(
                    Tie(
                        name, demand, algebra.ring.unknown(f"lambda_{name}", Kind.REACTION), meaning
                    )
                )
    return tuple(found)


def _demands(kinematics: Kinematics, loop: Loop) -> Iterator[tuple[str, Series, str]]:
    """Name, Φ and the multiplier's meaning of each equation."""
    algebra = kinematics.algebra
    A, B = (
        _frame(kinematics, *end)
        for end in ((loop.body_a, loop.frame_a), (loop.body_b, loop.frame_b))
    )
    p = [algebra.lift(b[3]) - algebra.lift(a[3]) for a, b in zip(A, B, strict=True)]
    on = f"of {loop.body_a} on {loop.body_b} in the loop {loop.name}"
    if loop.kind == "distance":
        length = algebra.series(loop.length)
        square = algebra.ring.sum([c * c for c in p])
        yield (
            "l",
            (square - length * length) / 2,
            f"push of the rod {loop.name} over its length [N/m]",
        )
        return
    within = None
    if loop.kind in ("pin", "plate"):
        within = _plane(kinematics, A)
        rows = [k for k in range(3) if k != within] if within is not None else [0, 1]
    else:
        rows = [0, 1, 2]
    own = loop.kind in ("pin", "plate") and within is None
    axes = f"the frame in {loop.body_a}" if own else "the world"
    for k in rows:
        demand = combination([a[k] for a in A], p) if own else p[k]
        yield (
            "xyz"[k],
            algebra.lift(demand),
            f"force {on}, {'xyz'[k]} component in the axes of {axes} [N]",
        )

    def turn(i: int, k: int) -> Series:
        """An entry of the rotation of frame b in frame a."""
        return algebra.lift(combination([a[i] for a in A], [b[k] for b in B]))

    about = f"moment {on}, about {{}} of its frame in {loop.body_a} [N m]"
    match loop.kind:
        case "plate":
            yield "rz", turn(1, 0), about.format("z")
        case "hinge":
            yield "rx", -turn(1, 2), about.format("x")
            yield "ry", turn(0, 2), about.format("y")
        case "weld":
            for axis, i, k in (("x", 2, 1), ("y", 0, 2), ("z", 1, 0)):
                yield f"r{axis}", (turn(i, k) - turn(k, i)) / 2, about.format(axis)


def _frame(kinematics: Kinematics, body: str, frame: Placement) -> Matrix:
    algebra = kinematics.algebra
    return product(kinematics.pose(body), origin(frame, algebra.values, algebra.arithmetic))


def _plane(kinematics: Kinematics, A: Matrix) -> int | None:
    """The axis of the world to which the plane of a frame stays normal, if there is one."""
    algebra = kinematics.algebra
    normal = [tidy(algebra.lift(row[2])) for row in A]
    still = [k for k, c in enumerate(normal) if (c * c - algebra.ring.number(1)).vanishes()]
    return still[0] if still else None
