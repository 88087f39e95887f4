"""Close the loops of a mechanism: positions near a guess or anywhere, velocities by projection."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from functools import partial

import numpy as np

from mecanique.arrays import Array
from mecanique.errors import ClosureError, UnknownNameError
from mecanique.model.expression import finite
from mecanique.model.mechanism import Mechanism
from mecanique.model.states import expect_mechanism
from mecanique.model.values import Given, names_of, whole
from mecanique.reference.loops.assembly.closing import close_position, is_open, refuse_open, settle
from mecanique.reference.loops.assembly.newton import displace, newton
from mecanique.reference.loops.closed import Closed
from mecanique.reference.loops.loading import load_loops
from mecanique.reference.loops.nullspace import are_certain
from mecanique.reference.loops.tolerances import (
    ASSEMBLED,
    DEPENDENT,
    LEAST,
    PIVOT,
    TINY,
    WEAK,
)

_WITHIN = 0.1
"""Largest correction of a drifted state, as a part of the distance to a singular position.

The least singular value, relative to the largest, measures that distance.
"""

_SWEEPS = 6
_STARTS = 30
"""Number of random positions to start from without a guess."""


def assemble(
    mechanism: Mechanism, guess: Given = None, *, keep: Sequence[str] = (), t: float = 0.0
) -> Array:
    """Return positions near a guess at which every loop is closed, shape (nq,).

    Coordinates named in the guess keep their values if the loops can then be closed; otherwise all
    coordinates are adjusted.

    Args:
        mechanism: the mechanism to assemble.
        guess: shape (nq,), or by coordinate name; zero by default. Loops without a named coordinate
            are also tried from random positions if they cannot be closed from zero.
        keep: names of coordinates that must keep their guessed values.
        t: time [s], for prescribed motions.

    Returns:
        Shape (nq,).

    Raises:
        ClosureError: if a loop cannot be closed from there; the message states its gap.
        InputError: if the guess or the time is invalid.
        UnknownNameError: if a name is not that of a coordinate.

    Example:
        >>> crank = mq.textbook.load('slider_crank')
        >>> q = mq.assemble(crank, {'theta': 0.7, 'beta': -0.9, 'x': 1.5})
        >>> bool(mq.Reference(crank).drift(q)[0] < 1e-9)
        True
    """
    q, t = expect_mechanism(mechanism).position(guess), finite(t, "time t")
    held = held_columns(mechanism, names_of(keep, "keep"))
    if not mechanism.constrained:
        return q
    return position_near(load_loops(mechanism), guess, q, t, held)


def position_near(closed: Closed, guess: Given, q: Array, t: float, held: Array) -> Array:
    """Return positions with closed loops, shape (nq,), keeping named coordinates if possible.

    Args:
        closed: the mechanism.
        guess: the guess as the user gave it.
        q: the same, shape (nq,).
        t: time [s].
        held: shape (nv,), whether the coordinate of each velocity must not change.

    Raises:
        ClosureError: if a loop cannot be closed; the message states its gap.
    """
    if held.any() or not (guess is None or isinstance(guess, Mapping)):
        return close_position(closed, q, t, held)
    named = held_columns(closed.mechanism, tuple(guess or ()))
    for part in range(closed.closures.parts.count):
        q = _close_part(closed, q, t, part, named)
    return q


def _close_part(closed: Closed, q: Array, t: float, part: int, named: Array) -> Array:
    """Return positions that close one part: near q, or anywhere if none of its names is given."""
    closures = closed.closures
    rows, own = closures.parts.rows == part, closures.parts.columns == part
    if (named & own).any():
        found, gaps = settle(closed, q, t, ~own | named)
        if is_open(gaps[rows]).any():
            found, gaps = settle(closed, q, t, ~own)
        refuse_open(closed, np.where(rows, gaps, 0.0))
        return found
    found, first = settle(closed, q, t, ~own)
    gaps, random, away = first, np.random.default_rng(0), np.zeros(len(own))
    for _ in range(_STARTS):
        if not is_open(gaps[rows]).any():
            return found
        away[own] = random.uniform(-1, 1, own.sum()) * closures.columns[own] * np.pi
        found, gaps = settle(closed, displace(closed, q, away), t, ~own)
    if is_open(gaps[rows]).any():
        refuse_open(closed, np.where(rows, first, 0.0))
    return found


def assembly_branches(
    mechanism: Mechanism,
    guess: Given = None,
    *,
    keep: Sequence[str] = (),
    most: int = 8,
    tries: int = 60,
    seed: int = 0,
    t: float = 0.0,
) -> tuple[Array, ...]:
    """Return different positions at which every loop is closed, the one nearest to the guess first.

    As many coordinates as there are degrees of freedom keep their guessed values; the positions
    differ in the others and are the branches for the same input, e.g. open and crossed.

    Args:
        mechanism: the mechanism to assemble.
        guess: shape (nq,), or by coordinate name; zero by default.
        keep: names of the coordinates to keep; by default chosen at the assembled guess.
        most: largest number of positions to return.
        tries: number of random positions to start from.
        seed: of the random positions.
        t: time [s], for prescribed motions.

    Returns:
        The positions, each of shape (nq,).

    Raises:
        ClosureError: if no position is found.
        InputError: if an argument is invalid.
        UnknownNameError: if a name is not that of a coordinate.

    Example:
        >>> linkage = mq.textbook.load("four_bar_linkage")
        >>> ways = mq.assembly_branches(linkage, {"phi": 1.0}, keep=("phi",))
        >>> len(ways)
        2
    """
    most, tries, seed = whole(most, "most"), whole(tries, "tries"), whole(seed, "seed", 0)
    keep = names_of(keep, "keep")
    start = assemble(mechanism, guess, keep=keep, t=t)
    if not mechanism.constrained:
        return (start,)
    closed = load_loops(mechanism)
    named = tuple(guess) if isinstance(guess, Mapping) and not keep else keep
    held = held_columns(mechanism, named)
    free = free_columns(closed, start, t)
    if not keep and held.sum() != free.sum():
        held = free
    random = np.random.default_rng(seed)
    found = [start]
    reach = closed.closures.columns * np.pi
    for _ in range(tries):
        if len(found) >= most:
            break
        away = np.where(held, 0.0, random.uniform(-1, 1, mechanism.nv) * reach)
        try:
            q = close_position(closed, displace(closed, start, away), t, held)
        except ClosureError:
            continue
        if all(_distance(closed, q, other, t) > 1e-6 for other in found):
            found.append(q)
    return tuple(found)


def close_velocity(
    closed: Closed, q: Array, v: Array, t: float, held: Array | None = None
) -> Array:
    """Return the velocities nearest to v that keep the loops closed, shape (nv,).

    Args:
        closed: the mechanism.
        q: shape (nq,), with closed loops.
        v: shape (nv,).
        t: time [s].
        held: shape (nv,), which velocities to keep; if that is impossible, all are changed.
    """
    _, jacobian, rates, rounding = closed.closures.scale(q, v, t)
    enough = ASSEMBLED * max(1.0, float(np.abs(v).max(initial=0)))
    if held is not None:
        free = np.where(held, 0.0, 1.0)
        J = jacobian * free
        step = free * -_find_least_step(J, rates, rounding)
        if np.abs(J @ step + rates).max(initial=0.0) <= enough:
            return np.asarray(v + closed.closures.columns * step)
    step = -_find_least_step(jacobian, rates, rounding)
    return np.asarray(v + closed.closures.columns * step)


def project(
    closed: Closed, q: Array, v: Array, t: float, *, drifted: bool = False
) -> tuple[Array, Array]:
    """Project an almost closed state on the loops, positions first, then velocities.

    Args:
        closed: the mechanism.
        q: shape (nq,).
        v: shape (nv,).
        t: time [s].
        drifted: whether the state has only drifted along a motion. Near a singular position,
            directions that the constraints hardly restrain are then not corrected.
    """
    jacobian = closed.closures.at(q, v, t).jacobian
    metric = closed.measure(jacobian)
    rounding = metric.rounding(jacobian)
    least = partial(_find_least_step, most=closed.most, drifted=drifted)
    positional = partial(least, rounding=rounding[closed.closures.positional])
    landing = newton(closed, q, v, t, metric, positional, stagnant=0.5, sweeps=_SWEEPS)
    speed = 1 + float(np.abs(v / metric.units.columns).max(initial=0.0))
    turn = least(landing.jacobian, landing.rates / speed, rounding)
    return landing.q, v - metric.columns @ (speed * turn)


def _find_least_step(
    J: Array,
    gaps: Array,
    rounding: Array,
    most: int | None = None,
    *,
    drifted: bool = False,
) -> Array:
    """Return the least x with J x = gaps, in the least-squares sense.

    After a drift, components longer than the distance to a singular position allows are left out.
    """
    left, singular, right = np.linalg.svd(J, full_matrices=False)
    parts = left.T @ gaps
    hold = singular / max(float(singular.max(initial=0.0)), TINY)
    strong = are_certain(left, singular, LEAST, rounding) & (
        hold > (WEAK if drifted else DEPENDENT)
    )
    if most is not None:
        strong[most:] = False
    parts[~strong] = 0.0
    parts[strong] /= singular[strong]
    if drifted:
        parts[np.abs(parts) > _WITHIN * hold] = 0.0
    result: Array = right.T @ parts
    return result


def free_columns(closed: Closed, q: Array, t: float) -> Array:
    """Return the velocities whose coordinates may be chosen freely near a position, shape (nv,).

    Args:
        closed: the mechanism.
        q: shape (nq,), with closed loops.
        t: time [s].
    """
    from scipy.linalg import qr

    here = closed.closures.scale(q, np.zeros(closed.mechanism.nv), t)
    positional = closed.closures.positional
    _, R, order = qr(here.jacobian[positional], mode="economic", pivoting=True)
    pivots = np.abs(np.diag(R))
    noise = float(np.linalg.norm(here.rounding[positional]))
    rank = int((pivots > max(PIVOT * pivots.max(initial=0.0), noise, TINY)).sum())
    free: Array = np.ones(closed.mechanism.nv, dtype=bool)
    free[order[:rank]] = False
    return free


def held_columns(mechanism: Mechanism, names: Sequence[str]) -> Array:
    """Return the velocities that belong to given coordinates, shape (nv,) of bool.

    Raises:
        UnknownNameError: if there is no such coordinate.
    """
    held: Array = np.zeros(mechanism.nv, dtype=bool)
    for name in names:
        if name not in mechanism.coordinates:
            raise UnknownNameError("coordinate", name, mechanism.coordinates)
        if f"{name}'" in mechanism.velocities:
            held[mechanism.velocities.index(f"{name}'")] = True
            continue
        joint = next(joint for joint in mechanism.joints if name in joint.coordinates)
        is_angle = name in joint.quaternion
        part = joint.angular_velocities if is_angle else joint.linear_velocities
        held[[mechanism.velocities.index(velocity) for velocity in part]] = True
    return held


def _distance(closed: Closed, q: Array, other: Array, t: float) -> float:
    """Return the distance of two positions; full turns and a quaternion's sign do not count."""
    gap = np.abs(closed.poses(q, t) - closed.poses(other, t))
    gap[:, :3, 3] /= closed.closures.length
    return float(gap.max(initial=0.0))
