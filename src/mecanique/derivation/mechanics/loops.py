"""Write the constraints on a tape, of loops, contacts and velocities: Φ'' or ψ' = J a + γ = 0."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property, partial
from typing import Any, NamedTuple, final

from mecanique.derivation.mechanics.contacts import ConstraintRow, velocity_rows
from mecanique.derivation.mechanics.elements import Ground
from mecanique.derivation.mechanics.forces import on_velocities
from mecanique.derivation.mechanics.letters import Letters
from mecanique.derivation.mechanics.recursion import TreeRecursion
from mecanique.derivation.mechanics.vectors import Rows, add, dot, scale
from mecanique.model.constraints.loops import CLOSED, Loop
from mecanique.model.mechanism import Mechanism


@final
@dataclass(frozen=True)
class Loops:
    """The equations of all loops, contacts and velocity constraints."""

    letters: Letters

    names: tuple[str, ...]  # name of each equation, e.g. "loop: motion it closes"
    # index of each equation's block: the lengths of a loop, its angles, or a contact
    blocks: tuple[int, ...]
    residual: list[Any]  # Φ; zero for equations that restrict velocities only
    rate: list[Any]  # Φ', or ψ
    gamma: list[Any]  # γ
    # the equations of contacts and velocity constraints, which come last
    velocity_rows: list[ConstraintRow]

    @cached_property
    def jacobian(self) -> Rows:
        """Rows of J; of a long chain they take more operations than all the rest."""
        holonomic = self.residual[: len(self.residual) - len(self.velocity_rows)]
        rows = [on_velocities(self.letters, [gap], [1.0]) for gap in holonomic]
        return [*rows, *(row.slopes for row in self.velocity_rows)]


class RowLabel(NamedTuple):
    """What an equation is called."""

    name: (
        str  # "loop: motion it closes", "contact: motion it prevents" or the velocity constraint's
    )
    block: int  # number of its block: the lengths of a loop, its angles, a contact, a constraint
    long: bool  # whether it is measured in lengths


def label_rows(mechanism: Mechanism) -> list[RowLabel]:
    """Return what the equations of loops, contacts and velocity constraints are called."""
    labels: list[RowLabel] = []
    for k, loop in enumerate(mechanism.loops):
        for row in CLOSED[loop.kind]:
            turns = row.startswith("r")
            labels.append(RowLabel(f"{loop.name}: {row}", 2 * k + turns, not turns))
    first = 2 * len(mechanism.loops)
    for k, contact in enumerate(mechanism.contacts, first):
        labels += [RowLabel(f"{contact.name}: {row}", k, True) for row in contact.rows]
    for k, law in enumerate(mechanism.velocity_constraints, first + len(mechanism.contacts)):
        labels.append(RowLabel(law.name, k, False))
    return labels


def loops_of(letters: Letters, recursion: TreeRecursion) -> Loops:
    """Return the equations of a mechanism's loops, contacts and velocity constraints."""
    angle = partial(letters.call, "atan2")
    residual: list[Any] = []
    for loop in letters.mechanism.loops:
        residual += closure(loop, recursion.ground, angle)
    rate = letters.along(residual)
    rows, labels = velocity_rows(letters, recursion), label_rows(letters.mechanism)
    return Loops(
        letters=letters,
        names=tuple(label.name for label in labels),
        blocks=tuple(label.block for label in labels),
        residual=[*residual, *(row.gap for row in rows)],
        rate=[*rate, *(row.slip for row in rows)],
        gamma=[*letters.along(rate), *(row.rate for row in rows)],
        velocity_rows=rows,
    )


def closure(loop: Loop, ground: Ground, angle: Callable[[Any, Any], Any]) -> list[Any]:
    """Return Φ of one loop, in the axes of frame a and in the arithmetic of the poses."""
    # There frame b has the position p and the rotation matrix R; a hinge keeps R z = z, a weld
    # keeps the skew part of R at zero
    A, a = ground.frame(loop.body_a, loop.frame_a)
    B, b = ground.frame(loop.body_b, loop.frame_b)
    apart = add(b, scale(-1.0, a))
    if loop.kind == "distance":
        return [ground.root(dot(apart, apart)) - ground.scalar(loop.length)]
    x, y, z = (dot(axis, apart) for axis in A)

    def R(i: int, k: int) -> Any:
        return dot(A[i], B[k])

    match loop.kind:
        case "pin":
            return [x, y]
        case "plate":
            return [x, y, angle(R(1, 0), R(0, 0))]
        case "hinge":
            return [x, y, z, -R(1, 2), R(0, 2)]
        case "weld":
            return [x, y, z, *((R(i, k) - R(k, i)) * 0.5 for i, k in ((2, 1), (0, 2), (1, 0)))]
    assert loop.kind == "ball", "validated"
    return [x, y, z]


def sense(loop: Loop, ground: Ground) -> Any | None:
    """Return what is positive unless a loop is closed half a turn off; None where it cannot be."""
    alike = {"hinge": (2,), "weld": (0, 1, 2)}.get(loop.kind)
    if alike is None:
        return None
    A, _ = ground.frame(loop.body_a, loop.frame_a)
    B, _ = ground.frame(loop.body_b, loop.frame_b)
    # half a turn about any axis leaves a trace of −1, the same frames one of 3
    return sum(dot(A[k], B[k]) for k in alike) - len(alike) // 2
