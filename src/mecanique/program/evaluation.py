"""Evaluate a program in numbers, operation by operation."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from mecanique.model.expression import numpy_function
from mecanique.program.tape import Tape, Value

_ARITHMETIC = {"+": np.add, "-": np.subtract, "*": np.multiply, "/": np.divide}


def evaluate(
    tape: Tape, outputs: Sequence[Value], inputs: Mapping[str, Any], states: int
) -> np.ndarray:
    """Return the outputs in many states, shape (states, outputs); inputs () or (states,)."""
    results: dict[int, Any] = {}

    def value(operand: Value) -> Any:
        return results[operand] if isinstance(operand, int) else operand

    for place in tape.find_needed(outputs):
        kind, operands, name = tape.operations[place]
        if kind == "input":
            results[place] = np.asarray(inputs[name], dtype=float)
        else:
            function = _ARITHMETIC.get(kind) or numpy_function(kind)
            results[place] = function(*map(value, operands))
    columns = [np.broadcast_to(value(output), (states,)) for output in outputs]
    return np.stack(columns, axis=-1) if columns else np.zeros((states, 0))
