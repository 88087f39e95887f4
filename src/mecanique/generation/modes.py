"""Build the program of a mechanism with elements that switch: every mode, and every impact.

A mode's formulas are those that `derive_modes` solves in letters. Which mode follows is for the
caller to decide, by the forces that a mode gives and by the gaps and rates of the elements.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from typing import Any, final

from mecanique.derivation.mechanics.contacts import velocity_rows
from mecanique.derivation.mechanics.letters import Letters
from mecanique.derivation.switching import ModeEquations, Modes, force_symbol, list_letters
from mecanique.errors import DerivationError
from mecanique.generation.build import assemble, require_known
from mecanique.generation.identifiers import file_stem
from mecanique.generation.mechanics.dynamics import Dynamics, Tree
from mecanique.generation.program import Answer, Program
from mecanique.generation.quantities import Output
from mecanique.model.constraints.friction import Contact
from mecanique.model.expression import coordinate
from mecanique.model.joint_base import Single
from mecanique.model.mechanism import Mechanism
from mecanique.program.solving import factorize
from mecanique.program.traced import values_of
from mecanique.verification.modes import is_struck


@final
@dataclass(frozen=True)
class _Row:
    """A direction of an element, on a tape."""

    gap: Any  # None of a friction
    slopes: list[Any]  # shape (nv,)
    rate: Any


def build_modes(
    modes: Modes, parameters: Sequence[str] | None = None, name: str | None = None
) -> Program:
    """Build the program of all modes that rigid bodies determine, impacts, gaps and rates."""
    mechanism = modes.mechanism
    base = replace(mechanism, switching=())
    closed = tuple(e.closed for e in mechanism.switching if isinstance(e, Contact))
    known = require_known(mechanism, parameters)
    letters = Letters(replace(base, contacts=closed), known)
    tree = Tree(letters)
    rows = dict(_list_rows(mechanism, letters, tree))
    answers = [_write_elements(mechanism, rows)]
    answers += [_write_mode(mechanism, letters, mode) for mode in modes.modes if mode.accelerations]
    answers += _write_impacts(mechanism, letters, tree, rows)
    dynamics = Dynamics(letters, tree, tree, "closed form of each mode")
    program = assemble(dynamics, file_stem(mechanism.name, name), answers)
    return replace(program, mechanism=base, switching=mechanism.switching)


def _list_rows(
    mechanism: Mechanism, letters: Letters, tree: Tree
) -> Iterator[tuple[tuple[str, str], _Row]]:
    """Yield the rows of each element, by its name and the letter of the force."""
    contacts = {row.name: row for row in velocity_rows(letters, tree.recursion)}
    driven = mechanism.coordinates.driven
    for element in mechanism.switching:
        if isinstance(element, Contact):
            for letter, direction in zip(list_letters(element), ("normal", "x"), strict=False):
                row = contacts[f"{element.name}: {direction}"]
                gap = row.gap if letter == "N" else None
                yield (element.name, letter), _Row(gap, row.slopes, row.slip)
            continue
        for stated in element.joint_rows:
            whole: Any = stated.offset or 0.0
            for joint_name, weight in stated.weights:
                joint = mechanism.joint(joint_name)
                assert isinstance(joint, Single), "validated"
                way: Any = driven.get(joint.coordinate, coordinate(joint.coordinate))
                whole = whole + weight * way
            place = letters.number(whole, letters.values)
            (rate,) = letters.along([place])
            slopes = letters.slopes(place)
            speed = letters.number(stated.speed, letters.values)
            gap = None if stated.offset is None else place
            yield (element.name, stated.letter), _Row(gap, slopes, rate - speed)


def _write_elements(mechanism: Mechanism, rows: dict[tuple[str, str], _Row]) -> Answer:
    values, words = list[Any](), list[str]()
    for element in mechanism.switching:
        for letter in list_letters(element):
            row = rows[element.name, letter]
            if row.gap is None:
                values.append(row.rate)
                words.append(f"slip of {element.name}")
            else:
                values += [row.gap, row.rate]
                words += [f"gap of {element.name}", "its rate"]
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


def _write_impacts(
    mechanism: Mechanism, letters: Letters, tree: Tree, rows: dict[tuple[str, str], _Row]
) -> Iterator[Answer]:
    """Yield the velocities after each element's impact, and its impulses, by its friction."""
    struck = [element for element in mechanism.switching if is_struck(element)]
    if not struck:
        return
    factors = factorize(letters.tape, tree.mass_matrix())
    for element in struck:
        normal, *tangents = (rows[element.name, letter] for letter in list_letters(element))
        e = letters.number(getattr(element, "restitution", 0.0), letters.values)
        ratio = letters.number(element.coefficients[0], letters.values)
        for state in ("sticks", "slips +", "slips -") if tangents else ("closed",):
            impulses = _strike(factors, normal, tangents, state, e, ratio)
            after = list[Any](letters.v)
            for row, impulse in zip((normal, *tangents), impulses, strict=True):
                change = factors.solve([slope * impulse for slope in row.slopes])
                after = [v + dv for v, dv in zip(after, change, strict=True)]
            quantity = Output(
                name=_identify("impact", element.name, state),
                symbol="u",
                takes=("t", "q", "v"),
                meaning=f"velocities after an impact of {element.name} that {state}, its impulses",
                mode=((element.name, state),),
                struck=True,
            )
            values = values_of([*after, *impulses])
            yield Answer(quantity, tuple(values), (len(values),))


def _strike(
    factors: Any, normal: _Row, tangents: Sequence[_Row], state: str, e: Any, ratio: Any
) -> list[Any]:
    """Return the impulses by which rates become −e of the normal one, and none if it sticks."""

    def between(a: _Row, b: _Row) -> Any:
        return sum(x * y for x, y in zip(a.slopes, factors.solve(b.slopes), strict=True))

    wanted = -1.0 * (1.0 + e) * normal.rate
    if not tangents:
        return [wanted / between(normal, normal)]
    (tangent,) = tangents
    across = between(normal, tangent)
    if state == "sticks":
        n, t = between(normal, normal), between(tangent, tangent)
        size = n * t - across * across
        slip = -1.0 * tangent.rate
        return [(t * wanted - across * slip) / size, (n * slip - across * wanted) / size]
    share = (-1.0 if state == "slips +" else 1.0) * ratio
    impulse = wanted / (between(normal, normal) + share * across)
    return [impulse, share * impulse]


def refuse_time(mechanism: Mechanism) -> None:
    """Refuse a coordinate map that depends on time, for which impacts are not written out."""
    from sympy import Symbol, sympify

    for name, place in mechanism.coordinates.driven.items():
        if Symbol("t") in sympify(place).free_symbols:
            raise DerivationError(
                f"mechanism {mechanism.name!r}: {name!r} is moved by time; code of modes is not "
                "written for that yet"
            )
