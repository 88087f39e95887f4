"""A row of the register, and how it is found."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import asdict, dataclass
from typing import Any, final

import numpy as np

__all__ = ["Check", "Finding", "Row", "compared", "corrected", "identical", "vanishing"]

TOLERANCE = 1e-9
"""Largest relative residual with which a numeric statement holds."""


@final
@dataclass(frozen=True)
class Finding:
    """What a check found.

    Args:
        how: what was compared with what.
        kind: "symbolic identity" or "numeric".
        holds: whether the equation holds as printed.
        residual: of a numeric check, relative; None for a symbolic one.
        right: the right form, where the print is in error.
        proof: why that is right.
        proven: whether the right form was found to hold.
    """

    how: str
    kind: str
    holds: bool
    residual: float | None = None
    right: str = ""
    proof: str = ""
    proven: bool = True


@final
@dataclass(frozen=True)
class Row:
    """One equation of the chapter.

    Args:
        number: as in the chapter; of a displayed result without a number, where it stands.
        states: what it states.
        finding: what a check found.
    """

    number: str
    states: str
    finding: Finding

    @property
    def sound(self) -> bool:
        """Whether it holds as printed, or the right form was found and proven."""
        return self.finding.holds or (bool(self.finding.right) and self.finding.proven)

    def to_dict(self) -> dict[str, Any]:
        """Return everything as plain data, ready for JSON."""
        return {
            "number": self.number,
            "states": self.states,
            **asdict(self.finding),
            "sound": self.sound,
        }

    def __str__(self) -> str:
        found = self.finding
        verdict = (
            "holds"
            if found.holds
            else "DOES NOT HOLD AS PRINTED"
            if self.sound
            else "NOT FOUND TO HOLD"
        )
        size = "" if found.residual is None else f", residual {found.residual:.1e}"
        lines = [
            f"{self.number:<9} {self.states}",
            f"{'':9} {verdict}: {found.kind}{size}; {found.how}",
        ]
        if found.right:
            lines += [f"{'':9} right: {found.right}", f"{'':9} proof: {found.proof}"]
        return "\n".join(lines)


@final
@dataclass(frozen=True)
class Check:
    """How a row is computed.

    Args:
        number: as in the chapter.
        states: what the equation states.
        check: finds out.
    """

    number: str
    states: str
    check: Callable[[], Finding]

    @property
    def order(self) -> tuple[int, str]:
        """Place of a numbered equation in the chapter: a section comes first, "1.14" before "1.14 a"."""
        number, _, letter = self.number.removeprefix("1.").partition(" ")
        return (int(number), letter) if number.isdigit() else (0, "")

    def row(self) -> Row:
        """Return the row, computed now."""
        return Row(self.number, self.states, self.check())


def vanishing(difference: Any) -> bool:
    """Return whether an expression, a series or each of several is identically zero.

    Args:
        difference: a sympy expression, a series, or a sequence of these.
    """
    if isinstance(difference, (list, tuple)):
        return all(vanishing(part) for part in difference)
    if hasattr(difference, "vanishes"):
        return bool(difference.vanishes())
    from sympy import simplify

    return bool(simplify(difference) == 0)


def identical(difference: Any, how: str) -> Finding:
    """Return the finding that sides are equal identically.

    Args:
        difference: left side minus right side, or several of these.
        how: what was compared with what.
    """
    return Finding(how, "symbolic identity", vanishing(difference))


def corrected(printed: Any, mended: Any, how: str, right: str, proof: str) -> Finding:
    """Return the finding for a print that may be in error.

    Args:
        printed: left minus right side as printed, or several of these.
        mended: the same in the right form.
        how: what was compared with what.
        right: the right form.
        proof: why it is right.
    """
    if vanishing(printed):
        return Finding(how, "symbolic identity", True)
    return Finding(
        how, "symbolic identity", False, right=right, proof=proof, proven=vanishing(mended)
    )


def compared(pairs: list[tuple[Any, Any]], how: str) -> Finding:
    """Return the finding that numbers are equal, each pair relative to its own size.

    Args:
        pairs: arrays of both sides.
        how: what was compared with what.
    """
    worst = 0.0
    for left, right in pairs:
        a, b = np.asarray(left, dtype=float), np.asarray(right, dtype=float)
        size = max(float(np.abs(a).max()), float(np.abs(b).max()), 1e-300)
        worst = max(worst, float(np.abs(a - b).max()) / size)
    return Finding(how, "numeric", worst <= TOLERANCE, worst)
