"""Answers of the in-house forms and the engine at the same states, and their comparison."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import final

import numpy as np

from mecanique.arrays import Array
from mecanique.errors import EngineError
from mecanique.model.mechanism import Mechanism
from mecanique.model.states import States
from mecanique.reference import Reference
from mecanique.reference.engine.package import engine_name
from mecanique.verification import derivations
from mecanique.verification.derivations import InHouse
from mecanique.verification.difference import scales
from mecanique.verification.rounding.conditioning import rounding
from mecanique.verification.rounding.contributions import entry_rounding
from mecanique.verification.rows import evaluate, rows_of
from mecanique.verification.verdict import Row
from mecanique.wording import say_count

_INDEPENDENT = "independent coordinates"

_IDLE = 1e-13
"""Eigenvalues of the scaled mass matrix below this belong to motions without mass."""

_PART = 1e-6
"""Components of a motion below this part of its largest are rounding errors."""


@final
@dataclass(frozen=True)
class Answers:
    """What the forms of the in-house derivation and the engine answer at n states.

    Args:
        engine: the engine's values.
        forms: values of each form, by name; of an expensive one at the first states only.
        notes: what was left out, and why.
    """

    engine: dict[str, Array]
    forms: dict[str, dict[str, Array]]
    notes: tuple[str, ...] = ()

    def at(self, start: int, stop: int) -> Answers:
        """Return the answers at some of the states: from `start` up to, but not including, `stop`.

        They are meant for forms that were asked at all states.
        """

        def cut(answers: dict[str, Array]) -> dict[str, Array]:
            return {quantity: values[start:stop] for quantity, values in answers.items()}

        forms = {name: cut(form) for name, form in self.forms.items()}
        return Answers(cut(self.engine), forms, self.notes)

    def rows(
        self, mechanism: Mechanism, states: States, tolerance: float | None = None
    ) -> tuple[Row, ...]:
        """Compare every form with the engine, quantity by quantity.

        Args:
            mechanism: whose answers they are.
            states: where they were asked.
            tolerance: largest relative difference that counts as agreement wherever rounding
                explains less; None for the usual one, and none of single entries.
        """
        usual, entries = rounding(mechanism, states, self.engine), entry_rounding(mechanism, states)
        rows: list[Row] = []
        for name, ours in self.forms.items():
            most = usual
            if name == _INDEPENDENT:
                regular = derivations.regularity(mechanism, states)
                most = rounding(mechanism, states, self.engine, regular=regular)
            count = min(map(len, ours.values()), default=0)
            rows += rows_of(
                (name, engine_name()),
                ours,
                {quantity: values[:count] for quantity, values in self.engine.items()},
                states.at(np.arange(count)),
                mechanism,
                rounding=most,
                entries=entries,
                tolerance=tolerance,
            )
        return tuple(rows)


def ask(
    ours: InHouse,
    engine: Reference,
    mechanism: Mechanism,
    states: States,
    *,
    reactions: bool = True,
    budget: bool = True,
    progress: Callable[[str, float], None] | None = None,
) -> Answers:
    """Evaluate every form and the engine at the same states.

    Args:
        ours: the forms.
        engine: the mechanism inside the engine.
        mechanism: whose equations they are.
        states: where to evaluate.
        reactions: whether those in the joints of a tree are asked for as well.
        budget: whether an expensive form is evaluated at the first states only.
        progress: called with what is evaluated next and the fraction done.
    """
    idle = None if mechanism.constrained else engine.massless
    notes, moves = ours.notes, idle is None
    if idle is not None:
        idle_ones = _idle(engine, states)
        remark = "left out: accelerations and reactions, which nothing determines"
        verb = "moves" if len(idle_ones) == 1 else "move"
        notes = (*notes, f"{remark}: {', '.join(idle_ones)} {verb} no mass")
    tell = progress or (lambda _name, _done: None)
    tell(engine_name(), 0.0)
    theirs = evaluate(engine, states, accelerations=moves)
    found: dict[str, dict[str, Array]] = {}
    for k, (name, form) in enumerate(ours.forms.items(), 1):
        tell(name, k / (len(ours.forms) + 2))
        some = derivations.affordable(name, states) if budget else states
        light = derivations.is_light(name, mechanism)
        if len(some) < len(states):
            without = ", without the mass matrix" if light else ""
            notes = (
                *notes,
                f"{name}: at the first {say_count(len(some), 'state')} only{without}, "
                "their cost grows with the cube of the size",
            )
        found[name] = evaluate(form, some, light=light, accelerations=moves)
    if mechanism.loops and not mechanism.rolls:
        found[_INDEPENDENT], remarks = derivations.independent_accelerations(mechanism, states)
        notes = (*notes, *remarks)
    tell("reactions and rounding", 1 - 1 / (len(ours.forms) + 2))
    if reactions and mechanism.contacts:
        theirs["contact forces"] = derivations.contact_forces(engine, engine, states)
        for name in ("recursion", "Newton-Euler"):
            touching = derivations.contact_forces(ours.forms[name], engine, states)
            found[name]["contact forces"] = touching
    if reactions and moves and not (mechanism.loops or mechanism.velocity_constraints):
        balances = derivations.balances(ours)
        shared = derivations.shared_reactions(engine, states) if mechanism.contacts else None
        for source, values in ((balances, found["Newton-Euler"]), (engine, theirs)):
            parts = [derivations.reactions(source, mechanism, states)]
            if shared is not None:
                parts[0][:, : shared.shape[1]][shared] = 0.0
            # reactions are judged against the contact forces that they balance
            parts += [values["contact forces"]] if mechanism.contacts else []
            values["reactions"] = np.concatenate(parts, axis=1)
    return Answers(theirs, found, notes)


def _idle(engine: Reference, states: States) -> list[str]:
    """Return the velocities that take part in motions without mass; refuse if all motions are."""
    mass = np.mean(engine.mass_matrix(states.q, states.t), axis=0)
    mechanism, velocities = engine.mechanism, engine.mechanism.velocities
    if not mass.any():
        moving = (body for body in mechanism.bodies if body.name != mechanism.ground)
        if any(mechanism.evaluate(body.mass) for body in moving):
            raise EngineError(
                f"mechanism {mechanism.name!r}: its bodies have mass, but none resists a change of "
                f"{', '.join(velocities)}: centers of mass lie on the axes, about which the "
                "moments of inertia are zero; give them inertia"
            )
        raise EngineError(
            f"mechanism {mechanism.name!r}: nothing that moves has mass, so it has geometry but no "
            "equations of motion; give its bodies mass and inertia"
        )
    size = scales(mass[None])[0]
    values, vectors = np.linalg.eigh(mass / np.outer(size, size))
    parts = np.abs(vectors[:, np.abs(values) < _IDLE]).max(axis=1, initial=0.0)
    return [name for name, part in zip(velocities, parts, strict=True) if part > _PART]
