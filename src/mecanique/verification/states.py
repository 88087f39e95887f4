"""Find the states at which the equations are defined.

The coordinate map must be defined there, springs and dampers must have a length, and the
coordinates must not be next to a singular point of theirs: where two axes of a gimbal fall in line,
the mass matrix has no inverse, and rounding errors of the acceleration grow without bound. Where
the closed form takes something for granted, e.g. that a spring on a line is not turned inside out,
that must hold.
"""

from __future__ import annotations

from collections.abc import Sequence
from contextlib import suppress
from dataclasses import replace
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from mecanique.arrays import Array, Flags, median
from mecanique.derivation.numeric.recursion import Recursion
from mecanique.derivation.scalars.evaluation import evaluate
from mecanique.derivation.symbolic.derivation import Assumption
from mecanique.derivation.tree.links import links
from mecanique.derivation.tree.poses import Arithmetic, joint_values, poses, times_point
from mecanique.errors import ClosureError, InputError
from mecanique.model.expression import symbols_in
from mecanique.model.force_base import LineLoad
from mecanique.model.mechanism import Mechanism
from mecanique.model.mechanism.description import angles
from mecanique.model.mechanism_units import characteristic_length
from mecanique.model.random_positions import draw_positions
from mecanique.model.states import States
from mecanique.model.values import whole
from mecanique.wording import say_count

_NEAR = 1e-2
"""Lengths below this part of the typical length count as zero."""

_SINGULAR = 1e3
"""A mass matrix conditioned worse than the typical one by this factor is nearly singular."""


def is_possible(
    mechanism: Mechanism, states: States, assumptions: Sequence[Assumption] = ()
) -> Flags:
    """Return at which states the equations of motion are defined, shape (n,)."""
    possible = np.ones(len(states.t), dtype=bool)
    with np.errstate(all="ignore"):
        values = joint_values(mechanism, states.values, Arithmetic())
        for name, (lower, upper) in mechanism.limits.items():
            possible &= (values[name] > lower) & (values[name] < upper)
        for name in mechanism.coordinates.driven:
            possible &= np.isfinite(values[name])
        for force in mechanism.forces:
            if isinstance(force, LineLoad):
                length = np.linalg.norm(_span(mechanism, force, values, len(states.t)), axis=1)
                known = length[np.isfinite(length)]
                long_enough: Flags = length > _NEAR * (median(known) if len(known) else 0.0)
                possible &= long_enough
        for assumption in assumptions:
            possible &= evaluate(assumption.positive, values) > 0
    return possible & _is_regular(mechanism, states, possible)


def _is_regular(mechanism: Mechanism, states: States, possible: Flags) -> Flags:
    """Return where the mass matrix is not much worse conditioned than usual."""
    at = np.flatnonzero(possible)
    regular = np.ones(len(possible), dtype=bool)
    if not len(at) or not mechanism.nv:
        return regular
    chosen = replace(states.at(at), v=np.zeros((len(at), mechanism.nv)))
    mass = Recursion(mechanism).mass_matrix(chosen)
    condition = np.array([_condition(matrix) for matrix in mass])
    regular[at] = ~(condition > _SINGULAR * median(condition))
    return regular


def _condition(mass: Array) -> float:
    """Return the condition number, diagonal scaled to one; 1 if there is none."""
    with np.errstate(all="ignore"):
        d = np.sqrt(np.diagonal(mass))
        scaled = mass / np.outer(d, d)
    return float(np.linalg.cond(scaled)) if np.isfinite(scaled).all() else 1.0


def _span(mechanism: Mechanism, force: LineLoad, values: dict[str, Any], n: int) -> Array:
    """From one end to the other in world axes, shape (n, 3) [m]."""
    tree = links(mechanism)
    carried = dict(
        zip((link.body for link in tree), poses(tree, values, Arithmetic()), strict=True)
    )
    ends = []
    for end in force.ends:
        here: Sequence[Any] = mechanism.evaluate_all(end.point)
        if end.body in carried:
            here = times_point(carried[end.body], here)
        ends.append(
            np.stack([np.broadcast_to(np.asarray(c, dtype=float), (n,)) for c in here], axis=-1)
        )
    return np.asarray(ends[1] - ends[0])


_RANK = 1e-9
_REGULAR = 0.03
"""Part of the typical smallest singular value below which a position is next to a singular one."""

_TREMBLING = 1e-5
"""The same, absolute: positions that close the loops without being held in them.

What is more than rounding and less than this holds for some forms and not for others, whose ranks
are judged in other units.
"""


_DETERMINED = 1e-2
"""Least margin of a contact, of a wheel the sine of the angle at which it lies.

Forms of its law divide by the margin's square, so that rounding grows to 1e4 times its usual size,
and stays a hundredth of what is tolerated.
"""

_STRIDE = 0.5
"""Length of a step along the loops, in radians or characteristic lengths."""

_STRIDES = 4
"""How many steps lead from one state to the next."""


class ClosedStates(NamedTuple):
    """States with closed loops."""

    q: Array  # positions, shape (k, nq)
    v: Array  # velocities, shape (k, nv)
    at: npt.NDArray[np.intp]  # which of the states given they are near, shape (k,)
    rank: int  # how many of the constraints are independent there
    weak: str = ""  # the row that is hardly held in all of them, and how much


def closed_states(mechanism: Mechanism, q: Array, v: Array, t: Array) -> ClosedStates:
    """Return the closed states near given q (n, nq), v (n, nv), t (n,), and which they are near."""
    from mecanique.reference import Reference
    from mecanique.reference.loops.assembly import close_position, project
    from mecanique.reference.loops.nullspace import are_certain
    from mecanique.reference.tolerances import LEAST

    closed = Reference.of(mechanism).closed
    if closed is None:
        return ClosedStates(q, v, np.arange(len(t)), 0)
    kept: list[tuple[int, Array, Array, float, int]] = []
    weak = ""
    for k in range(len(t)):
        try:
            with np.errstate(all="ignore"):
                start = close_position(closed, q[k], float(t[k]))
                position, velocity = project(closed, start, v[k], float(t[k]))
        except (ClosureError, ArithmeticError, ValueError):
            continue
        here = closed.closures.scale(position, velocity, float(t[k]))
        if closed.closures.contacts.margins.min(initial=1.0) < _DETERMINED:
            continue
        left, sizes, _ = np.linalg.svd(here.jacobian, full_matrices=False)
        held = np.flatnonzero(are_certain(left, sizes, LEAST, here.rounding))
        size = float(sizes[held[-1]]) if len(held) else 1.0
        if size < _TREMBLING:
            row = closed.closures.names[int(np.abs(left[:, held[-1]]).argmax())]
            weak = f"{row}, to a part of {size:.1e}"
        kept.append((k, position, velocity, size, len(held)))
    if not kept:
        return ClosedStates(q[:0], v[:0], np.arange(0), 0)
    at, positions, velocities, least, ranks = map(np.array, zip(*kept, strict=True))
    # fewer equations act at singular positions, and where parts fall together and move otherwise
    whole = ranks == ranks.max()
    regular = whole & (least > max(_REGULAR * np.median(least[whole]), _TREMBLING))
    rank = int(ranks.max())
    weak = "" if regular.any() else weak
    return ClosedStates(positions[regular], velocities[regular], at[regular], rank, weak)


def refuse_locked(mechanism: Mechanism) -> None:
    """Raise if a mechanism with loops is locked in a singular position."""
    # it may tremble there, so that no random position is held by the loops
    from mecanique.reference import Reference
    from mecanique.reference.loops.freedom import refuse_locked as refuse

    closed = Reference.of(mechanism).closed
    if closed is not None:
        with suppress(ClosureError):
            refuse(closed, 0.0)


def wander(
    mechanism: Mechanism,
    t: Array,
    random: np.random.Generator,
    start: Array | None = None,
    strides: int = _STRIDES,
) -> Array:
    """Return positions met on a random walk along the loops, shape (n, nq); t (n,), start (nq,)."""
    # it finds states of long chains of loops, which close from no random position
    from mecanique.reference import Reference
    from mecanique.reference.loops.assembly import close_position, displace, position_near

    closed, q = Reference.of(mechanism).closed, mechanism.neutral()
    if closed is None:
        return np.tile(q, (len(t), 1))
    still = np.zeros(mechanism.nv)
    met = []
    free = still.astype(bool)
    q = position_near(closed, None, q, float(t[0]), free) if start is None else start
    for time in t.tolist():
        heading = random.normal(size=len(still))
        for _ in range(strides):
            J = closed.closures.scale(q, still, time).jacobian[closed.closures.positional]
            along = heading - np.linalg.pinv(J, rcond=_RANK) @ (J @ heading)
            step = along * (_STRIDE / max(float(np.abs(along).max(initial=0.0)), _STRIDE))
            with suppress(ClosureError):
                q = close_position(
                    closed, displace(closed, q, closed.closures.columns * step), time
                )
        met.append(q)
    return np.array(met)


_LENGTH = 0.4
"""Coordinates that are lengths lie within this many characteristic lengths of zero."""

_FAR = 2.0
"""The same of closed mechanisms, where near zero parts may fall together and move otherwise."""

_RATE = 3.0
"""Velocities lie within this many radians, or characteristic lengths, per second of zero."""

_LOT = 32
"""Least number of candidates drawn at once; the same for all, as it decides what a seed gives."""

_USUAL_CLOSED = 16
"""Of these, at least so many are brought to where the loops are closed, to know what is usual."""

_ROUNDS = 50
"""How often a new lot is drawn while states are impossible."""

_SELDOM = 1 / 8
"""Where fewer random positions close the loops, a walk along the loops takes their place.

Twenty states of six squares in series take 1,273 steps then, instead of 22,737.
"""

_USUAL, _LONG, _FEWEST = 100, 60, 5
"""So many states, of mechanisms up to so many velocities; of longer ones fewer, but so many."""

_MOST_NUMBERS = 1_000_000
"""So many entries of mass matrices are compared at most: about a gigabyte, in all forms."""

_STEPS_BETWEEN = 2
"""How many steps of half a radian lead from one state of a walk to the next."""

_TIME = 10.0
"""Times lie between zero and this, for mechanisms whose equations depend on time [s]."""


def usual_samples(mechanism: Mechanism) -> int:
    """Return how many states a mechanism is compared at by default."""
    # a state of a long chain costs the square of its size, so that 100 of 200 links take minutes
    return max(_FEWEST, min(_USUAL, int(_USUAL * (_LONG / max(mechanism.nv, 1)) ** 2)))


def random_states(
    mechanism: Mechanism,
    samples: int,
    seed: int,
    assumptions: Sequence[Assumption] = (),
    *,
    lot: int = _LOT,
    walk: bool = False,
) -> States:
    """Return random states: angles in (−π, π), short lengths, unit quaternions."""
    samples, seed = whole(samples, "samples", 1), whole(seed, "seed", 0)
    most = max(usual_samples(mechanism), _MOST_NUMBERS // (2 + mechanism.nv**2))
    if samples > most:
        size = say_count(mechanism.nv, "velocity", "velocities")
        raise InputError(
            f"expected at most {most:,} samples of a mechanism with {size}, got {samples:,}: all "
            "states are kept at once"
        )
    random = np.random.default_rng(seed)
    lot, accepted, rank, near, start = max(samples, lot), list[States](), 0, False, None
    count = min(lot, max(_USUAL_CLOSED, 2 * samples)) if mechanism.constrained else lot
    for _ in range(_ROUNDS):
        candidates = _draw(mechanism, lot, random)
        if mechanism.constrained:
            candidates = candidates.at(np.arange(count))
            if near:
                try:
                    q = wander(mechanism, candidates.t, random, start)
                except ClosureError as error:
                    raise InputError(f"no state with closed loops was found: {error}") from error
                candidates = replace(candidates, q=q)
            elif walk:
                candidates = _walk(mechanism, candidates, random)
            closed = closed_states(mechanism, candidates.q, candidates.v, candidates.t)
            if not len(closed.at) and not any(map(len, accepted)):
                refuse_locked(mechanism)
                if near and closed.weak:
                    from mecanique.reference.loops.assembly import DIGITS

                    raise InputError(
                        f"mechanism {mechanism.name!r}: the digits of its description leave open "
                        f"what a loop holds ({closed.weak}); {DIGITS}"
                    )
            if not near and len(closed.at) < _SELDOM * count:
                near, start = True, closed.q[-1] if len(closed.at) else None
            if closed.rank > rank:
                # what was found before is special
                rank = closed.rank
                accepted.clear()
            elif closed.rank < rank:
                continue
            candidates = replace(candidates.at(closed.at), q=closed.q, v=closed.v)
        at = np.flatnonzero(is_possible(mechanism, candidates, assumptions))
        accepted.append(candidates.at(at[: samples - sum(map(len, accepted))]))
        if sum(map(len, accepted)) == samples:
            parts = [(part.q, part.v, part.t, part.a) for part in accepted]
            q, v, t, a = map(np.concatenate, zip(*parts, strict=True))
            return States(mechanism, q, v, t, a)
    raise InputError(
        f"expected states of mechanism {mechanism.name!r} at which its coordinate map is defined"
        f"{', its loops are closed' if mechanism.loops else ''} and no spring or "
        f"damper has length zero, found {sum(map(len, accepted))} of {samples} "
        f"among {_ROUNDS * count} random ones"
    )


def _walk(mechanism: Mechanism, candidates: States, random: np.random.Generator) -> States:
    """Candidates with positions on a random walk from the first of them that closes the loops."""
    for k in range(len(candidates)):
        candidate = candidates.at(np.array([k]))
        start = closed_states(mechanism, candidate.q, candidate.v, candidate.t)
        if len(start.at):
            q = wander(mechanism, candidates.t, random, start.q[0], _STEPS_BETWEEN)
            return replace(candidates, q=q)
    return candidates


def _draw(mechanism: Mechanism, samples: int, random: np.random.Generator) -> States:
    length = characteristic_length(mechanism)
    reach = _FAR if mechanism.loops else _LENGTH
    q = draw_positions(mechanism, samples, random, reach * length)
    angular = angles(mechanism)
    fast = np.array([_RATE * (1.0 if name in angular else length) for name in mechanism.velocities])
    v = random.uniform(-fast, fast, (samples, mechanism.nv))
    t = random.uniform(0.0, _TIME, samples) if _depends_on_time(mechanism) else np.zeros(samples)
    a = random.uniform(-fast, fast, (samples, mechanism.nv))
    return States(mechanism, q, v, t, a)


def _depends_on_time(mechanism: Mechanism) -> bool:
    if mechanism.inputs:
        return True
    maps = map(symbols_in, mechanism.coordinates.driven.values())
    forces = (force.symbols for force in mechanism.forces)
    return any("t" in names for names in (*maps, *forces))
