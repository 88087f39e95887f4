"""Programs as Python functions: of floats by `math`, of arrays by numpy."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from typing import TYPE_CHECKING, Any, TypeAlias

import numpy as np

from mecanique.model.expression import FUNCTIONS, numpy_function
from mecanique.motion.compile.program import RatesProgram
from mecanique.motion.record.curve import RightHandSide
from mecanique.program.listing import Listing, Notation, list_program

if TYPE_CHECKING:
    from mecanique.program.tape import Tape, Value


Batched: TypeAlias = Callable[[float | np.ndarray, np.ndarray, np.ndarray], None]
"""f(t, Y, out): rates of many states at once, shape (nq + nv, n) both, at one time or one each."""

_FLOATS: dict[str, Any] = {
    **{name: getattr(math, name) for name in ("sin", "cos", "sqrt", "exp", "log", "asin")},
    **{name: getattr(math, name) for name in ("acos", "atan", "atan2", "pow", "tanh")},
    "Abs": abs,
    "sign": lambda x: math.copysign(1.0, x) if x else 0.0,
}
"""Functions of floats, by their names in programs."""

_NOTATION = Notation({name: f"{name}({{}})" for name in {*_FLOATS, *FUNCTIONS}}, "{} = {}")


def scalar(program: RatesProgram) -> RightHandSide:
    """Return f(t, y) = y' of a program without open parameters; each answer is a new array."""
    return owning(overwriting(program)())


def owning(rhs: RightHandSide) -> RightHandSide:
    """Return a right-hand side with new arrays as answers, from one that overwrites its last."""
    return lambda t, y: rhs(t, y).copy()


def overwriting(program: RatesProgram) -> Callable[[], RightHandSide]:
    """Return a maker of functions f(t, y) = y', each of which overwrites its last answer."""
    listing = _write(program.tape, program.rates, program)
    body = [*_begin(program, "y.tolist()"), *listing.lines]
    body += [f"out[{k}] = {rate}" for k, rate in enumerate(listing.outputs)]
    text = [
        "def make():",
        f"    answer = empty({len(program.rates)})",
        "    out = memoryview(answer)",
        "    def rhs(t, y):",
        *(f"        {line}" for line in body),
        "        return answer",
        "    return rhs",
    ]
    make: Callable[[], RightHandSide] = _run(program, text, _FLOATS | {"empty": np.empty})["make"]
    return make


def list_values(
    program: RatesProgram, values: Sequence[Value]
) -> Callable[[float, np.ndarray], tuple[float, ...]]:
    """Return f(t, y) that lists values of the tape of a program without open parameters."""
    listing = _write(program.tape, values, program)
    body = [*_begin(program, "y.tolist()"), *listing.lines]
    text = [
        "def compute(t, y):",
        *(f"    {line}" for line in body),
        f"    return {''.join(f'{answer}, ' for answer in listing.outputs)}",
    ]
    compute: Callable[[float, np.ndarray], tuple[float, ...]]
    compute = _run(program, text, _FLOATS)["compute"]
    return compute


def vectorize(program: RatesProgram, values: Sequence[np.ndarray] = ()) -> Batched:
    """Return f(t, Y, out) of a program, for many states at once."""
    from mecanique.program.half_angles import by_tangents

    listing = _write(*by_tangents(program.tape, program.rates), program)
    fixed, moving = _split(program, listing.lines)
    body = [*_begin(program, "Y"), *moving]
    body += [f"out[{k}] = {rate}" for k, rate in enumerate(listing.outputs)]
    text = [
        f"def build({', '.join(map(_name, program.open))}):",
        *(f"    {line}" for line in fixed),
        "    def rhs(t, Y, out):",
        *(f"        {line}" for line in body),
        "    return rhs",
    ]
    functions = {name: numpy_function(name) for name in (*FUNCTIONS, "pow")}
    rhs: Batched = _run(program, text, functions)["build"](*values)
    return rhs


def _begin(program: RatesProgram, states: str) -> list[str]:
    """The lines that read the state, and the signals at its time."""
    names = ", ".join(f"s{k}" for k in range(len(program.states)))
    signals = [f"{_name(symbol)} = {_name(symbol)}_(t)" for symbol in program.signals]
    return [f"[{names}] = {states}", *signals]


def _run(
    program: RatesProgram, text: Sequence[str], functions: Mapping[str, Any]
) -> dict[str, Any]:
    """Return what lines of Python define, by name."""
    inputs = {signal.symbol: signal for signal in program.mechanism.inputs}
    values = program.mechanism.values
    signals = {f"{_name(s)}_": inputs[s].function(values) for s in program.signals}
    space: dict[str, Any] = {**functions, **signals}
    exec(compile("\n".join(text), f"<equations of {program.mechanism.name}>", "exec"), space)
    return space


def _name(symbol: str) -> str:
    """A letter of the mechanism as a name in Python; letters may be keywords or end in dashes."""
    return "i_" + symbol.replace("'", "_p")


def _write(tape: Tape, outputs: Sequence[Value], program: RatesProgram) -> Listing:
    """Write values of a tape, by the names that `_begin` gives the state."""
    names = {name: f"s{k}" for k, name in enumerate(program.states)} | {"t": "t"}
    # a motion has no driving forces besides those described
    names |= {f"tau {velocity}": "0.0" for velocity in program.mechanism.velocities}
    names |= {symbol: _name(symbol) for symbol in (*program.open, *program.signals)}
    return list_program(tape, outputs, names, _NOTATION)


def _split(program: RatesProgram, lines: Sequence[str]) -> tuple[list[str], list[str]]:
    """Assignments that depend on parameters alone, and the others."""
    import re

    moving_names = (
        {f"s{k}" for k in range(len(program.states))} | {"t"} | set(map(_name, program.signals))
    )
    fixed, moving = [], []
    for line in lines:
        target, _, expression = line.partition(" = ")
        if moving_names & set(re.findall(r"[A-Za-z_]\w*", expression)):
            moving.append(line)
            moving_names.add(target)
        else:
            fixed.append(line)
    return fixed, moving
