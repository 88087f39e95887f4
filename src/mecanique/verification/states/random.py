"""Draw random states to compare at; the same seed gives the same states."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from mecanique.derivation.symbolic.derivation import Assumption
from mecanique.errors import ClosureError, InputError
from mecanique.model.expression import symbols_in
from mecanique.model.mechanism import Mechanism
from mecanique.model.random_positions import angles, draw_positions
from mecanique.model.states import States
from mecanique.model.units import characteristic_length
from mecanique.model.values import whole
from mecanique.verification.states.loops import closed_states, refuse_locked, wander
from mecanique.verification.states.validity import is_possible
from mecanique.wording import say_count

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

_USUAL, _LONG, _FEWEST = 100, 60, 5
"""So many states, of mechanisms up to so many velocities; of longer ones fewer, but so many."""

_MOST_NUMBERS = 1_000_000
"""So many entries of mass matrices are compared at most: about a gigabyte, in all forms."""

_STRIDES = 2
"""How many steps of half a radian lead from one state of a walk to the next."""

_TIME = 10.0
"""Times lie between zero and this, for mechanisms whose equations depend on time [s]."""


def usual_samples(mechanism: Mechanism) -> int:
    """Return how many states a mechanism is compared at by default.

    A state of a long chain costs the square of its size, so that 100 of 200 links take minutes; and
    each of them is a comparison of 40,000 entries.
    """
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
    """Return random states: angles in (−π, π), short lengths, unit quaternions.

    Args:
        mechanism: the mechanism.
        samples: number of states, at least 1.
        seed: of numpy's default generator, at least 0.
        assumptions: what must hold besides.
        lot: least number of candidates drawn at once; those of closed mechanisms take long.
        walk: whether only the first position of a lot is brought from afar to where the loops are
            closed, and the others are met on a random walk along the loops from there. That takes a
            third of the time where there are many loops.

    Raises:
        InputError: if `samples` or `seed` is not a whole number in its range, so many states would
            fill the memory, no possible state is found, or the mechanism is locked in a singular
            position.
    """
    samples, seed = whole(samples, "samples", 1), whole(seed, "seed", 0)
    most = max(usual_samples(mechanism), _MOST_NUMBERS // (2 + mechanism.nv**2))
    if samples > most:
        size = say_count(mechanism.nv, "velocity", "velocities")
        raise InputError(
            f"expected at most {most:,} samples of a mechanism with {size}, got {samples:,}: all "
            "states are kept at once"
        )
    random = np.random.default_rng(seed)
    lot, found, rank, near = max(samples, lot), list[States](), 0, False
    count = min(lot, max(_USUAL_CLOSED, 2 * samples)) if mechanism.constrained else lot
    for _ in range(_ROUNDS):
        candidates = _draw(mechanism, lot, random)
        if mechanism.constrained:
            candidates = candidates.at(np.arange(count))
            if near:
                try:
                    candidates = replace(candidates, q=wander(mechanism, candidates.t, random))
                except ClosureError as error:
                    raise InputError(f"no state with closed loops was found: {error}") from error
            elif walk:
                candidates = _walk(mechanism, candidates, random)
            closed = closed_states(mechanism, candidates.q, candidates.v, candidates.t)
            if not len(closed.at) and not any(map(len, found)):
                refuse_locked(mechanism)
                near = True
            if closed.rank > rank:
                # what was found before is special
                rank = closed.rank
                found.clear()
            elif closed.rank < rank:
                continue
            candidates = replace(candidates.at(closed.at), q=closed.q, v=closed.v)
        at = np.flatnonzero(is_possible(mechanism, candidates, assumptions))
        found.append(candidates.at(at[: samples - sum(map(len, found))]))
        if sum(map(len, found)) == samples:
            parts = [(part.q, part.v, part.t, part.a) for part in found]
            q, v, t, a = map(np.concatenate, zip(*parts, strict=True))
            return States(mechanism, q, v, t, a)
    raise InputError(
        f"expected states of mechanism {mechanism.name!r} at which its coordinate map is defined"
        f"{', its loops are closed' if mechanism.loops else ''} and no spring or "
        f"damper has length zero, found {sum(map(len, found))} of {samples} "
        f"among {_ROUNDS * count} random ones"
    )


def _walk(mechanism: Mechanism, candidates: States, random: np.random.Generator) -> States:
    """Candidates with positions on a random walk from the first of them that closes the loops."""
    for k in range(len(candidates)):
        one = candidates.at(np.array([k]))
        start = closed_states(mechanism, one.q, one.v, one.t)
        if len(start.at):
            q = wander(mechanism, candidates.t, random, start.q[0], _STRIDES)
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
