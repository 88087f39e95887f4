"""The equations of motion as one straight-line program ẏ = f(t, y), from the closed form."""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import dataclass
from typing import final

from mecanique.derivation import derive
from mecanique.generation.mechanics.closed_form import ClosedForm
from mecanique.generation.mechanics.letters import Letters
from mecanique.generation.program.solving import factorize
from mecanique.generation.program.tape import Tape, Value
from mecanique.generation.program.traced import values_of
from mecanique.model.mechanism import Mechanism

__all__ = ["Program", "program_of"]


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
    kept = {p.symbol for p in mechanism.parameters if p.symbol in swept}
    letters = Letters(mechanism, kept)
    form, tape = ClosedForm(letters, derive(mechanism)), letters.tape
    rest = [Q - h for Q, h in zip(form.forces(), form.bias(), strict=True)]
    accelerations = factorize(tape, form.mass_matrix()).solve(rest)
    rates = values_of([*form.rates(), *accelerations])
    open_ = tuple(symbol for symbol in letters.open if symbol in kept)
    return Program(mechanism, tape, tuple(rates), open_, tuple(letters.signals))
