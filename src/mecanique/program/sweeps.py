"""Differentiate a program on its own tape: forward along a direction, or in reverse.

Both apply the chain rule operation by operation (R. E. Wengert, Comm. ACM 7 (1964) 463; S.
Linnainmaa, BIT 16 (1976) 146). Second derivatives are sweeps of sweeps.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from functools import partial
from typing import Any

from mecanique.errors import DerivationError
from mecanique.program.tape import Tape, Value
from mecanique.program.traced import call, trace, value_of


def push_forward(tape: Tape, outputs: Sequence[Value], along: Mapping[int, Value]) -> list[Value]:
    """Return the rate of each output when the inputs change at given rates."""
    rates: dict[int, Value] = dict(along)
    for place in tape.find_needed(outputs):
        if place in rates:
            continue
        terms = [
            tape.multiply(slope, rates[operand]) for operand, slope in _slopes(tape, place, rates)
        ]
        if terms:
            rates[place] = tape.sum(terms)
    return [rates.get(value, 0.0) if isinstance(value, int) else 0.0 for value in outputs]


def pull_back(
    tape: Tape, outputs: Sequence[Value], weights: Sequence[Value], inputs: Sequence[int]
) -> list[Value]:
    """Return Σ weight ∂output/∂input for each input, in one sweep for any number of inputs."""
    needed = tape.find_needed(outputs)
    depends = set(inputs)
    for place in needed:
        if any(isinstance(x, int) and x in depends for x in tape.operations[place][1]):
            depends.add(place)
    gradient: dict[int, Value] = {}

    def collect(place: int, term: Value) -> None:
        gradient[place] = tape.add(gradient[place], term) if place in gradient else term

    for value, weight in zip(outputs, weights, strict=True):
        if isinstance(value, int):
            collect(value, weight)
    for place in reversed(needed):
        if place in gradient:
            for operand, slope in _slopes(tape, place, depends):
                collect(operand, tape.multiply(gradient[place], slope))
    return [gradient.get(place, 0.0) for place in inputs]


def substitute(tape: Tape, outputs: Sequence[Value], known: Mapping[int, Value]) -> list[Value]:
    """Return outputs with other values in place of some operations."""
    values: dict[int, Value] = dict(known)

    def value(operand: Value) -> Value:
        return values.get(operand, operand) if isinstance(operand, int) else operand

    for place in tape.find_needed(outputs):
        kind, operands, _ = tape.operations[place]
        if place in values or kind == "input":
            continue
        values[place] = tape.record(kind, map(value, operands))
    return [value(output) for output in outputs]


def _slopes(
    tape: Tape, place: int, wanted: Mapping[int, Value] | set[int]
) -> Iterator[tuple[int, Value]]:
    """Yield each wanted operand of an operation, with the partial derivative by it."""
    kind, values, _ = tape.operations[place]
    for k, operand in enumerate(values):
        if isinstance(operand, int) and operand in wanted:
            yield operand, value_of(_slope(tape, kind, values, k, place))


def _slope(tape: Tape, kind: str, values: tuple[Value, ...], k: int, place: int) -> Any:
    """Return the partial derivative of an operation by its operand number k."""
    result = trace(tape, place)
    x, y = (trace(tape, value) for value in (values[k], values[1 - k] if values[1:] else 0.0))
    match kind:
        case "+":
            return 1.0
        case "-":
            return -1.0 if k else 1.0
        case "*":
            return y
        case "/":
            return -(result / x) if k else 1.0 / y
        case "atan2":
            return (-y if k else y) / (x * x + y * y)
        case "pow":
            return result * call(tape, "log", y) if k else y * x ** (y - 1.0)
    if kind not in SLOPES:
        raise DerivationError(f"no derivative is known for {kind!r}")
    return SLOPES[kind](result, x, lambda name: partial(call, tape, name))


SLOPES: Mapping[str, Callable[[Any, Any, Callable[[str], Callable[..., Any]]], Any]] = {
    "sin": lambda y, x, function: function("cos")(x),
    "cos": lambda y, x, function: -function("sin")(x),
    "tan": lambda y, x, function: 1.0 + y * y,
    "sqrt": lambda y, x, function: 0.5 / y,
    "exp": lambda y, x, function: y,
    "log": lambda y, x, function: 1.0 / x,
    "asin": lambda y, x, function: 1.0 / function("sqrt")(1.0 - x * x),
    "acos": lambda y, x, function: -1.0 / function("sqrt")(1.0 - x * x),
    "atan": lambda y, x, function: 1.0 / (1.0 + x * x),
    "tanh": lambda y, x, function: 1.0 - y * y,
    "Abs": lambda y, x, function: function("sign")(x),
    "sign": lambda y, x, function: 0.0 * x,
}
"""The derivative of each function y of x, given functions by name, on scalars of any kind."""
