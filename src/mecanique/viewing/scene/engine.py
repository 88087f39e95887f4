"""What a page needs to integrate by itself, as pure data."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal, final


@final
@dataclass(frozen=True)
class Resized:
    """A shape whose size or place follows the parameters.

    Args:
        body: number of the body.
        shape: number of the shape among those of the body that are no meshes.
        size: what it is drawn with: edges, radius and length, or radius [m].
    """

    body: int
    shape: int
    size: tuple[float, ...]


@final
@dataclass(frozen=True)
class Bound:
    """What ends a motion or sends it back: a number that passes zero.

    Args:
        words: where that is, e.g. "where x comes to its limit h".
        direction: +1 for rising through zero, −1 for falling, 0 for both.
        must: what a start beyond it violates; "" if a motion may start there.
        restitution: of an impact there, after which the motion continues; None if it ends.
    """

    words: str
    direction: int
    must: str = ""
    restitution: float | None = None


@final
@dataclass(frozen=True)
class Condition:
    """What numbers that depend on the parameters must be, see `mechanism.rules.Rule`.

    Args:
        kind: of numbers that are finite, of a gap that is their last, or of a mass and an inertia.
        where: what they belong to.
        words: the fault if they are not so, with a {} for each number; two of an inertia.
        count: how many numbers there are.
        strict: whether a gap must be above 0.
        follows: whether it means something only if the condition before it is kept.
    """

    kind: Literal["finite", "gap", "inertia"]
    where: str
    words: tuple[str, ...]
    count: int
    strict: bool = False
    follows: bool = False


@final
@dataclass(frozen=True)
class Engine:
    """A mechanism's program in JavaScript, and the start of its motion.

    The program is the text of functions (t, y, p, out): `rates` of the state and of the work done;
    `row`, every number of the scene in the order of its table, with the nine entries of a rotation
    in place of a quaternion; `shapes`, sizes and places of what follows the parameters; with loops
    `closure`, what they miss, its rate and the rows of its Jacobian; with bounds `bounds`, the
    number that passes zero and how near counts as reached, for each, and `gradients`, for each
    impact, its slopes over time and coordinates; with conditions
    `rules`, the numbers of each; where contacts or cords may cease to hold
    `margins`, three forces a, b, c for each: what it has left is a − √(b² + c²).

    Args:
        script: the text of the functions.
        coordinates: names, in order.
        velocities: names, in order.
        parameters: names, in the order of p.
        values: of the parameters.
        start: shape (nq + nv,), the state at the start.
        first: time at the start [s].
        duration: length of the motion [s].
        rtol: relative tolerance of a step.
        quaternions: where the quaternions stand in the state.
        loops: number of equations that close loops, hold contacts and restrain velocities.
        restrained: which of them restrain velocities alone.
        unknown: columns of the scene's table that the program does not know.
        resized: shapes that follow the parameters.
        bounds: what ends a motion or sends it back.
        conditions: what the numbers of a sound mechanism keep to.
        holding: what would happen where each of the margins passes zero, e.g. "rim would pull".
        endless: whether the motion continues beyond its end.
        python: text of the Python that makes the mechanism, e.g. 'mq.textbook.load("crane")'.
        options: further arguments of `simulate`, e.g. 'limits="stop"'.
    """

    script: str
    coordinates: tuple[str, ...]
    velocities: tuple[str, ...]
    parameters: tuple[str, ...]
    values: tuple[float, ...]
    start: tuple[float, ...]
    first: float
    duration: float
    rtol: float
    quaternions: tuple[int, ...] = ()
    loops: int = 0
    restrained: tuple[int, ...] = ()
    unknown: tuple[int, ...] = ()
    resized: tuple[Resized, ...] = ()
    bounds: tuple[Bound, ...] = ()
    conditions: tuple[Condition, ...] = ()
    holding: tuple[str, ...] = ()
    endless: bool = False
    python: str = ""
    options: tuple[str, ...] = ()
