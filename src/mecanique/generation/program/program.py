"""A program as targets see it: a mechanism's inputs by kind, and named outputs."""

from __future__ import annotations

from dataclasses import dataclass
from typing import final

from mecanique.generation.program.counts import Counts, count
from mecanique.generation.program.tape import Tape, Value
from mecanique.generation.quantities import Quantity
from mecanique.model.mechanism import Mechanism

__all__ = ["Answer", "Landing", "Letter", "Program"]


@final
@dataclass(frozen=True)
class Letter:
    """An input of a program.

    Args:
        name: the mechanism's name of it.
        place: its name on the tape.
        unit: its SI unit; "" where it is unknown.
        meaning: what it is, in a few words.
        value: what it is worth where nothing else is said.
    """

    name: str
    place: str
    unit: str = ""
    meaning: str = ""
    value: float = 0.0


@final
@dataclass(frozen=True)
class Answer:
    """A named output of a program.

    Args:
        quantity: what it is.
        values: its entries, row by row.
        shape: of these.
    """

    quantity: Quantity
    values: tuple[Value, ...]
    shape: tuple[int, ...]


@final
@dataclass(frozen=True)
class Landing:
    """What brings a state next to the loops onto them.

    Args:
        changes: of q, then of v, to first order, shape (nq + nv,).
        firmness: how firmly the loops hold, zero in singular positions.
        gaps: by how much each equation of the loops is missed.
    """

    changes: tuple[Value, ...]
    firmness: Value
    gaps: tuple[Value, ...]


@final
@dataclass(frozen=True)
class Program:
    """A straight-line program.

    Args:
        mechanism: whose equations it computes.
        name: what its functions are called after.
        origin: how the equations were made.
        tape: the operations, each different one once.
        letters: the inputs by kind: t, q, v, a, tau and p.
        answers: the outputs.
        start: of programs that are to move, the state they start from, shape (nq + nv,).
        landing: of closed mechanisms that are to move, how they stay on their loops.
    """

    mechanism: Mechanism
    name: str
    origin: str
    tape: Tape
    letters: dict[str, tuple[Letter, ...]]
    answers: tuple[Answer, ...]
    start: tuple[float, ...] = ()
    landing: Landing | None = None

    @property
    def parameters(self) -> tuple[Letter, ...]:
        """Parameters and signals that are inputs."""
        return self.letters["p"]

    def count(self, quantity: str | None = None) -> Counts:
        """Return the number of operations of one output, or of all together.

        Args:
            quantity: its name.
        """
        chosen = [a for a in self.answers if quantity in (None, a.quantity.name)]
        return count(self.tape, [value for answer in chosen for value in answer.values])
