"""Write the constraints on a tape, of loops, contacts and velocities: Φ'' or ψ' = J a + γ = 0."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, final

from mecanique.derivation.mechanics.chart import along
from mecanique.derivation.mechanics.contacts import Demand, demands_of
from mecanique.derivation.mechanics.forces import on_velocities
from mecanique.derivation.mechanics.letters import Letters
from mecanique.derivation.mechanics.recursion import Recursion
from mecanique.derivation.mechanics.vectors import Rows, apply_transpose, dot
from mecanique.derivation.tree.poses import Matrix, origin, product
from mecanique.errors import DerivationError
from mecanique.model.constraints.loops import CLOSED, Loop


@final
@dataclass(frozen=True)
class Loops:
    """The equations of all loops, contacts and velocity constraints.

    Args:
        names: name of each equation, e.g. "loop: motion it closes".
        blocks: index of each equation's block: the lengths of a loop, its angles, or a contact.
        residual: Φ; zero for equations that restrict velocities only.
        rate: Φ', or ψ.
        jacobian: rows of J.
        gamma: γ.
        demands: the equations of contacts and velocity constraints, which come last.
    """

    names: tuple[str, ...]
    blocks: tuple[int, ...]
    residual: list[Any]
    rate: list[Any]
    jacobian: Rows
    gamma: list[Any]
    demands: list[Demand]


def loops_of(letters: Letters, recursion: Recursion) -> Loops:
    """Return the equations of a mechanism's loops, contacts and velocity constraints.

    Args:
        letters: its inputs.
        recursion: the recursion over its bodies.
    """
    names: list[str] = []
    blocks: list[int] = []
    residual: list[Any] = []
    for k, loop in enumerate(letters.mechanism.loops):
        names += [f"{loop.name}: {row}" for row in CLOSED[loop.kind]]
        blocks += [2 * k + row.startswith("r") for row in CLOSED[loop.kind]]
        residual += _demands(letters, recursion, loop)
    rate = along(letters, residual)
    jacobian = [on_velocities(letters, [row], [1.0]) for row in residual]
    demands = demands_of(letters, recursion)
    return Loops(
        names=(*names, *(demand.name for demand in demands)),
        blocks=(*blocks, *(2 * len(letters.mechanism.loops) + demand.block for demand in demands)),
        residual=[*residual, *(demand.gap for demand in demands)],
        rate=[*rate, *(demand.slip for demand in demands)],
        jacobian=[*jacobian, *(demand.slopes for demand in demands)],
        gamma=[*along(letters, rate), *(demand.rate for demand in demands)],
        demands=demands,
    )


def _demands(letters: Letters, recursion: Recursion, loop: Loop) -> list[Any]:
    """Return Φ of one loop, in the axes of frame a."""
    frames: list[Matrix] = []
    for body, frame in ((loop.body_a, loop.frame_a), (loop.body_b, loop.frame_b)):
        placed = origin(frame, letters.values, letters.arithmetic)
        frames.append(product(recursion.pose(body), placed))
    A, B = frames
    apart = [b[3] - a[3] for a, b in zip(A, B, strict=True)]
    if loop.kind == "distance":
        length = letters.arithmetic(loop.length, letters.values)
        return [letters.call("sqrt", dot(apart, apart)) - length]
    x, y, z = apply_transpose(A, apart)

    def turn(i: int, k: int) -> Any:
        return dot([row[i] for row in A], [row[k] for row in B])

    match loop.kind:
        case "pin":
            return [x, y]
        case "plate":
            return [x, y, letters.call("atan2", turn(1, 0), turn(0, 0))]
        case "hinge":
            return [x, y, z, -turn(1, 2), turn(0, 2)]
        case "weld":
            skew = [(turn(i, k) - turn(k, i)) * 0.5 for i, k in ((2, 1), (0, 2), (1, 0))]
            return [x, y, z, *skew]
        case "ball":
            return [x, y, z]
    raise DerivationError(f"no program is known for loop {loop.name!r}, a {loop.kind!r}")
