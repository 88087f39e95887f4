"""Describe a model by the FMI standard: its variables, their units and their order.

Functional Mock-up Interface Specification, version 3.0 (Modelica Association, 2022).
"""

from __future__ import annotations

import hashlib
from collections.abc import Iterator
from dataclasses import dataclass
from typing import final

from mecanique.errors import DerivationError
from mecanique.generation.program import Answer, Program
from mecanique.model.dimensions import read_unit
from mecanique.model.units import per_second
from mecanique.urdf.markup import quote

TOLERANCE = 1e-8
"""Default relative tolerance of a simulation."""


@final
@dataclass(frozen=True)
class Variable:
    """A variable of a model; its index among the others is its value reference.

    Args:
        name: its unique name.
        kind: "time", "state", "rate", "parameter", "input" or "output".
        unit: its unit, "" if it has none.
        meaning: its meaning, in a few words.
        start: its initial value; None if it is computed.
        fixed: whether a parameter must not change during a simulation.
    """

    name: str
    kind: str
    unit: str = ""
    meaning: str = ""
    start: float | None = None
    fixed: bool = False


def variables_of(program: Program) -> tuple[Variable, ...]:
    """Return the variables of a program to be integrated: time, states, rates, p, outputs.

    Args:
        program: the program.

    Raises:
        DerivationError: if two variables have the same name.
    """
    letters, fixed = program.letters, _find_fixed(program)
    states = [*letters["q"], *letters["v"]]
    found = [Variable("time", "time", "s")]
    for state, value in zip(states, program.start, strict=True):
        found.append(Variable(state.name, "state", state.unit, start=value))
    for state in states:
        found.append(Variable(f"der({state.name})", "rate", per_second(state.unit)))
    for letter in letters["p"]:
        kind = "parameter" if letter.name in program.mechanism.values else "input"
        held = letter.place in fixed
        found.append(
            Variable(
                name=letter.name,
                kind=kind,
                unit=letter.unit,
                meaning=letter.meaning,
                start=letter.value,
                fixed=held,
            )
        )
    for letter in letters["tau"]:
        meaning = "added to the forces of the mechanism"
        found.append(Variable(letter.name, "input", letter.unit, meaning, 0.0))
    for answer in results_of(program):
        labels = _label(program, answer)
        meaning = answer.quantity.meaning
        found += [Variable(name, "output", unit, meaning) for name, unit in labels]
    names = [variable.name for variable in found]
    twice = sorted({name for name in names if names.count(name) > 1})
    if twice:
        raise DerivationError(f"two variables of the model would be called {twice[0]!r}")
    return tuple(found)


def results_of(program: Program) -> list[Answer]:
    """Return the answers that are outputs: all except the rates of the state.

    Args:
        program: the program.
    """
    return [answer for answer in program.answers if answer.quantity.name != "rhs"]


def token_of(program: Program) -> str:
    """Return the token that ties the description of a model to its binary.

    Args:
        program: the program.
    """
    names = [(v.name, v.kind, v.unit, v.start) for v in variables_of(program)]
    text = repr((program.name, names, program.count()))
    return f"{{{hashlib.sha256(text.encode()).hexdigest()[:32]}}}"


def describe_model(program: Program, generator: str) -> str:
    """Return the modelDescription.xml of a program.

    Args:
        program: the program.
        generator: name and version of the generating tool.
    """
    variables = variables_of(program)
    places = {kind: _find_places(variables, kind) for kind in ("state", "rate", "output")}
    first = places["rate"][0] - places["state"][0] if places["state"] else 0
    held = 'needsCompletedIntegratorStep="true" ' if program.landing is not None else ""
    same = (
        f'modelIdentifier={quote(program.name)} canGetAndSetFMUState="true" '
        'canSerializeFMUState="true"'
    )
    lines = [
        '<?xml version="1.0" encoding="UTF-8"?>',
        f'<fmiModelDescription fmiVersion="3.0" modelName={quote(program.mechanism.name)}',
        f'  instantiationToken="{token_of(program)}" generationTool={quote(generator)}',
        '  variableNamingConvention="flat">',
        f"  <ModelExchange {held}{same}/>",
        f'  <CoSimulation {same} canHandleVariableCommunicationStepSize="true"/>',
        *_write_units(variables),
        f'  <DefaultExperiment startTime="0" stopTime="10" tolerance="{TOLERANCE!r}"/>',
        "  <ModelVariables>",
    ]
    for place, variable in enumerate(variables):
        lines.append(_write_variable(place, variable, first))
    lines += ["  </ModelVariables>", "  <ModelStructure>"]
    shown = sorted([*places["state"], *places["output"]])
    lines += [f'    <Output valueReference="{k}"/>' for k in shown]
    lines += [f'    <ContinuousStateDerivative valueReference="{k}"/>' for k in places["rate"]]
    unknown = [*places["rate"], *places["output"]]
    lines += [f'    <InitialUnknown valueReference="{k}"/>' for k in unknown]
    return "\n".join([*lines, "  </ModelStructure>", "</fmiModelDescription>", ""])


def _write_variable(place: int, variable: Variable, before: int) -> str:
    """Write a variable; `before` is the distance from a state to its rate."""
    how = {
        "time": 'causality="independent" variability="continuous"',
        "state": 'causality="output" variability="continuous" initial="exact"',
        "rate": 'causality="local" variability="continuous" initial="calculated" '
        f'derivative="{place - before}"',
        "parameter": f'causality="parameter" initial="exact" '
        f'variability="{"fixed" if variable.fixed else "tunable"}"',
        "input": 'causality="input" variability="continuous"',
        "output": 'causality="output" variability="continuous" initial="calculated"',
    }[variable.kind]
    words = [f"<Float64 name={quote(variable.name)}", f'valueReference="{place}"', how]
    if variable.start is not None:
        words.append(f'start="{variable.start!r}"')
    if variable.unit:
        words.append(f"unit={quote(variable.unit)}")
    if variable.meaning:
        words.append(f"description={quote(variable.meaning)}")
    return f"    {' '.join(words)}/>"


def _write_units(variables: tuple[Variable, ...]) -> Iterator[str]:
    """Yield the units in SI base units; a radian counts as a unit in rad, rad/s and rad/s²."""
    yield "  <UnitDefinitions>"
    for unit in sorted({variable.unit for variable in variables if variable.unit}):
        exponents = dict(zip(("kg", "m", "s", "A", "K"), read_unit(unit), strict=True))
        exponents["rad"] = int(unit in ("rad", "rad/s", "rad/s²"))
        stated = [f'{base}="{power}"' for base, power in exponents.items() if power]
        base = " ".join(["<BaseUnit", *stated])
        yield f"    <Unit name={quote(unit)}>{base}/></Unit>"
    yield "  </UnitDefinitions>"


def _find_places(variables: tuple[Variable, ...], kind: str) -> list[int]:
    return [place for place, variable in enumerate(variables) if variable.kind == kind]


def _find_fixed(program: Program) -> set[str]:
    """Find the inputs on which the closure of loops depends."""
    if program.landing is None:
        return set()
    tape = program.tape
    operations = [tape.operations[k] for k in tape.find_needed(program.landing.gaps)]
    return {name for kind, _, name in operations if kind == "input"}


def _label(program: Program, answer: Answer) -> list[tuple[str, str]]:
    """Return the name and unit of each entry of an answer."""
    quantity = answer.quantity
    if quantity.name == "energy":
        return [("kinetic_energy", "J"), ("potential_energy", "J")]
    if quantity.name == "acceleration":
        return [(f"{letter.name}'", letter.unit) for letter in program.letters["a"]]
    if quantity.name == "poses":
        return list(_label_poses(program))
    if quantity.name == "reactions":
        return list(_label_reactions(program))
    forces = quantity.name in ("bias", "gravity", "forces")
    units = [letter.unit for letter in program.letters["tau"]] if forces else []
    units = units or [""] * len(answer.values)
    indices = _list_indices(answer.shape)
    names = [f"{quantity.name}[{','.join(map(str, index))}]" for index in indices]
    return list(zip(names, units, strict=True))


def _label_poses(program: Program) -> Iterator[tuple[str, str]]:
    mechanism = program.mechanism
    for body in mechanism.bodies:
        if body.name != mechanism.ground:
            for row in range(1, 4):
                for column in range(1, 5):
                    yield f"pose[{body.name},{row},{column}]", "m" if column == 4 else ""


def _label_reactions(program: Program) -> Iterator[tuple[str, str]]:
    mechanism = program.mechanism
    for each in (*mechanism.joints, *mechanism.loops):
        for part, unit in (("F", "N"), ("M", "N·m")):
            for axis in "xyz":
                yield f"reaction[{each.name},{part}{axis}]", unit


def _list_indices(shape: tuple[int, ...]) -> list[tuple[int, ...]]:
    """Return the indices from 1 on, row by row."""
    found: list[tuple[int, ...]] = [()]
    for size in shape:
        found = [(*index, k) for index in found for k in range(1, size + 1)]
    return found
