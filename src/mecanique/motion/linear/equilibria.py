"""Find the positions in which a mechanism can rest, by Newton's method from many starts."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from contextlib import suppress
from dataclasses import dataclass
from typing import TYPE_CHECKING, final

import numpy as np

from mecanique.arrays import Array
from mecanique.errors import EngineError, InputError, MecaniqueError
from mecanique.model.expression import finite
from mecanique.model.mechanism import Mechanism
from mecanique.model.mechanism_units import units
from mecanique.model.random_positions import draw_positions
from mecanique.model.values import whole
from mecanique.motion.linear.differences import find_idle, linearize_about
from mecanique.motion.linear.free_motions import effort
from mecanique.motion.linear.linearization import Linearization
from mecanique.motion.record.rates import Rates
from mecanique.motion.simulation.problem import Values
from mecanique.motion.tolerances import (
    ACCELERATES,
    AT_REST,
    AT_REST_ON_LOOPS,
    FLAT_SLOPE,
    IN_LINE,
    NEWTON_STEP,
    NEWTON_STEP_ON_LOOPS,
    NO_FORCE,
    SAME_FORCES,
    SAME_PLACE,
    SLOPE_STEP,
    SMALL_ACCELERATION,
    TINY,
    TURN,
)
from mecanique.threads import one_thread_for_loops
from mecanique.wording import Legible, enumerate_words

if TYPE_CHECKING:
    from mecanique.reference import Reference
    from mecanique.reference.loops.closed import Closed


_REACH = 1.0
"""Lengths of random starts lie within this of zero [m]."""

MOST_STARTS = 1_000_000
"""Random starts that may be asked for: hours of work."""

STEPS = 100
"""Most Newton steps from a start."""

HALVINGS = 20
"""How often a step that does not help is halved."""

PATIENCE, GAIN = 6, 0.9
"""A start is given up after so many steps on loops that do not bring the forces down to this part
of their least: between two turning points of a force Newton's method goes to and fro for good."""


@final
@dataclass(frozen=True, eq=False, repr=False)
class Equilibrium(Legible):
    """A position in which a mechanism can rest.

    Args:
        q: shape (nq,), the position.
        linearization: small motions about it.
        family: what may have any value at rest, by name; coordinates that change together are
            named together, as "phi and psi together". Empty where it stands alone.

    Example:
        >>> down, up = mq.equilibria(mq.textbook.load("rigid_bar_pendulum"))
        >>> down.stable, up.stable
        (True, False)
        >>> down.linearization.frequencies.round(3)
        array([3.836])
    """

    q: np.ndarray
    linearization: Linearization
    family: tuple[str, ...] = ()

    @property
    def stable(self) -> bool:
        """Whether no small deviation grows exponentially."""
        return self.linearization.stable

    def __str__(self) -> str:
        first, *rest = str(self.linearization).splitlines()
        return "\n".join([first + say_family(self.family), *rest])


@one_thread_for_loops
def equilibria(
    mechanism: Mechanism,
    starts: int | Iterable[Values] = 50,
    *,
    t: float = 0.0,
    seed: int = 0,
    reference: Reference | None = None,
) -> tuple[Equilibrium, ...]:
    """Return the equilibria that Newton's method finds, in the order of their potential energy.

    Angles that differ by whole turns are one position; they are brought to −π…π where the forces
    are the same there. Of a family of equilibria that nothing separates, e.g. of a cart anywhere on
    its track or a coin upright anywhere on its table, one is returned, and its `family` says which
    coordinates are free.

    Args:
        mechanism: what may rest.
        starts: positions to start from, or how many random ones besides the neutral position.
        t: time at which forces are taken [s].
        seed: of the random starts: angles in −π…π, lengths in −1…1 m.
        reference: the mechanism's `Reference`, if you have one already.

    Returns:
        One for each position found.

    Raises:
        InputError: if a start is not what is expected, or the loops lock the mechanism in a
            singular position.
        UnknownNameError: if a coordinate does not exist.
        ClosureError: if the loops cannot be closed at all.

    Example:
        >>> [each.stable for each in mq.equilibria(mq.textbook.load('rigid_bar_pendulum'))]
        [True, False]
    """
    t = finite(t, "the time t")
    if reference is None:
        from mecanique.reference import Reference

        reference = Reference.of(mechanism)
    if reference.closed is not None:
        from mecanique.reference.loops.freedom import refuse_locked

        refuse_locked(reference.closed, t)
    if isinstance(starts, int):
        count = whole(starts, "the number of starts", 0, MOST_STARTS)
        positions = draw_starts(mechanism, count, seed)
    else:
        positions = [mechanism.position(start) for start in starts]
    search = EquilibriumSearch(reference, positions, t)
    for start in positions:
        search.add(start)
    return search.sorted


@final
class EquilibriumSearch:
    """The equilibria that starts, shape (nq,) each, have led to so far."""

    def __init__(self, reference: Reference, starts: Sequence[np.ndarray], t: float) -> None:
        self.equilibria: list[Equilibrium] = []
        self.refused: list[MecaniqueError] = []
        """Why positions of rest cannot be linearized about."""
        self._reference, self._t = reference, t
        mechanism = reference.mechanism
        self._rates = Rates.of(mechanism)
        self._idle: list[Array] = []
        """The displacements that nothing resists at each of them, shape (nv, k)."""
        unit, places = units(mechanism), zip(*self._rates.plain, strict=True)
        names = mechanism.coordinates.names
        turning = [(in_q, in_v) for in_q, in_v in places if unit[names[in_q]] == "rad"]
        self._turning = [in_q for in_q, _ in turning]
        self._spinning = [in_v for _, in_v in turning]
        self._scales, self._least = _usual_inertia(reference, starts, t)

    @property
    def sorted(self) -> tuple[Equilibrium, ...]:
        """The equilibria in the order of their potential energy."""
        return tuple(sorted(self.equilibria, key=lambda e: self._potential(e.q)))

    def add(self, start: np.ndarray) -> None:
        """Add the equilibrium that a start leads to, if it leads to one that is not there yet."""
        q = equilibrium_near(self._reference, start, self._t)
        if q is None:
            return
        q = _unwind(self._reference, q, self._turning, self._t)
        if self._is_known(q):
            return
        # where the axes of a gimbal fall in line the mass matrix has no inverse, and next to a
        # singular position the loops leave no small motion
        try:
            self._refuse_singular(q)
            linearization = linearize_about(self._reference, q, t=self._t)
            idle = find_idle(self._reference, q, self._t)
        except (EngineError, InputError) as error:
            self.refused.append(error)
        else:
            family = find_family(self._reference, q, self._t, idle)
            self.equilibria.append(Equilibrium(q, linearization, family))
            self._idle.append(idle)

    def _is_known(self, q: Array) -> bool:
        """Return whether a position of rest is among those there, or of a family of theirs."""
        curved = []
        for known, idle in zip(self.equilibria, self._idle, strict=True):
            gap = self._apart(known.q, q)
            if np.abs(gap - idle @ (idle.T @ gap)).max(initial=0.0) < SAME_PLACE:
                return True
            if idle.shape[1]:
                curved.append((known.q, idle))
        height = self._potential(q)
        return any(
            abs(self._potential(place) - height) <= SAME_FORCES * (1 + abs(height))
            and self._walks(place, idle, q)
            for place, idle in curved
        )

    def _potential(self, q: Array) -> float:
        return float(self._reference.energy(q, None, self._t).potential)

    def _walks(self, place: Array, idle: Array, goal: Array) -> bool:
        """Return whether a way along positions of rest leads nearer and nearer to another."""
        gap, near = self._apart(place, goal), np.inf
        while (size := float(np.linalg.norm(gap))) < near * (1 - LEAST_GAIN):
            near, step = size, idle @ (idle.T @ gap)
            if size < SAME_PLACE:
                return True
            step *= min(1.0, WALK / max(float(np.linalg.norm(step)), TINY))
            ahead = self._rates.normalize(self._rates.displace(place, step))
            rest = equilibrium_near(self._reference, ahead, self._t)
            if rest is None:
                return False
            try:
                place, idle = rest, find_idle(self._reference, rest, self._t)
            except InputError:
                return False
            gap = self._apart(place, goal)
        return False

    def _apart(self, start: Array, end: Array) -> Array:
        """Return the step along velocities between positions, angles by the shorter way."""
        gap = self._rates.between(start, end)
        gap[self._spinning] = (gap[self._spinning] + np.pi) % (2 * np.pi) - np.pi
        return gap

    def _refuse_singular(self, q: np.ndarray) -> None:
        mechanism = self._reference.mechanism
        if mechanism.constrained or not mechanism.nv:
            return
        mass = self._reference.mass_matrix(q, self._t)
        values, motions = np.linalg.eigh(mass / np.outer(self._scales, self._scales))
        if values[0] <= IN_LINE * self._least:
            still = np.abs(motions[:, 0])
            names = [
                name
                for name, part in zip(mechanism.velocities, still, strict=True)
                if part > 0.1 * still.max()
            ]
            place = ", ".join(
                f"{name} = {round(x, 6) + 0.0:.6g}"
                for name, x in zip(mechanism.coordinates, q, strict=True)
            )
            raise InputError(f"a motion of {', '.join(names)} moves no mass at {place}")


def _usual_inertia(
    reference: Reference, positions: Sequence[np.ndarray], t: float
) -> tuple[np.ndarray, float]:
    """Return √M_ii at its largest, shape (nv,), and the largest least eigenvalue of M so scaled."""
    nv = reference.mechanism.nv
    masses: list[np.ndarray] = [np.zeros((nv, nv))]
    for position in positions:
        with suppress(MecaniqueError):
            masses.append(reference.mass_matrix(position, t))
    largest = np.max([np.diagonal(mass) for mass in masses], axis=0)
    scales = np.sqrt(np.where(largest > 0, largest, 1.0))
    scaled = np.array(masses) / np.outer(scales, scales)
    return scales, float(np.linalg.eigvalsh(scaled)[:, 0].max()) if nv else 0.0


def draw_starts(mechanism: Mechanism, count: int, seed: int) -> list[np.ndarray]:
    """Return the neutral position and random ones: angles in −π…π, lengths in −1…1 m."""
    drawn = draw_positions(mechanism, count, np.random.default_rng(seed), _REACH)
    return [mechanism.neutral(), *drawn]


def _unwind(reference: Reference, q: np.ndarray, turning: list[int], t: float) -> np.ndarray:
    """Bring angles to −π…π if the forces are the same there; with a torsion spring they are not."""
    if not turning:
        return q
    wound = q.copy()
    wound[turning] = (wound[turning] + np.pi - TURN) % (2 * np.pi) - np.pi + TURN
    still = np.zeros(reference.mechanism.nv)
    before, after = (reference.inverse_dynamics(x, still, still, t) for x in (q, wound))
    same = np.abs(before - after).max(initial=0.0) < SAME_FORCES * (1 + np.abs(before).max())
    return wound if same else q


WALK, LEAST_GAIN = 0.5, 1e-3
"""Longest step along a family [rad or m], and the part of the way that a step must gain."""

DISPLACEMENTS = (-1.7, -0.4, 0.6, 2.1)
"""By how much a coordinate is changed [rad or m]."""


_NAMED = 4  # coordinates


def find_family(reference: Reference, q: Array, t: float, idle: Array) -> tuple[str, ...]:
    """Return what may have any value at rest, by the displacements that nothing resists there."""
    mechanism, rates = reference.mechanism, Rates.of(reference.mechanism)
    still, directions = np.zeros(mechanism.nv), np.eye(mechanism.nv)
    disturbed = np.full(mechanism.nv, np.inf)
    along = np.linalg.norm(idle, axis=1)
    for k in np.flatnonzero(along > 1 - SAME_PLACE):
        try:
            moved = [rates.displace(q, step * directions[k]) for step in DISPLACEMENTS]
            accelerations = [reference.acceleration(position, still, t=t) for position in moved]
        except MecaniqueError:
            continue  # beyond its limits, or in a singular position
        disturbed[k] = np.abs(accelerations).max()
    known = disturbed[np.isfinite(disturbed)]
    free = disturbed < SMALL_ACCELERATION * max(1.0, known.max(initial=0.0))
    names = _name_directions(mechanism)
    alone = [name for name, size in zip(names, free, strict=True) if size]
    rest = _move_together(reference, q, t, idle * ~free[:, None])
    moved = ~free & (np.abs(rates.between(q, rest)) > SAME_PLACE)
    joined = [name for name, moves in zip(names, moved, strict=True) if moves]
    if len(joined) > 1:
        joined = [f"{enumerate_words(joined)} together"]
    return (*alone, *joined)


def _move_together(reference: Reference, q: Array, t: float, idle: Array) -> Array:
    """Return another position of rest along directions, or the same if they lead to none."""
    rates, length = Rates.of(reference.mechanism), np.linalg.norm(idle, axis=0)
    if length.max(initial=0.0) < SAME_PLACE:
        return q
    ahead = rates.displace(q, WALK / 2 * idle[:, length.argmax()])
    rest = equilibrium_near(reference, ahead, t)
    stays = rest is not None and np.linalg.norm(rates.between(ahead, rest)) < WALK / 4
    return rest if rest is not None and stays else q


def _name_directions(mechanism: Mechanism) -> list[str]:
    """Return the coordinate of each velocity; of what turns by a quaternion, what it turns."""
    names = [name.removesuffix("'") for name in mechanism.velocities]
    for joint in mechanism.joints:
        if joint.quaternion:
            for axis, name in zip("xyz", joint.velocities[-3:], strict=True):
                names[mechanism.velocities.index(name)] = f"turns of {joint.child} about {axis}"
    return names


def say_family(names: tuple[str, ...]) -> str:
    """Return what is added to a sentence about an equilibrium; nothing if it stands alone."""
    if not names:
        return ""
    listed = ", ".join(names[:_NAMED])
    if len(names) > _NAMED:
        listed += f" and {len(names) - _NAMED} more"
    return f"; it is one of a family, with any value of {listed}"


def equilibrium_near(reference: Reference, start: np.ndarray, t: float) -> np.ndarray | None:
    """Return the position (nq,) without acceleration that Newton's method reaches, or None."""
    if not reference.mechanism.nv:
        return start
    try:
        if reference.closed is None:
            return _of_tree(reference, start, t)
        q = _on_loops(reference, reference.closed, start, t)
        return None if q is None or _is_driven(reference, q, t) else q
    except (MecaniqueError, np.linalg.LinAlgError):
        return None  # e.g. a spring of no length, or loops that cannot be closed on the way


def _is_driven(reference: Reference, q: Array, t: float) -> bool:
    """Return whether constraints that depend on time move what is at rest."""
    moving = np.append(reference.constraint_bias(q, None, t), reference.drift(q, None, t)[1])
    return bool(np.abs(moving).max() > ACCELERATES)


def _of_tree(reference: Reference, start: np.ndarray, t: float) -> np.ndarray | None:
    mechanism, nv = reference.mechanism, reference.mechanism.nv
    rates = Rates.of(mechanism)
    q = rates.normalize(np.array(start, dtype=float))

    def residual(many: np.ndarray) -> np.ndarray:
        still = np.zeros((len(many), nv))
        value: np.ndarray = reference.inverse_dynamics(many, still, still, t)
        return value

    value = residual(q[None])[0]
    for _ in range(STEPS):
        ahead = np.vstack([np.eye(nv), -np.eye(nv)]) * SLOPE_STEP
        rise = residual(rates.displace(np.repeat(q[None], 2 * nv, axis=0), ahead))
        slope = ((rise[:nv] - rise[nv:]) / (2 * SLOPE_STEP)).T
        size = _size(value)
        step = _step(slope, value, longest=1.0)
        for _ in range(HALVINGS):
            trial = rates.normalize(rates.displace(q, step))
            new = residual(trial[None])[0]
            if _size(new) <= size:
                break
            step = step / 2
        else:
            break
        q, value = trial, new
        if _size(step) < NEWTON_STEP:
            break
    gravity = np.linalg.norm(mechanism.evaluate_all(mechanism.gravity))
    scale = _size(reference.mass_matrix(q, t)) * float(gravity) + _size(slope)
    return q if _size(value) <= AT_REST * scale + NO_FORCE else None


def _on_loops(
    reference: Reference, closed: Closed, start: np.ndarray, t: float
) -> np.ndarray | None:
    """Do the same in the deviations that the loops leave free."""
    from mecanique.reference.loops.assembly import close_position
    from mecanique.reference.loops.independent import Independent

    rates = Rates.of(reference.mechanism)
    still = np.zeros(reference.mechanism.nv)
    q = close_position(closed, rates.normalize(np.array(start, dtype=float)), t)
    balanced, best, idle = False, np.inf, 0
    for _ in range(STEPS):
        free = Independent(closed, q, t)
        count = len(free.chosen)
        if not count:
            return q
        none = np.zeros(count)
        steps = np.vstack([none, np.eye(count) * SLOPE_STEP, np.eye(count) * -SLOPE_STEP])
        along = [effort(reference, free, free.position(step), none, none, t) for step in steps]
        value, ahead, behind = (
            along[0],
            np.array(along[1 : count + 1]),
            np.array(along[count + 1 :]),
        )
        slope = ((ahead - behind) / (2 * SLOPE_STEP)).T
        # row by row and by the masses that move, so that a small part counts beside a large one
        tangent = free.tangent
        weight = np.abs(reference.inverse_dynamics(q, still, still, t))
        least = (
            AT_REST_ON_LOOPS * (np.abs(slope).max(axis=1) + np.abs(tangent).T @ weight) + NO_FORCE
        )
        balanced = bool((np.abs(value) <= least).all())
        mass = np.diag(tangent.T @ reference.mass_matrix(q, t) @ tangent)
        unit = np.sqrt(np.where(mass > 0, mass, 1.0))
        left = _size(value / unit)
        best, idle = (left, 0) if left <= GAIN * best else (best, idle + 1)
        if idle > PATIENCE:
            break
        step = _step(slope / np.outer(unit, unit), value / unit, longest=np.inf) / unit
        step *= min(1.0, 0.5 / max(_size(step), TINY))
        if _size(step) < NEWTON_STEP_ON_LOOPS:
            break
        q = close_position(closed, rates.displace(q, tangent @ step), t)
    return q if balanced else None


def _step(slope: np.ndarray, value: np.ndarray, longest: float) -> np.ndarray:
    """Return Newton's step, shortened to the longest that is allowed."""
    step: np.ndarray = -np.linalg.lstsq(slope, value, rcond=FLAT_SLOPE)[0]
    return step * min(1.0, longest / max(_size(step), TINY))


def _size(values: np.ndarray) -> float:
    return float(np.abs(values).max(initial=0.0))
