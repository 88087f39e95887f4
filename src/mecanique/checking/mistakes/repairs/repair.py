"""A change of one part that makes a formula right, and what is known of the part."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
import numpy.typing as npt

from mecanique.arrays import Array
from mecanique.checking.grammar.tape import Tape, Values
from mecanique.checking.grammar.tree import Node
from mecanique.checking.mistakes.context import Context

__all__ = ["ALIKE", "SIMPLE", "Part", "Repair"]

ALIKE = 1e-6
"""Two values at one state that differ by less than this part are one."""

SIMPLE = 60
"""Factors with numerators and denominators up to this are named."""


@dataclass(frozen=True)
class Repair:
    """A change of one part that makes a formula right.

    Args:
        kind: of the mistake.
        text: what is wrong, in words.
        part: the part as it was written.
        weight: the smaller, the likelier.
    """

    kind: str
    text: str
    part: str
    weight: float


@dataclass(frozen=True, eq=False)
class Part:
    """A part of a formula, what it is and what it would have to be.

    Args:
        tape: the formula.
        place: of the part in it.
        have: its values.
        want: the values it would need.
        usable: at which states.
        context: what may have been meant.
        text: what the formula was read from.
        values: of all parts.
    """

    tape: Tape
    place: int
    have: Array
    want: Array
    usable: npt.NDArray[np.bool_]
    context: Context
    text: str
    values: Values

    @property
    def node(self) -> Node:
        """The part itself."""
        return self.tape.nodes[self.place]

    @cached_property
    def quoted(self) -> str:
        """The part as it was written."""
        return " ".join(self.text[self.node.start : self.node.end].split())

    @property
    def is_term(self) -> bool:
        """Whether it is a term of a sum, or the whole."""
        parent = self.tape.parents[self.place]
        return parent < 0 or self.tape.nodes[parent].kind == "sum"

    def is_alike(self, value: Array) -> bool:
        """Whether a value is what is needed, at all states."""
        scale = np.abs(value) + np.abs(self.want)
        return bool((np.abs(value - self.want) <= ALIKE * scale).all())

    @property
    def here(self) -> str:
        """The part as it was written; of a letter's definition or a rate, its name."""
        return self.quoted or self.node.name

    @property
    def where(self) -> str:
        """The term that the part stands in, in words."""
        place = self.place
        while place >= 0 and (
            self.tape.parents[place] >= 0
            and self.tape.nodes[self.tape.parents[place]].kind != "sum"
        ):
            place = self.tape.parents[place]
        node = self.tape.nodes[place]
        if place == self.place or node.end <= node.start:
            return ""
        return f"in '{' '.join(self.text[node.start : node.end].split())}' "
