"""Find the positions in which a mechanism can rest, by Newton's method from many starts."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, field
from functools import partial
from itertools import compress, product, repeat
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
from mecanique.motion.linear.free_motions import effort, free_near
from mecanique.motion.linear.held import HeldMode
from mecanique.motion.linear.linearization import Linearization
from mecanique.motion.record.rates import Rates
from mecanique.motion.simulation.problem import Values
from mecanique.motion.switching.corners import Corners
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


_REACH = 1.0
"""Lengths of random starts lie within this of zero [m]."""

MOST_STARTS = 1_000_000
"""Random starts that may be asked for: hours of work."""

STEPS = 100
"""Most Newton steps from a start."""

HALVINGS = 20
"""How often a step that does not help is halved."""

HOPELESS = 8
"""After so many starts in vain the search in a mode ends."""

MOST_STRUCK = 6
"""Stops and contacts whose modes are searched: 64 choices of what is closed."""

BETWEEN = 0.3
"""Part of the way between two positions of rest where another is looked for: no symmetry makes a
third one there."""

REACHED = 1e-4
"""How near such a position must be to there for rest to be everywhere between."""

NEXT = 1e-4
"""Part of a coordinate's span, beside a position, to where it may be changed if it may at all."""

LOOKS = 8
"""Places over the span at which an end of what friction holds is looked for."""

FAR = (10.0, 100.0)
"""Spans away from where it holds for good."""

SAME_RANGE = 1e-4
"""Narrowest range that is told: a narrower one is a position with the search's own error."""

SAME_END = 1e-10
"""Part of the span to which the ends of a range are bisected."""

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
        states: of each element that switches, by name.
        ranges: from where to where a coordinate alone may be changed, as friction holds it there.

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
    states: Mapping[str, str] = field(default_factory=dict)
    ranges: Mapping[str, tuple[float, float]] = field(default_factory=dict)

    @property
    def stable(self) -> bool:
        """Whether no small deviation grows exponentially."""
        return self.linearization.stable

    def __str__(self) -> str:
        first, *rest = str(self.linearization).splitlines()
        held = [f"; {element} {state}" for element, state in self.states.items()]
        held += [f"; {x} {_say_range(*ends)}" for x, ends in self.ranges.items()]
        return "\n".join(["".join([first, say_family(self.family), *held]), *rest])


def _say_range(low: float, high: float) -> str:
    start, end = (f"{round(end, 9) + 0.0:.6g}" for end in (low, high))
    if low == -np.inf:
        return f"up to {end}"
    return f"from {start} on" if high == np.inf else f"from {start} to {end}"


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

    Where elements switch, a position rests if the mode that follows there has no acceleration.
    Every mode is searched; small motions are those within it, so that what sticks goes on sticking.
    Of positions among which friction holds one is returned, with its `states` and `ranges`.

    Args:
        mechanism: what may rest.
        starts: positions to start from, or how many random ones besides the neutral position.
        t: time at which forces are taken [s].
        seed: of the random starts: angles in −π…π, lengths in −1…1 m.
        reference: the mechanism's `Reference`, if you have one already.

    Returns:
        One for each position found.

    Raises:
        InputError: if a start is not what is expected, the loops lock the mechanism in a singular
            position, or more than 6 elements may be closed.
        UnknownNameError: if a coordinate does not exist.
        ClosureError: if the loops cannot be closed at all.

    Example:
        >>> [each.stable for each in mq.equilibria(mq.textbook.load('rigid_bar_pendulum'))]
        [True, False]
    """
    t = finite(t, "the time t")
    if isinstance(starts, int):
        count = whole(starts, "the number of starts", 0, MOST_STARTS)
        positions = draw_starts(mechanism, count, seed)
    else:
        positions = [mechanism.position(start) for start in starts]
    if mechanism.switching:
        return _search_modes(mechanism, positions, t)
    if reference is None:
        from mecanique.reference import Reference

        reference = Reference.of(mechanism)
    if reference.closed is not None:
        from mecanique.reference.loops.freedom import refuse_locked

        refuse_locked(reference.closed, t)
    search = EquilibriumSearch(reference, positions, t)
    for start in positions:
        search.add(start)
    return search.sorted


def _search_modes(mechanism: Mechanism, starts: list[Array], t: float) -> tuple[Equilibrium, ...]:
    """Return the positions of rest of every mode, in the order of their potential energy."""
    corners = Corners(mechanism)
    struck = [element.name for element in corners.elements if element.struck]
    if len(struck) > MOST_STRUCK:
        raise InputError(
            f"{len(struck)} elements may be closed, more than {MOST_STRUCK}, which are too many "
            "for every mode to be searched; expected fewer"
        )
    rests, rubs = list[Equilibrium](), any(element.tangents for element in corners.elements)
    for flags in product((False, True), repeat=len(struck)):
        closed = frozenset(compress(struck, flags))
        search = EquilibriumSearch(HeldMode(corners, closed), starts, t)
        loose = HeldMode(corners, closed, sticks=False)
        for k, start in enumerate(starts):
            if k == HOPELESS and not search.equilibria:
                break
            # friction holds around where it has nothing to hold
            balanced = equilibrium_near(loose, start, t) if rubs else None
            for place in (start,) if balanced is None else (balanced, start):
                search.add(place)
        # what touches without force rests in two modes
        rests += [e for e in search.equilibria if not any(map(search.is_same, repeat(e), rests))]
    return tuple(sorted(rests, key=lambda rest: search.potential(rest.q)))


@final
class EquilibriumSearch:
    """The equilibria that starts, shape (nq,) each, have led to so far."""

    def __init__(
        self, reference: Reference | HeldMode, starts: Sequence[np.ndarray], t: float
    ) -> None:
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
        return tuple(sorted(self.equilibria, key=lambda e: self.potential(e.q)))

    def add(self, start: np.ndarray) -> None:
        """Add the equilibrium that a start leads to, if it leads to one that is not there yet."""
        q = equilibrium_near(self._reference, start, self._t)
        if q is None:
            return
        q = _unwind(self._reference, q, self._turning, self._t)
        if self._is_known(q):
            return
        if isinstance(self._reference, HeldMode) and not self._reference.keeps(q, self._t):
            return
        # where the axes of a gimbal fall in line the mass matrix has no inverse, and next to a
        # singular position the loops leave no small motion
        try:
            self._refuse_singular(q)
            linearization = linearize_about(self._reference, q, t=self._t)
            if isinstance(self._reference, HeldMode):
                self.equilibria += self._describe(q, linearization, self._reference)
                return
            idle = find_idle(self._reference, q, self._t)
        except (EngineError, InputError) as error:
            self.refused.append(error)
        else:
            family = find_family(self._reference, q, self._t, idle)
            self.equilibria.append(Equilibrium(q, linearization, family))
            self._idle.append(idle)

    def _describe(
        self, q: Array, linearization: Linearization, mode: HeldMode
    ) -> Iterator[Equilibrium]:
        """Yield a position of rest in a mode, with the ends between which friction holds."""
        states = mode.follows(q, self._t)
        if states is None:  # where it touches without force another mode may follow
            return
        family, ranges = list[str](), dict[str, tuple[float, float]]()
        for in_q, in_v in zip(*self._rates.plain, strict=True):
            name = mode.mechanism.coordinates.names[in_q]
            span = np.pi if in_q in self._turning else _REACH
            low, high = (_find_end(mode, q, (in_q, in_v), self._t, side * span) for side in (-1, 1))
            if np.isinf(low) and np.isinf(high):
                family.append(name)
            elif high - low > SAME_RANGE:
                ranges[name] = low, high
        yield Equilibrium(q, linearization, tuple(family), states, ranges)

    def _is_known(self, q: Array) -> bool:
        """Return whether a position of rest is among those there, or of a family of theirs."""
        if isinstance(self._reference, HeldMode):
            return any(self._are_kin(known.q, q, self._reference) for known in self.equilibria)
        curved = []
        for known, idle in zip(self.equilibria, self._idle, strict=True):
            gap = self._apart(known.q, q)
            if np.abs(gap - idle @ (idle.T @ gap)).max(initial=0.0) < SAME_PLACE:
                return True
            if idle.shape[1]:
                curved.append((known.q, idle))
        height = self.potential(q)
        return any(
            abs(self.potential(place) - height) <= SAME_FORCES * (1 + abs(height))
            and self._walks(place, idle, q)
            for place, idle in curved
        )

    def _are_kin(self, known: Array, q: Array, mode: HeldMode) -> bool:
        """Return whether two positions of rest are one, or rest is between them, too."""
        gap = self._apart(known, q)
        if np.abs(gap).max(initial=0.0) < SAME_PLACE:
            return True
        try:
            between = mode.close(self._rates.displace(known, BETWEEN * gap), self._t)
        except MecaniqueError:
            return False
        rest = equilibrium_near(mode, between, self._t)
        if rest is None or np.abs(self._apart(between, rest)).max() >= REACHED:
            return False
        return mode.keeps(rest, self._t)

    def is_same(self, one: Equilibrium, other: Equilibrium) -> bool:
        """Return whether two positions are one."""
        return bool(np.abs(self._apart(one.q, other.q)).max(initial=0.0) < SAME_PLACE)

    def potential(self, q: Array) -> float:
        """Return the potential energy at a position [J]."""
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
    reference: Reference | HeldMode, positions: Sequence[np.ndarray], t: float
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


def _unwind(reference: Reference | HeldMode, q: Array, turning: list[int], t: float) -> Array:
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


def _find_end(
    mode: HeldMode, q: Array, coordinate: tuple[int, int], t: float, span: float
) -> float:
    """Return to where a coordinate alone may be changed; infinite if it may by far."""
    in_q, in_v = coordinate

    def rests(x: float) -> bool:
        moved = q.copy()
        moved[in_q] = x
        try:
            closed = mode.close(moved, t, fixed=in_v)
        except MecaniqueError:
            return False
        rest = equilibrium_near(mode, closed, t)
        return rest is not None and abs(rest[in_q] - x) < SAME_PLACE and mode.keeps(rest, t)

    inside = float(q[in_q])
    for part in (NEXT, *np.arange(1, LOOKS + 1) / LOOKS, *FAR):
        outside = float(q[in_q]) + part * span
        if not rests(outside):
            break
        inside = outside
    else:
        return float(np.sign(span)) * np.inf
    if part == NEXT:
        return inside
    while abs(outside - inside) > SAME_END * abs(span):
        middle = (inside + outside) / 2
        inside, outside = (middle, outside) if rests(middle) else (inside, middle)
    return inside


def equilibrium_near(
    reference: Reference | HeldMode, start: np.ndarray, t: float
) -> np.ndarray | None:
    """Return the position (nq,) without acceleration that Newton's method reaches, or None."""
    if not reference.mechanism.nv:
        return start
    try:
        if isinstance(reference, HeldMode):
            return _on_loops(reference, partial(reference.close, t=t), start, t)
        if reference.closed is None:
            return _of_tree(reference, start, t)
        from mecanique.reference.loops.assembly import close_position

        q = _on_loops(reference, partial(close_position, reference.closed, t=t), start, t)
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
    reference: Reference | HeldMode, close: Callable[[Array], Array], start: Array, t: float
) -> np.ndarray | None:
    """Do the same in the deviations that the loops, or what is closed and sticks, leave free."""
    rates = Rates.of(reference.mechanism)
    still = np.zeros(reference.mechanism.nv)
    q = close(rates.normalize(np.array(start, dtype=float)))
    balanced, best, idle = False, np.inf, 0
    for _ in range(STEPS):
        free = free_near(reference, q, t)
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
        if isinstance(reference, HeldMode):
            slope = reference.drop_rounding(slope, tangent, q, t)
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
        q = close(rates.displace(q, tangent @ step))
    return q if balanced else None


def _step(slope: np.ndarray, value: np.ndarray, longest: float) -> np.ndarray:
    """Return Newton's step, shortened to the longest that is allowed."""
    step: np.ndarray = -np.linalg.lstsq(slope, value, rcond=FLAT_SLOPE)[0]
    return step * min(1.0, longest / max(_size(step), TINY))


def _size(values: np.ndarray) -> float:
    return float(np.abs(values).max(initial=0.0))
