"""Repair a term of a sum: its sign, a factor, a letter, its absence."""

from __future__ import annotations

from collections.abc import Iterator
from fractions import Fraction

import numpy as np

from mecanique.checking.mistakes.repairs.repair import ALIKE, SIMPLE, Part, Repair

_INERTIAS = {Fraction(4), Fraction(1, 4), Fraction(3), Fraction(1, 3), Fraction(12)}


def repair_term(part: Part) -> Iterator[Repair]:
    """Yield repairs of a term: a number, a letter, a function; or its absence."""
    with np.errstate(all="ignore"):
        ratio = part.want / part.have
    if not np.isfinite(ratio).all():
        return
    size = part.values.sizes[part.tape.parents[part.place]][part.usable]
    if (np.abs(part.want) <= 1e-9 * size).all():
        text = f"the term '{part.quoted}' does not belong there"
        yield Repair("extra", text, part.quoted, 2.2)
        return
    mean = float(ratio.mean())
    if float(np.ptp(ratio)) <= ALIKE * abs(mean):
        yield from _scale(part, mean)
        return
    rows = part.context.ratios[:, part.usable]
    alike = (np.abs(rows - ratio) <= ALIKE * (np.abs(rows) + np.abs(ratio))).all(axis=1)
    alike |= (np.abs(rows + ratio) <= ALIKE * (np.abs(rows) + np.abs(ratio))).all(axis=1)
    names = list(part.context.factors)
    for place in np.flatnonzero(alike):
        name = names[place % len(names)]
        kind = part.context.factors[name][0]
        if kind == "sin for cos":
            formula = name[3:].removesuffix("^2")
            pair = ("sin", "cos") if place < len(names) else ("cos", "sin")
            text = f"in the term '{part.quoted}' {pair[1]}{formula} should be {pair[0]}{formula}"
            yield Repair(kind, text, part.quoted, 1.7)
        elif kind == "letter":
            pair = name.split("/") if place < len(names) else name.split("/")[::-1]
            text = f"in the term '{part.quoted}' {pair[1]} should be {pair[0]}"
            yield Repair(kind, text, part.quoted, 1.7)
        elif place >= len(names):
            text = f"the factor {name} does not belong in the term '{part.quoted}'"
            yield Repair("factor surplus", text, part.quoted, 2.0)
        elif kind == "small angle":
            text = (
                f"the term '{part.quoted}' lacks the factor {name}: the angle is assumed to be "
                "small"
            )
            yield Repair(kind, text, part.quoted, 1.8)
        else:
            text = f"the term '{part.quoted}' lacks the factor {name}"
            yield Repair(kind, text, part.quoted, 2.0)


def _scale(part: Part, ratio: float) -> Iterator[Repair]:
    found = Fraction(ratio).limit_denominator(SIMPLE)
    close = found != 0 and abs(ratio / float(found) - 1) < ALIKE
    if found == -1 and close:
        text = f"the sign of the term '{part.quoted}' is wrong"
        yield Repair("sign", text, part.quoted, 1.0)
    elif close and found in _INERTIAS and _is_inertial(part):
        text = (
            f"the term '{part.quoted}' should be {found} times as large: the inertia may be "
            "taken about the wrong point (center or pin) or of the wrong body"
        )
        yield Repair("inertia", text, part.quoted, 1.5)
    elif close and found > 0:
        text = {
            Fraction(2): f"the term '{part.quoted}' is half of what it should be",
            Fraction(1, 2): f"the term '{part.quoted}' is twice what it should be",
        }.get(found, f"the term '{part.quoted}' should be {found} times as large")
        yield Repair("factor", text, part.quoted, 1.4)
    elif close:
        text = f"the term '{part.quoted}' should be multiplied by {found}"
        yield Repair("factor", text, part.quoted, 2.4)
    else:
        text = f"the term '{part.quoted}' should be {ratio:.6g} times as large"
        yield Repair("factor", text, part.quoted, 2.6)


def _is_inertial(part: Part) -> bool:
    return bool(part.node.letters & set(part.context.accelerations))
