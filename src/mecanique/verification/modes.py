"""Compare every mode of a mechanism with elements that switch: in-house, and from the engine.

In-house the forces of the elements enter Lagrange's equations as loads, and each mode is solved in
letters; where its modes are many, or not written out, in numbers, from jets. Here the same mode is
solved in numbers, from the engine's mass matrix, bias and forces, from the gradients of its own
constraints of closed contacts, and from the rates of joints:

    M a − Jᵀ R = Q − h,  and for each force: J a + γ = 0 held, R = −μ N d slipping along d, R = 0
    open.

So are impacts, with impulses Λ: M (v⁺ − v) = Jᵀ Λ, J_n v⁺ = −e J_n v, and in the directions in
which no contact moves the momentum, about the contacts, stays as it is.

A mode's equations are algebra, which holds at any state: gaps need not be closed there.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from contextlib import suppress
from dataclasses import replace
from functools import cached_property
from itertools import product
from math import prod
from typing import Any, NamedTuple, final

import numpy as np

from mecanique.arrays import Array
from mecanique.derivation.mechanics.switching import (
    ElementRows,
    ModeProblem,
    Terms,
    accelerate,
    bounce,
    close_contacts,
    find_inside,
    hold,
    list_elements,
    name_mode,
    place_of,
    point_slip,
)
from mecanique.derivation.numeric.constraints.rows import Held
from mecanique.derivation.numeric.lagrange import LagrangeOnJets
from mecanique.derivation.numeric.paths import driven_paths
from mecanique.derivation.switching import ModeEquations, derive_modes, name_forces
from mecanique.errors import DerivationError
from mecanique.model.expression import evaluate
from mecanique.model.joint_base import Single
from mecanique.model.mechanism import Mechanism
from mecanique.model.states import States
from mecanique.reference import Reference
from mecanique.reference.engine.package import engine_name
from mecanique.reference.engine.tree import refuse_massless
from mecanique.reference.loops.closed import load_once
from mecanique.reference.loops.contacts import LoopClosure
from mecanique.verification.rows import IMPACT_MOMENTUM, OF_ELEMENTS, rows_of
from mecanique.verification.states import random_states
from mecanique.verification.verdict import SOLVED_ALIKE, Row, Verdict, conclude

EPSILON = 1e-15
"""Rounding of an entry of a mode's system, relative to the largest of its row."""

IN_LETTERS = 16
"""So many modes at most are solved in letters."""

MOST_MODES = 4096
"""So many modes at most are compared."""

IDLE = 1e-12
"""Rows below this in every state are those of a direction nothing moves in."""

DETERMINED = 1e9
"""Systems with condition numbers beyond this do not determine a mode's forces."""


def compare_modes(
    mechanism: Mechanism, samples: int, seed: int, tolerance: float | None = None
) -> Verdict:
    """Compare accelerations, the elements' forces and impacts of every mode at random states."""
    base = replace(mechanism, switching=())
    if base.constrained:
        raise DerivationError(
            f"mechanism {mechanism.name!r} has constraints that hold in every mode; modes are "
            "compared for trees alone"
        )
    bench = _Bench(mechanism, random_states(base, samples, seed), tolerance or SOLVED_ALIKE)
    choices = [element.states for element in bench.elements]
    count = prod(map(len, choices))
    if count > MOST_MODES:
        raise DerivationError(
            f"mechanism {mechanism.name!r} has {count} modes, more than {MOST_MODES}; expected "
            "fewer elements that switch"
        )
    letters = None
    if count <= IN_LETTERS:
        with suppress(DerivationError):  # what is not written out is compared in numbers
            letters = derive_modes(mechanism)
    if letters is not None:
        rows, notes = bench.compare_letters(letters.modes)
    else:
        names = [element.name for element in mechanism.switching]
        modes = [dict(zip(names, combined, strict=True)) for combined in product(*choices)]
        rows, notes = bench.compare_numbers(modes)
    rows += bench.compare_impacts()
    return conclude(mechanism, rows, samples, seed, tolerance or SOLVED_ALIKE, notes=tuple(notes))


def solve_mode(
    mechanism: Mechanism, mode: Mapping[str, str], states: States, *, struck: bool = False
) -> tuple[Array, Array]:
    """Return accelerations and forces in a mode by the engine's quantities, and their rounding.

    Of an impact these are the velocities after it and the impulses of its element alone. Shapes
    (n, nv + forces) and (n,).
    """
    bench = _Bench(mechanism, states, SOLVED_ALIKE)
    solution, condition = bench.solve(mode, bench.theirs, struck=struck)
    rounding = EPSILON * condition * np.linalg.norm(solution, axis=1)
    if struck:
        solution[:, : mechanism.nv] += states.v
        names = [element.name for element in bench.elements for _ in element.rows]
        in_mode = [k for k, name in enumerate(names, mechanism.nv) if name in mode]
        solution = solution[:, [*range(mechanism.nv), *in_mode]]
    return solution, rounding


def measure_elements(mechanism: Mechanism, states: States) -> Array:
    """Return gap and rate of each normal force, and the slip of each friction, by the engine.

    Of a side with ends, how far inside them it is touched, too.
    """
    bench = _Bench(mechanism, states, SOLVED_ALIKE)
    terms, columns = bench.theirs, list[Array]()
    for element, inside in zip(bench.elements, terms.inside.T, strict=True):
        for row in element.rows:
            columns += [terms.gaps[:, row]] if row == element.normal else []
            columns.append(terms.rates[:, row])
        columns += [] if element.length is None else [inside]
    return np.column_stack(columns)


class _Rates(NamedTuple):
    """A position q of contacts or joints at n states, to be compared with what the engine gives."""

    jacobian: Array  # shape (n, nv)
    gamma: Array  # shape (n,), its second rate without accelerations
    drift: Array | float = 0.0  # shape (n,), its rate without velocities
    gap: Array | float = 0.0  # shape (n,), the position where it is a gap


@final
class _Bench:
    """The states at which modes are compared, with what the engine says of them."""

    def __init__(self, mechanism: Mechanism, states: States, tolerance: float) -> None:
        self.mechanism = mechanism
        self.base = replace(mechanism, switching=())
        self.states = states
        self.tolerance = tolerance
        self._whole = close_contacts(mechanism)
        engine = Reference.of(self.base)
        if engine.massless is not None:
            refuse_massless(mechanism, np.array([*engine.massless.values()]))
        q, v, t = states.q, states.v, states.t
        self._feet: dict[str, Array] = {}
        contacts = self._ask_contacts()
        self._names = list(contacts)
        self.theirs = self._collect(
            np.asarray(engine.mass_matrix(q, t)),
            engine.forces(q, v, t) - engine.bias(q, v, t),
            contacts,
            self._ask_joint,
        )
        largest = np.abs(self.theirs.jacobian).max(axis=(0, 2), initial=0.0)
        self.elements = list_elements(
            mechanism, self._names, mechanism.evaluate, np.flatnonzero(largest <= IDLE).tolist()
        )
        inside = find_inside(self.elements, self._feet, self.theirs.gaps)
        columns = [np.broadcast_to(column, len(states)) for column in inside]
        self.theirs = self.theirs._replace(inside=np.column_stack(columns))
        self._order = [row for element in self.elements for row in element.rows]

    @cached_property
    def ours(self) -> Terms:
        """The terms in-house, from jets."""
        jets, states, contacts = LagrangeOnJets(self.base), self.states, dict[str, _Rates]()
        if self._whole.contacts:
            held = Held(self._whole)
            at = held.at(replace(states, mechanism=self._whole))
            drift = at.rates - (at.jacobian @ states.v[..., None])[..., 0]
            for k, name in enumerate(held.names):
                contacts[name] = _Rates(at.jacobian[:, k], at.gamma[:, k], drift[:, k])
        load = jets.forces(states) - jets.bias(states)
        return self._collect(jets.mass_matrix(states), load, contacts, self._differentiate)

    def _collect(
        self,
        mass: Array,
        load: Array,
        contacts: Mapping[str, _Rates],
        measure: Callable[[str], _Rates],
    ) -> Terms:
        """Return the terms by the rows of contacts, and by the rates of driven coordinates."""
        mechanism, states = self.mechanism, self.states
        rows = [contacts[name] for name in self._names]
        stated = [row for element in mechanism.switching for row in element.joint_rows]
        places = [0.0 if row.offset is None else place_of(self.base, row) for row in stated]
        gaps = self._evaluate(places)
        speeds = self._evaluate([row.speed for row in stated])
        for row, gap, speed in zip(stated, gaps.T, speeds.T, strict=True):
            jacobian, gamma, drift = np.zeros(states.v.shape), np.zeros(len(states)), -speed
            for name, weight in row.weights:
                joint = self.base.joint(name)
                assert isinstance(joint, Single), "validated"
                if joint.coordinate in self.base.coordinates.driven:
                    part = measure(joint.coordinate)
                    jacobian += weight * part.jacobian
                    gamma += weight * part.gamma
                    drift = drift + weight * part.drift
                else:
                    jacobian[:, self.base.velocities.index(f"{joint.coordinate}'")] += weight
            rows.append(_Rates(jacobian, gamma, drift, gap))
        n = len(states)
        jacobian = np.stack([row.jacobian for row in rows], axis=1)
        drift = np.stack([np.broadcast_to(row.drift, n) for row in rows], axis=1)
        coefficients = [element.coefficients for element in mechanism.switching]
        return Terms(
            mass=mass,
            load=load,
            jacobian=jacobian,
            gamma=np.stack([row.gamma for row in rows], axis=1),
            gaps=np.stack([np.broadcast_to(row.gap, n) for row in rows], axis=1),
            rates=(jacobian @ states.v[..., None])[..., 0] + drift,
            drift=drift,
            kinetic=self._evaluate([kinetic for kinetic, _ in coefficients]),
            static=self._evaluate([static for _, static in coefficients]),
        )

    def _ask_contacts(self) -> dict[str, _Rates]:
        """Return the rows of closed contacts by the engine, by name."""
        if not self._whole.contacts:
            return {}
        _, closed = load_once(self._whole)
        assert closed is not None, "contacts are closed"
        at, feet = list[LoopClosure](), list[Array]()
        for moment in zip(self.states.q, self.states.v, self.states.t.tolist(), strict=True):
            at.append(closed.closures.at(*moment))
            feet.append(closed.closures.contacts.feet.copy())
        touching = (contact.name for contact in self._whole.contacts)
        self._feet = dict(zip(touching, np.transpose(feet), strict=True))
        parts = ([c.jacobian for c in at], [c.gamma for c in at], [c.drift for c in at])
        rows = (*parts, [c.residual for c in at])
        jacobian, gamma, drift, gap = (np.swapaxes(part, 0, 1) for part in rows)
        names = closed.closures.names
        return dict(zip(names, map(_Rates, jacobian, gamma, drift, gap), strict=True))

    def _ask_joint(self, joint: str) -> _Rates:
        """Return the rates of a driven coordinate by the engine."""
        q, v, t = self.states.q, self.states.v, self.states.t
        ask = Reference.of(self.base).followers

        def rate(v: Array) -> Array:
            return ask(q, np.broadcast_to(v, (len(t), self.base.nv)), t=t)[f"{joint}'"]

        still = rate(np.zeros(self.base.nv))
        slopes = np.column_stack([rate(direction) - still for direction in np.eye(self.base.nv)])
        return _Rates(slopes, ask(q, v, np.zeros(v.shape), t=t)[f"{joint}''"], still)

    def _differentiate(self, joint: str) -> _Rates:
        """Return the rates of a driven coordinate from its formula, on jets."""
        path = driven_paths(replace(self.states, mechanism=self.base))[joint]
        slopes = path[0, 1:].T
        return _Rates(slopes, 2 * path[2, 0], path[1, 0] - (slopes * self.states.v).sum(axis=1))

    def compare_letters(self, modes: Sequence[ModeEquations]) -> tuple[list[Row], list[str]]:
        """Compare modes that are solved in letters."""
        rows, notes = list[Row](), list[str]()
        symbols = [
            symbol
            for rows in self.elements
            for symbol in name_forces(rows.element, len(rows.tangents))
        ]
        for mode in modes:
            label = ", ".join(mode.states.values())
            if len(mode.states) > 1:
                label = _say(mode.states)
            if mode.unsolved:
                rows += self.compare_numbers([mode.states])[0]
                continue
            if not mode.accelerations:
                notes.append(f"{label}: not compared, rigid bodies do not determine its forces")
                continue
            named = [mode.forces.get(symbol, 0.0) for symbol in symbols]
            ours = self._evaluate([*mode.accelerations.values(), *named])
            rows += self._judge(label, ours, *self.solve(mode.states, self.theirs))
        return rows, notes

    def compare_numbers(self, modes: Sequence[Mapping[str, str]]) -> tuple[list[Row], list[str]]:
        """Compare modes that are solved in numbers; the worst row of each quantity stands for all.

        Those whose forces rigid bodies do not determine are left out.
        """
        judged, compared = list[Row](), 0
        for mode in modes:
            rows = self._compare(mode)
            compared += bool(rows)
            remark = f"in the mode {_say(mode)}"
            judged += [replace(row, remark=row.remark or remark) for row in rows]
        left = len(modes) - compared
        notes = [f"{left} modes not compared, rigid bodies do not determine their forces"]
        return _find_worst(judged, f"{compared} modes"), notes if left else []

    def compare_impacts(self) -> list[Row]:
        """Compare impacts of each element by itself, and the momentum about the contact."""
        rows: list[Row] = []
        for element in filter(lambda element: element.struck, self.elements):
            judged: list[Row] = []
            for state in element.impacts:
                judged += self._compare({element.name: state}, struck=element)
            rows += _find_worst(judged, f"impact of {element.name}")
        return rows

    def _compare(self, mode: Mapping[str, str], *, struck: ElementRows | None = None) -> list[Row]:
        """Compare a mode, or an impact, that is solved in numbers; nothing if it is not known."""
        solution, condition = self.solve(mode, self.theirs, struck=struck is not None)
        if not (condition < DETERMINED).all():
            return []
        ours, _ = self.solve(mode, self.ours, struck=struck is not None)
        rows = self._judge("", ours, solution, condition)
        return [*rows, *(self._conserve(ours, condition, struck) if struck is not None else ())]

    def _conserve(self, solution: Array, condition: Array, element: ElementRows) -> tuple[Row, ...]:
        """Compare the momentum in the directions in which the contact does not move with zero."""
        nv, mass = self.base.nv, self.theirs.mass
        gained = (mass @ solution[:, :nv, None])[..., 0]
        size = np.linalg.norm(gained, axis=1)
        rows = self.theirs.jacobian[:, list(element.rows)]
        pushed = (np.linalg.pinv(rows, rcond=1e-9) @ (rows @ gained[..., None]))[..., 0]
        kept = np.linalg.norm(gained - pushed, axis=1)
        pair = np.column_stack([size, kept]), np.column_stack([size, np.zeros(len(size))])
        bound = EPSILON * condition * size
        return rows_of(
            ("", ""),
            {IMPACT_MOMENTUM: pair[0]},
            {IMPACT_MOMENTUM: pair[1], "mass matrix": mass},
            self.states,
            self.base,
            rounding={IMPACT_MOMENTUM: bound},
            tolerance=self.tolerance,
        )

    def _judge(self, label: str, ours: Array, theirs: Array, condition: Array) -> tuple[Row, ...]:
        """Compare accelerations and forces, shape (n, nv + forces)."""
        nv = self.base.nv
        bound = EPSILON * condition * np.linalg.norm(theirs, axis=1)
        first, second = (
            {"acceleration": side[:, :nv], OF_ELEMENTS: side[:, nv:]} for side in (ours, theirs)
        )
        return rows_of(
            (label, engine_name()),
            first,
            second | {"mass matrix": self.theirs.mass},
            self.states,
            self.base,
            rounding=dict.fromkeys(first, bound),
            tolerance=self.tolerance,
        )

    def solve(
        self, states: Mapping[str, str], terms: Terms, *, struck: bool = False
    ) -> tuple[Array, Array]:
        """Return accelerations and forces in a mode, shape (n, nv + forces), and conditions (n,).

        Of an impact these are changes of velocities and impulses.
        """
        elements, conditions = self.elements, list[Array]()

        def solve(terms: Terms, state: str, drive: ModeProblem) -> tuple[Array, Array]:
            of_impact = dict.fromkeys(states, state) if struck else states
            a, forces, condition = self._solve_state(of_impact, terms, drive)
            conditions.append(condition)
            return a, forces

        if struck:
            (named,) = states.items()
            a, forces = bounce(terms, elements, named, solve)
        else:
            a, forces = solve(terms, "", accelerate(terms, elements))
        whole = np.concatenate([a, forces[:, self._order]], axis=1)
        return whole, np.max(conditions, axis=0)

    def _solve_state(
        self, states: Mapping[str, str], terms: Terms, drive: ModeProblem
    ) -> tuple[Array, Array, Array]:
        """Return accelerations, the force along each row, and the system's condition."""
        (n, nv), elements = terms.load.shape, self.elements
        mode = point_slip(elements, name_mode(elements, states), terms.rates, np.hypot)
        held = hold(terms, elements, mode, drive)
        size = nv + len(held.rows)
        system, right = np.zeros((n, size, size)), np.zeros((n, size))
        system[:, :nv, :nv] = terms.mass
        system[:, :nv, nv:] = -held.forces
        system[:, nv:, :nv] = terms.jacobian[:, held.rows]
        right[:, :nv] = drive.load + (held.known[:, None] @ terms.jacobian)[:, 0]
        right[:, nv:] = drive.wanted[:, held.rows]
        condition = _condition(system)
        solution = np.full(right.shape, np.nan)
        if (condition < 1 / EPSILON).all():  # otherwise no digit is known
            solution = np.linalg.solve(system, right[..., None])[..., 0]
        forces = held.known + (solution[:, None, nv:] @ held.friction)[:, 0]
        return solution[:, :nv], forces, condition

    def _evaluate(self, scalars: Sequence[Any]) -> Array:
        """Return scalars at all states, shape (n, scalars)."""
        values = self.states.values
        out = np.empty((len(self.states), len(scalars)))
        with np.errstate(all="ignore"):
            for k, scalar in enumerate(scalars):
                out[:, k] = evaluate(scalar, values)
        return out


def _find_worst(rows: Iterable[Row], source: str) -> list[Row]:
    """Return the worst row of each quantity, which stands for all."""
    worst: dict[str, Row] = {}
    for row in rows:
        old = worst.get(row.quantity)
        if old is None or row.worst / row.allowed > old.worst / old.allowed:
            worst[row.quantity] = row
    return [replace(row, sources=(source, engine_name())) for row in worst.values()]


def _say(mode: Mapping[str, str]) -> str:
    return ", ".join(f"{name} {state}" for name, state in mode.items())


def _condition(system: Array) -> Array:
    """Return the condition numbers of systems, rows and columns scaled to one, shape (n,)."""
    rows = np.abs(system).max(axis=2, keepdims=True)
    scaled = system / rows
    columns = np.abs(scaled).max(axis=1, keepdims=True)
    numbers: Array = np.linalg.cond(scaled / columns)
    return numbers
