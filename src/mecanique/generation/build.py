"""Build programs: of chosen quantities, or of every mode and impact of a mechanism that switches.

A mode's formulas are those that `derive_modes` solves in letters. Which mode follows is for the
caller to decide, by the forces that a mode gives and by the gaps and rates of the elements.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from mecanique.derivation.equations import Equations
from mecanique.derivation.mechanics.letters import Letters
from mecanique.derivation.mechanics.switching import (
    accelerate,
    close_contacts,
    name_mode,
)
from mecanique.derivation.switching import ModeEquations, Modes, name_forces
from mecanique.errors import DerivationError, UnknownNameError
from mecanique.generation.identifiers import file_stem
from mecanique.generation.mechanics.dynamics import TapeDynamics, dynamics_of
from mecanique.generation.mechanics.free_body_forces import FreeBodyForces
from mecanique.generation.mechanics.switching import SwitchingEquations
from mecanique.generation.program import (
    QUANTITIES,
    Answer,
    Output,
    Program,
    ProgramInput,
    SwitchingTerms,
    choose,
)
from mecanique.model.mechanism import Mechanism
from mecanique.model.mechanism_units import characteristic_length, per_second, units
from mecanique.program.tape import Value
from mecanique.program.traced import values_of

MOST_ELEMENTS = 6
"""An FMU tries 4 states of each element at a corner, with as many as these 4,096 modes."""


def build_program(
    equations: Equations,
    what: str | Sequence[str],
    parameters: Sequence[str] | None = None,
    name: str | None = None,
    *,
    moves: bool = False,
) -> Program:
    """Build the program that computes some quantities of a mechanism."""
    mechanism = equations.mechanism
    quantities = choose(what, mechanism)
    if moves:
        others = [quantity for quantity in quantities if quantity.name != "rhs"]
        quantities = (QUANTITIES["rhs"], *others)
    stem = file_stem(mechanism.name, name)
    dynamics = dynamics_of(equations, require_known(mechanism, parameters))
    answers = []
    for quantity in quantities:
        values = _values(dynamics, quantity.base or quantity.name)
        if quantity.by:
            values = dynamics.differentiate(values, quantity.by)
        shape = _find_shape(quantity, mechanism, len(values))
        answers.append(Answer(quantity, tuple(values), shape))
    program = assemble(dynamics, stem, answers)
    if moves and mechanism.constrained:
        return replace(program, landing=dynamics.landing)
    return program


def require_known(mechanism: Mechanism, parameters: Sequence[str] | None) -> tuple[str, ...]:
    """Return the parameters and inputs that remain arguments, all by default."""
    known = (*mechanism.values, *(signal.symbol for signal in mechanism.inputs))
    for symbol in parameters or ():
        if symbol not in known:
            raise UnknownNameError("parameter", symbol, known)
    return known if parameters is None else tuple(parameters)


def assemble(dynamics: TapeDynamics, name: str, answers: Sequence[Answer]) -> Program:
    """Assemble a program from answers on the tape of a mechanism's dynamics."""
    mechanism, tape = dynamics.letters.mechanism, dynamics.letters.tape
    return Program(
        mechanism, name, dynamics.title, tape, _collect_letters(dynamics), tuple(answers)
    )


def _values(dynamics: TapeDynamics, name: str) -> list[Value]:
    """Return the values of a quantity."""
    if name != "reactions":
        return dynamics.answer(name)
    reactions = FreeBodyForces(dynamics).joint_reactions()
    return values_of([entry for wrench in reactions for entry in (*wrench.force, *wrench.moment)])


def _collect_letters(dynamics: TapeDynamics) -> dict[str, tuple[ProgramInput, ...]]:
    """Return the inputs by kind."""
    mechanism = dynamics.letters.mechanism
    unit = units(mechanism)
    neutral = dict(zip(mechanism.coordinates, mechanism.neutral().tolist(), strict=True))
    named = {p.symbol: p for p in mechanism.parameters} | {s.symbol: s for s in mechanism.inputs}
    constants = []
    for symbol in dynamics.letters.open:
        letter = named[symbol]
        value = mechanism.values.get(symbol, getattr(letter, "signal", 0.0))
        known = float(value) if isinstance(value, float) else 0.0
        constants.append(ProgramInput(symbol, symbol, letter.unit, letter.meaning, known))
    speeds, meaning = mechanism.velocities, _describe_free_joints(mechanism)
    return {
        "t": (ProgramInput("t", "t", "s", "time"),),
        "q": tuple(
            ProgramInput(q, q, unit[q], meaning.get(q, ""), neutral[q])
            for q in mechanism.coordinates
        ),
        "v": tuple(ProgramInput(v, v, unit[v], meaning.get(v, "")) for v in speeds),
        "a": tuple(ProgramInput(f"{v}'", f"a {v}", per_second(unit[v])) for v in speeds),
        "tau": tuple(
            ProgramInput(
                f"tau_{v}", f"tau {v}", _FORCES.get(unit[v], ""), meaning.get(f"tau_{v}", "")
            )
            for v in speeds
        ),
        "p": tuple(constants),
    }


def _describe_free_joints(mechanism: Mechanism) -> dict[str, str]:
    """Return the axes and origins of coordinates, velocities and tau of balls and free bodies."""
    meaning: dict[str, str] = {}
    for joint in mechanism.joints:
        if not joint.quaternion:
            continue
        child = f"of {joint.child!r}"
        for name, axis in zip(joint.coordinates[-4:], "xyzw", strict=True):
            meaning[name] = f"{axis} of the unit quaternion {child} in the joint's frame"
        for kind, force, names in (
            ("velocity of the origin", "force at the origin", joint.linear_velocities),
            ("angular velocity", "moment about the origin", joint.angular_velocities),
        ):
            for name, axis in zip(names, "xyz", strict=False):
                axes = f"along the {axis} axis of the body itself"
                meaning |= {
                    name: f"{kind} {child}, {axes}",
                    f"tau_{name}": f"{force} {child}, {axes}",
                }
        for name, axis in zip(joint.coordinates[:-4], "xyz", strict=False):
            meaning[name] = f"origin {child} along the {axis} axis of the joint's frame"
    return meaning


_FORCES = {"rad/s": "N·m", "m/s": "N"}
"""The unit of the generalized force by that of its velocity."""


def _find_shape(quantity: Output, mechanism: Mechanism, size: int) -> tuple[int, ...]:
    if quantity.by:
        rows = {"rhs": mechanism.nq + mechanism.nv, "energy": 2}.get(quantity.base, mechanism.nv)
        if quantity.base == "mass_matrix":
            return mechanism.nv, mechanism.nv, size // max(mechanism.nv**2, 1)
        if quantity.base in ("poses", "closure", "multipliers", "reactions", "jacobians"):
            return (size,)
        return rows, size // max(rows, 1)
    if quantity.name == "mass_matrix":
        return mechanism.nv, mechanism.nv
    if quantity.name == "poses":
        return size // 12, 3, 4
    if quantity.name == "jacobians":
        return size // max(6 * mechanism.nv, 1), 6, mechanism.nv
    if quantity.name == "reactions":
        return size // 6, 6
    return (size,)


def build_modes(
    modes: Modes,
    parameters: Sequence[str] | None = None,
    name: str | None = None,
    *,
    moves: bool = False,
) -> Program:
    """Build the program of all modes that rigid bodies determine, impacts, gaps and rates."""
    mechanism = modes.mechanism
    known = require_known(mechanism, parameters)
    letters = Letters(close_contacts(mechanism), known)
    equations = SwitchingEquations(mechanism, letters, modes.idle.__contains__)
    terms, values, words = equations.terms, list[Any](), list[str]()
    for element, inside in zip(equations.elements, terms.inside, strict=True):
        if element.normal is not None:
            values += [terms.gaps[element.normal], terms.rates[element.normal]]
            words += [f"gap of {element.name}", "its rate"]
        along = (" along x", " along y") if len(element.tangents) > 1 else ("",)
        for row, axis in zip(element.tangents, along, strict=False):
            values.append(terms.rates[row])
            words.append(f"slip of {element.name}{axis}")
        if element.length is not None:
            values.append(inside)
            words.append(f"how far {element.name} is inside the ends of its side")
    quantity = Output("elements", "s", ("t", "q", "v"), ", ".join(words))
    answers = [Answer(quantity, tuple(values_of(values)), (len(values),))]
    written = [mode for mode in modes.modes if mode.accelerations or mode.unsolved]
    answers += [_write_mode(mechanism, equations, mode) for mode in written]
    answers += _write_impacts(equations)
    dynamics = TapeDynamics(letters, equations.tree, equations.tree, "closed form of each mode")
    program = assemble(dynamics, file_stem(mechanism.name, name), answers)
    base = replace(mechanism, switching=())
    corners = _list_corners(mechanism, equations) if moves else None
    return replace(program, mechanism=base, switching=mechanism.switching, corners=corners)


def _list_corners(mechanism: Mechanism, equations: SwitchingEquations) -> SwitchingTerms:
    """Return what a program needs to find in a state which mode follows."""
    if len(mechanism.switching) > MOST_ELEMENTS:
        raise DerivationError(
            f"mechanism {mechanism.name!r} has {len(mechanism.switching)} elements that switch, "
            f"whose modes an FMU tries one by one; expected at most {MOST_ELEMENTS}"
        )
    in_joints = [row.offset is not None for e in mechanism.switching for row in e.joint_rows]
    names = [row.name for row in equations.contacts]
    return SwitchingTerms(
        equations.elements,
        (*(name.endswith(": normal") for name in names), *in_joints),
        characteristic_length(replace(mechanism, switching=())),
        tuple(values_of(equations.list_terms())),
        {
            k: tuple(values_of(np.concatenate(equations.bounce(element.name))))
            for k, element in enumerate(equations.elements)
            if element.struck and len(element.tangents) < 2  # in space its friction is asked for
        },
    )


def _write_mode(mechanism: Mechanism, equations: SwitchingEquations, mode: ModeEquations) -> Answer:
    letters = equations.letters
    symbols = [s for e in equations.elements for s in name_forces(e.element, len(e.tangents))]
    if mode.unsolved:
        named = name_mode(equations.elements, mode.states)
        drive = accelerate(equations.terms, equations.elements)
        a, forces = equations.solve(named, drive)
        rows = [row for element in equations.elements for row in element.rows]
        values = values_of([*a, *(forces[row] for row in rows)])
    else:
        formulas = [*mode.accelerations.values(), *(mode.forces.get(s, 0.0) for s in symbols)]
        values = values_of([letters.number(formula, letters.values) for formula in formulas])
    held = "; ".join(mode.conditions)
    # of a single element its state says it
    words = mode.states.values() if len(mode.states) == 1 else sum(mode.states.items(), ())
    quantity = Output(
        name=_identify("mode", *words),
        symbol="a",
        takes=("t", "q", "v"),
        meaning=f"accelerations, then {', '.join(symbols)}, {held}",
        mode=tuple(mode.states.items()),
    )
    return Answer(quantity, tuple(values), (len(values),))


def _identify(*words: str) -> str:
    """Return words as a function's name."""
    text = "_".join(words).replace("slips +", "slips plus").replace("slips -", "slips minus")
    return re.sub(r"\W+", "_", text, flags=re.ASCII).strip("_")


def _write_impacts(equations: SwitchingEquations) -> Iterator[Answer]:
    """Yield the velocities after each element's impact, and its impulses."""
    struck = (rows for rows in equations.elements if rows.struck)
    for element, state in ((rows, state) for rows in struck for state in rows.impacts):
        changes, impulses = equations.bounce(element.name, state)
        after = [v + dv for v, dv in zip(equations.letters.v, changes, strict=True)]
        quantity = Output(
            name=_identify("impact", element.name, state),
            symbol="u",
            takes=("t", "q", "v"),
            meaning=f"velocities after an impact of {element.name} by itself, then its impulses",
            mode=((element.name, state),),
            struck=True,
        )
        values = values_of([*after, *(impulses[row] for row in element.rows)])
        yield Answer(quantity, tuple(values), (len(values),))


def refuse_time(mechanism: Mechanism) -> None:
    """Refuse a coordinate map that depends on time, for which impacts are not written out."""
    from sympy import Symbol, sympify

    for name, place in mechanism.coordinates.driven.items():
        if Symbol("t") in sympify(place).free_symbols:
            raise DerivationError(
                f"mechanism {mechanism.name!r}: {name!r} is moved by time; code of modes is not "
                "written for that yet"
            )
