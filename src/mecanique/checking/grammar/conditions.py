"""Conditions on parameters, as in "stable if W^2 < g/R"."""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import dataclass
from itertools import pairwise
from typing import final

import numpy as np
import numpy.typing as npt

from mecanique.arrays import Array
from mecanique.checking.grammar.tape import FormulaTape
from mecanique.checking.grammar.tree import Node

IF = r"(?:if|when|for|provided(?: that)?|where|with|falls|wenn|für|mit|si|pour|avec|para|con)\b"
"""Words before a condition."""

_RELATION = re.compile(r"(?<![-=])>=?|<=?|[≥⩾≤⩽]|\\(?P<way>[lg])(?:t|eq?|eqslant)(?![a-z])")
# up to the end of a clause; a point or a comma may belong to a number
_CLAUSE = (
    r"(?:(?!\b(?:and|or|und|oder|et|ou|also|auch|aussi|otherwise|else|sonst|sinon|then|dann|alors)\b)"
    r"(?:[^\n;:=().,]|[.,](?=\d)|\([^()\n]*\)))*"
)
_RELATED = re.sub(r"\?P<way>", "?:", _RELATION.pattern)
_SIDE = r"(?:[^()=\n<>≤≥]|\([^()\n]*\)){1,60}"
CONDITION = re.compile(
    rf"(?<![ ,;])[ ,;]*(?:\\(?:text|mathrm|mbox)\s?\{{\s?)?\b(?:(?:only|nur) )?{IF}(?:\s?\}})?"
    rf"(?P<said>(?:[^=\n;:<>≤≥()]|\([^()\n]*\)){{0,99}}?(?:{_RELATED}){_CLAUSE})"
    rf"|\((?![^()\n]{{0,60}}\b{IF})(?P<alone>{_SIDE}(?:{_RELATED}){_SIDE})\)",
    re.IGNORECASE,
)
"""A condition after one of these words, or alone in brackets."""


STABLE = r"(?<![A-Za-z])(?:un|in|not |nicht )?stab(?:le|il)(?![a-z])|(?<![A-Za-z])labil(?![a-z])"
"""What is said of stability; a word that does not begin with "stab" denies it."""


@final
@dataclass(frozen=True)
class ParameterCondition:
    """What must hold for parameters."""

    said: str  # as it was written
    start: int  # its position in the text
    falling: tuple[Node, ...]  # formulas, each of which is larger than the next

    def holds(self, values: Mapping[str, Array], count: int) -> npt.NDArray[np.bool_]:
        """Return in which of the states it holds, shape (n,)."""
        sizes = [FormulaTape(node).evaluate(values, count).whole for node in self.falling]
        larger = [first > second for first, second in pairwise(sizes)]
        return np.asarray(np.logical_and.reduce(larger))


def split_relation(said: str) -> list[str] | None:
    """Return the sides of a relation, the largest first; None if its signs differ."""
    signs = [*_RELATION.finditer(said)]
    edges = [0, *(edge for sign in signs for edge in sign.span()), len(said)]
    sides = [said[start:end] for start, end in zip(edges[::2], edges[1::2], strict=True)]
    falls = {sign[0][0] in ">≥⩾" or sign["way"] == "g" for sign in signs}
    if len(falls) != 1:
        return None
    return sides if falls.pop() else sides[::-1]
