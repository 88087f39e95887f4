"""Close the loops of a mechanism: positions near a guess or anywhere, velocities by projection.

From nearby, Newton's method closes them: in coordinates of the tangent space at a position, the
position with closed loops is a smooth function of the displacement (Potra & Rheinboldt, Mech.
Struct. Mach. 19 (1991) 1). From far away, the steps are those of Levenberg and Marquardt in scaled
units (Marquardt, J. SIAM 11 (1963) 431); near the solution the damping vanishes, and the
pseudo-inverse of a possibly rank-deficient Jacobian is used (Ben-Israel, J. Math. Anal. Appl. 15
(1966) 243). Parts that share no motion are closed at the same time, but each with its own damping
and its own end, as if it were alone.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from typing import NamedTuple, TypeAlias

import numpy as np
import numpy.typing as npt

from mecanique.arrays import Array
from mecanique.errors import ClosureError
from mecanique.model import Loop, Mechanism
from mecanique.model.expression import finite
from mecanique.model.mechanism.letters import find_name
from mecanique.model.states import expect_mechanism
from mecanique.model.values import Given, names_of, whole
from mecanique.reference.loops.closed import Closed, load_loops
from mecanique.reference.loops.nullspace import Metric, are_certain
from mecanique.reference.tolerances import (
    ASSEMBLED,
    DEPENDENT,
    EPSILON,
    EXACT,
    LEAST,
    OPEN,
    PIVOT,
    RANK_ASSEMBLED,
    TINY,
    WEAK,
)
from mecanique.reference.vectors import rank_of

Least: TypeAlias = Callable[[Array, Array], Array]
"""Returns the least-squares solution of J x = gaps, for a scaled Jacobian and scaled gaps."""


class Tangent(NamedTuple):
    """The displacements among which to search: along + directions @ bend, in metric directions."""

    along: Array  # shape (nv,), a given displacement
    directions: Array  # shape (nv, k), directions of the correction
    bend: Array  # shape (k,), initial correction


class NewtonResult(NamedTuple):
    """The result of Newton's method."""

    q: Array  # shape (nq,)
    bend: Array  # shape (k,), the correction in the tangent space; empty without one
    jacobian: Array  # scaled Jacobian, in the directions of the tangent space if there is one
    rates: Array  # shape (m,), scaled rates of the gaps
    gap: float  # the largest gap, in natural units
    rounding: float  # the gap that rounding leaves there


def newton(
    closed: Closed,  # the mechanism
    q: Array,  # shape (nq,)
    v: Array,  # shape (nv,), for the rates of the gaps
    t: float,  # time [s]
    metric: Metric,  # the metric of the state
    least: Least,  # solves for a step
    *,
    tangent: Tangent | None = None,
    near: float = np.inf,  # gap below which stagnation ends the iteration
    stagnant: float,  # a step stagnates if it leaves more than this part of the gap
    sweeps: int,  # largest number of steps
) -> NewtonResult:
    """Close the loops near q by a limited number of Newton's steps."""
    # Without a tangent space every step starts at the last position and has any direction.
    bend = np.zeros(0) if tangent is None else tangent.bend
    there = q if tangent is None else _within(closed, q, metric, tangent, bend)
    gap = np.inf
    for _ in range(sweeps):
        closure = closed.closures.at(there, v, t)
        J = metric.scale(closure.jacobian)
        if tangent is not None:
            J = J @ tangent.directions
        last, gap = gap, float(np.abs(metric.units.rows * closure.residual).max(initial=0.0))
        if gap < EXACT or (gap < near and gap > stagnant * last):
            break
        held = closed.closures.positional
        step = -least(J[held], (metric.rows * closure.residual)[held])
        if tangent is None:
            there = displace(closed, there, metric.columns @ step)
        else:
            bend = bend + step
            there = _within(closed, q, metric, tangent, bend)
    rates = metric.rows * (closure.jacobian @ v + closure.drift)
    # the rounding of large angles propagates along a chain
    moved = metric.units.rows * (np.abs(closure.jacobian) @ closed.sizes(there))
    rounding = closed.closures.rounding() + EPSILON * float(moved.max(initial=0.0))
    return NewtonResult(there, bend, J, rates, gap, rounding)


def displace(closed: Closed, q: Array, step: Array) -> Array:
    """Return positions displaced along velocities, to first order, with unit quaternions."""
    result: Array = q + closed.rates(q, step)
    for _, at in closed.mechanism.quaternions:
        result[at] /= np.linalg.norm(result[at])
    return result


def _within(closed: Closed, q: Array, metric: Metric, tangent: Tangent, bend: Array) -> Array:
    return displace(closed, q, metric.columns @ (tangent.along + tangent.directions @ bend))


DIGITS = "where axes are to be parallel, or lengths alike, write them with all digits"
"""Remedy where a row of a loop is left open, or held, by the rounding of a description alone."""

MOST_TRIES = 1_000_000
"""Random positions that may be asked for: hours of work."""

_NEAR = 1e-4
"""Gap, in characteristic lengths or radians, below which steps are not damped."""

_STEPS = 200
_PATIENCE = 12
"""Largest number of successive steps that each gain less than a thousandth."""

_LONGEST = 0.5
"""Longest step, in characteristic lengths or radians."""


def close_position(closed: Closed, q: Array, t: float, held: Array | None = None) -> Array:
    """Return positions near q at which every loop is closed, shape (nq,)."""
    closest, gaps = settle(closed, q, t, held)
    refuse_open(closed, gaps)
    return closest


@dataclass
class _Search:
    """The state of the search for a position that closes one part."""

    rows: npt.NDArray[np.intp]  # indices of the part's constraints
    at: npt.NDArray[np.intp]  # indices of its velocities
    turning: npt.NDArray[np.bool_]  # which of them are angular
    damping: float = 1e-3  # damping of the next step, as a part of the largest singular value
    stuck: int = 0  # number of successive steps that gained almost nothing
    over: bool = False  # whether the search has been given up

    def is_over(self, gaps: Array) -> bool:
        """Return whether the part is closed, or the search has been given up."""
        gaps_of_loop = gaps[self.rows]
        return self.over or self._widest(gaps) <= EXACT or not np.isfinite(gaps_of_loop).all()

    def step(self, J: Array, gaps: Array, rounding: Array) -> Array:
        """Return the next step, scaled."""
        widest = self._widest(gaps)
        damping = None if widest < _NEAR else self.damping
        # from afar a body is carried rather than turned: a wheel would come to lie flat
        ease = np.where(self.turning, 1.0, max(1.0, widest))
        J = J[np.ix_(self.rows, self.at)] * ease
        return ease * _damped_step(J, gaps[self.rows], damping, rounding[self.rows])

    def accept(self, gaps: Array, trial: Array) -> bool:
        """Return whether to take a step, and set the damping of the next."""
        before, after = (float(np.linalg.norm(all_of[self.rows])) for all_of in (gaps, trial))
        self.stuck = self.stuck + 1 if after > 0.999 * before else 0
        if self.stuck > _PATIENCE:
            self.over = True
            return False
        if after < before:
            self.damping = max(self.damping / 5, 1e-12)
            return True
        self.over = self._widest(gaps) < _NEAR or self.damping > 1e6
        self.damping *= 4
        return False

    def _widest(self, gaps: Array) -> float:
        return float(np.abs(gaps[self.rows]).max(initial=0.0))


def settle(closed: Closed, q: Array, t: float, held: Array | None = None) -> tuple[Array, Array]:
    """Return the positions closest to closed that were found, and their gaps, shape (m,)."""
    # Parts that share no motion are closed at the same time, but each with its own damping and end
    closures, parts = closed.closures, closed.closures.parts
    positional = closures.positional
    free = np.ones(closed.mechanism.nv) if held is None else np.where(held, 0.0, 1.0)
    searches = []
    for k in range(parts.count):
        moving = np.flatnonzero(parts.columns == k)
        if free[moving].any():
            rows = np.flatnonzero((parts.rows == k) & positional)
            searches.append(_Search(rows, moving, closures.turning[moving]))
    gaps, here = _gaps(closed, q, t), closures.slopes(q, t)
    for _ in range(_STEPS):
        searches = [search for search in searches if not search.is_over(gaps)]
        if not searches:
            break
        slopes, rounding = here
        J = slopes * free
        step = np.zeros(len(free))
        for search in searches:
            step[search.at] = free[search.at] * search.step(J, gaps, rounding)
        moved = displace(closed, q, closures.columns * step)
        trial = _gaps(closed, moved, t)
        back = [search for search in searches if not search.accept(gaps, trial)]
        if len(back) == len(searches):
            continue
        if back:
            step[np.concatenate([search.at for search in back])] = 0.0
            moved = displace(closed, q, closures.columns * step)
            trial = _gaps(closed, moved, t)
        q, gaps, here = moved, trial, closures.slopes(moved, t)
    return q, np.abs(gaps)


def is_open(gaps: Array) -> npt.NDArray[np.bool_]:
    """Return whether each gap is wider than an assembly may leave, or not finite."""
    return ~(gaps <= ASSEMBLED)


def _damped_step(
    J: Array, gaps: Array, damping: float | None, rounding: Array | float = 0.0
) -> Array:
    """Return the scaled step of Levenberg and Marquardt, of limited length."""
    # Without damping, near the end, it leaves out directions that the constraints do not restrain
    if damping is None:
        step = -_find_least_step(J, gaps, rounding, RANK_ASSEMBLED)
    else:
        left, singular, right = np.linalg.svd(J, full_matrices=False)
        added = damping * singular.max(initial=0.0) ** 2
        gain = singular / np.maximum(singular**2 + added, TINY)
        step = -right.T @ (gain * (left.T @ gaps))
    longest = float(np.abs(step).max(initial=0.0))
    if longest > _LONGEST:
        step *= _LONGEST / longest
    return step


def refuse_open(closed: Closed, gaps: Array) -> None:
    """Refuse gaps that leave a loop open."""
    closures = closed.closures
    if not is_open(gaps).any():
        return
    worst = int(np.nanargmax(np.where(np.isfinite(gaps), gaps, np.inf)))
    name = closures.names[worst]
    unit = "rad" if name.split(": ")[-1] in ("rx", "ry", "rz") else "m"
    mechanism = closed.mechanism
    owner = (*mechanism.loops, *mechanism.contacts)[int(closures.owner[worst])]
    if not isinstance(owner, Loop):
        raise ClosureError(
            f"mechanism {mechanism.name!r}: {owner.name!r} cannot be put on the plane of "
            f"{owner.on!r} from there; the nearest position found leaves it off by "
            f"{gaps[worst] / closures.rows[worst]:.3g} m; do not fix the coordinate that lifts it"
        )
    remedy = DIGITS if gaps[worst] < OPEN else "try another guess, or check its lengths"
    raise ClosureError(
        f"mechanism {mechanism.name!r}: loop {owner.name!r} cannot be closed from there; "
        "the nearest position found leaves it open by "
        f"{gaps[worst] / closures.rows[worst]:.3g} {unit} ({name}); {remedy}"
    )


def _gaps(closed: Closed, q: Array, t: float) -> Array:
    return closed.closures.rows * closed.closures.residual(q, t)


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
    """Return positions with closed loops, shape (nq,), keeping named coordinates if possible."""
    if held.any() or not (guess is None or isinstance(guess, Mapping)):
        return close_position(closed, q, t, held)
    named = held_columns(closed.mechanism, tuple(guess or ()))
    for part in range(closed.closures.parts.count):
        q = _close_part(closed, q, t, part, named)
    return q


def _close_part(closed: Closed, q: Array, t: float, part: int, named: Array) -> Array:
    """Return positions that close one part: near q, or anywhere if none of its names is given."""
    closures = closed.closures
    rows, moving = closures.parts.rows == part, closures.parts.columns == part
    if (named & moving).any():
        closest, gaps = settle(closed, q, t, ~moving | named)
        if is_open(gaps[rows]).any():
            closest, gaps = settle(closed, q, t, ~moving)
        refuse_open(closed, np.where(rows, gaps, 0.0))
        return closest
    closest, first = settle(closed, q, t, ~moving)
    gaps, least, random, away = first, first, np.random.default_rng(0), np.zeros(len(moving))
    for _ in range(_STARTS):
        if not is_open(gaps[rows]).any():
            return closest
        away[moving] = random.uniform(-1, 1, moving.sum()) * closures.columns[moving] * np.pi
        closest, gaps = settle(closed, displace(closed, q, away), t, ~moving)
        least = min(least, gaps, key=lambda gap: np.nan_to_num(gap[rows], nan=np.inf).max())
    refuse_open(closed, np.where(rows, least if least[rows].max() < OPEN else first, 0.0))
    return closest


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
    most, tries, seed = (
        whole(most, "most"),
        whole(tries, "tries", most=MOST_TRIES),
        whole(seed, "seed", 0),
    )
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
    branches = [start]
    reach = closed.closures.columns * np.pi
    for _ in range(tries):
        if len(branches) >= most:
            break
        away = np.where(held, 0.0, random.uniform(-1, 1, mechanism.nv) * reach)
        try:
            q = close_position(closed, displace(closed, start, away), t, held)
        except ClosureError:
            continue
        if all(_distance(closed, q, branch, t) > 1e-6 for branch in branches):
            branches.append(q)
    return tuple(branches)


def close_velocity(
    closed: Closed, q: Array, v: Array, t: float, held: Array | None = None
) -> Array:
    """Return the velocities nearest to v that keep the loops closed, shape (nv,)."""
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
    """Project an almost closed state on the loops, positions first, then velocities."""
    # After a mere drift, directions hardly restrained near a singular position are not corrected.
    # Shapes: q (nq,), v (nv,)
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
    rounding: Array | float,
    part: float = DEPENDENT,  # singular values below this part of the largest count as zero
    most: int | None = None,
    *,
    drifted: bool = False,
) -> Array:
    """Return the least x with J x = gaps, in the least-squares sense."""
    # After a drift, components longer than the distance to a singular position allows are left out
    left, singular, right = np.linalg.svd(J, full_matrices=False)
    parts = left.T @ gaps
    hold = singular / max(float(singular.max(initial=0.0)), TINY)
    strong = are_certain(left, singular, LEAST, rounding) & (hold > (WEAK if drifted else part))
    if most is not None:
        strong[most:] = False
    parts[~strong] = 0.0
    parts[strong] /= singular[strong]
    if drifted:
        parts[np.abs(parts) > _WITHIN * hold] = 0.0
    result: Array = right.T @ parts
    return result


def free_columns(closed: Closed, q: Array, t: float) -> Array:
    """Return the velocities whose coordinates may be chosen freely near a position, shape (nv,)."""
    from scipy.linalg import qr

    here = closed.closures.scale(q, np.zeros(closed.mechanism.nv), t)
    positional = closed.closures.positional
    _, R, order = qr(here.jacobian[positional], mode="economic", pivoting=True)
    pivots = np.abs(np.diag(R))
    noise = float(np.linalg.norm(here.rounding[positional]))
    rank = rank_of(pivots, PIVOT, noise)
    free: Array = np.ones(closed.mechanism.nv, dtype=bool)
    free[order[:rank]] = False
    return free


def held_columns(mechanism: Mechanism, names: Sequence[str]) -> Array:
    """Return the velocities that belong to given coordinates, shape (nv,) of bool."""
    held: Array = np.zeros(mechanism.nv, dtype=bool)
    for typed in names:
        name = find_name(mechanism, typed, mechanism.coordinates)
        if f"{name}'" in mechanism.velocities:
            held[mechanism.velocities.index(f"{name}'")] = True
            continue
        joint = next(joint for joint in mechanism.joints if name in joint.coordinates)
        is_angle = name in joint.quaternion
        part = joint.angular_velocities if is_angle else joint.linear_velocities
        held[[mechanism.velocities.index(velocity) for velocity in part]] = True
    return held


def _distance(closed: Closed, q: Array, start: Array, t: float) -> float:
    """Return the distance of two positions; full turns and a quaternion's sign do not count."""
    gap = np.abs(closed.poses(q, t) - closed.poses(start, t))
    gap[:, :3, 3] /= closed.closures.length
    return float(gap.max(initial=0.0))
