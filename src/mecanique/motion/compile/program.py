"""The equations of motion as one straight-line program ẏ = f(t, y), from the closed form."""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import dataclass
from typing import final

from mecanique.derivation import derive
from mecanique.errors import DerivationError
from mecanique.generation.program.lowering import Lowering
from mecanique.generation.program.tape import Tape, Value
from mecanique.generation.program.traced import arithmetic_on, trace, value_of
from mecanique.model.mechanism import Mechanism

__all__ = ["MOST_VELOCITIES", "Program", "program_of"]

MOST_VELOCITIES = 8
"""Closed forms of larger mechanisms are too long to be faster than a recursion."""


@final
@dataclass(frozen=True)
class Program:
    """A straight-line program that gives the rates of a mechanism's state.

    Its inputs are named as the mechanism names them: coordinates, velocities, "t", parameters left
    open, and signals that are functions.

    Args:
        mechanism: whose motion it is.
        tape: the operations.
        rates: value of each rate, first of q, then of v, shape (nq + nv,).
        open: parameters that are inputs, by symbol.
        signals: inputs of the mechanism that are functions of time, by symbol.
    """

    mechanism: Mechanism
    tape: Tape
    rates: tuple[Value, ...]
    open: tuple[str, ...]
    signals: tuple[str, ...]

    @property
    def states(self) -> tuple[str, ...]:
        """Names of the state's parts: coordinates, then velocities."""
        return (*self.mechanism.coordinates.names, *self.mechanism.velocities)


def program_of(mechanism: Mechanism, swept: Collection[str] = ()) -> Program:
    """Derive the equations of a mechanism and return them as a program.

    Args:
        mechanism: a tree of few joints.
        swept: symbols of the parameters that stay inputs; all others are the numbers they stand
            for.

    Raises:
        DerivationError: if there is no closed form, or none that holds at every state.
    """
    if mechanism.constrained:
        raise DerivationError(
            f"mechanism {mechanism.name!r} has loops; its closed form is that of the open tree"
        )
    if mechanism.nv > MOST_VELOCITIES:
        raise DerivationError(
            f"expected at most {MOST_VELOCITIES} velocities for a closed form, got {mechanism.nv}"
        )
    derivation = derive(mechanism).derivation
    if derivation.assumptions:
        subjects = ", ".join(assumption.subject for assumption in derivation.assumptions)
        raise DerivationError(
            f"the closed form of {mechanism.name!r} holds for one sign of {subjects} only"
        )
    tape, ring = Tape(), derivation.algebra.ring
    values: dict[str, Value] = {
        name: tape.input(name) for name in (*mechanism.coordinates, *mechanism.velocities, "t")
    }
    kept = tuple(p.symbol for p in mechanism.parameters if p.symbol in swept)
    values |= {
        p.symbol: tape.input(p.symbol) if p.symbol in kept else p.value
        for p in mechanism.parameters
    }
    signals = []
    for signal in mechanism.inputs:
        if callable(signal.signal):
            signals.append(signal.symbol)
            values[signal.symbol] = tape.input(signal.symbol)
        else:
            traced = {name: trace(tape, value) for name, value in values.items()}
            values[signal.symbol] = value_of(arithmetic_on(tape)(signal.signal, traced))
    lowered = Lowering(ring, tape, values)
    M = [list(map(lowered, row)) for row in derivation.M]
    rest = [
        tape.subtract(lowered(q), lowered(h))
        for q, h in zip(derivation.Q, derivation.h, strict=True)
    ]
    accelerations = _solve(tape, M, rest)
    rates = [lowered(ring.rates[ring.index(name)]) for name in mechanism.coordinates]
    return Program(mechanism, tape, (*rates, *accelerations), kept, tuple(signals))


def _solve(tape: Tape, M: list[list[Value]], rest: list[Value]) -> list[Value]:
    """Solve M a = rest from the last row up, M = Uᵀ D U (Cholesky's method without roots)."""
    M, rest = [list(row) for row in M], list(rest)
    size = len(rest)
    factors: dict[tuple[int, int], Value] = {}
    for k in range(size - 1, -1, -1):
        for i in range(k):
            factors[k, i] = tape.divide(M[k][i], M[k][k])
        for i in range(k):
            for j in range(i + 1):
                M[i][j] = tape.subtract(M[i][j], tape.multiply(factors[k, j], M[k][i]))
            rest[i] = tape.subtract(rest[i], tape.multiply(factors[k, i], rest[k]))
    found: list[Value] = []
    for k in range(size):
        known = tape.sum(tape.multiply(factors[k, i], found[i]) for i in range(k))
        found.append(tape.subtract(tape.divide(rest[k], M[k][k]), known))
    return found
