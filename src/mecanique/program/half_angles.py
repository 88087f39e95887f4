"""Compute sines and cosines from tangents of half angles, which numpy does several times faster.

With t = tan(θ/2): sin θ = 2t/(1 + t²), cos θ = 2/(1 + t²) − 1 (Weierstrass's substitution). Both
are accurate up to rounding, even where t grows without bounds.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple, final

from mecanique.program.tape import Operation, Tape, Value

_BOTH = frozenset({"sin", "cos"})


def by_tangents(tape: Tape, outputs: Sequence[Value]) -> tuple[Tape, list[Value]]:
    """Return a program with the same results and fewer sines and cosines.

    If both are needed for an angle, they share a tangent. For a sum of angles they follow from its
    parts by the addition theorems, if one of the parts has a sine or cosine of its own.
    """
    needed = tape.find_needed(outputs)
    new = _Rewritten(_find_angles(tape, needed))
    for place in needed:
        new.add(place, tape.operations[place])
    return new.tape, [new.move(value) for value in outputs]


class _Angles(NamedTuple):
    """The angles of a program."""

    wanted: dict[int, set[str]]  # the functions of each that are needed, by its index
    # sign and both parts of each sum that is treated by the addition theorems
    parts: dict[int, tuple[str, int, int]]


def _find_angles(tape: Tape, needed: Sequence[int]) -> _Angles:
    wanted: dict[int, set[str]] = {}
    for place in needed:
        kind, values, _ = tape.operations[place]
        if kind in _BOTH and isinstance(values[0], int):
            wanted.setdefault(values[0], set()).add(kind)
    parts: dict[int, tuple[str, int, int]] = {}
    for place in sorted(wanted, reverse=True):
        kind, values, _ = tape.operations[place]
        if kind in ("+", "-") and any(
            value in wanted for value in values if isinstance(value, int)
        ):
            a, b = values
            if isinstance(a, int) and isinstance(b, int):
                parts[place] = kind, a, b
                wanted.setdefault(a, set()).update(_BOTH)
                wanted.setdefault(b, set()).update(_BOTH)
    return _Angles(wanted, parts)


@final
class _Rewritten:
    """The new program, as far as it is written."""

    def __init__(self, angles: _Angles) -> None:
        self.tape = Tape()
        self._angles = angles
        self._places: dict[int, Value] = {}
        self._known: dict[tuple[str, int], Value] = {}

    def move(self, value: Value) -> Value:
        """Return the value in the new program that corresponds to one in the old program."""
        return self._places[value] if isinstance(value, int) else value

    def add(self, place: int, operation: Operation) -> None:
        """Add an operation of the old program, in its order there."""
        kind, values, name = operation
        if kind in _BOTH and isinstance(values[0], int):
            self._places[place] = self._circular(kind, values[0])
        else:
            self._places[place] = self.tape.record(kind, map(self.move, values), name)

    def _circular(self, function: str, angle: int) -> Value:
        """The sine or cosine of an angle, written once."""
        if (function, angle) not in self._known:
            write = self._of_sum if angle in self._angles.parts else self._of_one
            self._known[function, angle] = write(function, angle)
        return self._known[function, angle]

    def _of_sum(self, function: str, angle: int) -> Value:
        """By an addition theorem."""
        kind, a, b = self._angles.parts[angle]
        cofunction = "cos" if function == "sin" else "sin"
        first = self.tape.multiply(self._circular(function, a), self._circular("cos", b))
        second = self.tape.multiply(self._circular(cofunction, a), self._circular("sin", b))
        if (kind == "+") == (function == "sin"):
            return self.tape.add(first, second)
        return self.tape.subtract(first, second)

    def _of_one(self, function: str, angle: int) -> Value:
        """By the tangent of its half, if both functions are needed."""
        new, moved = self.tape, self.move(angle)
        if self._angles.wanted[angle] != _BOTH:
            return new.call(function, moved)
        t = new.call("tan", new.multiply(0.5, moved))
        twice = new.divide(2.0, new.add(1.0, new.multiply(t, t)))
        return new.multiply(t, twice) if function == "sin" else new.subtract(twice, 1.0)
