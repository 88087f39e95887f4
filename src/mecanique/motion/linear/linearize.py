"""Linearize a mechanism about a state given, or about equilibria that Newton's method reaches."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, final

import numpy as np

from mecanique.arrays import Array
from mecanique.errors import EngineError, InputError, MecaniqueError
from mecanique.model.expression import finite
from mecanique.model.mechanism import Mechanism
from mecanique.model.mechanism_units import units
from mecanique.model.random_positions import draw_positions
from mecanique.model.values import whole
from mecanique.motion.linear.differences import find_idle, linearize_about, refuse_rolling
from mecanique.motion.linear.equilibrium import drop_disturbances, equilibrium_near
from mecanique.motion.linear.linearization import Linearization
from mecanique.motion.record.curve import State
from mecanique.motion.record.rates import Rates
from mecanique.motion.simulation.problem import Values
from mecanique.motion.tolerances import (
    IN_LINE,
    SAME_FORCES,
    SAME_PLACE,
    SMALL_ACCELERATION,
    TINY,
    TURN,
)
from mecanique.threads import one_thread_for_loops
from mecanique.wording import Legible, enumerate_words

if TYPE_CHECKING:
    from mecanique.reference import Reference


_REACH = 1.0
"""Lengths of random starts lie within this of zero [m]."""

MOST_STARTS = 1_000_000
"""Random starts that may be asked for: hours of work."""


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
        positions = _draw_starts(mechanism, count, seed)
    else:
        positions = [mechanism.position(start) for start in starts]
    search = _Equilibria(reference, positions, t)
    for start in positions:
        search.add(start)
    return search.sorted


@final
class _Equilibria:
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


def _draw_starts(mechanism: Mechanism, count: int, seed: int) -> list[np.ndarray]:
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

STEPS = (-1.7, -0.4, 0.6, 2.1)
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
            moved = [rates.displace(q, step * directions[k]) for step in STEPS]
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


STARTS = 20
"""Number of random starts of the search if no equilibrium is near the neutral position."""

HOPELESS = 8
"""After so many of them in vain the search ends."""


@one_thread_for_loops
def linearize(
    mechanism: Mechanism,
    at: Values | State | None = None,
    *,
    near: Values | None = None,
    v: Values | None = None,
    t: float = 0.0,
    reference: Reference | None = None,
) -> Linearization:
    """Linearize the equations of motion about a state.

    M a + bias − forces is differentiated by central differences of eighth order; `error` says how
    well that worked. About a state in motion the accelerations are held at the state's own. A
    mechanism with loops is linearized in independent deviations, about the state on the loops next
    to the one given.

    Without `at` an equilibrium is looked for by Newton's method from `near`, or from the neutral
    position; inputs that change with time are then zero. Where neither is given and the neutral
    position leads nowhere, 20 random positions follow: of the equilibria found a stable one is
    chosen if there is any, and of these the one with the least potential energy. `chosen` says
    which it is; `equilibria` gives them all.

    Args:
        mechanism: what moves.
        at: positions, shape (nq,) or by name, or a `State` with time and velocities; by default an
            equilibrium.
        near: where to start the search for the equilibrium, shape (nq,) or by name.
        v: velocities, shape (nv,) or by name; zero by default.
        t: time [s].
        reference: the mechanism's `Reference`, if you have one already.

    Returns:
        M, C and K with modes and frequencies.

    Raises:
        InputError: if the state is not what is expected, no equilibrium is found, or the loops lock
            the mechanism in a singular position.
        EngineError: if a motion moves no mass in the state given.
        UnknownNameError: if a coordinate or velocity does not exist.
        ClosureError: if the loops cannot be closed.

    Example:
        >>> small = mq.linearize(mq.textbook.load('rigid_bar_pendulum'))
        >>> [round(float(w), 3) for w in small.frequencies]
        [3.836]
    """
    t = finite(t, "the time t")
    refuse_rolling(mechanism)
    mechanism.refuse_switching("small motions are those of one mode, as long as it holds")
    described = mechanism
    if at is not None and near is not None:
        raise InputError("expected either at or near, got both")
    if at is None:
        mechanism = drop_disturbances(mechanism)
        reference = reference if mechanism is described else None
    if reference is None:
        from mecanique.reference import Reference

        reference = Reference.of(mechanism)
    if isinstance(at, State):
        t, v, at = float(at.t), at.v, at.q
    if at is not None:
        return linearize_about(reference, at, v, t, described=described)
    if reference.closed is not None:
        from mecanique.reference.loops.freedom import refuse_locked

        refuse_locked(reference.closed, t)
    q = equilibrium_near(reference, mechanism.position(near), t)
    place = "the neutral position" if near is None else "the start given"
    if q is None and near is not None:
        raise InputError(_no_equilibrium(mechanism, place))
    if q is not None:
        chosen = f"the equilibrium that Newton's method reaches from {place}"
        try:
            chosen += say_family(find_family(reference, q, t, find_idle(reference, q, t)))
            return linearize_about(reference, q, v, t, described=described, chosen=chosen)
        except (EngineError, InputError):
            # e.g. where the axes of a gimbal fall in line; there may be another
            if near is not None:
                raise
    best = _search(reference, t, described)
    if v is None:
        return best
    return linearize_about(reference, best.q, v, t, described=described, chosen=best.chosen)


def _search(reference: Reference, t: float, described: Mechanism) -> Linearization:
    """Linearize about the best of the equilibria found from random starts."""
    mechanism = reference.mechanism
    first, *starts = _draw_starts(mechanism, STARTS, 0)
    search = _Equilibria(reference, [first, *starts], t)
    for k, start in enumerate(starts):
        if k == HOPELESS and not (search.equilibria or search.refused):
            break
        search.add(start)
    if not search.equilibria:
        if search.refused:
            raise InputError(
                f"the equilibria found of {mechanism.name!r} cannot be linearized about: "
                f"{search.refused[-1]}; choose other coordinates, or give a state: "
                "linearize(mechanism, at={...})"
            )
        raise InputError(_no_equilibrium(mechanism, "the neutral position or random ones"))
    best = min(search.sorted, key=lambda equilibrium: not equilibrium.stable)
    count = len(search.equilibria)
    if count == 1:
        chosen = f"the only equilibrium that {STARTS} random starts lead to"
    else:
        kind = "the stable one" if best.stable else "of which none is stable, the one"
        chosen = f"of {count} equilibria that {STARTS} random starts lead to, {kind} with the least"
        chosen += " potential energy"
    chosen += say_family(best.family)
    return replace(best.linearization, mechanism=described, chosen=chosen)


def _no_equilibrium(mechanism: Mechanism, start: str) -> str:
    return (
        f"no equilibrium of {mechanism.name!r} was found from {start}; if it has one, say where: "
        "linearize(mechanism, near={...}), or --at on the command line; a motion or a fall that "
        "nothing balances has none, but can be linearized about any state: "
        "linearize(mechanism, at={...})"
    )
