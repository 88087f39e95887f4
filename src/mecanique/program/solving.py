"""Solve linear equations with a symmetric matrix on a tape; zeros of the matrix cost nothing."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, final

from mecanique.program.tape import Tape, Value
from mecanique.program.traced import trace, values_of


@final
@dataclass(frozen=True)
class Factors:
    """M = Uᵀ D U with U lower triangular and unit diagonal, without roots and pivoting.

    Rows are eliminated from the last one up: for a tree whose joints come after their parents no
    zero is filled in (R. Featherstone, Int. J. Robotics Research 24 (2005) 487).
    """

    tape: Tape  # the tape to write on
    pivots: tuple[Value, ...]  # D
    rows: tuple[tuple[Value, ...], ...]  # entries of U below its diagonal, row by row

    def solve(self, rest: Sequence[Any]) -> list[Any]:
        """Return x with M x = rest, shape (n,)."""
        tape, left = self.tape, values_of(rest)
        for k in range(len(left) - 1, -1, -1):
            for i in range(k):
                left[i] = tape.subtract(left[i], tape.multiply(self.rows[k][i], left[k]))
        x: list[Value] = []
        for k, pivot in enumerate(self.pivots):
            known = tape.sum(tape.multiply(self.rows[k][i], x[i]) for i in range(k))
            x.append(tape.subtract(tape.divide(left[k], pivot), known))
        return [trace(tape, value) for value in x]


def factorize(tape: Tape, M: Sequence[Sequence[Any]]) -> Factors:
    """Factorize a symmetric matrix, reading its lower triangle."""
    left = [values_of(row[: k + 1]) for k, row in enumerate(M)]
    rows: list[tuple[Value, ...]] = [()] * len(left)
    for k in range(len(left) - 1, -1, -1):
        rows[k] = tuple(tape.divide(left[k][i], left[k][k]) for i in range(k))
        for i in range(k):
            for j in range(i + 1):
                part = tape.multiply(rows[k][j], left[k][i])
                left[i][j] = tape.subtract(left[i][j], part)
    pivots = tuple(left[k][k] for k in range(len(left)))
    return Factors(tape, pivots, tuple(rows))


def eliminate(system: Sequence[Sequence[Any]], rest: Sequence[Any]) -> list[Any]:
    """Return x with A x = rest for any A, by elimination without pivoting, shape (n,)."""
    rows = [[*row, value] for row, value in zip(system, rest, strict=True)]
    for k, pivot in enumerate(rows):
        for row in rows[k + 1 :]:
            part = row[k] / pivot[k]
            pairs = zip(row[k + 1 :], pivot[k + 1 :], strict=True)
            row[k + 1 :] = [entry - part * other for entry, other in pairs]
    x: list[Any] = []
    for k in reversed(range(len(rows))):
        known = sum((a * b for a, b in zip(rows[k][k + 1 : -1], x, strict=True)), 0.0)
        x.insert(0, (rows[k][-1] - known) / rows[k][k])
    return x
