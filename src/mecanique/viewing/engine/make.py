"""Make the engine of a page from a motion, and compare it with what Pinocchio gave."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace
from math import floor, log10
from typing import Any, final

import numpy as np

from mecanique.arrays import spread
from mecanique.derivation.equations import Equations
from mecanique.errors import DerivationError
from mecanique.generation.build import assemble
from mecanique.generation.mechanics.constrained import inputs_at
from mecanique.generation.mechanics.dynamics import Dynamics, dynamics_of
from mecanique.generation.program import Answer, Letter, Program
from mecanique.generation.quantities import QUANTITIES, Quantity
from mecanique.generation.targets.javascript import functions
from mecanique.model.mechanism import Mechanism
from mecanique.model.meshing.teeth import visuals_of
from mecanique.model.states import States
from mecanique.motion.record.motion import Motion
from mecanique.motion.simulation.watching.validity import margins_along
from mecanique.program.evaluation import evaluate
from mecanique.program.traced import value_of, values_of
from mecanique.verification.states.random import random_states
from mecanique.viewing.engine.agreement import TOLERANCE, find_unknown
from mecanique.viewing.engine.bounds import bounds_of, gradients_of, is_cut_short, options_of
from mecanique.viewing.engine.columns import WORK, Columns, sizes_of
from mecanique.viewing.engine.conditions import conditions_of
from mecanique.viewing.scene.engine import Engine, Resized
from mecanique.viewing.scene.naming import name_arrows
from mecanique.viewing.scene.scene import Floats, Scene

MOST_LETTERS = 400_000
"""Longest program that a page takes along [characters]; compressed it is a fifth of that."""

MOST_VELOCITIES = 12
"""Programs of larger mechanisms would take long to write, and longer than this to read."""

RTOL, LOOPS_RTOL = 1e-9, 1e-8
"""Relative tolerances of a step that a page begins with; with loops a step uses a tenth of it."""

_STATES = 12
"""Number of random states at which a force that never acts is recognized."""

_FAINT = 1e-9

_TAKES = ("t", "y", "tau")


@final
class Maker:
    """Makes the engine of a motion's page.

    Args:
        motion: what was simulated.
        equations: the equations of motion of its mechanism.

    Raises:
        DerivationError: if there is no program of reasonable length.
    """

    def __init__(self, motion: Motion, equations: Equations) -> None:
        self._motion = motion
        self._mechanism = mechanism = motion.mechanism
        refuse(mechanism)
        symbols = (*mechanism.values, *(signal.symbol for signal in mechanism.inputs))
        self._dynamics: Dynamics = dynamics_of(equations, symbols)
        self._columns = Columns(self._dynamics)

    def thin(self, scene: Scene) -> Scene:
        """Return a complete scene without the forces and moments that never act.

        Args:
            scene: with every arrow.
        """
        acting = self._acting()

        def acts(name: str, values: Floats) -> bool:
            return acting.get(name, bool(np.abs(values).max(initial=0.0) > _FAINT))

        return replace(
            scene,
            arrows=tuple(arrow for arrow in scene.arrows if acts(arrow.name, arrow.vector)),
            series=tuple(
                each
                for each in scene.series
                if each.group != "Reactions" or acts(each.name, each.values)
            ),
        )

    def make(self, scene: Scene, python: str = "") -> Engine:
        """Return the engine of a scene.

        Args:
            scene: what the page shows.
            python: text of the Python that makes the mechanism.

        Raises:
            DerivationError: if the program is too long, or does not give the scene's motion.
        """
        motion, mechanism = self._motion, self._mechanism
        columns = self._columns.row(scene)
        known = [0.0 if column is None else column for column in columns]
        chosen = spread(len(motion.t), 40)
        numbers = self._evaluate(known, chosen)
        unknown = find_unknown(scene, numbers, chosen, [column is None for column in columns])
        resized = list(self._find_resized())
        shapes = [entry for _, entries in resized for entry in entries]
        answers = [
            self._answer("rates", self._columns.rates),
            self._answer("row", known),
            self._answer("shapes", shapes),
        ]
        if mechanism.constrained:
            answers.append(self._answer("closure", self._columns.closure()))
        bounds = bounds_of(motion, self._dynamics.letters)
        if bounds:
            answers.append(self._answer("bounds", [x for _, pair in bounds for x in pair]))
        conditions = conditions_of(self._dynamics.letters)
        if conditions:
            answers.append(self._answer("rules", [x for _, each in conditions for x in each]))
        gradients = gradients_of(motion, self._dynamics.letters)
        if gradients:
            answers.append(self._answer("gradients", gradients))
        margins = self._margins(chosen)
        if margins:
            answers.append(self._answer("margins", [x for each in margins.values() for x in each]))
        text = "\n".join(functions(self._program(answers)))
        if len(text) > MOST_LETTERS:
            raise DerivationError(f"the program would take {len(text) // 1000} kB")
        names = ", ".join(answer.quantity.name for answer in answers)
        closing = self._dynamics.loops.residual if mechanism.constrained else []
        return Engine(
            script=f'"use strict";\n{text}\nglobalThis.mecaniqueProgram = {{ {names} }};\n',
            coordinates=tuple(mechanism.coordinates),
            velocities=tuple(mechanism.velocities),
            parameters=tuple(self._dynamics.letters.open),
            values=tuple(value_at(mechanism, name) for name in self._dynamics.letters.open),
            start=tuple(map(float, (*motion.q[0], *motion.v[0]))),
            first=float(motion.t[0]),
            duration=_duration(motion),
            rtol=LOOPS_RTOL if mechanism.constrained else RTOL,
            quaternions=tuple(at[0] for _, at in mechanism.quaternions),
            loops=len(closing),
            restrained=tuple(k for k, gap in enumerate(closing) if gap == 0.0),
            unknown=unknown,
            resized=tuple(shape for shape, _ in resized),
            bounds=tuple(bound for bound, _ in bounds),
            conditions=tuple(condition for condition, _ in conditions),
            holding=tuple(margins),
            python=python,
            options=tuple(options_of(motion)),
        )

    def proof(self) -> Program:
        """Return the part of the program that Pinocchio knows the answers of."""
        mechanism = self._mechanism
        names = ["rhs", "energy", "poses", *(["closure"] if mechanism.constrained else [])]
        answers = []
        for name in names:
            values = tuple(self._dynamics.answer(name))
            answers.append(Answer(QUANTITIES[name], values, (len(values),)))
        return assemble(self._dynamics, "page", answers)

    def _margins(self, chosen: np.ndarray) -> dict[str, tuple[Any, Any, Any]]:
        """What contacts and cords have left, where the program gives it as the reference does."""
        margins = self._columns.margins()
        if not margins:
            return {}
        motion = self._motion
        numbers = self._evaluate([x for each in margins.values() for x in each], chosen)
        a, b, c = np.moveaxis(numbers.reshape(len(chosen), -1, 3), 2, 0)
        known = margins_along(
            motion.reference, motion.q[chosen], motion.v[chosen], motion.t[chosen]
        )
        gaps = np.abs(a - np.hypot(b, c) - known).max(axis=0)
        near = gaps <= TOLERANCE * np.abs(known).max(axis=0)  # not where they are undetermined
        return {
            name: each for (name, each), same in zip(margins.items(), near, strict=True) if same
        }

    def _answer(self, name: str, scalars: Sequence[Any]) -> Answer:
        values = tuple(values_of(scalars))
        return Answer(Quantity(name, name, _TAKES, ""), values, (len(values),))

    def _program(self, answers: Sequence[Answer]) -> Program:
        program = assemble(self._dynamics, "page", answers)
        letters = dict(program.letters)
        letters["v"] = (*letters["v"], Letter("work", WORK, "J"))
        # torques are named after velocities; none drives the work
        letters["tau"] = (*letters["tau"], Letter("work", f"tau {WORK}"))
        return replace(program, letters=letters)

    def _evaluate(self, scalars: Sequence[Any], chosen: np.ndarray) -> np.ndarray:
        """Numbers along the motion, shape (chosen, scalars)."""
        motion, letters = self._motion, self._dynamics.letters
        t, q, v = motion.t[chosen], motion.q[chosen], motion.v[chosen]
        states = States(self._mechanism, q, v, t, motion.a[chosen])
        inputs = inputs_at(letters, states) | {WORK: motion.energy().work[chosen]}
        return evaluate(letters.tape, values_of(scalars), inputs, len(chosen))

    def _acting(self) -> dict[str, bool]:
        """Whether each arrow and each component of a reaction is ever nonzero, by name."""
        vectors: dict[str, Sequence[Any]] = {}
        for name, action, unit in name_arrows(self._columns.shown):
            vectors[name] = action.force if unit == "N" else action.moment
        vectors |= {name: (x, 0.0, 0.0) for name, x in self._columns.reactions().items()}
        letters = self._dynamics.letters
        states = random_states(self._mechanism, _STATES, 0)
        scalars = [component for vector in vectors.values() for component in vector]
        numbers = evaluate(
            letters.tape, values_of(scalars), inputs_at(letters, states), len(states)
        )
        sizes = np.abs(numbers).reshape(len(states), -1, 3).max(axis=(0, 2))
        least = _FAINT * sizes.max(initial=0.0)
        return dict(zip(vectors, (sizes > least).tolist(), strict=True))

    def _find_resized(self) -> Iterator[tuple[Resized, list[Any]]]:
        """Shapes that depend on a parameter, with size and place on the tape."""
        drawn = visuals_of(self._mechanism)
        for k, body in enumerate(self._mechanism.bodies):
            solids = [visual for visual in drawn[body.name] if sizes_of(visual)]
            for j, visual in enumerate(solids):
                entries = self._columns.shape(visual)
                if any(isinstance(value_of(entry), int) for entry in entries):
                    size = tuple(map(float, self._mechanism.evaluate_all(sizes_of(visual))))
                    yield Resized(k, j, size), entries


def refuse(mechanism: Mechanism) -> None:
    """Refuse a mechanism for which a page cannot have a program.

    Raises:
        DerivationError: saying why.
    """
    if mechanism.nv > MOST_VELOCITIES:
        raise DerivationError(f"a program for {mechanism.nv} velocities would be too long")
    for signal in mechanism.inputs:
        if callable(signal.signal):
            raise DerivationError(f"input {signal.symbol!r} is a function of Python")


def value_at(mechanism: Mechanism, symbol: str) -> float:
    """Return the number that a parameter or a constant input has."""
    constants = {s.symbol: s.signal for s in mechanism.inputs if isinstance(s.signal, float)}
    return float(mechanism.values.get(symbol, constants.get(symbol, 0.0)))


def _duration(motion: Motion) -> float:
    """Length of a motion; one that a limit has ended was to last longer, so that its page ends it.

    It then lasts until the next number of two digits.
    """
    length = float(motion.t[-1] - motion.t[0])
    if not is_cut_short(motion) or length <= 0:
        return length
    digit = 10.0 ** (floor(log10(length)) - 1)
    return float(f"{digit * (floor(length / digit) + 1):.2g}")
