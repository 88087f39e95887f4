"""A row of the register: an equation or a sentence of the chapter, and whether it holds."""

from __future__ import annotations

from dataclasses import asdict, dataclass
from typing import Any, final

import numpy as np

STATEMENT_HOLDS = 1e-9
"""Largest relative residual of a numeric statement that holds."""


@final
@dataclass(frozen=True)
class ChapterRow:
    """One equation of the chapter, or what one of its sentences states."""

    number: str  # as in the chapter; its place, for what has no number
    states: str  # what it states
    how: str  # what was compared with what
    # "symbolic identity", "numeric", "computed" (a count, or whether a letter appears), "read"
    # (of wording, which no computation judges) or "not checked"
    kind: str
    holds: bool | None  # whether it holds as printed; None if that is not checked
    residual: float | None = None  # of a numeric check, relative; None for a symbolic one
    right: str = ""  # the right form of a misprint
    proof: str = ""  # why that is right
    proven: bool = True  # whether the right form holds
    about: str = "equation"  # "equation" or "sentence"

    @property
    def sound(self) -> bool:
        """Whether it is not wrong as printed, or its right form is proven."""
        return self.holds is not False or (bool(self.right) and self.proven)

    @property
    def place(self) -> tuple[int, str]:
        """Place of a numbered equation in the chapter: "1.14" comes before "1.14 a"."""
        number, _, letter = self.number.removeprefix("1.").partition(" ")
        return (int(number), letter) if number.isdigit() else (0, "")

    def to_dict(self) -> dict[str, Any]:
        """Return everything as plain data, ready for JSON."""
        return {**asdict(self), "sound": self.sound}

    def __str__(self) -> str:
        if self.holds is None:
            return f"\n{'':10}".join(
                (f"{self.number:<9} {self.states}", f"not checked: {self.how}")
            )
        verdict = "holds" if self.holds else "DOES NOT HOLD AS PRINTED"
        if not self.sound:
            verdict = "IS NOT PROVEN"
        size = "" if self.residual is None else f", residual {self.residual:.1e}"
        lines = [f"{self.number:<9} {self.states}", f"{verdict}: {self.kind}{size}; {self.how}"]
        if self.right:
            lines += [f"right: {self.right}", f"proof: {self.proof}"]
        return f"\n{'':10}".join(lines)


def identity(number: str, states: str, how: str, *differences: Any) -> ChapterRow:
    """Return the row of an equation whose left minus right sides vanish identically."""
    holds = bool(differences) and all(map(_vanishes, differences))
    return ChapterRow(number, states, how, "symbolic identity", holds)


def agreement(number: str, states: str, how: str, *pairs: tuple[Any, Any]) -> ChapterRow:
    """Return the row of an equation whose sides are equal numbers, pair by pair."""
    worst = 0.0
    for left, right in pairs:
        a, b = np.asarray(left, dtype=float), np.asarray(right, dtype=float)
        size = max(float(np.abs(a).max()), float(np.abs(b).max()), 1e-300)
        worst = max(worst, float(np.abs(a - b).max()) / size)
    return ChapterRow(number, states, how, "numeric", worst <= STATEMENT_HOLDS, worst)


def decision(number: str, states: str, how: str, *facts: bool) -> ChapterRow:
    """Return the row of a statement that a count, or the letters of a result, decide."""
    return ChapterRow(number, states, how, "computed", bool(facts) and all(facts))


def misread(number: str, states: str, *, right: str, proof: str) -> ChapterRow:
    """Return the row of a sentence whose wording is at fault: read, not computed."""
    return ChapterRow(
        number=number,
        states=states,
        how="the sentence itself",
        kind="read",
        holds=False,
        residual=None,
        right=right,
        proof=proof,
    )


def open_point(number: str, states: str, why: str) -> ChapterRow:
    """Return the row of what is not checked."""
    return ChapterRow(number, states, why, "not checked", None)


def misprint(
    number: str, states: str, how: str, printed: Any, corrected: Any, *, right: str, proof: str
) -> ChapterRow:
    """Return the row of an equation that may be in error as printed."""
    row = identity(number, states, how, *printed)
    if row.holds:
        return row
    proven = all(map(_vanishes, corrected))
    return ChapterRow(
        number=number,
        states=states,
        how=how,
        kind=row.kind,
        holds=False,
        residual=None,
        right=right,
        proof=proof,
        proven=proven,
    )


def _vanishes(difference: Any) -> bool:
    """Return whether a series or a sympy expression is identically zero."""
    if hasattr(difference, "vanishes"):
        return bool(difference.vanishes())
    from sympy import numer, simplify, sympify, together

    # multiplying out shows most of them in a tenth of the time
    if numer(together(sympify(difference))).expand() == 0:
        return True
    return bool(simplify(difference) == 0)
