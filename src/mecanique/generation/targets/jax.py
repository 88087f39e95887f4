"""Write JAX: short programs line by line, long ones as tables that a scan works through.

XLA compiles the derivative of a program of 2,000 lines for minutes, and that of a scan in a second.
"""

from __future__ import annotations

import heapq
import math
import textwrap
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import final

from mecanique.generation.program import Answer, Program
from mecanique.generation.targets.python import (
    NOTATION,
    Python,
    list_arguments,
    open_function,
    write_function,
)
from mecanique.generation.targets.target import list_reads
from mecanique.program.tape import Tape, Value

LONG = 400
"""Programs with more operations are written as tables."""

_SLACK = 0.8
"""Width of a row, as a part of that which would need no more rows than the longest chain."""

_ARITHMETIC = "+-*/"


@final
@dataclass(frozen=True)
class Rows:
    """Additions, subtractions, multiplications and divisions, some of each at a time."""

    first: int  # place of the first result; the results of a row follow those of the row before
    widths: tuple[int, ...]  # numbers of each operation in a row
    left: list[list[int]]  # places of the left operands, row by row
    right: list[list[int]]  # places of the right operands


@final
@dataclass(frozen=True)
class Calls:
    """Calls of one function: its name, the place of the first result, the places of arguments."""

    function: str
    first: int
    arguments: list[list[int]]


@final
class Table:
    """A program as rows of operations on an array of values: numbers, inputs, then results."""

    def __init__(self, tape: Tape, outputs: Sequence[Value]) -> None:
        needed = tape.find_needed(outputs)
        self._operations = tape.operations
        # operations that only fill a row work on the first number, 1
        self._numbers = {1.0: 0}
        for values in [*(tape.operations[place][1] for place in needed), outputs]:
            for value in values:
                if isinstance(value, float):
                    self._numbers.setdefault(value, len(self._numbers))
        self.inputs = [tape.operations[k][2] for k in needed if self._kind(k) == "input"]
        given = [k for k in needed if self._kind(k) == "input"]
        self._places = {k: len(self._numbers) + at for at, k in enumerate(given)}
        self.size = len(self._numbers) + len(given)
        self.parts: list[Rows | Calls] = []
        self._schedule(needed)
        self.outputs = [self._place(value) for value in outputs]

    @property
    def numbers(self) -> list[float]:
        """The numbers, from place 0 on."""
        return list(self._numbers)

    def _kind(self, place: int) -> str:
        return self._operations[place][0]

    def _operands(self, place: int) -> list[int]:
        """Return the operations on which one depends."""
        return [value for value in self._operations[place][1] if isinstance(value, int)]

    def _place(self, value: Value) -> int:
        return self._numbers[value] if isinstance(value, float) else self._places[value]

    def _schedule(self, needed: list[int]) -> None:
        """Plan arithmetic that needs no function, then functions of its results, and so on."""
        layer: dict[int, int] = {}
        heights = dict.fromkeys(needed, 1)
        for k in needed:
            called = self._kind(k) not in (*_ARITHMETIC, "input")
            layer[k] = max((layer[operand] for operand in self._operands(k)), default=0) + called
        for k in reversed(needed):
            for operand in self._operands(k):
                heights[operand] = max(heights[operand], heights[k] + 1)
        for number in range(max(layer.values(), default=0) + 1):
            members = [k for k in needed if layer[k] == number and k not in self._places]
            self._plan_calls([k for k in members if self._kind(k) not in _ARITHMETIC])
            self._plan_rows([k for k in members if self._kind(k) in _ARITHMETIC], heights)

    def _plan_calls(self, members: list[int]) -> None:
        for function in dict.fromkeys(map(self._kind, members)):
            called = [k for k in members if self._kind(k) == function]
            columns = zip(*(self._operations[k][1] for k in called), strict=True)
            arguments = [list(map(self._place, column)) for column in columns]
            self.parts.append(Calls(function, self.size, arguments))
            self._places |= {k: self.size + at for at, k in enumerate(called)}
            self.size += len(called)

    def _plan_rows(self, members: list[int], heights: dict[int, int]) -> None:
        """Fill rows with operations that are ready, those with most still to follow first."""
        if not members:
            return
        inside = set(members)
        users: dict[int, list[int]] = {k: [] for k in members}
        waits: dict[int, int] = {}
        depth: dict[int, int] = {}
        for k in members:
            before = inside.intersection(self._operands(k))
            waits[k] = len(before)
            depth[k] = 1 + max((depth[operand] for operand in before), default=0)
            for operand in before:
                users[operand].append(k)
        kinds = [self._kind(k) for k in members]
        deepest = max(depth.values())
        widths = tuple(math.ceil(_SLACK * kinds.count(kind) / deepest) for kind in _ARITHMETIC)
        ready: dict[str, list[tuple[int, int]]] = {kind: [] for kind in _ARITHMETIC}
        for k in members:
            if not waits[k]:
                heapq.heappush(ready[self._kind(k)], (-heights[k], k))
        rows = Rows(self.size, widths, [], [])
        while any(ready.values()):
            left: list[int] = []
            right: list[int] = []
            done: list[int] = []
            for kind, width in zip(_ARITHMETIC, widths, strict=True):
                for _ in range(width):
                    operands: tuple[Value, ...] = (1.0, 1.0)
                    if ready[kind]:
                        _, k = heapq.heappop(ready[kind])
                        operands = self._operations[k][1]
                        self._places[k] = self.size + len(left)
                        done.append(k)
                    left.append(self._place(operands[0]))
                    right.append(self._place(operands[1]))
            rows.left.append(left)
            rows.right.append(right)
            self.size += sum(widths)
            for user in (user for k in done for user in users[k]):
                waits[user] -= 1
                if not waits[user]:
                    heapq.heappush(ready[self._kind(user)], (-heights[user], user))
        self.parts.append(rows)


def write_scan(program: Program, answer: Answer) -> list[str]:
    """Return the lines of a function: a scan over tables if it has many operations."""
    if program.count(answer.quantity.name).total <= LONG:
        return write_function(program, answer)
    table, name = Table(program.tape, answer.values), f"_{answer.quantity.name.upper()}"
    read = {read.letter.place: read for read in list_reads(program, answer)}
    reads = [read[place] for place in table.inputs]
    constants = [f"{name}_NUMBERS = {_wrap(map(repr, table.numbers))}"]
    inputs = _wrap((read.symbol for read in reads), 4)
    lines = [
        *open_function(answer, reads),
        f"    inputs = {inputs}",
        f"    given = [{list_arguments(answer)}]",
        f"    values = _start({name}_NUMBERS, inputs, {table.size}, _lead(given))",
    ]
    for number, part in enumerate(table.parts):
        if isinstance(part, Calls):
            arguments = ", ".join(_pick(row) for row in part.arguments)
            called = NOTATION.functions[part.function].format(arguments)
            lines.append(f"    values = _put(values, {part.first}, {called})")
        else:
            pairs = zip(part.left, part.right, strict=True)
            rows = "\n".join(textwrap.fill(f"({left}, {right}),", 94) for left, right in pairs)
            constants.append(f"{name}_{number} = [\n{textwrap.indent(rows, '    ')}\n]")
            lines.append(f"    values = _run(values, {part.first}, {part.widths}, {name}_{number})")
    lines.append(f"    out = np.moveaxis({_pick(table.outputs)}, 0, -1)")
    return [
        *constants,
        "",
        "",
        *lines,
        f"    return np.reshape(out, out.shape[:-1] + {answer.shape})",
    ]


def _pick(places: Sequence[int]) -> str:
    return f"_take(values, {_wrap(map(str, places), 4)})"


def _wrap(words: Iterable[str], indent: int = 0) -> str:
    """Write a list, over several lines if it is long."""
    text = ", ".join(words)
    if len(text) < 60:
        return f"[{text}]"
    lines = textwrap.fill(f"{text},", 90, break_long_words=False, break_on_hyphens=False)
    return f"[\n{textwrap.indent(lines, ' ' * (indent + 4))}\n{' ' * indent}]"


_HELPERS = '''


def _start(numbers, inputs, size, leading):
    """Return values, shape (size, ...): numbers, then inputs, the others still zero."""
    inputs = [np.broadcast_to(entry, leading) for entry in inputs]
    numbers = np.stack([np.broadcast_to(number, leading) for number in numbers])
    begun = np.concatenate([numbers, np.stack(inputs)]) if inputs else numbers
    return np.zeros((size, *leading), begun.dtype).at[: len(begun)].set(begun)


def _take(values, places):
    return values.at[np.array(places)].get(mode="promise_in_bounds")


def _put(values, first, entries):
    return jax.lax.dynamic_update_slice_in_dim(values, entries, first, 0)


def _run(values, first, widths, table):
    """Work through a table: each row adds, subtracts, multiplies and divides earlier values."""
    i, j, k, width = (sum(widths[:n]) for n in (1, 2, 3, 4))

    def advance(values, row):
        at, (left, right) = row
        x, y = _take(values, left), _take(values, right)
        parts = [x[:i] + y[:i], x[i:j] - y[i:j], x[j:k] * y[j:k], x[k:] / y[k:]]
        return _put(values, at, np.concatenate(parts)), None

    places = first + width * np.arange(len(table))
    return jax.lax.scan(advance, values, (places, np.array(table)))[0]
'''.rstrip("\n")

JAX = Python("Python with JAX", "jax", "jax.numpy", write_scan, _HELPERS)
"""A Python module that computes with JAX."""
