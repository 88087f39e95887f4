"""Build the program of a mechanism with elements that switch: every mode, and every impact.

A mode's formulas are those that `derive_modes` solves in letters. Which mode follows is for the
caller to decide, by the forces that a mode gives and by the gaps and rates of the elements.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Sequence
from dataclasses import replace
from typing import Any

from mecanique.derivation.mechanics.letters import Letters
from mecanique.derivation.mechanics.switching import bounce, close_contacts, name_mode, strike
from mecanique.derivation.switching import ModeEquations, Modes, force_symbol, list_letters
from mecanique.errors import DerivationError
from mecanique.generation.build import assemble, require_known
from mecanique.generation.identifiers import file_stem
from mecanique.generation.mechanics.dynamics import TapeDynamics
from mecanique.generation.mechanics.switching import SwitchingEquations
from mecanique.generation.program import Answer, Program, SwitchingTerms
from mecanique.generation.quantities import Output
from mecanique.model.mechanism import Mechanism
from mecanique.model.mechanism_units import characteristic_length
from mecanique.program.traced import values_of

MOST_ELEMENTS = 6
"""An FMU tries 4 states of each element at a corner, with as many as these 4,096 modes."""


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
    # the equations of modes are derived of contacts that slip along x alone
    equations = SwitchingEquations(mechanism, letters, idle=lambda name: name.endswith(": y"))
    answers = [_write_elements(equations)]
    answers += [_write_mode(mechanism, letters, mode) for mode in modes.modes if mode.accelerations]
    answers += _write_impacts(equations)
    dynamics = TapeDynamics(letters, equations.tree, equations.tree, "closed form of each mode")
    program = assemble(dynamics, file_stem(mechanism.name, name), answers)
    base = replace(mechanism, switching=())
    corners = _list_corners(mechanism, equations) if moves else None
    return replace(program, mechanism=base, switching=mechanism.switching, corners=corners)


def _list_corners(mechanism: Mechanism, equations: SwitchingEquations) -> SwitchingTerms:
    """Return what a program needs to find in a state which mode follows."""
    for element in mechanism.switching:
        if getattr(element, "law", "newton") != "newton":
            raise DerivationError(
                f"the impacts of {element.name!r} follow Poisson's law, which an FMU does not "
                'have; give it law="newton"'
            )
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
    )


def _write_elements(equations: SwitchingEquations) -> Answer:
    terms, values, words = equations.terms, list[Any](), list[str]()
    for element in equations.elements:
        for row in element.rows:
            values += [terms.gaps[row]] if row == element.normal else []
            values.append(terms.rates[row])
            pressing = (f"gap of {element.name}", "its rate")
            words += pressing if row == element.normal else [f"slip of {element.name}"]
    quantity = Output("elements", "s", ("t", "q", "v"), ", ".join(words))
    return Answer(quantity, tuple(values_of(values)), (len(values),))


def _write_mode(mechanism: Mechanism, letters: Letters, mode: ModeEquations) -> Answer:
    symbols = list(_list_symbols(mechanism))
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


def _list_symbols(mechanism: Mechanism) -> Iterator[str]:
    for element in mechanism.switching:
        yield from (force_symbol(letter, element.name) for letter in list_letters(element))


def _identify(*words: str) -> str:
    """Return words as a function's name."""
    text = "_".join(words).replace("slips +", "slips plus").replace("slips -", "slips minus")
    return re.sub(r"\W+", "_", text, flags=re.ASCII).strip("_")


def _write_impacts(equations: SwitchingEquations) -> Iterator[Answer]:
    """Yield the velocities after each element's impact, and its impulses, by its friction."""
    terms, elements = equations.terms, equations.elements
    for element in filter(lambda element: element.struck, elements):
        for state in element.states[1:]:
            mode = name_mode(elements, {element.name: state})
            drive = strike(terms, bounce(terms, element), elements)
            changes, impulses = equations.solve(mode, drive)
            after = [v + dv for v, dv in zip(equations.letters.v, changes, strict=True)]
            quantity = Output(
                name=_identify("impact", element.name, state),
                symbol="u",
                takes=("t", "q", "v"),
                meaning=f"velocities after an impact of {element.name} that {state}, its impulses",
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
