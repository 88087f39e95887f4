"""Modes of elements that switch: the law in each, which of them follow, and impacts.

In a mode M a = load + Σ w λ with J a + γ = 0 in the rows it holds: w is Jᵀ of the row, and of the
normal of a contact that slips J_nᵀ − μ Σ d J_tᵀ, d being the direction of slip. A mode follows if
what it presupposes is so: normal forces press, what sticks needs no more than static friction, what
opens parts, and what begins to slip does so against its friction (Pfeiffer & Glocker, Multibody
Dynamics with Unilateral Contacts, 1996, ch. 4–6). All modes are tried, so that solutions are
counted: Coulomb's law with rigid bodies may have none, or several (Painlevé, 1895).
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field, replace
from itertools import product
from math import hypot, prod
from typing import Any, NamedTuple, final

import numpy as np

from mecanique.arrays import Array
from mecanique.errors import InputError
from mecanique.motion.switching.rows import ElementRows, Terms
from mecanique.motion.tolerances import REDUNDANT, SAME_ANSWER, SLACK, TINY

OPEN, CLOSED, STICKS = "open", "closed", "sticks"
FORWARD, BACKWARD, SLIPS = "slips +", "slips -", "slips"

MOST_MODES = 4096
"""So many modes at most are tried at once."""


ANGLES = 72
"""Directions in which a root of the direction of slip is looked for."""

_TURN = np.linspace(0.0, 2.0 * np.pi, 64, endpoint=False)

_DIRECTIONS = {
    1: np.array([[1.0], [-1.0]]),
    2: np.column_stack([np.cos(_TURN), np.sin(_TURN)]),
}
"""Directions along which friction is bounded, by the number of tangents."""

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
@dataclass(frozen=True)
class ElementState:
    """The state of one element."""

    name: str  # one of those above
    direction: tuple[float, ...] = ()  # of slip along its tangents, of unit length


Mode = tuple[ElementState, ...]


@final
@dataclass(frozen=True, eq=False)
class ModeSolution:
    """Accelerations and forces in a mode, or velocities and impulses after an impact."""

    mode: Mode
    a: Array  # shape (nv,)
    forces: Array  # shape (m,), the force along each row
    redundant: bool  # whether the forces of the rows held are not determined
    null: Array = field(default_factory=lambda: np.zeros((0, 0)))  # of the held rows' forces
    held: tuple[int, ...] = ()


class HeldRows(NamedTuple):
    """The rows that a mode holds, the directions of their forces, and the force it knows."""

    rows: list[int]
    forces: Array  # shape (nv, rows)
    friction: Array  # shape (rows, m), what a unit of each row's force is along all rows
    known: Array  # shape (m,), forces along rows that are known


def hold(
    terms: Terms, elements: Sequence[ElementRows], mode: Mode, permanent: Sequence[int]
) -> HeldRows:
    """Return what a mode holds."""
    rows = list(permanent)
    m, scalars = len(terms.jacobian), terms.gaps.dtype
    known = np.zeros(m, scalars)
    sliding: dict[int, list[tuple[int, float]]] = {}  # shares of the row that presses
    for k, (element, state) in enumerate(zip(elements, mode, strict=True)):
        normal = element.normal
        if state.name == OPEN:
            continue
        if normal is not None and element.stiffness is not None:
            known[normal] = -element.stiffness * terms.gaps[normal]
        elif normal is not None:
            rows.append(normal)
        if state.name == STICKS:
            rows += element.tangents
        elif state.direction:
            pairs = zip(element.tangents, state.direction, strict=True)
            shares = [(row, -terms.kinetic[k] * part) for row, part in pairs]
            if element.pressing is None:
                for row, share in shares:
                    known[row] = share
            else:
                sliding.setdefault(element.pressing, []).extend(shares)
    for pressing in sliding.keys() - rows:  # of an elastic stop, or of nothing that touches
        for row, share in sliding[pressing]:
            known[row] = share * known[pressing]
    friction = np.zeros((len(rows), m), scalars)
    for i, row in enumerate(rows):
        friction[i, row] = 1.0
        for tangent, share in sliding.get(row, ()):
            friction[i, tangent] = share
    return HeldRows(rows, terms.jacobian.T @ friction.T, friction, known)


def solve(
    terms: Terms,
    elements: Sequence[ElementRows],
    mode: Mode,
    permanent: Sequence[int],
    targets: Array | None = None,
) -> ModeSolution | None:
    """Return accelerations and forces in a mode; None if its equations have no solution.

    With `targets`, rates (m,) that the rows are to have, it returns the change of velocities and
    the impulses instead.
    """
    held = hold(terms, elements, mode, permanent)
    rows, J = held.rows, terms.jacobian
    known = held.known if targets is None else np.zeros(len(J))
    load = terms.load + J.T @ known if targets is None else np.zeros(len(terms.load))
    if not rows:
        return ModeSolution(mode, np.linalg.solve(terms.mass, load), known, redundant=False)
    response = np.linalg.solve(terms.mass, np.column_stack([load, held.forces]))
    free, yielding = response[:, 0], response[:, 1:]
    wanted = -terms.gamma[rows] if targets is None else targets[rows] - terms.rates[rows]
    right = wanted - J[rows] @ free
    system = J[rows] @ yielding
    null = np.zeros((len(rows), 0))
    if len(rows) == 1:
        size = np.abs(J[rows[0]]) @ np.abs(yielding[:, 0])
        if abs(system[0, 0]) <= REDUNDANT * size:
            return None
        forces = right / system[0, 0]
    else:
        # rows in the metric of kinetic energy, so that singular values are comparable
        inverse = np.linalg.solve(terms.mass, J[rows].T)
        scale = np.sqrt(np.einsum("ij,ji->i", J[rows], inverse))
        scale[scale == 0] = 1.0
        left, sizes, right_vectors = np.linalg.svd(system / np.outer(scale, scale))
        rank = int((sizes > REDUNDANT * max(sizes[0], TINY)).sum())
        part = left[:, :rank].T @ (right / scale) / sizes[:rank]
        forces = right_vectors[:rank].T @ part / scale
        if rank < len(rows):
            null = right_vectors[rank:].T / scale[:, None]
            missed = np.abs(system @ forces - right).max()
            if missed > SLACK * (np.abs(wanted).max() + np.abs(J[rows] @ free).max()):
                return None
    a = free + yielding @ forces
    for i, row in enumerate(rows):
        # a coordinate that sticks does not creep, not even by rounding
        entries = np.flatnonzero(J[row])
        if len(entries) == 1:
            column = entries[0]
            a[column] = wanted[i] / J[row, column]
    total = known + held.friction.T @ forces
    return ModeSolution(mode, a, total, null.shape[1] > 0, null, tuple(rows))


def list_margins(
    terms: Terms,
    elements: Sequence[ElementRows],
    mode: Mode,
    forces: Array | None,
    length: Callable[..., Any],
) -> list[tuple[Any, Any]]:
    """Return what each element has left in its state, see `Laws.margins`.

    It holds for numbers and for scalars on a tape; `length` gives that of a force by its parts.
    """
    margins: list[tuple[Any, Any]] = []
    for k, (element, state) in enumerate(zip(elements, mode, strict=True)):
        normal = element.normal
        if normal is not None and (state.name == OPEN or element.stiffness is not None):
            gap = terms.gaps[normal]
            margins.append((gap if state.name == OPEN else -gap, 1.0))
            continue
        press: Any = 1.0
        if normal is not None and forces is not None:
            press = forces[normal] + element.holds
        friction: Any = 1.0
        if state.name == STICKS and forces is not None:
            pulls = [forces[row] for row in element.tangents]
            friction = friction_limit(element, terms.static[k], forces) - length(*pulls)
        elif state.direction:
            # the slip along the direction in which it began
            pairs = zip(element.tangents, state.direction, strict=True)
            friction = sum(terms.rates[row] * part for row, part in pairs)
        margins.append((press, friction))
    return margins


def friction_limit(element: ElementRows, coefficient: Any, forces: Array) -> Any:
    """Return the most friction of an element, by its coefficient and the forces along rows."""
    return coefficient if element.pressing is None else coefficient * forces[element.pressing]


@final
class Laws:
    """The laws of a mechanism's elements."""

    def __init__(self, elements: Sequence[ElementRows], permanent: Sequence[int]) -> None:
        self.elements = tuple(elements)
        self.permanent = tuple(permanent)

    def solve(self, terms: Terms, mode: Mode) -> ModeSolution | None:
        """Return accelerations and forces in a mode, with the direction of slip of the state."""
        return solve(terms, self.elements, self.along_slip(terms, mode), self.permanent)

    def along_slip(self, terms: Terms, mode: Mode) -> Mode:
        """Return the mode with the directions of slip in space that the state has."""
        if not any(state.name == SLIPS for state in mode):
            return mode
        states = []
        for element, state in zip(self.elements, mode, strict=True):
            if state.name == SLIPS:
                slip = terms.rates[list(element.tangents)]
                size = float(np.linalg.norm(slip))
                if size > 0 and slip @ np.array(state.direction) > 0:
                    state = replace(state, direction=tuple((slip / size).tolist()))
            states.append(state)
        return tuple(states)

    def margins(self, terms: Terms, mode: Mode) -> Array:
        """Return what each element has left in its state, shape (elements, 2): gap, friction.

        The first is the gap while it is open and the normal force while it is closed, the second
        the reserve of static friction or the speed of slip; 1 where there is none.
        """
        solution = self.solve(terms, mode)
        if solution is not None and solution.redundant:
            return self._shared_margins(terms, solution, np.ones((len(self.elements), 2)))
        forces = None if solution is None else solution.forces
        return np.array(list_margins(terms, self.elements, mode, forces, hypot))

    def _shared_margins(self, terms: Terms, solution: ModeSolution, margins: Array) -> Array:
        """Return the margins where forces can be shared: what sticks does so while a share exists.

        Elements that bear redundant forces together have one margin, that of the best share.
        """
        spare = self._find_spare(terms, solution)
        for k, (element, state) in enumerate(zip(self.elements, solution.mode, strict=True)):
            if element.normal is not None and (state.name == OPEN or element.stiffness is not None):
                gap = terms.gaps[element.normal]
                margins[k, 0] = gap if state.name == OPEN else -gap
            elif state.name == STICKS:
                margins[k, 1] = spare
            elif element.normal is not None:
                margins[k, 0] = spare
            if state.direction:
                slip = terms.rates[list(element.tangents)]
                margins[k, 1] = float(slip @ np.array(state.direction))
        return margins

    # which mode follows -------------------------------------------------------------------------

    def follow(
        self,
        terms: Terms,
        touching: Sequence[bool],
        still: float,
        forbidden: frozenset[tuple[int, str]] = frozenset(),
        ended: frozenset[Mode] = frozenset(),
    ) -> list[ModeSolution]:
        """Return every mode that may follow in a state, by distinct accelerations.

        Args:
            terms: those of the state.
            touching: whether the gap of each element is closed.
            still: speeds up to this are none.
            forbidden: elements and states that end here.
            ended: modes that end as a whole, as their elements share their forces.
        """
        choices = []
        for k, element in enumerate(self.elements):
            states = self._candidates(terms, element, touching[k], still)
            choices.append([s for s in states if (k, s.name) not in forbidden])
        self._refuse_many(choices)
        solutions: list[ModeSolution] = []
        for mode in product(*choices):
            if mode in ended:
                continue
            for solution in self._in_space(terms, mode):
                if self._follows(terms, solution, touching, still):
                    solutions.append(solution)
        return _distinct(_prefer_sticking(self, terms, solutions), terms)

    def _candidates(
        self, terms: Terms, element: ElementRows, touches: bool, still: float
    ) -> list[ElementState]:
        normal = element.normal
        states: list[ElementState] = []
        if normal is not None:
            if element.stiffness is not None:
                inside = terms.gaps[normal] < 0 or (touches and terms.rates[normal] < 0)
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
        self, terms: Terms, mode: Mode, targets: Array | None = None
    ) -> Iterator[ModeSolution]:
        """Yield the solutions of a mode, for each direction in which a contact begins to slip."""
        unknown = [k for k, s in enumerate(mode) if s.name == SLIPS and not s.direction]
        if not unknown:
            solution = solve(terms, self.elements, mode, self.permanent, targets)
            if solution is not None:
                yield solution
            return
        if len(unknown) > 1:
            names = ", ".join(repr(self.elements[k].name) for k in unknown)
            raise InputError(
                f"contacts {names} may begin to slip in space at once, which is not treated: only "
                "one at a time is"
            )
        (k,) = unknown
        tangents = list(self.elements[k].tangents)

        def at(angle: float) -> ModeSolution | None:
            state = ElementState(SLIPS, (float(np.cos(angle)), float(np.sin(angle))))
            changed = (*mode[:k], state, *mode[k + 1 :])
            return solve(terms, self.elements, changed, self.permanent, targets)

        def across(angle: float) -> float:
            solution = at(angle)
            if solution is None:
                return float("nan")
            x, y = self._begins(terms, solution, tangents, targets)
            return float(np.cos(angle) * y - np.sin(angle) * x)

        from scipy.optimize import brentq

        angles = np.linspace(-np.pi, np.pi, ANGLES + 1) + 0.01
        values = [across(angle) for angle in angles]
        for low, high, a, b in zip(angles, angles[1:], values, values[1:], strict=False):
            if a * b <= 0 and a != b:
                solution = at(float(brentq(across, low, high, xtol=1e-15, rtol=1e-15)))
                if solution is not None:
                    yield solution

    @staticmethod
    def _begins(
        terms: Terms, solution: ModeSolution, rows: list[int], targets: Array | None
    ) -> Array:
        """The rate at which slip grows, or after an impact the slip, along rows."""
        change = terms.jacobian[rows] @ solution.a
        added: Array = change + (terms.gamma[rows] if targets is None else terms.rates[rows])
        return added

    def _follows(
        self, terms: Terms, solution: ModeSolution, touching: Sequence[bool], still: float
    ) -> bool:
        """Return whether what a mode presupposes is so."""
        J, a = terms.jacobian, solution.a
        forces = solution.forces
        growth = J @ a + terms.gamma
        # sizes of what is added up in each row: differences below a part of them are rounding
        free = np.linalg.solve(terms.mass, terms.load)
        size = np.abs(J) @ (np.abs(a) + np.abs(free)) + np.abs(terms.gamma)
        pull = float(np.abs(forces).max(initial=0.0)) + _typical_force(terms)
        if solution.redundant:
            return self._feasible(terms, solution, touching, still, pull)
        for k, (element, state) in enumerate(zip(self.elements, solution.mode, strict=True)):
            normal = element.normal
            if element.stiffness is not None:
                continue
            if normal is not None and state.name == OPEN:
                near = touching[k] and terms.rates[normal] <= still
                if near and growth[normal] < -SLACK * size[normal]:
                    return False
                continue
            if normal is not None and forces[normal] < -element.holds - SLACK * pull:
                return False
            tangents = list(element.tangents)
            if state.name == STICKS:
                bound = friction_limit(element, terms.static[k], forces)
                if np.linalg.norm(forces[tangents]) > bound + SLACK * pull:
                    return False
            elif state.direction and np.linalg.norm(terms.rates[tangents]) <= still:
                grows = float(growth[tangents] @ np.array(state.direction))
                if grows < -SLACK * float(size[tangents].max()):
                    return False
        return True

    def _feasible(
        self,
        terms: Terms,
        solution: ModeSolution,
        touching: Sequence[bool],
        still: float,
        pull: float,
    ) -> bool:
        """Return whether redundant forces can be shared so that all conditions are met."""
        growth = terms.jacobian @ solution.a + terms.gamma
        for k, (element, state) in enumerate(zip(self.elements, solution.mode, strict=True)):
            normal = element.normal
            if state.name != OPEN or normal is None or not touching[k]:
                continue
            near = terms.rates[normal] <= still
            if near and growth[normal] < -SLACK * (1 + np.abs(growth).max()):
                return False
        return self._find_spare(terms, solution) >= -SLACK * pull

    def _find_spare(self, terms: Terms, solution: ModeSolution) -> float:
        """Return the least reserve of normal forces and static friction under the best share.

        The share of redundant forces that leaves most is found by a linear program; in space the
        cone of friction is a pyramid of 64 sides about it, wider by a thousandth at most.
        """
        from scipy.optimize import linprog

        held = hold(terms, self.elements, solution.mode, self.permanent)
        spread = held.friction.T @ solution.null  # along all rows, by shares of the null space
        rows, bounds = list[Array](), list[float]()
        for k, (element, state) in enumerate(zip(self.elements, solution.mode, strict=True)):
            normal = element.normal
            if state.name == OPEN or element.stiffness is not None:
                continue
            if normal is not None:
                rows.append(-spread[normal])
                bounds.append(float(solution.forces[normal]) + element.holds)
            if state.name != STICKS:
                continue
            limit, tangents, pressing = terms.static[k], list(element.tangents), element.pressing
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

    def impact(self, terms: Terms, touching: Sequence[bool], still: float) -> Array:
        """Return the change of velocities by an impact of the contacts that touch.

        Raises:
            UndecidedError: if no velocities follow, or several.
        """
        contacts = [
            k
            for k, element in enumerate(self.elements)
            if touching[k] and element.normal is not None and element.stiffness is None
        ]
        if any(getattr(self.elements[k].element, "in_turn", False) for k in contacts):
            return self._in_turn(terms, contacts, still)
        return self._together(terms, contacts, still)

    def _in_turn(self, terms: Terms, contacts: list[int], still: float) -> Array:
        change = np.zeros(len(terms.load))
        for _ in range(MOST_IMPACTS):
            rates = {k: terms.rates[self._normal(k)] for k in contacts}
            fastest = min(rates, key=lambda k: rates[k])
            if rates[fastest] >= -still:
                return change
            step = self._together(terms, [fastest], still)
            change = change + step
            terms = terms._replace(rates=terms.rates + terms.jacobian @ step)
        raise UndecidedError(
            f"impacts in turn do not end after {MOST_IMPACTS}; let them be together", 0
        )

    def _normal(self, k: int) -> int:
        row = self.elements[k].normal
        assert row is not None, "it has a gap"
        return row

    def _together(self, terms: Terms, contacts: list[int], still: float) -> Array:
        laws = {getattr(self.elements[k].element, "law", "newton") for k in contacts}
        if laws == {"poisson"}:
            return self._by_poisson(terms, contacts, still)
        if "poisson" in laws:
            raise InputError(
                "contacts that impact together have Newton's and Poisson's laws of restitution; "
                "expected one of them"
            )
        targets = np.zeros(len(terms.jacobian))
        for k in contacts:
            approach = min(terms.rates[self._normal(k)], 0.0)
            targets[self._normal(k)] = -self.elements[k].restitution * approach
        return self._impulses(terms, contacts, targets, still).a

    def _by_poisson(self, terms: Terms, contacts: list[int], still: float) -> Array:
        """Compression until no contact approaches, then e times its normal impulses."""
        targets = np.zeros(len(terms.jacobian))
        pressed = self._impulses(terms, contacts, targets, still)
        after = terms._replace(rates=terms.rates + terms.jacobian @ pressed.a)
        given = {
            k: self.elements[k].restitution * float(pressed.forces[self._normal(k)])
            for k in contacts
        }
        change = pressed.a + self._expand(after, given, still)
        size = np.abs(terms.jacobian) @ np.abs(change) + np.abs(terms.rates) + still
        rates = terms.rates + terms.jacobian @ change
        for k in contacts:
            normal = self._normal(k)
            # friction in expansion may press a contact together again, which this law leaves open
            if rates[normal] < -SLACK * size[normal]:
                raise UndecidedError(
                    f"after Poisson's expansion the bodies at {self.elements[k].name!r} still "
                    "approach each other; use Newton's law of restitution",
                    0,
                )
        return change

    def _expand(self, terms: Terms, given: dict[int, float], still: float) -> Array:
        """Return the change of velocities by given normal impulses, with their friction."""
        choices = [self._impact_states(k, closed_only=True) for k in given]
        J = terms.jacobian
        changes: list[Array] = []
        for states in product(*choices):
            normal, rows, shares = np.zeros(len(J)), list(self.permanent), np.zeros(len(J))
            for (k, impulse), state in zip(given.items(), states, strict=True):
                normal[self._normal(k)] = impulse
                tangents = list(self.elements[k].tangents)
                if state.name == STICKS:
                    rows += tangents
                elif state.direction:
                    shares[tangents] = -terms.kinetic[k] * impulse * np.array(state.direction)
            free = np.linalg.solve(terms.mass, J.T @ (normal + shares))
            system = J[rows] @ np.linalg.solve(terms.mass, J[rows].T)
            impulses = np.linalg.lstsq(system, -(terms.rates + J @ free)[rows], rcond=REDUNDANT)[0]
            change = free + np.linalg.solve(terms.mass, J[rows].T @ impulses)
            forces = normal + shares
            forces[rows] += impulses
            size = np.abs(J) @ np.abs(change) + np.abs(terms.rates) + still
            sound = True
            for (k, impulse), state in zip(given.items(), states, strict=True):
                tangents = list(self.elements[k].tangents)
                slip = (terms.rates + J @ change)[tangents]
                if state.name == STICKS:
                    bound = terms.kinetic[k] * impulse * (1 + SLACK) + TINY
                    sound &= bool(np.linalg.norm(forces[tangents]) <= bound)
                elif state.direction:
                    least = -SLACK * size[tangents].max()
                    sound &= bool(slip @ np.array(state.direction) >= least)
            if sound:
                changes.append(change)
        distinct: list[Array] = []
        for change in changes:
            speed = np.abs(change).max() + np.abs(terms.rates).max() + still
            if all(np.abs(change - old).max() > SAME_ANSWER * speed for old in distinct):
                distinct.append(change)
        if len(distinct) != 1:
            message = _say_count(len(distinct), "velocities", "after this impact")
            raise UndecidedError(message, len(distinct))
        return distinct[0]

    def _impact_states(self, k: int, *, closed_only: bool = False) -> list[ElementState]:
        element = self.elements[k]
        states = [] if closed_only else [ElementState(OPEN)]
        if not element.tangents:
            return [*states, ElementState(CLOSED)]
        states.append(ElementState(STICKS))
        if len(element.tangents) == 1:
            return [*states, ElementState(FORWARD, (1.0,)), ElementState(BACKWARD, (-1.0,))]
        if closed_only:
            raise InputError(
                f"contact {self.elements[k].name!r}: Poisson's law with friction is treated in the "
                "plane alone; use Newton's, or no friction"
            )
        return [*states, ElementState(SLIPS)]

    def _impulses(
        self, terms: Terms, contacts: list[int], targets: Array, still: float
    ) -> ModeSolution:
        """Return the change of velocities and the impulses for which rates reach their targets."""
        choices: list[list[ElementState]] = []
        for k in range(len(self.elements)):
            # what only rubs has no impulse, nor has what does not touch
            states = self._impact_states(k) if k in contacts else [ElementState(OPEN)]
            choices.append(states)
        self._refuse_many(choices)
        solutions: list[ModeSolution] = []
        for mode in product(*choices):
            for solution in self._in_space(terms, mode, targets):
                if self._restores(terms, solution, contacts, targets, still):
                    solutions.append(solution)
        solutions = _distinct(solutions, terms, still)
        if len(solutions) != 1:
            names = ", ".join(self.elements[k].name for k in contacts)
            message = _say_count(len(solutions), "velocities", f"after the impact of {names}")
            raise UndecidedError(message, len(solutions))
        return solutions[0]

    def _restores(
        self,
        terms: Terms,
        solution: ModeSolution,
        contacts: list[int],
        targets: Array,
        still: float,
    ) -> bool:
        after = terms.rates + terms.jacobian @ solution.a
        size = np.abs(terms.jacobian) @ np.abs(solution.a) + np.abs(terms.rates) + still
        impulses = solution.forces
        most = float(np.abs(impulses).max(initial=0.0))
        for k in contacts:
            state, normal = solution.mode[k], self._normal(k)
            if after[normal] < targets[normal] - SLACK * size[normal]:
                return False
            if impulses[normal] < -SLACK * most:
                return False
            tangents = list(self.elements[k].tangents)
            if state.name == STICKS:
                bound = terms.kinetic[k] * impulses[normal] + SLACK * most
                if np.linalg.norm(impulses[tangents]) > bound:
                    return False
            elif state.direction:
                slip = float(after[tangents] @ np.array(state.direction))
                if slip < -SLACK * float(size[tangents].max()):
                    return False
        return True


def _typical_force(terms: Terms) -> float:
    """A size of the forces in a state along rows, for rounding."""
    lengths = np.abs(terms.jacobian).max(axis=1, initial=0.0)
    longest = float(lengths.max(initial=0.0))
    return float(np.abs(terms.load).max(initial=0.0)) / longest if longest else 0.0


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
