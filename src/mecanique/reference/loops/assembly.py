"""Close the loops of a mechanism: positions by Gauss–Newton with damping, velocities by projection.

The step is that of Levenberg and Marquardt in scaled units (Marquardt, J. SIAM 11 (1963) 431); near
the solution the damping vanishes and the pseudo-inverse of a Jacobian that may lack rank takes over
(Ben-Israel, J. Math. Anal. Appl. 15 (1966) 243).
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from functools import partial

import numpy as np

from mecanique.arrays import Array
from mecanique.errors import ClosureError, InputError, UnknownNameError
from mecanique.model.contacts import Rolling
from mecanique.model.expression import finite
from mecanique.model.mechanism import Mechanism
from mecanique.model.values import Given
from mecanique.reference.loops.closed import Closed
from mecanique.reference.loops.loading import load_loops
from mecanique.reference.loops.newton import displace, newton
from mecanique.reference.loops.tolerances import (
    ASSEMBLED,
    DEPENDENT,
    EXACT,
    LEAST,
    PIVOT,
    RANK_ASSEMBLED,
    TINY,
    WEAK,
)

__all__ = [
    "assemble",
    "assembly_branches",
    "close_position",
    "close_velocity",
    "free_columns",
    "held_columns",
    "position_near",
    "project",
]

_NEAR = 1e-4
"""Gap, in characteristic lengths or radians, below which steps are not damped."""

_WITHIN = 0.1
"""Part of the distance to a singular position that a drifted state may be moved.

The singular value, relative to the largest, is a measure of that distance.
"""

_SWEEPS = 6
_STEPS = 200
_PATIENCE = 12
"""How many steps in a row may gain less than a thousandth."""

_STARTS = 30
"""From how many random positions to start where no guess is given."""

_LONGEST = 0.5
"""Longest step, in characteristic lengths or radians."""


def assemble(
    mechanism: Mechanism, guess: Given = None, *, keep: Sequence[str] = (), t: float = 0.0
) -> Array:
    """Return positions near a guess at which every loop is closed, shape (nq,).

    Coordinates that the guess names stay as they are if the loops can be closed so; else all give
    way together.

    Args:
        mechanism: what to assemble.
        guess: shape (nq,), or by coordinate name; zero where left out. Without any guess, random
            positions are tried where zero does not lead to a closed one.
        keep: names of coordinates that must stay as guessed.
        t: time [s], for prescribed motions.

    Returns:
        Shape (nq,).

    Raises:
        ClosureError: naming the loop that cannot be closed from there, and by how much it stays
            open.
        InputError: if the guess or the time is not what is expected.
        UnknownNameError: if a name is no coordinate.

    Example:
        >>> crank = mq.textbook.load('slider_crank')
        >>> q = mq.assemble(crank, {'theta': 0.7, 'beta': -0.9, 'x': 1.5})
        >>> bool(mq.Reference(crank).drift(q)[0] < 1e-9)
        True
    """
    q, t = mechanism.position(guess), finite(t, "time t")
    held = held_columns(mechanism, keep)
    if not mechanism.constrained:
        return q
    return position_near(load_loops(mechanism), guess, q, t, held)


def position_near(closed: Closed, guess: Given, q: Array, t: float, held: Array) -> Array:
    """Return positions with closed loops, shape (nq,); named coordinates stay if they can.

    Args:
        closed: the mechanism.
        guess: as the user gave it.
        q: the same, shape (nq,).
        t: time [s].
        held: shape (nv,), which velocities' coordinates must stay.

    Raises:
        ClosureError: naming the loop that cannot be closed, and by how much.
    """
    if isinstance(guess, Mapping) and guess and not held.any():
        try:
            return close_position(closed, q, t, held_columns(closed.mechanism, tuple(guess)))
        except ClosureError:
            pass
    nothing_given = guess is None or (isinstance(guess, Mapping) and not guess)
    if nothing_given and not held.any():
        return _position_anywhere(closed, q, t, held)
    return close_position(closed, q, t, held)


def _position_anywhere(closed: Closed, q: Array, t: float, held: Array) -> Array:
    """Positions near q if they can be closed, else near one of a few random ones."""
    try:
        return close_position(closed, q, t, held)
    except ClosureError as error:
        first = error
    random = np.random.default_rng(0)
    for _ in range(_STARTS):
        away = random.uniform(-1, 1, closed.mechanism.nv) * closed.closures.columns * np.pi
        try:
            return close_position(closed, displace(closed, q, away), t, held)
        except ClosureError:
            continue
    raise first


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

    As many coordinates as there are degrees of freedom stay as guessed; only the others differ, so
    that the positions are the branches of one and the same input, e.g. open and crossed.

    Args:
        mechanism: what to assemble.
        guess: shape (nq,), or by coordinate name; zero where left out.
        keep: names of the coordinates that stay; chosen at the assembled guess if none is given.
        most: how many positions are enough.
        tries: from how many random positions to start.
        seed: of the random positions.
        t: time [s], for prescribed motions.

    Raises:
        ClosureError: if not even one position is found.
        InputError: if an argument is not what is expected.
        UnknownNameError: if a name is no coordinate.
    """
    for name, number in (("most", most), ("tries", tries)):
        if isinstance(number, bool) or not isinstance(number, (int, np.integer)) or number < 1:
            raise InputError(f"expected a whole number of at least 1 for {name}, got {number!r}")
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


def close_position(closed: Closed, q: Array, t: float, held: Array | None = None) -> Array:
    """Return positions near q at which every loop is closed, shape (nq,).

    Args:
        closed: the mechanism.
        q: shape (nq,), the guess.
        t: time [s].
        held: shape (nv,), which velocities' coordinates stay; none by default.

    Raises:
        ClosureError: naming the loop that cannot be closed, and by how much.
    """
    closures = closed.closures
    still, rows = np.zeros(closed.mechanism.nv), closures.positional
    free = np.ones(len(still)) if held is None else np.where(held, 0.0, 1.0)
    damping, gaps, stuck = 1e-3, _gaps(closed, q, t), 0
    for _ in range(_STEPS):
        widest = float(np.abs(gaps).max(initial=0.0))
        if widest <= EXACT or not np.isfinite(gaps).all():
            break
        near = widest < _NEAR
        J = closures.scale(q, still, t).jacobian[rows] * free
        step = free * _damped_step(J, gaps[rows], None if near else damping)
        trial = displace(closed, q, closures.columns * step)
        gaps_after = _gaps(closed, trial, t)
        before, after = float(np.linalg.norm(gaps)), float(np.linalg.norm(gaps_after))
        stuck = stuck + 1 if after > 0.999 * before else 0
        if stuck > _PATIENCE:
            break
        if after < before:
            q, gaps, damping = trial, gaps_after, max(damping / 5, 1e-12)
        elif near or damping > 1e6:
            break
        else:
            damping *= 4
    _refuse_open(closed, np.abs(gaps))
    return q


def _damped_step(J: Array, gaps: Array, damping: float | None) -> Array:
    """Return the scaled step of Levenberg and Marquardt, of limited length.

    Without damping, near the end, directions that are not held are left alone.
    """
    left, singular, right = np.linalg.svd(J, full_matrices=False)
    top = max(float(singular[0]), TINY) if singular.size else 1.0
    least, added = (
        (max(RANK_ASSEMBLED * top, LEAST), 0.0) if damping is None else (0.0, damping * top**2)
    )
    gain = np.zeros_like(singular)
    strong = singular > least
    gain[strong] = singular[strong] / (singular[strong] ** 2 + added)
    step: Array = -right.T @ (gain * (left.T @ gaps))
    longest = float(np.abs(step).max(initial=0.0))
    if longest > _LONGEST:
        step *= _LONGEST / longest
    return step


def _refuse_open(closed: Closed, gaps: Array) -> None:
    """Raise if a loop is left open."""
    closures = closed.closures
    if np.isfinite(gaps).all() and float(gaps.max(initial=0.0)) <= ASSEMBLED:
        return
    worst = int(np.nanargmax(np.where(np.isfinite(gaps), gaps, np.inf)))
    name = closures.names[worst]
    unit = "rad" if name.split(": ")[-1] in ("rx", "ry", "rz") else "m"
    mechanism = closed.mechanism
    owner = (*mechanism.loops, *mechanism.contacts)[int(closures.owner[worst])]
    if isinstance(owner, Rolling):
        raise ClosureError(
            f"mechanism {mechanism.name!r}: {owner.name!r} cannot be put on the plane of "
            f"{owner.on!r} from there; the nearest position found leaves it off by "
            f"{gaps[worst] / closures.rows[worst]:.3g} m; leave free a coordinate that lifts it"
        )
    raise ClosureError(
        f"mechanism {mechanism.name!r}: loop {owner.name!r} cannot be closed from there; "
        "the nearest position found leaves it open by "
        f"{gaps[worst] / closures.rows[worst]:.3g} {unit} ({name}); try another guess, or check "
        "its lengths"
    )


def close_velocity(
    closed: Closed, q: Array, v: Array, t: float, held: Array | None = None
) -> Array:
    """Return the velocities nearest to v that keep the loops closed, shape (nv,).

    Args:
        closed: the mechanism.
        q: shape (nq,), with closed loops.
        v: shape (nv,).
        t: time [s].
        held: shape (nv,), which velocities stay as they are; if they cannot, the others and they
            give way together.
    """
    _, jacobian, rates = closed.closures.scale(q, v, t)
    enough = ASSEMBLED * max(1.0, float(np.abs(v).max(initial=0)))
    if held is not None:
        free = np.where(held, 0.0, 1.0)
        J = jacobian * free
        step = free * -_least_step(J, rates)
        if np.abs(J @ step + rates).max(initial=0.0) <= enough:
            return np.asarray(v + closed.closures.columns * step)
    step = -_least_step(jacobian, rates)
    return np.asarray(v + closed.closures.columns * step)


def project(
    closed: Closed, q: Array, v: Array, t: float, *, drifted: bool = False
) -> tuple[Array, Array]:
    """Return the closed state next to one that is almost closed, positions first, then velocities.

    Args:
        closed: the mechanism.
        q: shape (nq,).
        v: shape (nv,).
        t: time [s].
        drifted: whether the state has only drifted, along a motion. Directions that the constraints
            hardly hold, next to a singular position, are then left alone until the motion has
            passed.
    """
    metric = closed.measure(closed.closures.at(q, v, t).jacobian)
    least = partial(_least_step, most=closed.most, drifted=drifted)
    landing = newton(closed, q, v, t, metric, least, stagnant=0.5, sweeps=_SWEEPS)
    speed = 1 + float(np.abs(v / metric.units.columns).max(initial=0.0))
    turn = least(landing.jacobian, landing.rates / speed)
    return landing.q, v - metric.columns @ (speed * turn)


def _least_step(J: Array, gaps: Array, most: int | None = None, *, drifted: bool = False) -> Array:
    """Return the least x with J x = gaps, as far as J reaches.

    After a drift no part of x goes beyond where J is singular.
    """
    left, singular, right = np.linalg.svd(J, full_matrices=False)
    parts = left.T @ gaps
    hold = singular / max(float(singular.max(initial=0.0)), TINY)
    strong = (hold > (WEAK if drifted else DEPENDENT)) & (singular > LEAST)
    if most is not None:
        strong[most:] = False
    parts[~strong] = 0.0
    parts[strong] /= singular[strong]
    if drifted:
        parts[np.abs(parts) > _WITHIN * hold] = 0.0
    result: Array = right.T @ parts
    return result


def free_columns(closed: Closed, q: Array, t: float) -> Array:
    """Return which coordinates may be chosen freely near a position, by velocities, shape (nv,).

    Args:
        closed: the mechanism.
        q: shape (nq,), with closed loops.
        t: time [s].
    """
    from scipy.linalg import qr

    J = closed.closures.scale(q, np.zeros(closed.mechanism.nv), t).jacobian
    J = J[closed.closures.positional]
    _, R, order = qr(J, mode="economic", pivoting=True)
    pivots = np.abs(np.diag(R))
    rank = int((pivots > PIVOT * max(float(pivots.max(initial=0.0)), TINY)).sum())
    free: Array = np.ones(closed.mechanism.nv, dtype=bool)
    free[order[:rank]] = False
    return free


def _gaps(closed: Closed, q: Array, t: float) -> Array:
    return closed.closures.rows * closed.closures.residual(q, t)


def held_columns(mechanism: Mechanism, names: Sequence[str]) -> Array:
    """Return which velocities belong to coordinates, shape (nv,) of bool.

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
    """How far two positions are apart; full turns and the sign of a quaternion do not count."""
    gap = np.abs(closed.poses(q, t) - closed.poses(other, t))
    gap[:, :3, 3] /= closed.closures.length
    return float(gap.max(initial=0.0))
