"""A row of the register: the statement of an equation in the chapter, and whether it holds."""

from __future__ import annotations

from dataclasses import asdict, dataclass
from typing import Any, final

import numpy as np

__all__ = ["Row", "agreement", "identity", "misprint"]

TOLERANCE = 1e-9
"""Largest relative residual of a numeric statement that holds."""


@final
@dataclass(frozen=True)
class Row:
    """One equation of the chapter.

    Args:
        number: as in the chapter; its place, for a displayed result without a number.
        states: what it states.
        how: what was compared with what.
        kind: "symbolic identity" or "numeric".
        holds: whether the equation holds as printed.
        residual: of a numeric check, relative; None for a symbolic one.
        right: the right form of a misprint.
        proof: why that is right.
        proven: whether the right form holds.
    """

    number: str
    states: str
    how: str
    kind: str
    holds: bool
    residual: float | None = None
    right: str = ""
    proof: str = ""
    proven: bool = True

    @property
    def sound(self) -> bool:
        """Whether it holds as printed, or its right form is proven."""
        return self.holds or (bool(self.right) and self.proven)

    @property
    def place(self) -> tuple[int, str]:
        """Place of a numbered equation in the chapter: "1.14" comes before "1.14 a"."""
        number, _, letter = self.number.removeprefix("1.").partition(" ")
        return (int(number), letter) if number.isdigit() else (0, "")

    def to_dict(self) -> dict[str, Any]:
        """Return everything as plain data, ready for JSON."""
        return {**asdict(self), "sound": self.sound}

    def __str__(self) -> str:
        verdict = "holds" if self.holds else "DOES NOT HOLD AS PRINTED"
        if not self.sound:
            verdict = "IS NOT PROVEN"
        size = "" if self.residual is None else f", residual {self.residual:.1e}"
        lines = [f"{self.number:<9} {self.states}", f"{verdict}: {self.kind}{size}; {self.how}"]
        if self.right:
            lines += [f"right: {self.right}", f"proof: {self.proof}"]
        return f"\n{'':10}".join(lines)


def identity(number: str, states: str, how: str, *differences: Any) -> Row:
    """Return the row of an equation whose left minus right sides vanish identically."""
    holds = bool(differences) and all(map(_vanishes, differences))
    return Row(number, states, how, "symbolic identity", holds)


def agreement(number: str, states: str, how: str, *pairs: tuple[Any, Any]) -> Row:
    """Return the row of an equation whose sides are equal numbers, pair by pair."""
    worst = 0.0
    for left, right in pairs:
        a, b = np.asarray(left, dtype=float), np.asarray(right, dtype=float)
        size = max(float(np.abs(a).max()), float(np.abs(b).max()), 1e-300)
        worst = max(worst, float(np.abs(a - b).max()) / size)
    return Row(number, states, how, "numeric", worst <= TOLERANCE, worst)


def misprint(
    number: str, states: str, how: str, printed: Any, corrected: Any, *, right: str, proof: str
) -> Row:
    """Return the row of an equation that may be in error as printed.

    Args:
        number: as in the chapter.
        states: what is printed.
        how: what was compared with what.
        printed: left sides minus right sides as printed.
        corrected: the same in the right form.
        right: the right form.
        proof: why it is right.
    """
    row = identity(number, states, how, *printed)
    if row.holds:
        return row
    proven = all(map(_vanishes, corrected))
    return Row(number, states, how, row.kind, False, None, right, proof, proven)


def _vanishes(difference: Any) -> bool:
    """Return whether a series or a sympy expression is identically zero."""
    if hasattr(difference, "vanishes"):
        return bool(difference.vanishes())
    from sympy import simplify

    return bool(simplify(difference) == 0)
