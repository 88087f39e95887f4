"""The way back onto the loops for a state next to them, on a tape."""

from __future__ import annotations

from typing import Any

from mecanique.generation.mechanics.constraints.constrained import Constrained
from mecanique.generation.mechanics.constraints.loops import Loops
from mecanique.generation.mechanics.letters import Letters
from mecanique.generation.program.program import Landing
from mecanique.generation.program.sweeps import push_forward
from mecanique.generation.program.traced import value_of, values_of

__all__ = ["landing_of"]


def landing_of(letters: Letters, loops: Loops, constrained: Constrained) -> Landing:
    """Return the changes of q and v that close the loops, and let them stay closed.

    Args:
        letters: the mechanism's letters.
        loops: what its loops demand.
        constrained: the same, factorized.
    """
    step: list[Any] = constrained.close(loops.residual)
    turn: list[Any] = constrained.close(loops.rate)
    # the rates of q are linear in the velocities, in whose place the step is put
    along = {v.place: value_of(x) for v, x in zip(letters.v, step, strict=True)}
    moved = push_forward(letters.tape, values_of(letters.rates), along)
    changes = (*moved, *values_of(turn))
    gaps = tuple(values_of(loops.residual))
    return Landing(changes, value_of(constrained.firmness()), gaps)
