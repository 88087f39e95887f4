"""What a page needs to compute a motion with corners: the program of every mode and impact.

The law of modes is written on the tape that their equations are solved on, and so are the margins
that end a mode and those by which it is one that may follow; the page compares numbers with zero.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from itertools import product
from math import prod
from typing import Any, final

import numpy as np

from mecanique.derivation.mechanics.letters import Letters
from mecanique.derivation.mechanics.switching import (
    OPEN,
    STICKS,
    ElementRows,
    ElementState,
    Mode,
    ModeProblem,
    Scalars,
    Terms,
    accelerate,
    as_scalars,
    close_contacts,
    hold,
    list_margins,
    list_present_margins,
    name_mode,
    strike,
)
from mecanique.derivation.mechanics.vectors import Triple, add, cross, scale
from mecanique.derivation.tolerances import REDUNDANT, SWITCHING
from mecanique.errors import DerivationError, MecaniqueError
from mecanique.generation.build import assemble
from mecanique.generation.mechanics.constrained import inputs_at
from mecanique.generation.mechanics.dynamics import TapeDynamics
from mecanique.generation.mechanics.switching import SwitchingEquations
from mecanique.generation.program import Answer, Program, ProgramInput
from mecanique.model import Contact, Mechanism
from mecanique.model.states import States
from mecanique.motion.motion import Motion
from mecanique.motion.switching.corners import Corners, ElementForce
from mecanique.motion.switching.law import solve
from mecanique.motion.tolerances import TINY
from mecanique.program.evaluation import evaluate
from mecanique.program.traced import trace, values_of
from mecanique.verification.states import random_states
from mecanique.viewing.scene.scene import PageElement, PageModes

MOST_MODES = 64
"""More modes than this, of those that rigid bodies determine, make a long program."""

MOST_CHOICES = 256
"""Among more combinations of states it would be long looked for these."""

_STATES = 8
"""Random states in which it is found which modes rigid bodies determine."""

_SAME = 1e-8
"""Largest difference, relative to the largest force, from the forces of a motion's own modes."""


_IMPULSE = "impulse of "
"""What impulses are called on the tape, before the name of their element."""

_FREE = 1e-6
"""Part of a row that others leave free, above rounding."""


@final
class PageCorners:
    """The modes of a motion's mechanism on a tape.

    Raises:
        DerivationError: if they are not written out for a page.
    """

    def __init__(self, motion: Motion, symbols: Sequence[str]) -> None:
        corners = motion.corners
        assert isinstance(corners, Corners), "it has elements that switch"
        self._motion, self._corners = motion, corners
        self.mechanism: Mechanism = motion.described
        _refuse(corners)
        letters = self.letters = Letters(close_contacts(self.mechanism), symbols)
        self._equations = SwitchingEquations(
            self.mechanism, letters, corners.rows.idle.__contains__
        )
        self.elements = self._equations.elements
        self._forces = [
            signal.signal
            for signal in motion.mechanism.inputs
            if isinstance(signal.signal, ElementForce)
        ]
        struck = [element for element in self.elements if element.struck]
        self._modes = list(_combine_sticking(self.elements))
        together = struck if len(struck) > 1 else []
        self._strikes = list(_combine(self.elements, together))
        self._expansions = list(_combine(self.elements, [e for e in together if e.by_impulse]))
        self._given: dict[int, Any] = {}
        for element in struck:
            assert element.normal is not None, "it is struck"
            impulse = letters.tape.input(f"{_IMPULSE}{element.name}")
            self._given[element.normal] = trace(letters.tape, impulse)
        self._samples: dict[frozenset[str], States | None] = {}

    def program(self, answers: Sequence[Answer]) -> Program:
        """Return the program of answers; impulses stand in the place of the elements' forces."""
        program = assemble(self.dynamics, "page", answers)
        names = [f"{_IMPULSE}{element.name}" for element in self.elements if element.struck]
        impulses = [ProgramInput(f"impulse{k}", name, "N·s") for k, name in enumerate(names)]
        letters = {**program.letters, "p": (*program.letters["p"], *impulses)}
        return replace(program, letters=letters)

    @property
    def dynamics(self) -> TapeDynamics:
        """The dynamics of the tree with its contacts closed, by which programs are assembled."""
        tree = self._equations.tree
        return TapeDynamics(self.letters, tree, tree, "closed form of each mode")

    def functions(self) -> tuple[dict[str, list[Any]], PageModes]:
        """Return what the page evaluates, by name, and what it must know of that."""
        modes = [mode for mode in self._modes if self._is_determined(mode, struck=False)]
        strikes = [mode for mode in self._strikes if self._is_determined(mode, struck=True)]
        if len(modes) > MOST_MODES:
            raise DerivationError(
                f"{len(modes)} modes are more than the {MOST_MODES} that a page has"
            )
        expansions = [
            mode
            for mode in self._expansions
            if self._is_determined(mode, struck=True, expands=True)
        ]
        written = [self._write_mode(mode) for mode in modes]
        self._compare(modes, written)
        functions = {"rows": self._write_rows()}
        functions |= {f"mode{k}": values for k, values in enumerate(written)}
        functions |= {
            f"impact{k}": self._take(*self._equations.bounce(element.name))
            for k, element in enumerate(self.elements)
            if element.struck
        }
        functions |= {f"strike{k}": self._write_strike(mode) for k, mode in enumerate(strikes)}
        functions |= {
            f"expansion{k}": self._write_strike(mode, self._given)
            for k, mode in enumerate(expansions)
        }
        listed = tuple(
            PageElement(
                element.name,
                element.normal,
                element.tangents[0] if element.tangents else None,
                struck=element.struck,
                in_turn=element.in_turn,
                by_impulse=element.by_impulse,
                ends=element.length is not None,
            )
            for element in self.elements
        )
        return functions, PageModes(
            elements=listed,
            modes=tuple(map(_name, modes)),
            kept=tuple(map(_find_kept, modes)),
            strikes=tuple(map(_name, strikes)),
            expansions=tuple(map(_name, expansions)),
            positional=tuple(self._corners.rows.positional.tolist()),
            forces=len(self._forces),
            length=self._corners.length,
            tolerances=SWITCHING,
        )

    def _write_rows(self) -> list[Any]:
        """Gaps, rates, J and M⁻¹Jᵀ of all rows, M⁻¹ of the load, T, numbers of each element."""
        terms = self._equations.driven
        free = self._equations.by_mass(list(terms.load))
        numbers = [
            [element.restitution for element in self.elements],
            [element.holds for element in self.elements],
            terms.static - terms.kinetic,
            terms.inside,
        ]
        of_elements = [x for of_element in zip(*numbers, strict=True) for x in of_element]
        slopes = [slope for row in terms.jacobian for slope in row]
        steps = [part for row in terms.jacobian for part in self._equations.by_mass(list(row))]
        v = as_scalars(self.letters.v)
        rows = [*terms.gaps, *terms.rates, *slopes, *steps]
        return [*rows, *free, 0.5 * (v @ terms.mass @ v), *of_elements]

    def _write_mode(self, mode: Mode) -> list[Any]:
        """Accelerations, forces as the page's inputs, heat, margins and what is presupposed."""
        terms = self._equations.driven
        drive = accelerate(terms, self.elements)
        a, forces = self._equations.solve(mode, drive)
        margins = list_present_margins(terms, self.elements, mode, forces, self._equations.length)
        rubbing = [element.tangents for element in self.elements if element.tangents]
        heat = [-1.0 * forces[rows[0]] * terms.rates[rows[0]] for rows in rubbing]  # in a plane
        signals = [self._press(force, forces) for force in self._forces]
        return [
            *a,
            *signals,
            *heat,
            *np.ravel(np.array(margins, dtype=object)),
            *self._presuppose(mode, drive, a, forces),
            sum(map(self._equations.length, terms.load), 0.0),
        ]

    def _write_strike(self, mode: Mode, given: Mapping[int, Any] | None = None) -> list[Any]:
        """Changes of velocities, the energy that each element takes, and what is presupposed.

        Impulses of normals are given in the expansion of Poisson's law.
        """
        terms, elements = self._equations.terms, self.elements
        targets = {
            element.normal: 0.5 * element.restitution * (self._equations.length(rate) - rate)
            for element in elements
            if element.normal is not None and element.struck and not element.by_impulse
            for rate in (terms.rates[element.normal],)
        }
        drive = strike(terms, targets, elements, given)
        solved = self._equations.solve(mode, drive)
        return [*self._take(*solved), *self._presuppose(mode, drive, *solved)]

    def _take(self, change: Scalars, impulses: Scalars) -> list[Any]:
        """Return changes of velocities, and the energy that each element takes."""
        between = as_scalars(self.letters.v) + 0.5 * change
        works = impulses * (self._equations.terms.jacobian @ between)
        return [*change, *(-1.0 * sum(works[list(e.rows)], 0.0) for e in self.elements)]

    def _presuppose(
        self, mode: Mode, drive: ModeProblem, a: Scalars, forces: Scalars
    ) -> Iterator[Any]:
        """Yield two margins of each element, then the sizes of what is compared in them.

        The margins are what the rows gain by and the forces have left, `law.Laws.follow`.
        """
        terms, length = self._equations.terms, self._equations.length
        gained = terms.jacobian @ a - drive.wanted
        limits = drive.sticking, drive.holds
        left = list_margins(self.elements, mode, (gained, gained), forces, limits, length)
        yield from np.ravel(np.array(left, dtype=object))
        free = self._equations.by_mass(list(drive.load))
        moved = [length(x) + length(y) for x, y in zip(a, free, strict=True)]
        for element in self.elements:
            for row in (element.normal, next(iter(element.tangents), None)):
                if row is None:
                    yield 0.0
                else:
                    slopes = map(length, terms.jacobian[row])
                    along = sum(s * x for s, x in zip(slopes, moved, strict=True))
                    yield along + length(drive.wanted[row])
        yield sum(map(length, forces), 0.0)

    def _press(self, force: ElementForce, forces: Scalars) -> Any:
        """Return a component of an element's force on a body, by the forces along rows."""
        if not isinstance(force.source, tuple):
            return sum(weight * forces[row] for row, weight in force.source.items())
        name, body, kind = force.source
        pull: Triple = [0.0, 0.0, 0.0]
        place: Triple = pull
        for k, row in enumerate(self._equations.contacts):
            contact, _, which = row.name.rpartition(": ")
            if contact == name and (which == "normal") == (kind == "normal"):
                assert row.direction is not None, "a contact's row has one"
                pull, place = add(pull, scale(forces[k], row.direction)), row.place or place
        source = next(e for e in self.mechanism.switching if e.name == name)
        assert isinstance(source, Contact), "it has a wrench"
        center = source.center if body == source.body else (0.0, 0.0, 0.0)
        about = self._equations.tree.recursion.ground.point(body, center)
        moment = cross(add(place, scale(-1.0, about)), pull)
        sign = 1.0 if body == source.body else -1.0
        return sign * (*pull, *moment)[force.part]

    def _is_determined(self, mode: Mode, *, struck: bool, expands: bool = False) -> bool:
        """Return whether rigid bodies determine the forces of a mode, by sampled states."""
        rows, elements = self._corners.rows, self._corners.elements
        held = [e.name for e, state in zip(elements, mode, strict=True) if state.name != OPEN]
        states = self._sample(frozenset(held))
        if states is None:
            return False
        for state in zip(states.q, states.v, states.t.tolist(), strict=True):
            terms = rows.at(*state)
            given = dict.fromkeys(self._given, 1.0) if expands else None
            drive = strike(terms, {}, elements, given) if struck else accelerate(terms, elements)
            if not struck and not _leaves_slip(terms, elements, mode, drive):
                continue
            solution = solve(terms, elements, mode, drive)
            if solution is not None and not solution.redundant:
                return True
        return False

    def _sample(self, held: frozenset[str]) -> States | None:
        """Return states in which the contacts held are closed; None if they are not at once."""
        if held not in self._samples:
            held_alone = [element for element in self.mechanism.switching if element.name in held]
            closed = close_contacts(replace(self.mechanism, switching=tuple(held_alone)))
            try:
                self._samples[held] = random_states(closed, _STATES, 0)
            except MecaniqueError:
                self._samples[held] = None
        return self._samples[held]

    def _compare(self, modes: Sequence[Mode], values: Sequence[list[Any]]) -> None:
        """Compare the forces of modes with those of the motion in the middle of each span."""
        motion, nv = self._motion, self.mechanism.nv
        for span in motion.modes:
            named = tuple(span.states[element.name] for element in self.elements)
            for mode, written in zip(modes, values, strict=True):
                if _name(mode) != named or _find_kept(mode):
                    continue
                t = (span.begin + span.end) / 2
                at = motion(t)
                here = States(
                    self.letters.mechanism, at.q[None], at.v[None], np.array([t]), at.v[None]
                )
                inputs = inputs_at(self.letters, here)
                signals = values_of(written[nv : nv + len(self._forces)])
                (ours,) = evaluate(self.letters.tape, signals, inputs, 1)
                theirs = np.array([force(t) for force in self._forces])
                gap = float(np.abs(ours - theirs).max(initial=0.0))
                if not gap <= _SAME * float(np.abs(theirs).max(initial=TINY)):
                    raise DerivationError(
                        f"the program gives other forces in the mode {', '.join(named)} than the "
                        f"motion, by {gap:.1e}"
                    )


def _combine(elements: Sequence[ElementRows], moving: Sequence[ElementRows]) -> Iterator[Mode]:
    """Yield every mode of some elements, the others being open, in which one is not."""
    for states in product(*(element.states for element in moving)):
        named = {element.name: state for element, state in zip(moving, states, strict=True)}
        if {*states} - {OPEN}:
            yield name_mode(elements, named)


def _combine_sticking(elements: Sequence[ElementRows]) -> Iterator[Mode]:
    """Yield every mode, also those in which what sticks uses all of its static friction."""
    choices: list[list[ElementState]] = []
    for element in elements:
        states = [name_mode([element], {element.name: name})[0] for name in element.states]
        choices.append(states + [replace(s, name=STICKS) for s in states if s.direction])
    yield from product(*choices)


def _find_kept(mode: Mode) -> tuple[int, ...]:
    """Return the elements that use all of their static friction."""
    return tuple(k for k, state in enumerate(mode) if _is_kept(state))


def _is_kept(state: ElementState) -> bool:
    return state.name == STICKS and bool(state.direction)


def _leaves_slip(
    terms: Terms, elements: Sequence[ElementRows], mode: Mode, drive: ModeProblem
) -> bool:
    """Return whether what slips in a mode may do so, and what is kept from slipping may not."""
    held = terms.jacobian[hold(terms, elements, mode, drive).rows]
    spanned = np.linalg.pinv(held, rcond=REDUNDANT) @ held
    for element, state in zip(elements, mode, strict=True):
        if state.direction:
            row = terms.jacobian[element.tangents[0]]
            free = np.linalg.norm(row - spanned @ row) > _FREE * np.linalg.norm(row)
            if free == _is_kept(state):
                return False
    return True


def _name(mode: Mode) -> tuple[str, ...]:
    return tuple(state.name for state in mode)


def _refuse(corners: Corners) -> None:
    """Refuse elements that a page does not switch."""
    if corners.rows.permanent:
        raise DerivationError("a page does not switch elements beside loops and rolling")
    count = prod(len(element.states) for element in corners.elements)
    if count > MOST_CHOICES:
        raise DerivationError(f"{count} modes are more than a page looks through, {MOST_CHOICES}")
    for element in corners.elements:
        if len(element.tangents) > 1:
            raise DerivationError(f"{element.name!r} slips in space, whose direction is sought")
