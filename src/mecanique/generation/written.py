"""Equations of any size as text: a recursion from body to body, each result named and defined."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import final

from mecanique.derivation.equations import Equations
from mecanique.errors import DerivationError
from mecanique.generation.mechanics.dynamics import Dynamics, Tree
from mecanique.generation.mechanics.letters import Letters
from mecanique.generation.mechanics.recursion import Recursion
from mecanique.generation.program.listing import Notation, list_program
from mecanique.generation.program.tape import Tape
from mecanique.generation.program.traced import Traced, value_of

__all__ = ["Written", "write_recursion"]

_CALLS = ("sin", "cos", "tan", "sqrt", "exp", "log", "asin", "acos", "atan", "tanh", "sign")
_NOTATION = Notation(
    {name: f"{name}({{}})" for name in _CALLS} | {"Abs": "abs({})"}, "{} = {}", lambda x: f"{x!r}"
)
_MEANINGS = {
    "w": "angular velocity of {} [rad/s]",
    "alpha": "angular acceleration of {} [rad/s²]",
    "a": "acceleration of the origin of {} less that of free fall [m/s²]",
    "F": "force that moves {} and all that hangs on it [N]",
    "N": "moment that turns {} and all that hangs on it, about its origin [N·m]",
}
_INTRODUCTION = (
    "The closed form is too long for a reader; this is the same as a recursion from body to body: "
    "outwards the motion of each, inwards the forces that make it. All components are in the axes "
    "of the body. What of a body its parent carries alike, such as a mass on the axis of its "
    "hinge, is counted with the parent."
)


@final
@dataclass(frozen=True)
class Written:
    """Equations of motion as a list of named results.

    Args:
        meanings: symbols, and what they are.
        lines: the results in order, name = formula.
        equations: the equations of motion, formula = 0, one for each velocity.
    """

    meanings: tuple[tuple[str, str], ...]
    lines: tuple[str, ...]
    equations: tuple[str, ...]

    def __str__(self) -> str:
        wide = max(len(names) for names, _ in self.meanings)
        out = [_INTRODUCTION, "", "Symbols"]
        out += [f"  {names:<{wide}}  {sentence}" for names, sentence in self.meanings]
        out += ["", "Recursion"]
        digits = len(str(len(self.lines)))
        for number, line in enumerate(self.lines, 1):
            label = f"({number})"
            out.append(f"  {label:>{digits + 2}}  {line}")
        return "\n".join([*out, "", "Equations of motion", *(f"  {row}" for row in self.equations)])


def write_recursion(equations: Equations) -> Written:
    """Return equations of motion of any size as a recursion, which parses back.

    It is Newton and Euler's recursion (J. Y. S. Luh, M. W. Walker & R. P. C. Paul, 1980), with
    parameters as letters.

    Args:
        equations: the equations of motion.

    Raises:
        DerivationError: if the mechanism has loops, contacts or velocity constraints, or its
            coordinate map no derivatives.
    """
    mechanism = equations.mechanism
    if mechanism.constrained:
        raise DerivationError(
            f"mechanism {mechanism.name!r} is closed or rolls, which no recursion along its tree "
            "tells of"
        )
    letters = Letters(mechanism, tuple(mechanism.values))
    tree = Tree(letters)
    dynamics = Dynamics(letters, tree, tree, "recursion")
    outputs = dynamics.answer("inverse_dynamics")
    names, found = _name_results(tree.recursion), list[tuple[str, str]]()
    names |= _name_functions(letters.tape, names)
    inputs = {name: name for name in (*mechanism.coordinates, *mechanism.velocities)}
    inputs |= {f"a {name}": f"{name}'" for name in mechanism.velocities}
    inputs |= {name: name for name in ("t", *mechanism.values, *letters.signals)}
    listing = list_program(letters.tape, outputs, inputs, _NOTATION, names)
    lines = tuple(line.replace(" * ", " ").replace(" / ", "/") for line in listing.lines)
    defined = {line.partition(" = ")[0] for line in lines}
    for name in (*mechanism.coordinates, *mechanism.velocities):
        found.append((name, "generalized velocity" if name.endswith("'") else "coordinate"))
    for parameter in mechanism.parameters:
        if parameter.symbol in listing.inputs:
            unit = "" if parameter.unit == "1" else f" [{parameter.unit}]"
            found.append((parameter.symbol, f"{parameter.meaning or 'parameter'}{unit}"))
    found += _explain_results(tree.recursion, defined)
    found.append(("x1, x2 …", "results that stand in several others"))
    rows = []
    for output in listing.outputs:
        rows.append(f"{output.replace(' * ', ' ').replace(' / ', '/')} = 0")
    return Written(tuple(found), lines, tuple(rows))


def _bodies(recursion: Recursion) -> list[str]:
    """The body that each moving link is called after."""
    first: dict[int, str] = {}
    for body, seat in recursion.seats.items():
        first.setdefault(seat.place, body)
    return [first.get(place, f"link{place + 1}") for place in range(len(recursion.links))]


def _name_results(recursion: Recursion) -> dict[int, str]:
    """The names of the components of the links' vectors, by place on the tape."""
    names: dict[int, str] = {}
    for letter, vectors in recursion.found.items():
        for body, vector in zip(_bodies(recursion), vectors, strict=True):
            word = "".join(sign if sign.isalnum() else "_" for sign in body)
            for axis, component in zip("xyz", vector, strict=True):
                known = isinstance(component, Traced)
                place = value_of(component) if known else None
                inner = isinstance(place, int) and recursion.letters.tape.operations[place]
                if isinstance(place, int) and inner and inner[0] != "input":
                    names.setdefault(place, f"{letter}_{word}_{axis}")
    return names


def _name_functions(tape: Tape, taken: dict[int, str]) -> dict[int, str]:
    """Sines and cosines of coordinates by name: s_q1 and c_q1."""
    names: dict[int, str] = {}
    for place, (kind, values, _) in enumerate(tape.operations):
        if kind in ("sin", "cos") and place not in taken:
            (inner,) = values
            operation = tape.operations[inner] if isinstance(inner, int) else ("", (), "")
            if operation[0] == "input":
                names[place] = f"{kind[0]}_{operation[2]}"
    return names


def _explain_results(recursion: Recursion, defined: set[str]) -> Iterator[tuple[str, str]]:
    """What the named vectors are, where a component of them stands in the list."""
    for body in _bodies(recursion):
        word = "".join(sign if sign.isalnum() else "_" for sign in body)
        for letter, sentence in _MEANINGS.items():
            parts = [name for axis in "xyz" if (name := f"{letter}_{word}_{axis}") in defined]
            if parts:
                yield ", ".join(parts), sentence.format(body)
    for name in sorted(defined):
        if name.startswith(("s_", "c_")):
            yield name, f"{'sine' if name[0] == 's' else 'cosine'} of {name[2:]}"
