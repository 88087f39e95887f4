"""The interface of a language: write a program, write its test, and state how to run the test."""

from __future__ import annotations

import subprocess
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import NamedTuple, Protocol, final, runtime_checkable

import numpy as np

from mecanique.generation.identifiers import identifiers
from mecanique.generation.program import Answer, Program, ProgramInput
from mecanique.program.listing import Listing, Notation, list_program


@final
@dataclass(frozen=True)
class Cases:
    """States with the values of the reference.

    Differences are relative: the norm of weight × difference over the entries of an answer.
    """

    inputs: dict[str, np.ndarray]  # values of t, q, v, a, tau and p, each shape (n, any)
    expected: dict[str, np.ndarray]  # values of the reference, by quantity, each shape (n, any)
    weights: dict[str, np.ndarray]  # weights of the same shapes
    # largest relative difference in each state, by quantity, each shape (n,)
    allowed: dict[str, np.ndarray]

    def __len__(self) -> int:
        return len(self.inputs["t"])

    @property
    def _tables(self) -> tuple[dict[str, np.ndarray], ...]:
        return self.inputs, self.expected, self.weights, self.allowed

    def first(self, number: int) -> Cases:
        """Return the first states."""
        cut = []
        for table in self._tables:
            cut.append({name: rows[:number] for name, rows in table.items()})
        return Cases(*cut)

    def join(self, more: Cases) -> Cases:
        """Return these states followed by others."""
        pairs = zip(self._tables, more._tables, strict=True)
        joined = []
        for a, b in pairs:
            joined.append({name: np.concatenate([a[name], b[name]]) for name in a})
        return Cases(*joined)


def run_command(
    command: Sequence[str], seconds: float | None = None
) -> subprocess.CompletedProcess[str]:
    """Run a command to its end, or for some seconds, and keep what it prints."""
    return subprocess.run(
        command,
        capture_output=True,
        encoding="utf-8",
        errors="replace",
        check=False,
        timeout=seconds,
    )


@runtime_checkable
class Target(Protocol):
    """A language."""

    @property
    def title(self) -> str:
        """The name of the language."""

    def files(self, program: Program, head: Sequence[str]) -> Mapping[str, str | bytes]:
        """Return the files of a program, by name.

        Args:
            program: the program.
            head: lines of the comment at the top.
        """

    def test_files(self, program: Program, cases: Cases) -> dict[str, str]:
        """Return the files of a program's test, by name.

        The test prints a line "quantity difference state" for each answer, and fails if one
        differs by more than is allowed.

        Args:
            program: the program.
            cases: the states.
        """

    def commands(self, program: Program, directory: Path) -> list[list[str]]:
        """Return the commands that build and run the test.

        Args:
            program: the program.
            directory: directory of its files.

        Raises:
            InputError: if a tool that they need is not installed.
        """

    def version(self) -> str:
        """Return name and version of the tool that runs the code."""


_NAMES = (
    *("sin", "cos", "tan", "asin", "acos", "atan", "atan2"),
    *("sqrt", "exp", "log", "tanh", "pow", "Abs", "sign"),
)
"""Functions by their names in programs."""


def call_functions(prefix: str, assignment: str, **other: str) -> Notation:
    """Return a notation in which functions have their names in programs or others, and a prefix."""
    calls = {name: f"{prefix}{other.get(name, name)}({{}})" for name in _NAMES}
    return Notation(calls, assignment)


def symbols_of(program: Program) -> dict[str, tuple[str, ...]]:
    """Return an identifier for every input, by kind."""

    def names(kind: str) -> list[str]:
        kind_of_letter = "v" if kind in ("a", "tau") else kind
        return [letter.name for letter in program.letters[kind_of_letter]]

    return {"t": ("t",)} | {
        kind: identifiers(kind, names(kind)) for kind in ("q", "v", "a", "tau", "p")
    }


class Read(NamedTuple):
    """An input that a function uses: symbol = array[place]; the time is not an array."""

    letter: ProgramInput
    symbol: str
    array: str
    place: int


def list_reads(program: Program, answer: Answer, *, stacked: bool = False) -> list[Read]:
    """Return the inputs that an answer may read."""
    stacked = stacked or "y" in answer.quantity.takes
    symbols, letters = symbols_of(program), program.letters
    reads = []
    kinds = [part for kind in answer.quantity.takes for part in ("qv" if kind == "y" else [kind])]
    for kind in (*kinds, "p"):
        array = "y" if stacked and kind in ("q", "v") else kind
        offset = len(letters["q"]) if stacked and kind == "v" else 0
        for k, (letter, symbol) in enumerate(zip(letters[kind], symbols[kind], strict=True)):
            reads.append(Read(letter, symbol, array, offset + k))
    return reads


def list_answer(
    program: Program, answer: Answer, notation: Notation, *, stacked: bool = False
) -> tuple[Listing, list[Read]]:
    """Return the text of an answer and the inputs that it reads."""
    reads = list_reads(program, answer, stacked=stacked)
    spelled = {read.letter.place: read.symbol for read in reads}
    listing = list_program(program.tape, answer.values, spelled, notation)
    return listing, [read for read in reads if read.letter.place in listing.inputs]


def describe(letters: Sequence[ProgramInput]) -> list[str]:
    """Return a line for each input: its number, name, unit and meaning."""
    lines = []
    for k, letter in enumerate(letters):
        unit = f" [{letter.unit}]" if letter.unit else ""
        meaning = f": {letter.meaning}" if letter.meaning else ""
        lines.append(f"{k}  {letter.name}{unit}{meaning}")
    return lines
