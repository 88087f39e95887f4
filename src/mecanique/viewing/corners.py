"""What a page needs to compute a motion with corners: the terms of a state.

Its scripts have the law by which modes are solved and follow each other, and that of impacts.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from math import prod
from typing import Any, final

import numpy as np

from mecanique.derivation.mechanics.letters import Letters
from mecanique.derivation.mechanics.switching import as_scalars, close_contacts
from mecanique.derivation.mechanics.vectors import Triple, add, cross, scale
from mecanique.derivation.tolerances import SWITCHING
from mecanique.errors import DerivationError
from mecanique.generation.build import assemble
from mecanique.generation.mechanics.constrained import inputs_at
from mecanique.generation.mechanics.dynamics import TapeDynamics
from mecanique.generation.mechanics.switching import SwitchingEquations
from mecanique.generation.program import Answer, Program, ProgramInput
from mecanique.model import Contact, Mechanism
from mecanique.model.states import States
from mecanique.motion.motion import Motion
from mecanique.motion.switching.corners import Corners, ElementForce
from mecanique.motion.tolerances import TINY
from mecanique.program.evaluation import evaluate
from mecanique.program.traced import trace, values_of
from mecanique.viewing.scene.scene import PageElement, PageModes

MOST_MODES = 256
"""Among more combinations of states it would be long looked for rests."""

_SAME = 1e-8
"""Largest difference, relative to the largest of its kind, from terms and forces of a motion."""

_FORCE = "force of row "
"""What the forces along rows are called on the tape, before the number of their row."""


@final
class PageCorners:
    """The terms of a motion's mechanism on a tape.

    Raises:
        DerivationError: if a page does not switch the elements, or its terms are not the engine's.
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
        self._forces = [
            signal.signal
            for signal in motion.mechanism.inputs
            if isinstance(signal.signal, ElementForce)
        ]
        self._names = [f"{_FORCE}{k}" for k, _ in enumerate(self._equations.terms.gaps)]
        self._pushes = as_scalars(
            trace(letters.tape, letters.tape.input(name)) for name in self._names
        )

    def program(self, answers: Sequence[Answer]) -> Program:
        """Return the program of answers; forces along rows replace those on bodies."""
        program = assemble(self.dynamics, "page", answers)
        pushes = [ProgramInput(f"force{k}", name, "N") for k, name in enumerate(self._names)]
        letters = {**program.letters, "p": (*program.letters["p"], *pushes)}
        return replace(program, letters=letters)

    @property
    def dynamics(self) -> TapeDynamics:
        """The dynamics of the tree with its contacts closed, by which programs are assembled."""
        tree = self._equations.tree
        return TapeDynamics(self.letters, tree, tree, "closed form of each mode")

    def functions(self) -> tuple[dict[str, list[Any]], PageModes]:
        """Return what the page evaluates, by name, and what it must know of that."""
        terms, elements = self._equations.list_terms(), self._equations.elements
        pressed = [self._press(force) for force in self._forces]
        self._compare(terms, pressed)
        functions = {"terms": terms, "press": pressed}
        functions |= {
            f"impact{k}": list(np.concatenate(self._equations.bounce(element.name)))
            for k, element in enumerate(elements)
            if element.struck and len(element.tangents) < 2  # in space its friction is asked for
        }
        listed = tuple(
            PageElement(
                element.name,
                element.normal,
                element.tangents,
                element.pressing,
                struck=element.struck,
                in_turn=element.in_turn,
                by_impulse=element.by_impulse,
                ends=element.length is not None,
            )
            for element in elements
        )
        return functions, PageModes(
            elements=listed,
            positional=tuple(self._corners.rows.positional.tolist()),
            forces=len(self._forces),
            length=self._corners.length,
            tolerances=SWITCHING,
        )

    def _press(self, force: ElementForce) -> Any:
        """Return a component of an element's force on a body, by the forces along rows."""
        if not isinstance(force.source, tuple):
            return sum(weight * self._pushes[row] for row, weight in force.source.items())
        name, body, kind = force.source
        pull: Triple = [0.0, 0.0, 0.0]
        place: Triple = pull
        for k, row in enumerate(self._equations.contacts):
            contact, _, which = row.name.rpartition(": ")
            if contact == name and (which == "normal") == (kind == "normal"):
                assert row.direction is not None, "a contact's row has one"
                pull, place = add(pull, scale(self._pushes[k], row.direction)), row.place or place
        source = next(e for e in self.mechanism.switching if e.name == name)
        assert isinstance(source, Contact), "it has a wrench"
        center = source.center if body == source.body else (0.0, 0.0, 0.0)
        about = self._equations.tree.recursion.ground.point(body, center)
        moment = cross(add(place, scale(-1.0, about)), pull)
        sign = 1.0 if body == source.body else -1.0
        return sign * (*pull, *moment)[force.part]

    def _compare(self, terms: Sequence[Any], pressed: Sequence[Any]) -> None:
        """Compare terms and forces with those of the motion in the middle of each span."""
        motion, letters = self._motion, self.letters
        for span in motion.modes:
            t = (span.begin + span.end) / 2
            at, states = motion(t), ", ".join(span.states.values())
            if self._corners.shares_friction(t, at.q, at.v):
                raise DerivationError(
                    f"contacts share static friction in the mode {states}, which a page does not "
                    "divide among them"
                )
            here = States(letters.mechanism, at.q[None], at.v[None], np.array([t]), at.v[None])
            known, forces = self._corners.forces(t, at.q, at.v)
            inputs = inputs_at(letters, here) | dict(zip(self._names, forces, strict=True))
            (ours,) = evaluate(letters.tape, values_of([*pressed, *terms[len(at.q) :]]), inputs, 1)
            along, free = np.abs(known.jacobian), np.linalg.solve(known.mass, known.load)
            acting = np.array([force(t) for force in self._forces])
            speeds = along @ np.abs(at.v)
            pulls = along @ np.abs(free) + speeds**2 / self._corners.length
            for name, theirs, sizes in (
                ("forces", acting, acting),
                ("masses", known.mass, known.mass),
                ("loads", known.load, known.load),
                ("slopes", known.jacobian, along),
                ("accelerations of rows", known.gamma, pulls),
                ("gaps", known.gaps, self._corners.length),
                ("rates", known.rates, speeds),
            ):
                part, ours = np.split(ours, [theirs.size])
                gap = float(np.abs(part - theirs.ravel()).max(initial=0.0))
                if not gap <= _SAME * float(np.abs(sizes).max(initial=TINY)):
                    raise DerivationError(
                        f"the program gives other {name} in the mode {states} than the motion, by "
                        f"{gap:.1e}"
                    )


def _refuse(corners: Corners) -> None:
    """Refuse elements that a page does not switch."""
    if corners.rows.permanent:
        raise DerivationError("a page does not switch elements beside loops and rolling")
    count = prod(len(element.states) for element in corners.elements)
    if count > MOST_MODES:
        raise DerivationError(f"{count} modes are more than a page looks through, {MOST_MODES}")
