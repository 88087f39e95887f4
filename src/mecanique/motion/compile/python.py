"""Programs as Python functions: of floats by `math`, of arrays by numpy."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from typing import TYPE_CHECKING, Any, TypeAlias

import numpy as np

from mecanique.model.expression import FUNCTIONS, numpy_function
from mecanique.motion.compile.program import RatesProgram
from mecanique.motion.record.curve import RightHandSide

if TYPE_CHECKING:
    from mecanique.program.tape import Tape, Value


Batched: TypeAlias = Callable[[float | np.ndarray, np.ndarray, np.ndarray], None]
"""f(t, Y, out): rates of many states at once, shape (nq + nv, n) both, at one time or one each."""

_DEEPEST = 40

_FLOATS: dict[str, Any] = {
    **{name: getattr(math, name) for name in ("sin", "cos", "sqrt", "exp", "log", "asin")},
    **{name: getattr(math, name) for name in ("acos", "atan", "atan2", "pow", "tanh")},
    "Abs": abs,
    "sign": lambda x: math.copysign(1.0, x) if x else 0.0,
}
"""Functions of floats, by their names in programs."""


def scalar(program: RatesProgram) -> RightHandSide:
    """Return f(t, y) = y' of a program without open parameters; each answer is a new array."""
    return owning(overwriting(program)())


def owning(rhs: RightHandSide) -> RightHandSide:
    """Return a right-hand side with new arrays as answers, from one that overwrites its last."""
    return lambda t, y: rhs(t, y).copy()


def overwriting(program: RatesProgram) -> Callable[[], RightHandSide]:
    """Return a maker of functions f(t, y) = y', each of which overwrites its last answer."""
    lines, rates = _write(program.tape, program.rates, program)
    body = [*_begin(program, "y.tolist()"), *lines]
    body += [f"out[{k}] = {rate}" for k, rate in enumerate(rates)]
    text = [
        "def make():",
        f"    answer = empty({len(rates)})",
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
    lines, answers = _write(program.tape, values, program)
    body = [*_begin(program, "y.tolist()"), *lines]
    text = [
        "def compute(t, y):",
        *(f"    {line}" for line in body),
        f"    return {''.join(f'{answer}, ' for answer in answers)}",
    ]
    compute: Callable[[float, np.ndarray], tuple[float, ...]]
    compute = _run(program, text, _FLOATS)["compute"]
    return compute


def vectorize(program: RatesProgram, values: Sequence[np.ndarray] = ()) -> Batched:
    """Return f(t, Y, out) of a program, for many states at once."""
    from mecanique.program.half_angles import by_tangents

    lines, rates = _write(*by_tangents(program.tape, program.rates), program)
    fixed, moving = _split(program, lines)
    body = [*_begin(program, "Y"), *moving]
    body += [f"out[{k}] = {rate}" for k, rate in enumerate(rates)]
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


def _write(
    tape: Tape, outputs: Sequence[Value], program: RatesProgram
) -> tuple[list[str], list[str]]:
    """Assignments and the outputs' expressions; what is used once is written where it is used."""
    names = {name: f"s{k}" for k, name in enumerate(program.states)} | {"t": "t"}
    # a motion has no driving forces besides those described
    names |= {f"tau {velocity}": "0.0" for velocity in program.mechanism.velocities}
    needed = tape.find_needed(outputs)
    uses = dict.fromkeys(needed, 0)
    for value in [*(v for place in needed for v in tape.operations[place][1]), *outputs]:
        if isinstance(value, int):
            uses[value] += 1
    texts: dict[int, str] = {}
    depth: dict[int, int] = {}
    lines: list[str] = []

    def text(value: Value) -> str:
        return repr(value) if isinstance(value, float) else texts[value]

    for place in needed:
        kind, values, name = tape.operations[place]
        depth[place] = 1 + max((depth[v] for v in values if isinstance(v, int)), default=0)
        if kind == "input":
            texts[place] = names.get(name) or _name(name)
            continue
        words = [text(value) for value in values]
        expression = (
            f"({words[0]} {kind} {words[1]})" if kind in "+-*/" else f"{kind}({', '.join(words)})"
        )
        if uses[place] > 1 or depth[place] > _DEEPEST:
            lines.append(f"x{place} = {expression}")
            texts[place], depth[place] = f"x{place}", 0
        else:
            texts[place] = expression
    return lines, [text(value) for value in outputs]


def _split(program: RatesProgram, lines: list[str]) -> tuple[list[str], list[str]]:
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
