"""Close the loops of a mechanism: positions by Gauss–Newton with damping, velocities by projection.

The step is that of Levenberg and Marquardt in scaled units (Marquardt, J. SIAM 11 (1963) 431); near
the solution the damping vanishes and the pseudo-inverse of a Jacobian that may lack rank takes over
(Ben-Israel, J. Math. Anal. Appl. 15 (1966) 243).
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from mecanique.errors import ClosureError, InputError, UnknownNameError
from mecanique.model.expression import finite
from mecanique.model.mechanism import Mechanism
from mecanique.model.values import Given
from mecanique.reference.engine.answers import Array
from mecanique.reference.engine.tree import Tree
from mecanique.reference.loops.closed import LEAST, WEAK, Closed

__all__ = [
    "assemble",
    "assembly_branches",
    "closed_position",
    "closed_velocity",
    "free_columns",
    "held_columns",
    "moved",
    "position_near",
]

_CLOSED = 1e-9
"""Loops this near to closed, in characteristic lengths or radians, count as closed."""

_PROJECTED = 1e-9
"""Singular values below this part of the largest are left alone where a state is brought back."""

_WITHIN = 0.1
"""Part of the distance to a singular position, as the singular value tells it, that a drifted state may be moved."""

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

    Raises:
        ClosureError: naming the loop that cannot be closed from there, and by how much it stays
            open.
        InputError: if the guess or the time is not what is expected.
        UnknownNameError: if a name is no coordinate.
    """
    q, t = mechanism.position(guess), finite(t, "time t")
    held = held_columns(mechanism, keep)
    if not mechanism.loops:
        return q
    return position_near(Closed(Tree(mechanism)), guess, q, t, held)


def position_near(closed: Closed, guess: Given, q: Array, t: float, held: Array) -> Array:
    """Return positions at which every loop is closed; named coordinates of the guess stay if they can, shape (nq,).

    Args:
        closed: the mechanism.
        guess: as the user gave it.
        q: the same, shape (nq,).
        t: time [s].
        held: shape (nv,), which velocities' coordinates must stay.

    Raises:
        ClosureError: naming the loop that cannot be closed, and by how much.
    """
    if isinstance(guess, Mapping) and not held.any():
        try:
            return closed_position(closed, q, t, held_columns(closed.mechanism, tuple(guess)))
        except ClosureError:
            pass
    if guess is None and not held.any():
        return _position_anywhere(closed, q, t, held)
    return closed_position(closed, q, t, held)


def _position_anywhere(closed: Closed, q: Array, t: float, held: Array) -> Array:
    """Positions near q if they can be closed, else near one of a few random ones."""
    try:
        return closed_position(closed, q, t, held)
    except ClosureError as error:
        first = error
    random = np.random.default_rng(0)
    for _ in range(_STARTS):
        away = random.uniform(-1, 1, closed.mechanism.nv) * closed.closures.columns * np.pi
        try:
            return closed_position(closed, moved(closed, q, away), t, held)
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
    if not mechanism.loops:
        return (start,)
    closed = Closed(Tree(mechanism))
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
            q = closed_position(closed, moved(closed, start, away), t, held)
        except ClosureError:
            continue
        if all(_distance(closed, q, other, t) > 1e-6 for other in found):
            found.append(q)
    return tuple(found)


def closed_position(closed: Closed, q: Array, t: float, held: Array | None = None) -> Array:
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
    rows, columns = (
        closures.rows,
        closures.columns if held is None else np.where(held, 0.0, closures.columns),
    )
    rest = np.zeros(len(columns))
    damping, best, stuck = 1e-3, _state(closed, q, t), 0
    for _ in range(_STEPS):
        size = float(np.abs(best).max(initial=0.0))
        if size <= 1e-15 or not np.isfinite(best).all():
            break
        J = rows[:, None] * closures.at(q, rest, t).jacobian * columns
        left, singular, right = np.linalg.svd(J, full_matrices=False)
        top = max(float(singular[0]), 1e-300) if singular.size else 1.0
        # near the end nothing is damped, and directions without a hold are left alone
        near = size < 1e-4
        gain = np.zeros_like(singular)
        strong = singular > (max(1e-7 * top, LEAST) if near else 0.0)
        gain[strong] = singular[strong] / (
            singular[strong] ** 2 + (0.0 if near else damping * top**2)
        )
        step = -right.T @ (gain * (left.T @ best))
        longest = float(np.abs(step).max(initial=0.0))
        if longest > _LONGEST:
            step *= _LONGEST / longest
        trial = moved(closed, q, columns * step)
        after = _state(closed, trial, t)
        before, now = float(np.linalg.norm(best)), float(np.linalg.norm(after))
        stuck = stuck + 1 if now > 0.999 * before else 0
        if stuck > _PATIENCE:
            break
        if now < before:
            q, best, damping = trial, after, max(damping / 5, 1e-12)
        elif near or damping > 1e6:
            break
        else:
            damping *= 4
    gaps = np.abs(best)
    if not np.isfinite(gaps).all() or float(gaps.max(initial=0.0)) > _CLOSED:
        worst = int(np.nanargmax(np.where(np.isfinite(gaps), gaps, np.inf)))
        name = closures.names[worst]
        unit = "rad" if name.split(": ")[-1] in ("rx", "ry", "rz") else "m"
        loop = closed.mechanism.loops[int(closures.owner[worst])].name
        raise ClosureError(
            f"mechanism {closed.mechanism.name!r}: loop {loop!r} cannot be closed from there; the nearest position "
            f"found leaves it open by {gaps[worst] / rows[worst]:.3g} {unit} ({name}); try another guess, or check "
            "its lengths"
        )
    return q


def closed_velocity(
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
    closures = closed.closures
    closure = closures.at(q, v, t)
    off = closures.rows * (closure.jacobian @ v + closure.drift)
    for fixed in (held, None) if held is not None else (None,):
        columns = closures.columns if fixed is None else np.where(fixed, 0.0, closures.columns)
        J = closures.rows[:, None] * closure.jacobian * columns
        step = -_least(J, off)
        if fixed is None or np.abs(J @ step + off).max(initial=0.0) <= 1e-9 * max(
            1.0, float(np.abs(v).max(initial=0))
        ):
            break
    result: Array = v + columns * step
    return result


def projected(
    closed: Closed, q: Array, v: Array, t: float, *, drifted: bool = False
) -> tuple[Array, Array]:
    """Return the closed state next to one that is almost closed: positions by Newton's method, then velocities.

    Args:
        closed: the mechanism.
        q: shape (nq,).
        v: shape (nv,).
        t: time [s].
        drifted: whether the state has only drifted, along a motion. Directions that the constraints
            hardly hold, next to a singular position, are then left alone until the motion has
            passed.
    """
    closures = closed.closures
    rows, columns = closures.rows, closures.columns
    size = np.inf
    for _ in range(_SWEEPS):
        closure = closures.at(q, v, t)
        J, off = rows[:, None] * closure.jacobian * columns, rows * closure.residual
        last, size = size, float(np.abs(off).max(initial=0.0))
        if size < 1e-15 or size > 0.5 * last:
            break
        q = moved(closed, q, -columns * _least(J, off, closed.most, drifted=drifted))
    off = rows * (closure.jacobian @ v + closure.drift)
    speed = 1 + float(np.abs(v / columns).max(initial=0.0))
    return q, v - columns * speed * _least(J, off / speed, closed.most, drifted=drifted)


def _least(J: Array, off: Array, most: int | None = None, *, drifted: bool = False) -> Array:
    """The least x with J x = off, as far as J reaches; after a drift no part of x is beyond where J is singular."""
    left, singular, right = np.linalg.svd(J, full_matrices=False)
    parts = left.T @ off
    hold = singular / max(float(singular.max(initial=0.0)), 1e-300)
    strong = (hold > (WEAK if drifted else _PROJECTED)) & (singular > LEAST)
    if most is not None:
        strong[most:] = False
    parts[~strong] = 0.0
    parts[strong] /= singular[strong]
    if drifted:
        parts[np.abs(parts) > _WITHIN * hold] = 0.0
    result: Array = right.T @ parts
    return result


def free_columns(closed: Closed, q: Array, t: float) -> Array:
    """Return which velocities may be chosen freely, as many as there are degrees of freedom, shape (nv,) of bool.

    Args:
        closed: the mechanism.
        q: shape (nq,), with closed loops.
        t: time [s].
    """
    from scipy.linalg import qr

    closures = closed.closures
    J = (
        closures.rows[:, None]
        * closures.at(q, np.zeros(closed.mechanism.nv), t).jacobian
        * closures.columns
    )
    _, R, order = qr(J, mode="economic", pivoting=True)
    pivots = np.abs(np.diag(R))
    rank = int((pivots > 1e-8 * max(float(pivots.max(initial=0.0)), 1e-300)).sum())
    free: Array = np.ones(closed.mechanism.nv, dtype=bool)
    free[order[:rank]] = False
    return free


def moved(closed: Closed, q: Array, step: Array) -> Array:
    """Return positions moved along velocity directions, to first order, with unit quaternions.

    Args:
        closed: the mechanism.
        q: shape (nq,).
        step: shape (nv,), a velocity times a short time.
    """
    result: Array = q + closed.rates(q, step)
    for _, at in closed.mechanism.quaternions:
        result[at] /= np.linalg.norm(result[at])
    return result


def _state(closed: Closed, q: Array, t: float) -> Array:
    return closed.closures.rows * closed.closures.residual(q, t)


def held_columns(mechanism: Mechanism, names: Sequence[str]) -> Array:
    """Return which velocities belong to coordinates, shape (nv,) of bool.

    Args:
        mechanism: whose coordinates.
        names: of the coordinates.

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
