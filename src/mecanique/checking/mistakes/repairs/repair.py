"""A change of one part that makes a formula right, with the facts about the part."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
import numpy.typing as npt

from mecanique.arrays import Array
from mecanique.checking.grammar.tape import Tape, Values
from mecanique.checking.grammar.tree import Node
from mecanique.checking.mistakes.context import Context

ALIKE = 1e-6
"""Two values in a state are equal if they differ by less than this part."""

SIMPLE = 60
"""Factors with a denominator up to this are written as fractions."""


@dataclass(frozen=True)
class Repair:
    """A change of one part that makes a formula right.

    Args:
        kind: kind of the mistake.
        text: the mistake in words.
        part: the part as it was written.
        weight: the smaller, the likelier.
    """

    kind: str
    text: str
    part: str
    weight: float


@dataclass(frozen=True, eq=False)
class Part:
    """A part of a formula, with its present and its needed values.

    Args:
        tape: the formula.
        place: index of the part on the tape.
        have: its present values.
        want: its needed values.
        usable: the states in which both are known.
        context: the likely intentions.
        text: the text of the formula.
        values: values of all parts.
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
        """Whether a value is the needed one, in all states."""
        scale = np.abs(value) + np.abs(self.want)
        return bool((np.abs(value - self.want) <= ALIKE * scale).all())

    @property
    def here(self) -> str:
        """The part as it was written; within a definition or a rate, its letter's name."""
        return self.quoted or self.node.name

    @property
    def where(self) -> str:
        """The term that contains the part, in words."""
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
