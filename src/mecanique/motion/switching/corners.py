"""The corners of a motion: where elements switch, and the mode between two of them.

The equations of a mode are compiled for the many states between two corners where the mode
determines its forces: the rows that it holds are independent. They take their laws from the tape,
not from the engine, and are compared with the engine before they are used.
"""

from __future__ import annotations

from bisect import bisect_right
from collections.abc import Callable, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, field, replace
from functools import cached_property
from itertools import product
from math import inf, nan
from typing import ClassVar, NoReturn, TypeVar, final

import numpy as np

from mecanique.arrays import Array, Flags
from mecanique.derivation.mechanics.switching import (
    OPEN,
    SLIPS,
    STICKS,
    ElementState,
    Mode,
    Terms,
    accelerate,
    list_present_margins,
)
from mecanique.derivation.switching import name_forces
from mecanique.derivation.tolerances import (
    BEGUN,
    CLOSED_GAP,
    DEAD,
    DRIFTED,
    EVEN,
    LEAST_MARGIN,
    NO_GAP,
    PARTED,
    REDUNDANT,
    SAME_PROGRAM,
    SAME_WAY,
    SLACK,
    STILL,
    TAIL,
    TURNED,
)
from mecanique.errors import DerivationError, InputError, IntegrationError
from mecanique.generation.mechanics.switching import SwitchingEquations
from mecanique.model.constraints.friction import Contact
from mecanique.model.forces import Force, JointForce, Torque
from mecanique.model.joint_base import Single
from mecanique.model.mechanism import Mechanism
from mecanique.model.mechanism_units import characteristic_length
from mecanique.model.parameters import Input
from mecanique.motion.compile.python import list_values, scalar
from mecanique.motion.record.curve import Curve
from mecanique.motion.record.events import Event, Margin, ModeSpan, Occurrence
from mecanique.motion.switching.law import Laws, ModeSolution, UndecidedError, find_gains, is_slow
from mecanique.motion.switching.rows import SwitchingRows
from mecanique.motion.tolerances import BY_PROGRAM, TINY
from mecanique.program.traced import values_of

MOST_OPERATIONS = 20_000
"""Operations of a mode's program; a longer one is no faster than the engine."""


@final
class ModeProgram:
    """The rates and margins of one mode, as functions of time and state."""

    def __init__(self, rows: SwitchingRows, equations: SwitchingEquations, mode: Mode) -> None:
        terms, elements, letters = equations.terms, equations.elements, rows.letters
        acceleration, forces = equations.solve(mode, accelerate(terms, elements))
        margins = list_present_margins(terms, elements, mode, forces, equations.length)
        self._elements = len(margins)
        self.slipping = [k for k, state in enumerate(mode) if state.name == SLIPS]
        slips = [terms.rates[row] for k in self.slipping for row in elements[k].tangents]
        rates = values_of([*letters.rates, *acceleration, *slips])
        watched = values_of([*np.ravel(margins), *terms.load, *slips])
        program = rows.program(rates)
        self.length = len(letters.tape.find_needed([*rates, *watched]))
        self._rates = scalar(program)
        self._watch = list_values(program, watched)

    def rates(self, t: float, y: Array, mode: Mode, slow: float) -> Array | None:
        """Return the rates of a state; None where slip in space has no direction of its own."""
        values = self._rates(t, y)
        if not self.slipping:
            return values
        slips = values[len(y) :].reshape(-1, 2)
        return values[: len(y)] if self._has_directions(slips, mode, slow) else None

    def margins(self, t: float, y: Array, mode: Mode, slow: float) -> tuple[Array, float] | None:
        """Return what each element has left, shape (elements, 2), and the largest load.

        None where slip in space has no direction of its own.
        """
        values = np.array(self._watch(t, y))
        end, last = 2 * self._elements, len(values) - 2 * len(self.slipping)
        margins, slips = values[:end].reshape(-1, 2), values[last:].reshape(-1, 2)
        if not self._has_directions(slips, mode, slow):
            return None
        for k, slip in zip(self.slipping, slips, strict=True):
            margins[k, 1] = slip @ np.array(mode[k].direction) - TURNED * np.linalg.norm(slip)
        return margins, float(np.abs(values[end:last]).max(initial=0.0))

    def _has_directions(self, slips: Array, mode: Mode, slow: float) -> bool:
        """Return whether slip in space is faster than rounding, and not past its end."""
        sizes = np.hypot(*slips.T)
        pairs = zip(self.slipping, slips, sizes, strict=True)
        return all(
            size > slow and slip @ np.array(mode[k].direction) > SAME_WAY * size
            for k, slip, size in pairs
        )


@final
class ModePrograms:
    """Writes the modes of a mechanism's elements as programs."""

    def __init__(self, rows: SwitchingRows) -> None:
        self._rows = rows

    @cached_property
    def _equations(self) -> SwitchingEquations:
        rows = self._rows
        return SwitchingEquations(rows.mechanism, rows.letters, rows.idle.__contains__)

    def write(self, mode: Mode) -> ModeProgram | None:
        """Return a mode as a program; None if it is not to be written as one."""
        sliding = any(
            (state.direction or state.name == SLIPS) and element.pressing is not None
            for element, state in zip(self._rows.elements, mode, strict=True)
        )
        # what slips beside another contact is not solved on a tape to as many digits as here
        presses = sum(
            state.name != OPEN and e.struck
            for e, state in zip(self._rows.elements, mode, strict=True)
        )
        if self._rows.permanent or (sliding and presses > 1):
            return None
        try:
            program = ModeProgram(self._rows, self._equations, mode)
        except (ArithmeticError, DerivationError):
            return None
        return program if program.length <= MOST_OPERATIONS else None

    def write_terms(self) -> Callable[[float, Array], Terms] | None:
        """Return a program of the terms of a state; None if there is none."""
        if self._rows.permanent:
            return None
        try:
            parts, program = self._equations.terms, self._rows.program(())
            values = values_of(np.concatenate([*map(np.ravel, parts)]))
            if len(program.tape.find_needed(values)) > MOST_OPERATIONS:
                return None
            measure = list_values(program, values)
        except (ArithmeticError, DerivationError):
            return None
        ends, nv = np.cumsum([part.size for part in parts])[:-1], len(parts.load)

        def measure_terms(t: float, y: Array) -> Terms:
            split = np.split(np.array(measure(t, y)), ends)
            terms = Terms(
                *(part.reshape(old.shape) for part, old in zip(split, parts, strict=True))
            )
            return terms._replace(drift=terms.rates - terms.jacobian @ y[-nv:])

        return measure_terms


_Answer = TypeVar("_Answer")


MOST_AT_ONCE = 50
"""Switches that may follow each other at one instant."""

MOST_KEPT = 100_000
"""Times at which forces along a motion are kept."""

_KINDS = ("normal", "friction")
"""The forces of a contact."""

_LETTERS = ("Fx", "Fy", "Fz", "Mx", "My", "Mz")
"""Letters of the components of a wrench."""

OFTEN = 100
"""So many evaluations of a mode by the engine take as long as to write its program."""


@final
class Corners:
    """The elements of a mechanism in motion, and the modes they went through.

    Where the mode at a time is asked for, it is that after a switch at this time.
    """

    share: ClassVar[float] = 0.1

    def __init__(self, mechanism: Mechanism, rtol: float = STILL) -> None:
        self.mechanism = mechanism
        self._error = max(1.0, rtol / STILL)  # of steps, by rounding
        self.rows = SwitchingRows(mechanism)
        self.elements = self.rows.elements
        self.laws = Laws(self.elements, self.rows.permanent)
        self.rubbing = {e.name: list(e.tangents) for e in self.elements if e.tangents}
        self.length = characteristic_length(self.rows.base)
        self._nq = mechanism.nq
        self._times: list[float] = []
        self._modes: list[Mode] = []
        self._programs: dict[Mode, ModeProgram | None] = {}
        self._asked: dict[Mode, int] = {}
        # from when to when the program of the last mode asked for holds; hashing a mode takes time
        self._present_program: tuple[float, float, ModeProgram | None] = (inf, -inf, None)
        self._slow = 0.0  # of slip in space, that which the engine follows
        self._slow_slip = 0.0  # its speed as it begins, and as it is about to end
        self._writer = ModePrograms(self.rows)
        self._terms: Callable[[float, Array], Terms] | None = None
        self._at_once = 0
        self._ended: frozenset[Mode] = frozenset()
        self.events = tuple(
            Event(
                f"{element.name}: {('gap', 'friction')[which]}",
                Margin(self, (k, which), switches=True),
                -1,
            )
            for k, element in enumerate(self.elements)
            for which in (0, 1)
            if (element.normal is not None if which == 0 else element.tangents)
        )

    # between corners ----------------------------------------------------------------------------

    def mode(self, t: float) -> Mode:
        """Return the mode at a time [s]."""
        return self._modes[max(bisect_right(self._times, t) - 1, 0)]

    def rhs(self, t: float, y: Array) -> Array:
        """Return the rates of a state, shape (nq + nv,)."""
        program = self._program(t, y)
        if program is not None:
            try:
                mode = self.mode(t) if program.slipping else ()
                rates = program.rates(t, y, mode, self._slow)
            except (ArithmeticError, ValueError):
                rates = None  # the engine may know, or says why not
            if rates is not None:
                return rates
        return self._rates(t, y)

    def _rates(self, t: float, y: Array) -> Array:
        """Return the rates of a state by the engine's quantities."""
        q, v = y[: self._nq], y[self._nq :]
        solution = self._solve(self.rows.at(q, v, t), v, t)
        return np.concatenate([self.rows.rates.first(q, v), solution.a])

    def measure(self, q: Array, v: Array, t: float) -> Terms:
        """Return the terms in one of many states, by a program that gave the engine's before."""
        y, engine = np.concatenate([q, v]), self.rows.at
        try:
            if self._terms is None:
                written, nq = self._writer.write_terms(), self._nq
                if written is not None and _are_close(written(t, y), engine(q, v, t)):
                    self._terms = written
                else:
                    self._terms = lambda t, y: engine(y[:nq], y[nq:], t)
            return self._terms(t, y)
        except (ArithmeticError, ValueError):
            return engine(q, v, t)  # it may know, or says why not

    def _program(self, t: float, y: Array) -> ModeProgram | None:
        """Return the program of the mode at a time, once that mode has been asked for often."""
        begin, end, program = self._present_program
        if begin <= t < end:
            return program
        # a program takes the directions of slip in space from the state
        mode = tuple(ElementState(s.name) if s.name == SLIPS else s for s in self.mode(t))
        if any(state.beginning for state in self.mode(t)):
            return None
        if mode in self._programs:
            program = self._programs[mode]
            k = max(bisect_right(self._times, t) - 1, 0)
            end = self._times[k + 1] if k + 1 < len(self._times) else inf
            self._present_program = self._times[k], end, program
            return program
        self._asked[mode] = self._asked.get(mode, 0) + 1
        if self._asked[mode] <= OFTEN:
            return None
        program = self._writer.write(mode)
        if program is not None and not self._agrees(program, t, y):
            program = None
        self._programs[mode] = program
        return program

    def _agrees(self, program: ModeProgram, t: float, y: Array) -> bool:
        """Return whether a program gives what the engine's quantities do."""
        y = self.close(t, y)  # off unit quaternions each goes on in a way of its own
        terms, mode = self.rows.at(y[: self._nq], y[self._nq :], t), self.mode(t)
        self._slow = max(self._slow, BY_PROGRAM * self.still_speed(terms, y[self._nq :]))
        try:
            rates = program.rates(t, y, mode, self._slow)
            left = program.margins(t, y, mode, self._slow)
        except (ArithmeticError, ValueError):
            return False
        if rates is None or left is None:
            return False
        solution = self._solve(terms, y[self._nq :], t)
        theirs = self._rates(t, y), self.laws.margins(terms, mode, solution)
        return _are_close((rates, left[0]), theirs)

    def _solve(self, terms: Terms, v: Array, t: float) -> ModeSolution:
        mode = self.mode(t)
        solution = self.laws.solve(terms, mode, _rounding(terms, v))
        if solution is None:
            raise UndecidedError(
                f"the mode {self.describe(mode)} has no accelerations at t = {t:.6g} s", 0
            )
        return solution

    def forces(self, t: float, q: Array, v: Array) -> tuple[Terms, Array]:
        """Return the terms and the force along each row in a state, shape (m,)."""
        terms = self.rows.at(q, v, t)
        return terms, self._solve(terms, v, t).forces

    def shares_friction(self, t: float, q: Array, v: Array) -> bool:
        """Return whether contacts in space stick by friction that they share in any way."""
        solution = self._solve(self.rows.at(q, v, t), v, t)
        pairs = zip(self.elements, solution.mode, strict=True)
        rows = [row for e, s in pairs if s.name == STICKS and e.tangents[1:] for row in e.tangents]
        sizes = np.abs(solution.forces)
        rubs = sizes[rows].max(initial=0.0) > SLACK * sizes.max(initial=0.0)
        return solution.redundant and bool(rubs)

    def push(
        self, t: Array, q: Array, v: Array
    ) -> tuple[dict[str, Array], dict[str, Flags], dict[str, Array]]:
        """Return what elements do along a motion, by name.

        The wrenches of contacts on their bodies, about their centers, shape (n, 6), world axes, and
        which of their components elements share in any way, shape (6,); and the forces of elements
        in joints by their letters, such as R_dry, shape (n,), NaN where they are shared.
        """
        contacts = [e for e in self.mechanism.switching if isinstance(e, Contact)]
        wrenches: dict[str, list[Array]] = {contact.name: [] for contact in contacts}
        loose = {name: np.zeros(6, dtype=bool) for name in wrenches}
        along = dict[str, list[float]]()
        for moment, position, velocity in zip(t.tolist(), q, v, strict=True):
            solution = self._solve(self.rows.at(position, velocity, moment), velocity, moment)
            ways = [solution.forces, *solution.spread.T]
            least = REDUNDANT * np.abs(solution.spread).max(initial=0.0)
            parts = [self.rows.contact_wrenches(position, moment, way) for way in ways if contacts]
            for its in contacts:
                acting = [part[its.name, its.body, kind] for kind in _KINDS for part in parts]
                pushed, *shares = np.array(acting).reshape(2, -1, 6).sum(axis=0)
                wrenches[its.name].append(pushed)
                for share in shares:
                    loose[its.name] |= np.abs(share) > least
            for element, rows in zip(self.mechanism.switching, self.elements, strict=True):
                if isinstance(element, Contact):
                    continue
                for name, row in zip(name_forces(element, 0), rows.rows, strict=True):
                    shared = bool((np.abs(solution.spread[row : row + 1]) > least).any())
                    along.setdefault(name, []).append(nan if shared else solution.forces[row])
        return (
            {name: np.array(values) for name, values in wrenches.items()},
            loose,
            {name: np.array(values) for name, values in along.items()},
        )

    def powers(self, t: Array, q: Array, v: Array) -> Array:
        """Return the heat of each element that rubs, then the power of all, shape (n, k) [W]."""
        powers = []
        for moment, position, velocity in zip(t.tolist(), q, v, strict=True):
            terms, forces = self.forces(moment, position, velocity)
            # what is held does not move: between steps it does by the error of the curve, whose
            # power would be resolved in vain
            slips = terms.rates.copy()
            slips[self.list_rows(self.mode(moment))] = 0.0
            heat = [-forces[rows] @ slips[rows] for rows in self.rubbing.values()]
            powers.append([*heat, forces @ (slips - terms.drift)])
        return np.array(powers).reshape(len(t), -1)

    def margins(self, t: float, q: Array, v: Array) -> Array:
        """Return what each element has left, shape (elements, 2), `list_margins`."""
        mode, y = self.mode(t), np.concatenate([q, v])
        program, left = self._program(t, y), None
        if program is not None:
            with suppress(ArithmeticError, ValueError):
                left = program.margins(t, y, mode, self._slow)
        if left is not None:
            margins, load = left
        else:
            terms = self.rows.at(q, v, t)
            solution = self.laws.solve(terms, mode, _rounding(terms, v))
            if solution is not None and solution.redundant:
                self._refuse_decisive_shares(terms, solution, v, t)
            margins = self.laws.margins(terms, mode, solution)
            load = float(np.abs(terms.load).max(initial=0.0))
            for k, state in enumerate(mode):
                if state.beginning:  # it ends at rest, or has begun
                    slow, speed = self.still_speed(terms, v), margins[k, 1]
                    margins[k, 1] = min(slow + speed, BEGUN * slow - speed)
        pull = DEAD * load + LEAST_MARGIN
        together = _slip_together(mode)
        for k, state in enumerate(mode):
            if state.name == OPEN:
                margins[k, 0] += EVEN * self.length
            elif self.elements[k].stiffness is None:
                margins[k, 0] += pull
            if state.name == STICKS:
                margins[k, 1] += pull
            if together and state.name == SLIPS and not state.beginning:
                # it is about to end: a little below the speed at which it is marked as slow, so
                # that the state of the corner is marked in spite of rounding
                slip = margins[k, 1] / (1.0 - TURNED)
                margins[k, 1] = min(margins[k, 1], slip - 0.8 * self._slow_slip)
        return margins

    def _refuse_decisive_shares(
        self, terms: Terms, solution: ModeSolution, v: Array, t: float
    ) -> None:
        if self.laws.shares_decide(terms, solution, self._find_error(terms, v)):
            raise UndecidedError(
                "how contacts share their forces, which is undetermined, decides how bodies move "
                f"at t = {t:.6g} s, as they slip in different directions",
                0,
            )

    # on the rows that are held ------------------------------------------------------------------

    def list_rows(self, mode: Mode) -> list[int]:
        """Return the rows held in velocity, of which those of gaps are held in position, too."""
        rows = list(self.rows.permanent)
        for element, state in zip(self.elements, mode, strict=True):
            if state.name != OPEN and element.struck:
                rows += element.rows[:1]
            if state.name == STICKS:
                rows += element.tangents
        return rows

    def close(self, t: float, y: Array) -> Array:
        """Return the state on the rows that are held, next to a state."""
        return self._project(t, y, self.mode(t))

    def _project(self, t: float, y: Array, mode: Mode) -> Array:
        in_velocity = self.list_rows(mode)
        in_position = [row for row in in_velocity if self.rows.positional[row]]
        q, v = self.rows.rates.normalize(y[: self._nq]), y[self._nq :]
        if not in_velocity:
            return np.concatenate([q, v])
        q = self._close_gaps(t, q, v, in_position)
        terms = self.rows.at(q, v, t)
        v = v + least_step(terms, in_velocity, terms.rates[in_velocity])
        for row in in_velocity:
            entries = np.flatnonzero(terms.jacobian[row])
            if len(entries) == 1:
                column = entries[0]
                # from zero, as minus a rate of zero would be told as -0
                v[column] = 0.0 - terms.drift[row] / terms.jacobian[row, column]
        return np.concatenate([q, v])

    def _close_gaps(self, t: float, q: Array, v: Array, rows: list[int]) -> Array:
        """Return the positions next to some at which the gaps of rows are zero."""
        # Newton's method, from the small gaps that the time of an event leaves
        for _ in range(4 if rows else 0):
            terms = self.rows.at(q, v, t)
            gaps = terms.gaps[rows]
            if np.abs(gaps).max() <= NO_GAP * self.length:
                break
            q = self.rows.rates.displace(q, least_step(terms, rows, gaps))
        return q

    def has_left(self, t: float, y: Array) -> bool:
        """Return whether a state has drifted off the rows that are held."""
        if not self.list_rows(self.mode(t)):
            return False
        gap = np.abs(self.close(t, y) - y)
        return bool(gap.max() > DRIFTED * (1.0 + np.abs(y).max()))

    def close_all(self, t: Array, q: Array, v: Array) -> tuple[Array, Array]:
        """Return the states on the rows held next to some states, shape (n, nq) and (n, nv)."""
        states = zip(t.tolist(), np.hstack([q, v]), strict=True)
        closed = np.array([self.close(*state) for state in states])
        return closed[:, : self._nq], closed[:, self._nq :]

    # at corners ---------------------------------------------------------------------------------

    def begin(self, t: float, y: Array) -> tuple[Array, list[Occurrence]]:
        """Return the state to start from, after impacts if there are any, and what happens."""
        q, v = y[: self._nq], y[self._nq :]
        terms = self.rows.at(q, v, t)
        for k, element in enumerate(self.elements):
            gap = float(terms.gaps[element.rows[0]]) if element.struck else 0.0
            if gap < -CLOSED_GAP * self.length and self._is_inside(terms, k):
                raise InputError(
                    f"{element.name!r} begins with a gap of {gap:.3g}: its bodies are one within "
                    "the other; expected a start where they are apart or touch"
                )
        touching = [self._is_touching(terms, k) for k in range(len(self.elements))]
        return self._change(t, y, touching, frozenset())

    def passes_over(self, t: float, y: Array, event: Event) -> bool:
        """Return whether an event is no corner: slip in space turned, or bodies that part met.

        The law takes the direction of slip from the state: nothing jumps, and the time need not be
        exact. Bodies that part are still one within the other by the rounding of their gap.
        """
        assert isinstance(event.when, Margin), "events of corners are margins"
        k, which = event.when.index
        mode, v = self.mode(t), y[self._nq :]
        terms = self.rows.at(y[: self._nq], v, t)
        if which == 0:
            row = self.elements[k].rows[0]
            met = terms.gaps[row] < -PARTED * self.length
            return (
                mode[k].name == OPEN and not met and terms.rates[row] > self.still_speed(terms, v)
            )
        if mode[k].beginning or not self._is_turning(
            terms, k, v, mode, self.laws.solve(terms, mode)
        ):
            return False
        self._turn(t, terms, mode, k)
        return True

    def switch(self, t: float, y: Array, event: Event) -> tuple[Array, list[Occurrence]]:
        """Return the state after the margin of an event passed zero, and what happened."""
        self._at_once = self._at_once + 1 if self._times[-1] == t else 0
        if self._at_once > MOST_AT_ONCE:
            raise IntegrationError(
                f"elements switch without end at t = {t:.9g} s; the last was {event.name!r}", time=t
            )
        assert isinstance(event.when, Margin), "events of corners are margins"
        k, which = event.when.index
        mode = self.mode(t)
        state = mode[k]
        q, v = y[: self._nq], y[self._nq :]
        terms = self.rows.at(q, v, t)
        touching = [self._is_touching(terms, i, mode[i]) for i in range(len(self.elements))]
        forbidden, spent = frozenset[tuple[int, str]](), None
        solution = self.laws.solve(terms, mode)
        if which == 1 and self._is_turning(terms, k, v, mode, solution):
            self._turn(t, terms, mode, k)
            return y, []
        yields = state.name == STICKS if which else state.name != OPEN
        shared = solution is not None and solution.redundant and yields
        shared = shared and self._is_inside(terms, k)
        if not self._at_once:
            self._ended = frozenset()
        if shared or self._ended:
            # which of the elements that share their forces yields is not known beforehand: no
            # mode is tried twice at one instant
            self._ended |= {mode}
        if not shared and which == 0:
            if state.name == OPEN:
                self._refuse_from_beside(terms, k, t, y)
                touching[k] = True
            elif self.elements[k].struck and self._is_inside(terms, k):
                forbidden = frozenset((k, name) for name in self.elements[k].states[1:])
            else:
                touching[k] = False
        elif not shared and state.name == STICKS:
            if any(near and s.name == OPEN for near, s in zip(touching, mode, strict=True)):
                self._ended |= {mode}  # what touches and is open may hold it from here on
                spent = k
            else:
                forbidden = frozenset({(k, STICKS)})
        elif not shared:
            # the slip, which is zero to rounding, is zero, and so is that of contacts beside it
            ended = {k, *self._list_slow_slips(terms, mode, solution, v)}
            stuck = (ElementState(STICKS) if i in ended else s for i, s in enumerate(mode))
            y = self._project(t, y, tuple(stuck))
        begun = self._list_begun(terms, solution, v) - {(k, STICKS)}
        return self._change(t, y, touching, forbidden, spent, begun)

    def _list_begun(
        self, terms: Terms, solution: ModeSolution | None, v: Array
    ) -> frozenset[tuple[int, str]]:
        """Return what began to slip just now and goes on, each with the state that it has left.

        Where several begin at once by symmetry, one and another would stick in turn without end.
        """
        if solution is None:
            return frozenset()
        growth, rounding = find_gains(terms, solution.a, accelerate(terms, self.elements))
        still = self.still_speed(terms, v)
        begun = set[tuple[int, str]]()
        for k, (element, state) in enumerate(zip(self.elements, solution.mode, strict=True)):
            rows = list(element.tangents)
            if not state.direction or state.name == STICKS:
                continue
            grows = growth[rows] @ np.array(state.direction) >= -rounding[rows].max()
            if grows and np.linalg.norm(terms.rates[rows]) <= still:
                begun.add((k, STICKS))
        return frozenset(begun)

    def _is_turning(
        self, terms: Terms, k: int, v: Array, mode: Mode, solution: ModeSolution | None
    ) -> bool:
        """Return whether slip in space goes on in another direction."""
        if mode[k].name != SLIPS or k in self._list_slow_slips(terms, mode, solution, v):
            return False
        slip = terms.rates[list(self.elements[k].tangents)]
        return bool(slip @ np.array(mode[k].direction) > SAME_WAY * np.linalg.norm(slip))

    def _turn(self, t: float, terms: Terms, mode: Mode, k: int) -> None:
        """Go on in a mode with the directions of slip of a state; that of an element has begun."""
        mode = (*mode[:k], replace(mode[k], beginning=False), *mode[k + 1 :])
        self._times.append(t)
        self._modes.append(self._mark_slow_slip(terms, self.laws.along_slip(terms, mode), mode))
        self._present_program = (inf, -inf, None)

    def _list_slow_slips(
        self, terms: Terms, mode: Mode, solution: ModeSolution | None, v: Array
    ) -> list[int]:
        """Return what slips in space no faster than rounding.

        Where contacts of a body share forces, errors of steps turn it as it stops, and what slips
        no faster than these ends with the others.
        """
        shared = solution is not None and solution.redundant
        slow = (self._find_error if shared else self.still_speed)(terms, v)
        return [
            k
            for k, (element, state) in enumerate(zip(self.elements, mode, strict=True))
            if state.name == SLIPS and is_slow(terms, element, slow)
        ]

    def _is_touching(self, terms: Terms, k: int, state: ElementState | None = None) -> bool:
        element, closed = self.elements[k], state is not None and state.name != OPEN
        if element.normal is None:
            return False
        if element.stiffness is not None:
            # as it opens its gap is zero to rounding, of either sign
            return closed or (state is None and bool(terms.gaps[element.normal] < 0))
        near = bool(terms.gaps[element.rows[0]] <= CLOSED_GAP * self.length)
        return closed or (near and self._is_inside(terms, k))

    def _is_inside(self, terms: Terms, k: int) -> bool:
        """Return whether an element is between the ends of its side; always without ends."""
        return bool(terms.inside[k] >= -EVEN * self.length)

    def _refuse_from_beside(self, terms: Terms, k: int, t: float, y: Array) -> None:
        """Refuse what passes an end of a side below it."""
        element = self.elements[k]
        if element.length is None:
            return
        gap = float(terms.gaps[element.rows[0]])
        if gap < -CLOSED_GAP * self.length and terms.inside[k] < -gap:
            raise IntegrationError(
                f"{element.name!r} comes in from beyond an end of its side at t = {t:.9g} s, with "
                f"a gap of {gap:.3g}: its bodies would be one within the other; give the corner in "
                "which the side ends, or the side next to it, a contact of its own",
                time=t,
                state=y,
            )

    def _change(
        self,
        t: float,
        y: Array,
        touching: list[bool],
        forbidden: frozenset[tuple[int, str]],
        spent: int | None = None,
        begun: frozenset[tuple[int, str]] = frozenset(),
    ) -> tuple[Array, list[Occurrence]]:
        """Resolve impacts, then choose the mode that follows; return the state and events.

        What has spent its static friction sticks on only where others take some of it, and what has
        begun to slip only where nothing else follows.
        """
        q, v = y[: self._nq], y[self._nq :].copy()
        before = y[self._nq :]
        terms = self.rows.at(q, v, t)
        still = self.still_speed(terms, v)
        occurrences: list[Occurrence] = []
        approaching = [
            k
            for k, element in enumerate(self.elements)
            if touching[k] and element.struck and terms.rates[element.rows[0]] < -still
        ]

        old = self._modes[-1] if self._modes else ()

        def follow() -> ModeSolution:
            following, error = list[ModeSolution](), self._find_error(terms, v)
            if begun:
                with suppress(InputError):
                    ends = forbidden | begun
                    following = self.laws.follow(terms, touching, still, ends, self._ended, error)
            if not following:
                following = self.laws.follow(terms, touching, still, forbidden, self._ended, error)
            if spent is not None and len(following) > 1:
                following = [
                    s
                    for s in following
                    if s.mode[spent].name != STICKS
                    or self.laws.margins(terms, s.mode, s)[spent, 1] > 0
                ]
            return self._choose(following, t, y)

        if approaching:
            change, pushed = self._decide(t, y, lambda: self.laws.impact(terms, touching, still))
            v = v + change
            terms = self.rows.at(q, v, t)
            # times are found to 1e-13 s: what does not part would be left one within the other
            normals = [self.elements[k].rows[0] for k in approaching]
            q = self._close_gaps(t, q, v, [row for row in normals if terms.rates[row] <= still])
            terms = self.rows.at(q, v, t)
            struck = pushed.union(approaching)
            names = ", ".join(e.name for k, e in enumerate(self.elements) if k in struck)
            occurrences.append(Occurrence(f"{names}: impact", t, q, before, v))
            still = self.still_speed(terms, np.maximum(np.abs(before), np.abs(v)))
            self._ended = frozenset()
        solution = self._decide(t, y, follow)
        if approaching and (ended := self._find_last_bounces(terms, solution, touching, still)):
            # what touches stays together meanwhile
            rows = self.list_rows(solution.mode) + [self.elements[k].rows[0] for k in ended]
            bouncing, step = terms, least_step(terms, rows, terms.rates[rows])
            terms = self.rows.at(q, v + step, t)
            v = v + self.laws.end_bounces(bouncing, self._decide(t, y, follow).mode, step)
            terms = self.rows.at(q, v, t)
            # the energy of the bounces left out is lost by the last one
            occurrences[-1] = replace(occurrences[-1], after=v)
            for k, later in ended.items():
                occurrences.append(Occurrence(f"{self.elements[k].name}: rest", t + later, q, v, v))
            solution = self._decide(t, y, follow)
        mode = solution.mode
        y = self._project(t, np.concatenate([q, v]), mode)
        q, v = y[: self._nq], y[self._nq :]
        self._slow_slip = 0.5 * BEGUN * still  # half, as at the speed itself it has begun
        mode = self._mark_slow_slip(terms, mode, old)
        for k, state in enumerate(mode):
            if old and old[k].name != state.name:
                said = f"{self.elements[k].name}: {state.name}"
                occurrences.append(Occurrence(said, t, q, v, v))
        self._times.append(t)
        self._modes.append(mode)
        self._present_program = (inf, -inf, None)
        return y, occurrences

    def _mark_slow_slip(self, terms: Terms, mode: Mode, old: Mode) -> Mode:
        """Return a mode in which slow slip in space goes along or against its growth.

        It does so as it begins, and where several contacts slip together also as it ends.
        """
        together = _slip_together(mode)
        marked = list(mode)
        for k, (element, state) in enumerate(zip(self.elements, mode, strict=True)):
            begins = state.beginning or together or (old and old[k].beginning)
            if state.name == SLIPS and begins and is_slow(terms, element, self._slow_slip):
                marked[k] = replace(state, beginning=True)
        return tuple(marked)

    def still_speed(self, terms: Terms, v: Array) -> float:
        """Return the speed below which a row's rate is rounding."""
        # where all comes to rest at once, speeds are rounding of those that the loads bring about
        pull = np.abs(terms.jacobian) @ np.abs(np.linalg.solve(terms.mass, terms.load))
        usual = float(np.sqrt(self.length * pull.max(initial=0.0)))
        return max(_rounding(terms, v), STILL * usual) + TINY

    def _find_error(self, terms: Terms, v: Array) -> float:
        """Return the speed below which a row's rate is error of the steps."""
        return self._error * self.still_speed(terms, v)

    def _decide(self, t: float, y: Array, ask: Callable[[], _Answer]) -> _Answer:
        try:
            return ask()
        except UndecidedError as error:
            raise IntegrationError(f"{error}, at t = {t:.9g} s", time=t, state=y) from error

    def _choose(self, solutions: list[ModeSolution], t: float, y: Array) -> ModeSolution:
        if len(solutions) == 1:
            return solutions[0]
        message = (
            f"no mode follows at t = {t:.9g} s: Coulomb's friction of rigid bodies has no "
            "solution here (Painlevé); make a body or a contact elastic, or lower the friction"
        )
        if solutions:
            listed = "; ".join(self.describe(solution.mode) for solution in solutions)
            message = (
                f"{len(solutions)} modes follow at t = {t:.9g} s: {listed}; which of them does is "
                "not decided by rigid bodies with Coulomb's friction"
            )
        raise IntegrationError(message, time=t, state=y)

    def describe(self, mode: Mode) -> str:
        """Return a mode in words."""
        pairs = zip(self.elements, mode, strict=True)
        return ", ".join(f"{element.name} {state.name}" for element, state in pairs)

    def _find_last_bounces(
        self, terms: Terms, solution: ModeSolution, touching: list[bool], still: float
    ) -> dict[int, float]:
        """Return the contacts whose bounces are over, with the time that the rest of these takes.

        Bounces accumulate (chattering, after Zeno): a bounce at speed u takes 2 u/g and the next e
        times that, together 2 u/(g (1 − e)).
        """
        growth = terms.jacobian @ solution.a + terms.gamma
        ended: dict[int, float] = {}
        for k, element in enumerate(self.elements):
            if not (touching[k] and element.struck):
                continue
            row, e = element.rows[0], element.restitution
            speed, fall = float(terms.rates[row]), -float(growth[row])
            if not (e < 1 and speed > still and fall > 0):
                continue
            if speed**2 / (2 * fall) <= TAIL * self.length:
                ended[k] = 2 * speed / (fall * (1 - e))
        return ended

    # afterwards ---------------------------------------------------------------------------------

    def spans(self, end: float) -> tuple[ModeSpan, ...]:
        """Return the modes in order, until a time [s]; those of no length are left out."""
        ends = [*self._times[1:], end]
        spans: list[ModeSpan] = []
        for begin, stop, mode in zip(self._times, ends, self._modes, strict=True):
            pairs = zip(self.elements, mode, strict=True)
            states = {element.name: state.name for element, state in pairs}
            if spans and spans[-1].states == states:
                spans[-1] = replace(spans[-1], end=stop)
            elif stop > begin:
                spans.append(ModeSpan(begin, stop, states))
        return tuple(spans)

    def as_loads(self, curve: Curve) -> Mechanism:
        """Return the mechanism with the forces of its elements along a motion as inputs.

        So all that is known of loads holds of them: reactions, work, momenta.
        """
        m = self.rows.base
        inputs, forces = list(m.inputs), list(m.forces)
        record = _ForceRecord(self, curve)
        taken = {*m.values, *m.coordinates, *(signal.symbol for signal in m.inputs), "t"}

        def add(label: str, unit: str, value: Callable[[float], float]) -> Input:
            symbol = "R_" + "".join(c if c.isalnum() else "_" for c in label)
            while symbol in taken:
                symbol += "_"
            taken.add(symbol)
            signal = Input(symbol, value, unit, label)
            inputs.append(signal)
            return signal

        known = {force.name for force in forces}
        for element in self.elements:
            source = element.element
            name = source.name
            while name in known:
                name += "_"
            known.add(name)
            if isinstance(source, Contact):
                moved = [body for body in (source.body, source.on) if body != m.ground]
                for body, kind in product(moved, _KINDS if element.tangents else _KINDS[:1]):
                    label = f"{name}, {kind}" if len(moved) == 1 else f"{name} on {body}, {kind}"
                    on_source = body == source.body
                    # a point has no lever, and the normal of a ball passes through its center
                    centered = kind == "normal" and source.axis is None
                    held = not on_source or not (source.radius == 0 or centered)
                    signals = []
                    for k, letter in enumerate(_LETTERS if held else _LETTERS[:3]):
                        value = ElementForce(record, (element.name, body, kind), k)
                        signals.append(add(f"{label} {letter}", "N" if k < 3 else "N·m", value))
                    x, y, z, *turn = signals
                    px, py, pz = source.center if on_source else (0.0, 0.0, 0.0)
                    forces.append(Force(label, body, (px, py, pz), (x, y, z)))
                    if held:
                        forces.append(Torque(f"{label}, moment", body, (turn[0], turn[1], turn[2])))
                continue
            rows = [row for row in (element.normal, *element.tangents) if row is not None]
            shares: dict[str, dict[int, float]] = {}
            for row, stated in zip(rows, source.joint_rows, strict=True):
                for joint_name, weight in stated.weights:
                    shares.setdefault(joint_name, {})[row] = weight
            for joint_name, weights in shares.items():
                joint = m.joint(joint_name)
                assert isinstance(joint, Single), "validated"
                unit = "N·m" if joint.turns else "N"
                label = name if len(shares) == 1 else f"{name} on {joint_name}"
                signal = add(label, unit, ElementForce(record, weights))
                forces.append(JointForce(label, joint_name, signal))
        return replace(m, inputs=tuple(inputs), forces=tuple(forces))


@final
class _ForceRecord:
    """The forces of elements along a motion, kept for the times that were asked for."""

    def __init__(self, corners: Corners, curve: Curve) -> None:
        self._corners = corners
        self._curve = curve
        self._known: dict[float, tuple[Array, dict[tuple[str, str, str], Array]]] = {}
        self._presses = any(isinstance(e.element, Contact) for e in corners.elements)

    def at(self, t: float) -> tuple[Array, dict[tuple[str, str, str], Array]]:
        """Return the forces along rows, and the wrenches of contacts, at a time."""
        known = self._known.get(t)
        if known is None:
            corners, state = self._corners, self._curve(t)
            forces = corners.forces(t, state.q, state.v)[1]
            wrenches = corners.rows.contact_wrenches(state.q, t, forces) if self._presses else {}
            if len(self._known) >= MOST_KEPT:
                self._known.clear()
            known = self._known[t] = forces, wrenches
        return known


@final
@dataclass(frozen=True, eq=False)
class ElementForce:
    """A force along a motion, which lives with the motion that it is computed from."""

    record: _ForceRecord = field(repr=False)
    source: Mapping[int, float] | tuple[str, str, str]  # weights of rows, or a contact's wrench
    part: int = 0  # of the wrench

    def __call__(self, t: float) -> float:
        """Return the force."""
        forces, wrenches = self.record.at(t)
        if isinstance(self.source, tuple):
            return float(wrenches[self.source][self.part])
        return float(sum(weight * forces[row] for row, weight in self.source.items()))

    def __reduce__(self) -> NoReturn:
        raise InputError(
            "a motion with elements that switch computes their forces as they are asked for, and "
            "is not pickled; expected motion.save(path), which keeps its samples"
        )


def _slip_together(mode: Mode) -> bool:
    """Return whether several contacts slip in space, which errors of steps turn as they stop."""
    return sum(state.name == SLIPS for state in mode) > 1


def _are_close(ours: Sequence[Array], theirs: Sequence[Array]) -> bool:
    """Return whether a program's arrays are those of the engine."""
    return all(
        np.allclose(a, b, rtol=SAME_PROGRAM, atol=SAME_PROGRAM * np.abs(b).max(initial=0.0))
        for a, b in zip(ours, theirs, strict=True)
    )


def _rounding(terms: Terms, v: Array) -> float:
    """Return the speed below which rates of rows are rounding of the velocities."""
    size = np.abs(terms.jacobian) @ np.abs(v) + np.abs(terms.drift)
    return STILL * float(size.max(initial=0.0))


def least_step(terms: Terms, rows: list[int], gaps: Array) -> Array:
    """Return the least change of velocities, by kinetic energy, that takes away rates of rows."""
    J = terms.jacobian[rows]
    response = np.linalg.solve(terms.mass, J.T)
    system = J @ response
    scale = np.sqrt(np.abs(np.diag(system)))
    scale[scale == 0] = 1.0
    inverse = np.linalg.pinv(system / np.outer(scale, scale), rcond=REDUNDANT)
    step: Array = -response @ ((inverse @ (gaps / scale)) / scale)
    return step
