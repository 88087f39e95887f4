"""Evaluate formulas in many states, with the derivatives of the whole by each part."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from fractions import Fraction
from functools import cache, reduce
from operator import mul
from typing import Any, TypeAlias, final

import numpy as np
import numpy.typing as npt

from mecanique.arrays import Array
from mecanique.checking.budget import spend
from mecanique.checking.grammar.tree import FUNCTIONS, Node, letter
from mecanique.errors import FormulaError

OPAQUE = ("integral", "ellipk", "ellipk_of_modulus")
"""Functions whose derivatives by their arguments are not taken."""

_NODES, _WEIGHTS = np.polynomial.legendre.leggauss(80)

Rows: TypeAlias = npt.NDArray[np.intp]
"""Numbers of states, or of paths."""

_MOST_NUMBERS = 2_000_000
"""Largest number of values of parts kept at once: 16 MB, and as much for sizes and slopes each."""


@final
@dataclass(frozen=True, eq=False)
class FormulaValues:
    """The values of all parts of a formula in n states."""

    parts: list[Array]  # values of each part, in the order of the tape; each shape (n,)
    # for each part the sum of the absolute values of its terms, a scale of rounding
    sizes: list[Array]

    @property
    def whole(self) -> Array:
        """The value of the formula, shape (n,)."""
        return self.parts[-1]

    @property
    def size(self) -> Array:
        """The sum of the absolute values of its terms, shape (n,)."""
        return self.sizes[-1]

    @property
    def relative(self) -> Array:
        """The magnitude of the formula relative to that of its terms, shape (n,)."""
        return np.asarray(np.abs(self.whole) / self.size)


@final
class FormulaTape:
    """A formula as a list of its parts, each after its own parts."""

    def __init__(self, root: Node) -> None:
        self.nodes: list[Node] = []
        self.parts: list[tuple[int, ...]] = []
        self.parents: list[int] = []
        spend(root.size)
        self._append(root)
        self.parents = [-1] * len(self.nodes)
        for k, parts in enumerate(self.parts):
            for part in parts:
                self.parents[part] = k

    def _append(self, node: Node) -> int:
        if node.kind == "table":
            raise FormulaError("expected a formula, got a matrix")
        places = tuple([self._append(part) for part in node.parts])
        self.nodes.append(node)
        self.parts.append(places)
        return len(self.nodes) - 1

    def evaluate(self, letters: Mapping[str, Array], count: int) -> FormulaValues:
        """Return the values of all parts; letters (n,) or ()."""
        spend()
        results: list[Array] = []
        sizes: list[Array] = []
        with np.errstate(all="ignore"):
            for node, places in zip(self.nodes, self.parts, strict=True):
                below = [results[k] for k in places]
                value = _value(node, below, letters)
                size = _size(node, value, below, [sizes[k] for k in places])
                results.append(np.broadcast_to(value, (count,)))
                sizes.append(np.broadcast_to(size, (count,)))
        return FormulaValues(results, sizes)

    def blocks(self, letters: Mapping[str, Array], count: int) -> Iterator[FormulaValues]:
        """Yield the values in some of the states after others, so as not to need much memory."""
        step = max(1, _MOST_NUMBERS // len(self.nodes))
        for start in range(0, count, step):
            some = slice(start, start + step)
            block = {name: value[some] for name, value in letters.items()}
            yield self.evaluate(block, len(range(count)[some]))

    def whole(self, letters: Mapping[str, Array], count: int) -> Array:
        """Return the value of the formula, shape (count,); letters (count,)."""
        return np.concatenate([values.whole for values in self.blocks(letters, count)])

    def slopes(self, values: FormulaValues) -> list[Array]:
        """Return the derivative of the whole with respect to each part, each shape (n,)."""
        slopes = [np.zeros_like(values.whole)] * len(self.nodes)
        slopes[-1] = np.ones_like(values.whole)
        with np.errstate(all="ignore"):
            for k in range(len(self.nodes) - 1, -1, -1):
                places = self.parts[k]
                below = [values.parts[j] for j in places]
                for place, slope in zip(places, _partials(self.nodes[k], below), strict=True):
                    slopes[place] = slopes[place] + slopes[k] * slope
        return slopes

    def along(self, slopes: list[Array], name: str) -> Array:
        """Return the derivative of the whole with respect to a letter, shape (n,)."""
        total = np.zeros_like(slopes[-1])
        for node, slope in zip(self.nodes, slopes, strict=True):
            if node.kind == "letter" and node.name == name:
                total = total + slope
        return total


def _integrate(node: Node, low: Array, high: Array, letters: Mapping[str, Array]) -> Array:
    """Return the integral of a formula over a letter by Gauss and Legendre's rule."""
    tape = FormulaTape(node.parts[0])
    name = node.parts[1].name
    middle, half = (low + high) / 2, (high - low) / 2
    count = max(np.size(value) for value in (middle, *letters.values()))
    total = np.zeros(count)
    # over x = middle + half sin φ an inverse root that is infinite at an end stays finite
    for angle, weight in zip(np.pi / 2 * _NODES, np.pi / 2 * _WEIGHTS, strict=True):
        at = np.broadcast_to(middle + half * np.sin(angle), (count,))
        height = tape.evaluate({**letters, name: at}, count).whole
        total = total + weight * half * np.cos(angle) * height
    return total


def _value(node: Node, below: list[Array], letters: Mapping[str, Array]) -> Any:
    if node.name == "integral" and node.kind == "call":
        return _integrate(node, below[2], below[3], letters)
    match node.kind:
        case "number":
            return np.float64(node.value)
        case "letter":
            # a unit in brackets is one of SI, in which all values are
            return np.float64(1.0) if node.name.startswith("[") else letters[node.name]
        case "sum":
            return sum(below[1:], below[0])
        case "product":
            return reduce(mul, below)
        case "quotient":
            return below[0] / below[1]
        case "power":
            return _power(below[0], node.parts[1], below[1])
        case "negative":
            return -below[0]
    function = FUNCTIONS[node.name].value
    assert function is not None, "a formula takes the place of others"
    return function(*below)


def _power(base: Array, exponent: Node, value: Array) -> Array:
    if exponent.kind == "number" and exponent.value == 2:
        return base * base
    return np.asarray(np.power(base, value))


def _size(node: Node, value: Any, below: list[Array], sizes: list[Array]) -> Any:
    match node.kind:
        case "sum":
            return sum(sizes[1:], sizes[0])
        case "product":
            return reduce(mul, sizes)
        case "quotient":
            # cancellation in the divisor makes the quotient uncertain to the same degree
            return sizes[0] / np.abs(below[1]) * (sizes[1] / np.abs(below[1]))
        case "power":
            # of a base that is zero nothing is lost
            worse = np.where(below[0] == 0, 1.0, sizes[0] / np.abs(below[0]))
            return np.abs(value) * np.maximum(1.0, np.abs(below[1]) * worse)
        case "negative":
            return sizes[0]
        case "call":
            # an argument with terms of size s has the error s ε, as have its sine and cosine
            if node.name == "abs":
                return sizes[0]
            return np.abs(value) + (sizes[0] if node.name in ("sin", "cos") else 0.0)
    return np.abs(value)


def _partials(node: Node, below: list[Array]) -> list[Any]:
    match node.kind:
        case "sum":
            return [1.0] * len(below)
        case "negative":
            return [-1.0]
        case "product":
            return _leave_each_out(below)
        case "quotient":
            return [1 / below[1], -below[0] / below[1] ** 2]
        case "power":
            base, exponent = below
            return [exponent * np.power(base, exponent - 1), 0.0]
    if node.kind == "call" and (slope := _slope_of(node.name)) is not None:
        return [slope.evaluate({_ARGUMENT: below[0]}, len(below[0])).whole]
    if node.name == "atan2":
        square = below[0] ** 2 + below[1] ** 2
        return [below[1] / square, -below[0] / square]
    return [0.0] * len(below)


def _leave_each_out(factors: list[Array]) -> list[Any]:
    """Return for each factor the product of the others."""
    return [reduce(mul, [*factors[:k], *factors[k + 1 :]], 1.0) for k in range(len(factors))]


_ARGUMENT = "x"


@cache
def _slope_of(name: str) -> FormulaTape | None:
    """Return the derivative of a function of one argument, None if it is not known."""
    slope = FUNCTIONS[name].slope
    return None if slope is None else FormulaTape(slope(letter(_ARGUMENT)))


def needed_values(tape: FormulaTape, values: FormulaValues, target: Array) -> list[Array]:
    """Return for each part the value (n,) that makes the whole equal a target (n,)."""
    # from the whole to the parts, by inverting one operation after another; NaN where there is
    # none, and within the arguments of functions
    unknown = np.full_like(values.whole, np.nan)
    needed: list[Array] = [unknown] * len(tape.nodes)
    needed[-1] = np.broadcast_to(target, values.whole.shape)
    with np.errstate(all="ignore"):
        for k in range(len(tape.nodes) - 1, -1, -1):
            places = tape.parts[k]
            below = [values.parts[j] for j in places]
            parts = _undo(tape.nodes[k].kind, tape.nodes[k].name, values.parts[k], needed[k], below)
            for place, part in zip(places, parts, strict=True):
                needed[place] = unknown if part is None else part
    return needed


def _undo(
    kind: str, name: str, value: Array, target: Array, below: list[Array]
) -> list[Array | None]:
    match kind:
        case "sum":
            return [target - (value - part) for part in below]
        case "negative":
            return [-target]
        case "product":
            return [target / others for others in _leave_each_out(below)]
        case "quotient":
            return [target * below[1], below[0] / target]
        case "power":
            return [_root(target, below), None]
        case "call" if name == "sqrt":
            return [target * target]
    return [None] * len(below)


def _root(target: Array, below: list[Array]) -> Array:
    """Return the base of a power; for an even exponent with the sign of the present base."""
    base, exponent = below
    size = np.abs(target) ** (1 / exponent)
    even = np.mod(exponent, 2) == 0
    odd = np.mod(exponent, 2) == 1
    signed = np.where(even, np.sign(base) * size, np.where(odd, np.sign(target) * size, size))
    return np.where((target < 0) & ~odd, np.nan, signed)


_WRITTEN = re.compile(r"\d*[.,](\d+)")
_SAME = 1e-9
"""What differs by less of it is one number: rounding through the operations of a line of text."""


def find_rounding(tape: FormulaTape, values: FormulaValues, text: str) -> str:
    """Return the rounded number for which a formula is not zero, and what it is more exactly."""
    wanted = needed_values(tape, values, np.zeros_like(values.whole))
    finite = np.isfinite(values.whole) & np.isfinite(values.size)
    for node, exact in zip(tape.nodes, wanted, strict=True):
        written = _WRITTEN.fullmatch(text[node.start : node.end])
        if node.kind != "number" or written is None:
            continue
        # zeros behind the decimal mark are digits, those before the first other digit are not
        digits = re.sub("[.,]", "", text[node.start : node.end]).lstrip("0")
        usable = finite & np.isfinite(exact)
        unsaid = finite & ~usable & (np.abs(values.whole) > _SAME * values.size)
        if len(digits) < 2 or usable.sum() < min(3, len(finite)) or unsaid.any():
            continue
        exact = exact[usable]
        value = float(exact.mean())
        half = 0.5 * 10.0 ** -len(written[1])
        near = abs(value - float(node.value)) <= half * (1 + _SAME)
        differs = abs(value - float(node.value)) > _SAME * abs(value)
        if near and differs and np.ptp(exact) <= 1e-6 * abs(value):
            simple = Fraction(value).limit_denominator(60)
            said = (
                str(simple)
                if abs(float(simple) / value - 1) < _SAME
                else f"{value:.{max(6, len(digits) + 3)}g}"
            )
            return f"{text[node.start : node.end]} is rounded: it is {said}"
    return ""


def find_error(tape: FormulaTape, values: FormulaValues) -> str:
    """Return by how much the only number of a formula is wrong, if it is the same everywhere."""
    wanted = needed_values(tape, values, np.zeros_like(values.whole))
    numbers = [k for k, node in enumerate(tape.nodes) if node.kind == "number" and node.value]
    if len(numbers) != 1:
        return ""
    ratio = float(tape.nodes[numbers[0]].value) / wanted[numbers[0]]
    off = 100 * (float(ratio.mean()) - 1)
    if not np.isfinite(ratio).all() or np.ptp(ratio) > 1e-6 * np.abs(ratio).max():
        return ""
    return f"the number is {abs(off):.2g} % too {'large' if off > 0 else 'small'}"


def find_sign_changes(
    value: Callable[[Rows, Array], Array], count: int, grid: Array, halvings: int
) -> tuple[Rows, Array, Array]:
    """Return where values (k,) or (k, m) of rows turn away from those before, along a grid.

    Returns:
        The row and the place of each change, and what is left there of the value before: a jump
        from one sign to the other, at which more is left, is a pole, no root.
    """
    rows = np.repeat(np.arange(count), len(grid))
    table = value(rows, np.tile(grid, count)).reshape(count, len(grid), -1)
    row, step = np.nonzero((table[:, :-1] * table[:, 1:]).sum(axis=2) < 0)
    first, low, high = table[row, step], grid[step], grid[step + 1]
    if not len(row):
        return row, low, low
    for _ in range(halvings):
        middle = (low + high) / 2
        before = (value(row, middle).reshape(len(row), -1) * first).sum(axis=1) > 0
        low, high = np.where(before, middle, low), np.where(before, high, middle)
    left = np.linalg.norm(value(row, low).reshape(len(row), -1), axis=1)
    return row, low, np.asarray(left / np.linalg.norm(first, axis=1))
