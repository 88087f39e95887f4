"""Find single changes of a submitted formula that make it right.

The value that each part needs is known in every state; a change is found if this is always the
value of the same simple expression: the part with the opposite sign, cos for sin, another letter.
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from mecanique.arrays import Array
from mecanique.checking.budget import spend
from mecanique.checking.grammar.tape import Tape, Values
from mecanique.checking.mistakes.context import Context
from mecanique.checking.mistakes.needed_values import needed_values
from mecanique.checking.mistakes.repairs.factors import (
    repair_circular,
    repair_letter,
    repair_number,
    repair_power,
    repair_sum,
)
from mecanique.checking.mistakes.repairs.repair import Part, Repair
from mecanique.checking.mistakes.repairs.terms import repair_term

_FEWEST = 6
"""Least number of states in which a part must have a value."""


def repairs(
    tape: Tape, values: Values, target: Array, context: Context, text: str
) -> Iterator[Repair]:
    """Yield the changes of single parts that make a formula right.

    Args:
        tape: the formula.
        values: values of its parts in the states.
        target: required values of the whole.
        context: the likely intentions.
        text: the text of the formula.
    """
    needed = needed_values(tape, values, target)
    finite = np.isfinite(values.whole)
    explained: set[int] = set()
    for k in range(len(tape.nodes) - 1, -1, -1):
        spend()
        parent = tape.parents[k]
        if parent in explained and tape.nodes[parent].kind in ("product", "quotient", "negative"):
            # its factors would need the same change
            explained.add(k)
            continue
        node = tape.nodes[k]
        if node.end <= node.start and node.kind != "letter":
            # within a definition or a rate only letters can be quoted
            continue
        want, have = needed[k], values.parts[k]
        usable = finite & np.isfinite(want)
        if usable.sum() < min(_FEWEST, len(finite)) or not usable.any():
            continue
        one = Part(
            tape=tape,
            place=k,
            have=have[usable],
            want=want[usable],
            usable=usable,
            context=context,
            text=text,
            values=values,
        )
        whole = list(_find(one))
        if any(repair.kind in ("sign", "extra", "factor", "inertia") for repair in whole):
            explained.add(k)
        yield from whole


def _find(part: Part) -> Iterator[Repair]:
    """Yield repairs of a part."""
    if part.is_term and part.tape.parents[part.place] >= 0:
        yield from repair_term(part)
    node = part.node
    if node.kind == "letter":
        yield from repair_letter(part)
    elif node.kind == "call" and node.name in ("sin", "cos"):
        yield from repair_circular(part)
    elif node.kind == "power":
        yield from repair_power(part)
    elif node.kind == "sum":
        yield from repair_sum(part)
    elif node.kind == "number":
        yield from repair_number(part)
