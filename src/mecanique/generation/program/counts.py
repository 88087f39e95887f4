"""Count the operations of a program by kind."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import final

from mecanique.generation.program.tape import Tape, Value


@final
@dataclass(frozen=True)
class Counts:
    """Numbers of operations; a result that is used several times counts once.

    Args:
        additions: additions and subtractions.
        multiplications: products of two factors.
        divisions: divisions, except by numbers.
        functions: sines, roots and so on.
    """

    additions: int
    multiplications: int
    divisions: int
    functions: int

    @property
    def total(self) -> int:
        """The number of all operations."""
        return self.additions + self.multiplications + self.divisions + self.functions

    def __str__(self) -> str:
        return (
            f"{self.total} operations: {self.additions} additions, {self.multiplications} "
            f"multiplications, {self.divisions} divisions, {self.functions} functions"
        )


def count(tape: Tape, outputs: Sequence[Value]) -> Counts:
    """Return the numbers of operations that outputs need.

    Args:
        tape: the program.
        outputs: its outputs.
    """
    kinds = [tape.operations[place][0] for place in tape.find_needed(outputs)]
    sums = sum(kind in "+-" for kind in kinds)
    products, divisions = kinds.count("*"), kinds.count("/")
    others = len(kinds) - sums - products - divisions - kinds.count("input")
    return Counts(sums, products, divisions, others)
