"""Evaluate a program, operation by operation, in numbers or in scalars of another kind."""

from __future__ import annotations

import operator
from collections.abc import Callable, Mapping, Sequence
from typing import Any

import numpy as np

from mecanique.model.expression import numpy_function
from mecanique.program.tape import Tape, Value

_ARITHMETIC = {"+": operator.add, "-": operator.sub, "*": operator.mul, "/": operator.truediv}


def replay(
    tape: Tape,
    outputs: Sequence[Value],
    read: Callable[[str], Any],
    function: Callable[[str], Callable[..., Any]],
    lift: Callable[[Any], Any] = lambda scalar: scalar,
) -> list[Any]:
    """Return the outputs as scalars of another kind, given its inputs and functions.

    Numbers, and what operations give, become such scalars by `lift`.
    """
    results: dict[int, Any] = {}

    def value(operand: Value) -> Any:
        return results[operand] if isinstance(operand, int) else lift(operand)

    for place in tape.find_needed(outputs):
        kind, operands, name = tape.operations[place]
        if kind == "input":
            results[place] = read(name)
        else:
            operation = _ARITHMETIC.get(kind) or function(kind)
            results[place] = lift(operation(*map(value, operands)))
    return [value(output) for output in outputs]


def evaluate(
    tape: Tape, outputs: Sequence[Value], inputs: Mapping[str, Any], states: int
) -> np.ndarray:
    """Return the outputs in many states, shape (states, outputs); inputs () or (states,)."""

    def read(name: str) -> np.ndarray:
        return np.asarray(inputs[name], dtype=float)

    values = replay(tape, outputs, read, numpy_function)
    columns = [np.broadcast_to(value, (states,)) for value in values]
    return np.stack(columns, axis=1) if columns else np.zeros((states, 0))
