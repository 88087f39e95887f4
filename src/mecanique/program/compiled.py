"""Compile a program to one Python function of floats."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from typing import Any

from mecanique.model.expression import FUNCTIONS
from mecanique.program.listing import Notation, list_program
from mecanique.program.tape import Tape, Value

FLOATS: dict[str, Any] = {
    **{name: getattr(math, name) for name in ("sin", "cos", "sqrt", "exp", "log", "asin")},
    **{name: getattr(math, name) for name in ("acos", "atan", "atan2", "pow", "tanh")},
    "Abs": abs,
    "sign": lambda x: math.copysign(1.0, x) if x else 0.0,
}
"""Functions of floats, by their names in programs."""

PYTHON = Notation({name: f"{name}({{}})" for name in {*FLOATS, *FUNCTIONS}}, "{} = {}")


def compile_program(
    tape: Tape, outputs: Sequence[Value], inputs: Sequence[str]
) -> Callable[..., tuple[float, ...]]:
    """Return a function of the inputs, in their order, that lists the outputs."""
    letters = {name: f"i{k}" for k, name in enumerate(inputs)}
    listing = list_program(tape, outputs, letters, PYTHON)
    answer = "".join(f"{output}, " for output in listing.outputs)
    body = [*listing.lines, f"return ({answer})"]
    text = "\n    ".join([f"def compute({', '.join(letters.values())}):", *body])
    space = dict(FLOATS)
    exec(compile(text, "<program>", "exec"), space)
    compute: Callable[..., tuple[float, ...]] = space["compute"]
    return compute
