"""Compare every mode of a mechanism with elements that switch: in-house, and from the engine.

In-house the forces of the elements enter Lagrange's equations as loads, and each mode is solved in
letters; where its modes are many, or slip along two directions, in numbers, from jets. Here the
same mode is solved in numbers, from the engine's mass matrix, bias and forces, from the gradients
of its own constraints of closed contacts, and from the rates of joints:

    M a − Jᵀ R = Q − h,  and for each force: J a + γ = 0 held, R = −μ N d slipping along d, R = 0
    open.

So are impacts, with impulses Λ: M (v⁺ − v) = Jᵀ Λ, J_n v⁺ = −e J_n v, and in the directions in
which no contact moves the momentum, about the contacts, stays as it is.

A mode's equations are algebra, which holds at any state: gaps need not be closed there.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import product
from math import prod
from typing import Any, NamedTuple, final

import numpy as np

from mecanique.arrays import Array
from mecanique.derivation.numeric.constraints.multipliers import Held
from mecanique.derivation.numeric.lagrange import LagrangeOnJets
from mecanique.derivation.switching import (
    ModeEquations,
    derive_modes,
    force_symbol,
)
from mecanique.errors import DerivationError
from mecanique.model.constraint_base import JointRow
from mecanique.model.constraints.friction import Contact, Friction, Stop, Switching
from mecanique.model.expression import compile_scalars, coordinate
from mecanique.model.joint_base import Single
from mecanique.model.mechanism import Mechanism
from mecanique.model.states import States
from mecanique.reference import Reference
from mecanique.reference.engine.package import engine_name
from mecanique.reference.loops.loading import load_once
from mecanique.verification.rows import IMPACT_MOMENTUM, OF_ELEMENTS, rows_of
from mecanique.verification.states import random_states
from mecanique.verification.verdict import TOLERANCE, Row, Verdict, conclude

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


@final
@dataclass(frozen=True)
class _Force:
    """A force of an element, and its row at n states."""

    symbol: str
    element: Switching
    axis: int  # of a friction, which of its directions; -1 of a normal force
    jacobian: Array  # shape (n, nv)
    gamma: Array  # shape (n,)

    @property
    def presses(self) -> bool:
        """Whether it is a normal force."""
        return self.axis < 0


class _Terms(NamedTuple):
    """What the modes of a mechanism are made of, at n states."""

    mass: Array  # shape (n, nv, nv)
    load: Array  # shape (n, nv), forces − bias
    forces: tuple[_Force, ...]


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
    states = random_states(base, samples, seed)
    theirs = _ask_engine(mechanism, base, states)
    choices = [_list_states(element, theirs.forces) for element in mechanism.switching]
    count = prod(map(len, choices))
    if count > MOST_MODES:
        raise DerivationError(
            f"mechanism {mechanism.name!r} has {count} modes, more than {MOST_MODES}; expected "
            "fewer elements that switch"
        )
    bench = _Bench(mechanism, base, states, tolerance or TOLERANCE)
    flat = not any("slips" in states for states in choices)
    written = None
    if count <= IN_LETTERS and flat:
        written = derive_modes(mechanism).modes
        rows, notes = bench.compare_letters(written, theirs)
    else:
        ours = _ask_jets(mechanism, base, states, theirs)
        names = [element.name for element in mechanism.switching]
        modes = [dict(zip(names, combined, strict=True)) for combined in product(*choices)]
        rows, notes = bench.compare_numbers(modes, ours, theirs)
    struck = [element for element in mechanism.switching if is_struck(element)]
    if struck:
        ours = _ask_jets(mechanism, base, states, theirs)
        rows += bench.compare_impacts(struck, ours, theirs)
    return conclude(mechanism, rows, samples, seed, tolerance or TOLERANCE, notes=tuple(notes))


def solve_mode(
    mechanism: Mechanism, mode: Mapping[str, str], states: States, *, struck: bool = False
) -> tuple[Array, Array]:
    """Return accelerations and forces in a mode by the engine's quantities, and their rounding.

    Of an impact these are the velocities after it and the impulses of its element alone. Shapes
    (n, nv + forces) and (n,).
    """
    base = replace(mechanism, switching=())
    terms = _ask_engine(mechanism, base, states)
    system, right = _Bench(mechanism, base, states, TOLERANCE).write(mode, terms, struck=struck)
    solved = _solve(system, right)
    rounding = EPSILON * _condition(system) * np.linalg.norm(solved, axis=1)
    if struck:
        solved[:, : base.nv] += states.v
        in_mode = [k for k, f in enumerate(terms.forces, base.nv) if f.element.name in mode]
        solved = solved[:, [*range(base.nv), *in_mode]]
    return solved, rounding


def measure_elements(mechanism: Mechanism, states: States) -> Array:
    """Return gap and rate of each normal force, and the slip of each friction, by the engine."""
    base = replace(mechanism, switching=())
    whole = _close(mechanism, base)
    gaps: dict[str, Array] = {}
    if whole.contacts:
        _, closed = load_once(whole)
        assert closed is not None, "contacts are closed"
        moments = zip(states.q, states.v, states.t.tolist(), strict=True)
        residuals = np.array([closed.closures.at(*moment).residual for moment in moments])
        gaps = dict(zip(closed.closures.names, residuals.T, strict=True))
    columns: list[Array] = []
    for force in _ask_engine(mechanism, base, states).forces:
        element = force.element
        rate = (force.jacobian * states.v).sum(axis=1)
        if isinstance(element, Contact):
            columns += [gaps[f"{element.name}: normal"]] if force.presses else []
        else:
            row = next(r for r in element.joint_rows if (r.offset is not None) == force.presses)
            if row.offset is not None:
                place: Any = row.offset
                for name, weight in row.weights:
                    joint = _coordinate_of(base, name)
                    way: Any = base.coordinates.driven.get(joint, coordinate(joint))
                    place += weight * way
                columns.append(_evaluate(mechanism, [place], states)[:, 0])
            rate = rate - _evaluate(mechanism, [row.speed], states)[:, 0]
        columns.append(rate)
    return np.column_stack(columns)


def _list_states(element: Switching, forces: Sequence[_Force]) -> tuple[str, ...]:
    """Return the states of an element, by the directions that it has."""
    own = [force for force in forces if force.element is element]
    states = ("open",) if own[0].presses else ()
    along = sum(not force.presses for force in own)
    if not along:
        return (*states, "closed")
    return (*states, "sticks", *(("slips +", "slips -") if along == 1 else ("slips",)))


def is_struck(element: Switching) -> bool:
    """Return whether an element has impacts."""
    elastic = isinstance(element, Stop) and element.stiffness is not None
    return not isinstance(element, Friction) and not elastic


@final
@dataclass(frozen=True)
class _Bench:
    """The states at which modes are compared."""

    mechanism: Mechanism
    base: Mechanism
    states: States
    tolerance: float

    def compare_letters(
        self, modes: Sequence[ModeEquations], theirs: _Terms
    ) -> tuple[list[Row], list[str]]:
        """Compare modes that are solved in letters."""
        rows, notes = list[Row](), list[str]()
        for mode in modes:
            label = ", ".join(mode.states.values())
            if len(mode.states) > 1:
                label = _say(mode.states)
            if not mode.accelerations:
                notes.append(f"{label}: not compared, rigid bodies do not determine its forces")
                continue
            system, right = self.write(mode.states, theirs)
            named = [mode.forces.get(force.symbol, 0.0) for force in theirs.forces]
            ours = np.concatenate(
                [
                    _evaluate(self.mechanism, [*mode.accelerations.values()], self.states),
                    _evaluate(self.base, named, self.states),
                ],
                axis=1,
            )
            solved = _solve(system, right)
            rows += self._judge(label, ours, solved, _condition(system), theirs.mass)
        return rows, notes

    def compare_numbers(
        self, modes: Sequence[Mapping[str, str]], ours: _Terms, theirs: _Terms
    ) -> tuple[list[Row], list[str]]:
        """Compare modes that are solved in numbers; the worst row of each quantity stands for all.

        Those whose forces rigid bodies do not determine are left out.
        """
        worst: dict[str, Row] = {}
        compared = 0
        for mode in modes:
            system, right = self.write(mode, theirs)
            condition = _condition(system)
            if not (condition < DETERMINED).all():
                continue
            compared += 1
            solved = _solve(system, right)
            system, right = self.write(mode, ours)
            in_house = _solve(system, right)
            for row in self._judge("", in_house, solved, condition, theirs.mass):
                old = worst.get(row.quantity)
                if old is None or row.worst / row.allowed > old.worst / old.allowed:
                    remark = f"in the mode {_say(mode)}"
                    worst[row.quantity] = replace(row, remark=row.remark or remark)
        label = (f"{compared} modes", engine_name())
        left = len(modes) - compared
        notes = [f"{left} modes not compared, rigid bodies do not determine their forces"]
        return [replace(row, sources=label) for row in worst.values()], notes if left else []

    def compare_impacts(
        self, struck: Sequence[Switching], ours: _Terms, theirs: _Terms
    ) -> list[Row]:
        """Compare impacts of each element by itself, and the momentum about the contact."""
        rows: list[Row] = []
        for element in struck:
            worst: dict[str, Row] = {}
            own = [force for force in theirs.forces if force.element is element]
            still = _null_space(np.stack([force.jacobian for force in own], axis=1))
            for state in _list_states(element, theirs.forces)[1:]:
                system, right = self.write({element.name: state}, theirs, struck=True)
                condition = _condition(system)
                if not (condition < DETERMINED).all():
                    continue
                solved = _solve(system, right)
                system, right = self.write({element.name: state}, ours, struck=True)
                in_house = _solve(system, right)
                judged = self._judge("", in_house, solved, condition, theirs.mass)
                judged += self._conserve(in_house, condition, theirs, still)
                for row in judged:
                    old = worst.get(row.quantity)
                    if old is None or row.worst / row.allowed > old.worst / old.allowed:
                        worst[row.quantity] = row
            label = (f"impact of {element.name}", engine_name())
            rows += [replace(row, sources=label) for row in worst.values()]
        return rows

    def _conserve(
        self, solved: Array, condition: Array, theirs: _Terms, still: Sequence[Array]
    ) -> tuple[Row, ...]:
        """Compare the momentum in the directions in which the contact does not move with zero."""
        nv = self.base.nv
        gained = (theirs.mass @ solved[:, :nv, None])[..., 0]
        size = np.linalg.norm(gained, axis=1)
        kept = [np.linalg.norm(N.T @ g) for N, g in zip(still, gained, strict=True)]
        pair = np.column_stack([size, kept]), np.column_stack([size, np.zeros(len(size))])
        bound = EPSILON * condition * size
        return rows_of(
            ("", ""),
            {IMPACT_MOMENTUM: pair[0]},
            {IMPACT_MOMENTUM: pair[1], "mass matrix": theirs.mass},
            self.states,
            self.base,
            rounding={IMPACT_MOMENTUM: bound},
            tolerance=self.tolerance,
        )

    def _judge(
        self, label: str, ours: Array, theirs: Array, condition: Array, mass: Array
    ) -> tuple[Row, ...]:
        """Compare accelerations and forces, shape (n, nv + forces)."""
        nv = self.base.nv
        bound = EPSILON * condition * np.linalg.norm(theirs, axis=1)
        values = [
            {"acceleration": side[:, :nv], OF_ELEMENTS: side[:, nv:], "mass matrix": mass}
            for side in (ours, theirs)
        ]
        del values[0]["mass matrix"]
        return rows_of(
            (label, engine_name()),
            values[0],
            values[1],
            self.states,
            self.base,
            rounding=dict.fromkeys(values[0], bound),
            tolerance=self.tolerance,
        )

    def write(
        self, mode: Mapping[str, str], terms: _Terms, *, struck: bool = False
    ) -> tuple[Array, Array]:
        """Return the matrix and the right side of a mode, shapes (n, k, k) and (n, k).

        Of an impact the unknowns are changes of velocities and impulses.
        """
        mechanism, states, forces = self.mechanism, self.states, terms.forces
        n, nv = terms.load.shape
        size = nv + len(forces)
        system, right = np.zeros((n, size, size)), np.zeros((n, size))
        system[:, :nv, :nv] = terms.mass
        if not struck:
            right[:, :nv] = terms.load
        normal = {force.element.name: k for k, force in enumerate(forces, nv) if force.presses}
        angle = 1.0 + np.arange(n)  # of slip in space, another at each state
        along = np.stack([np.cos(angle), np.sin(angle)])
        for k, force in enumerate(forces, nv):
            system[:, :nv, k] = -force.jacobian
            element, state = force.element, mode.get(force.element.name, "open")
            rate = (force.jacobian * states.v).sum(axis=1)
            if state == "open":
                system[:, k, k] = 1.0
            elif isinstance(element, Stop) and element.stiffness is not None:
                name = _coordinate_of(mechanism, element.joint)
                place = mechanism.coordinates.driven.get(name, coordinate(name))
                gap = element.side * (element.at - place)
                system[:, k, k] = 1.0
                right[:, k] = -_evaluate(mechanism, [element.stiffness * gap], states)[:, 0]
            elif force.presses or state == "sticks":
                system[:, k, :nv] = force.jacobian
                right[:, k] = -force.gamma
                if struck:
                    e = mechanism.evaluate(getattr(element, "restitution", 0.0))
                    right[:, k] = -(1.0 + e if force.presses else 1.0) * rate
            else:
                sign = {"slips +": 1.0, "slips -": -1.0}.get(state, along[force.axis])
                system[:, k, k] = 1.0
                if isinstance(element, Friction) and not isinstance(element.load, str):
                    pull = _evaluate(mechanism, [element.mu * element.load], states)[:, 0]
                    right[:, k] = -sign * pull
                else:
                    ratio = _evaluate(mechanism, [element.coefficients[0]], states)[:, 0]
                    system[:, k, normal[element.pressed_by or ""]] = sign * ratio
        return system, right


def _solve(system: Array, right: Array) -> Array:
    return np.asarray(np.linalg.solve(system, right[..., None])[..., 0], dtype=np.float64)


def _say(mode: Mapping[str, str]) -> str:
    return ", ".join(f"{name} {state}" for name, state in mode.items())


def _null_space(rows: Array) -> list[Array]:
    """Return the directions that rows (n, m, nv) do not move, shape (nv, any) at each state."""
    spaces = []
    for matrix in rows:
        _, sizes, directions = np.linalg.svd(matrix)
        rank = int((sizes > 1e-9 * sizes[0]).sum())
        spaces.append(directions[rank:].T)
    return spaces


def _ask_engine(mechanism: Mechanism, base: Mechanism, states: States) -> _Terms:
    engine = Reference.of(base)
    load = engine.forces(states.q, states.v, states.t) - engine.bias(states.q, states.v, states.t)
    rows = _measure_contacts(_close(mechanism, base), states)
    ask = engine.followers

    def measure(joint: str) -> tuple[Array, Array]:
        """Return the slopes and the second rate of a driven coordinate."""

        def rate(v: Array) -> Array:
            return ask(states.q, np.broadcast_to(v, states.v.shape), t=states.t)[f"{joint}'"]

        still = rate(np.zeros(base.nv))
        slopes = np.column_stack([rate(direction) - still for direction in np.eye(base.nv)])
        return slopes, ask(states.q, states.v, np.zeros(states.v.shape), t=states.t)[f"{joint}''"]

    mass = np.asarray(engine.mass_matrix(states.q, states.t))
    return _Terms(mass, load, tuple(_list_forces(mechanism, states, rows, measure)))


def _ask_jets(mechanism: Mechanism, base: Mechanism, states: States, like: _Terms) -> _Terms:
    """Return the terms in-house; of the same forces as the engine's."""
    jets, whole = LagrangeOnJets(base), _close(mechanism, base)
    rows: dict[str, tuple[Array, Array]] = {}
    if whole.contacts:
        held = Held(whole)
        at = held.at(replace(states, mechanism=whole))
        for k, name in enumerate(held.names):
            rows[name] = at.jacobian[:, k], at.gamma[:, k]

    def measure(joint: str) -> tuple[Array, Array]:
        from sympy import Symbol, diff, sympify

        rate = 0
        place = sympify(base.coordinates.driven[joint])
        names = dict(zip(base.coordinates, base.velocities, strict=True))
        slopes = [diff(place, Symbol(name)) for name in names]
        for slope, name in zip(slopes, names.values(), strict=True):
            rate += slope * Symbol(name)
        rate += diff(place, Symbol("t"))
        second = diff(rate, Symbol("t"))
        for name, speed in names.items():
            second += diff(rate, Symbol(name)) * Symbol(speed)
        values = _evaluate(base, [*slopes, second], states)
        return values[:, :-1], values[:, -1]

    forces = tuple(_list_forces(mechanism, states, rows, measure))
    by_symbol = {force.symbol: force for force in forces}
    load = jets.forces(states) - jets.bias(states)
    return _Terms(
        jets.mass_matrix(states), load, tuple(by_symbol[force.symbol] for force in like.forces)
    )


def _close(mechanism: Mechanism, base: Mechanism) -> Mechanism:
    """Return the mechanism in which every contact is closed and sticks."""
    closed = tuple(e.closed for e in mechanism.switching if isinstance(e, Contact))
    return replace(base, contacts=closed)


def _list_forces(
    mechanism: Mechanism,
    states: States,
    contacts: Mapping[str, tuple[Array, Array]],
    measure: Callable[[str], tuple[Array, Array]],
) -> Iterator[_Force]:
    """Yield the forces of the elements with their rows, in the order of the derivation."""
    base = replace(mechanism, switching=())
    for element in mechanism.switching:
        name = element.name
        if not isinstance(element, Contact):
            for row in element.joint_rows:
                jacobian, gamma = _measure_joints(base, row, states, measure)
                axis = -1 if row.offset is not None else 0
                yield _Force(force_symbol(row.letter, name), element, axis, jacobian, gamma)
            continue
        yield _Force(force_symbol("N", element.name), element, -1, *contacts[f"{name}: normal"])
        axis = 0
        for row_name in ("x", "y") if element.rubs else ():
            jacobian, gamma = contacts[f"{name}: {row_name}"]
            if np.abs(jacobian).max() > IDLE:
                symbol = force_symbol("T" if axis == 0 else "Y", name)
                yield _Force(symbol, element, axis, jacobian, gamma)
                axis += 1


def _measure_contacts(whole: Mechanism, states: States) -> dict[str, tuple[Array, Array]]:
    """Return J, shape (n, nv), and γ, shape (n,), of the rows of closed contacts by their names."""
    if not whole.contacts:
        return {}
    _, closed = load_once(whole)
    assert closed is not None, "contacts are closed"
    moments = zip(states.q, states.v, states.t.tolist(), strict=True)
    closures = [closed.closures.at(q, v, t) for q, v, t in moments]
    jacobian = np.array([closure.jacobian for closure in closures])
    gamma = np.array([closure.gamma for closure in closures])
    names = closed.closures.names
    return {name: (jacobian[:, k], gamma[:, k]) for k, name in enumerate(names)}


def _measure_joints(
    base: Mechanism,
    row: JointRow,
    states: States,
    measure: Callable[[str], tuple[Array, Array]],
) -> tuple[Array, Array]:
    """Return J, shape (n, nv), and γ, shape (n,), of the rate of a row of joints."""
    jacobian, gamma = np.zeros((len(states.t), base.nv)), np.zeros(len(states.t))
    for name, weight in row.weights:
        joint = _coordinate_of(base, name)
        if joint in base.coordinates.driven:
            slopes, second = measure(joint)
            jacobian += weight * slopes
            gamma += weight * second
        else:
            jacobian[:, base.velocities.index(f"{joint}'")] += weight
    return jacobian, gamma


def _coordinate_of(mechanism: Mechanism, name: str) -> str:
    joint = mechanism.joint(name)
    assert isinstance(joint, Single), "validated"
    return joint.coordinate


def _condition(system: Array) -> Array:
    """Return the condition numbers of systems, rows and columns scaled to one, shape (n,)."""
    rows = np.abs(system).max(axis=2, keepdims=True)
    scaled = system / rows
    columns = np.abs(scaled).max(axis=1, keepdims=True)
    numbers: Array = np.linalg.cond(scaled / columns)
    return numbers


def _evaluate(mechanism: Mechanism, scalars: Sequence[Any], states: States) -> Array:
    """Return scalars at all states, shape (n, scalars)."""
    from sympy import sympify

    signals = [signal.symbol for signal in mechanism.inputs]
    names = [*mechanism.coordinates, *mechanism.velocities, "t", *mechanism.values, *signals]
    function: Callable[..., Any] = compile_scalars([sympify(s) for s in scalars], names)
    laws = [signal.function(mechanism.values) for signal in mechanism.inputs]
    constants = list(mechanism.values.values())
    values = []
    for q, v, t in zip(states.q.tolist(), states.v.tolist(), states.t.tolist(), strict=True):
        values.append(function(*q, *v, t, *constants, *(law(t) for law in laws)))
    return np.array(values, dtype=float).reshape(len(states.t), len(scalars))
