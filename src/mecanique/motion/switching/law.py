"""Which modes of elements that switch follow in a state (complementarity), and impacts.

A mode follows if what it presupposes is so: normal forces press, what sticks needs no more than
static friction, what opens parts, and what begins to slip does so against its friction (Pfeiffer &
Glocker, Multibody Dynamics with Unilateral Contacts, 1996, ch. 4–6). All modes are tried, so that
solutions are counted: Coulomb's law with rigid bodies may have none, or several (Painlevé, 1895).
The velocities after an impact follow from its impulses by the same conditions.
"""

from __future__ import annotations

from collections.abc import Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from itertools import product
from math import acos, atan2, hypot, prod
from typing import final

import numpy as np

from mecanique.arrays import Array, rank_of
from mecanique.derivation.mechanics.switching import (
    BACKWARD,
    CLOSED,
    FORWARD,
    OPEN,
    SLIPS,
    STICKS,
    ElementRows,
    ElementState,
    Mode,
    ModeProblem,
    Terms,
    accelerate,
    bounce,
    friction_limit,
    hold,
    keep_inside,
    list_margins,
    name_mode,
    solve_held,
    strike,
)
from mecanique.derivation.tolerances import (
    ANGLES,
    DIRECTION_STEPS,
    PROJECTIONS,
    REDUNDANT,
    SAME_ANSWER,
    SAME_DIRECTION,
    SAME_WAY,
    SLACK,
    SMALL_TURN,
    SPENT,
    TURNED,
)
from mecanique.errors import InputError
from mecanique.motion.tolerances import TINY

MOST_MODES = 4096
"""So many modes at most are tried at once."""

_TURN = np.linspace(0.0, 2.0 * np.pi, 64, endpoint=False)

_DIRECTIONS = {
    1: np.array([[1.0], [-1.0]]),
    2: np.column_stack([np.cos(_TURN), np.sin(_TURN)]),
}
"""Directions along which friction is bounded, by the number of tangents."""

_UNDIRECTED = (CLOSED, STICKS, SLIPS)
"""States without a direction of slip, or one that is sought."""

MOST_IMPACTS = 10_000
"""Impacts that may follow each other in turn at one instant."""


class UndecidedError(InputError):
    """No mode follows, or several do; `count` says how many."""

    def __init__(self, message: str, count: int) -> None:
        super().__init__(message)
        self.count = count

    def __reduce__(self) -> tuple[type[UndecidedError], tuple[str, int]]:
        return type(self), (str(self), self.count)


@final
@dataclass(frozen=True, eq=False)
class ModeSolution:
    """Accelerations and forces in a mode, or changes of velocities and impulses at an impact."""

    mode: Mode
    a: Array  # shape (nv,)
    forces: Array  # shape (m,), the force along each row
    # how the forces of redundant rows can be shared, along all rows: shape (m, shares)
    spread: Array = field(default_factory=lambda: np.zeros((0, 0)))

    @property
    def redundant(self) -> bool:
        """Whether the forces of the rows held are not determined."""
        return bool(self.spread.shape[1])


def solve(
    terms: Terms,
    elements: Sequence[ElementRows],
    mode: Mode,
    drive: ModeProblem,
    permanent: Sequence[int] = (),
) -> ModeSolution | None:
    """Return accelerations and forces in a mode; None if its equations have no solution."""
    held = hold(terms, elements, mode, drive, permanent)
    null: Array = np.zeros((len(held.rows), 0))

    def by_mass(columns: Array) -> Array:
        return np.asarray(np.linalg.solve(terms.mass, columns))

    def by_rows(J: Array, yielding: Array, free: Array, wanted: Array) -> Array | None:
        nonlocal null
        system, right = J @ yielding, wanted - free
        if len(J) == 1:
            size = np.abs(J[0]) @ np.abs(yielding[:, 0])
            known = abs(system[0, 0]) > REDUNDANT * size
            return right / system[0, 0] if known else None
        # rows in the metric of kinetic energy, so that singular values are comparable
        scale = np.sqrt(np.einsum("ij,ji->i", J, by_mass(J.T)))
        scale[scale == 0] = 1.0
        left, sizes, right_vectors = np.linalg.svd(system / np.outer(scale, scale))
        rank = rank_of(sizes, REDUNDANT)
        part = left[:, :rank].T @ (right / scale) / sizes[:rank]
        forces: Array = right_vectors[:rank].T @ part / scale
        if rank < len(J):
            null = right_vectors[rank:].T / scale[:, None]
            missed = np.abs(system @ forces - right).max()
            if missed > SLACK * (np.abs(wanted).max() + np.abs(free).max()):
                return None
        return forces

    solved = solve_held(terms, held, drive, by_mass, by_rows)
    if solved is None:
        return None
    return ModeSolution(mode, *solved, held.friction.T @ null)


def is_slow(terms: Terms, element: ElementRows, speed: float) -> bool:
    """Return whether an element slips no faster than a speed [m/s]."""
    return bool(np.linalg.norm(terms.rates[list(element.tangents)]) <= speed)


def find_gains(
    terms: Terms, a: Array, drive: ModeProblem, still: float = 0.0
) -> tuple[Array, Array]:
    """Return what the rate of each row gains by, and below what that is rounding, shape (m,)."""
    J, free = terms.jacobian, np.linalg.solve(terms.mass, drive.load)
    # sizes of what is added up in each row: differences below a part of them are rounding
    size = np.abs(J) @ (np.abs(a) + np.abs(free)) + np.abs(drive.wanted) + still
    return J @ a - drive.wanted, SLACK * size


@final
class Laws:
    """The laws of a mechanism's elements."""

    def __init__(self, elements: Sequence[ElementRows], permanent: Sequence[int]) -> None:
        self.elements = tuple(elements)
        self.permanent = tuple(permanent)

    def solve(self, terms: Terms, mode: Mode, rounding: float = 0.0) -> ModeSolution | None:
        """Return accelerations and forces in a mode, with the direction of slip of the state."""
        drive, mode = accelerate(terms, self.elements), self.along_slip(terms, mode, rounding)
        if any(state.beginning for state in mode):
            return self._begin_slips(terms, mode, drive)
        return solve(terms, self.elements, mode, drive, self.permanent)

    def along_slip(self, terms: Terms, mode: Mode, rounding: float = 0.0) -> Mode:
        """Return the mode with the directions of slip in space that the state has."""
        if not any(state.name == SLIPS for state in mode):
            return mode
        states = []
        for element, state in zip(self.elements, mode, strict=True):
            if state.name == SLIPS and not state.beginning:
                slip = terms.rates[list(element.tangents)]
                size = float(np.linalg.norm(slip))
                # past its end, or as rounding, slip points anywhere: the mode's direction is kept
                if size > rounding and slip @ np.array(state.direction) > SAME_WAY * size:
                    state = replace(state, direction=tuple((slip / size).tolist()))
            states.append(state)
        return tuple(states)

    def margins(self, terms: Terms, mode: Mode, solution: ModeSolution | None) -> Array:
        """Return what each element has left in its state, shape (elements, 2), `list_margins`.

        Elements that bear redundant forces together have one margin, that of the best share: what
        sticks does so while a share exists.
        """
        forces = None if solution is None else solution.forces
        limits = terms.static, [element.holds for element in self.elements]
        moved = terms.gaps, terms.rates
        margins = np.array(list_margins(self.elements, mode, moved, forces, limits, hypot))
        for k, (element, state) in enumerate(zip(self.elements, mode, strict=True)):
            if state.name == SLIPS and not state.beginning:  # it ends, or has turned
                margins[k, 1] -= TURNED * np.linalg.norm(terms.rates[list(element.tangents)])
        if solution is not None and solution.redundant:
            spare = self._find_spare(terms, solution, accelerate(terms, self.elements))
            for k, (element, state) in enumerate(zip(self.elements, mode, strict=True)):
                if state.name == STICKS:
                    margins[k] = 1.0, spare
                elif element.struck and state.name != OPEN:
                    margins[k, 0] = spare
        return np.array(keep_inside(terms, self.elements, mode, margins.tolist(), hypot))

    # which mode follows -------------------------------------------------------------------------

    def follow(
        self,
        terms: Terms,
        touching: Sequence[bool],
        still: float,
        forbidden: frozenset[tuple[int, str]] = frozenset(),
        ended: frozenset[Mode] = frozenset(),
        error: float = 0.0,
    ) -> list[ModeSolution]:
        """Return every mode that may follow in a state, by distinct accelerations.

        Speeds are known but for an error [m/s].
        """
        choices, near, beginning = [], set[int](), dict[int, float]()
        for k, element in enumerate(self.elements):
            states = self.candidates(terms, element, touching[k], still)
            choices.append([s for s in states if (k, s.name) not in forbidden])
            if touching[k] and element.struck and terms.rates[element.normal] <= still:
                near.add(k)
            if is_slow(terms, element, still):
                # what has just spent its friction has done so to the rounding of the corner's time
                beginning[k] = SPENT if (k, STICKS) in forbidden else 1.0
        drive = accelerate(terms, self.elements)
        solutions = self._solve_all(terms, choices, drive, near, beginning, 0.0, ended, error)
        solutions = _prefer_sticking(self, terms, solutions)
        # of shares of the same forces among contacts the one in which all press that can
        rubbing = [row for e in self.elements if e.normal is None for row in e.rows]
        sharing = [
            s
            for s in solutions
            if s.redundant
            and not np.abs(s.spread[rubbing]).max(initial=0.0) > REDUNDANT * np.abs(s.spread).max()
            and self._find_spare(terms, s, drive) > 0
        ]
        sharing.sort(key=lambda solution: sum(state.name == OPEN for state in solution.mode))
        return _distinct([*sharing, *solutions], terms)

    def _solve_all(
        self,
        terms: Terms,
        choices: Sequence[Sequence[ElementState]],
        drive: ModeProblem,
        near: Collection[int],
        beginning: Mapping[int, float],
        still: float,
        ended: Collection[Mode] = (),
        error: float = 0.0,
    ) -> list[ModeSolution]:
        """Return the solutions of all modes whose conditions are met.

        Slip that begins grows but for rounding, times a number by element.
        """
        self._refuse_many(choices)
        solutions, together = list[ModeSolution](), list[tuple[Mode, list[int]]]()

        def add(mode: Mode, begin: list[int]) -> None:
            solutions.extend(
                solution
                for solution in self._in_space(terms, mode, drive, begin)
                if self._is_sound(terms, solution, drive, near, beginning, still, error)
            )

        for mode in product(*choices):
            begin = [
                k for k, state in enumerate(mode) if state.name == SLIPS and not state.direction
            ]
            if mode in ended:
                continue
            if len(begin) > 1:
                together.append((mode, begin))
            else:
                add(mode, begin)
        if together and not solutions:
            for mode, begin in together:
                add(mode, begin)
        if together and not solutions:
            names = ", ".join(repr(self.elements[k].name) for k in together[-1][1])
            raise InputError(
                f"contacts {names} may begin to slip in space at once, in directions that depend "
                "on each other and were not found; expected motion in a plane, or no friction in "
                "all but one"
            )
        return solutions

    def candidates(
        self, terms: Terms, element: ElementRows, touches: bool, still: float
    ) -> list[ElementState]:
        """Return the states in which an element may go on, open first, by its gap and its slip."""
        normal = element.normal
        states: list[ElementState] = []
        if normal is not None:
            if element.stiffness is not None:
                inside = touches and (terms.gaps[normal] < 0 or terms.rates[normal] < 0)
                return [ElementState(CLOSED if inside else OPEN)]
            if not touches or terms.rates[normal] > still:
                return [ElementState(OPEN)]
            states.append(ElementState(OPEN))
            if not element.tangents:
                return [*states, ElementState(CLOSED)]
        slip = terms.rates[list(element.tangents)]
        speed = float(np.linalg.norm(slip))
        if speed > still:
            direction = tuple((slip / speed).tolist())
            name = FORWARD if slip[0] > 0 else BACKWARD
            if len(direction) > 1:
                name = SLIPS
            return [*states, ElementState(name, direction)]
        states.append(ElementState(STICKS))
        if len(element.tangents) > 1:
            return [*states, ElementState(SLIPS)]
        return [*states, ElementState(FORWARD, (1.0,)), ElementState(BACKWARD, (-1.0,))]

    def _refuse_many(self, choices: Sequence[Sequence[ElementState]]) -> None:
        count = prod(len(states) for states in choices)
        if count > MOST_MODES:
            raise InputError(
                f"{count} modes may follow here, more than {MOST_MODES}, which are too many to be "
                "counted one by one; expected fewer elements that switch at once"
            )

    def _in_space(
        self, terms: Terms, mode: Mode, drive: ModeProblem, begin: Sequence[int]
    ) -> Iterator[ModeSolution]:
        """Yield the solutions of a mode, for each direction in which contacts begin to slip."""
        if not begin:
            solution = solve(terms, self.elements, mode, drive, self.permanent)
            if solution is not None:
                yield solution
            return
        around = np.linspace(-np.pi, np.pi, ANGLES + 1) + 0.01
        if len(begin) == 1:
            yield from self._begin_slip(terms, mode, drive, begin[0], around)
            return
        start = self._find_start(terms, mode, drive, begin)
        solution = None if start is None else self._begin_slips(terms, start, drive)
        if solution is not None:
            yield solution

    def _find_start(
        self, terms: Terms, mode: Mode, drive: ModeProblem, begin: Sequence[int]
    ) -> Mode | None:
        """Return a mode with directions near those in which several contacts begin to slip.

        Friction takes away as much of the growth of slip as what presses allows: a fixed point of
        projections on disks (Jean, Comput. Methods Appl. Mech. Eng. 177, 1999, 235).
        """
        smooth = ElementState(SLIPS, (0.0, 0.0))
        free = tuple(smooth if k in begin else state for k, state in enumerate(mode))
        tangents = np.array([self.elements[k].tangents for k in begin]).ravel()

        def respond(load: Array) -> Array:
            pushed = drive._replace(load=load)
            solution = solve(terms, self.elements, free, pushed, self.permanent)
            if solution is None:
                return np.full(len(tangents) + len(begin), np.nan)
            gained, _ = find_gains(terms, solution.a, pushed)
            limits = [
                friction_limit(self.elements[k], terms.kinetic[k], solution.forces) for k in begin
            ]
            return np.concatenate([gained[tangents], limits])

        base = respond(drive.load)
        slopes = np.array([respond(drive.load + terms.jacobian[r]) - base for r in tangents]).T
        if not np.isfinite(slopes).all():
            return None
        # no longer than the inverse of the largest eigenvalue, up to which projections contract
        step = 1.0 / (np.linalg.norm(slopes[: len(tangents)]) + TINY)
        rub = np.zeros((len(begin), 2))
        for _ in range(PROJECTIONS):
            growth, limits = np.split(base + slopes @ rub.ravel(), [len(tangents)])
            rub = rub - step * growth.reshape(-1, 2)
            sizes = np.linalg.norm(rub, axis=1) + TINY
            rub *= np.minimum(1.0, np.maximum(limits, 0.0) / sizes)[:, None]
        states = list(mode)
        for k, slip in zip(begin, -rub, strict=True):
            states[k] = ElementState(SLIPS, tuple(slip.tolist()), True)
        return tuple(states)

    def _begin_slips(self, terms: Terms, mode: Mode, drive: ModeProblem) -> ModeSolution | None:
        """Return the solution next to a mode in which slip that begins goes along its growth."""
        begin = [k for k, state in enumerate(mode) if state.beginning]
        angles = np.array([atan2(*mode[k].direction[::-1]) for k in begin])
        turns = SMALL_TURN * np.eye(len(begin))
        for _ in range(DIRECTION_STEPS):
            solution, missed = self._head(terms, mode, drive, begin, angles)
            if solution is None:
                return None
            scale = float(find_gains(terms, solution.a, drive)[1].max()) / SLACK
            columns = [self._head(terms, mode, drive, begin, angles + turn)[1] for turn in turns]
            slopes = (np.array(columns) - missed).T / SMALL_TURN
            if not np.isfinite(slopes).all():
                return None
            # where friction alone acts, directions may turn together: what slopes are left of that
            # are rounding of differences
            left, sizes, right = np.linalg.svd(slopes)
            rank = int((sizes > SMALL_TURN * scale).sum())
            turned = right[:rank].T @ (left[:, :rank].T @ missed / sizes[:rank])
            largest = np.abs(turned).max()
            if largest <= SAME_DIRECTION:
                return solution
            angles = angles - turned * min(1.0, acos(SAME_WAY) / largest)
        return None

    def _begin_slip(
        self, terms: Terms, mode: Mode, drive: ModeProblem, k: int, angles: Array
    ) -> Iterator[ModeSolution]:
        """Yield the solutions in which a contact slips as slip grows, between two of the angles."""
        from scipy.optimize import brentq

        def across(angle: float) -> float:
            return float(self._head(terms, mode, drive, [k], np.array([angle]))[1][0])

        values = [across(angle) for angle in angles]
        for low, high, a, b in zip(angles, angles[1:], values, values[1:], strict=False):
            if a * b <= 0 and a != b:
                try:
                    angle = np.array([brentq(across, low, high, xtol=1e-15, rtol=1e-15)])
                except ValueError:  # the mode has no solution at an angle in between
                    continue
                solution, _ = self._head(terms, mode, drive, [k], angle)
                if solution is not None:
                    yield solution

    def _head(
        self, terms: Terms, mode: Mode, drive: ModeProblem, begin: Sequence[int], angles: Array
    ) -> tuple[ModeSolution | None, Array]:
        """Return the solution with slip along angles, and the growth across; shape (contacts,)."""
        states, ways = list(mode), np.column_stack([np.cos(angles), np.sin(angles)])
        for k, way in zip(begin, ways.tolist(), strict=True):
            states[k] = ElementState(SLIPS, tuple(way), True)
        solution = solve(terms, self.elements, tuple(states), drive, self.permanent)
        if solution is None:
            return None, np.full(len(begin), np.nan)
        tangents = np.array([self.elements[k].tangents for k in begin])
        x, y = (terms.jacobian @ solution.a - drive.wanted)[tangents].T
        return solution, ways[:, 0] * y - ways[:, 1] * x

    def _is_sound(
        self,
        terms: Terms,
        solution: ModeSolution,
        drive: ModeProblem,
        near: Collection[int],
        beginning: Mapping[int, float],
        still: float,
        error: float,
    ) -> bool:
        """Return whether what a mode presupposes is so."""
        forces = solution.forces
        gained, rounding = find_gains(terms, solution.a, drive, still)
        pull = float(np.abs(forces).max(initial=0.0)) + _typical_force(terms, drive)
        if solution.redundant and (
            self.shares_decide(terms, solution, error)
            or self._find_spare(terms, solution, drive) < -SLACK * pull
        ):
            return False
        limits = drive.sticking, drive.holds
        left = list_margins(self.elements, solution.mode, (gained, gained), forces, limits, hypot)
        for k, (element, state) in enumerate(zip(self.elements, solution.mode, strict=True)):
            (apart, rubs), normal = left[k], element.normal
            if element.stiffness is not None:
                continue
            if normal is not None and state.name == OPEN:
                if k in near and apart < -rounding[normal]:
                    return False
                continue
            least = -float(rounding[list(element.tangents)].max(initial=0.0))
            if state.direction and rubs < least * beginning.get(k, np.inf):
                return False
            if solution.redundant:
                continue  # its forces are among those that are shared
            if normal is not None and apart < -SLACK * pull:
                return False
            if state.name == STICKS and rubs < -SLACK * pull:
                return False
        return True

    def shares_decide(self, terms: Terms, solution: ModeSolution, error: float = 0.0) -> bool:
        """Return whether accelerations depend on how redundant forces are shared.

        They do where contacts share what presses and slip in different directions, each known but
        for an error of its speed [m/s].
        """
        ways = np.linalg.solve(terms.mass, terms.jacobian.T)
        most = (np.abs(ways) @ np.abs(solution.spread)).max(initial=0.0)
        moved = np.abs(ways @ solution.spread).max(initial=0.0) / (most + TINY)
        pairs = zip(self.elements, solution.mode, strict=True)
        slips = [
            np.linalg.norm(terms.rates[list(element.tangents)])
            for element, state in pairs
            if state.name == SLIPS and not state.beginning
        ]
        return bool(moved > SLACK + error / (min(slips, default=1.0) + TINY))

    def _find_spare(self, terms: Terms, solution: ModeSolution, drive: ModeProblem) -> float:
        """Return the least reserve of normal forces and static friction under the best share.

        The share of redundant forces that leaves most is found by a linear program; in space the
        cone of friction is a pyramid of 64 sides about it, wider by a thousandth at most.
        """
        from scipy.optimize import linprog

        spread = solution.spread
        rows, bounds = list[Array](), list[float]()
        for k, (element, state) in enumerate(zip(self.elements, solution.mode, strict=True)):
            normal = element.normal
            if state.name == OPEN or element.stiffness is not None:
                continue
            if normal is not None:
                rows.append(-spread[normal])
                bounds.append(float(solution.forces[normal]) + drive.holds[k])
            if state.name != STICKS:
                continue
            limit, tangents, pressing = drive.sticking[k], list(element.tangents), element.pressing
            by_normal = 0.0 if pressing is None else limit * spread[pressing]
            most = float(friction_limit(element, limit, solution.forces))
            for direction in _DIRECTIONS[len(tangents)]:
                rows.append(direction @ spread[tangents] - by_normal)
                bounds.append(most - float(direction @ solution.forces[tangents]))
        if not rows:
            return 1.0
        # the last unknown is the reserve; forces are of order one
        scale = max(float(np.abs(bounds).max()), TINY)
        shares = spread.shape[1]
        matrix = np.column_stack([np.array(rows), np.ones(len(rows))])
        answer = linprog(
            np.append(np.zeros(shares), -1.0),
            matrix,
            np.array(bounds) / scale,
            bounds=[*[(None, None)] * shares, (None, 10.0)],
        )
        if answer.status != 0 or answer.x is None:
            return -scale
        return float(answer.x[-1]) * scale

    # impacts ------------------------------------------------------------------------------------

    def impact(
        self, terms: Terms, touching: Sequence[bool], still: float
    ) -> tuple[Array, frozenset[int]]:
        """Return the change of velocities by an impact of the contacts that touch, and who pushes.

        Raises:
            UndecidedError: if no velocities follow, or several.
        """
        struck = zip(self.elements, touching, strict=True)
        contacts = [k for k, (element, near) in enumerate(struck) if near and element.struck]
        if any(self.elements[k].in_turn for k in contacts):
            change, impulses = self._in_turn(terms, contacts, still)
        else:
            change, impulses = self._together(terms, contacts, still)
        normals = terms.jacobian[[self.elements[k].rows[0] for k in contacts]]
        yields = (normals * np.linalg.solve(terms.mass, normals.T).T).sum(axis=1)
        pushed = (impulses[self.elements[k].rows[0]] for k in contacts)
        pairs = zip(contacts, yields, pushed, strict=True)
        return change, frozenset(k for k, by, impulse in pairs if by * impulse > still)

    def end_bounces(self, terms: Terms, mode: Mode, smooth: Array) -> Array:
        """Return what velocities change by as bounces end in a mode, which takes its rates away.

        All bounces left out press as much as what rests meanwhile, less the impulse that ends them
        now: that takes its friction along. Without friction the change is `smooth`.
        """
        states = []
        for element, state in zip(self.elements, mode, strict=True):
            # what rubs by a stated load has no impulse, nor has what is elastic
            free = (state.direction and element.pressing is None) or element.stiffness is not None
            states.append(ElementState(OPEN) if free else state)
        drive = strike(terms, {}, self.elements)
        ended = solve(terms, self.elements, tuple(states), drive, self.permanent)
        return smooth if ended is None else ended.a

    def _in_turn(self, terms: Terms, contacts: list[int], still: float) -> tuple[Array, Array]:
        change, impulses = np.zeros(len(terms.load)), np.zeros(len(terms.gaps))
        for _ in range(MOST_IMPACTS):
            rates = {k: terms.rates[self.elements[k].rows[0]] for k in contacts}
            fastest = min(rates, key=lambda k: rates[k])
            if rates[fastest] >= -still:
                return change, impulses
            step, push = self._together(terms, [fastest], still)
            change, impulses = change + step, impulses + push
            terms = terms._replace(rates=terms.rates + terms.jacobian @ step)
        raise UndecidedError(
            f"impacts in turn do not end after {MOST_IMPACTS}; let them be together", 0
        )

    def _together(self, terms: Terms, contacts: list[int], still: float) -> tuple[Array, Array]:
        if len(contacts) == 1 and len(self.elements[contacts[0]].tangents) < 2:
            return self._alone(terms, self.elements[contacts[0]])
        laws = {self.elements[k].by_impulse for k in contacts}
        if len(laws) > 1:
            raise InputError(
                "contacts that impact together have Newton's and Poisson's laws of restitution; "
                "expected one of them"
            )
        normals = {k: self.elements[k].rows[0] for k in contacts}
        if laws == {True}:
            return self._by_poisson(terms, normals, still)
        targets = {
            row: -self.elements[k].restitution * min(terms.rates[row], 0.0)
            for k, row in normals.items()
        }
        struck = self._strike(terms, contacts, strike(terms, targets, self.elements), still)
        return struck.a, struck.forces

    def _alone(self, terms: Terms, element: ElementRows) -> tuple[Array, Array]:
        """Return changes of velocities and impulses of one contact in a plane."""

        def push(terms: Terms, state: str, drive: ModeProblem) -> tuple[Array, Array]:
            mode = name_mode(self.elements, {element.name: state})
            solution = solve(terms, self.elements, mode, drive, self.permanent)
            assert solution is not None, "its normal impulse is given"
            return solution.a, solution.forces

        change, impulses = bounce(terms, self.elements, (element.name, ""), push)
        before, e = terms.rates[element.normal], element.restitution
        after = before + terms.jacobian[element.normal] @ change
        if not element.by_impulse and after < (SAME_ANSWER - e) * before:
            message = _say_count(0, "velocities", f"after the impact of {element.name}")
            raise UndecidedError(f"{message}: friction jams it", 0)
        return change, impulses

    def _by_poisson(
        self, terms: Terms, normals: dict[int, int], still: float
    ) -> tuple[Array, Array]:
        """Compression until no contact approaches, then e times its normal impulses."""
        pressed = self._strike(terms, normals, strike(terms, {}, self.elements), still)
        after = terms._replace(rates=terms.rates + terms.jacobian @ pressed.a)
        given = {
            row: self.elements[k].restitution * pressed.forces[row] for k, row in normals.items()
        }
        drive = strike(after, {}, self.elements, given)
        parted = self._strike(after, normals, drive, still)
        change = pressed.a + parted.a
        size = np.abs(terms.jacobian) @ np.abs(change) + np.abs(terms.rates) + still
        rates = terms.rates + terms.jacobian @ change
        for k, normal in normals.items():
            # friction in expansion may press a contact together again, which this law leaves open
            if rates[normal] < -SLACK * size[normal]:
                raise UndecidedError(
                    f"after Poisson's expansion the bodies at {self.elements[k].name!r} still "
                    "approach each other; use Newton's law of restitution",
                    0,
                )
        return change, pressed.forces + parted.forces

    def _strike(
        self, terms: Terms, contacts: Collection[int], drive: ModeProblem, still: float
    ) -> ModeSolution:
        """Return the only change of velocities that meets all conditions, with the impulses."""
        choices: list[list[ElementState]] = []
        for k, element in enumerate(self.elements):
            # what only rubs has no impulse, nor has what does not touch
            states = [ElementState(OPEN)]
            if k in contacts:
                closed = [ElementState(name) for name in element.states[1:] if name in _UNDIRECTED]
                states = closed if element.normal in drive.given else states + closed
                if len(element.tangents) == 1:
                    states += [ElementState(FORWARD, (1.0,)), ElementState(BACKWARD, (-1.0,))]
            choices.append(states)
        every = dict.fromkeys(contacts, 1.0)
        solutions = self._solve_all(terms, choices, drive, contacts, every, still)
        solutions = _distinct(solutions, terms, still)
        if len(solutions) != 1:
            names = ", ".join(self.elements[k].name for k in contacts)
            message = _say_count(len(solutions), "velocities", f"after the impact of {names}")
            raise UndecidedError(message, len(solutions))
        return solutions[0]


def _typical_force(terms: Terms, drive: ModeProblem) -> float:
    """A size of the forces along rows, for rounding."""
    lengths = np.abs(terms.jacobian).max(axis=1, initial=0.0)
    longest = float(lengths.max(initial=0.0))
    return float(np.abs(drive.load).max(initial=0.0)) / longest if longest else 0.0


def _distinct(
    solutions: Sequence[ModeSolution], terms: Terms, still: float = 0.0
) -> list[ModeSolution]:
    """The solutions of different accelerations or velocities."""
    free = np.abs(np.linalg.solve(terms.mass, terms.load))
    kept: list[ModeSolution] = []
    for solution in solutions:
        for old in kept:
            size = np.maximum(np.abs(solution.a), np.abs(old.a)).max() + free.max(initial=0.0)
            if np.abs(solution.a - old.a).max(initial=0.0) <= SAME_ANSWER * size + still:
                break
        else:
            kept.append(solution)
    return kept


def _prefer_sticking(laws: Laws, terms: Terms, solutions: list[ModeSolution]) -> list[ModeSolution]:
    """Leave out what ends where it need not: what can stick sticks, and latches keep closed."""
    kept = []
    for solution in solutions:
        yields_to = False
        for rival in solutions:
            differ = [
                k
                for k, (a, b) in enumerate(zip(solution.mode, rival.mode, strict=True))
                if a.name != b.name
            ]
            held = [
                k
                for k in differ
                if (
                    rival.mode[k].name == STICKS
                    and solution.mode[k].direction
                    and terms.static[k] > terms.kinetic[k]
                )
                or (rival.mode[k].name == CLOSED and laws.elements[k].holds > 0)
            ]
            yields_to |= bool(differ) and held == differ
        if not yields_to:
            kept.append(solution)
    return kept


def _say_count(count: int, what: str, where: str) -> str:
    number = "no" if count == 0 else str(count)
    return f"{number} {what} follow {where}, where one is expected"
