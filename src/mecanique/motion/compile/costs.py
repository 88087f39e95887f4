"""What it costs to derive, compile and step equations, counted in operations of compiled code.

Where times were measured they are divided by the nanosecond that an operation in C took there, so
they are rough; as nothing but ratios decides, the same call chooses the same method anywhere.
"""

from __future__ import annotations

from mecanique.model.mechanism import Mechanism
from mecanique.motion.compile.program import SAMPLES, RatesProgram, is_long_chain

LOOP_STEP = {"dop853": 2e6, "closed_form": 3e4, "compiled": 1e4}
"""A step of a closed mechanism by method: dop853 on the reference for each velocity, the closed
form in Python for each pair of velocities."""

_OPERATIONS_OF_CHAIN = 400
"""How many a long chain's equations take for each velocity (`program.LONG`)."""

CHAIN_STEP = 1000 * _OPERATIONS_OF_CHAIN
"""A step of the closed form of a long chain, for each velocity: 14 times its operations, each of
which takes 70 times as long in Python."""

NUMPY = 400
"""What numpy takes per run, second of motion and operation of the equations."""

OPERATIONS_OF_LINE = 2
"""How many a line of C has, roughly."""

_DERIVING, _DERIVING_LOOPS = 2e6, 1.5e7
"""To derive, compare and compile the least equations in Python; with loops, for each velocity."""

_CLOSING, _CLOSING_CHAIN = 2e5, 6e4
"""To close one random state, for each pair of velocities: of any mechanism, and of a long chain."""

_COMPILING = 8e7
"""To compile equations of unknown length in C, for each velocity."""

_COMPILING_OPERATIONS = {"optimized": 5e5, "plain": 5e4}
"""The same for each operation."""

_IMPORTING = 3e8
"""To import heyoka."""

_BUILDING = {True: (2e7, 3.5e6), False: (1e7, 4e5)}
"""To build an integrator by Taylor series, optimized or not: in all, and for each operation."""


def estimate_step(mechanism: Mechanism) -> float:
    """Return what a step of dop853 on the reference costs."""
    return 12 * (1500 + 500 * mechanism.nv)


def estimate_deriving(mechanism: Mechanism) -> float:
    """Return what it costs to derive, compare and compile the equations in Python."""
    size = mechanism.nv
    if not mechanism.constrained:
        return _DERIVING + 1e6 * size**3
    # states to compare in have to be closed, each the longer the more loops there are
    closing = _CLOSING_CHAIN if is_long_chain(mechanism) else _CLOSING
    return _DERIVING_LOOPS * size + SAMPLES * closing * size**2


def estimate_compiling(mechanism: Mechanism, operations: int | None = None) -> float:
    """Return what it costs to compile the equations in C, by their operations if known."""
    if operations is None and is_long_chain(mechanism):
        operations = _OPERATIONS_OF_CHAIN * mechanism.nv
    if operations is None:
        return _COMPILING * mechanism.nv
    from mecanique.generation.targets.c import LONG

    kind = "plain" if operations > OPERATIONS_OF_LINE * LONG else "optimized"
    return _COMPILING_OPERATIONS[kind] * operations


def estimate_series(operations: float, *, optimized: bool = True) -> float:
    """Return what it costs to build an integrator by Taylor series."""
    once, per_operation = _BUILDING[optimized]
    return _IMPORTING + once + per_operation * operations


def estimate_deriving_series(mechanism: Mechanism) -> float:
    """Return what it costs to derive the equations and build an integrator, by the size alone."""
    return estimate_deriving(mechanism) + estimate_series(15 * mechanism.nv**2, optimized=False)


def estimate_series_of(program: RatesProgram) -> float:
    """Return what it costs to build an optimized integrator of a program."""
    return estimate_series(len(program.tape.find_needed(program.rates)))
