"""Write the projection of a nearby state on the loops, on a tape."""

from __future__ import annotations

from typing import Any

from mecanique.generation.mechanics.constraints.constrained import Constrained
from mecanique.generation.mechanics.constraints.loops import Loops
from mecanique.generation.mechanics.letters import Letters
from mecanique.generation.program import Landing
from mecanique.program.sweeps import push_forward
from mecanique.program.traced import value_of, values_of


def landing_of(letters: Letters, loops: Loops, constrained: Constrained) -> Landing:
    """Return the changes of q and v that close the loops and their rates.

    Args:
        letters: the mechanism's inputs.
        loops: the equations of its loops.
        constrained: the same, factorized.
    """
    step: list[Any] = constrained.close(loops.residual)
    turn: list[Any] = constrained.close(loops.rate)
    # the rates of q are linear in v, so replacing v by the step gives the change of q
    along = {v.place: value_of(x) for v, x in zip(letters.v, step, strict=True)}
    moved = push_forward(letters.tape, values_of(letters.rates), along)
    changes = (*moved, *values_of(turn))
    gaps = tuple(values_of(loops.residual))
    return Landing(changes, value_of(constrained.firmness()), gaps)
