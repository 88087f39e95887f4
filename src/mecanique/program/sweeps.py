"""Differentiate a program on its own tape: forward along a direction, or in reverse.

Both apply the chain rule operation by operation (R. E. Wengert, Comm. ACM 7 (1964) 463; S.
Linnainmaa, BIT 16 (1976) 146). Second derivatives are sweeps of sweeps.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence

from mecanique.errors import DerivationError
from mecanique.program.tape import Tape, Value


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
        if any(value in depends for value in _operands(tape, place)):
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


def _operands(tape: Tape, place: int) -> list[int]:
    return [value for value in tape.operations[place][1] if isinstance(value, int)]


def _slopes(
    tape: Tape, place: int, wanted: Mapping[int, Value] | set[int]
) -> Iterator[tuple[int, Value]]:
    """Yield each wanted operand of an operation, with the partial derivative by it."""
    kind, values, _ = tape.operations[place]
    for k, operand in enumerate(values):
        if isinstance(operand, int) and operand in wanted:
            yield operand, _slope(tape, kind, values, k, place)


def _slope(tape: Tape, kind: str, values: tuple[Value, ...], k: int, place: int) -> Value:
    """Return the partial derivative of an operation by its operand number k."""
    x, y = values[k], values[1 - k] if len(values) == 2 else 0.0

    def square(value: Value) -> Value:
        return tape.multiply(value, value)

    match kind:
        case "+":
            return 1.0
        case "-":
            return -1.0 if k else 1.0
        case "*":
            return y
        case "/":
            if k:
                return tape.multiply(-1.0, tape.divide(place, x))
            return tape.divide(1.0, y)
        case "sin":
            return tape.call("cos", x)
        case "cos":
            return tape.multiply(-1.0, tape.call("sin", x))
        case "tan":
            return tape.add(1.0, square(place))
        case "sqrt":
            return tape.divide(0.5, place)
        case "exp":
            return place
        case "log":
            return tape.divide(1.0, x)
        case "asin" | "acos":
            root = tape.call("sqrt", tape.subtract(1.0, square(x)))
            return tape.divide(1.0 if kind == "asin" else -1.0, root)
        case "atan":
            return tape.divide(1.0, tape.add(1.0, square(x)))
        case "tanh":
            return tape.subtract(1.0, square(place))
        case "Abs":
            return tape.call("sign", x)
        case "sign":
            return 0.0
        case "atan2":
            squares = tape.add(square(x), square(y))
            return tape.divide(y if k == 0 else tape.multiply(-1.0, y), squares)
        case "pow":
            if k:
                return tape.multiply(place, tape.call("log", y))
            return tape.multiply(y, tape.call("pow", x, tape.subtract(y, 1.0)))
    raise DerivationError(f"no derivative is known for {kind!r}")
