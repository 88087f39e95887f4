"""The outcome of a check: right or not, how far off, where, and why."""

from __future__ import annotations

import json
import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any, Literal, TypeAlias, final

from mecanique.wording import Legible, say_count

Outcome: TypeAlias = Literal["right", "right except for form", "incomplete", "wrong"]
"""The outcome of a check."""

_SHOWN = 3
"""Largest number of causes printed for a line."""


@final
@dataclass(frozen=True, repr=False)
class Mistake(Legible):
    """A mistake that explains a wrong formula, a `Cause`: mended, the formula is right."""

    kind: str  # kind of the mistake, e.g. "sign"
    text: str  # the mistake in words
    part: str = ""  # the part of the formula, as it was written; empty if it is missing
    weight: float = field(default=0.0, compare=False)  # the smaller, the likelier
    equation: int = 0  # number of the equation, from 1; 0 for all

    @property
    def where(self) -> str:
        """The part of the formula, as of any `Cause`."""
        return self.part

    def to_dict(self) -> dict[str, Any]:
        """Return what is known to others as plain data."""
        return {
            "kind": self.kind,
            "text": self.text,
            "part": self.part,
            "equation": self.equation,
        }

    def __str__(self) -> str:
        return self.text


@final
@dataclass(frozen=True)
class Line:
    """The verdict on one submitted equation or formula."""

    text: str  # the line as it was written
    outcome: Outcome  # whether it is right
    worst: float  # the largest difference relative to the size of its terms
    forms: tuple[str, ...] = ()  # deviations of a right one from the requested form
    # possible causes of a wrong one, the likeliest first; several may give the same formula
    causes: tuple[Mistake, ...] = ()

    def to_dict(self) -> dict[str, Any]:
        """Return everything as plain data."""
        return {
            "text": self.text,
            "outcome": self.outcome,
            "worst": self.worst if math.isfinite(self.worst) else None,
            "forms": list(self.forms),
            "causes": [cause.to_dict() for cause in self.causes],
        }


@final
@dataclass(frozen=True, repr=False)
class Check(Legible):
    """The verdict on a submitted formula: whether it is right, and if not, why not.

    Args:
        mechanism: name of the mechanism.
        asked: the quantity in question, e.g. "equation of motion".
        outcome: the verdict on the whole.
        lines: the verdict on each equation.
        states: number of random states at which it was compared.
        varied: whether the parameters differed from state to state.
        exact: whether equality was also proven by algebra.
        forms: deviations of a right answer from the requested form.
        causes: possible causes of a wrong answer, the likeliest first.
        at: the state with the largest difference, by letter.
        independent: how many of its right equations or values are independent of each other.
        needed: how many independent ones a whole answer has.
        notes: how the text was read where that is not plain: words set aside, letters that it
            defines, decimal commas.

    Example:
        >>> answer = mq.check(mq.textbook.load("simple_pendulum"), "q'' - g/l sin q = 0")
        >>> answer.right
        False
        >>> print(answer.causes[0])
        the sign of the potential of gravity is wrong
    """

    mechanism: str
    asked: str
    outcome: Outcome
    lines: tuple[Line, ...]
    states: int
    varied: bool = True
    exact: bool = False
    forms: tuple[str, ...] = ()
    causes: tuple[Mistake, ...] = ()
    at: Mapping[str, float] | None = None
    independent: int = 0
    notes: tuple[str, ...] = ()
    needed: int = 1

    @property
    def right(self) -> bool:
        """Whether it is right and in the requested form."""
        return self.outcome == "right"

    @property
    def form(self) -> str:
        """The deviations of a right answer from the requested form; empty if there are none."""
        return "; ".join(self.forms)

    @property
    def worst(self) -> float:
        """The largest difference relative to the size of the terms."""
        return max((line.worst for line in self.lines), default=0.0)

    def to_json(self) -> str:
        """Return everything as JSON text."""
        return json.dumps(self.to_dict(), ensure_ascii=False, allow_nan=False, indent=2)

    def to_dict(self) -> dict[str, Any]:
        """Return everything as plain data, ready for JSON."""
        return {
            "mechanism": self.mechanism,
            "asked": self.asked,
            "outcome": self.outcome,
            "right": self.right,
            "worst": self.worst if math.isfinite(self.worst) else None,
            "states": self.states,
            "varied": self.varied,
            "exact": self.exact,
            "forms": list(self.forms),
            "causes": [cause.to_dict() for cause in self.causes],
            "lines": [line.to_dict() for line in self.lines],
            "at": dict(self.at) if self.at else None,
            "independent": self.independent,
            "needed": self.needed,
            "notes": list(self.notes),
        }

    @property
    def summary(self) -> str:
        """The verdict in one sentence."""
        where = say_count(self.states, "random state")
        if self.varied:
            where += " with random parameters"
        proof = "; proven by algebra" if self.exact else ""
        size = f"worst relative difference {self.worst:.1e}"
        return f"{self.mechanism}, {self.asked}: {self.outcome.upper()} ({where}, {size}{proof})"

    def __str__(self) -> str:
        out = [self.summary]
        several = len(self.lines) > 1
        for number, line in enumerate(self.lines, 1):
            if several:
                out.append(f"  {number}. {line.outcome}: {line.text}")
        out += [f"  form: {form}" for form in self.forms]
        out += [f"  note: {note}" for note in self.notes]
        out += self._list_causes()
        if self.at:
            state = ", ".join(f"{name} = {value:.4g}" for name, value in self.at.items())
            out.append(f"  largest difference at {state}")
        return "\n".join(out)

    def _list_causes(self) -> list[str]:
        """The likeliest cause for each equation, and others that give the very same formula."""
        out: list[str] = []
        reported: set[Mistake] = set()
        for line in self.lines:
            new = [cause for cause in line.causes[:_SHOWN] if cause not in reported]
            reported.update(new)
            for cause in new:
                # mismatched units are reported first, and by themselves
                alike = cause is not new[0] and new[0].kind != "units"
                others = "or, which gives the same formula" if alike else "or"
                out.append(f"  {'likely cause' if cause is new[0] else others}: {cause}")
        return out
