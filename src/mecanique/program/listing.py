"""Write a program as assignments in a language, one for each result that is used repeatedly."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import final

from mecanique.errors import DerivationError
from mecanique.program.tape import Tape, Value

_LONGEST = 72
"""Expressions longer than this get a name of their own."""

_LEVELS = {"+": 1, "-": 1, "*": 2, "/": 2}
_ATOM = 4


@final
@dataclass(frozen=True)
class Notation:
    """The notation of numbers, function calls and assignments in a language."""

    # format of each function's call, by its sympy name, with {} for the arguments
    functions: Mapping[str, str]
    assignment: str  # format of an assignment to a new name, e.g. "const double {} = {};"
    number: Callable[[float], str] = repr  # writes a number


@final
@dataclass(frozen=True)
class Listing:
    """A program as text."""

    inputs: tuple[str, ...]  # names of the inputs that it uses
    lines: tuple[str, ...]  # the assignments, in order
    outputs: tuple[str, ...]  # an expression for each output
    names: Mapping[int, str]  # the name of each operation that is assigned to one, in order


def list_program(
    tape: Tape,
    outputs: Sequence[Value],
    inputs: Mapping[str, str],
    notation: Notation,
    names: Mapping[int, str] | None = None,
    fresh: str = "x",
) -> Listing:
    """Write a program as text; a result that is used once is written where it is used."""
    needed = tape.find_needed(outputs)
    uses = dict.fromkeys(needed, 0)
    for value in [*(v for place in needed for v in tape.operations[place][1]), *outputs]:
        if isinstance(value, int):
            uses[value] += 1
    written: dict[int, tuple[str, int]] = {}
    used: list[str] = []
    lines: list[str] = []
    named: dict[int, str] = {}

    def write(value: Value, level: int = 0) -> str:
        if isinstance(value, int):
            text, level_of = written[value]
        else:
            text, level_of = notation.number(value), _ATOM if value >= 0 else 0
        return text if level_of >= level else f"({text})"

    for place in needed:
        kind, values, name = tape.operations[place]
        if kind == "input":
            used.append(name)
            written[place] = inputs[name], _ATOM
            continue
        if kind in _LEVELS:
            level_of = _LEVELS[kind]
            left, right = values
            if kind == "*" and left == -1.0 and isinstance(left, float):
                text, level_of = f"-{write(right, 3)}", 1
            else:
                # operands on the right keep their parentheses, to keep the rounding
                text = f"{write(left, level_of)} {kind} {write(right, level_of + 1)}"
        elif kind in notation.functions:
            text, level_of = notation.functions[kind].format(", ".join(map(write, values))), _ATOM
        else:
            raise DerivationError(f"there is no {kind!r} in this language")
        own_name = (names or {}).get(place)
        if uses[place] > 1 or len(text) > _LONGEST or own_name is not None:
            symbol = own_name or f"{fresh}{len(lines)}"
            lines.append(notation.assignment.format(symbol, text))
            named[place] = text = symbol
            level_of = _ATOM
        written[place] = text, level_of
    return Listing(tuple(used), tuple(lines), tuple(map(write, outputs)), named)
