"""Compare every mode of a mechanism with elements that switch: in letters, and from the engine.

In-house the forces of the elements enter Lagrange's equations as loads, and each mode is solved in
letters. Here the same mode is solved in numbers, from the engine's mass matrix, bias and forces,
from the gradients of its own constraints of closed contacts, and from the rates of joints:

    M a − Jᵀ R = Q − h,  and for each force: J a + γ = 0 held, R = ∓μ N sliding, R = 0 open.

A mode's equations are algebra, which holds at any state: gaps need not be closed there.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from typing import Any, final

import numpy as np

from mecanique.arrays import Array
from mecanique.derivation.switching import ModeEquations, derive_modes, force_symbol
from mecanique.model.constraints.friction import Contact, Friction, Stop, Switching
from mecanique.model.expression import compile_scalars, coordinate
from mecanique.model.joint_base import Single
from mecanique.model.mechanism import Mechanism
from mecanique.model.states import States
from mecanique.reference import Reference
from mecanique.reference.engine.package import engine_name
from mecanique.reference.loops.loading import load_once
from mecanique.verification.rows import OF_ELEMENTS, rows_of
from mecanique.verification.states import random_states
from mecanique.verification.verdict import TOLERANCE, Row, Verdict, conclude

EPSILON = 1e-15
"""Rounding of an entry of a mode's system, relative to the largest of its row."""


@final
@dataclass(frozen=True)
class _Force:
    """A force of an element, and its row at n states by the engine."""

    symbol: str
    element: Switching
    presses: bool  # a normal force
    jacobian: Array  # shape (n, nv)
    gamma: Array  # shape (n,)


def compare_modes(
    mechanism: Mechanism, samples: int, seed: int, tolerance: float | None = None
) -> Verdict:
    """Compare the accelerations and the elements' forces of every mode at random states."""
    modes = derive_modes(mechanism)
    base = replace(mechanism, switching=())
    engine, states = Reference.of(base), random_states(base, samples, seed)
    mass = np.asarray(engine.mass_matrix(states.q, states.t))
    load = engine.forces(states.q, states.v, states.t) - engine.bias(states.q, states.v, states.t)
    forces = list(_measure(mechanism, base, states))
    rows: list[Row] = []
    notes: list[str] = []
    for mode in modes.modes:
        label = ", ".join(mode.states.values())
        if len(mode.states) > 1:
            label = ", ".join(f"{name} {state}" for name, state in mode.states.items())
        if not mode.accelerations:
            notes.append(f"{label}: not compared, rigid bodies do not determine its forces")
            continue
        system, right = _write_system(mechanism, mode, mass, load, forces, states)
        solved = np.asarray(np.linalg.solve(system, right[..., None])[..., 0], dtype=np.float64)
        expected = _evaluate(mechanism, [*mode.accelerations.values()], states)
        named = [mode.forces.get(force.symbol, 0.0) for force in forces]
        ours = {"acceleration": expected, OF_ELEMENTS: _evaluate(base, named, states)}
        nv = base.nv
        theirs = {
            "mass matrix": mass,
            "acceleration": solved[:, :nv],
            OF_ELEMENTS: solved[:, nv:],
        }
        bound = EPSILON * _condition(system) * np.linalg.norm(solved, axis=1)
        rows += rows_of(
            (label, engine_name()),
            ours,
            theirs,
            states,
            base,
            rounding=dict.fromkeys(ours, bound),
            tolerance=tolerance or TOLERANCE,
        )
    return conclude(mechanism, rows, samples, seed, tolerance or TOLERANCE, notes=tuple(notes))


def _measure(mechanism: Mechanism, base: Mechanism, states: States) -> Iterator[_Force]:
    """Yield the forces of the elements with their rows, in the order of the derivation."""
    closed = tuple(e.closed for e in mechanism.switching if isinstance(e, Contact))
    contact_rows: dict[str, tuple[Array, Array]] = {}
    if closed:
        whole = replace(base, contacts=closed)
        contact_rows = _measure_contacts(whole, states)
    for element in mechanism.switching:
        name = element.name
        if isinstance(element, Contact):
            yield _Force(
                force_symbol("N", element), element, True, *contact_rows[f"{name}: normal"]
            )
            if element.rubs:
                yield _Force(
                    force_symbol("T", element), element, False, *contact_rows[f"{name}: x"]
                )
        elif isinstance(element, Stop):
            yield _Force(
                force_symbol("N", element), element, True, *_measure_joint(base, element, states)
            )
        else:
            yield _Force(
                force_symbol("R", element), element, False, *_measure_joint(base, element, states)
            )


def _measure_contacts(whole: Mechanism, states: States) -> dict[str, tuple[Array, Array]]:
    """Return J, shape (n, nv), and γ, shape (n,), of the rows of closed contacts by their names."""
    _, closed = load_once(whole)
    assert closed is not None, "contacts are closed"
    moments = zip(states.q, states.v, states.t.tolist(), strict=True)
    closures = [closed.closures.at(q, v, t) for q, v, t in moments]
    jacobian = np.array([closure.jacobian for closure in closures])
    gamma = np.array([closure.gamma for closure in closures])
    names = closed.closures.names
    return {name: (jacobian[:, k], gamma[:, k]) for k, name in enumerate(names)}


def _measure_joint(
    base: Mechanism, element: Friction | Stop, states: States
) -> tuple[Array, Array]:
    """Return J, shape (n, nv), and γ, shape (n,), of the rate that an element in a joint meets."""
    joint, nv = _coordinate_of(base, element), base.nv
    jacobian, gamma = np.zeros((len(states.t), nv)), np.zeros(len(states.t))
    if joint in base.coordinates.driven:
        ask = Reference.of(base).followers

        def rate(v: Array) -> Array:
            return ask(states.q, np.broadcast_to(v, states.v.shape), t=states.t)[f"{joint}'"]

        still = rate(np.zeros(nv))
        jacobian = np.column_stack([rate(direction) - still for direction in np.eye(nv)])
        gamma = ask(states.q, states.v, np.zeros(states.v.shape), t=states.t)[f"{joint}''"]
    else:
        jacobian[:, base.velocities.index(f"{joint}'")] = 1.0
    if isinstance(element, Stop):
        return -element.side * jacobian, -element.side * gamma
    return jacobian, gamma


def _coordinate_of(mechanism: Mechanism, element: Friction | Stop) -> str:
    joint = mechanism.joint(element.joint)
    assert isinstance(joint, Single), "validated"
    return joint.coordinate


def _write_system(
    mechanism: Mechanism,
    mode: ModeEquations,
    mass: Array,
    load: Array,
    forces: Sequence[_Force],
    states: States,
) -> tuple[Array, Array]:
    """Return the matrix and the right side of a mode, shapes (n, k, k) and (n, k)."""
    n, nv = load.shape
    size = nv + len(forces)
    system, right = np.zeros((n, size, size)), np.zeros((n, size))
    system[:, :nv, :nv] = mass
    right[:, :nv] = load
    normal = {force.element.name: k for k, force in enumerate(forces, nv) if force.presses}
    for k, force in enumerate(forces, nv):
        system[:, :nv, k] = -force.jacobian
        element, state = force.element, mode.states[force.element.name]
        if state == "open":
            system[:, k, k] = 1.0
        elif isinstance(element, Stop) and element.stiffness is not None:
            name = _coordinate_of(mechanism, element)
            place = mechanism.coordinates.driven.get(name, coordinate(name))
            gap = element.side * (element.at - place)
            system[:, k, k] = 1.0
            right[:, k] = -_evaluate(mechanism, [element.stiffness * gap], states)[:, 0]
        elif force.presses or state == "sticks":
            system[:, k, :nv] = force.jacobian
            right[:, k] = -force.gamma
        else:
            sign = 1.0 if state == "slips +" else -1.0
            system[:, k, k] = 1.0
            if isinstance(element, Friction):
                pull = _evaluate(mechanism, [element.mu * element.load], states)[:, 0]
                right[:, k] = -sign * pull
            elif isinstance(element, Contact):
                mu = _evaluate(mechanism, [element.mu], states)[:, 0]
                system[:, k, normal[element.name]] = sign * mu
    return system, right


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
