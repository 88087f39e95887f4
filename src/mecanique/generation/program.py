"""A program in the form that languages need: inputs by kind, and named outputs."""

from __future__ import annotations

from dataclasses import dataclass
from typing import final

from mecanique.derivation.mechanics.switching import ElementRows
from mecanique.generation.quantities import Output
from mecanique.model.constraints.friction import Switching
from mecanique.model.mechanism import Mechanism
from mecanique.program.tape import Counts, Tape, Value, count


@final
@dataclass(frozen=True)
class ProgramInput:
    """An input of a program."""

    name: str
    place: str  # its name on the tape
    unit: str = ""  # its SI unit; "" if it is unknown
    meaning: str = ""  # its meaning, in a few words
    value: float = 0.0


@final
@dataclass(frozen=True)
class Answer:
    """A named output of a program."""

    quantity: Output
    values: tuple[Value, ...]  # its entries, row by row
    shape: tuple[int, ...]  # its shape


@final
@dataclass(frozen=True)
class LoopProjection:
    """The correction that projects a nearby state on the loops."""

    changes: tuple[Value, ...]  # changes of q, then of v, to first order, shape (nq + nv,)
    firmness: Value  # measure of regularity, zero in singular positions
    gaps: tuple[Value, ...]  # gap of each equation of the loops


@final
@dataclass(frozen=True)
class SwitchingTerms:
    """What decides which mode follows in a state."""

    elements: tuple[ElementRows, ...]
    positional: tuple[bool, ...]  # whether each row is the rate of a gap
    length: float  # a characteristic length [m]
    values: tuple[Value, ...]  # as `SwitchingEquations.list_terms` gives them


@final
@dataclass(frozen=True)
class Program:
    """A straight-line program."""

    mechanism: Mechanism  # the mechanism whose equations it computes
    name: str  # stem of its functions' names
    origin: str  # how the equations were obtained
    tape: Tape  # the operations, each different one once
    letters: dict[str, tuple[ProgramInput, ...]]  # the inputs by kind: t, q, v, a, tau and p
    answers: tuple[Answer, ...]  # the outputs
    # for programs to be integrated, the default initial state, shape (nq + nv,)
    start: tuple[float, ...] = ()
    # for closed mechanisms to be integrated, the correction that keeps loops closed
    landing: LoopProjection | None = None
    switching: tuple[Switching, ...] = ()  # the elements whose modes it computes
    # for programs to be integrated, what decides which mode of these follows
    corners: SwitchingTerms | None = None

    @property
    def parameters(self) -> tuple[ProgramInput, ...]:
        """The parameters and signals that are inputs."""
        return self.letters["p"]

    def count(self, quantity: str | None = None) -> Counts:
        """Return the number of operations of one output, or of all together."""
        chosen = [a for a in self.answers if quantity in (None, a.quantity.name)]
        return count(self.tape, [value for answer in chosen for value in answer.values])
